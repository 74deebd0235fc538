//! Contour lines of a field, by marching squares.

use super::field::Field;
use std::collections::HashMap;

/// Closed contour line: its corners in order, m; the last corner joins the first.
pub type Loop = Vec<[f64; 2]>;

/// Straight piece of a contour line.
pub type Segment = [[f64; 2]; 2];

/// Link between the centres of two neighbouring cells: column, row, and true for an upward link.
type Link = (isize, isize, bool);

/// Returns the contour lines of `field` at `level` (above zero), with linear interpolation between the centres of cells.
///
/// The field counts as zero outside its grid, so that every line is closed.
pub fn contours(field: &Field, level: f64) -> Vec<Loop> {
    let mut next: HashMap<Link, Vec<Link>> = HashMap::new();
    let mut order = Vec::new();
    for row in -1..field.rows as isize {
        for column in -1..field.columns as isize {
            for (from, to) in pieces(field, level, column, row) {
                order.push(from);
                next.entry(from).or_default().push(to);
                next.entry(to).or_default().push(from);
            }
        }
    }
    // Each crossed link has two pieces, one on each side: follow them to close the line.
    let mut loops = Vec::new();
    for start in order {
        let mut line = Vec::new();
        let mut here = start;
        while let Some(onward) = next.remove(&here) {
            line.push(crossing(field, level, here));
            match onward.into_iter().find(|link| next.contains_key(link)) {
                Some(link) => here = link,
                None => break,
            }
        }
        if line.len() > 2 {
            loops.push(line);
        }
    }
    loops
}

/// Returns the contour line with the largest area: the outline of the bed, without holes and stray grains.
pub fn outline(field: &Field, level: f64) -> Option<Loop> {
    contours(field, level).into_iter().max_by(|a, b| area(a).total_cmp(&area(b)))
}

/// Returns the pieces of the contour in the square with its lower left corner at the centre of a cell.
fn pieces(field: &Field, level: f64, column: isize, row: isize) -> Vec<(Link, Link)> {
    let corner = [
        field.get(column, row),
        field.get(column + 1, row),
        field.get(column + 1, row + 1),
        field.get(column, row + 1),
    ];
    let links = [(column, row, false), (column + 1, row, true), (column, row + 1, false), (column, row, true)];
    let above = corner.map(|value| value >= level);
    let crossed: Vec<usize> = (0..4).filter(|&side| above[side] != above[(side + 1) % 4]).collect();
    match crossed.as_slice() {
        [a, b] => vec![(links[*a], links[*b])],
        [_, _, _, _] => {
            // A saddle: the mean of the corners decides whether the high corners are joined.
            let joined = corner.iter().sum::<f64>() >= 4.0 * level;
            match above[0] == joined {
                true => vec![(links[0], links[1]), (links[2], links[3])],
                false => vec![(links[3], links[0]), (links[1], links[2])],
            }
        }
        _ => Vec::new(),
    }
}

/// Returns the point of a link at which the field passes `level`.
fn crossing(field: &Field, level: f64, (column, row, upward): Link) -> [f64; 2] {
    let (to_column, to_row) = if upward { (column, row + 1) } else { (column + 1, row) };
    let (from, to) = (field.get(column, row), field.get(to_column, to_row));
    let share = (level - from) / (to - from);
    let (a, b) = (field.centre(column, row), field.centre(to_column, to_row));
    [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])]
}

/// Returns the area of a closed line, m2.
pub fn area(line: &Loop) -> f64 {
    let twice: f64 = segments(line).map(|[a, b]| a[0] * b[1] - a[1] * b[0]).sum();
    0.5 * twice.abs()
}

/// Returns the straight pieces of a closed line.
pub fn segments(line: &Loop) -> impl Iterator<Item = Segment> + '_ {
    (0..line.len()).map(|index| [line[index], line[(index + 1) % line.len()]])
}

/// Returns true if a segment crosses the ray from a point towards larger first coordinates. A closed line that encloses the point has an
/// odd number of such segments.
pub fn crosses([a, b]: Segment, point: [f64; 2]) -> bool {
    (a[1] > point[1]) != (b[1] > point[1]) && point[0] < a[0] + (point[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
}

/// Returns the squared distance of a point from a segment, m2.
pub fn squared_distance([a, b]: &Segment, point: [f64; 2]) -> f64 {
    let (along, arm) = ([b[0] - a[0], b[1] - a[1]], [point[0] - a[0], point[1] - a[1]]);
    let square = (along[0] * along[0] + along[1] * along[1]).max(f64::MIN_POSITIVE);
    let share = ((arm[0] * along[0] + arm[1] * along[1]) / square).clamp(0.0, 1.0);
    (arm[0] - share * along[0]).powi(2) + (arm[1] - share * along[1]).powi(2)
}
