//! Exact volumes of spheres cut by boxes: closed forms, partitions, Monte Carlo.

use approx::assert_abs_diff_eq;
use makadam_measure::observables::field::Field;
use makadam_measure::observables::sphere_volume::{half_space, octant, quadrant, sphere, sphere_in_box};
use proptest::prelude::*;
use std::f64::consts::PI;

const FULL: f64 = 4.0 / 3.0 * PI;
const FAR: f64 = f64::INFINITY;

fn unit(min: [f64; 3], max: [f64; 3]) -> f64 {
    sphere_in_box([0.0; 3], 1.0, min, max)
}

#[test]
fn simple_parts() {
    for (min, max, share) in [
        ([-1.0; 3], [1.0; 3], 1.0),
        ([-FAR; 3], [FAR; 3], 1.0),
        ([0.0, -2.0, -2.0], [2.0; 3], 0.5),
        ([0.0, 0.0, -2.0], [2.0; 3], 0.25),
        ([0.0; 3], [2.0; 3], 0.125),
        ([-2.0, -2.0, -2.0], [0.0, 0.0, 0.0], 0.125),
        ([1.0, -2.0, -2.0], [2.0; 3], 0.0),
        ([0.8, 0.7, -2.0], [2.0; 3], 0.0),
        ([0.6, 0.6, 0.6], [2.0; 3], 0.0),
        ([5.0; 3], [6.0; 3], 0.0),
    ] {
        assert_abs_diff_eq!(unit(min, max), share * FULL, epsilon = 1e-12);
    }
}

#[test]
fn cap_and_slab() {
    for height in [0.01, 0.3, 1.0, 1.7] {
        let cap = PI * height * height * (3.0 - height) / 3.0;
        assert_abs_diff_eq!(unit([1.0 - height, -2.0, -2.0], [2.0; 3]), cap, epsilon = 1e-12);
        assert_abs_diff_eq!(half_space(1.0 - height), cap, epsilon = 1e-12);
    }
    let slab = PI * (0.5 - 0.5_f64.powi(3) / 3.0) + PI * (0.2 - 0.2_f64.powi(3) / 3.0);
    assert_abs_diff_eq!(unit([-2.0, -0.2, -2.0], [2.0, 0.5, 2.0]), slab, epsilon = 1e-12);
}

#[test]
fn box_inside_the_sphere_is_the_box() {
    assert_abs_diff_eq!(unit([-0.5, -0.2, 0.1], [0.3, 0.4, 0.6]), 0.8 * 0.6 * 0.5, epsilon = 1e-12);
    assert_abs_diff_eq!(unit([0.1, 0.2, 0.3], [0.1001, 0.2001, 0.3001]), 1e-12, epsilon = 1e-14);
}

/// Simpson's rule over slices: the volume beyond X > a is the integral of the area of a cut disc.
fn simpson(from: f64, to: f64, area: impl Fn(f64) -> f64) -> f64 {
    let (steps, width) = (20_000, (to - from) / 20_000.0);
    let weight = |n: usize| {
        if n == 0 || n == steps {
            1.0
        } else if n % 2 == 1 {
            4.0
        } else {
            2.0
        }
    };
    (0..=steps).map(|n| weight(n) * area(from + n as f64 * width)).sum::<f64>() * width / 3.0
}

