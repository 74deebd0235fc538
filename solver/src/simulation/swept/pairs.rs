//! Impacts of grains whose paths cross within a step.
//!
//! Relative to a grain j, the centre of a grain i moves along `s h (v_i - v_j)`, 0 <= s <= 1. If this path is longer than the
//! smaller of their radii r <= q, its distance from the centre of j must not fall below
//!
//! ```text
//! R = r + q            without overlap at the start
//! q + 9/10 (d - q)     with overlap                                   d: distance of their centres at the start
//! 9/10 d               if the larger grain contains the other's centre
//! ```
//!
//! A shorter path from outside ends before the point of closest approach, or passes at 0.86 R or more: the next step finds an
//! overlap, or a grazing contact is missed. Two grains that come nearer receive the impulse of Newton's and Coulomb's impact
//! along the normal at that point, in order of impact time. They have the velocities after the impact for the whole step:
//! velocities are exact, and positions are known to the path of a step.
//!
//! The search for paths has two levels: blocks of grains that are adjacent in memory, and so in space, and then single grains.
//! Two blocks are skipped if no relative path is long enough, or if none leads from one block to the other. Grains that fly
//! together are skipped at any speed.

use super::{INVERSE_INERTIA, LONG_LEVEL, Passage, Strike, Struck, Vector, friction};
use crate::Simulation;
use crate::effects::friction::slip_speed;
use crate::effects::restitution::at_speed;
use crate::laws::period::Period;
use crate::schedule::{Each, Phase, Team};
use crate::world::World;
use std::ops::Range;

/// Grains of a block.
const BLOCK: usize = 32;

/// Rounding error of a distance, relative to the compared length.
const SLACK: f64 = 1e-9;

/// Pieces of a path per shortest period: the nearest image at the start of a piece stays the nearest along the piece.
const PIECES: f64 = 8.0;

/// Two grains that collide within the step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Meeting {
    /// Fraction of the step before the impact.
    share: f64,
    /// Body indices of the two grains; the first has the smaller id.
    places: [u32; 2],
}

/// Point of excessive approach between the paths of two grains.
struct PairImpact {
    share: f64,
    /// Unit normal from the first to the second.
    normal: Vector,
}

/// Bounds of grains: positions, m, velocities, m/s, and radii, m.
struct Bounds {
    low: Vector,
    high: Vector,
    slow: Vector,
    fast: Vector,
    radii: [f64; 2],
}

impl Bounds {
    fn of(world: &World, places: Range<usize>) -> Bounds {
        let infinite = Vector::repeat(f64::INFINITY);
        let none =
            Bounds { low: infinite, high: -infinite, slow: infinite, fast: -infinite, radii: [f64::INFINITY, 0.0] };
        places.fold(none, |all, place| {
            let (sphere, body) = (&world.spheres[place], &world.bodies[place]);
            let (centre, velocity) = (world.wrapped(&sphere.centre), Vector::from(body.velocity));
            Bounds {
                low: all.low.inf(&centre),
                high: all.high.sup(&centre),
                slow: all.slow.inf(&velocity),
                fast: all.fast.sup(&velocity),
                radii: [all.radii[0].min(sphere.radius), all.radii[1].max(sphere.radius)],
            }
        })
    }

    /// Returns true if the path between a grain of this block and one of another may be long, and lead from one block to the other.
    fn may_meet(&self, other: &Bounds, period: &Period, step: f64) -> bool {
        let path = (self.fast - other.slow).sup(&(other.fast - self.slow)).norm() * step * (1.0 + SLACK);
        if path <= self.radii[0].min(other.radii[0]) {
            return false;
        }
        let gaps: [f64; 3] = std::array::from_fn(|axis| {
            let (ahead, behind) = (other.low[axis] - self.high[axis], self.low[axis] - other.high[axis]);
            let gap = ahead.max(behind).max(0.0);
            // Around a periodic axis the path may be shorter.
            let length = period.length(axis);
            if length > 0.0 { gap.min((ahead.min(behind) + length).max(0.0)) } else { gap }
        });
        let reach = (self.radii[1] + other.radii[1] + path) * (1.0 + SLACK);
        Vector::from(gaps).norm_squared() <= reach * reach
    }
}

