//! Curved surfaces, closed meshes and random meshes.

use super::{Corners, G, RADIUS, cylinder, mesh, start, wall_contacts};
use crate::common::{CONVERGED_RIGID, DENSITY, Setup, grain, run_until};
use makadam::Simulation;
use nalgebra::Vector3;
use proptest::prelude::*;
use std::f64::consts::PI;

type Vector = Vector3<f64>;

#[test]
fn the_error_of_a_cylinder_falls_as_one_minus_a_cosine() {
    let radius = 0.1;
    let mass = DENSITY * 4.0 / 3.0 * PI * RADIUS.powi(3);
    for sides in [12, 48, 192] {
        // From the middle of the lowest side, a little up the flank, the grain slides back.
        let body =
            grain(RADIUS, [0.0, 0.05, -radius + 1.6 * RADIUS + radius * (1.0 - (PI / sides as f64).cos())], [0.0; 3]);
        let setup = Setup { restitution: 0.0, body, ..Setup::default() };
        let mut simulation = start(&setup, &[mesh("shell", &cylinder(radius, 0.1, sides, 3))]);
        run_until(&mut simulation, 0.1);
        let height = simulation.snapshot().particles[0].position[2];
        let error = height - (RADIUS - radius);
        let expected = radius * (1.0 - (PI / sides as f64).cos());
        assert!((error - expected).abs() < 1e-6 * RADIUS, "{sides} sides: {error:e} and {expected:e}");
        let force: f64 = wall_contacts(&simulation).iter().map(|(_, force)| force).sum();
        assert!((force - mass * G).abs() < 1e-9 * mass * G, "{force}");
    }
}

