//! Frames in VTK's XML files (`.vtp`, `.vtu`) of polygonal data or of an unstructured grid: points and arrays over them, or lines and arrays
//! over them. Arrays are appended (raw or base64) or inline (base64 or text), compressed by zlib, by LZ4 or not at all, in either
//! byte order.

use super::columns::StatedColumns;
use super::table::{FrameTable, ImportError, Named, is_wanted, table_of};
use crate::output::FIELD_DATA;
use crate::run_frames::columns::{Number, driven_walls};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::{Decompress, FlushDecompress, Status};
use makadam::snapshot::DrivenWall;
use roxmltree::{Document, Node};
use std::path::Path;

/// Files that list other files: type of the root, and name of the list.
const LISTS: [(&str, &str); 5] = [
    ("Collection", "files (.pvd)"),
    ("vtkMultiBlockDataSet", "blocks (.vtm)"),
    ("vtkPartitionedDataSetCollection", "blocks (.vtpc)"),
    ("PPolyData", "pieces (.pvtp)"),
    ("PUnstructuredGrid", "pieces (.pvtu)"),
];

/// VTK's name of an unstructured grid.
const GRID: &str = "UnstructuredGrid";

/// Start of the appended arrays.
const APPENDED: &[u8] = b"<AppendedData";

/// Compression of the blocks of arrays.
#[derive(Clone, Copy, PartialEq)]
enum Compression {
    None,
    Zlib,
    Lz4,
}

/// Largest compression ratio of zlib and LZ4, rounded up: a file with a larger ratio is damaged.
const BEST_COMPRESSION: usize = 1100;

/// Encoding of the arrays of a document.
struct Source<'a> {
    appended: &'a [u8],
    /// True if appended arrays are text.
    in_base64: bool,
    compression: Compression,
    /// Bytes of the header integers of an array.
    header: usize,
    /// True for big-endian numbers.
    is_big: bool,
}

/// Reads the frame of a file: its lines, if it has lines, otherwise its points.
pub(super) fn xml(file: &Path, bytes: &[u8], stated: &StatedColumns) -> Result<Vec<FrameTable>, ImportError> {
    let fault = |problem: String| ImportError::new(file, 1, problem);
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(1000)]);
    if let Some((_, list)) = LISTS.iter().find(|(kind, _)| head.contains(&format!("type=\"{kind}\""))) {
        return Err(fault(format!(
            "it is a list of {list}; give the files that it lists, one frame each, or the folder of a run of Makadam; merge pieces of one \
             frame (in ParaView: filter Merge Blocks)"
        )));
    }
    let content = read(bytes, |name, components| is_wanted(name, components, stated)).map_err(fault)?;
    let Content { time, of_run, driven_walls, count, arrays } = content;
    Ok(vec![FrameTable {
        time,
        first_id: of_run.then_some(0),
        driven_walls,
        ..table_of(file, count, &arrays, stated)?
    }])
}

/// Content of a file.
#[derive(Debug)]
struct Content {
    /// Simulated time, s; absent if the file does not state it.
    time: Option<f64>,
    /// True for a file of a Makadam run, with the scene's grain numbers.
    of_run: bool,
    driven_walls: Vec<DrivenWall>,
    /// Number of points, or of lines.
    count: usize,
    arrays: Vec<Named>,
}

