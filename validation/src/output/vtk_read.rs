//! Reading the VTK files that runs write, those of today and the uncompressed ones of earlier versions.

use super::vtk::{Array, Cells, Kind, PolyData};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::{Decompress, FlushDecompress, Status};
use roxmltree::{Document, Node};

/// Where what is appended begins.
const APPENDED: &[u8] = b"<AppendedData";

/// More than zlib ever gains: who claims more lies.
const BEST_COMPRESSION: usize = 1100;

/// What holds the arrays of a document.
struct Source<'a> {
    appended: &'a [u8],
    compressed: bool,
}

/// The polygonal data in the bytes of a file.
///
/// # Errors
/// What is wrong with them.
pub(crate) fn decode(bytes: &[u8]) -> Result<PolyData, String> {
    let (head, appended) = match bytes.windows(APPENDED.len()).position(|window| window == APPENDED) {
        None => (bytes, &[][..]),
        Some(place) => {
            let rest = &bytes[place..];
            let start = rest.iter().position(|byte| *byte == b'_').ok_or("nothing stands behind the document")?;
            (&bytes[..place], &rest[start + 1..])
        }
    };
    let mut text = String::from_utf8(head.to_vec()).map_err(|_| "it is no text".to_string())?;
    if head.len() < bytes.len() {
        text += "</VTKFile>";
    }
    let document = Document::parse(&text).map_err(|error| format!("it is no XML document: {error}"))?;
    let root = document.root_element();
    if root.attribute("type") != Some("PolyData") {
        return Err("it holds no polygonal data".into());
    }
    let source = Source { appended, compressed: root.attribute("compressor").is_some() };
    let piece = named(root, "Piece").ok_or("it has no piece")?;
    let count = |name: &str| match piece.attribute(name).unwrap_or("0").parse::<usize>() {
        Ok(count) if count <= i32::MAX as usize => Ok(count),
        _ => Err(format!("{name} is no number of points or cells")),
    };
    let points = count("NumberOfPoints")?;
    let coordinates = section(&source, piece, "Points", points)?.pop().ok_or("it has no points")?;
    if coordinates.components != 3 {
        return Err("its points have no three coordinates".into());
    }
    let kinds = [("Verts", 1), ("Lines", 2), ("Polys", 3)];
    let some = |(name, _): &(&str, usize)| count(&format!("NumberOf{name}")).is_ok_and(|cells| cells > 0);
    let (name, size) = kinds.into_iter().find(some).unwrap_or(("Verts", 1));
    let cells = count(&format!("NumberOf{name}"))?;
    let cells = match name {
        "Verts" if cells == points => Cells::Vertices,
        "Lines" if 2 * cells == points => Cells::Lines,
        "Polys" => Cells::Triangles(triangles(&source, piece, points, size * cells)?),
        _ => return Err("its cells are not those of a run".into()),
    };
    let mut field_data = Vec::new();
    let mut texts = Vec::new();
    for node in named(root, "FieldData").into_iter().flat_map(|fields| fields.children()) {
        let tuples = || {
            let tuples = node.attribute("NumberOfTuples").unwrap_or("1").parse::<usize>();
            tuples.map_err(|_| "a field has no number of tuples".to_string())
        };
        match node.tag_name().name() {
            "DataArray" => field_data.push(array(&source, node, tuples()?)?),
            "Array" => texts.push((node.attribute("Name").unwrap_or_default().to_string(), strings(node)?)),
            _ => {}
        }
    }
    let time = field_data.iter().position(|array| array.name == "TimeValue");
    let time = time.and_then(|place| field_data.remove(place).values().first().copied());
    let over_cells = cells.count(points);
    Ok(PolyData {
        time: time.filter(|time| time.is_finite()).ok_or("it has no time")?,
        point_data: section(&source, piece, "PointData", points)?,
        cell_data: section(&source, piece, "CellData", over_cells)?,
        points: coordinates,
        cells,
        field_data,
        texts,
    })
}

fn named<'a, 'input>(node: Node<'a, 'input>, name: &str) -> Option<Node<'a, 'input>> {
    node.descendants().find(|node| node.has_tag_name(name))
}

fn section(source: &Source<'_>, piece: Node<'_, '_>, name: &str, tuples: usize) -> Result<Vec<Array>, String> {
    let Some(section) = piece.children().find(|node| node.has_tag_name(name)) else { return Ok(Vec::new()) };
    section.children().filter(|node| node.has_tag_name("DataArray")).map(|node| array(source, node, tuples)).collect()
}

fn triangles(source: &Source<'_>, piece: Node<'_, '_>, points: usize, corners: usize) -> Result<Vec<[u32; 3]>, String> {
    let section = piece.children().find(|node| node.has_tag_name("Polys")).ok_or("it has no polygons")?;
    let node = section.children().find(|node| node.attribute("Name") == Some("connectivity"));
    let corners = array(source, node.ok_or("its polygons have no corners")?, corners)?.values();
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
            blocks(rest.ok_or_else(|| wrong("it lies beyond the end of the file"))?, source.compressed, size)
        }
        "binary" if !source.compressed => {
            let text = node.text().unwrap_or_default().trim();
            let bytes = STANDARD.decode(text).map_err(|error| wrong(&format!("it is no base64: {error}")))?;
            blocks(&bytes, false, size)
        }
        other => Err(format!("its format '{other}' is not that of a run")),
    };
    Ok(Array { bytes: bytes.map_err(|what| wrong(&what))?, name, components, kind })
}

/// What an array of `size` bytes is made from: a size and bytes, or blocks of zlib behind the table of their sizes.
fn blocks(bytes: &[u8], compressed: bool, size: usize) -> Result<Vec<u8>, String> {
    let cut = || "the file ends within it".to_string();
    let number = |place: usize| {
        let bytes = bytes.get(8 * place..8 * place + 8).ok_or_else(cut)?;
        let number = u64::from_le_bytes(bytes.try_into().expect("eight bytes"));
        usize::try_from(number).map_err(|_| cut())
    };
    let other = |found: usize| format!("it has {found} bytes in place of {size}");
    if !compressed {
        let found = number(0)?;
        if found != size {
            return Err(other(found));
        }
        return bytes.get(8..8 + size).map(<[u8]>::to_vec).ok_or_else(cut);
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
    let mut start = 24 + 8 * count;
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
        let new = decode(old.as_bytes()).unwrap().encode();
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
        let place = new.windows(2).rposition(|bytes| bytes == [0x78, 0x01]).unwrap();
        let mut changed = new.clone();
        changed[place + 4] ^= 0xff;
        refused(&changed, "damaged");
    }
}
