//! Grains that come and go during a run: sources, sinks, their regions and their checks.

use super::check::{MOST_GRAINS, extent, in_domain, known_material, tube};
use super::document::{Checked, DocumentPath};
use super::error::short;
use super::populate::{symmetric, uniform};
use super::stages::known_stage;
use super::{Insertion, Region, Removal, Scene, Stage, sphere_volume};
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;

/// Fraction of a region above which its grains overlap: no random placement fills half of a region.
const FULL: f64 = 0.5;

impl Region {
    /// Returns true if a point (m) is inside.
    pub fn holds(&self, point: &Vector3<f64>) -> bool {
        self.meets(point, &Vector3::zeros())
    }

    /// Returns true if a straight path (m) from a point (m) meets the region.
    pub(crate) fn meets(&self, from: &Vector3<f64>, path: &Vector3<f64>) -> bool {
        // Part of the path, 0 to 1, between two parallel planes.
        let clip = |[first, last]: [f64; 2], place: f64, rate: f64, low: f64, high: f64| {
            let [enter, leave] = [low, high].map(|end| (end - place) / rate);
            match rate == 0.0 {
                true if place >= low && place <= high => [first, last],
                true => [1.0, 0.0],
                false => [first.max(enter.min(leave)), last.min(enter.max(leave))],
            }
        };
        match self {
            Region::Box { min, max } => {
                let part = |part, axis: usize| clip(part, from[axis], path[axis], min[axis], max[axis]);
                let [first, last] = (0..3).fold([0.0, 1.0], part);
                first <= last
            }
            Region::Cylinder { base, axis, radius, length } => {
                let (axis, arm) = (Vector3::from(*axis).normalize(), from - Vector3::from(*base));
                let (along, rise) = (axis.dot(&arm), axis.dot(path));
                let [first, last] = clip([0.0, 1.0], along, rise, 0.0, *length);
                let (across, moved) = (arm - axis * along, path - axis * rise);
                // Nearest to the axis; without motion across it, not a number.
                let nearest = (-across.dot(&moved) / moved.norm_squared()).max(first).min(last);
                first <= last && (across + moved * nearest).norm() <= *radius
            }
        }
    }

    /// Draws the centre (m) of a grain of the given radius (m) inside, uniform over the places where the grain is inside.
    pub(crate) fn draw(&self, radius: f64, random: &mut ChaCha8Rng) -> Vector3<f64> {
        match self {
            Region::Box { min, max } => Vector3::from_fn(|axis, _| {
                min[axis] + radius + uniform(random) * (max[axis] - min[axis] - 2.0 * radius).max(0.0)
            }),
            Region::Cylinder { base, axis, radius: own, length } => {
                let axis = Vector3::from(*axis).normalize();
                let first = axis.cross(&Vector3::ith(axis.iamin(), 1.0)).normalize();
                let (u, v) = loop {
                    let (u, v) = (symmetric(random), symmetric(random));
                    if u * u + v * v <= 1.0 {
                        break (u, v);
                    }
                };
                let across = (first * u + axis.cross(&first) * v) * (own - radius).max(0.0);
                let along = radius + uniform(random) * (length - 2.0 * radius).max(0.0);
                Vector3::from(*base) + axis * along + across
            }
        }
    }

    /// Returns the corners of the smallest box around the region, m.
    pub(crate) fn bounds(&self) -> ([f64; 3], [f64; 3]) {
        match self {
            Region::Box { min, max } => (*min, *max),
            Region::Cylinder { base, axis, radius, length } => {
                let axis = Vector3::from(*axis).normalize();
                let (a, b) = (Vector3::from(*base), Vector3::from(*base) + axis * *length);
                let side = axis.map(|c| radius * (1.0 - c * c).max(0.0).sqrt());
                ((a.inf(&b) - side).into(), (a.sup(&b) + side).into())
            }
        }
    }

    /// Returns the volume, m3, and the smallest extent, m.
    pub(super) fn size(&self) -> (f64, f64) {
        match self {
            Region::Box { min, max } => {
                let widths: [f64; 3] = std::array::from_fn(|axis| max[axis] - min[axis]);
                (widths.iter().product(), widths.iter().copied().fold(f64::INFINITY, f64::min))
            }
            Region::Cylinder { radius, length, .. } => {
                (std::f64::consts::PI * radius * radius * length, length.min(2.0 * radius))
            }
        }
    }

