//! Initial grains: generated once from the scene and a seed, the same for every code.

use super::document::DocumentPath;
use super::error::{Fault, short};
use super::{Domain, Grain, Placement, Population, Region, Scene, SceneError};
use crate::laws::period::Period;
use crate::surface::Surface;
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use rand_core::{RngCore, SeedableRng};
use std::collections::HashMap;

/// Largest number of lattice sites of a region, occupied or not; a scene cannot have as many grains.
const MOST_SITES: f64 = 2e8;

/// Number of tries to find a random free place for a grain.
const TRIES: usize = 10_000;

/// Places the scene's grains: listed grains first, then those of the start file and each population, all numbered in that order.
///
/// The generator is ChaCha8 seeded with `seed`; equal scenes and seeds give equal bits.
///
/// # Errors
/// [`SceneError::Invalid`] if a population does not fit its region, a grain lies outside the domain or its
/// container, or two grains overlap by more than `largest_start_overlap` of the smaller radius.
pub fn populate(scene: &Scene, seed: u64) -> Result<Vec<Grain>, SceneError> {
    let grains = placed(scene, seed)?;
    inside_container(scene, &grains)?;
    no_overlap(scene, &grains)?;
    Ok(grains)
}

/// Returns the initial grains without a check of domain, container or overlap.
pub(super) fn placed(scene: &Scene, seed: u64) -> Result<Vec<Grain>, SceneError> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut grains = Vec::new();
    reserve(&mut grains, scene.grain_count().min(MOST_SITES as usize))?;
    grains.extend(scene.listed().cloned());
    for (index, population) in scene.population.iter().enumerate() {
        let at = DocumentPath::default().key("population").index(index);
        match population.placement {
            Placement::Lattice => jittered_lattice(scene, population, &at, &mut random, &mut grains)?,
            Placement::Random => random_places(scene, population, &at, &mut random, &mut grains)?,
        }
    }
    Ok(grains)
}

/// Path in the scene of the entry that defines a grain.
pub(super) fn origin(scene: &Scene, grain: usize) -> DocumentPath {
    let (root, mut before) = (DocumentPath::default(), scene.listed().count());
    if grain < scene.grain.len() {
        return root.key("grain").index(grain).key("position");
    }
    if grain < before {
        return root.key("start").key("file");
    }
    let index = scene.population.iter().position(|population| {
        before += population.count;
        grain < before
    });
    root.key("population").index(index.unwrap_or(0))
}

/// Reserves memory for more entries; returns an error if the allocation fails.
fn reserve<T>(list: &mut Vec<T>, more: usize) -> Result<(), SceneError> {
    list.try_reserve(more).map_err(|_| SceneError::Memory { bytes: more.saturating_mul(size_of::<T>()) })
}

