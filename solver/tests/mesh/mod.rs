//! Walls from CAD files: contacts with meshes against analytic walls and closed forms.

mod contacts;
mod contracts;
mod edges;
mod files;
mod streams;
mod surfaces;

use crate::common::Setup;
use makadam::scene::{Motion, Scene, Shape, TriangleMesh, Wall};
use makadam::{Partner, Simulation};

pub const RADIUS: f64 = 0.005;
pub const G: f64 = 9.81;

pub type Corners = [[f64; 3]; 3];

/// A wall of triangles at rest.
pub fn mesh(name: &str, triangles: &[Corners]) -> Wall {
    let mesh = TriangleMesh::new(triangles).unwrap_or_else(|problem| panic!("{problem}"));
    Wall::new(name, "wall", Shape::mesh(name, mesh))
}

/// A wall of triangles with a motion.
pub fn moving(name: &str, triangles: &[Corners], motion: Motion) -> Wall {
    mesh(name, triangles).moving(motion)
}

/// The scene of a set-up with further walls.
pub fn scene(setup: &Setup, walls: &[Wall]) -> Scene {
    let mut scene = setup.scene();
    scene.wall.extend_from_slice(walls);
    scene
}

pub fn start(setup: &Setup, walls: &[Wall]) -> Simulation {
    Simulation::new(&scene(setup, walls), 1).unwrap_or_else(|error| panic!("{error}"))
}

fn add(a: [f64; 3], b: [f64; 3], share: f64) -> [f64; 3] {
    std::array::from_fn(|axis| a[axis] + b[axis] * share)
}

/// Parallelogram from a corner along two sides, cut into cells of two triangles each; `bend` displaces each inner point of the grid.
pub fn bent(
    corner: [f64; 3],
    one: [f64; 3],
    other: [f64; 3],
    [m, n]: [usize; 2],
    bend: impl Fn(usize, usize) -> [f64; 3],
) -> Vec<Corners> {
    let point = |i: usize, j: usize| {
        let flat = add(add(corner, one, i as f64 / m as f64), other, j as f64 / n as f64);
        let inner = i > 0 && i < m && j > 0 && j < n;
        if inner { add(flat, bend(i, j), 1.0) } else { flat }
    };
    let mut all = Vec::new();
    for (i, j) in (0..m).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let [a, b, c, d] = [point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)];
        match (i + j) % 2 {
            0 => all.extend([[a, b, c], [a, c, d]]),
            _ => all.extend([[a, b, d], [b, c, d]]),
        }
    }
    all
}

pub fn rectangle(corner: [f64; 3], one: [f64; 3], other: [f64; 3], cells: [usize; 2]) -> Vec<Corners> {
    bent(corner, one, other, cells, |_, _| [0.0; 3])
}

/// Sides of a box without its lid.
pub fn open_box(min: [f64; 3], max: [f64; 3], n: usize) -> Vec<Corners> {
    let [x, y, z] = [0, 1, 2].map(|axis| {
        let mut side = [0.0; 3];
        side[axis] = max[axis] - min[axis];
        side
    });
    let cells = [n, n];
    let mut all = rectangle(min, x, y, cells);
    all.extend(rectangle(min, x, z, cells));
    all.extend(rectangle(min, y, z, cells));
    all.extend(rectangle(add(min, y, 1.0), x, z, cells));
    all.extend(rectangle(add(min, x, 1.0), y, z, cells));
    all
}

/// Shell of a cylinder about the y axis, with a corner at the angle zero from -z plus half a side: a side lies at the bottom.
pub fn cylinder(radius: f64, length: f64, sides: usize, rings: usize) -> Vec<Corners> {
    let point = |i: usize, j: usize| {
        let angle = (i as f64 + 0.5) / sides as f64 * std::f64::consts::TAU;
        [radius * angle.sin(), length * j as f64 / rings as f64, -radius * angle.cos()]
    };
    let mut all = Vec::new();
    for (i, j) in (0..sides).flat_map(|i| (0..rings).map(move |j| (i, j))) {
        let [a, b, c, d] = [point(i, j), point((i + 1) % sides, j), point((i + 1) % sides, j + 1), point(i, j + 1)];
        all.extend([[a, b, c], [a, c, d]]);
    }
    all
}

/// Contacts of the only grain with walls: normals and normal forces.
pub fn wall_contacts(simulation: &Simulation) -> Vec<([f64; 3], f64)> {
    let contacts = simulation.snapshot().contacts;
    let of_walls = contacts.iter().filter(|contact| matches!(contact.second, Partner::Wall(_)));
    of_walls.map(|contact| (contact.normal, contact.normal_force)).collect()
}
