//! Which part of a bed is its bulk: away from walls and from the free surface.

use super::bed_surface::BedFields;
use super::contour::{self, Loop, Segment};
use super::drum::Drum;
use super::effort;
use super::frames::Frames;
use super::setting::Setting;
use super::sphere_volume::half_space;
use super::static_angle::{HeapFields, HeapFrame};
use super::walls::PlacedWalls;
use crate::plan::Observable;
use makadam::snapshot::{Particle, Snapshot};
use nalgebra::Vector3;

/// Fewest grains a frame, on average, for a bulk two diameters inside; with fewer, one diameter is taken.
const FEWEST: usize = 50;

/// The bulk of a recording's measured frames: one free surface, averaged over them.
pub struct Bulk {
    /// Distance kept from walls and from the free surface, m.
    pub inset: f64,
    surface: FreeSurface,
}

/// The free surface of a bed.
enum FreeSurface {
    /// There is no bulk at all.
    Nowhere,
    /// There is no surface: no gravity, or no bed yet.
    None,
    /// A level one: the direction up, and the height along it, m.
    Level(Vector3<f64>, f64),
    /// In a drum: outline of the bed in the cross-section, and its free pieces.
    Drum(Drum, Loop, Vec<Segment>),
    /// Of a heap: outline in (r, z), and its free pieces.
    Heap(HeapFrame, Loop, Vec<Segment>),
}

impl Bulk {
    /// Finds the free surface of the measured frames, and how far inside it the bulk begins.
    ///
    /// `bed` holds the fields of these frames where the scene has a drum, `heap` where it asks for a heap's angle.
    ///
    /// # Errors
    /// Where a frame cannot be shown.
    pub fn new<F: Frames + ?Sized>(
        setting: &Setting<'_>,
        bed: Option<&BedFields>,
        heap: Option<HeapFields>,
        frames: &F,
    ) -> Result<Self, F::Error> {
        let surface = FreeSurface::find(setting, bed, heap, frames)?;
        let deep = Bulk { inset: 2.0 * setting.diameter, surface };
        let mut inside = 0;
        frames.each(&mut |frame| inside += deep.grains(setting, frame))?;
        Ok(match inside >= FEWEST * frames.count() {
            true => deep,
            false => Bulk { inset: setting.diameter, ..deep },
        })
    }

    /// No bulk, where none is asked for.
    pub fn nowhere() -> Self {
        Bulk { inset: 0.0, surface: FreeSurface::Nowhere }
    }

    fn grains(&self, setting: &Setting<'_>, frame: &Snapshot) -> usize {
        let walls = PlacedWalls::at(setting.scene, frame);
        frame.particles.iter().filter(|grain| self.contains(&walls, &grain.position.into())).count()
    }

    /// Whether a point lies in the bulk.
    pub fn contains(&self, walls: &PlacedWalls, point: &Vector3<f64>) -> bool {
        walls.distance(point) >= self.inset && self.surface.covers(point, self.inset)
    }

    /// Height of the free surface along the direction up, m, where it is level.
    pub fn level(&self) -> Option<f64> {
        match self.surface {
            FreeSurface::Level(_, height) => Some(height),
            _ => None,
        }
    }
}

impl FreeSurface {
    fn find<F: Frames + ?Sized>(
        setting: &Setting<'_>,
        bed: Option<&BedFields>,
        heap: Option<HeapFields>,
        frames: &F,
    ) -> Result<FreeSurface, F::Error> {
        let Some(up) = setting.up else {
            return Ok(FreeSurface::None);
        };
        let diameter = setting.diameter;
        if let Some(drum) = &setting.drum {
            let Some(bed) = bed else {
                return Ok(FreeSurface::Nowhere);
            };
            let Some(outline) = contour::outline(&bed.whole, 0.5 * bed.whole.largest()) else {
                return Ok(FreeSurface::None);
            };
            let free = pieces(&outline, |point| point[0].hypot(point[1]) < drum.radius - diameter);
            return Ok(FreeSurface::Drum(drum.clone(), outline, free));
        }
        if setting.scene.measure.observables.contains(&Observable::StaticAngleOfRepose) {
            let Some(fields) = heap else {
                return Ok(FreeSurface::Nowhere);
            };
            if let Some(outline) = fields.outline() {
                let free = pieces(&outline, |point| point[1] > diameter);
                return Ok(FreeSurface::Heap(fields.heap, outline, free));
            }
        }
        level(setting, up, frames)
    }