/// Returns a uniform random number in [0, 1) from the upper 53 bits.
pub(super) fn uniform(random: &mut ChaCha8Rng) -> f64 {
    (random.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
}

pub(super) fn symmetric(random: &mut ChaCha8Rng) -> f64 {
    2.0 * uniform(random) - 1.0
}

/// Fills the lowest lattice sites of the region.
fn jittered_lattice(
    scene: &Scene,
    population: &Population,
    at: &DocumentPath,
    random: &mut ChaCha8Rng,
    grains: &mut Vec<Grain>,
) -> Result<(), SceneError> {
    let lattice = Lattice::of(population);
    let mut sites = lattice.sites(&population.region, at)?;
    if sites.len() < population.count {
        let (count, sites) = (population.count, sites.len());
        let problem = format!("{count} grains do not fit their region: it has {sites} lattice sites");
        let remedy = "enlarge the region, or lower the count, the spacing or the radius, which is in metres";
        return Err(Fault::new(at.key("count"), problem, remedy).into());
    }
    // The lowest sites come first, so that the bed forms without a long fall; sites of equal height retain lattice order.
    let up = -Vector3::from(scene.gravity);
    let mut radii = population.radius.all(population.count, random);
    let layer = |site: &Vector3<f64>| (site.dot(&up) / (up.norm().max(1e-300) * 0.5 * lattice.pitch)).round() as i64;
    sites.sort_by_key(layer);
    grains.extend(sites[..population.count].iter().map(|site| {
        let offset = Vector3::from_fn(|_, _| lattice.jitter * symmetric(random));
        let velocity = Vector3::from_fn(|_, _| population.agitation * symmetric(random));
        Grain {
            material: population.material.clone(),
            radius: radii(random),
            position: (site + offset).into(),
            velocity: velocity.into(),
            spin: [0.0; 3],
        }
    }));
    Ok(())
}

/// Places the grains at random where they overlap no other grain and no wall, the largest first. Their numbers follow the order in which radii
/// are drawn, so that large and small grains are mixed.
fn random_places(
    scene: &Scene,
    population: &Population,
    at: &DocumentPath,
    random: &mut ChaCha8Rng,
    grains: &mut Vec<Grain>,
) -> Result<(), SceneError> {
    let mut draw = population.radius.all(population.count, random);
    let radii: Vec<f64> = (0..population.count).map(|_| draw(random)).collect();
    let mut order: Vec<usize> = (0..radii.len()).collect();
    order.sort_by(|&one, &other| radii[other].total_cmp(&radii[one]));
    let ((_, width), diameter) = (population.region.size(), order.first().map_or(0.0, |&largest| 2.0 * radii[largest]));
    if width < diameter {
        let (width, diameter) = (short(width), short(diameter));
        let problem = format!("it is {width} m wide, and the largest grain has a diameter of {diameter} m");
        let remedy = "enlarge the region or lower the radius: grains lie entirely inside";
        return Err(Fault::new(at.key("region"), problem, remedy).into());
    }
    let largest = grains.iter().map(|grain| grain.radius).fold(population.radius.bounds().1, f64::max);
    let mut neighbours = Neighbours::new(&scene.domain, largest);
    grains.iter().for_each(|grain| neighbours.add(&grain.position, grain.radius));
    let (first, period) = (grains.len(), scene.domain.period());
    let surfaces: Vec<Surface> = scene.wall.iter().map(|wall| Surface::of(&wall.shape, period)).collect();
    grains.extend(radii.iter().map(|&radius| Grain {
        material: population.material.clone(),
        radius,
        position: [0.0; 3],
        velocity: [0.0; 3],
        spin: [0.0; 3],
    }));
    for (placed, &number) in order.iter().enumerate() {
        let grain = &mut grains[first + number];
        let is_free = (0..TRIES).any(|_| {
            grain.position = population.region.draw(grain.radius, random).into();
            neighbours.find(&grain.position, grain.radius, |overlap, _| overlap > 0.0).is_none()
                && surfaces.iter().all(|surface| surface.depth(&grain.position.into(), grain.radius) <= 0.0)
        });
        if !is_free {
            let (number, count) = (placed + 1, population.count);
            let problem =
                format!("no free place was found in {TRIES} tries for grain {number} of {count}, the largest first");
            let remedy = "enlarge the region or lower the count: random places fill some 0.3 of a region with grains of one size";
            return Err(Fault::new(at.key("count"), problem, remedy).into());
        }
        neighbours.add(&grain.position, grain.radius);
        grain.velocity = Vector3::from_fn(|_, _| population.agitation * symmetric(random)).into();
    }
    Ok(())
}

/// Cubic lattice, centred in a region. Grains stay inside the region for every jitter.
struct Lattice {
    /// Distance of neighbours, m.
    pitch: f64,
    /// Largest distance of a grain from its site along each axis, m.
    jitter: f64,
    /// Largest radius, m.
    largest: f64,
    /// First site, m.
    start: Vector3<f64>,
    /// Number of further sites after the first along each axis; negative if no site fits.
    beyond: Vector3<f64>,
}

impl Lattice {
    fn of(population: &Population) -> Lattice {
        let largest = population.radius.bounds().1;
        let pitch = 2.0 * largest * population.spacing;
        let jitter = 0.5 * (pitch - 2.0 * largest);
        let reach = largest + jitter;
        let (min, max) = population.region.bounds();
        let (min, max) = (Vector3::from(min), Vector3::from(max));
        let room = (max - min).map(|width| width - 2.0 * reach);
        let beyond = room.map(|width| if width < 0.0 { -1.0 } else { (width / pitch + 1e-9).floor() });
        let start = min + (max - min - beyond * pitch) * 0.5;
        Lattice { pitch, jitter, largest, start, beyond }
    }

    /// Number of sites of the box around the region.
    fn in_box(&self) -> f64 {
        self.beyond.map(|sites| sites + 1.0).product()
    }

    fn sites(&self, region: &Region, at: &DocumentPath) -> Result<Vec<Vector3<f64>>, SceneError> {
        let reach = self.largest + self.jitter;
        let inside = |site: &Vector3<f64>| match region {
            Region::Box { .. } => true,
            Region::Cylinder { base, axis, radius, length } => {
                let axis = Vector3::from(*axis).normalize();
                let arm = site - Vector3::from(*base);
                let along = arm.dot(&axis);
                // The jitter may move a grain along a diagonal of the cross-section.
                let spare = self.largest + self.jitter * std::f64::consts::SQRT_2;
                (arm - axis * along).norm() <= radius - spare && along >= reach && along <= length - reach
            }
        };
        let all = self.in_box();
        if all > MOST_SITES {
            let problem = format!("the region has {all:e} lattice sites, more than {MOST_SITES:e}");
            let remedy = "make the region smaller, or the radius or the spacing larger";
            return Err(Fault::new(at.key("region"), problem, remedy).into());
        }
        let mut sites: Vec<Vector3<f64>> = Vec::new();
        if self.beyond.min() < 0.0 {
            return Ok(sites);
        }
        reserve(&mut sites, all as usize)?;
        for k in 0..=self.beyond.z as usize {
            for j in 0..=self.beyond.y as usize {
                for i in 0..=self.beyond.x as usize {
                    let site = self.start + Vector3::new(i as f64, j as f64, k as f64) * self.pitch;
                    if inside(&site) {
                        sites.push(site);
                    }
                }
            }
        }
        Ok(sites)
    }
}

impl Population {
    /// Number of lattice sites of the box around the region of the population.
    pub(super) fn sites(&self) -> f64 {
        Lattice::of(self).in_box().clamp(0.0, MOST_SITES)
    }
}

/// Checks that every grain starts inside the domain and on the correct side of every wall.
fn inside_container(scene: &Scene, grains: &[Grain]) -> Result<(), Fault> {
    let fault = |index: usize, what: String, remedy: &str| {
        Fault::new(origin(scene, index), format!("grain {index} at {:?} {what}", grains[index].position), remedy)
    };
    let period = scene.domain.period();
    let surfaces: Vec<Surface> = scene.wall.iter().map(|wall| Surface::of(&wall.shape, period)).collect();
    for (index, grain) in grains.iter().enumerate() {
        let outside = (0..3)
            .any(|axis| grain.position[axis] < scene.domain.min[axis] || grain.position[axis] > scene.domain.max[axis]);
        if outside {
            return Err(fault(index, "lies outside the domain".into(), "move it inside or enlarge [domain]"));
        }
        for (wall, surface) in scene.wall.iter().zip(&surfaces) {
            let overlap = surface.depth(&Vector3::from(grain.position), grain.radius);
            if overlap > scene.largest_start_overlap * grain.radius {
                let problem = format!("lies {overlap:.3e} m inside or behind wall '{}'", wall.name);
                return Err(fault(index, problem, &accepted("move the grain or its region into the container", scene)));
            }
        }
    }
    Ok(())
}

/// Returns a remedy of an overlap at the start, with the largest accepted one.
fn accepted(remedy: &str, scene: &Scene) -> String {
    let most = scene.largest_start_overlap;
    format!("{remedy}: at most {most} of the smaller radius is accepted (largest_start_overlap)")
}

fn no_overlap(scene: &Scene, grains: &[Grain]) -> Result<(), SceneError> {
    let largest = grains.iter().map(|grain| grain.radius).fold(0.0, f64::max);
    let mut neighbours = Neighbours::new(&scene.domain, largest);
    reserve(&mut neighbours.grains, grains.len())?;
    for (index, grain) in grains.iter().enumerate() {
        let overlapping = neighbours.find(&grain.position, grain.radius, |overlap, radius| {
            overlap > scene.largest_start_overlap * grain.radius.min(radius)
        });
        if let Some((other, overlap)) = overlapping {
            let problem = format!("grains {other} and {index} overlap by {overlap:.3e} m at the start");
            return Err(Fault::new(origin(scene, index), problem, accepted("move them apart", scene)).into());
        }
        neighbours.add(&grain.position, grain.radius);
    }
    Ok(())
}

/// Grains by cells, for the search of overlaps: a grid for each level of radii, which halve from level to level.
pub(crate) struct Neighbours<'a> {
    domain: &'a Domain,
    period: Period,
    /// Largest radius, m.
    largest: f64,
    levels: Vec<Level>,
    /// Centre and radius of each grain, m, and the previous grain in the same cell.
    grains: Vec<([f64; 3], f64, Option<usize>)>,
}

