//! Where a picture is taken from: a parallel projection, what of the scene it frames, and which grains it shows.

use crate::plan::Scene;
use makadam::scene::{Motion, Shape};
use makadam::snapshot::Particle;
use nalgebra::Vector3;

/// A parallel projection.
#[derive(Clone, Debug)]
pub(crate) struct View {
    /// What the caption calls it.
    pub(crate) name: &'static str,
    /// Direction to the right of the picture.
    pub(crate) right: Vector3<f64>,
    /// Direction to the top of the picture.
    pub(crate) up: Vector3<f64>,
    /// Direction away from the viewer.
    pub(crate) forward: Vector3<f64>,
}

impl View {
    fn new(name: &'static str, forward: Vector3<f64>, up: Vector3<f64>) -> View {
        View { name, right: forward.cross(&up), up, forward }
    }

    /// A point on the picture's plane, and its depth.
    pub(crate) fn project(&self, point: &[f64; 3]) -> [f64; 3] {
        let point = Vector3::from(*point);
        [point.dot(&self.right), point.dot(&self.up), point.dot(&self.forward)]
    }
}

/// The two views of a scene: along and across the axis of a turning drum; otherwise from the front and from above.
pub(crate) fn views(scene: &Scene) -> [View; 2] {
    let up = -Vector3::from(scene.gravity);
    let up = if up.norm() > 0.0 { up.normalize() } else { Vector3::z() };
    // Along y, unless gravity points that way.
    let level = if up.y.abs() < 0.9 { Vector3::y() } else { Vector3::x() };
    let front = (level - up * up.dot(&level)).normalize();
    match drum_axis(scene, &up) {
        Some(axis) => {
            // The side from which the free surface slopes towards the viewer: bed and shell climb on the far side.
            let across = up.cross(&axis);
            [View::new("along the axis", axis, up), View::new("from the side", across, up)]
        }
        None => [View::new("from the front", front, up), View::new("from above", -up, front)],
    }
}

/// Direction of the axis of a cylinder that turns about a level axis, so that it turns clockwise when seen along it.
fn drum_axis(scene: &Scene, up: &Vector3<f64>) -> Option<Vector3<f64>> {
    scene.wall.iter().find_map(|wall| match (&wall.shape, &wall.motion) {
        (Shape::Cylinder { .. }, Motion::Rotating { axis, rate, .. }) => {
            let axis = Vector3::from(*axis).normalize() * if *rate < 0.0 { -1.0 } else { 1.0 };
            (axis.dot(up).abs() < 0.3).then_some(axis)
        }
        _ => None,
    })
}

/// The rectangle of the picture's plane that is shown, metres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    pub(crate) min: [f64; 2],
    pub(crate) max: [f64; 2],
}

impl Frame {
    /// The grains of all codes but stray ones, and a turning drum whole.
    pub(crate) fn of<'a>(view: &View, scene: &Scene, grains: impl Iterator<Item = &'a Particle>) -> Option<Frame> {
        let mut across = [Vec::new(), Vec::new()];
        let mut radius: f64 = 0.0;
        for grain in grains {
            let p = view.project(&grain.position);
            if p.iter().all(|v| v.is_finite()) {
                across[0].push(p[0]);
                across[1].push(p[1]);
                radius = radius.max(grain.radius);
            }
        }
        if across[0].is_empty() {
            return None;
        }
        let mut frame = Frame { min: [0.0; 2], max: [0.0; 2] };
        for (k, places) in across.iter_mut().enumerate() {
            places.sort_by(f64::total_cmp);
            // A single grain that rolled away must not shrink the rest.
            let strays = places.len() / 400;
            frame.min[k] = places[strays] - 3.0 * radius;
            frame.max[k] = places[places.len() - 1 - strays] + 3.0 * radius;
        }
        for wall in &scene.wall {
            if let (Shape::Cylinder { base, axis, radius, length }, Motion::Rotating { .. }) =
                (&wall.shape, &wall.motion)
            {
                frame.include_cylinder(view, base, axis, *radius, *length);
            }
        }
        Some(frame)
    }

    fn include_cylinder(&mut self, view: &View, base: &[f64; 3], axis: &[f64; 3], radius: f64, length: f64) {
        let axis = Vector3::from(*axis).normalize();
        // Room for the arrow of rotation where the drum is seen along its axis.
        let room = if axis.dot(&view.forward).abs() > 0.99 { 1.14 * radius } else { 1.04 * radius };
        for end in [Vector3::from(*base), Vector3::from(*base) + axis * length] {
            let p = view.project(&end.into());
            for (k, direction) in [&view.right, &view.up].into_iter().enumerate() {
                let half = room * (1.0 - axis.dot(direction).powi(2)).max(0.0).sqrt() + 0.04 * radius;
                self.min[k] = self.min[k].min(p[k] - half);
                self.max[k] = self.max[k].max(p[k] + half);
            }
        }
    }

    pub(crate) fn width(&self) -> f64 {
        self.max[0] - self.min[0]
    }

    pub(crate) fn height(&self) -> f64 {
        self.max[1] - self.min[1]
    }
}

