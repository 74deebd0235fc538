//! Coordination: contacts per grain in the bulk.
//!
//! The geometric number needs no force, so that rigid and soft codes are measured alike. Rattlers are removed repeatedly, with their
//! contacts, until none is left; contacts with walls support a grain, too.

use super::catalogue::{ALL_CONTACTS, Group, define};
use super::measurement::Readings;
use super::view::{TOUCHING, View};
use makadam::snapshot::{Particle, Partner};
use makadam_frames::plan::Observable;

const SILBERT: &str = "Silbert, Soft Matter 6, 2918 (2010); Shundyak et al., Phys. Rev. E 75, 010301 (2007)";

pub(super) const GROUP: Group = Group {
    observable: Observable::CoordinationNumber,
    name: "coordination-number",
    read,
    definitions: &[
        define(
            ["coordination_number", "Z", ""],
            "neighbours per grain of the bulk whose gap is below 1% of the mean diameter",
        ),
        define(
            ["coordination_number_without_rattlers", "Z_nr", ""],
            "Z of the grains that remain after repeated removal of rattlers (fewer than 2 supports with friction, 4 \
             without)",
        )
        .source(SILBERT),
        define(["rattler_share", "χ_r", ""], "fraction of the grains of the bulk that are rattlers").source(SILBERT),
        define(
            ["mechanical_coordination_number", "Z_m", ""],
            "contacts with f_n > 0 per grain of the bulk, with grains and walls",
        )
        .needs(ALL_CONTACTS),
        define(["bulk_grains", "N_b", ""], "grains in the bulk: two mean diameters from walls and free surface"),
    ],
};

fn read(view: &View<'_>, readings: &mut Readings) -> Result<(), String> {
    view.bulk()?;
    let in_bulk = view.in_bulk();
    let bulk = in_bulk.iter().filter(|inside| **inside).count();
    readings.add("bulk_grains", bulk as f64);
    let mean_over = |counts: &[usize], chosen: &dyn Fn(usize) -> bool| {
        let picked: Vec<usize> = (0..counts.len()).filter(|&grain| in_bulk[grain] && chosen(grain)).collect();
        picked.iter().map(|&grain| counts[grain]).sum::<usize>() as f64 / picked.len() as f64
    };

    let mut neighbours = vec![0; in_bulk.len()];
    for pair in view.pairs() {
        neighbours[pair.first] += 1;
        neighbours[pair.second] += 1;
    }
    readings.add("coordination_number", mean_over(&neighbours, &|_| true));

    let held = held_grains(view, &neighbours);
    let mut among_held = vec![0; in_bulk.len()];
    for pair in view.pairs().iter().filter(|pair| held[pair.first] && held[pair.second]) {
        among_held[pair.first] += 1;
        among_held[pair.second] += 1;
    }
    readings.add("coordination_number_without_rattlers", mean_over(&among_held, &|grain| held[grain]));
    let rattlers = (0..in_bulk.len()).filter(|&grain| in_bulk[grain] && !held[grain]).count();
    readings.add("rattler_share", rattlers as f64 / bulk as f64);

    let mut pushed = vec![0; in_bulk.len()];
    for contact in view.frame.contacts.iter().filter(|contact| contact.normal_force > 0.0) {
        let second = match contact.second {
            Partner::Grain(id) => view.place(id),
            Partner::Wall(_) => None,
        };
        for grain in [view.place(contact.first), second].into_iter().flatten() {
            pushed[grain] += 1;
        }
    }
    if !view.frame.contacts.is_empty() {
        readings.add("mechanical_coordination_number", mean_over(&pushed, &|_| true));
    }
    Ok(())
}

/// Returns the grains left after repeated removal of rattlers, given the number of neighbours of each grain.
fn held_grains(view: &View<'_>, neighbours: &[usize]) -> Vec<bool> {
    let grains = &view.frame.particles;
    let needed = if view.setting.properties.frictional() { 2 } else { 4 };
    let reach = TOUCHING * view.setting.diameter;
    let walls = |(grain, distance): (&Particle, &f64)| match grain.radius + reach {
        within if *distance < within => view.walls.within(&grain.position.into(), within),
        _ => 0,
    };
    let mut supports: Vec<usize> = grains.iter().zip(view.wall_distances()).map(walls).collect();
    supports.iter_mut().zip(neighbours).for_each(|(supports, count)| *supports += count);
    // Neighbours of all grains in one list; those of a grain end at `ends[grain]`.
    let mut ends: Vec<usize> =
        neighbours.iter().scan(0, |end, count| Some(std::mem::replace(end, *end + count))).collect();
    let mut touching = vec![0; 2 * view.pairs().len()];
    for (grain, other) in view.pairs().iter().flat_map(|pair| [(pair.first, pair.second), (pair.second, pair.first)]) {
        touching[ends[grain]] = other;
        ends[grain] += 1;
    }
    let mut held = vec![true; grains.len()];
    let mut loose: Vec<usize> = (0..grains.len()).filter(|&grain| supports[grain] < needed).collect();
    loose.iter().for_each(|&grain| held[grain] = false);
    while let Some(rattler) = loose.pop() {
        for &neighbour in &touching[ends[rattler] - neighbours[rattler]..ends[rattler]] {
            supports[neighbour] -= 1;
            if held[neighbour] && supports[neighbour] < needed {
                held[neighbour] = false;
                loose.push(neighbour);
            }
        }
    }
    held
}