/// Returns the fraction of the path at which a point at `-arm` from the middle of a ball enters the radius; the start must be outside.
fn time_within(arm: &Vector, path: &Vector, radius: f64) -> Option<f64> {
    let (square, half, beyond) = (path.norm_squared(), arm.dot(path), arm.norm_squared() - radius * radius);
    let root = half * half - square * beyond;
    if root < 0.0 || beyond <= 0.0 || half <= 0.0 {
        return None;
    }
    // Smaller root of a quadratic, without a difference of large numbers.
    let share = beyond / (half + root.sqrt());
    (share <= 1.0).then_some(share)
}

impl PairImpact {
    fn of(world: &World, [i, j]: [usize; 2], step: f64) -> Option<PairImpact> {
        let velocity = |place: usize| Vector::from(world.bodies[place].velocity);
        let [own, other] = [i, j].map(|place| world.spheres[place].radius);
        let (sum, larger) = (own + other, own.max(other));
        let path = (velocity(i) - velocity(j)) * step;
        let length = path.norm();
        if length <= own.min(other) || !length.is_finite() {
            return None;
        }
        let (touch, start) = (sum * (1.0 - SLACK), world.arm(i, j));
        let distance = start.norm();
        if !world.period.any() && distance > length + sum {
            return None;
        }
        let periods = (0..3).map(|axis| world.period.length(axis)).filter(|&length| length > 0.0);
        let pieces = (PIECES * length / periods.fold(f64::INFINITY, f64::min)).ceil().max(1.0);
        let piece = path / pieces;
        let mut number = 0.0;
        while number < pieces {
            let moved = start - piece * number;
            let [x, y, z] = world.period.shortest([moved.x, moved.y, moved.z]);
            let arm = if world.period.any() { Vector::new(x, y, z) } else { moved };
            let radius = match distance {
                _ if arm.norm() > touch => touch,
                deep if deep <= larger => LONG_LEVEL * deep,
                _ => larger + LONG_LEVEL * (distance.min(sum) - larger),
            };
            if let Some(share) = time_within(&arm, &piece, radius) {
                let normal = (arm - piece * share) / radius;
                return Some(PairImpact { share: (number + share) / pieces, normal });
            }
            number += 1.0;
        }
        None
    }
}

/// Lists the pairs of colliding grains within a block, and with later blocks.
fn find_meetings(world: &World, blocks: &[Bounds], number: usize, step: f64, found: &mut Vec<Meeting>) {
    found.clear();
    let (own, grains) = (&blocks[number], world.grains());
    let places = |block: usize| BLOCK * block..(BLOCK * (block + 1)).min(grains);
    for (other, bounds) in blocks.iter().enumerate().skip(number) {
        if !own.may_meet(bounds, &world.period, step) {
            continue;
        }
        for i in places(number) {
            if other != number && !Bounds::of(world, i..i + 1).may_meet(bounds, &world.period, step) {
                continue;
            }
            let first = if other == number { i + 1 } else { places(other).start };
            for j in first..places(other).end {
                let pair = if world.ids[i] < world.ids[j] { [i, j] } else { [j, i] };
                if let Some(PairImpact { share, .. }) = PairImpact::of(world, pair, step) {
                    found.push(Meeting { share, places: pair.map(|place| place as u32) });
                }
            }
        }
    }
}

impl Simulation {
    /// Stops grains that would pass through each other within the step. Returns true if there were any; the `last` try records them as failures.
    pub(super) fn stop_at_grains(&mut self, last: bool, team: &Team) -> bool {
        let mut meetings = self.find_meetings(team);
        let ids = |one: &Meeting| one.places.map(|place| self.world.ids[place as usize]);
        meetings.sort_unstable_by(|a, b| a.share.total_cmp(&b.share).then_with(|| ids(a).cmp(&ids(b))));
        let Some(first) = meetings.first() else { return false };
        if last {
            let grains = ids(first).map(|id| self.world.roll.number(id));
            self.swept.passage.get_or_insert(Passage { grains });
            return true;
        }
        for Meeting { places, .. } in meetings {
            let pair = places.map(|place| place as usize);
            // An earlier impact may have changed their paths.
            if let Some(impact) = PairImpact::of(&self.world, pair, self.settings.step) {
                self.strike_grain(pair, &impact);
            }
        }
        true
    }