/// A grain on the picture's plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spot {
    pub(crate) centre: [f64; 2],
    pub(crate) radius: f64,
    /// 0 for the foremost grain of the picture, 1 for the hindmost.
    pub(crate) depth: f64,
    pub(crate) speed: f64,
}

/// Pixels of the visibility test over a mean radius: a grain that shows less than this is not drawn.
const PIXELS_A_RADIUS: f64 = 5.0;
const MOST_PIXELS: f64 = 1500.0;

/// The grains of which something is seen, the hindmost first, and how many lie outside the frame.
///
/// Most grains of a bed are hidden behind others. They are left out, which keeps a report small: a coarse image is
/// filled from front to back, and a grain stays if it fills a pixel.
pub(crate) fn visible(view: &View, frame: &Frame, particles: &[Particle]) -> (Vec<Spot>, usize) {
    let mut spots: Vec<Spot> = particles
        .iter()
        .filter(|p| p.position.iter().chain(&p.velocity).all(|v| v.is_finite()))
        .map(|p| {
            let [x, y, depth] = view.project(&p.position);
            Spot { centre: [x, y], radius: p.radius, depth, speed: Vector3::from(p.velocity).norm() }
        })
        .collect();
    let all = spots.len();
    spots.retain(|s| (0..2).all(|k| s.centre[k] + s.radius > frame.min[k] && s.centre[k] - s.radius < frame.max[k]));
    let outside = all - spots.len();
    if spots.is_empty() {
        return (spots, outside);
    }
    spots.sort_by(|a, b| a.depth.total_cmp(&b.depth));

    let radius = spots.iter().map(|s| s.radius).sum::<f64>() / spots.len() as f64;
    let pixel = (radius / PIXELS_A_RADIUS).max(frame.width().max(frame.height()) / MOST_PIXELS);
    let (columns, lines) = ((frame.width() / pixel).ceil() as usize + 1, (frame.height() / pixel).ceil() as usize + 1);
    let mut filled = vec![false; columns * lines];
    spots.retain(|spot| fill(spot, frame, pixel, columns, lines, &mut filled));

    let (front, back) = (spots[0].depth, spots[spots.len() - 1].depth);
    for spot in &mut spots {
        spot.depth = (spot.depth - front) / (back - front).max(f64::MIN_POSITIVE);
    }
    spots.reverse();
    (spots, outside)
}

/// Fills the free pixels of a grain; whether there were any.
fn fill(spot: &Spot, frame: &Frame, pixel: f64, columns: usize, lines: usize, filled: &mut [bool]) -> bool {
    let centre = [(spot.centre[0] - frame.min[0]) / pixel, (spot.centre[1] - frame.min[1]) / pixel];
    let radius = spot.radius / pixel;
    let span = |k: usize, most: usize| {
        let low = (centre[k] - radius).floor().max(0.0) as usize;
        low..((centre[k] + radius).ceil().max(0.0) as usize + 1).min(most)
    };
    let mut seen = false;
    for line in span(1, lines) {
        for column in span(0, columns) {
            let (dx, dy) = (column as f64 + 0.5 - centre[0], line as f64 + 0.5 - centre[1]);
            if dx * dx + dy * dy <= radius * radius {
                let place = &mut filled[line * columns + column];
                seen |= !*place;
                *place = true;
            }
        }
    }
    seen
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grain(position: [f64; 3]) -> Particle {
        Particle { id: 0, position, radius: 1.0, velocity: [0.0; 3], spin: [0.0; 3] }
    }

    #[test]
    fn a_hidden_grain_is_left_out_and_the_hindmost_comes_first() {
        let view = View::new("front", Vector3::y(), Vector3::z());
        let frame = Frame { min: [-5.0, -5.0], max: [5.0, 5.0] };
        let particles =
            [grain([0.0, 0.0, 0.0]), grain([0.0, 3.0, 0.0]), grain([1.5, 4.0, 0.0]), grain([90.0, 0.0, 0.0])];
        let (spots, outside) = visible(&view, &frame, &particles);
        assert_eq!(outside, 1);
        assert_eq!(spots.iter().map(|s| s.centre[0]).collect::<Vec<_>>(), [1.5, 0.0]);
        assert_eq!(spots[0].depth, 1.0);
    }

    #[test]
    fn right_is_right_seen_from_the_front() {
        let view = View::new("front", Vector3::y(), Vector3::z());
        assert_eq!(view.right, Vector3::x());
    }
}
