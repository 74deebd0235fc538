//! Unit tests of `src/run_frames/walls.rs`.

use super::*;
use crate::plan::MeasuredScene;
use makadam::snapshot::DrivenWall;
use std::f64::consts::TAU;

const WALLS: &str = r#"
        name = "walls"
        description = "every shape"
        duration = 1.0
        gravity = [0.0, 0.0, -9.81]
        [domain]
        min = [-1.0, -1.0, -1.0]
        max = [1.0, 1.0, 1.0]
        [material.steel]
        density = 2500.0
        youngs_modulus = 1e7
        poisson_ratio = 0.3
        friction = 0.5
        restitution = 0.3
        [material.glass]
        density = 2500.0
        youngs_modulus = 1e7
        poisson_ratio = 0.3
        friction = 0.5
        restitution = 0.3
        [[wall]]
        name = "slope"
        material = "steel"
        shape = { kind = "plane", point = [0.0, 0.0, -0.5], normal = [0.3, 0.2, 1.0] }
        [[wall]]
        name = "drum"
        material = "glass"
        shape = { kind = "cylinder", base = [0.1, -0.2, 0.3], axis = [1.0, 2.0, 0.5], radius = 0.4, length = 0.5 }
        motion = { kind = "rotating", point = [0.1, -0.2, 0.3], axis = [1.0, 2.0, 0.5], rate = 2.0 }
        [[wall]]
        name = "blade"
        material = "steel"
        shape = { kind = "disc", centre = [0.5, 0.0, 0.0], normal = [1.0, 0.0, 1.0], radius = 0.3, hole = 0.1 }
        motion = { kind = "rotating", point = [0.0, 0.0, 0.0], axis = [0.0, 0.0, 1.0], rate = 1.5 }
        [[wall]]
        name = "lid"
        material = "steel"
        shape = { kind = "disc", centre = [0.0, 0.0, 0.8], normal = [0.0, 0.0, -1.0], radius = 0.3 }
        motion = { kind = "force-driven", axis = [0.0, 0.0, -1.0], force = 1.0, mass = 1.0 }
        [[wall]]
        name = "tray"
        material = "steel"
        shape = { kind = "box", min = [-0.2, -0.2, -0.2], max = [0.2, 0.3, 0.4], open = ["+z", "-x"] }
        motion = { kind = "translating", velocity = [0.0, 0.5, 0.0] }
        [[wall]]
        name = "bumps"
        material = "steel"
        shape = { kind = "spheres", centres = [[0.5, 0.5, 0.5], [-0.5, 0.5, 0.5]], radius = 0.1 }
        [[grain]]
        material = "glass"
        radius = 0.01
        position = [0.9, 0.9, 0.9]
    "#;

#[test]
fn corners_lie_on_the_walls_and_move_with_them() {
    let scene = MeasuredScene::parse(WALLS).unwrap();
    let mesh = FrameTables::new(&scene);
    let driven = |displacement| vec![DrivenWall { wall: 3, displacement, rate: 0.25 }];
    let at = |time, driven_walls| mesh.walls_part(&Snapshot { time, driven_walls, ..Snapshot::default() });
    let (early, late) = (at(0.4, driven(0.1)), at(0.5, driven(0.2)));
    let triangles: Vec<[u32; 3]> = late.corners().as_chunks().0.to_vec();
    let (points, before, velocities) = (&late.points.values, &early.points.values, &late.of_points[0].values);
    let vector = |values: &[f64], place: usize| Vector::from_column_slice(&values[3 * place..3 * place + 3]);
    let walls = &late.of_cells[0].values;
    assert_eq!(late.of_cells[1].values.len(), triangles.len());
    let placed = PlacedWalls::at(&scene.wall, &scene.domain, 0.5, &driven(0.2), &[]);
    let mut seen = [0; 6];
    for (triangle, wall) in triangles.iter().zip(walls) {
        for corner in triangle.map(|corner| corner as usize) {
            let point = vector(points, corner);
            let mut faces = placed.faces().filter(|(of, _)| *of == *wall as usize);
            assert!(faces.any(|(_, face)| face.distance(&point).abs() < 1e-6), "wall {wall}: {point}");
            // Straight ways are taken by the mean velocity; those of turning walls bend.
            let way = (point - vector(before, corner)) / 0.1;
            let off = (way - vector(velocities, corner)).norm();
            match wall {
                4.0 => assert!(off < 1e-5, "{off}"),
                3.0 => assert!((way.z + 1.0).abs() < 1e-5 && vector(velocities, corner).z == -0.25),
                2.0 => assert!(off < 0.1 && way.norm() > 0.1, "{off}"),
                _ => assert!(way.norm() < 1e-5, "{way}"),
            }
        }
        seen[*wall as usize] += 1;
    }
    assert_eq!(seen, [2, 192, 192, 94, 8, 640]);
    // The shell of the drum moves within itself.
    let on_drum = triangles[seen[0]][0] as usize;
    assert!((vector(velocities, on_drum).norm() - 0.8).abs() < 1e-6);
}

