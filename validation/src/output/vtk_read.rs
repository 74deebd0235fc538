//! Reading VTK's XML files: those that runs write, of today and of earlier versions, and what other codes write as polygonal data or as an
//! unstructured grid: appended as it is or in base64, in place as base64 or as words, compressed by zlib or not.

use super::vtk::{Array, Cells, Kind, PolyData};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::{Decompress, FlushDecompress, Status};
use roxmltree::{Document, Node};

/// What VTK calls an unstructured grid.
const GRID: &str = "UnstructuredGrid";

/// Where what is appended begins.
const APPENDED: &[u8] = b"<AppendedData";

/// More than zlib ever gains: who claims more lies.
const BEST_COMPRESSION: usize = 1100;

/// What holds the arrays of a document.
struct Source<'a> {
    appended: &'a [u8],
    /// Whether what is appended is text.
    in_base64: bool,
    compressed: bool,
    /// Bytes of the integers in front of an array.
    header: usize,
}

/// The polygonal data in the bytes of a file.
///
/// # Errors
/// What is wrong with them.
pub(crate) fn decode(bytes: &[u8]) -> Result<PolyData, String> {
    let Outline { time, points, cells, topology, corners, mut sections } = outline(bytes, &|_| true)?;
    let time = time.ok_or("it has no time")?;
    let mut take = |name: &str| match sections.iter().position(|(of, _)| *of == name) {
        None => Vec::new(),
        Some(place) => std::mem::take(&mut sections[place].1),
    };
    let coordinates = take("Points").pop().ok_or("it has no points")?;
    if coordinates.components != 3 {
        return Err("its points have no three coordinates".into());
    }
    let cells = match topology {
        "Verts" if cells == points => Cells::Vertices,
        "Lines" if corners * cells == points => Cells::Lines,
        "Polys" => {
            let corners = take("Polys").into_iter().find(|array| array.name == "connectivity");
            Cells::Triangles(triangles(&corners.ok_or("its polygons have no corners")?, points)?)
        }
        _ => return Err("its cells are not those of a run".into()),
    };
    let (field_data, texts) = fields(bytes)?;
    Ok(PolyData {
        time,
        point_data: take("PointData"),
        cell_data: take("CellData"),
        points: coordinates,
        cells,
        field_data,
        texts,
    })
}

