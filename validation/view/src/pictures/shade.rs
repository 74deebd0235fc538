//! Shading of visible surfaces: light, ambient occlusion, glass walls, edges.

use super::camera::Camera;
use super::raster::{Flat, Raster, WALL, bands};
use nalgebra::Vector3;
use std::f64::consts::TAU;

type Vector = Vector3<f64>;

/// Fractions of red, green and blue.
pub(super) type Colour = [f32; 3];

pub(super) const PAPER: Colour = [1.0, 1.0, 1.0];

/// Colour of opaque walls.
const STONE: Colour = [0.66, 0.65, 0.63];

/// Colour of transparent walls, and their opacity: in front of grains, and in front of the background.
const GLASS: Colour = [0.50, 0.57, 0.64];
const VEIL: [f32; 2] = [0.07, 0.17];

/// Colour of the edges of walls, and their opacity.
const EDGE: Colour = [0.25, 0.29, 0.34];
const EDGE_VEIL: f32 = 0.75;

/// Number of sampling points about a pixel for ambient occlusion.
const NEIGHBOURS: usize = 14;

/// Pixels to shade.
pub(super) struct Surface<'a> {
    pub raster: &'a Raster,
    pub camera: &'a Camera,
    /// Colour of each grain.
    pub colours: &'a [Colour],
    /// Range of ambient occlusion, m.
    pub reach: f64,
    /// Sampling points of [`places`].
    pub places: [[f64; 2]; NEIGHBOURS],
}

/// Returns the sampling points for ambient occlusion about a pixel, over its range: on a spiral.
pub(super) fn places() -> [[f64; 2]; NEIGHBOURS] {
    std::array::from_fn(|number| {
        let share = (number as f64 + 0.5) / NEIGHBOURS as f64;
        let (sine, cosine) = (2.399_963 * number as f64).sin_cos();
        [share * cosine, share * sine]
    })
}

impl Surface<'_> {
    /// Returns the colours of all pixels without transparent walls.
    pub fn colours(&self) -> Vec<Colour> {
        let width = self.raster.width;
        let mut colours = vec![PAPER; self.raster.pixels.len()];
        bands(&mut colours, width, |first, colours| {
            for (offset, colour) in colours.iter_mut().enumerate() {
                let place = first * width + offset;
                let pixel = self.raster.pixels[place];
                if pixel.depth.is_finite() {
                    let base = if pixel.what == WALL { STONE } else { self.colours[pixel.what as usize] };
                    *colour = self.lit(base, place);
                }
            }
        });
        colours
    }

    /// Returns the point that a pixel shows, in camera coordinates, m.
    fn point(&self, column: usize, line: usize, depth: f64) -> [f64; 3] {
        self.camera.seen_at(column as f64 + 0.5, line as f64 + 0.5, depth)
    }

    fn lit(&self, base: Colour, place: usize) -> Colour {
        let (column, line) = (place % self.raster.width, place / self.raster.width);
        let pixel = self.raster.pixels[place];
        let normal = Vector::from(pixel.normal.map(f64::from));
        let light = self.camera.light();
        let towards = -self.camera.ray(column as f64 + 0.5, line as f64 + 0.5).normalize();
        // Wrap-around lighting leaves no side black.
        let lambert = (0.5 * normal.dot(&light) + 0.5).powi(2);
        let half = (light + towards).normalize();
        let gloss = 0.16 * normal.dot(&half).max(0.0).powi(40);
        let open = self.openness(column, line, &normal);
        let rim = 0.72 + 0.28 * normal.dot(&towards).clamp(0.0, 1.0).powf(0.7);
        let bright = (0.36 + 0.86 * lambert) * (0.28 + 0.72 * open) * rim;
        base.map(|share| (f64::from(share) * bright + gloss * open).clamp(0.0, 1.0) as f32)
    }

    /// Returns the unoccluded fraction of the sky at a pixel, from nearby surfaces: M. McGuire, B. Osman, M. Bukowski and P. Hennessy, The
    /// Alchemy screen-space ambient obscurance algorithm, High Performance Graphics 2011, 25-32.
    fn openness(&self, column: usize, line: usize, normal: &Vector) -> f64 {
        let depth = f64::from(self.raster.pixels[line * self.raster.width + column].depth);
        let (here, normal) = (self.point(column, line, depth), self.camera.turned(normal));
        let radius = self.camera.pixels(self.reach, depth).clamp(3.0, 160.0);
        // Each pixel rotates the sampling points by its own angle, which hides their pattern.
        let turn = TAU * fraction(52.982_918_9 * fraction(0.067_110_56 * column as f64 + 0.005_837_15 * line as f64));
        let (sine, cosine) = turn.sin_cos();
        let mut hidden = 0.0;
        for [right, down] in self.places {
            let x = column as f64 + radius * (right * cosine - down * sine);
            let y = line as f64 + radius * (right * sine + down * cosine);
            if x < 0.0 || y < 0.0 || x >= self.raster.width as f64 || y >= self.raster.height as f64 {
                continue;
            }
            let (x, y) = (x as usize, y as usize);
            // Surfaces too far away along the line of sight do not occlude, nor does the background, which is infinitely far.
            let there = f64::from(self.raster.pixels[y * self.raster.width + x].depth);
            if (there - depth).abs() >= self.reach {
                continue;
            }
            let point = self.point(x, y, there);
            let arm: [f64; 3] = std::array::from_fn(|axis| point[axis] - here[axis]);
            let dot = |other: &[f64; 3]| arm[0] * other[0] + arm[1] * other[1] + arm[2] * other[2];
            let square = dot(&arm);
            let above = (dot(&normal) - 0.02 * self.reach).max(0.0);
            if square < self.reach * self.reach {
                hidden += above * self.reach / (square + 0.02 * self.reach * self.reach)
                    * (1.0 - square / (self.reach * self.reach));
            }
        }
        (1.0 - 1.1 * hidden / NEIGHBOURS as f64).clamp(0.0, 1.0)
    }
}

