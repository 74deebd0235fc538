//! Perspective camera of a picture, and its distance.

use makadam_frames::run_frames::{RunFrame, Walls};
use nalgebra::Vector3;
use serde::Serialize;

type Vector = Vector3<f64>;

/// Angle between the upper and the lower edge of a picture, rad.
const OPENING: f64 = 0.42;

/// Largest fraction of the picture that the subject fills.
const FILLED: f64 = 0.94;

/// Fraction of the grains on either side of each axis that may be ignored as strays.
const STRAYS: f64 = 0.0025;

/// Extension of the subject beyond the grains to include walls, over the size of the bed.
const AROUND: f64 = 0.35;

/// View direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum View {
    /// Along a rotating drum and slightly from above, or across a corner.
    Natural,
    /// Degrees to the right of the front and above it; the front is level, along the axis of a drum or along y.
    Angles([f64; 2]),
}

/// Camera with perspective.
#[derive(Clone, Debug)]
pub struct Camera {
    eye: Vector,
    right: Vector,
    up: Vector,
    forward: Vector,
    /// Pixels per unit of tangent.
    focal: f64,
    /// Centre pixel, on the optical axis.
    middle: [f64; 2],
}

/// Subject of a picture.
#[derive(Clone, Debug)]
pub struct Subject {
    points: Vec<(Vector, f64)>,
}

impl Subject {
    /// Returns the subject of frames: the grains except stray ones, and the walls about them. Grains far beyond the walls do not count, for
    /// example after the discharge of a silo into the open: then the walls are shown whole. With `all`, every grain counts.
    pub fn of<'a>(frames: impl Iterator<Item = &'a RunFrame>, all: bool) -> Subject {
        let mut points = Vec::new();
        for frame in frames {
            let each = frame.grains.positions.iter().zip(&frame.grains.radii);
            let each = each.map(|(position, radius)| (Vector::from(*position), *radius));
            let grains: Vec<(Vector, f64)> = match frame.walls.as_ref().and_then(neighbourhood).filter(|_| !all) {
                Some([low, high]) => each.filter(|(place, _)| *place >= low && *place <= high).collect(),
                None => each.collect(),
            };
            let count = frame.grains.positions.len();
            let fled = (count - grains.len()) as f64 > count as f64 * STRAYS;
            let sorted = |axis: usize| {
                let mut places: Vec<f64> = grains.iter().map(|(position, _)| position[axis]).collect();
                places.sort_by(f64::total_cmp);
                places
            };
            let strays = if all { 0 } else { (grains.len() as f64 * STRAYS) as usize };
            let bound = |place: usize| {
                let at = |axis: usize, _| sorted(axis).get(place).copied().unwrap_or(0.0);
                Vector::from_fn(at)
            };
            let last = grains.len().saturating_sub(1);
            let [low, high] = [bound(strays), bound(last - strays.min(last))];
            let is_inside = |point: &Vector, room: f64| {
                (0..3).all(|axis| (low[axis] - room..=high[axis] + room).contains(&point[axis]))
            };
            points.extend(grains.iter().copied().filter(|(point, _)| is_inside(point, 1e-9)));
            let room = AROUND * (high - low).norm();
            if let Some(walls) = &frame.walls {
                let turning = |wall: usize| walls.axes.get(wall).is_some_and(|axis| Vector::from(*axis).norm() > 0.5);
                for (corners, wall) in walls.triangles.iter().zip(&walls.wall) {
                    let corners = corners.map(|corner| Vector::from(walls.points[corner as usize]));
                    // A drum is shown whole; of other walls, the part about the grains.
                    let whole = fled || turning(*wall as usize);
                    points
                        .extend(corners.into_iter().filter(|point| whole || is_inside(point, room)).map(|p| (p, 0.0)));
                }
            }
        }
        Subject { points }
    }
}

/// Returns the ends of the box about walls and nearby grains, m; `None` without walls.
fn neighbourhood(walls: &Walls) -> Option<[Vector; 2]> {
    let corners = || walls.points.iter().map(|point| Vector::from(*point));
    let low = corners().reduce(|low, point| low.inf(&point))?;
    let high = corners().reduce(|high, point| high.sup(&point))?;
    let room = Vector::repeat(AROUND * (high - low).norm());
    Some([low - room, high + room])
}

