//! Bulk of a bed: the part of it that lies away from walls and from free surfaces, in one frame.
//!
//! The free surface is
//!
//! - in a drum the outline of the bed in the cross-section;
//! - elsewhere the level below which layers across gravity are filled, where the bed is level between walls;
//! - otherwise the outline of a heap, averaged over azimuth;
//! - without gravity none: grains have to fill the room between the walls.
//!
//! A bulk region must hold no hole: a bed of another form (a slope, a block that stands free, a funnel) has none of these
//! surfaces, and no bulk.

use super::bed_surface::MeanField;
use super::contour::{self, Loop, Segment};
use super::drum::Drum;
use super::effort;
use super::field::mean_within;
use super::holes::hole;
use super::setting::Setting;
use super::sphere_volume::half_space;
use super::static_angle::{HeapFields, HeapFrame};
use super::walls::PlacedWalls;
use makadam::snapshot::{Particle, Snapshot};
use nalgebra::Vector3;

/// Fewest grains for a bulk two diameters inside; with fewer, one diameter is taken.
const FEWEST: usize = 50;

/// Part of a diameter by which points may lie outside: lengths that are multiples of each other make points that lie on the border, and
/// the last bits of a number say nothing of their side.
const HAIR: f64 = 1e-9;

/// The bulk of the bed of one frame.
pub struct Bulk {
    /// Distance kept from walls and from the free surface, m.
    pub inset: f64,
    /// Distance by which points on the border count as inside, m.
    hair: f64,
    surface: FreeSurface,
}

enum FreeSurface {
    /// There is none, as there is no gravity.
    None,
    /// A level one: the direction up, and the height along it, m.
    Level(Vector3<f64>, f64),
    /// In a drum: outline of the bed in the cross-section, and its free pieces.
    Drum(Drum, Loop, Vec<Segment>),
    /// Of a heap: outline in (r, z), and its free pieces.
    Heap(HeapFrame, Loop, Vec<Segment>),
}

impl Bulk {
    /// Finds the free surface of a frame, and how far inside it the bulk begins.
    pub fn of(setting: &Setting<'_>, frame: &Snapshot, walls: &PlacedWalls) -> Result<Bulk, String> {
        if frame.particles.is_empty() {
            return Err("there are no grains".into());
        }
        let Some(up) = setting.up else {
            return Bulk::below(FreeSurface::None, setting, frame, walls)
                .map_err(|why| format!("{why}: without gravity, grains have to fill the room between the walls"));
        };
        if let Some(drum) = &setting.drum {
            return Bulk::below(in_drum(setting, drum, frame)?, setting, frame, walls);
        }
        let level = level(setting, up, frame).and_then(|level| Bulk::below(level, setting, frame, walls));
        let heap = |why: String| {
            let heap = heap(setting, frame).and_then(|heap| Bulk::below(heap, setting, frame, walls));
            heap.map_err(|heap| format!("the bed is neither level between walls ({why}) nor a round heap ({heap})"))
        };
        level.or_else(heap)
    }

    /// The bulk below a surface, as deep as there are grains for.
    fn below(
        surface: FreeSurface,
        setting: &Setting<'_>,
        frame: &Snapshot,
        walls: &PlacedWalls,
    ) -> Result<Bulk, String> {
        let mut bulk = Bulk { inset: 2.0 * setting.diameter, hair: HAIR * setting.diameter, surface };
        let mut inside = bulk.grains(frame, walls);
        if inside.len() < FEWEST {
            bulk.inset = setting.diameter;
            inside = bulk.grains(frame, walls);
        }
        if inside.is_empty() {
            return Err("no grain lies a mean diameter inside walls and free surface".into());
        }
        // The outline of the bed in a drum is that of its field, which has no holes at all.
        match bulk.surface {
            FreeSurface::Drum(..) => Ok(bulk),
            _ => match hole(setting, frame, &inside, &|point| bulk.contains(walls, point))? {
                None => Ok(bulk),
                Some(place) => {
                    let [x, y, z] = place.map(|metres| format!("{metres:.4}")).into();
                    Err(format!("no grain lies near ({x}, {y}, {z}) m, inside its bulk"))
                }
            },
        }
    }

    /// Grains whose centres lie in the bulk.
    fn grains<'f>(&self, frame: &'f Snapshot, walls: &PlacedWalls) -> Vec<&'f Particle> {
        frame.particles.iter().filter(|grain| self.contains(walls, &grain.position.into())).collect()
    }

    /// Returns true for a point in the bulk.
    pub fn contains(&self, walls: &PlacedWalls, point: &Vector3<f64>) -> bool {
        let inset = self.inset - self.hair;
        walls.distance(point) >= inset && self.surface.covers(point, inset)
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
    /// Returns true for a point at least `inset` (m) below the surface.
    fn covers(&self, point: &Vector3<f64>, inset: f64) -> bool {
        let deep = |outline: &Loop, free: &[Segment], point: [f64; 2]| {
            let far = |piece: &Segment| contour::squared_distance(piece, point) >= inset * inset;
            free.iter().all(far) && contour::encloses(outline, point)
        };
        match self {
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

fn in_drum(setting: &Setting<'_>, drum: &Drum, frame: &Snapshot) -> Result<FreeSurface, String> {
    let mut mean = MeanField::new(setting, drum, frame.particles.len());
    mean.add(frame);
    let field = mean.finish().ok_or("grains are too small for the drum, or too unlike in size")?;
    let outline = contour::outline(&field, 0.5 * field.largest()).ok_or("there is no bed in the drum")?;
    let free = pieces(&outline, |point| point[0].hypot(point[1]) < drum.radius - setting.diameter);
    Ok(FreeSurface::Drum(drum.clone(), outline, free))
}

fn heap(setting: &Setting<'_>, frame: &Snapshot) -> Result<FreeSurface, String> {
    let Ok(fields) = HeapFields::new(setting, &[frame][..]);
    let fields = fields?;
    let outline = fields.outline().ok_or("it has no outline")?;
    let foot = outline.iter().map(|point| point[1]).fold(f64::INFINITY, f64::min);
    let free = pieces(&outline, |point| point[1] > foot + setting.diameter);
    Ok(FreeSurface::Heap(fields.heap, outline, free))
}

/// The level, along `up`, at which the solid volume a layer falls to half of what it is within the bed.
///
/// Layers are one mean radius thick, volumes exact. Only ratios of volumes enter, so the container's area does not.
///
/// # Errors
/// Where layers would be more work than [`effort::most`]: grains are then too far apart, or too unlike, for a bed.
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
    // The layers that a grain reaches, and where it lies among them.
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
