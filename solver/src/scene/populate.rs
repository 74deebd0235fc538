//! The grains that every code starts from: generated once, from the scene and a seed.

use super::error::{Fault, Step};
use super::{Domain, Population, RadiusDistribution, Region, Scene, SceneError, Shape};
use crate::effects::period::Period;
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use rand_core::{RngCore, SeedableRng};
use std::collections::HashMap;
use std::path::Path;

/// Most lattice sites of a region, used or not; a scene cannot have as many grains.
const MOST_SITES: f64 = 2e8;

/// A grain at the start.
#[derive(Clone, Debug, PartialEq)]
pub struct Grain {
    /// Name of its material.
    pub material: String,
    /// Radius, metres.
    pub radius: f64,
    /// Centre, metres.
    pub position: [f64; 3],
    /// Velocity, m/s.
    pub velocity: [f64; 3],
    /// Angular velocity, rad/s.
    pub spin: [f64; 3],
}

/// Places the scene's grains: listed grains first, then each population, all numbered in that order.
///
/// The generator is ChaCha8 seeded with `seed`; equal scenes and seeds give equal bits. `file` is named in errors.
///
/// # Errors
/// [`SceneError::Invalid`] if a population does not fit its region, a grain lies outside the domain or its
/// container, or two grains overlap by more than `largest_start_overlap` of the smaller radius.
pub fn populate(scene: &Scene, seed: u64, file: &Path) -> Result<Vec<Grain>, SceneError> {
    place(scene, seed).map_err(|fault| {
        let text = std::fs::read_to_string(file).unwrap_or_default();
        fault.locate(file, &text)
    })
}

fn place(scene: &Scene, seed: u64) -> Result<Vec<Grain>, Fault> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut grains: Vec<Grain> = scene
        .grain
        .iter()
        .map(|entry| Grain {
            material: entry.material.clone(),
            radius: entry.radius,
            position: entry.position,
            velocity: entry.velocity,
            spin: entry.spin,
        })
        .collect();
    let mut origin: Vec<Vec<Step>> =
        (0..grains.len()).map(|i| vec![Step::Key("grain"), Step::Index(i), Step::Key("position")]).collect();
    for (index, population) in scene.population.iter().enumerate() {
        let at = vec![Step::Key("population"), Step::Index(index)];
        let placed = lattice_gas(scene, population, &mut random).map_err(|misfit| misfit.fault(&at, population))?;
        origin.resize(grains.len() + placed.len(), at);
        grains.extend(placed);
    }
    inside_container(scene, &grains, &origin)?;
    no_overlap(scene, &grains, &origin)?;
    Ok(grains)
}

/// Why a population cannot be placed.
enum Misfit {
    /// Its region has only so many lattice sites.
    TooSmall(usize),
    /// Its region has so many lattice sites that they cannot be listed.
    TooLarge(f64),
}

impl Misfit {
    fn fault(self, at: &[Step], population: &Population) -> Fault {
        let (key, problem, remedy) = match self {
            Misfit::TooSmall(sites) => (
                "count",
                format!("{} grains do not fit their region: it has {sites} lattice sites", population.count),
                "enlarge the region, lower the count, or lower the spacing",
            ),
            Misfit::TooLarge(sites) => (
                "region",
                format!("the region has {sites:e} lattice sites, more than {MOST_SITES:e}"),
                "make the region smaller, or the radius or the spacing larger",
            ),
        };
        Fault { path: [at, &[Step::Key(key)]].concat(), problem, remedy: remedy.into() }
    }
}

