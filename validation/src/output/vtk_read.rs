//! Reading VTK's XML files: those that runs write, of today and of earlier versions, and what other codes write as polygonal data or as an
//! unstructured grid: appended as it is or in base64, in place as base64 or as words, compressed by zlib, by LZ4 or not, in either order
//! of bytes.

use super::vtk::{Array, Kind};
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
    compressor: Option<Compressor>,
    /// Bytes of the integers in front of an array.
    header: usize,
    /// True if numbers are in big endian.
    is_big: bool,
}

/// Ways to compress blocks.
#[derive(Clone, Copy, PartialEq)]
enum Compressor {
    Zlib,
    Lz4,
}

/// Section of the arrays of a whole file.
pub(crate) const FIELD_DATA: &str = "FieldData";

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
    /// Arrays by their sections.
    pub sections: Vec<(&'static str, Vec<Array>)>,
    /// Sections, names and components of arrays that were not wanted.
    pub unread: Vec<(&'static str, String, usize)>,
    /// True if the file names the scene of a run of Makadam, which numbers grains as its scene does.
    pub of_run: bool,
}

/// Counts, and the arrays whose sections and names are wanted.
///
/// # Errors
/// What is wrong with the bytes.
pub(crate) fn outline(bytes: &[u8], wanted: &dyn Fn(&str, &str) -> bool) -> Result<Outline, String> {
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
    let kinds = [("Verts", 1), ("Lines", 2), ("Polys", 3), ("Strips", 0)];
    let mut counts = [0; 4];
    for (cells, (name, _)) in counts.iter_mut().zip(kinds) {
        *cells = count(&format!("NumberOf{name}"))?;
    }
    let first = counts.iter().position(|cells| *cells > 0).unwrap_or(0);
    let (topology, corners) = kinds[first];
    // Arrays over cells run over those of all kinds.
    let cells = match root.attribute("type") {
        Some(GRID) => count("NumberOfCells")?,
        _ => counts.iter().sum(),
    };
    let (mut sections, mut unread) = (Vec::new(), Vec::new());
    let polygons = if topology == "Polys" { corners * cells } else { 0 };
    for (name, tuples) in [("Points", points), ("PointData", points), ("CellData", cells), ("Polys", polygons)] {
        let nodes = piece.children().find(|node| node.has_tag_name(name)).into_iter().flat_map(|node| node.children());
        let mut arrays = Vec::new();
        for node in nodes.filter(|node| node.has_tag_name("DataArray")) {
            let own = node.attribute("Name").unwrap_or_default();
            // Other cells than those of the file have other numbers of tuples, and so have offsets.
            let is_sized = name != "Polys" || (topology == "Polys" && own == "connectivity");
            match is_sized && wanted(name, own) {
                true => arrays.push(array(&source, node, tuples).map_err(|problem| format!("{name}: {problem}"))?),
                false => {
                    let components = node.attribute("NumberOfComponents").and_then(|count| count.parse().ok());
                    unread.push((name, own.to_string(), components.unwrap_or(1)));
                }
            }
        }
        sections.push((name, arrays));
    }
    let fields = || {
        let section = root.descendants().find(|node| node.has_tag_name(FIELD_DATA));
        section.into_iter().flat_map(|section| section.children())
    };
    let own = fields().filter(|node| {
        node.has_tag_name("DataArray") && wanted(FIELD_DATA, node.attribute("Name").unwrap_or_default())
    });
    let of_whole = own.map(|node| array(&source, node, tuples_of_field(node)?));
    sections.push((FIELD_DATA, of_whole.collect::<Result<_, _>>()?));
    let of_run = fields().any(|node| node.has_tag_name("Array") && node.attribute("Name") == Some("scene_name"));
    let time = fields().find(|node| node.attribute("Name") == Some("TimeValue"));
    let time = time.map(|node| array(&source, node, 1)).transpose()?.and_then(|array| array.values().first().copied());
    let time = time.filter(|time| time.is_finite());
    Ok(Outline { time, points, cells, topology, sections, unread, of_run })
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
    let is_big = match root.attribute("byte_order") {
        None | Some("LittleEndian") => false,
        Some("BigEndian") => true,
        Some(other) => return Err(format!("byte_order is '{other}', neither LittleEndian nor BigEndian")),
    };
    let compressor = match root.attribute("compressor") {
        None => None,
        Some("vtkZLibDataCompressor") => Some(Compressor::Zlib),
        Some("vtkLZ4DataCompressor") => Some(Compressor::Lz4),
        Some(other) => {
            return Err(format!(
                "it is compressed by {other}; write it with zlib, LZ4 or none (in ParaView: Compressor Type)"
            ));
        }
    };
    let header = if root.attribute("header_type") == Some("UInt64") { 8 } else { 4 };
    let section = document.descendants().find(|node| node.has_tag_name("AppendedData"));
    let in_base64 = section.is_some_and(|node| node.attribute("encoding") == Some("base64"));
    Ok((root, Source { appended, in_base64, compressor, header, is_big }))
}

/// Number of tuples of an array of the whole file.
fn tuples_of_field(node: Node<'_, '_>) -> Result<usize, String> {
    let tuples = node.attribute("NumberOfTuples").unwrap_or("1").parse::<usize>();
    tuples.ok().filter(|tuples| *tuples <= i32::MAX as usize).ok_or("a field has no number of tuples".to_string())
}

/// An array with that many tuples.
fn array(source: &Source<'_>, node: Node<'_, '_>, tuples: usize) -> Result<Array, String> {
    let attribute = |name: &str| node.attribute(name).unwrap_or_default();
    let name = attribute("Name").to_string();
    let wrong = |what: &str| format!("array {name}: {what}");
    let kind = Kind::of(attribute("type"));
    let kind = kind.ok_or_else(|| wrong(&format!("numbers of type '{}' are not read", attribute("type"))))?;
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
        other => Err(format!("its format '{other}' is not read")),
    };
    let mut bytes = bytes.map_err(|what| wrong(&what))?;
    if source.is_big && attribute("format") != "ascii" {
        bytes.chunks_exact_mut(kind.size()).for_each(<[u8]>::reverse);
    }
    Ok(Array { bytes, name, components, kind })
}

