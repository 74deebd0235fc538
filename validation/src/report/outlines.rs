//! Outlines of the walls in a picture, and the arrow of a drum's rotation.

use crate::draw::numbers::compact;
use crate::draw::svg::{Anchor, Drawing};
use crate::draw::view::View;
use crate::plan::Scene;
use makadam::scene::{Motion, Shape};
use makadam::wall::PlacedWalls;
use nalgebra::Vector3;

/// From metres on the picture's plane to the drawing.
pub(super) type Place<'a> = &'a dyn Fn([f64; 2]) -> [f64; 2];

/// Draws all walls as they stand at a time, but those that a force or a torque drives: states do not tell where these are.
pub(super) fn walls(drawing: &mut Drawing, scene: &Scene, view: &View, time: f64, scale: f64, place: Place<'_>) {
    let placed = PlacedWalls::at(&scene.wall, &scene.domain, time, &[]);
    for (number, wall) in scene.wall.iter().enumerate().filter(|(_, wall)| !wall.motion.is_driven()) {
        // What turns is drawn as the scene places it: turning mostly maps it onto itself.
        let turns = matches!(wall.motion, Motion::Rotating { .. });
        let at = |point: &[f64; 3]| match Vector3::from(*point) {
            point if turns => point,
            point => placed.point_of(number, &point),
        };
        match &wall.shape {
            Shape::Plane { point, normal } => {
                plane(drawing, view, at(point), Vector3::from(*normal).normalize(), place)
            }
            Shape::Box { min, max, open } => box_sides(drawing, view, at(min), at(max), open, place),
            Shape::Cylinder { base, axis, radius, length } => {
                let axis = Vector3::from(*axis).normalize();
                let cylinder = Cylinder { base: at(base), axis, radius: *radius, length: *length };
                tube(drawing, view, &cylinder, scale, place);
                if let Motion::Rotating { axis: turning, rate, .. } = &wall.motion {
                    let about = Vector3::from(*turning).normalize() * *rate;
                    rotation(drawing, view, at(base), about, *radius, place);
                }
            }
            Shape::Spheres { centres, radius } => {
                for centre in centres {
                    drawing.circle("wall", place(flat(view, at(centre))), radius * scale);
                }
            }
            // Edge on, a disc is a line; face on, it coincides with the shell that it closes.
            Shape::Disc { centre, normal, radius, hole } => {
                let normal = Vector3::from(*normal).normalize();
                if normal.dot(&view.forward).abs() < 0.05 {
                    let along = normal.cross(&view.forward);
                    for side in [-along, along] {
                        segment(drawing, view, at(centre) + side * *hole, at(centre) + side * *radius, place);
                    }
                }
            }
        }
    }
}

fn flat(view: &View, point: Vector3<f64>) -> [f64; 2] {
    let [x, y, _] = view.project(&point.into());
    [x, y]
}

fn segment(drawing: &mut Drawing, view: &View, from: Vector3<f64>, to: Vector3<f64>, place: Place<'_>) {
    drawing.line("wall", place(flat(view, from)), place(flat(view, to)));
}

fn plane(drawing: &mut Drawing, view: &View, point: Vector3<f64>, normal: Vector3<f64>, place: Place<'_>) {
    if normal.dot(&view.forward).abs() < 0.05 {
        // Far beyond any frame; the drawing cuts it off.
        let along = normal.cross(&view.forward) * 100.0;
        segment(drawing, view, point - along, point + along, place);
    }
}

fn box_sides(
    drawing: &mut Drawing,
    view: &View,
    min: Vector3<f64>,
    max: Vector3<f64>,
    open: &[String],
    place: Place<'_>,
) {
    let middle = (min + max) / 2.0;
    let half = (max - min) / 2.0;
    for k in 0..3 {
        for (sign, name) in [(-1.0, "-"), (1.0, "+")] {
            let face = format!("{name}{}", ["x", "y", "z"][k]);
            let mut normal = Vector3::zeros();
            normal[k] = sign;
            // Only faces seen edge on have an outline of their own.
            if open.contains(&face) || normal.dot(&view.forward).abs() > 0.05 {
                continue;
            }
            let along = normal.cross(&view.forward);
            let reach = along.abs().dot(&half);
            let centre = middle + normal * half[k];
            segment(drawing, view, centre - along * reach, centre + along * reach, place);
        }
    }
}

/// A cylinder's mantle; the axis is a unit vector.
struct Cylinder {
    base: Vector3<f64>,
    axis: Vector3<f64>,
    radius: f64,
    length: f64,
}

fn tube(drawing: &mut Drawing, view: &View, cylinder: &Cylinder, scale: f64, place: Place<'_>) {
    let Cylinder { base, axis, radius, length } = *cylinder;
    if axis.dot(&view.forward).abs() > 0.99 {
        drawing.circle("wall", place(flat(view, base)), radius * scale);
        return;
    }
    let side = axis.cross(&view.forward).normalize() * radius;
    for side in [side, -side] {
        segment(drawing, view, base + side, base + side + axis * length, place);
    }
    for end in [base, base + axis * length] {
        drawing.line("wall faint", place(flat(view, end - side)), place(flat(view, end + side)));
    }
}

/// An arrow outside the shell, in the sense in which it turns; only where the drum is seen along its axis.
fn rotation(
    drawing: &mut Drawing,
    view: &View,
    base: Vector3<f64>,
    about: Vector3<f64>,
    radius: f64,
    place: Place<'_>,
) {
    let rate = about.norm();
    if rate == 0.0 || about.dot(&view.forward).abs() < 0.99 * rate {
        return;
    }
    let clockwise = about.dot(&view.forward) > 0.0;
    let centre = flat(view, base);
    let at = |angle: f64, r: f64| place([centre[0] + r * angle.cos(), centre[1] + r * angle.sin()]);
    let (from, to) = if clockwise { (2.2, 1.25) } else { (0.95, 1.9) };
    let arc = 1.07 * radius;
    let steps = 24;
    drawing.curve("arrow", (0..=steps).map(|k| at(from + (to - from) * f64::from(k) / f64::from(steps), arc)));
    let turn = (to - from).signum() * 0.07;
    drawing.polygon("arrowhead", &[at(to + turn, arc), at(to, 1.035 * radius), at(to, 1.105 * radius)]);
    let label = at(if clockwise { 1.0 } else { 2.14 }, 1.1 * radius);
    let anchor = if clockwise { Anchor::Start } else { Anchor::End };
    drawing.text("tick", label, anchor, &format!("{} rad/s", compact(rate)));
}