#[test]
fn areas_are_those_of_the_shapes() {
    let area = |shape: &Shape, domain: &Domain| -> f64 {
        let corners =
            wall_mesh(shape, domain, 0.0, DRAWN).triangles.into_iter().map(|corners| corners.map(Vector::from));
        corners.map(|[a, b, c]| 0.5 * (b - a).cross(&(c - a)).norm()).sum()
    };
    let domain = Domain { min: [0.0; 3], max: [1.0, 2.0, 3.0], periodic: vec![makadam::scene::Axis::Y] };
    let level = |height: f64| Shape::Plane { point: [0.3, 0.2, height], normal: [0.0, 0.0, 1.0] };
    assert!((area(&level(0.0), &domain) - 2.0).abs() < 1e-7);
    assert_eq!(area(&level(9.0), &domain), 0.0);
    // A plane through the middle that cuts all three axes alike shows a regular hexagon in a cube.
    let cube = Domain { min: [0.0; 3], max: [1.0; 3], periodic: Vec::new() };
    let diagonal = Shape::Plane { point: [0.5; 3], normal: [1.0; 3] };
    let hexagon = Triangles::of(&diagonal, &cube);
    assert_eq!((hexagon.points.len(), hexagon.triangles.len()), (6, 4));
    assert!((area(&diagonal, &cube) - 0.75 * 3.0_f64.sqrt()).abs() < 1e-7);
    // Along a periodic axis a tube reaches through the domain.
    let tube = Shape::Cylinder { base: [0.5, 0.7, 0.5], axis: [0.0, 1.0, 0.0], radius: 0.25, length: 0.1 };
    assert!((area(&tube, &domain) / (TAU * 0.25 * 2.0) - 1.0).abs() < 2e-3);
    let ring = Shape::Disc { centre: [0.0; 3], normal: [0.0, 1.0, 0.0], radius: 0.5, hole: 0.25 };
    assert!((area(&ring, &domain) / (TAU / 2.0 * (0.25 - 0.0625)) - 1.0).abs() < 2e-3);
    let ball = Shape::Spheres { centres: vec![[0.0; 3]], radius: 2.0 };
    assert!((area(&ball, &domain) / (2.0 * TAU * 4.0) - 1.0).abs() < 0.05);
    let many = Shape::Spheres { centres: vec![[0.0; 3]; 2000], radius: 2.0 };
    assert_eq!(wall_mesh(&many, &domain, 0.0, DRAWN).triangles.len(), 160_000);
}

#[test]
fn wear_of_a_mesh_is_on_its_triangles() {
    let mut scene = MeasuredScene::parse(WALLS).unwrap();
    let corners =
        [[[0.0, 0.0, 0.0], [0.2, 0.0, 0.0], [0.0, 0.1, 0.0]], [[0.2, 0.0, 0.0], [0.2, 0.1, 0.0], [0.0, 0.1, 0.0]]];
    scene.wall.truncate(1);
    scene.wall[0].shape = Shape::mesh("two", makadam::scene::TriangleMesh::new(&corners).unwrap());
    let of = |scene: &MeasuredScene| {
        let wear =
            [(0, 3.0), (1, 1.0)].map(|(face, archard)| FaceWear { face, archard, ..FaceWear::default() }).to_vec();
        let part = FrameTables::new(scene).walls_part(&Snapshot { wear, ..Snapshot::default() });
        part.of_cells.into_iter().find(|column| column.name == "archard").map(|column| column.values)
    };
    assert_eq!(of(&scene), None);
    scene.measure.observables = vec![Observable::Wear];
    // Each triangle has an area of 0.01 m2.
    assert_eq!(of(&scene), Some(vec![300.0, 100.0]));
    // Other shapes have the mean of the wall.
    scene.wall[0].shape = Shape::Box {
        min: [0.0; 3],
        max: [0.2, 0.1, 1.0],
        open: ["+z", "-x", "+x", "-y", "+y"].map(String::from).to_vec(),
    };
    assert!(of(&scene).unwrap().iter().all(|value| (value - 200.0).abs() < 1e-4));
}
