//! Offscreen pictures of frames: shaded grains, glass walls, a colour scale, PNG, APNG and GIF.
//!
//! ```text
//! RunFrame ─> Subject ─> Camera ─> raster (visible surface per pixel) ─> shade ─> lettering ─> Picture ─> files
//! ```
//!
//! Grains are drawn by ray-sphere intersection, exact at every pixel; each pixel of a picture is the mean of four.

mod camera;
mod colours;
mod files;

mod raster;
mod shade;

pub use camera::{Camera, Cut, Subject, View};
use colours::{Anchor, Sheet, length};
pub use colours::{MOST_KINDS, PALETTE, Scale, VIRIDIS, telling};
pub(crate) use colours::{kind_name, ticks};
pub use files::{Animation, PictureError, is_animation, png, write_png};
use makadam_frames::run_frames::{Quantity, RunFolderError, RunFrame, RunFrames, Walls};
use nalgebra::Vector3;
use raster::Flat;
use shade::{Colour, PAPER, Surface};
use std::collections::BTreeMap;

type Vector = Vector3<f64>;

/// Oversampling: lines and columns per line and column of a picture.
const FINER: usize = 2;

/// Largest cosine of the angle between two triangles with a drawn common edge.
const SHARP: f64 = 0.9;

/// Style of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Style {
    /// Width and height, pixels.
    pub size: [usize; 2],
    /// View direction.
    pub view: View,
    /// Clipping plane, with everything in front of it hidden.
    pub cut: Option<Cut>,
    /// True if walls are drawn.
    pub walls: bool,
}

/// Picture: three bytes per pixel, line after line.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Pixels per line.
    pub width: usize,
    /// Lines.
    pub height: usize,
    /// Red, green and blue.
    pub bytes: Vec<u8>,
}

impl Picture {
    /// Returns the colour of a pixel.
    pub fn pixel(&self, column: usize, line: usize) -> [u8; 3] {
        let place = 3 * (line * self.width + column);
        [self.bytes[place], self.bytes[place + 1], self.bytes[place + 2]]
    }
}

/// Frame with camera and clipping plane.
struct Sight<'a> {
    frame: &'a RunFrame,
    camera: &'a Camera,
    /// Normal and position of the clipping plane.
    plane: Option<(Vector, f64)>,
}

/// Returns a camera that shows a subject in a style.
pub fn camera(subject: &Subject, frame: &RunFrame, style: &Style) -> Camera {
    let [width, height] = style.size;
    let strip = Sheet { colours: &mut [], width, height }.strip();
    Camera::looking_at(subject, frame, style.view, [width as f64, height as f64], strip as f64)
}

/// Returns true if pictures of a size have space for the colour scale.
pub fn has_scale([width, height]: [usize; 2]) -> bool {
    Sheet { colours: &mut [], width, height }.strip() > 0
}

/// Returns the peak memory for drawing a picture of a size, bytes.
pub fn memory([width, height]: [usize; 2]) -> u64 {
    let fine = size_of::<raster::Pixel>() + size_of::<Colour>() + size_of::<f32>();
    let own = size_of::<Colour>() + 3;
    (width * height * (FINER * FINER * fine + own)) as u64
}

/// Draws a frame, its grains coloured by a quantity on a scale, with the caption above. After a stop request of the user, the result is
/// invalid.
pub fn draw(
    frame: &RunFrame,
    quantity: &Quantity,
    scale: &Scale,
    camera: &Camera,
    style: &Style,
    caption: &str,
) -> Picture {
    let [width, height] = style.size;
    let fine = [FINER * width, FINER * height];
    let close = camera.enlarged(FINER as f64);
    let sight = Sight { frame, camera: &close, plane: style.cut.map(|cut| cut.plane(close.eye())) };
    let walls = frame.walls.as_ref().filter(|_| style.walls);
    let (stone, glass) = walls.map_or((Vec::new(), Vec::new()), |walls| flats(walls, &sight));
    let raster = raster::draw(&sight, fine, &stone);
    let colours: Vec<Colour> = quantity.values.iter().map(|value| scale.colour(*value)).collect();
    let count = frame.grains.radii.len().max(1) as f64;
    let reach = 3.0 * frame.grains.radii.iter().sum::<f64>() / count;
    let mut drawn =
        Surface { raster: &raster, camera: &close, colours: &colours, reach, places: shade::places() }.colours();
    shade::glaze(&mut drawn, &raster, &close, &glass);
    if let Some(walls) = walls {
        shade::edges(&mut drawn, &raster, &close, &edges(walls, &sight), 1.3 * FINER as f64);
    }
    let mut mixed = mean(&drawn, width, height);
    let mut sheet = Sheet { colours: &mut mixed, width, height };
    let line = sheet.line() as i64;
    sheet.write(caption, [line, line / 2], Anchor::Left);
    sheet.write(&sizes(frame), [line, height as i64 - line - line / 2], Anchor::Left);
    sheet.scale(quantity, scale);
    let byte = |share: f32| (255.0 * share.clamp(0.0, 1.0)).round() as u8;
    Picture { width, height, bytes: mixed.iter().flat_map(|colour| colour.map(byte)).collect() }
}

/// Formats number and sizes of the grains.
pub(crate) fn sizes(frame: &RunFrame) -> String {
    let radii = &frame.grains.radii;
    let [least, most] =
        [radii.iter().copied().fold(f64::INFINITY, f64::min), radii.iter().copied().fold(0.0, f64::max)];
    let count = radii.len();
    match (count, most > 1.005 * least) {
        (0, _) => "no grains".into(),
        (1, _) => format!("1 grain, diameter {}", length(2.0 * most)),
        (_, false) => format!("{count} grains, diameter {}", length(2.0 * most)),
        (_, true) => format!("{count} grains, diameters {} to {}", length(2.0 * least), length(2.0 * most)),
    }
}

