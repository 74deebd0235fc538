//! Contours, lines and walls: the geometry that measures stand on.

use approx::assert_abs_diff_eq;
use makadam::snapshot::{DrivenWall, Snapshot};
use makadam_frames::plan::MeasuredScene;
use makadam_measure::observables::contour::{Loop, area, contours, crosses, outline, segments, squared_distance};
use makadam_measure::observables::field::Field;
use makadam_measure::observables::line::{Line, clip};
use makadam_measure::observables::walls::PlacedWalls;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// A field whose value at the centre of each cell is given.
fn field(value: impl Fn(f64, f64) -> f64) -> Field {
    let mut field = Field::new([-1.0; 2], [1.0; 2], 0.05, 10_000).unwrap();
    for row in 0..field.rows {
        for column in 0..field.columns {
            let [x, y] = field.centre(column as isize, row as isize);
            field.values[row * field.columns + column] = value(x, y);
        }
    }
    field
}

/// Returns true if a closed line encloses a point.
fn encloses(line: &Loop, point: [f64; 2]) -> bool {
    segments(line).filter(|segment| crosses(*segment, point)).count() % 2 == 1
}

#[test]
fn contour_of_a_hill_is_a_circle() {
    let hill = field(|x, y| 1.0 - x.hypot(y));
    let lines = contours(&hill, 0.5);
    assert_eq!(lines.len(), 1);
    for point in &lines[0] {
        assert_abs_diff_eq!(point[0].hypot(point[1]), 0.5, epsilon = 2e-3);
    }
    assert_abs_diff_eq!(area(&lines[0]), PI * 0.25, epsilon = 5e-3);
    assert!(encloses(&lines[0], [0.3, 0.3]) && !encloses(&lines[0], [0.4, 0.4]));
}

#[test]
fn outline_is_the_largest_of_the_closed_lines() {
    // Two hills, one with a hole; the contour of a field that is high at its rim is closed there.
    let hills = field(|x, y| {
        let (near, far) = ((x + 0.4).hypot(y), (x - 0.7).hypot(y - 0.7));
        if near < 0.1 || (near > 0.4 && far > 0.15) { 0.0 } else { 1.0 }
    });
    assert_eq!(contours(&hills, 0.5).len(), 3);
    let line = outline(&hills, 0.5).expect("a line");
    assert!(encloses(&line, [-0.4, 0.0]) && !encloses(&line, [0.7, 0.7]));
    assert_abs_diff_eq!(area(&line), PI * 0.16, epsilon = 0.02);
    let full = field(|_, _| 1.0);
    assert_abs_diff_eq!(area(&outline(&full, 0.5).expect("a line")), 4.0, epsilon = 0.03);
    assert!(outline(&field(|_, _| 0.0), 0.5).is_none());
}

#[test]
fn saddles_are_joined_by_their_mean() {
    for (middle, lines) in [(0.2, 2), (0.8, 1)] {
        let mut saddle = Field::new([0.0; 2], [2.0; 2], 1.0, 10_000).unwrap();
        saddle.values = vec![1.0, 2.0 * middle - 1.0, 2.0 * middle - 1.0, 1.0];
        assert_eq!(contours(&saddle, 0.5).len(), if middle < 0.5 { lines } else { 1 });
    }
}

#[test]
fn smoothing_keeps_the_sum() {
    let mut bump = field(|x, y| if x.hypot(y) < 0.3 { 1.0 + x } else { 0.0 });
    let before: f64 = bump.values.iter().sum();
    bump.smooth();
    assert_abs_diff_eq!(bump.values.iter().sum::<f64>(), before, epsilon = 1e-10);
}

#[test]
fn line_through_pieces_of_a_line() {
    for degrees in [-80.0_f64, -30.0, 0.0, 45.0, 89.0] {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        let at = |s: f64| [0.3 + s * cosine, -0.2 + s * sine];
        let line = Line::fit([[at(0.0), at(1.0)], [at(5.0), at(5.5)]].into_iter()).expect("two pieces");
        assert_abs_diff_eq!(line.degrees(), degrees, epsilon = 1e-9);
        assert_abs_diff_eq!(line.above(at(7.0)), 0.0, epsilon = 1e-12);
        assert_abs_diff_eq!(line.above([0.3 - sine, -0.2 + cosine]), 1.0, epsilon = 1e-12);
    }
    assert!(Line::fit(std::iter::empty()).is_none());
}

