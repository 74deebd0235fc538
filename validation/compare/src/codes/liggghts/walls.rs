//! The walls of a deck: meshes, whose contacts are told, or what LIGGGHTS is fastest with.
//!
//! ```text
//!              measuring                    timing
//! curved       fine mesh                    primitive where it is one, else coarse mesh
//! flat         mesh                         primitive where it is one, else mesh
//! contacts     dumped                       not told: a primitive has none that can be dumped beside those of meshes
//! ```

use crate::codes::Purpose;
use crate::codes::primitives::{Primitive, primitives};
use makadam::scene::Grain;
use makadam_frames::output::mesh::{COARSE, FINE, Mesh, wall_mesh};
use makadam_frames::plan::Scene;

/// Largest relative error of the velocity of a turning wall that is a primitive.
const VELOCITY_ERROR: f64 = 0.01;

/// The walls of a deck.
pub(super) struct Walls {
    pub purpose: Purpose,
    /// The walls that are meshes, by their place in the scene: LIGGGHTS numbers its meshes itself, and a wall without triangles has none.
    pub meshes: Vec<(usize, Mesh)>,
    /// The primitives of the other walls, in the words of `fix wall/gran`.
    pub primitives: Vec<(usize, String)>,
}

impl Walls {
    /// Meshes alone for measuring; for timing, what is fastest with the same physics.
    pub fn new(scene: &Scene, grains: &[Grain], purpose: Purpose) -> Walls {
        let smallest = grains.iter().map(|grain| grain.radius).fold(f64::INFINITY, f64::min);
        let (fineness, found) = match purpose {
            Purpose::Measuring => (FINE, vec![Vec::new(); scene.wall.len()]),
            Purpose::Timing => (COARSE, primitives(scene, grains)),
        };
        let mut walls = Walls { purpose, meshes: Vec::new(), primitives: Vec::new() };
        for (place, (wall, found)) in scene.wall.iter().zip(&found).enumerate() {
            let words: Option<Vec<String>> = found.iter().map(|primitive| words(primitive, grains)).collect();
            match words.filter(|words| !words.is_empty()) {
                Some(words) => walls.primitives.extend(words.into_iter().map(|words| (place, words))),
                None => {
                    let mesh = wall_mesh(&wall.shape, &scene.domain, smallest, fineness);
                    walls.meshes.extend((!mesh.triangles.is_empty()).then_some((place, mesh)));
                }
            }
        }
        walls
    }

    /// Returns true if their contacts are dumped.
    pub fn are_told(&self) -> bool {
        self.purpose == Purpose::Measuring && !self.meshes.is_empty()
    }
}

/// A primitive in the words of `fix wall/gran`; nothing for one that it cannot have.
///
/// A cylinder turns by `shear`: the word of a direction across its axis, and the angular velocity. The velocity is taken at the centre of the
/// grain in place of the surface, so that the angular velocity is raised by the ratio of both distances from the axis: exact for the mean
/// grain. About y it is wrong: the two coordinates of the distance are interchanged, and grains are not dragged along ([`Turn`](super::turn)).
fn words(primitive: &Primitive, grains: &[Grain]) -> Option<String> {
    const AXES: [&str; 3] = ["x", "y", "z"];
    match *primitive {
        Primitive::Plane { axis, at } => Some(format!("{}plane {at:.17e}", AXES[axis])),
        Primitive::Cylinder { axis, centre, radius, rate } => {
            // The two coordinates of the centre follow in the order x, y, z, x.
            let [first, second] = [1, 2].map(|step| centre[(axis + step) % 3]);
            let name = format!("{}cylinder {radius:.17e} {first:.17e} {second:.17e}", AXES[axis]);
            if rate == 0.0 {
                return Some(name);
            }
            let radii = || grains.iter().map(|grain| grain.radius);
            let mean = radii().sum::<f64>() / grains.len() as f64;
            let error = radii().map(|own| ((radius - own) / (radius - mean) - 1.0).abs()).fold(0.0, f64::max);
            let shear = rate * radius / (radius - mean);
            let across = AXES[(axis + 1) % 3];
            (axis != 1 && error <= VELOCITY_ERROR).then(|| format!("{name} shear {across} {shear:.17e}"))
        }
    }
}
