//! Readers of STL files, text and binary, and of OBJ files.
//!
//! ```text
//! STL binary  80 bytes, number of triangles (u32), then 50 bytes a triangle: normal and three corners (f32), two bytes
//! STL text    solid ... facet normal x y z / outer loop / vertex x y z (three times) / endloop / endfacet ... endsolid
//! OBJ         v x y z; f corner corner corner ..., counted from 1, or backwards from -1; polygons lose corner after corner
//! ```
//!
//! Normals of a file are ignored. A file is binary STL if its length is that of its number of triangles: binary files may begin with
//! "solid", too.

use super::Vector;
use super::mesh::MOST_TRIANGLES;

/// Corners of a triangle.
type Corners = [[f64; 3]; 3];

/// Number of bytes before the triangles of a binary STL file.
const HEAD: usize = 84;
/// Number of bytes of a triangle of a binary STL file.
const RECORD: usize = 50;

/// Reads the triangles of a file.
///
/// # Errors
/// Text that follows the name of the file, with the remedy.
pub(super) fn triangles(bytes: &[u8]) -> Result<Vec<Corners>, String> {
    let count = bytes.get(80..HEAD).map(|four| u32::from_le_bytes(four.try_into().expect("four bytes")) as usize);
    if count.is_some_and(|count| bytes.len() == HEAD + RECORD * count) {
        return Ok(binary(&bytes[HEAD..]));
    }
    let text = std::str::from_utf8(bytes).ok();
    let Some(text) = text else {
        let lengths = match count {
            Some(count) if count <= MOST_TRIANGLES && !bytes.starts_with(b"solid") => {
                format!(" ({} bytes, and {count} triangles take {})", bytes.len(), HEAD + RECORD * count)
            }
            _ => String::new(),
        };
        return Err(format!("is neither STL nor OBJ{lengths}; export it again as STL"));
    };
    let word = |line: &str| line.split_ascii_whitespace().next().map(str::to_ascii_lowercase);
    let first = text.lines().find_map(|line| word(line).filter(|word| !word.starts_with('#')));
    match first.as_deref() {
        Some("solid") => text_stl(text),
        Some(_) if text.lines().any(|line| word(line).as_deref() == Some("v")) => obj(text),
        _ => Err("is neither STL nor OBJ; export it again as STL".into()),
    }
}

fn binary(records: &[u8]) -> Vec<Corners> {
    let number = |four: &[u8]| f64::from(f32::from_le_bytes(four.try_into().expect("four bytes")));
    let corner =
        |record: &[u8], corner: usize| std::array::from_fn(|axis| number(&record[12 * (corner + 1) + 4 * axis..][..4]));
    records.chunks_exact(RECORD).map(|record| std::array::from_fn(|number| corner(record, number))).collect()
}

fn text_stl(text: &str) -> Result<Vec<Corners>, String> {
    let mut corners = Vec::new();
    let (mut loops, mut is_whole) = (0, false);
    for (number, line) in text.lines().enumerate() {
        let mut words = line.split_ascii_whitespace();
        match words.next().map(str::to_ascii_lowercase).as_deref() {
            Some("vertex") => corners.push(point(words, number)?),
            Some("endloop") => {
                loops += 1;
                if corners.len() != 3 * loops {
                    return Err(format!("has a facet without three corners in line {}; export it again", number + 1));
                }
            }
            Some("endsolid") => is_whole = true,
            _ => {}
        }
    }
    if corners.len() != 3 * loops {
        return Err("ends within a facet; export it again".into());
    }
    if !is_whole {
        return Err("ends without endsolid, so that triangles may be missing; export it again".into());
    }
    Ok(corners.chunks_exact(3).map(|three| [three[0], three[1], three[2]]).collect())
}

fn obj(text: &str) -> Result<Vec<Corners>, String> {
    let (mut points, mut triangles): (Vec<[f64; 3]>, Vec<Corners>) = (Vec::new(), Vec::new());
    for (number, line) in text.lines().enumerate() {
        let mut words = line.split_ascii_whitespace();
        match words.next() {
            Some("v") => points.push(point(words, number)?),
            Some("f") => {
                let corner = |word: &str| {
                    let index: i64 = word.split('/').next()?.parse().ok()?;
                    let place = if index < 0 { points.len() as i64 + index } else { index - 1 };
                    points.get(usize::try_from(place).ok()?).copied()
                };
                let corners: Option<Vec<[f64; 3]>> = words.map(corner).collect();
                let corners = corners.filter(|corners| corners.len() >= 3).ok_or_else(|| {
                    format!("has a face without three known corners in line {}; export it again", number + 1)
                })?;
                clip(corners, &mut triangles).ok_or_else(|| {
                    format!(
                        "has a polygon that crosses itself in line {}; triangulate it before the export",
                        number + 1
                    )
                })?;
            }
            _ => {}
        }
    }
    Ok(triangles)
}

/// Clips corners of a polygon until a triangle is left: the first convex corner, if its triangle holds no other corner. So convex polygons
/// become fans. Returns `None` for a polygon that crosses itself.
fn clip(mut corners: Vec<[f64; 3]>, triangles: &mut Vec<Corners>) -> Option<()> {
    let turn = |[a, b, c]: Corners| (Vector::from(b) - Vector::from(a)).cross(&(Vector::from(c) - Vector::from(a)));
    let normal: Vector = corners[1..].windows(2).map(|two| turn([corners[0], two[0], two[1]])).sum();
    while corners.len() > 3 {
        let count = corners.len();
        let at = |middle: usize| [middle - 1, middle % count, (middle + 1) % count].map(|place| corners[place]);
        let ear = |&middle: &usize| {
            let [a, b, c] = at(middle);
            let is_left = |a, b, point| turn([a, b, point]).dot(&normal) >= 0.0;
            let holds = |&point: &[f64; 3]| is_left(a, b, point) && is_left(b, c, point) && is_left(c, a, point);
            let is_other = |point: &&[f64; 3]| ![a, b, c].contains(*point);
            turn([a, b, c]).dot(&normal) > 0.0 && !corners.iter().filter(is_other).any(holds)
        };
        let middle = (1..=count).find(ear).or((normal.norm() == 0.0).then_some(1))?;
        triangles.push(at(middle));
        corners.remove(middle % count);
    }
    let last = [corners[0], corners[1], corners[2]];
    triangles.push(last);
    (turn(last).dot(&normal) >= -1e-9 * normal.norm_squared()).then_some(())
}

/// Reads three coordinates of a line.
fn point<'w>(words: impl Iterator<Item = &'w str>, line: usize) -> Result<[f64; 3], String> {
    let numbers: Vec<f64> = words.map_while(|word| word.parse().ok()).collect();
    match numbers[..] {
        [x, y, z, ..] => Ok([x, y, z]),
        _ => Err(format!("has no three numbers in line {}; export it again", line + 1)),
    }
}