/// What a file holds, as far as it was asked for.
#[derive(Debug)]
pub(crate) struct Outline {
    /// Simulated time, s; none where the file does not tell it.
    pub time: Option<f64>,
    /// Number of points.
    pub points: usize,
    /// Number of cells.
    pub cells: usize,
    /// What VTK calls the cells.
    pub topology: &'static str,
    /// Points of a cell.
    pub corners: usize,
    /// Arrays by their sections.
    pub sections: Vec<(&'static str, Vec<Array>)>,
}

/// Counts, and the arrays whose names are wanted.
///
/// # Errors
/// What is wrong with the bytes.
pub(crate) fn outline(bytes: &[u8], wanted: &dyn Fn(&str) -> bool) -> Result<Outline, String> {
    let (text, appended) = split(bytes)?;
    let document = Document::parse(&text).map_err(|error| format!("it is no XML document: {error}"))?;
    let (root, source) = root(&document, appended)?;
    let holds = |piece: &Node<'_, '_>| piece.attribute("NumberOfPoints").is_some_and(|points| points.trim() != "0");
    let pieces = || root.descendants().filter(|node| node.has_tag_name("Piece"));
    let piece = pieces().find(holds).or_else(|| pieces().next()).ok_or("it has no piece")?;
    if pieces().filter(holds).count() > 1 {
        return Err(
            "it has several pieces; write one piece a file (in ParaView: filter Merge Blocks, or Append Geometry)"
                .into(),
        );
    }
    let count = |name: &str| match piece.attribute(name).unwrap_or("0").parse::<usize>() {
        Ok(count) if count <= i32::MAX as usize => Ok(count),
        _ => Err(format!("{name} is no number of points or cells")),
    };
    let points = count("NumberOfPoints")?;
    let kinds = [("Verts", 1), ("Lines", 2), ("Polys", 3)];
    let some = |(name, _): &(&str, usize)| count(&format!("NumberOf{name}")).is_ok_and(|cells| cells > 0);
    let (topology, corners) = kinds.into_iter().find(some).unwrap_or(("Verts", 1));
    let cells = match root.attribute("type") {
        Some(GRID) => count("NumberOfCells")?,
        _ => count(&format!("NumberOf{topology}"))?,
    };
    let mut sections = Vec::new();
    for (name, tuples) in [("Points", points), ("PointData", points), ("CellData", cells), ("Polys", corners * cells)] {
        // Offsets of polygons have another number of tuples, and say nothing of triangles.
        let is_wanted = |array: &str| wanted(array) && (name != "Polys" || array == "connectivity");
        sections.push((name, section(&source, piece, name, tuples, &is_wanted)?));
    }
    let time = named(root, "FieldData").into_iter().flat_map(|fields| fields.children());
    let time = time.into_iter().find(|node| node.attribute("Name") == Some("TimeValue"));
    let time = time.map(|node| array(&source, node, 1)).transpose()?.and_then(|array| array.values().first().copied());
    let time = time.filter(|time| time.is_finite());
    Ok(Outline { time, points, cells, topology, corners, sections })
}

/// A document, with what is appended to it cut off.
fn split(bytes: &[u8]) -> Result<(String, &[u8]), String> {
    let (head, appended) = match bytes.windows(APPENDED.len()).position(|window| window == APPENDED) {
        None => (bytes, &[][..]),
        Some(place) => {
            let rest = &bytes[place..];
            // The mark comes behind the attributes, which may have marks in their names.
            let open = rest.iter().position(|byte| *byte == b'>').ok_or("nothing stands behind the document")?;
            let start =
                rest[open..].iter().position(|byte| *byte == b'_').ok_or("nothing stands behind the document")?;
            (&bytes[..place + open + 1], &rest[open + start + 1..])
        }
    };
    let mut text = String::from_utf8(head.to_vec()).map_err(|_| "it is no text".to_string())?;
    if head.len() < bytes.len() {
        text += "</AppendedData></VTKFile>";
    }
    Ok((text, appended))
}

fn root<'a, 'input>(
    document: &'a Document<'input>,
    appended: &'a [u8],
) -> Result<(Node<'a, 'input>, Source<'a>), String> {
    let root = document.root_element();
    if !matches!(root.attribute("type"), Some("PolyData" | GRID)) {
        return Err("it holds no polygonal data, and no unstructured grid".into());
    }
    if root.attribute("byte_order") == Some("BigEndian") {
        return Err("its numbers are in big endian".into());
    }
    let compressed = match root.attribute("compressor") {
        None => false,
        Some("vtkZLibDataCompressor") => true,
        Some(other) => return Err(format!("it is compressed by {other}; only zlib is read")),
    };
    let header = if root.attribute("header_type") == Some("UInt64") { 8 } else { 4 };
    let section = document.descendants().find(|node| node.has_tag_name("AppendedData"));
    let in_base64 = section.is_some_and(|node| node.attribute("encoding") == Some("base64"));
    Ok((root, Source { appended, in_base64, compressed, header }))
}

/// Named texts.
type Texts = Vec<(String, Vec<String>)>;

/// Arrays of numbers of the whole file whose names are wanted.
///
/// # Errors
/// What is wrong with the bytes.
pub(crate) fn field_arrays(bytes: &[u8], wanted: &[&str]) -> Result<Vec<Array>, String> {
    let (text, appended) = split(bytes)?;
    let document = Document::parse(&text).map_err(|error| error.to_string())?;
    let (root, source) = root(&document, appended)?;
    let nodes = named(root, "FieldData").into_iter().flat_map(|fields| fields.children());
    let is_wanted = |node: &Node<'_, '_>| {
        node.has_tag_name("DataArray") && node.attribute("Name").is_some_and(|name| wanted.contains(&name))
    };
    nodes.filter(is_wanted).map(|node| array(&source, node, tuples_of_field(node)?)).collect()
}

/// Number of tuples of an array of the whole file.
fn tuples_of_field(node: Node<'_, '_>) -> Result<usize, String> {
    let tuples = node.attribute("NumberOfTuples").unwrap_or("1").parse::<usize>();
    tuples.ok().filter(|tuples| *tuples <= i32::MAX as usize).ok_or("a field has no number of tuples".to_string())
}

/// Arrays and texts of the whole file but for its time.
fn fields(bytes: &[u8]) -> Result<(Vec<Array>, Texts), String> {
    let (text, appended) = split(bytes)?;
    let document = Document::parse(&text).map_err(|error| error.to_string())?;
    let (root, source) = root(&document, appended)?;
    let (mut arrays, mut texts) = (Vec::new(), Vec::new());
    for node in named(root, "FieldData").into_iter().flat_map(|fields| fields.children()) {
        match node.tag_name().name() {
            "DataArray" if node.attribute("Name") != Some("TimeValue") => {
                arrays.push(array(&source, node, tuples_of_field(node)?)?)
            }
            "Array" => texts.push((node.attribute("Name").unwrap_or_default().to_string(), strings(node)?)),
            _ => {}
        }
    }
    Ok((arrays, texts))
}

fn named<'a, 'input>(node: Node<'a, 'input>, name: &str) -> Option<Node<'a, 'input>> {
    node.descendants().find(|node| node.has_tag_name(name))
}

fn section(
    source: &Source<'_>,
    piece: Node<'_, '_>,
    name: &str,
    tuples: usize,
    wanted: &dyn Fn(&str) -> bool,
) -> Result<Vec<Array>, String> {
    let Some(section) = piece.children().find(|node| node.has_tag_name(name)) else { return Ok(Vec::new()) };
    let arrays = section.children().filter(|node| node.has_tag_name("DataArray"));
    arrays
        .filter(|node| wanted(node.attribute("Name").unwrap_or_default()))
        .map(|node| array(source, node, tuples))
        .collect()
}

fn triangles(corners: &Array, points: usize) -> Result<Vec<[u32; 3]>, String> {
    let corners = corners.values();
    if corners.iter().any(|corner| !(0.0..points as f64).contains(corner)) {
        return Err("a triangle has a corner that is no point".into());
    }
    Ok(corners.as_chunks::<3>().0.iter().map(|corners| corners.map(|corner| corner as u32)).collect())
}

fn strings(node: Node<'_, '_>) -> Result<Vec<String>, String> {
    let numbers = node.text().unwrap_or_default().split_ascii_whitespace();
    let bytes: Result<Vec<u8>, _> = numbers.map(str::parse).collect();
    let bytes = bytes.map_err(|_| "a text is no row of bytes".to_string())?;
    let texts = bytes.split_inclusive(|byte| *byte == 0);
    let text = |bytes: &[u8]| String::from_utf8(bytes[..bytes.len() - 1].to_vec());
    texts.map(text).collect::<Result<_, _>>().map_err(|_| "a text is not in UTF-8".to_string())
}

/// An array with that many tuples.
fn array(source: &Source<'_>, node: Node<'_, '_>, tuples: usize) -> Result<Array, String> {
    let attribute = |name: &str| node.attribute(name).unwrap_or_default();
    let name = attribute("Name").to_string();
    let wrong = |what: &str| format!("array {name}: {what}");
    let kind = Kind::ALL.into_iter().find(|kind| kind.name() == attribute("type"));
    let kind = kind.ok_or_else(|| wrong(&format!("numbers of type '{}' are not those of a run", attribute("type"))))?;
    let components = node.attribute("NumberOfComponents").unwrap_or("1").parse::<usize>();
    let components = components.ok().filter(|count| (1..=9).contains(count));
    let components = components.ok_or_else(|| wrong("it has no number of components"))?;
    let size = kind.size() * components * tuples;
    let bytes = match attribute("format") {
        "appended" => {
            let offset = attribute("offset").parse::<usize>().ok();
            let rest = offset.and_then(|offset| source.appended.get(offset..));
            let rest = rest.ok_or_else(|| wrong("it lies beyond the end of the file"))?;
            match source.in_base64 {
                true => from_base64(source, rest, size).and_then(|bytes| blocks(source, &bytes, size)),
                false => blocks(source, rest, size),
            }
        }
        "binary" => {
            let text = node.text().unwrap_or_default().trim();
            from_base64(source, text.as_bytes(), size).and_then(|bytes| blocks(source, &bytes, size))
        }
        "ascii" => in_words(kind, node.text().unwrap_or_default(), components * tuples),
        other => Err(format!("its format '{other}' is not that of a run")),
    };
    Ok(Array { bytes: bytes.map_err(|what| wrong(&what))?, name, components, kind })
}

fn cut() -> String {
    "the file ends within it".into()
}

/// An integer of `header` bytes in front of an array.
fn header_number(bytes: &[u8], header: usize, place: usize) -> Result<usize, String> {
    let own = bytes.get(header * place..header * (place + 1)).ok_or_else(cut)?;
    let mut eight = [0; 8];
    eight[..header].copy_from_slice(own);
    usize::try_from(u64::from_le_bytes(eight)).map_err(|_| cut())
}

/// The bytes of an array that begins a text in base64. Compressed ones have their header encoded by itself.
fn from_base64(source: &Source<'_>, text: &[u8], size: usize) -> Result<Vec<u8>, String> {
    let decoded = |start: usize, bytes: usize| {
        let letters = bytes.checked_add(2).map(|bytes| bytes / 3 * 4).ok_or_else(cut)?;
        let own = text.get(start..start.saturating_add(letters)).ok_or_else(cut)?;
        let decoded = STANDARD.decode(own).map_err(|error| format!("it is no base64: {error}"))?;
        Ok::<_, String>((decoded, start + letters))
    };
    let header = source.header;
    // Nine bytes and twelve letters are whole groups: enough for the first number of a header.
    let begin =
        STANDARD.decode(text.get(..12).ok_or_else(cut)?).map_err(|error| format!("it is no base64: {error}"))?;
    let count = header_number(&begin, header, 0)?;
    if !source.compressed {
        return match count == size {
            true => decoded(0, header + size).map(|(bytes, _)| bytes),
            false => Err(format!("it has {count} bytes in place of {size}")),
        };
    }
    if count > text.len() {
        return Err(cut());
    }
    let (mut bytes, start) = decoded(0, header * (3 + count))?;
    let mut packed = 0_usize;
    for block in 0..count {
        packed = packed.saturating_add(header_number(&bytes, header, 3 + block)?);
    }
    bytes.extend(decoded(start, packed)?.0);
    Ok(bytes)
}

/// The bytes of numbers that stand as words.
fn in_words(kind: Kind, text: &str, count: usize) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    let mut found = 0;
    for word in text.split_ascii_whitespace() {
        let number: f64 = word.parse().map_err(|_| format!("'{word}' is no number"))?;
        match kind {
            Kind::UInt8 => bytes.push(number as u8),
            Kind::Int32 => bytes.extend((number as i32).to_le_bytes()),
            Kind::Int64 => bytes.extend((number as i64).to_le_bytes()),
            Kind::Float32 => bytes.extend((number as f32).to_le_bytes()),
            Kind::Float64 => bytes.extend(number.to_le_bytes()),
        }
        found += 1;
    }
    match found == count {
        true => Ok(bytes),
        false => Err(format!("it has {found} numbers in place of {count}")),
    }
}

