//! Bulk of a bed in one frame: the part away from walls and from free surfaces.
//!
//! The free surface is
//!
//! - in a drum, the outline of the bed in the cross-section;
//! - elsewhere, for a level bed between walls, the level of half-filled layers across gravity;
//! - otherwise the outline of a heap, averaged over azimuth;
//! - without gravity none: grains must fill the space between the walls.
//!
//! A bulk region must hold no hole: a bed of another form (a slope, a free-standing block, a funnel) has none of these
//! surfaces, and no bulk.

use super::contour::{self, Loop, Segment};
use super::drum::Drum;
use super::effort;
use super::field::mean_within;
use super::holes::hole;
use super::setting::Setting;
use super::sphere_volume::half_space;
use super::static_angle::HeapFrame;
use super::view::View;
use super::walls::PlacedWalls;
use makadam::snapshot::{Particle, Snapshot};
use nalgebra::Vector3;

/// Smallest number of grains for a bulk at two diameters; with fewer grains, the distance is one diameter.
const FEWEST: usize = 50;

/// Tolerance of the border, in diameters: for lengths that are multiples of each other, points lie on the border, and
/// rounding would decide their side.
const BORDER_TOLERANCE: f64 = 1e-9;

/// Bulk of the bed of one frame.
pub struct Bulk {
    /// Distance from walls and from the free surface, m.
    pub inset: f64,
    /// Flags of the grains in the bulk, in the order of the frame's table.
    pub inside: Vec<bool>,
    /// Tolerance for points on the border, m.
    tolerance: f64,
    surface: FreeSurface,
}

enum FreeSurface {
    /// No surface, without gravity.
    None,
    /// Level surface: the direction up, and the height along it, m.
    Level(Vector3<f64>, f64),
    /// Surface in a drum: outline of the bed in the cross-section.
    Drum(Drum, Outline),
    /// Surface of a heap: outline in (r, z).
    Heap(HeapFrame, Outline),
}

impl Bulk {
    /// Finds the free surface of a frame, and the distance of the bulk from it.
    pub fn of(view: &View<'_>) -> Result<Bulk, String> {
        let (setting, frame) = (view.setting, view.frame);
        if frame.particles.is_empty() {
            return Err("there are no grains".into());
        }
        let Some(up) = setting.up else {
            return Bulk::below(FreeSurface::None, view)
                .map_err(|why| format!("{why}: without gravity, grains have to fill the room between the walls"));
        };
        if let Some(drum) = &setting.drum {
            return Bulk::below(in_drum(view, drum)?, view);
        }
        let level = level(setting, up, frame).and_then(|level| Bulk::below(level, view));
        let heap = |why: String| {
            let heap = heap(view).and_then(|heap| Bulk::below(heap, view));
            heap.map_err(|heap| format!("the bed is neither level between walls ({why}) nor a round heap ({heap})"))
        };
        level.or_else(heap)
    }

    /// Finds the bulk below a surface, at the distance that the number of grains permits.
    fn below(surface: FreeSurface, view: &View<'_>) -> Result<Bulk, String> {
        let (setting, grains) = (view.setting, &view.frame.particles);
        let mut bulk = Bulk {
            inset: 2.0 * setting.diameter,
            inside: Vec::new(),
            tolerance: BORDER_TOLERANCE * setting.diameter,
            surface,
        };
        let count = |inside: &[bool]| inside.iter().filter(|inside| **inside).count();
        bulk.inside = bulk.find(view);
        if count(&bulk.inside) < FEWEST {
            bulk.inset = setting.diameter;
            bulk.inside = bulk.find(view);
        }
        if count(&bulk.inside) == 0 {
            return Err("no grain lies a mean diameter inside walls and free surface".into());
        }
        // The outline of the bed in a drum is from its field, which has no holes.
        if let FreeSurface::Drum(..) = bulk.surface {
            return Ok(bulk);
        }
        let inside = grains.iter().zip(&bulk.inside).filter(|(_, inside)| **inside);
        let inside: Vec<&Particle> = inside.map(|(grain, _)| grain).collect();
        match hole(setting, view.frame, &inside, &|point| bulk.contains(&view.walls, point))? {
            None => Ok(bulk),
            Some(place) => {
                let [x, y, z] = place.map(|metres| format!("{metres:.4}")).into();
                Err(format!("no grain lies near ({x}, {y}, {z}) m, inside its bulk"))
            }
        }
    }