/// Averages each pixel over a square of finer ones.
fn mean(fine: &[Colour], width: usize, height: usize) -> Vec<Colour> {
    let mut colours = vec![PAPER; width * height];
    for (place, colour) in colours.iter_mut().enumerate() {
        let (column, line) = (FINER * (place % width), FINER * (place / width));
        let parts = (0..FINER * FINER).map(|part| fine[(line + part / FINER) * FINER * width + column + part % FINER]);
        *colour = parts.fold([0.0; 3], |sum, part| std::array::from_fn(|k| sum[k] + part[k]));
        colour.iter_mut().for_each(|share| *share /= (FINER * FINER) as f32);
    }
    colours
}

/// Returns the triangles of walls on a picture: opaque ones and transparent ones.
fn flats(walls: &Walls, sight: &Sight<'_>) -> (Vec<Flat>, Vec<Flat>) {
    let (mut stone, mut glass) = (Vec::new(), Vec::new());
    for (triangle, wall) in walls.triangles.iter().zip(&walls.wall) {
        let corners = triangle.map(|corner| Vector::from(walls.points[corner as usize]));
        if is_cut_away(&corners, sight) {
            continue;
        }
        let flat = Flat::of(corners, sight.camera);
        if is_stone(walls, *wall) { stone.extend(flat) } else { glass.extend(flat) }
    }
    (stone, glass)
}

/// Returns true for an opaque wall.
pub(crate) fn is_stone(walls: &Walls, wall: u32) -> bool {
    walls.shapes.get(wall as usize).is_some_and(|shape| *shape == "spheres")
}

/// Returns true if all corners lie in front of the clipping plane.
fn is_cut_away(corners: &[Vector], sight: &Sight<'_>) -> bool {
    sight.plane.is_some_and(|(normal, at)| corners.iter().all(|corner| normal.dot(corner) > at))
}

/// Returns the edges of walls that the clipping plane does not hide.
fn edges(walls: &Walls, sight: &Sight<'_>) -> Vec<[Vector; 2]> {
    let ends = wall_edges(walls).into_iter().map(|ends| ends.map(Vector::from));
    ends.filter(|ends| !is_cut_away(ends, sight)).collect()
}

/// Side of a triangle: the number of its wall, and its ends, rounded.
type Side = (u32, [[i64; 3]; 2]);

/// Returns the ends (m) of the edges of walls, at the ends and sharp bends of surfaces. Walls of spheres have none.
pub(crate) fn wall_edges(walls: &Walls) -> Vec<[[f64; 3]; 2]> {
    let size = walls.points.iter().flatten().fold(0.0_f64, |size, place| size.max(place.abs())).max(1e-12);
    // Faces of a box share no points, only positions.
    let key = |point: &[f64; 3]| point.map(|place| (place / size * 1e6).round() as i64);
    let mut sides: BTreeMap<Side, (Vec<Vector>, [[f64; 3]; 2])> = BTreeMap::new();
    for (triangle, &wall) in walls.triangles.iter().zip(&walls.wall) {
        if is_stone(walls, wall) {
            continue;
        }
        let corners = triangle.map(|corner| walls.points[corner as usize]);
        let [a, b, c] = corners.map(Vector::from);
        let Some(normal) = (b - a).cross(&(c - a)).try_normalize(0.0) else { continue };
        for ends in [[0, 1], [1, 2], [2, 0]].map(|side| side.map(|corner: usize| corners[corner])) {
            let mut places = ends.map(|end| key(&end));
            places.sort_unstable();
            sides.entry((wall, places)).or_insert_with(|| (Vec::new(), ends)).0.push(normal);
        }
    }
    let bends = |normals: &[Vector]| normals.iter().any(|other| other.dot(&normals[0]).abs() < SHARP);
    let edges = sides.into_values().filter(|(normals, _)| normals.len() == 1 || bends(normals));
    edges.map(|(_, ends)| ends).collect()
}

/// Content of a picture, in addition to its [`Style`].
#[derive(Clone, Debug, Default)]
pub struct Content {
    /// Field for colouring grains; if absent, chosen by [`telling`].
    pub field: Option<String>,
    /// Values at the ends of the colour scale, in the field's unit; if absent, from the frames.
    pub range: Option<[f64; 2]>,
    /// Shows grains far from the walls, too.
    pub all_grains: bool,
}

impl Content {
    /// Returns the field for colouring the grains of a frame.
    pub fn field_of(&self, frame: &RunFrame) -> String {
        self.field.clone().unwrap_or_else(|| telling(frame).into())
    }

    /// Returns the colour scale of a field with these values.
    pub fn scale_of(&self, title: &str, values: &[f64]) -> Scale {
        self.range.map_or_else(|| Scale::of(title, values), Scale::Range)
    }

    /// Draws a frame of a run.
    ///
    /// # Errors
    /// [`RunFolderError::Unknown`] for a field that cannot be drawn.
    pub fn picture(&self, run: &RunFrames, frame: &RunFrame, style: &Style) -> Result<Picture, RunFolderError> {
        let quantity = run.field(frame, &self.field_of(frame))?;
        let scale = self.scale_of(&quantity.title, &quantity.values);
        let camera = camera(&Subject::of(std::iter::once(frame), self.all_grains), frame, style);
        Ok(draw(frame, &quantity, &scale, &camera, style, &caption(run, frame)))
    }
}

/// Returns the line above a picture: scene and time.
pub fn caption(run: &RunFrames, frame: &RunFrame) -> String {
    format!("{}   t = {:.3} s", run.scene(), frame.time)
}
