//! Visible surface of each pixel: the foremost grain, or the foremost opaque wall.

use super::Sight;
use super::camera::Camera;
use makadam_frames::interrupt;
use nalgebra::Vector3;
use rayon::prelude::*;

type Vector = Vector3<f64>;

/// Lines of a picture per task.
const BAND: usize = 32;

/// Visible surface of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pixel {
    /// Distance along the line of sight, m; infinite for the background.
    pub depth: f32,
    /// Unit normal of the surface, towards the viewer.
    pub normal: [f32; 3],
    /// Number of the grain; [`WALL`] for a wall.
    pub what: u32,
}

/// Grain number of walls.
pub(super) const WALL: u32 = u32::MAX;

const NOTHING: Pixel = Pixel { depth: f32::INFINITY, normal: [0.0; 3], what: WALL };

/// Pixels of a picture, line after line.
pub(super) struct Raster {
    pub width: usize,
    pub height: usize,
    pub pixels: Vec<Pixel>,
}

/// Triangle on the picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flat {
    /// Corners: pixels to the right, pixels down, one over the distance.
    pub corners: [[f64; 3]; 3],
    /// Unit normal, towards the viewer.
    pub normal: Vector,
    /// Smallest and largest line.
    lines: [f64; 2],
}

/// Grain on the picture.
struct Disc {
    number: u32,
    centre: Vector,
    radius: f64,
    columns: [f64; 2],
    lines: [f64; 2],
}

/// Draws grains and opaque walls.
pub(super) fn draw(sight: &Sight<'_>, [width, height]: [usize; 2], walls: &[Flat]) -> Raster {
    let discs: Vec<Disc> = discs(sight);
    let mut pixels = vec![NOTHING; width * height];
    bands(&mut pixels, width, |first, pixels| {
        let lines = [first as f64, (first + pixels.len() / width) as f64];
        for disc in discs.iter().filter(|disc| disc.lines[1] >= lines[0] && disc.lines[0] <= lines[1]) {
            sphere(disc, sight, width, first, pixels);
        }
        for flat in walls.iter().filter(|flat| flat.lines[1] >= lines[0] && flat.lines[0] <= lines[1]) {
            flat.each_pixel(width, first, pixels.len() / width, |place, depth| {
                if (depth as f32) < pixels[place].depth {
                    pixels[place] =
                        Pixel { depth: depth as f32, normal: flat.normal.map(|n| n as f32).into(), what: WALL };
                }
            });
        }
    });
    Raster { width, height, pixels }
}

/// Fills a picture in parallel bands of lines, given their first line. After a stop request of the user, the remaining bands stay unchanged.
pub(super) fn bands<T: Send>(all: &mut [T], width: usize, fill: impl Fn(usize, &mut [T]) + Sync) {
    all.par_chunks_mut(BAND * width).enumerate().filter(|_| !interrupt::requested()).for_each(|(band, part)| {
        fill(band * BAND, part);
    });
}

fn discs(sight: &Sight<'_>) -> Vec<Disc> {
    let camera = sight.camera;
    let grains = sight.frame.grains.positions.iter().zip(&sight.frame.grains.radii);
    let seen = (0..).zip(grains).filter_map(|(number, (centre, &radius))| {
        let [x, y, depth] = camera.project(centre);
        let centre = Vector::from(*centre);
        let cut_away = sight.plane.is_some_and(|(normal, at)| normal.dot(&centre) - at > radius);
        if depth <= 1.01 * radius || cut_away {
            return None;
        }
        // Away from the middle, the image of a sphere is a slightly elongated ellipse.
        let reach = 1.15 * camera.pixels(radius, (depth * depth - radius * radius).sqrt()) + 1.0;
        Some(Disc { number, centre, radius, columns: [x - reach, x + reach], lines: [y - reach, y + reach] })
    });
    seen.collect()
}