    /// Whether a point lies at least `inset` (m) below the surface.
    fn covers(&self, point: &Vector3<f64>, inset: f64) -> bool {
        let deep = |outline: &Loop, free: &[Segment], point: [f64; 2]| {
            let far = |piece: &Segment| contour::squared_distance(piece, point) >= inset * inset;
            free.iter().all(far) && contour::encloses(outline, point)
        };
        match self {
            FreeSurface::Nowhere => false,
            FreeSurface::None => true,
            FreeSurface::Level(up, height) => point.dot(up) <= height - inset,
            FreeSurface::Drum(drum, outline, free) => deep(outline, free, drum.section(point)),
            FreeSurface::Heap(heap, outline, free) => deep(outline, free, heap.meridian(point)),
        }
    }
}

fn pieces(outline: &Loop, free: impl Fn([f64; 2]) -> bool) -> Vec<Segment> {
    contour::segments(outline).filter(|[a, b]| free(*a) && free(*b)).collect()
}

/// The level, along `up`, at which the solid volume a layer falls to half of what it is within the bed.
///
/// Layers are one mean radius thick, volumes exact. Only ratios of volumes enter, so the container's area does not. There is no
/// bulk where layers would be more work than [`effort::most`]: grains are then too far apart, or too unlike, for a bed.
fn level<F: Frames + ?Sized>(setting: &Setting<'_>, up: Vector3<f64>, frames: &F) -> Result<FreeSurface, F::Error> {
    let height = |position: &[f64; 3]| Vector3::from(*position).dot(&up);
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    frames.each(&mut |frame| {
        for grain in &frame.particles {
            let at = height(&grain.position);
            (low, high) = (low.min(at - grain.radius), high.max(at + grain.radius));
        }
    })?;
    let layer = 0.5 * setting.diameter;
    let (count, most) = (((high - low) / layer).ceil().max(1.0), effort::most(frames.grains(0..frames.count())));
    if count > most as f64 {
        return Ok(FreeSurface::Nowhere);
    }
    let count = count as usize;
    // The layers that a grain reaches, and where it lies among them.
    let reached = |grain: &Particle| {
        let (bottom, reach) = ((height(&grain.position) - low) / layer, grain.radius / layer);
        let first = (bottom - reach).floor().max(0.0) as usize;
        let last = count.min((bottom + reach).ceil() as usize);
        (bottom, reach, first.min(last)..last)
    };
    let mut volume = vec![0.0; count];
    // Visits to layers that may still be made; absent once there were too many.
    let mut left = Some(most);
    frames.each(&mut |frame| {
        let visits = frame.particles.iter().map(|grain| reached(grain).2.len()).fold(0, usize::saturating_add);
        left = left.and_then(|left| left.checked_sub(visits));
        for grain in frame.particles.iter().filter(|_| left.is_some()) {
            let (bottom, reach, layers) = reached(grain);
            let beyond = |plane: f64| half_space((plane - bottom) / reach) * grain.radius.powi(3);
            let first = layers.start;
            for (offset, layer) in volume[layers].iter_mut().enumerate() {
                let index = (first + offset) as f64;
                *layer += beyond(index) - beyond(index + 1.0);
            }
        }
    })?;
    if left.is_none() {
        return Ok(FreeSurface::Nowhere);
    }
    let mean_above = |floor: f64| {
        let full: Vec<f64> = volume.iter().copied().filter(|volume| *volume > floor).collect();
        full.iter().sum::<f64>() / full.len().max(1) as f64
    };
    let mut bulk = mean_above(0.0);
    for _ in 0..20 {
        bulk = mean_above(0.5 * bulk);
    }
    let Some(last) = volume.iter().rposition(|volume| *volume >= 0.5 * bulk) else {
        return Ok(FreeSurface::None);
    };
    let above = volume.get(last + 1).copied().unwrap_or(0.0);
    // Linear between the middles of the two layers.
    let share = (volume[last] - 0.5 * bulk) / (volume[last] - above).max(f64::MIN_POSITIVE);
    Ok(FreeSurface::Level(up, low + (last as f64 + 0.5 + share) * layer))
}