    /// Finds the grains with centres in the bulk.
    fn find(&self, view: &View<'_>) -> Vec<bool> {
        let is_inside = |(grain, distance): (&Particle, &f64)| {
            *distance >= self.inset - self.tolerance && self.is_covered(&grain.position.into())
        };
        view.frame.particles.iter().zip(view.wall_distances()).map(is_inside).collect()
    }

    /// Returns true for a point in the bulk.
    pub fn contains(&self, walls: &PlacedWalls, point: &Vector3<f64>) -> bool {
        walls.distance(point) >= self.inset - self.tolerance && self.is_covered(point)
    }

    /// Returns true for a point deep enough below the free surface.
    pub fn is_covered(&self, point: &Vector3<f64>) -> bool {
        self.surface.covers(point, self.inset - self.tolerance)
    }

    /// Returns the height of a level free surface along the direction up, m.
    pub fn level(&self) -> Option<f64> {
        match self.surface {
            FreeSurface::Level(_, height) => Some(height),
            _ => None,
        }
    }
}

impl FreeSurface {
    /// Returns true for a point at least `inset` (m) below the surface.
    fn covers(&self, point: &Vector3<f64>, inset: f64) -> bool {
        match self {
            FreeSurface::None => true,
            FreeSurface::Level(up, height) => point.dot(up) <= height - inset,
            FreeSurface::Drum(drum, outline) => outline.covers(drum.section(point), inset),
            FreeSurface::Heap(heap, outline) => outline.covers(heap.meridian(point), inset),
        }
    }
}

/// Outline of a bed in a plane, in runs of consecutive pieces: most points are far from most runs.
struct Outline(Vec<Run>);

/// Consecutive pieces of an outline, and the circle about them.
struct Run {
    pieces: Vec<Segment>,
    /// Pieces of the free surface.
    free: Vec<Segment>,
    centre: [f64; 2],
    radius: f64,
}

impl Outline {
    /// Pieces per run.
    const LENGTH: usize = 8;

    /// Makes an outline; `is_free` marks points of the free surface.
    fn new(outline: &Loop, is_free: impl Fn([f64; 2]) -> bool) -> Outline {
        let pieces: Vec<_> = contour::segments(outline).map(|[a, b]| ([a, b], is_free(a) && is_free(b))).collect();
        let run = |marked: &[(Segment, bool)]| {
            let pieces: Vec<_> = marked.iter().map(|(piece, _)| *piece).collect();
            let free = marked.iter().filter(|(_, is_free)| *is_free).map(|(piece, _)| *piece).collect();
            let corners = || pieces.iter().flatten();
            let centre =
                [0, 1].map(|axis| corners().map(|corner| corner[axis]).sum::<f64>() / corners().count() as f64);
            let square = corners().map(|[x, y]| (x - centre[0]).powi(2) + (y - centre[1]).powi(2)).fold(0.0, f64::max);
            // Rounding must not increase the distance to a run.
            Run { centre, radius: (1.0 + 1e-9) * square.sqrt(), free, pieces }
        };
        Outline(pieces.chunks(Outline::LENGTH).map(run).collect())
    }