/// Closed sphere of triangles: an octahedron whose faces are cut into four so often.
fn ball(radius: f64, cuts: usize) -> Vec<Corners> {
    let unit = |sign: f64, axis: usize| Vector::ith(axis, sign);
    let mut all: Vec<[Vector; 3]> = Vec::new();
    for number in 0..8 {
        let sign = |axis: usize| if number >> axis & 1 == 0 { 1.0 } else { -1.0 };
        all.push([unit(sign(0), 0), unit(sign(1), 1), unit(sign(2), 2)]);
    }
    for _ in 0..cuts {
        let cut = |[a, b, c]: [Vector; 3]| {
            let [ab, bc, ca] = [(a + b).normalize(), (b + c).normalize(), (c + a).normalize()];
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        all = all.into_iter().flat_map(cut).collect();
    }
    all.into_iter().map(|corners| corners.map(|corner| (corner * radius).into())).collect()
}

#[test]
fn grains_stay_in_a_closed_mesh_at_any_speed() {
    let inner = 0.02;
    for (cuts, speed) in [(1, 3.0), (3, 3.0), (3, 300.0), (5, 60.0)] {
        let grains: String = (0..8)
            .map(|k| {
                let place = [0, 1, 2].map(|axis| if k >> axis & 1 == 0 { 0.0052 } else { -0.0052 });
                let velocity =
                    [speed * (k as f64 + 0.3).sin(), speed * (2.0 * k as f64).cos(), speed * (3.0 * k as f64).sin()];
                grain(0.4 * RADIUS, place, velocity)
            })
            .collect();
        let solver = "step = 1e-4\nnormal_law = { kind = 'rigid' }\nstop = { kind = 'sweeps', sweeps = 30 }";
        let setup = Setup { restitution: 0.9, solver: solver.into(), body: grains, ..Setup::default() };
        let mut simulation = start(&setup, &[mesh("ball", &ball(inner, cuts))]);
        for step in 0..2000 {
            simulation.step();
            if step % 50 == 0 {
                for grain in simulation.snapshot().particles {
                    let distance = Vector::from(grain.position).norm();
                    assert!(distance < inner, "{cuts} cuts, {speed} m/s, step {step}: {grain:?}");
                }
            }
        }
        assert_eq!(simulation.crossing(), None);
    }
}

/// Nearest point of a triangle by comparison of its face, sides and corners.
fn nearest(corners: &[Vector; 3], point: &Vector) -> Vector {
    let [a, b, c] = *corners;
    let normal = (b - a).cross(&(c - a)).normalize();
    let foot = point - normal * normal.dot(&(point - a));
    let inside = (0..3).all(|k| {
        let (start, end) = (corners[k], corners[(k + 1) % 3]);
        (end - start).cross(&(foot - start)).dot(&normal) >= 0.0
    });
    if inside {
        return foot;
    }
    let on_sides = (0..3).map(|k| {
        let (start, along) = (corners[k], corners[(k + 1) % 3] - corners[k]);
        start + along * (along.dot(&(point - start)) / along.norm_squared()).clamp(0.0, 1.0)
    });
    on_sides.min_by(|a, b| (a - point).norm().total_cmp(&(b - point).norm())).unwrap()
}

/// Directions to the local minima of the distance within `reach`: points from which no way along the surface leads nearer.
fn brute_force(triangles: &[[Vector; 3]], centre: &Vector, reach: f64) -> Vec<Vector> {
    let feet: Vec<Vector> = triangles.iter().map(|triangle| nearest(triangle, centre)).collect();
    let mut found: Vec<(f64, Vector)> = Vec::new();
    for foot in feet.iter().filter(|foot| (*foot - centre).norm() < reach) {
        let distance = (foot - centre).norm();
        let descends = triangles.iter().any(|triangle| {
            let touches = (nearest(triangle, foot) - foot).norm() < 1e-9;
            touches
                && triangle.iter().any(|corner| {
                    let ways = [corner - foot, (triangle[0] + triangle[1] + triangle[2]) / 3.0 - foot];
                    ways.iter().any(|way| (foot + way * 1e-4 - centre).norm() < distance * (1.0 - 1e-12))
                })
        });
        let direction = (foot - centre) / distance;
        if !descends && found.iter().all(|(_, other)| (other - direction).norm() > 1e-6) {
            found.push((distance, direction));
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut kept: Vec<(f64, Vector)> = Vec::new();
    for (distance, direction) in found {
        if kept.iter().all(|(nearer, other)| distance * direction.dot(other) < *nearer) {
            kept.push((distance, direction));
        }
    }
    kept.into_iter().map(|(_, direction)| direction).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn contacts_with_random_meshes_are_the_minima_of_the_distance(
        heights in prop::collection::vec(-1.0_f64..1.0, 25),
        rough in 0.05_f64..1.5,
        place in [0.3_f64..0.7, 0.3..0.7],
        overlap in 1e-4_f64..0.1,
        width in 0.5_f64..8.0,
    ) {
        // A terrain of four by four cells about the grain.
        let width = width * RADIUS;
        let point = |i: usize, j: usize| {
            Vector::new((i as f64 / 4.0 - place[0]) * width, (j as f64 / 4.0 - place[1]) * width, 0.2 * rough * width * heights[5 * i + j])
        };
        let mut terrain: Vec<[Vector; 3]> = Vec::new();
        for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))) {
            let [a, b, c, d] = [point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)];
            terrain.extend([[a, b, c], [a, c, d]]);
        }
        // Lowered until it overlaps the nearest point.
        let mut centre = Vector::new(0.0, 0.0, 3.0 * width);
        for _ in 0..200 {
            let gap = terrain.iter().map(|one| (nearest(one, &centre) - centre).norm()).fold(f64::INFINITY, f64::min) - (1.0 - overlap) * RADIUS;
            centre.z -= gap;
        }
        // Contacts close to the limit of reach may be on either side of it.
        let sets = [0.999, 1.0, 1.001].map(|share| brute_force(&terrain, &centre, RADIUS * share));
        prop_assume!(sets.iter().all(|set| set.len() == sets[0].len()) && sets[0].len() <= 6);
        let triangles: Vec<Corners> = terrain.iter().map(|one| one.map(Into::into)).collect();
        let setup = Setup { gravity: [0.0; 3], body: grain(RADIUS, centre.into(), [0.0; 3]), solver: CONVERGED_RIGID.into(), ..Setup::default() };
        let mut scene = super::scene(&setup, &[mesh("terrain", &triangles)]);
        scene.largest_start_overlap = 2.0;
        let mut simulation = Simulation::new(&scene, 1).unwrap();
        simulation.step();
        let kept = simulation.kept_contacts()[1].clone().into_iter().filter(|kept| kept.impact.speed != 0.0);
        let faces = kept.map(|kept| nearest(&terrain[kept.second as usize], &centre));
        let mut found: Vec<Vector> = faces.map(|foot| (foot - centre).normalize()).collect();
        for expected in &sets[0] {
            let place = found.iter().position(|normal| (normal - expected).norm() < 1e-6);
            prop_assert!(place.is_some(), "no contact towards {:?} in {:?}", expected, found);
            found.swap_remove(place.unwrap());
        }
        prop_assert!(found.is_empty(), "further contacts {:?}", found);
    }
}
