//! Stress tests, group by group.
//!
//! Each case states its expected outcome and the reason. Bounds come from closed forms, conservation laws or the purpose of a
//! container's wall, never from the result of a code.

mod contacts;
mod drums;
mod impacts;
mod loads;

use crate::sketch::{GRAVITY, RADIUS, Sketch, hertz_overlap, mass};
use crate::stability::Case;
use crate::study::Finding;
use makadam::scene::Region;

/// Returns all cases, in the order of tables.
pub fn catalogue() -> Vec<Case> {
    [loads::cases(), starts(), impacts::cases(), contacts::cases(), drums::cases()].into_iter().flatten().collect()
}

fn starts() -> Vec<Case> {
    let mut cases: Vec<Case> = [1, 10, 50, 100].map(overlap).into();
    cases.extend([empty(), one_grain(), drift(), collision(), one_box()]);
    cases
}

fn overlap(percent: u32) -> Case {
    let apart = RADIUS * (1.0 - f64::from(percent) / 100.0);
    let scene = Sketch::new(format!("overlap-{percent}"), 0.05)
        .gravity([0.0; 3])
        .with(|scene| scene.largest_start_overlap = 2.0)
        .grain(RADIUS, [0.0, 0.0, 0.4 - apart])
        .grain(RADIUS, [0.0, 0.0, 0.4 + apart])
        .scene();
    let right = format!("two grains that overlap by {percent}% of a diameter part with no more than the energy stored");
    let source = "conservation of energy and momentum; Hertz's potential 2/5 k_H d^(5/2)";
    Case::new("initial overlaps", scene, right, source, move |evidence| {
        let stored = evidence.elastic(&evidence.frames()[0]);
        let fastest = (stored / evidence.mass(0)).sqrt();
        let momentum = evidence.momentum(evidence.last()).norm() / (evidence.mass(0) * fastest);
        vec![
            Finding::at_most("kinetic energy over what was stored", evidence.kinetic(evidence.last()) / stored, 1.01),
            Finding::at_most("overlap at the end over the radius", evidence.largest_overlap(0.0), 1e-3),
            Finding::at_most("momentum over one grain's largest", momentum, 1e-6),
        ]
    })
}

fn empty() -> Case {
    let scene = Sketch::new("no-grains", 0.1).floor().scene();
    let right = "a scene without grains runs to its end";
    Case::new("small scenes", scene, right, "nothing happens", |evidence| {
        vec![
            Finding::near("end of the run", evidence.last().time, 0.1, 1e-9).in_unit("s"),
            Finding::at_most("grains", evidence.last().particles.len() as f64, 0.0),
        ]
    })
}

fn one_grain() -> Case {
    let place = RADIUS - hertz_overlap(mass(RADIUS) * GRAVITY, [1e7; 2], RADIUS);
    let scene = Sketch::new("one-grain", 1.0).floor().grain(RADIUS, [0.0, 0.0, 0.05]).scene();
    let right = "one grain falls, bounces and comes to rest at the static overlap";
    Case::new("small scenes", scene, right, "Hertz's law", move |evidence| {
        let above = (evidence.grain(0).position[2] - place) / RADIUS;
        vec![
            Finding::near("grain above its place, over its radius", above, 0.0, 1e-4),
            Finding::at_most("largest speed at the end", evidence.fastest(), 1e-4).in_unit("m/s"),
        ]
    })
}

fn drift() -> Case {
    let scene = Sketch::new("drift", 1.0)
        .gravity([0.0; 3])
        .floor()
        .moving_grain(RADIUS, [-0.3, 0.0, 0.4], [0.5, 0.0, 0.0], [0.0, 0.0, 100.0])
        .scene();
    let right = "without gravity a grain flies straight on and keeps its spin";
    Case::new("zero gravity", scene, right, "Newton's first law", |evidence| {
        let grain = evidence.grain(0);
        vec![
            Finding::near("way over 0.5 m", (grain.position[0] + 0.3) / 0.5, 1.0, 1e-6),
            Finding::at_most("way aside", grain.position[1].abs().max((grain.position[2] - 0.4).abs()), 1e-9)
                .in_unit("m"),
            Finding::near("spin over 100 rad/s", grain.spin[2] / 100.0, 1.0, 1e-6),
        ]
    })
}

fn collision() -> Case {
    const RESTITUTION: f64 = 0.8;
    let scene = Sketch::new("collision", 0.2)
        .gravity([0.0; 3])
        .restitution(RESTITUTION)
        .moving_grain(RADIUS, [-0.05, 0.0, 0.4], [1.0, 0.0, 0.0], [0.0; 3])
        .grain(RADIUS, [0.0, 0.0, 0.4])
        .scene();
    let right = "a grain that is struck leaves at 0.9 of the speed, the other keeps 0.1";
    Case::new(
        "zero gravity",
        scene,
        right,
        "Newton's law of impact, restitution 0.8: (1 + e)/2 and (1 - e)/2",
        |evidence| {
            let [first, second] = [0, 1].map(|id| evidence.grain(id).velocity[0]);
            vec![
                Finding::near("speed of the grain that is struck", second, 0.5 * (1.0 + RESTITUTION), 0.01)
                    .in_unit("m/s"),
                Finding::near("sum of both speeds", first + second, 1.0, 1e-6).in_unit("m/s"),
            ]
        },
    )
}

fn one_box() -> Case {
    const HALF: f64 = 4.0 * RADIUS;
    let scene = Sketch::new("one-box", 1.0)
        .domain([-HALF, -HALF, 0.0], [HALF, HALF, 16.0 * RADIUS])
        .open_box([-HALF, -HALF, 0.0], [HALF, HALF, 16.0 * RADIUS])
        .population(50, RADIUS, Region::Box { min: [-HALF, -HALF, 0.0], max: [HALF, HALF, 16.0 * RADIUS] })
        .scene();
    let right = "a bed whose contacts all lie in one box of the solver comes to rest and bears its weight";
    Case::new("small scenes", scene, right, "balance of forces", |evidence| {
        vec![
            Finding::near("force on walls over weight", evidence.carried(0.1), 1.0, 0.01),
            Finding::at_most("largest speed at the end", evidence.fastest(), 0.01).in_unit("m/s"),
            Finding::at_most("grains lost", evidence.lost(), 0.0),
        ]
    })
}

#[cfg(test)]
#[path = "../../../tests/unit/stability_catalogue.rs"]
mod tests;