#[test]
fn edge_and_corner_match_quadrature() {
    for (a, b) in [(0.1_f64, 0.2_f64), (0.5, 0.5), (0.9, 0.1), (0.0, 0.3)] {
        // Substituting x = top - t^2 takes the root's infinite slope away at the end of the range.
        let top = (1.0 - b * b).sqrt();
        let segment = |x: f64| {
            let r = (1.0 - x * x).max(0.0).sqrt();
            if r <= b { 0.0 } else { r * r * (b / r).acos() - b * (r * r - b * b).sqrt() }
        };
        let numeric = simpson(0.0, (top - a).sqrt(), |t| 2.0 * t * segment(top - t * t));
        assert_abs_diff_eq!(quadrant(a, b), numeric, epsilon = 1e-9);
        assert_abs_diff_eq!(quadrant(b, a), quadrant(a, b), epsilon = 1e-14);
    }
    for (a, b, c) in [(0.1_f64, 0.2_f64, 0.3_f64), (0.5, 0.5, 0.5), (0.0, 0.0, 0.7), (0.05, 0.9, 0.1)] {
        let top = (1.0 - b * b - c * c).sqrt();
        let cut_disc = |x: f64| {
            let r2 = (1.0 - x * x).max(0.0);
            if r2 <= b * b + c * c {
                return 0.0;
            }
            let (y, z) = ((r2 - c * c).sqrt(), (r2 - b * b).sqrt());
            let arc = z.atan2(b) - c.atan2(y);
            0.5 * (r2 * arc - b * (z - c) - c * (y - b))
        };
        let numeric = simpson(0.0, (top - a).sqrt(), |t| 2.0 * t * cut_disc(top - t * t));
        assert_abs_diff_eq!(octant(a, b, c), numeric, epsilon = 1e-9);
    }
}

#[test]
fn monte_carlo_agrees() {
    let mut state = 11_u64;
    let mut uniform = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    for _ in 0..20 {
        let corner: [[f64; 2]; 3] = std::array::from_fn(|_| {
            let (a, b) = (2.4 * uniform() - 1.2, 2.4 * uniform() - 1.2);
            [a.min(b), a.max(b)]
        });
        let points = 200_000;
        let hits = (0..points).filter(|_| {
            let p: [f64; 3] = std::array::from_fn(|i| corner[i][0] + uniform() * (corner[i][1] - corner[i][0]));
            p.iter().map(|x| x * x).sum::<f64>() < 1.0
        });
        let size: f64 = corner.iter().map(|[a, b]| b - a).product();
        let estimate = size * hits.count() as f64 / f64::from(points);
        let exact = unit(corner.map(|c| c[0]), corner.map(|c| c[1]));
        assert_abs_diff_eq!(exact, estimate, epsilon = 5.0 * size * 0.5 / f64::from(points).sqrt());
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn boxes_of_a_partition_sum_to_the_sphere(
        centre in prop::array::uniform3(-1.0..1.0_f64),
        radius in 0.1..2.0_f64,
        cuts in prop::array::uniform3(prop::collection::vec(-3.5..3.5_f64, 0..4)),
    ) {
        let lines = cuts.map(|mut cuts| {
            cuts.extend([-4.0, 4.0]);
            cuts.sort_by(f64::total_cmp);
            cuts
        });
        let mut sum = 0.0;
        for x in lines[0].windows(2) {
            for y in lines[1].windows(2) {
                for z in lines[2].windows(2) {
                    sum += sphere_in_box(centre, radius, [x[0], y[0], z[0]], [x[1], y[1], z[1]]);
                }
            }
        }
        prop_assert!((sum - sphere(radius)).abs() < 1e-12 * sphere(radius).max(1.0));
    }

    #[test]
    fn a_field_keeps_the_volume(x in -0.5..0.5_f64, y in -0.5..0.5_f64, radius in 0.02..0.4_f64) {
        let mut field = Field::new([-1.0; 2], [1.0; 2], 0.1, 10_000).unwrap();
        field.add_spheres(&[([x, y], radius)], 1.0);
        prop_assert!((field.values.iter().sum::<f64>() - sphere(radius)).abs() < 1e-12);
        prop_assert!(field.values.iter().all(|value| *value > -1e-14));
        // Each cell is the same volume as that of a box without ends.
        for row in 0..20_isize {
            for column in 0..20_isize {
                let [u, v] = field.centre(column, row);
                let exact =
                    sphere_in_box([x, y, 0.0], radius, [u - 0.05, v - 0.05, -FAR], [u + 0.05, v + 0.05, FAR]);
                prop_assert!((field.get(column, row) - exact).abs() < 1e-13);
            }
        }
    }
}
