//! Meshes as STL, in text.

use makadam_frames::output::mesh::Mesh;
use nalgebra::Vector3;
use std::fmt::Write;

/// The text of a file: as many digits as decide on which side of a face a grain lies.
pub(super) fn stl(mesh: &Mesh) -> String {
    let mut text = String::from("solid wall\n");
    for [a, b, c] in &mesh.triangles {
        let (p, q, r) = (Vector3::from(*a), Vector3::from(*b), Vector3::from(*c));
        let normal = (q - p).cross(&(r - p)).normalize();
        let _ = writeln!(text, "facet normal {} {} {}\nouter loop", normal.x, normal.y, normal.z);
        for [x, y, z] in [a, b, c] {
            let _ = writeln!(text, "vertex {x:.12e} {y:.12e} {z:.12e}");
        }
        text += "endloop\nendfacet\n";
    }
    text + "endsolid wall\n"
}