fn cut() -> String {
    "the file ends within it".into()
}

/// An integer in front of an array.
fn header_number(source: &Source<'_>, bytes: &[u8], place: usize) -> Result<usize, String> {
    let header = source.header;
    let own = bytes.get(header * place..header * (place + 1)).ok_or_else(cut)?;
    let add = |sum: u64, byte: &u8| sum << 8 | u64::from(*byte);
    let number = if source.is_big { own.iter().fold(0, add) } else { own.iter().rev().fold(0, add) };
    usize::try_from(number).map_err(|_| cut())
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
    let count = header_number(source, &begin, 0)?;
    if source.compressor.is_none() {
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
        packed = packed.saturating_add(header_number(source, &bytes, 3 + block)?);
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
        bytes.extend(kind.bytes(number));
        found += 1;
    }
    match found == count {
        true => Ok(bytes),
        false => Err(format!("it has {found} numbers in place of {count}")),
    }
}

/// Unpacks the `size` bytes of an array: stored as a size and bytes, or as compressed blocks behind the table of their sizes.
fn blocks(source: &Source<'_>, bytes: &[u8], size: usize) -> Result<Vec<u8>, String> {
    let header = source.header;
    let number = |place: usize| header_number(source, bytes, place);
    let other = |found: usize| format!("it has {found} bytes in place of {size}");
    let Some(compressor) = source.compressor else {
        let found = number(0)?;
        if found != size {
            return Err(other(found));
        }
        return bytes.get(header..header + size).map(<[u8]>::to_vec).ok_or_else(cut);
    };
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
        let is_whole = match compressor {
            Compressor::Zlib => {
                let status = Decompress::new(true).decompress_vec(packed, &mut unpacked, FlushDecompress::Finish);
                matches!(status, Ok(Status::StreamEnd))
            }
            Compressor::Lz4 => lz4_block(packed, &mut unpacked, end).is_some(),
        };
        if !is_whole || unpacked.len() != end {
            return Err("a block is damaged".into());
        }
    }
    Ok(unpacked)
}

/// Unpacks a block of LZ4 behind what `unpacked` holds, up to a length of `end`; none where the block is damaged. A block is a row of
/// sequences: a token with two lengths, literal bytes, and how far back the bytes to copy begin
/// (<https://github.com/lz4/lz4/blob/dev/doc/lz4_Block_format.md>).
fn lz4_block(packed: &[u8], unpacked: &mut Vec<u8>, end: usize) -> Option<()> {
    let start = unpacked.len();
    let mut bytes = packed.iter().copied();
    // A length of 15 goes on in further bytes, up to one that is not 255.
    fn length(first: u8, bytes: &mut impl Iterator<Item = u8>) -> Option<usize> {
        let mut length = usize::from(first);
        let mut more = if first == 15 { 255 } else { 0 };
        while more == 255 {
            more = bytes.next()?;
            length += usize::from(more);
        }
        Some(length)
    }
    while let Some(token) = bytes.next() {
        let literals = length(token >> 4, &mut bytes)?;
        if literals > end - unpacked.len() {
            return None;
        }
        let before = unpacked.len();
        unpacked.extend(bytes.by_ref().take(literals));
        if unpacked.len() - before < literals {
            return None;
        }
        // The last sequence ends behind its literals.
        let Some(low) = bytes.next() else { return Some(()) };
        let back = usize::from(low) | usize::from(bytes.next()?) << 8;
        let copied = length(token & 15, &mut bytes)? + 4;
        if back == 0 || back > unpacked.len() - start || copied > end - unpacked.len() {
            return None;
        }
        for place in unpacked.len() - back..unpacked.len() - back + copied {
            unpacked.push(unpacked[place]);
        }
    }
    Some(())
}

#[cfg(test)]
#[path = "../../tests/unit/output_vtk_read.rs"]
mod tests;