/// Reads the wanted arrays, selected by name and number of components.
///
/// # Errors
/// Error in the bytes.
fn read(bytes: &[u8], is_wanted: impl Fn(&str, usize) -> bool) -> Result<Content, String> {
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
    let mut counts = [0; 4];
    for (cells, name) in counts.iter_mut().zip(["Verts", "Lines", "Polys", "Strips"]) {
        *cells = count(&format!("NumberOf{name}"))?;
    }
    let section = |name: &str| piece.children().find(|node| node.has_tag_name(name));
    let has = |name: &str| !arrays_of(section(name)).is_empty();
    // A contact frame without contacts has no lines, but arrays over lines.
    let of_lines = (counts[0] == 0 && counts[1] > 0) || (points == 0 && !has("PointData") && has("CellData"));
    let (sections, count) = match (of_lines, root.attribute("type")) {
        (false, _) => (&["Points", "PointData"][..], points),
        (true, Some(GRID)) => (&["CellData"][..], count("NumberOfCells")?),
        // Arrays over cells cover the cells of all kinds.
        (true, _) => (&["CellData"][..], counts.iter().sum()),
    };
    let mut arrays = Vec::new();
    for of in sections {
        for node in arrays_of(section(of)) {
            let name = if *of == "Points" { "points" } else { node.attribute("Name").unwrap_or_default() };
            let components = node.attribute("NumberOfComponents").and_then(|count| count.parse().ok()).unwrap_or(1);
            let numbers = match is_wanted(name, components) {
                true => Some(array(&source, node, count).map_err(|problem| format!("{of}: {problem}"))?),
                false => None,
            };
            arrays.push(Named::new(name, components, numbers));
        }
    }
    let whole = root.descendants().find(|node| node.has_tag_name(FIELD_DATA));
    let fields = || whole.into_iter().flat_map(|section| section.children());
    let of_run = fields().any(|node| node.has_tag_name("Array") && node.attribute("Name") == Some("scene_name"));
    let named = |name: &str| arrays_of(whole).into_iter().find(|node| node.attribute("Name") == Some(name));
    let time = named("TimeValue").map(|node| array(&source, node, 1)).transpose()?;
    let time = time.and_then(|time| time.first().copied()).filter(|time| time.is_finite());
    let pose = |node| tuples_of_field(node).and_then(|tuples| array(&source, node, tuples));
    let driven_walls = driven_walls(|name| named(name).filter(|_| of_run).map(pose).transpose())?;
    Ok(Content { time, of_run, driven_walls, count, arrays })
}