/// Grains with radii above half of the largest radius of a level, in cells as wide as its largest diameter.
#[derive(Default)]
struct Level {
    /// Largest radius, m.
    radius: f64,
    /// Last grain of each cell.
    last: HashMap<[i64; 3], usize>,
}

impl Level {
    fn cell(&self, place: &[f64; 3]) -> [i64; 3] {
        place.map(|x| (x / (2.0 * self.radius)).floor() as i64)
    }

    /// Returns the last grains of all cells that a cube around a point reaches, with a half width in m, and possibly of others.
    fn near(&self, point: &[f64; 3], reach: f64) -> Vec<usize> {
        let (low, high) = (self.cell(&point.map(|x| x - reach)), self.cell(&point.map(|x| x + reach)));
        let cells: f64 = (0..3).map(|axis| (high[axis] - low[axis] + 1) as f64).product();
        // A large grain reaches more cells of a fine level than are occupied.
        if cells > self.last.len() as f64 {
            return self.last.values().copied().collect();
        }
        let rows = (low[2]..=high[2]).flat_map(|z| (low[1]..=high[1]).map(move |y| [y, z]));
        let cells = rows.flat_map(|[y, z]| (low[0]..=high[0]).map(move |x| [x, y, z]));
        cells.filter_map(|cell| self.last.get(&cell).copied()).collect()
    }
}