/// Uniform in [0, 1) from the upper 53 bits.
fn uniform(random: &mut ChaCha8Rng) -> f64 {
    (random.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
}

fn symmetric(random: &mut ChaCha8Rng) -> f64 {
    2.0 * uniform(random) - 1.0
}

fn draw_radius(distribution: &RadiusDistribution, random: &mut ChaCha8Rng) -> f64 {
    match distribution {
        RadiusDistribution::Fixed { value } => *value,
        RadiusDistribution::Uniform { mean, spread } => mean * (1.0 + spread * symmetric(random)),
        RadiusDistribution::Normal { mean, deviation, min, max } => loop {
            // Marsaglia's polar method: no trigonometric function, and a logarithm with the same bits everywhere.
            let (u, v) = (symmetric(random), symmetric(random));
            let s = u * u + v * v;
            if s > 0.0 && s < 1.0 {
                let radius = mean + deviation * u * (-2.0 * libm::log(s) / s).sqrt();
                if (*min..=*max).contains(&radius) {
                    return radius;
                }
            }
        },
        RadiusDistribution::Discrete { radii, shares } => {
            let mut left = uniform(random) * shares.iter().sum::<f64>();
            for (radius, share) in radii.iter().zip(shares) {
                left -= share;
                if left < 0.0 {
                    return *radius;
                }
            }
            radii[radii.len() - 1]
        }
    }
}

/// Fills the lowest lattice sites of the region.
fn lattice_gas(scene: &Scene, population: &Population, random: &mut ChaCha8Rng) -> Result<Vec<Grain>, Misfit> {
    let largest = population.radius.bounds().1;
    let pitch = 2.0 * largest * population.spacing;
    let jitter = 0.5 * (pitch - 2.0 * largest);
    let mut sites = lattice_sites(&population.region, pitch, largest, jitter)?;
    if sites.len() < population.count {
        return Err(Misfit::TooSmall(sites.len()));
    }
    // Lowest first, so that the bed forms without a long fall; ties keep lattice order.
    let up = -Vector3::from(scene.gravity);
    let layer = |site: &Vector3<f64>| (site.dot(&up) / (up.norm().max(1e-300) * 0.5 * pitch)).round() as i64;
    sites.sort_by_key(layer);
    sites.truncate(population.count);
    let grains = sites.into_iter().map(|site| {
        let offset = Vector3::from_fn(|_, _| jitter * symmetric(random));
        let velocity = Vector3::from_fn(|_, _| population.agitation * symmetric(random));
        Grain {
            material: population.material.clone(),
            radius: draw_radius(&population.radius, random),
            position: (site + offset).into(),
            velocity: velocity.into(),
            spin: [0.0; 3],
        }
    });
    Ok(grains.collect())
}

/// Sites of a cubic lattice of the given pitch, centred, whose grains stay inside the region wherever the jitter moves them.
fn lattice_sites(region: &Region, pitch: f64, largest: f64, jitter: f64) -> Result<Vec<Vector3<f64>>, Misfit> {
    let reach = largest + jitter;
    let (min, max) = match region {
        Region::Box { min, max } => (Vector3::from(*min), Vector3::from(*max)),
        Region::Cylinder { base, axis, radius, length } => {
            let axis = Vector3::from(*axis).normalize();
            let (a, b) = (Vector3::from(*base), Vector3::from(*base) + axis * *length);
            let side = axis.map(|c| radius * (1.0 - c * c).max(0.0).sqrt());
            (a.inf(&b) - side, a.sup(&b) + side)
        }
    };
    let inside = |site: &Vector3<f64>| match region {
        Region::Box { .. } => true,
        Region::Cylinder { base, axis, radius, length } => {
            let axis = Vector3::from(*axis).normalize();
            let arm = site - Vector3::from(*base);
            let along = arm.dot(&axis);
            // The jitter may move a grain along a diagonal of the cross-section.
            let spare = largest + jitter * std::f64::consts::SQRT_2;
            (arm - axis * along).norm() <= radius - spare && along >= reach && along <= length - reach
        }
    };
    let room = (max - min).map(|width| width - 2.0 * reach);
    if room.min() < 0.0 {
        return Ok(Vec::new());
    }
    let count = room.map(|width| (width / pitch + 1e-9).floor());
    let all = count.map(|sites| sites + 1.0).product();
    if all > MOST_SITES {
        return Err(Misfit::TooLarge(all));
    }
    let start = min + (max - min - count * pitch) * 0.5;
    let mut sites = Vec::new();
    for k in 0..=count.z as usize {
        for j in 0..=count.y as usize {
            for i in 0..=count.x as usize {
                let site = start + Vector3::new(i as f64, j as f64, k as f64) * pitch;
                if inside(&site) {
                    sites.push(site);
                }
            }
        }
    }
    Ok(sites)
}

/// Every grain starts inside the domain and on the right side of every wall.
fn inside_container(scene: &Scene, grains: &[Grain], origin: &[Vec<Step>]) -> Result<(), Fault> {
    let fault = |index: usize, what: String, remedy: &str| Fault {
        path: origin[index].clone(),
        problem: format!("grain {index} at {:?} {what}", grains[index].position),
        remedy: remedy.into(),
    };
    let period = scene.domain.period();
    for (index, grain) in grains.iter().enumerate() {
        let outside = (0..3)
            .any(|axis| grain.position[axis] < scene.domain.min[axis] || grain.position[axis] > scene.domain.max[axis]);
        if outside {
            return Err(fault(index, "lies outside the domain".into(), "move it inside or enlarge [domain]"));
        }
        for wall in &scene.wall {
            let overlap = wall_overlap(&wall.shape, &period, grain);
            if overlap > scene.largest_start_overlap * grain.radius {
                return Err(fault(
                    index,
                    format!("lies {overlap:.3e} m inside or behind wall '{}'", wall.name),
                    "move the grain or its region away from the wall, into the container",
                ));
            }
        }
    }
    Ok(())
}

/// How deep a grain reaches into a wall (or behind it) at the start, metres; negative where it is clear of it.
fn wall_overlap(shape: &Shape, period: &Period, grain: &Grain) -> f64 {
    let centre = Vector3::from(grain.position);
    match shape {
        Shape::Plane { point, normal } => {
            grain.radius - Vector3::from(*normal).normalize().dot(&(centre - Vector3::from(*point)))
        }
        Shape::Box { min, max, open } => {
            let mut deepest = f64::NEG_INFINITY;
            for (axis, name) in ["x", "y", "z"].iter().enumerate() {
                if !open.contains(&format!("-{name}")) {
                    deepest = deepest.max(grain.radius - (centre[axis] - min[axis]));
                }
                if !open.contains(&format!("+{name}")) {
                    deepest = deepest.max(grain.radius - (max[axis] - centre[axis]));
                }
            }
            deepest
        }
        Shape::Cylinder { base, axis, radius, length } => {
            let axis = Vector3::from(*axis).normalize();
            let arm = centre - Vector3::from(*base);
            let along = arm.dot(&axis);
            let across = (arm - axis * along).norm();
            let past_end = (-along).max(along - length).max(0.0);
            grain.radius - (across - radius).hypot(past_end)
        }
        Shape::Spheres { centres, radius } => {
            let gaps = centres.iter().map(|middle| period.arm(&centre, &Vector3::from(*middle)).norm() - radius);
            grain.radius - gaps.fold(f64::INFINITY, f64::min)
        }
        Shape::Disc { centre: middle, normal, radius, hole } => {
            let normal = Vector3::from(*normal).normalize();
            let arm = centre - Vector3::from(*middle);
            let height = normal.dot(&arm);
            let across = (arm - normal * height).norm();
            // It has two sides, so that nothing lies behind it.
            grain.radius - (across - across.clamp(*hole, *radius)).hypot(height)
        }
    }
}

fn no_overlap(scene: &Scene, grains: &[Grain], origin: &[Vec<Step>]) -> Result<(), Fault> {
    let size = 2.0 * grains.iter().map(|grain| grain.radius).fold(1e-12, f64::max);
    let cell = |position: &[f64; 3]| position.map(|x| (x / size).floor() as i64);
    let mut cells: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
    let period = scene.domain.period();
    for (index, grain) in grains.iter().enumerate() {
        for neighbour in images(&grain.position, &period, &scene.domain, size).flat_map(|image| around(cell(&image))) {
            for &other in cells.get(&neighbour).into_iter().flatten() {
                let there = &grains[other];
                let distance = period.arm(&grain.position.into(), &there.position.into()).norm();
                let overlap = grain.radius + there.radius - distance;
                if overlap > scene.largest_start_overlap * grain.radius.min(there.radius) {
                    return Err(Fault {
                        path: origin[index].clone(),
                        problem: format!("grains {other} and {index} overlap by {overlap:.3e} m at the start"),
                        remedy: format!(
                            "move them apart: at most {} of the smaller radius is accepted (largest_start_overlap)",
                            scene.largest_start_overlap
                        ),
                    });
                }
            }
        }
        cells.entry(cell(&grain.position)).or_default().push(index);
    }
    Ok(())
}

/// A cell and those around it.
fn around([x, y, z]: [i64; 3]) -> impl Iterator<Item = [i64; 3]> {
    (0..27).map(move |n| [x + n % 3 - 1, y + n / 3 % 3 - 1, z + n / 9 - 1])
}

/// A point and those of its images that lie within `reach` (m) of the domain.
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
