//! Mixing of two kinds of grains: by origin, by size, or by population.

use super::catalogue::{Group, define};
use super::measurement::Readings;
use super::view::View;
use makadam::snapshot::Particle;
use makadam_frames::plan::Observable;
use nalgebra::Vector3;

pub(super) const GROUP: Group = Group {
    observable: Observable::SizeMixing,
    name: "size-mixing",
    read,
    definitions: &[
        define(
            ["size_mixing_index", "M_d", ""],
            "Lacey's index of the small grains in cells of three mean diameters: 0 apart, 1 mixed at random",
        )
        .source("Lacey, J. Appl. Chem. 4, 257 (1954)"),
        define(
            ["small_over_large_distance", "R_d", ""],
            "root mean square distance of small grains from the middle of the bed over that of large ones; below 1 \
             where they form a core",
        ),
        define(["population_mixing_index", "M_p", ""], "Lacey's index of the first population")
            .source("Lacey, J. Appl. Chem. 4, 257 (1954)"),
        define(
            ["first_over_other_distance", "R_p", ""],
            "root mean square distance of the first population from the middle of the bed over that of the others",
        ),
    ],
};

/// Width of the cells of the mixing index, mean diameters.
pub(super) const MIXING_CELL: f64 = 3.0;

/// Smallest number of grains in a cell that counts: cells at the rim of a bed hold fewer.
const FEWEST: f64 = 5.0;

/// Smallest ratio of the largest to the smallest radius in a bed of two sizes.
const TWO_SIZES: f64 = 1.3;

/// Returns Lacey's mixing index of marked grains, given positions (m) and marks: `(s0^2 - s^2)/(s0^2 - sr^2)` with the variance of the
/// fraction of marked grains over cells (`cell`, m), actual, unmixed and random: 0 for unmixed and 1 for random (Lacey, J. Appl.
/// Chem. 4, 257, 1954). `None` if there are too few grains.
pub fn lacey_index(places: impl Iterator<Item = ([f64; 3], bool)>, cell: f64) -> Option<f64> {
    // Sorted, so that sums have the same order in every run.
    let mut grains: Vec<([i64; 3], bool)> =
        places.map(|(place, is_marked)| (place.map(|x| (x / cell).floor() as i64), is_marked)).collect();
    grains.sort_unstable();
    let counts = grains.chunk_by(|(one, _), (other, _)| one == other).map(|grains| {
        let marked = grains.iter().filter(|(_, is_marked)| *is_marked).count();
        (marked as f64, grains.len() as f64)
    });
    let full: Vec<(f64, f64)> = counts.filter(|(_, all)| *all >= FEWEST).collect();
    let total: f64 = full.iter().map(|(_, all)| all).sum();
    let share = full.iter().map(|(marked, _)| marked).sum::<f64>() / total;
    let variance = full.iter().map(|(marked, all)| all * (marked / all - share).powi(2)).sum::<f64>() / total;
    let unmixed = share * (1.0 - share);
    let random = unmixed * full.len() as f64 / total;
    let index = (unmixed - variance) / (unmixed - random);
    (full.len() >= 5 && index.is_finite()).then_some(index)
}

/// Adds a frame's readings: by size for grains of very different sizes, by population for several populations.
///
/// Small grains have radii below the middle of the smallest and the largest radius. The same quantity by population, for grains
/// of equal size, separates the effect of size from the effect of the drum.
fn read(view: &View<'_>, readings: &mut Readings) -> Result<(), String> {
    let radii = || view.frame.particles.iter().map(|grain| grain.radius);
    let (smallest, largest) = (radii().fold(f64::INFINITY, f64::min), radii().fold(0.0, f64::max));
    if largest >= TWO_SIZES * smallest {
        let middle = 0.5 * (smallest + largest);
        read_kinds(view, ["size_mixing_index", "small_over_large_distance"], &|grain| grain.radius < middle, readings);
    }
    if view.setting.scene().population.len() > 1 {
        let population = |grain: &Particle| view.setting.properties.roster.kind(view.frame, grain.id).population;
        read_kinds(
            view,
            ["population_mixing_index", "first_over_other_distance"],
            &|grain| population(grain) == Some(0),
            readings,
        );
    }
    match largest >= TWO_SIZES * smallest {
        true => Ok(()),
        false => Err(format!("the largest radius is less than {TWO_SIZES} of the smallest")),
    }
}

/// Adds the mixing index of marked grains and, in drums, the ratio of their distance from the middle of the bed to that of the others.
fn read_kinds(
    view: &View<'_>,
    [index, distance]: [&'static str; 2],
    is_marked: &dyn Fn(&Particle) -> bool,
    readings: &mut Readings,
) {
    let grains = &view.frame.particles;
    let middle = view.setting.middle();
    let place = |grain: &Particle| (Vector3::from(grain.position) - middle).into();
    let marks = grains.iter().map(|grain| (place(grain), is_marked(grain)));
    if let Some(value) = lacey_index(marks, MIXING_CELL * view.setting.diameter) {
        readings.add(index, value);
    }
    let Some(drum) = &view.setting.drum else { return };
    let volume = |grain: &Particle| grain.radius.powi(3);
    let total: f64 = grains.iter().map(volume).sum();
    let middle = grains.iter().map(|grain| Vector3::from(grain.position) * volume(grain)).sum::<Vector3<f64>>();
    let [x, y] = drum.section(&(middle / total));
    let spread = |marked: bool| {
        let own = grains.iter().filter(|grain| is_marked(grain) == marked);
        let squares: Vec<f64> = own
            .map(|grain| {
                let [across, up] = drum.section(&grain.position.into());
                (across - x).powi(2) + (up - y).powi(2)
            })
            .collect();
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
    };
    let ratio = spread(true) / spread(false);
    if ratio.is_finite() {
        readings.add(distance, ratio);
    }
}

#[cfg(test)]
#[path = "../../tests/unit/observables_mixing.rs"]
mod tests;
