//! Checks of meshes from files: their unit of length, their place, and triangles that were dropped.
//!
//! Files of CAD programs have no unit of length. A mesh is in another unit if its longest side is above 10 times the longest side of the domain, or
//! below the diameter of the smallest grain. The remedy names the longest unit with which the mesh is at least a tenth of the domain and fits.

use crate::scene::Scene;
use crate::scene::document::DocumentPath;
use crate::scene::error::{Fault, short};
use crate::surface::Shape;

/// Largest plausible ratio of the sizes of a mesh and the domain.
const RATIO: f64 = 10.0;

/// Units of length, m, the longest first.
const UNITS: [(&str, f64); 5] =
    [("metres", 1.0), ("inches", 0.0254), ("centimetres", 1e-2), ("millimetres", 1e-3), ("micrometres", 1e-6)];

/// Returns the findings on meshes.
pub(super) fn faults(scene: &Scene) -> Vec<Fault> {
    scene.wall.iter().enumerate().flat_map(|(index, wall)| of_wall(scene, index, &wall.shape)).collect()
}

fn of_wall(scene: &Scene, index: usize, shape: &Shape) -> Vec<Fault> {
    let Shape::Mesh { file, scale, content, .. } = shape else { return Vec::new() };
    let at = DocumentPath::default().key("wall").index(index).key("shape");
    let (domain, mut faults) = (&scene.domain, Vec::new());
    let size = |low: [f64; 3], high: [f64; 3]| (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
    let extent = size(domain.min, domain.max);
    let smallest = scene.grain_kinds().map(|(_, (least, _))| 2.0 * least).fold(f64::INFINITY, f64::min);
    for (low, high) in shape.bounds() {
        let longest = size(low, high);
        let fits = |factor: f64| (extent / RATIO..=extent).contains(&(longest * factor));
        if longest > extent * RATIO || (longest < smallest && smallest.is_finite()) {
            let sides: Vec<String> = (0..3).map(|axis| rounded(high[axis] - low[axis])).collect();
            let problem = format!(
                "'{file}' spans {} m where the longest side of the domain is {} m, and the smallest grain {} m wide",
                sides.join(" x "),
                short(extent),
                short(smallest)
            );
            let remedy = match UNITS.iter().find(|(_, metres)| fits(metres / scale)) {
                Some((unit, metres)) => format!("is the file in {unit}? scale = {metres} makes it fit"),
                None => "give the metres per unit of the file, or the domain that the walls need".into(),
            };
            faults.push(at.key("scale").fault(problem, &remedy));
        } else if (0..3).any(|axis| high[axis] < domain.min[axis] || low[axis] > domain.max[axis]) {
            let point = |point: [f64; 3]| point.map(rounded).join(", ");
            let problem = format!("'{file}' lies outside the domain, from ({}) to ({}) m", point(low), point(high));
            faults.push(at.key("translate").fault(problem, "move the mesh, or enlarge [domain]"));
        }
    }
    let [flat, repeated] = content.dropped();
    if flat + repeated > 0 {
        let problem =
            format!("'{file}' has {flat} triangles without area and {repeated} repeated ones, which are dropped");
        faults.push(at.key("file").fault(problem, "check the export if the surface has holes"));
    }
    faults
}

fn rounded(value: f64) -> String {
    short(format!("{value:.3e}").parse().unwrap_or(value))
}