/// Initial view of a page: directions, angles, distance.
#[derive(Clone, Debug, Serialize)]
pub struct Outlook {
    /// Unit vector against gravity.
    up: [f64; 3],
    /// Unit vector from the viewer at the front to the scene.
    front: [f64; 3],
    /// Angle to the right of the front, rad.
    azimuth: f64,
    /// Angle above the front, rad.
    elevation: f64,
    /// Target point of the view, m.
    target: [f64; 3],
    /// Distance of the eye from the target, m.
    away: f64,
    /// Half the size of the subject, m.
    size: f64,
    /// Angle between the upper and the lower edge of the view, rad.
    opening: f64,
}

impl Subject {
    /// Returns the initial view for a window of any shape.
    pub fn outlook(&self, frame: &RunFrame) -> Outlook {
        let (front, up, best) = natural(frame);
        let camera = Camera::looking_at(self, frame, View::Natural, [1000.0, 1000.0], 0.0);
        let count = self.points.len().max(1) as f64;
        let middle = self.points.iter().map(|(point, _)| point).sum::<Vector>() / count;
        let away = camera.forward.dot(&(middle - camera.eye));
        let target = camera.eye + camera.forward * away;
        let reach = |(point, radius): &(Vector, f64)| (point - target).norm() + radius;
        Outlook {
            up: up.into(),
            front: front.into(),
            azimuth: best[0].to_radians(),
            elevation: best[1].to_radians(),
            target: target.into(),
            away: 1.1 * away,
            size: self.points.iter().map(reach).fold(1e-9, f64::max),
            opening: OPENING,
        }
    }
}

/// Returns the upward vertical direction.
fn vertical(frame: &RunFrame) -> Vector {
    let up = -Vector::from(frame.gravity);
    if up.norm() > 0.0 { up.normalize() } else { Vector::z() }
}

/// Returns the direction of the axis of a wall with rotation about a level axis, such that the rotation is clockwise seen along it.
fn level_axis(walls: Option<&Walls>, up: &Vector) -> Option<Vector> {
    let axes = walls?.axes.iter().map(|axis| Vector::from(*axis));
    axes.into_iter().find(|axis| axis.norm() > 0.5 && axis.dot(up).abs() < 0.3)
}

/// Returns the directions to the front and up, and the most informative azimuth and elevation.
fn natural(frame: &RunFrame) -> (Vector, Vector, [f64; 2]) {
    let up = vertical(frame);
    match level_axis(frame.walls.as_ref(), &up) {
        Some(axis) => ((axis - up * up.dot(&axis)).normalize(), up, [14.0, 9.0]),
        None => {
            // Along y, unless gravity is parallel to it.
            let level = if up.y.abs() < 0.9 { Vector::y() } else { Vector::x() };
            ((level - up * up.dot(&level)).normalize(), up, [28.0, 20.0])
        }
    }
}

impl Camera {
    /// Makes a camera that shows a subject, for pictures of a size (pixels) with a free strip on the right.
    pub fn looking_at(
        subject: &Subject,
        frame: &RunFrame,
        view: View,
        [width, height]: [f64; 2],
        strip: f64,
    ) -> Camera {
        let (front, up, best) = natural(frame);
        let [azimuth, elevation] = match view {
            View::Natural => best,
            View::Angles(angles) => angles,
        }
        .map(f64::to_radians);
        let beside = front.cross(&up);
        let level = front * azimuth.cos() - beside * azimuth.sin();
        let forward = level * elevation.cos() - up * elevation.sin();
        let top = level * elevation.sin() + up * elevation.cos();
        let right = forward.cross(&top);
        let focal = 0.5 * height / (0.5 * OPENING).tan();
        let room = [0.5 * (width - strip), 0.5 * height].map(|half| FILLED * half / focal);
        let mut camera = Camera {
            eye: Vector::zeros(),
            right,
            up: top,
            forward,
            focal,
            middle: [0.5 * (width - strip), 0.5 * height],
        };
        let count = subject.points.len().max(1) as f64;
        let mut target = subject.points.iter().map(|(point, _)| point).sum::<Vector>() / count;
        let size = subject.points.iter().map(|(point, radius)| (point - target).norm() + radius).fold(1e-9, f64::max);
        // Two iterations would suffice: the middle shifts with perspective.
        for _ in 0..6 {
            let seen = |point: &Vector| {
                let arm = point - target;
                [arm.dot(&right), arm.dot(&top), arm.dot(&forward)]
            };
            let mut away = 0.05 * size;
            for (point, radius) in &subject.points {
                let [x, y, depth] = seen(point);
                let reach = |offset: f64, room: f64| (offset.abs() + 1.05 * radius) / room - depth;
                away = away.max(reach(x, room[0])).max(reach(y, room[1])).max(2.0 * radius - depth);
            }
            camera.eye = target - forward * away;
            let mut edges = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
            for (point, radius) in &subject.points {
                let [x, y, depth] = seen(point);
                for (edge, offset) in edges.iter_mut().zip([x, y]) {
                    let near = depth + away;
                    *edge = [edge[0].min((offset - radius) / near), edge[1].max((offset + radius) / near)];
                }
            }
            if subject.points.is_empty() {
                break;
            }
            let [x, y] = edges.map(|[low, high]| 0.5 * (low + high) * away);
            target += right * x + top * y;
        }
        camera
    }