impl<'a> Neighbours<'a> {
    /// Begins without grains, for radii up to `largest` (m).
    pub fn new(domain: &'a Domain, largest: f64) -> Neighbours<'a> {
        let largest = largest.max(1e-12);
        Neighbours { domain, period: domain.period(), largest, levels: Vec::new(), grains: Vec::new() }
    }

    /// Adds a grain, with its centre inside the domain along periodic axes.
    pub fn add(&mut self, position: &[f64; 3], radius: f64) {
        let level = libm::log2(self.largest / radius).clamp(0.0, 60.0) as usize;
        for number in self.levels.len()..=level {
            self.levels.push(Level { radius: self.largest * 0.5_f64.powi(number as i32), ..Level::default() });
        }
        let level = &mut self.levels[level];
        let before = level.last.insert(level.cell(position), self.grains.len());
        self.grains.push((*position, radius, before));
    }

    /// Returns the number and the overlap (m) of the first grain whose overlap (m) and radius (m) satisfy the predicate.
    pub fn find(&self, position: &[f64; 3], radius: f64, is_one: impl Fn(f64, f64) -> bool) -> Option<(usize, f64)> {
        let mut first: Option<(usize, f64)> = None;
        for image in images(position, &self.period, self.domain, 2.0 * self.largest) {
            for level in self.levels.iter().filter(|level| !level.last.is_empty()) {
                for newest in level.near(&image, radius + level.radius) {
                    for other in std::iter::successors(Some(newest), |&other| self.grains[other].2) {
                        let (there, its_radius, _) = self.grains[other];
                        let distance = self.period.arm(&(*position).into(), &there.into()).norm();
                        let overlap = radius + its_radius - distance;
                        if is_one(overlap, its_radius) && first.is_none_or(|(number, _)| other < number) {
                            first = Some((other, overlap));
                        }
                    }
                }
            }
        }
        first
    }
}

/// Returns a point and its periodic images within `reach` (m) of the domain.
fn images(point: &[f64; 3], period: &Period, domain: &Domain, reach: f64) -> impl Iterator<Item = [f64; 3]> {
    let laps = |axis: usize| if period.is_periodic(axis) { -1..=1 } else { 0..=0 };
    let mut images = Vec::new();
    for (i, j, k) in laps(0).flat_map(|i| laps(1).flat_map(move |j| laps(2).map(move |k| (i, j, k)))) {
        let image: [f64; 3] =
            std::array::from_fn(|axis| point[axis] + f64::from([i, j, k][axis]) * period.length(axis));
        if (0..3).all(|axis| image[axis] >= domain.min[axis] - reach && image[axis] <= domain.max[axis] + reach) {
            images.push(image);
        }
    }
    images.into_iter()
}