    fn find_meetings(&mut self, team: &Team) -> Vec<Meeting> {
        let Simulation { world, swept, settings, .. } = self;
        let grains = world.grains();
        let blocks: Vec<Bounds> = (0..grains.div_ceil(BLOCK))
            .map(|number| Bounds::of(world, BLOCK * number..(BLOCK * (number + 1)).min(grains)))
            .collect();
        let (world, step) = (&*world, settings.step);
        swept.meetings.resize_with(blocks.len(), Vec::new);
        team.each_with(Phase::Integrate, blocks.len(), Each::of(&mut swept.meetings), |number, found| {
            find_meetings(world, &blocks, number, step, found);
        });
        swept.meetings.iter().flatten().copied().collect()
    }

    /// Applies the impact of two grains.
    fn strike_grain(&mut self, pair: [usize; 2], impact: &PairImpact) {
        let (h, normal, world) = (self.settings.step, impact.normal, &self.world);
        let bodies = pair.map(|place| world.bodies[place]);
        let [first, second] = bodies.map(|body| Vector::from(body.velocity));
        let [spin, other_spin] = bodies.map(|body| Vector::from(body.scaled_spin));
        let inverse_mass = bodies[0].inverse_mass + bodies[1].inverse_mass;
        let along = normal.dot(&(second - first));
        let [own, other] = pair.map(|place| world.materials[place]);
        let material = world.table.between_grains(own, other);
        let speed = (-along).max(0.0);
        let restitution = at_speed(material.restitution, material.restitution_speed, speed);
        let threshold = self.constrainer.scheme().restitution_threshold;
        let bias = Some(restitution * speed).filter(|bias| *bias > threshold).unwrap_or(0.0);
        let borne = (bias - along).max(0.0) / inverse_mass;
        // Friction at the surface velocity, which the normal impulse does not change.
        let surfaces = |velocities: [Vector; 2], spins: [Vector; 2]| {
            velocities[1] - velocities[0] - (spins[0] + spins[1]).cross(&normal)
        };
        let before = surfaces([first, second], [spin, other_spin]);
        let slip = before - normal * normal.dot(&before);
        let sliding = slip.norm() > slip_speed(world.field.largest(), h);
        let coefficient = if sliding { material.kinetic_friction } else { material.friction };
        let sticking = 1.0 / (inverse_mass * (1.0 + INVERSE_INERTIA));
        let tangential = friction(slip, sticking, coefficient * borne);
        let impulse = tangential - normal * borne;
        let turned = normal.cross(&tangential) * INVERSE_INERTIA;
        for (place, sign) in pair.into_iter().zip([1.0, -1.0]) {
            let body = &mut self.world.bodies[place];
            let (velocity, spin) = (Vector::from(body.velocity), Vector::from(body.scaled_spin));
            body.velocity = (velocity + impulse * (sign * body.inverse_mass)).into();
            // Both turn in the same direction: arms and impulses are both opposite.
            body.scaled_spin = (spin + turned * body.inverse_mass).into();
        }
        let bodies = pair.map(|place| self.world.bodies[place]);
        let [velocities, spins] =
            [bodies.map(|body| Vector::from(body.velocity)), bodies.map(|body| Vector::from(body.scaled_spin))];
        let relative = [before, surfaces(velocities, spins)];
        self.book_pair_impulse(pair, normal, relative, impulse);
        let [place, partner] = pair.map(|place| place as u32);
        let (struck, tangential) = (Struck::Grain(partner), -tangential);
        self.swept.strikes.push(Strike { place, struck, normal, along: borne, tangential });
    }
}