/// Splits the XML document from the appended data.
fn split(bytes: &[u8]) -> Result<(String, &[u8]), String> {
    let (head, appended) = match bytes.windows(APPENDED.len()).position(|window| window == APPENDED) {
        None => (bytes, &[][..]),
        Some(place) => {
            let rest = &bytes[place..];
            // The underscore follows the attributes, which may contain underscores in their names.
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
    let compression = match root.attribute("compressor") {
        None => Compression::None,
        Some("vtkZLibDataCompressor") => Compression::Zlib,
        Some("vtkLZ4DataCompressor") => Compression::Lz4,
        Some(other) => {
            return Err(format!(
                "it is compressed by {other}; write it with zlib, LZ4 or none (in ParaView: Compressor Type)"
            ));
        }
    };
    let header = if root.attribute("header_type") == Some("UInt64") { 8 } else { 4 };
    let section = document.descendants().find(|node| node.has_tag_name("AppendedData"));
    let in_base64 = section.is_some_and(|node| node.attribute("encoding") == Some("base64"));
    Ok((root, Source { appended, in_base64, compression, header, is_big }))
}

/// Returns the arrays of a section.
fn arrays_of<'a, 'input>(section: Option<Node<'a, 'input>>) -> Vec<Node<'a, 'input>> {
    let children = section.into_iter().flat_map(|section| section.children());
    children.filter(|node| node.has_tag_name("DataArray")).collect()
}

/// Returns the number of tuples of an array of the whole file.
fn tuples_of_field(node: Node<'_, '_>) -> Result<usize, String> {
    let tuples = node.attribute("NumberOfTuples").unwrap_or("1").parse::<usize>();
    tuples.ok().filter(|tuples| *tuples <= i32::MAX as usize).ok_or("a field has no number of tuples".to_string())
}

/// Returns the numbers of an array with the given number of tuples.
fn array(source: &Source<'_>, node: Node<'_, '_>, tuples: usize) -> Result<Vec<f64>, String> {
    let attribute = |name: &str| node.attribute(name).unwrap_or_default();
    let wrong = |what: String| format!("array {}: {what}", attribute("Name"));
    let number = Number::of(attribute("type"));
    let number = number.ok_or_else(|| wrong(format!("numbers of type '{}' are not read", attribute("type"))))?;
    let components = node.attribute("NumberOfComponents").unwrap_or("1").parse::<usize>();
    let components = components.ok().filter(|count| (1..=9).contains(count));
    let components = components.ok_or_else(|| wrong("it has no number of components".into()))?;
    let size = number.size() * components * tuples;
    let text = node.text().unwrap_or_default();
    let bytes = match attribute("format") {
        "appended" => {
            let offset = attribute("offset").parse::<usize>().ok();
            let rest = offset.and_then(|offset| source.appended.get(offset..));
            let rest = rest.ok_or_else(|| wrong("it lies beyond the end of the file".into()))?;
            match source.in_base64 {
                true => from_base64(source, rest, size).and_then(|bytes| blocks(source, &bytes, size)),
                false => blocks(source, rest, size),
            }
        }
        "binary" => from_base64(source, text.trim().as_bytes(), size).and_then(|bytes| blocks(source, &bytes, size)),
        "ascii" => return in_words(text, components * tuples).map_err(wrong),
        other => Err(format!("its format '{other}' is not read")),
    };
    bytes.map(|bytes| number.decode(bytes, source.is_big)).map_err(wrong)
}

fn cut() -> String {
    "the file ends within it".into()
}

/// Reads a header integer of an array.
fn header_number(source: &Source<'_>, bytes: &[u8], place: usize) -> Result<usize, String> {
    let header = source.header;
    let own = bytes.get(header * place..header * (place + 1)).ok_or_else(cut)?;
    let add = |sum: u64, byte: &u8| sum << 8 | u64::from(*byte);
    let number = if source.is_big { own.iter().fold(0, add) } else { own.iter().rev().fold(0, add) };
    usize::try_from(number).map_err(|_| cut())
}

/// Decodes an array at the start of a base64 text. The header of a compressed array is encoded separately.
fn from_base64(source: &Source<'_>, text: &[u8], size: usize) -> Result<Vec<u8>, String> {
    let header = source.header;
    let unit = |start: usize, bytes: usize| {
        let end = start.saturating_add(bytes.div_ceil(3).saturating_mul(4)).min(text.len());
        let decoded = STANDARD.decode(text.get(start..end).unwrap_or_default());
        decoded.map(|bytes| (bytes, end)).map_err(|error| format!("it is no base64: {error}"))
    };
    if source.compression == Compression::None {
        return Ok(unit(0, header + size)?.0);
    }
    // Nine bytes are whole groups of letters: enough for the first number of a header.
    let count = header_number(source, &unit(0, 9)?.0, 0)?;
    if count > text.len() {
        return Err(cut());
    }
    let (mut bytes, start) = unit(0, header * (3 + count))?;
    let add = |sum: usize, block| header_number(source, &bytes, 3 + block).map(|size| sum.saturating_add(size));
    let packed = (0..count).try_fold(0, add)?;
    bytes.extend(unit(start, packed)?.0);
    Ok(bytes)
}

/// Parses numbers from text.
fn in_words(text: &str, count: usize) -> Result<Vec<f64>, String> {
    let number = |word: &str| word.parse::<f64>().map_err(|_| format!("'{word}' is no number"));
    let numbers = text.split_ascii_whitespace().map(number).collect::<Result<Vec<f64>, _>>()?;
    match numbers.len() == count {
        true => Ok(numbers),
        false => Err(format!("it has {} numbers in place of {count}", numbers.len())),
    }
}

/// Decodes the `size` bytes of an array: stored as a size and bytes, or as compressed blocks after the table of their sizes.
fn blocks(source: &Source<'_>, bytes: &[u8], size: usize) -> Result<Vec<u8>, String> {
    let header = source.header;
    let number = |place: usize| header_number(source, bytes, place);
    let other = |found: usize| format!("it has {found} bytes in place of {size}");
    if source.compression == Compression::None {
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
        let is_whole = if source.compression == Compression::Lz4 {
            unpacked.resize(end, 0);
            matches!(lz4_flex::block::decompress_into(packed, &mut unpacked[end - wanted..]), Ok(length) if length == wanted)
        } else {
            let status = Decompress::new(true).decompress_vec(packed, &mut unpacked, FlushDecompress::Finish);
            matches!(status, Ok(Status::StreamEnd))
        };
        if !is_whole || unpacked.len() != end {
            return Err("a block is damaged".into());
        }
    }
    Ok(unpacked)
}

#[cfg(test)]
#[path = "../../tests/unit/import_xml.rs"]
mod tests;