#[test]
fn clipping_keeps_the_part_inside() {
    let piece = [[0.0, 0.0], [2.0, 4.0]];
    assert_eq!(clip(piece, |p| p[0], 0.5, 1.0), Some([[0.5, 1.0], [1.0, 2.0]]));
    assert_eq!(clip(piece, |p| p[1], -1.0, 9.0), Some(piece));
    assert_eq!(clip(piece, |p| p[1], 5.0, 9.0), None);
    let square = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let nearest = segments(&square).map(|side| squared_distance(&side, [0.5, 0.2])).fold(1.0, f64::min);
    assert_abs_diff_eq!(nearest, 0.04, epsilon = 1e-15);
}

#[test]
fn walls_are_where_their_motion_has_brought_them() {
    let text = r#"
name = "walls"
description = "walls that move"
duration = 10.0
domain = { min = [-1.0, -1.0, -1.0], max = [1.0, 1.0, 1.0] }
[material.steel]
density = 7800.0
youngs_modulus = 1e7
poisson_ratio = 0.3
friction = 0.5
restitution = 0.3
[[wall]]
name = "tube"
material = "steel"
shape = { kind = "cylinder", base = [0.0, 0.0, 0.0], axis = [0.0, 0.0, 1.0], radius = 0.1, length = 0.2 }
motion = { kind = "translating", velocity = [0.0, 0.0, 0.1], start = 1.0, stop = 3.0 }
[[wall]]
name = "flap"
material = "steel"
shape = { kind = "plane", point = [0.5, 0.0, 0.0], normal = [-1.0, 0.0, 0.0] }
motion = { kind = "rotating", point = [0.0, 0.0, 0.0], axis = [0.0, 0.0, 1.0], rate = 1.5707963267948966, start = 2.0 }
[[wall]]
name = "lid"
material = "steel"
shape = { kind = "plane", point = [0.0, 0.0, 9.0], normal = [0.0, 0.0, -1.0] }
motion = { kind = "force-driven", axis = [0.0, 0.0, -2.0], force = 1.0, mass = 1.0 }
[[wall]]
name = "door"
material = "steel"
shape = { kind = "plane", point = [-9.0, 0.0, 0.0], normal = [1.0, 0.0, 0.0] }
motion = { kind = "torque-driven", point = [0.0, 0.0, 0.0], axis = [0.0, 0.0, 1.0], torque = 1.0, moment_of_inertia = 1.0 }
"#;
    let scene = MeasuredScene::parse(text).expect("a valid scene");
    let at = |time: f64| PlacedWalls::at(&scene, &Snapshot { time, ..Snapshot::default() });
    let distance = |time: f64, point: [f64; 3]| at(time).distance(&Vector3::from(point));
    assert_abs_diff_eq!(distance(0.0, [0.07, 0.0, 0.05]), 0.03, epsilon = 1e-12);
    // Lifted by 0.2 m: the point lies 0.15 m below the rim and 0.03 m inside.
    assert_abs_diff_eq!(distance(5.0, [0.07, 0.0, 0.05]), 0.15_f64.hypot(0.03), epsilon = 1e-12);
    assert_abs_diff_eq!(distance(2.0, [0.45, 0.0, 0.1]), 0.05, epsilon = 1e-12);
    // A quarter turn later the plane stands at y = 0.5.
    assert_abs_diff_eq!(distance(3.0, [0.0, 0.48, 0.1]), 0.02, epsilon = 1e-12);
    assert_abs_diff_eq!(distance(3.0, [0.0, 0.51, 0.1]), -0.01, epsilon = 1e-12);
    // Driven walls are where the frame says: the lid 4 m lower, the door a quarter turn on at y = -9.
    let driven = |wall: u32, displacement: f64| DrivenWall { wall, displacement, rate: 0.0 };
    let driven_walls = vec![driven(2, 4.0), driven(3, std::f64::consts::FRAC_PI_2)];
    let frame = Snapshot { driven_walls, ..Snapshot::default() };
    let distance = |point: [f64; 3]| PlacedWalls::at(&scene, &frame).distance(&Vector3::from(point));
    assert_abs_diff_eq!(distance([0.0, 0.0, 4.9]), 0.1, epsilon = 1e-12);
    assert_abs_diff_eq!(distance([0.0, -8.8, 0.0]), 0.2, epsilon = 1e-12);
    assert_eq!(at(0.0).within(&Vector3::new(0.07, 0.0, 0.05), 0.031), 1);
}