    /// Returns true for a point inside the outline, at least `inset` (m) from its free pieces.
    fn covers(&self, point: [f64; 2], inset: f64) -> bool {
        let mut crossings = 0;
        for Run { pieces, free, centre, radius } in &self.0 {
            let [x, y] = [point[0] - centre[0], point[1] - centre[1]];
            let is_near = !free.is_empty() && x * x + y * y < (inset + radius).powi(2);
            if is_near && free.iter().any(|piece| contour::squared_distance(piece, point) < inset * inset) {
                return false;
            }
            // The ray leads towards larger first coordinates.
            if y.abs() <= *radius && x <= *radius {
                crossings += pieces.iter().filter(|piece| contour::crosses(**piece, point)).count();
            }
        }
        crossings % 2 == 1
    }
}

fn in_drum(view: &View<'_>, drum: &Drum) -> Result<FreeSurface, String> {
    let outline = view.outline(drum)?.ok_or("there is no bed in the drum")?;
    let inside = drum.radius - view.setting.diameter;
    let outline = Outline::new(outline, |point| point[0].hypot(point[1]) < inside);
    Ok(FreeSurface::Drum(drum.clone(), outline))
}

fn heap(view: &View<'_>) -> Result<FreeSurface, String> {
    let fields = view.heap()?;
    let outline = fields.outline().ok_or("it has no outline")?;
    let foot = outline.iter().map(|point| point[1]).fold(f64::INFINITY, f64::min);
    let outline = Outline::new(&outline, |point| point[1] > foot + view.setting.diameter);
    Ok(FreeSurface::Heap(fields.heap, outline))
}

/// Finds the level, along `up`, where the solid volume per layer falls to half its value within the bed.
///
/// Layers are one mean radius thick, volumes exact. Only ratios of volumes enter, so the container's area does not.
///
/// # Errors
/// Message if layers exceed the work limit [`effort::most`]: grains are then too far apart, or too different in size, for a bed.
fn level(setting: &Setting<'_>, up: Vector3<f64>, frame: &Snapshot) -> Result<FreeSurface, String> {
    const APART: &str = "grains lie too far apart, or are too unlike in size";
    let height = |position: &[f64; 3]| Vector3::from(*position).dot(&up);
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for grain in &frame.particles {
        let at = height(&grain.position);
        (low, high) = (low.min(at - grain.radius), high.max(at + grain.radius));
    }
    let layer = 0.5 * setting.diameter;
    let (count, most) = (((high - low) / layer).ceil().max(1.0), effort::most(frame.particles.len()));
    if count > most as f64 {
        return Err(APART.into());
    }
    let count = count as usize;
    // First and last layer of a grain, and its position among them.
    let reached = |grain: &Particle| {
        let (bottom, reach) = ((height(&grain.position) - low) / layer, grain.radius / layer);
        let first = (bottom - reach).floor().max(0.0) as usize;
        let last = count.min((bottom + reach).ceil() as usize);
        (bottom, reach, first.min(last)..last)
    };
    let visits = frame.particles.iter().map(|grain| reached(grain).2.len()).fold(0, usize::saturating_add);
    if visits > most {
        return Err(APART.into());
    }
    let mut volume = vec![0.0; count];
    for grain in &frame.particles {
        let (bottom, reach, layers) = reached(grain);
        let beyond = |plane: f64| half_space((plane - bottom) / reach) * grain.radius.powi(3);
        let first = layers.start;
        for (offset, layer) in volume[layers].iter_mut().enumerate() {
            let index = (first + offset) as f64;
            *layer += beyond(index) - beyond(index + 1.0);
        }
    }
    let bulk = mean_within(&volume, |_| 1.0);
    let Some(last) = volume.iter().rposition(|volume| *volume >= 0.5 * bulk) else {
        return Err("no layer of it is filled".into());
    };
    let above = volume.get(last + 1).copied().unwrap_or(0.0);
    // Linear between the middles of the two layers.
    let share = (volume[last] - 0.5 * bulk) / (volume[last] - above).max(f64::MIN_POSITIVE);
    Ok(FreeSurface::Level(up, low + (last as f64 + 0.5 + share) * layer))
}