/// What an array of `size` bytes is made from: a size and bytes, or blocks of zlib behind the table of their sizes.
fn blocks(source: &Source<'_>, bytes: &[u8], size: usize) -> Result<Vec<u8>, String> {
    let header = source.header;
    let number = |place: usize| header_number(bytes, header, place);
    let other = |found: usize| format!("it has {found} bytes in place of {size}");
    if !source.compressed {
        let found = number(0)?;
        if found != size {
            return Err(other(found));
        }
        return bytes.get(header..header + size).map(<[u8]>::to_vec).ok_or_else(cut);
    }
    let (count, whole, last) = (number(0)?, number(1)?, number(2)?);
    let found = match (count, last) {
        (0, _) => 0,
        (count, 0) => count.saturating_mul(whole),
        (count, last) => (count - 1).saturating_mul(whole).saturating_add(last),
    };
    if found != size {
        return Err(other(found));
    }
    if size > bytes.len().saturating_mul(BEST_COMPRESSION) || count > bytes.len() {
        return Err(cut());
    }
    let mut start = header * (3 + count);
    let mut unpacked = Vec::with_capacity(size);
    for block in 0..count {
        let length = number(3 + block)?;
        let packed = bytes.get(start..start.saturating_add(length)).ok_or_else(cut)?;
        start += length;
        let wanted = if block + 1 == count && last > 0 { last } else { whole };
        let end = unpacked.len() + wanted;
        let status = Decompress::new(true).decompress_vec(packed, &mut unpacked, FlushDecompress::Finish);
        if !matches!(status, Ok(Status::StreamEnd)) || unpacked.len() != end {
            return Err("a block is damaged".into());
        }
    }
    Ok(unpacked)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A frame as versions before compression wrote it.
    fn uncompressed() -> String {
        let encode = |bytes: Vec<u8>| STANDARD.encode([&(bytes.len() as u64).to_le_bytes()[..], &bytes].concat());
        let radius = encode([0.5_f32, 0.25].iter().flat_map(|value| value.to_le_bytes()).collect());
        let points = encode((0..6).flat_map(|n| (n as f32).to_le_bytes()).collect());
        let time = encode(2.5_f64.to_le_bytes().to_vec());
        format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n\
             <PolyData>\n<FieldData>\n<DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"binary\">{time}\
             </DataArray>\n</FieldData>\n<Piece NumberOfPoints=\"2\" NumberOfVerts=\"2\" NumberOfLines=\"0\" NumberOfStrips=\"0\" \
             NumberOfPolys=\"0\">\n<PointData>\n<DataArray type=\"Float32\" Name=\"radius\" NumberOfComponents=\"1\" \
             format=\"binary\">{radius}</DataArray>\n</PointData>\n<Points>\n<DataArray type=\"Float32\" Name=\"Points\" \
             NumberOfComponents=\"3\" format=\"binary\">{points}</DataArray>\n</Points>\n</Piece>\n</PolyData>\n</VTKFile>\n"
        )
    }

    #[test]
    fn frames_of_earlier_versions_are_read() {
        let file = decode(uncompressed().as_bytes()).unwrap();
        assert_eq!((file.time, file.count()), (2.5, 2));
        assert_eq!(file.point_data[0].values(), [0.5, 0.25]);
        assert_eq!(file.points.values(), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
    }

    #[test]
    fn damaged_files_are_refused_with_a_reason() {
        let refused = |bytes: &[u8], reason: &str| {
            let error = decode(bytes).unwrap_err();
            assert!(error.contains(reason), "{error}");
        };
        let old = uncompressed();
        refused(b"", "no XML");
        refused(b"<VTKFile type=\"ImageData\"/>", "no polygonal data");
        refused(old.replace("NumberOfPoints=\"2\"", "NumberOfPoints=\"3\"").as_bytes(), "24 bytes in place of 36");
        refused(old.replace("TimeValue", "Time").as_bytes(), "no time");
        refused(old.replace("Float32", "Float16").as_bytes(), "Float16");
        let new = decode(old.as_bytes()).unwrap().encode(&mut crate::output::vtk::Packer::new());
        assert!(decode(&new).is_ok());
        // Whatever byte is lost or changed, there is an answer and no panic.
        for end in 0..new.len() {
            let _ = decode(&new[..end]);
        }
        for place in 0..new.len() {
            let mut changed = new.clone();
            changed[place] ^= 0x55;
            let _ = decode(&changed);
        }
        // The first stream is that of the time, a block of eight bytes that is stored behind two bytes, a mark and two lengths.
        let place = new.windows(2).position(|bytes| bytes == [0x78, 0x01]).unwrap();
        let mut changed = new.clone();
        changed[place + 8] ^= 0xff;
        refused(&changed, "damaged");
    }
}