    /// Checks the values of a region.
    pub fn check(&self, at: &DocumentPath) -> Checked {
        match self {
            Region::Box { min, max } => extent(at, min, max),
            Region::Cylinder { base, axis, radius, length } => tube(at, (base, axis), (&[*radius], "radius"), *length),
        }
    }
}

impl Insertion {
    /// Returns the time since the start, s, up to the end.
    pub(crate) fn elapsed(&self, time: f64) -> f64 {
        (self.until.map_or(time, |until| time.min(until)) - self.from).max(0.0)
    }
}

impl Scene {
    /// Returns true if grains come or go during a run.
    pub fn flows(&self) -> bool {
        !self.insert.is_empty() || !self.remove.is_empty()
    }

    /// Returns material and smallest and largest radius (m) of the listed grains, the populations with grains, and the sources.
    pub fn grain_kinds(&self) -> impl Iterator<Item = (&str, (f64, f64))> {
        let listed = self.listed().map(|grain| (grain.material.as_str(), (grain.radius, grain.radius)));
        let populations = self.population.iter().filter(|group| group.count > 0);
        let placed = populations.map(|group| (group.material.as_str(), group.radius.bounds()));
        listed.chain(placed).chain(self.insert.iter().map(|source| (source.material.as_str(), source.radius.bounds())))
    }

    /// Iterates over the smallest and largest radii (m) of populations, sources and listed grains, with their places in the scene.
    pub(crate) fn radii(&self) -> impl Iterator<Item = (DocumentPath, (f64, f64))> {
        let of = |table, index| DocumentPath::default().key(table).index(index).key("radius");
        let populations = self.population.iter().map(|group| group.radius.bounds()).enumerate();
        let sources = self.insert.iter().map(|source| source.radius.bounds()).enumerate();
        let listed = self.listed().enumerate().map(move |(index, grain)| {
            let start = || DocumentPath::default().key("start").key("file");
            (if index < self.grain.len() { of("grain", index) } else { start() }, (grain.radius, grain.radius))
        });
        let populations = populations.map(move |(index, range)| (of("population", index), range));
        populations.chain(sources.map(move |(index, range)| (of("insert", index), range))).chain(listed)
    }

    /// Returns the mean radius (m) over the grains at the start and those that come. A source counts as its total, or as
    /// a thousand grains: the mean depends on no time.
    pub(crate) fn mean_radius(&self) -> f64 {
        let placed = self.population.iter().map(|group| (group.count as f64, group.radius.mean()));
        let listed = self.listed().map(|grain| (1.0, grain.radius));
        let to_come = |total: Option<u64>| total.map_or(1000.0, |total| total as f64);
        let come = self.insert.iter().map(|source| (to_come(source.total), source.radius.mean()));
        let all = placed.chain(listed).chain(come);
        let (count, sum) = all.fold((0.0, 0.0), |(count, sum), (own, radius)| (count + own, sum + own * radius));
        sum / f64::max(count, 1.0)
    }

    /// Returns the number of grains at the start and of those that come by the end of the run, unless they find no places.
    pub fn most_grains(&self) -> usize {
        let come: f64 = self.insert.iter().map(|source| self.expected(source)).sum();
        self.grain_count().saturating_add(come as usize)
    }

    /// Returns the longest time of the run, or of the stage that is named, s.
    pub(super) fn longest_of(&self, name: Option<&String>) -> f64 {
        self.stage.iter().find(|stage| name == Some(&stage.name)).map_or(self.duration, Stage::longest)
    }

    /// Returns an estimate of the grains of a source by the end of the run.
    pub(crate) fn expected(&self, source: &Insertion) -> f64 {
        let mean = sphere_volume(source.radius.mean()) * self.material[&source.material].density;
        let rate = source.rate.or(source.mass_rate.map(|rate| rate / mean));
        let due = rate.map_or(f64::INFINITY, |rate| rate * source.elapsed(self.longest_of(source.stage.as_ref())));
        due.min(source.total.map_or(f64::INFINITY, |total| total as f64))
    }
}