fn fraction(value: f64) -> f64 {
    value - value.floor()
}

/// Draws transparent walls over the picture. All have one colour, so their order does not matter.
pub(super) fn glaze(colours: &mut [Colour], raster: &Raster, camera: &Camera, walls: &[Flat]) {
    let width = raster.width;
    bands(colours, width, |first, colours| {
        for flat in walls {
            flat.each_pixel(width, first, colours.len() / width, |place, depth| {
                let behind = raster.pixels[first * width + place].depth;
                if (depth as f32) >= behind {
                    return;
                }
                let ray = camera.ray((place % width) as f64, (first + place / width) as f64).normalize();
                // Glass at grazing incidence is more opaque.
                let grazing = (1.0 - flat.normal.dot(&ray).abs()).powi(3) as f32;
                let veil = if behind.is_finite() { VEIL[0] } else { VEIL[1] };
                blend(&mut colours[place], GLASS, veil * (1.0 + 1.6 * grazing));
            });
        }
    });
}

pub(super) fn blend(colour: &mut Colour, over: Colour, share: f32) {
    for (below, above) in colour.iter_mut().zip(over) {
        *below += (above - *below) * share;
    }
}

/// Draws the visible parts of lines between points (m), at a width in pixels.
pub(super) fn edges(colours: &mut [Colour], raster: &Raster, camera: &Camera, edges: &[[Vector; 2]], wide: f64) {
    let mut covered = vec![0.0_f32; colours.len()];
    for [from, to] in edges {
        let [from, to] = [from, to].map(|end| camera.project(&(*end).into()));
        if from[2] <= 1e-9 || to[2] <= 1e-9 {
            continue;
        }
        line(&mut covered, raster, [from, to], wide);
    }
    for (colour, covered) in colours.iter_mut().zip(covered).filter(|(_, covered)| *covered > 0.0) {
        blend(colour, EDGE, EDGE_VEIL * covered);
    }
}

fn line(covered: &mut [f32], raster: &Raster, [from, to]: [[f64; 3]; 2], wide: f64) {
    let way = [to[0] - from[0], to[1] - from[1]];
    let steps = (2.0 * way[0].abs().max(way[1].abs())).ceil().min(50_000.0);
    let reach = wide.ceil() as i64 + 1;
    for step in 0..=steps as u64 {
        let share = if steps > 0.0 { step as f64 / steps } else { 0.0 };
        let (x, y) = (from[0] + share * way[0], from[1] + share * way[1]);
        // The inverse distance is linear on a picture.
        let depth = 1.0 / (1.0 / from[2] * (1.0 - share) + 1.0 / to[2] * share);
        for line in (y as i64 - reach)..=(y as i64 + reach) {
            for column in (x as i64 - reach)..=(x as i64 + reach) {
                if line < 0 || column < 0 || line >= raster.height as i64 || column >= raster.width as i64 {
                    continue;
                }
                let place = line as usize * raster.width + column as usize;
                let off = ((column as f64 + 0.5 - x).powi(2) + (line as f64 + 0.5 - y).powi(2)).sqrt();
                let cover = (0.5 * wide + 0.5 - off).clamp(0.0, 1.0) as f32;
                if cover > covered[place] && (depth as f32) < raster.pixels[place].depth * 1.0005 {
                    covered[place] = cover;
                }
            }
        }
    }
}