    /// Returns the position on the picture (pixels to the right and down) and the distance along the line of sight (m) of a point (m).
    pub fn project(&self, point: &[f64; 3]) -> [f64; 3] {
        let arm = Vector::from(*point) - self.eye;
        let depth = arm.dot(&self.forward);
        let scale = self.focal / depth.max(1e-12);
        [self.middle[0] + arm.dot(&self.right) * scale, self.middle[1] - arm.dot(&self.up) * scale, depth]
    }

    /// Returns the size of a length (m) at a distance (m), in pixels.
    pub fn pixels(&self, length: f64, depth: f64) -> f64 {
        self.focal * length / depth
    }

    /// Returns the point at a distance along the line of sight (m) for a position on the picture: to the right of the eye, below it, before it.
    pub(super) fn seen_at(&self, x: f64, y: f64, depth: f64) -> [f64; 3] {
        let share = depth / self.focal;
        [(x - self.middle[0]) * share, (y - self.middle[1]) * share, depth]
    }

    /// Returns a direction in the coordinates of [`Camera::seen_at`].
    pub(super) fn turned(&self, direction: &Vector) -> [f64; 3] {
        [direction.dot(&self.right), -direction.dot(&self.up), direction.dot(&self.forward)]
    }

    /// Returns the vector from the eye through a position on the picture, with a component of one along the line of sight.
    pub(super) fn ray(&self, x: f64, y: f64) -> Vector {
        self.forward + (self.right * (x - self.middle[0]) - self.up * (y - self.middle[1])) / self.focal
    }

    pub(super) fn eye(&self) -> &Vector {
        &self.eye
    }

    /// Returns the unit vector towards the light: over the left shoulder.
    pub(super) fn light(&self) -> Vector {
        (self.up * 0.75 - self.right * 0.45 - self.forward * 0.65).normalize()
    }

    /// Returns the camera for a picture larger by a factor.
    pub(super) fn enlarged(&self, factor: f64) -> Camera {
        Camera { focal: factor * self.focal, middle: self.middle.map(|place| factor * place), ..self.clone() }
    }
}

impl std::str::FromStr for View {
    type Err = String;

    fn from_str(text: &str) -> Result<View, String> {
        let angles = || {
            let (azimuth, elevation) = text.split_once(',')?;
            let angle = |text: &str| text.trim().parse::<f64>().ok().filter(|angle| angle.abs() <= 360.0);
            Some(View::Angles([angle(azimuth)?, angle(elevation)?]))
        };
        match text {
            "natural" => Ok(View::Natural),
            "front" => Ok(View::Angles([0.0, 0.0])),
            "side" => Ok(View::Angles([90.0, 0.0])),
            "top" => Ok(View::Angles([0.0, 90.0])),
            _ => angles().ok_or_else(|| {
                format!("'{text}' is no view: give natural, front, side, top, or AZIMUTH,ELEVATION in degrees, such as 30,20")
            }),
        }
    }
}

/// Clipping plane, with everything in front of it hidden.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    /// Axis, 0 to 2.
    pub axis: usize,
    /// Position of the plane on the axis, m.
    pub at: f64,
}

impl std::str::FromStr for Cut {
    type Err = String;

    fn from_str(text: &str) -> Result<Cut, String> {
        let cut = || {
            let (axis, at) = text.split_once('=')?;
            let axis = ["x", "y", "z"].iter().position(|name| *name == axis.trim())?;
            let at = at.trim().parse::<f64>().ok().filter(|at| at.is_finite())?;
            Some(Cut { axis, at })
        };
        cut().ok_or_else(|| format!("'{text}' is no clipping plane: give an axis and a place in m, such as y=0.02"))
    }
}

impl Cut {
    /// Returns the unit normal towards the removed side, the side of an eye, and the position of the plane along it, m.
    pub(super) fn plane(self, eye: &Vector) -> (Vector, f64) {
        let side = if eye[self.axis] >= self.at { 1.0 } else { -1.0 };
        (Vector::ith(self.axis, side), side * self.at)
    }
}