/// Checks the sources and the sinks.
pub(super) fn check(scene: &Scene) -> Checked {
    let root = DocumentPath::default();
    let mut count = scene.grain_count() as f64;
    for (index, source) in scene.insert.iter().enumerate() {
        let at = root.key("insert").index(index);
        known_stage(scene, &at, source.stage.as_ref())?;
        check_source(scene, &at, source)?;
        count += scene.expected(source);
        let problem = || format!("{} grains by the end of the run, with those before them", short(count.round()));
        let remedy = format!("lower the rate, or give a total, for at most {MOST_GRAINS:e} grains");
        at.require(count <= MOST_GRAINS, problem, &remedy)?;
    }
    for (index, Removal { region, stage, from, until }) in scene.remove.iter().enumerate() {
        let at = root.key("remove").index(index);
        known_stage(scene, &at, stage.as_ref())?;
        region.check(&at.key("region"))?;
        times(&at, *from, *until)?;
        in_domain(scene, &at.key("region"), region.bounds(), false)?;
    }
    Ok(())
}

fn check_source(scene: &Scene, at: &DocumentPath, source: &Insertion) -> Checked {
    known_material(scene, &at.key("material"), &source.material)?;
    source.radius.check(&at.key("radius"))?;
    source.region.check(&at.key("region"))?;
    at.key("velocity").finite(&source.velocity)?;
    times(at, source.from, source.until)?;
    match (source.rate, source.mass_rate, source.total) {
        (None, None, None) => {
            let remedy = "give rate (grains/s), mass_rate (kg/s) or total (grains)";
            return Err(at.fault("has neither a rate nor a total".into(), remedy));
        }
        (Some(_), Some(_), _) => {
            let remedy = "leave one out: rate is in grains/s, mass_rate in kg/s";
            return Err(at.key("mass_rate").fault("given in addition to rate".into(), remedy));
        }
        (rate, mass_rate, total) => {
            at.key("rate").range(rate.unwrap_or(1.0), 1e-9, 1e9, "grains/s")?;
            at.key("mass_rate").range(mass_rate.unwrap_or(1.0), 1e-15, 1e9, "kg/s")?;
            at.key("total").range(total.unwrap_or(1) as f64, 1.0, MOST_GRAINS, "grains")?;
        }
    }
    in_domain(scene, &at.key("region"), source.region.bounds(), true)?;
    let (volume, width) = source.region.size();
    let largest = 2.0 * source.radius.bounds().1;
    let problem = || format!("{} m wide, and the largest grains have a diameter of {} m", short(width), short(largest));
    let remedy = "enlarge it, or lower the radius: grains lie entirely inside";
    at.key("region").require(width >= largest, problem, remedy)?;
    rate_can_be_met(scene, at, source, volume, width)
}

/// Refuses a rate that fills the region. New grains move on average for at least the time `t` with `|v| t + g t^2/2 = w/8`
/// before they leave a region of the smallest extent w, the mean distance of a place in a cube from its surface. Until then,
/// `rate t` grains occupy the region (J. D. C. Little, Operations Research 9 (1961), 383-387).
fn rate_can_be_met(scene: &Scene, at: &DocumentPath, source: &Insertion, volume: f64, width: f64) -> Checked {
    let density = scene.material[&source.material].density;
    let least = sphere_volume(source.radius.bounds().0);
    let (key, given, solid) = match (source.rate, source.mass_rate) {
        (Some(rate), _) => ("rate", rate, rate * least),
        (_, Some(rate)) => ("mass_rate", rate, rate / density),
        _ => return Ok(()),
    };
    let (speed, gravity) = (Vector3::from(source.velocity).norm(), scene.largest_gravity());
    let stay = 0.25 * width / (speed + (speed * speed + 0.25 * gravity * width).sqrt());
    let active = source
        .elapsed(scene.longest_of(source.stage.as_ref()))
        .min(source.total.map_or(f64::INFINITY, |total| total as f64 * least / solid));
    let most = FULL * volume / stay.min(active);
    let problem = || {
        let given = short(given);
        format!("{given} cannot be met: new grains would fill more than {FULL} of the region before they leave it")
    };
    let possible = short((given * most / solid * 1e3).floor() * 1e-3);
    let remedy = format!("lower it to at most {possible}, enlarge the region, or raise velocity");
    at.key(key).require(solid <= most, problem, &remedy)
}

fn times(at: &DocumentPath, from: f64, until: Option<f64>) -> Checked {
    at.key("from").range(from, 0.0, 1e6, "s")?;
    at.key("until").range(until.unwrap_or(from), from, 1e6, "s")
}