fn sphere(disc: &Disc, sight: &Sight<'_>, width: usize, first: usize, pixels: &mut [Pixel]) {
    let camera = sight.camera;
    let arm = camera.eye() - disc.centre;
    let outside = arm.norm_squared() - disc.radius * disc.radius;
    for line in span(disc.lines, first, pixels.len() / width) {
        for column in span(disc.columns, 0, width) {
            let ray = camera.ray(column as f64 + 0.5, (first + line) as f64 + 0.5);
            let (square, along) = (ray.norm_squared(), ray.dot(&arm));
            let root = along * along - square * outside;
            if root < 0.0 {
                continue;
            }
            let [near, far] = [(-along - root.sqrt()) / square, (-along + root.sqrt()) / square];
            let mut seen = (near, (arm + ray * near) / disc.radius);
            if let Some((normal, at)) = sight.plane {
                let above = |share: f64| normal.dot(&(camera.eye() + ray * share)) - at;
                if above(near) > 0.0 {
                    let share = above(0.0) / -normal.dot(&ray);
                    if !(near..=far).contains(&share) {
                        continue;
                    }
                    seen = (share, normal);
                }
            }
            let pixel = &mut pixels[line * width + column];
            if (seen.0 as f32) < pixel.depth {
                *pixel = Pixel { depth: seen.0 as f32, normal: seen.1.map(|n| n as f32).into(), what: disc.number };
            }
        }
    }
}

/// Returns the whole numbers from `first` within bounds, at most `count`, relative to `first`.
fn span([low, high]: [f64; 2], first: usize, count: usize) -> std::ops::Range<usize> {
    let place = |at: f64| (at - first as f64).clamp(0.0, count as f64);
    place(low.floor()) as usize..place(high.ceil()) as usize
}

impl Flat {
    /// Projects a triangle (m) onto the picture; `None` unless all of it is in front of the eye.
    pub fn of(corners: [Vector; 3], camera: &Camera) -> Option<Flat> {
        let placed = corners.map(|corner| camera.project(&corner.into()));
        if placed.iter().any(|[_, _, depth]| *depth <= 1e-9) {
            return None;
        }
        let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).try_normalize(0.0)?;
        let away = normal.dot(&(corners[0] - camera.eye())) > 0.0;
        let lines = placed.map(|[_, y, _]| y);
        Some(Flat {
            corners: placed.map(|[x, y, depth]| [x, y, 1.0 / depth]),
            normal: if away { -normal } else { normal },
            lines: [
                lines.iter().copied().fold(f64::INFINITY, f64::min),
                lines.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            ],
        })
    }

    /// Returns the ends of a line's part inside the triangle, one pixel wider on either side: long triangles are thin.
    fn columns(&self, y: f64) -> [f64; 2] {
        let [a, b, c] = self.corners;
        let crossings = [(a, b), (b, c), (c, a)].into_iter().filter_map(|(from, to)| {
            let share = (y - from[1]) / (to[1] - from[1]);
            (0.0..=1.0).contains(&share).then(|| from[0] + share * (to[0] - from[0]))
        });
        let ends = [f64::INFINITY, f64::NEG_INFINITY];
        crossings.fold(ends, |ends, at| [ends[0].min(at - 1.0), ends[1].max(at + 1.0)])
    }

    /// Calls a function for the pixels within some lines, with their positions from the first line and their distances.
    pub fn each_pixel(&self, width: usize, first: usize, lines: usize, mut visit: impl FnMut(usize, f64)) {
        let [a, b, c] = self.corners;
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        if area.abs() < 1e-12 {
            return;
        }
        for line in span(self.lines, first, lines) {
            let y = (first + line) as f64 + 0.5;
            for column in span(self.columns(y), 0, width) {
                let x = column as f64 + 0.5;
                let share = |p: [f64; 3], q: [f64; 3]| ((p[0] - x) * (q[1] - y) - (q[0] - x) * (p[1] - y)) / area;
                let (u, v, w) = (share(b, c), share(c, a), share(a, b));
                // A corner common to two triangles must not be drawn twice.
                let inside = |share: f64, p: [f64; 3], q: [f64; 3]| {
                    share > 0.0 || (share == 0.0 && (q[1] - p[1], p[0] - q[0]) > (0.0, 0.0))
                };
                if inside(u, b, c) && inside(v, c, a) && inside(w, a, b) {
                    visit(line * width + column, 1.0 / (u * a[2] + v * b[2] + w * c[2]));
                }
            }
        }
    }
}
