//! Bodies and lane groups in single precision: half the memory, and sixteen contacts per group.
//!
//! A step is laid out in double precision. Bodies and constraint data are rounded to `f32` for its sweeps only; two
//! consecutive groups become one if they share no body. Impulses are then copied back, and each body receives only the
//! change of its velocity, so that bodies without contacts are not rounded.

use super::{ByNumber, Layout, TaskGroups};
use crate::effects::friction::FrictionLanes;
use crate::effects::term::Tangential;
use crate::groups::{ContactLanes, Effects, PairGroup, WallGroup, padding_places, with_pairs};
use crate::lanes::{Available, Eight, Kernel, LANES, Lanes, SINGLE_LANES, Sixteen};
use crate::schedule::{Phase, Team};
use crate::world::{Body, DUMMIES, by_chunk, chunk, chunks};
use bytemuck::{Pod, Zeroable};

/// Dynamic state of a grain in single precision: half a cache line, laid out as [`Body`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C, align(32))]
pub(crate) struct SingleBody {
    velocity: [f32; 3],
    inverse_mass: f32,
    scaled_spin: [f32; 3],
    inverse_radius: f32,
}

/// Sixteen contacts of pairs of grains that share no body, with memory for friction in every scene.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct SinglePairGroup {
    pub first: [u32; SINGLE_LANES],
    pub second: [u32; SINGLE_LANES],
    pub contacts: ContactLanes<Sixteen>,
}

/// Sixteen contacts of different grains with walls.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct SingleWallGroup {
    pub body: [u32; SINGLE_LANES],
    pub wall_velocity: [Sixteen; 3],
    pub contacts: ContactLanes<Sixteen>,
}

/// Lane groups of one task.
#[derive(Clone, Debug, Default)]
pub(crate) struct SingleGroups {
    pub pairs: Vec<SinglePairGroup>,
    pub walls: Vec<SingleWallGroup>,
    /// Number of groups of eight in each group, pairs before walls.
    joined: Vec<u8>,
}

/// Bodies and lane groups of a step in single precision; empty for scenes in double precision.
#[derive(Clone, Debug, Default)]
pub(crate) struct SingleCopy {
    pub bodies: Vec<SingleBody>,
    /// Groups by task number, as in [`Layout`].
    pub groups: Vec<SingleGroups>,
}

impl SinglePairGroup {
    /// Returns the bytes of a group that a sweep with these effects reads: the friction data are last.
    pub(crate) const fn used<E: Effects>() -> usize {
        size_of::<Self>() - if E::FRICTION { 0 } else { size_of::<FrictionLanes<Sixteen>>() }
    }
}

impl SingleBody {
    fn of(body: &Body) -> SingleBody {
        SingleBody {
            velocity: body.velocity.map(|component| component as f32),
            inverse_mass: body.inverse_mass as f32,
            scaled_spin: body.scaled_spin.map(|component| component as f32),
            inverse_radius: body.inverse_radius as f32,
        }
    }

    /// Adds the change of this body since its conversion to the original body.
    fn give_change(&self, body: &mut Body) {
        let before = SingleBody::of(body);
        for axis in 0..3 {
            body.velocity[axis] += f64::from(self.velocity[axis]) - f64::from(before.velocity[axis]);
            body.scaled_spin[axis] += f64::from(self.scaled_spin[axis]) - f64::from(before.scaled_spin[axis]);
        }
    }
}

impl SingleCopy {
    /// Rounds bodies and the lane groups of a step.
    pub fn take(&mut self, bodies: &[Body], layout: &Layout, set: Available, team: &Team) {
        // The padding bodies of the boxes follow the grains.
        let grains = bodies.len() - layout.boxes * DUMMIES;
        self.bodies.resize(bodies.len(), SingleBody::default());
        self.groups.resize_with(layout.groups.len(), SingleGroups::default);
        team.each_with(Phase::Sweep, chunks(bodies.len()), by_chunk(&mut self.bodies), |number, copies| {
            let bodies = &bodies[chunk(number, bodies.len())];
            copies.iter_mut().zip(bodies).for_each(|(copy, body)| *copy = SingleBody::of(body));
        });
        layout.plan.run_all(team, Phase::Sweep, ByNumber::of(&mut self.groups), |_, task, copy| {
            let number = task.number as usize;
            let dummies = (grains + task.home as usize * DUMMIES) as u32;
            set.run(Take { copy, task: &layout.groups[number], grains: grains as u32, dummies });
        });
    }

    /// Returns the impulses, and the change of each body's velocities, to double precision.
    pub fn give_back(&self, bodies: &mut [Body], layout: &mut Layout, team: &Team) {
        let count = bodies.len();
        team.each_with(Phase::Sweep, chunks(count), by_chunk(bodies), |number, bodies| {
            let copies = &self.bodies[chunk(number, count)];
            bodies.iter_mut().zip(copies).for_each(|(body, copy)| copy.give_change(body));
        });
        layout.plan.run_all(team, Phase::Sweep, ByNumber::of(&mut layout.groups), |_, task, groups| {
            self.groups[task.number as usize].give_back(groups);
        });
    }

    pub fn memory_bytes(&self) -> usize {
        let of_task = |task: &SingleGroups| {
            size_of::<SingleGroups>()
                + task.pairs.capacity() * size_of::<SinglePairGroup>()
                + task.walls.capacity() * size_of::<SingleWallGroup>()
                + task.joined.capacity()
        };
        self.bodies.capacity() * size_of::<SingleBody>() + self.groups.iter().map(of_task).sum::<usize>()
    }
}

impl SingleGroups {
    /// Rounds the groups of a task. Bodies from `grains` on are padding bodies, those of this box from `dummies` on.
    #[inline(always)]
    fn take(&mut self, task: &TaskGroups, grains: u32, dummies: u32) {
        self.pairs.clear();
        self.walls.clear();
        self.joined.clear();
        reserve(&mut self.pairs, task.pairs.len());
        reserve(&mut self.walls, task.walls.len());
        reserve(&mut self.joined, task.pairs.len() + task.walls.len());
        with_pairs!(&task.pairs, pairs => self.take_pairs(pairs, grains, dummies));
        let (padding, nothing) = (padding_places(dummies), ContactLanes::default());
        let mut walls = task.walls.as_slice();
        while let [group, rest @ ..] = walls {
            let partner = rest.first().filter(|next| !any_equal(&group.body, &next.body, grains));
            let at_rest = &nothing.normal;
            self.walls.push(SingleWallGroup {
                body: side_by_side(&group.body, partner.map_or(&padding[0], |next| &next.body)),
                wall_velocity: joined_vectors(
                    &group.wall_velocity,
                    partner.map_or(at_rest, |next| &next.wall_velocity),
                ),
                contacts: joined(&group.contacts, partner.map_or(&nothing, |next| &next.contacts)),
            });
            let count = 1 + usize::from(partner.is_some());
            self.joined.push(count as u8);
            walls = &walls[count..];
        }
    }

    /// Rounds the groups of pairs.
    #[inline(always)]
    fn take_pairs<T: Tangential>(&mut self, mut pairs: &[PairGroup<T>], grains: u32, dummies: u32) {
        let (padding, nothing) = (padding_places(dummies), ContactLanes::default());
        while let [group, rest @ ..] = pairs {
            let partner = rest.first().filter(|next| !share_a_grain(group, next, grains));
            let other = partner.map(|next| &next.contacts);
            self.pairs.push(SinglePairGroup {
                first: side_by_side(&group.first, partner.map_or(&padding[0], |next| &next.first)),
                second: side_by_side(&group.second, partner.map_or(&padding[1], |next| &next.second)),
                contacts: joined(&group.contacts, other.unwrap_or(&nothing)),
            });
            let count = 1 + usize::from(partner.is_some());
            self.joined.push(count as u8);
            pairs = &pairs[count..];
        }
    }

    /// Returns the impulses to the original groups.
    fn give_back(&self, task: &mut TaskGroups) {
        let mut joined = self.joined.iter();
        let mut walls = task.walls.iter_mut().map(|group: &mut WallGroup| &mut group.contacts);
        with_pairs!(&mut task.pairs, pairs => {
            let mut pairs = pairs.iter_mut().map(|group| &mut group.contacts);
            for (group, &count) in self.pairs.iter().zip(joined.by_ref()) {
                (0..count).zip(&mut pairs).for_each(|(half, contacts)| give_impulses(&group.contacts, half, contacts));
            }
        });
        for (group, &count) in self.walls.iter().zip(joined) {
            (0..count).zip(&mut walls).for_each(|(half, contacts)| give_impulses(&group.contacts, half, contacts));
        }
    }
}

/// Reserves memory for n entries, an eighth more than requested if there was too little.
fn reserve<T>(all: &mut Vec<T>, count: usize) {
    if count > all.capacity() {
        all.reserve_exact(count + count / 8 + 2);
    }
}

/// Returns true if a grain is in both groups. Padding bodies may be in both: no impulse moves them.
#[inline(always)]
fn share_a_grain<T>(own: &PairGroup<T>, next: &PairGroup<T>, grains: u32) -> bool {
    any_equal(&own.first, &next.first, grains)
        | any_equal(&own.first, &next.second, grains)
        | any_equal(&own.second, &next.first, grains)
        | any_equal(&own.second, &next.second, grains)
}

/// Returns true if a slot below `grains` is in both lists.
#[inline(always)]
fn any_equal(own: &[u32; LANES], others: &[u32; LANES], grains: u32) -> bool {
    // Compares all lanes at once, with one list rotated slot by slot.
    let mut equal = [false; LANES];
    for turn in 0..LANES {
        for lane in 0..LANES {
            equal[lane] |= (own[(lane + turn) % LANES] == others[lane]) & (others[lane] < grains);
        }
    }
    equal.iter().fold(false, |any, &equal| any | equal)
}

/// Slots of two groups.
#[inline(always)]
fn side_by_side(own: &[u32; LANES], partner: &[u32; LANES]) -> [u32; SINGLE_LANES] {
    let mut out = [0; SINGLE_LANES];
    out[..LANES].copy_from_slice(own);
    out[LANES..].copy_from_slice(partner);
    out
}

/// Rounds two times eight numbers.
#[inline(always)]
fn rounded(own: &Eight, partner: &Eight) -> Sixteen {
    let mut out = Sixteen::default();
    for lane in 0..LANES {
        out.0[lane] = own.0[lane] as f32;
        out.0[LANES + lane] = partner.0[lane] as f32;
    }
    out
}

#[inline(always)]
fn joined_vectors(own: &[Eight; 3], partner: &[Eight; 3]) -> [Sixteen; 3] {
    [rounded(&own[0], &partner[0]), rounded(&own[1], &partner[1]), rounded(&own[2], &partner[2])]
}

#[inline(always)]
fn joined<T: Tangential>(own: &ContactLanes<Eight, T>, partner: &ContactLanes<Eight, T>) -> ContactLanes<Sixteen> {
    let tangential = match (own.tangential.lanes(), partner.tangential.lanes()) {
        (Some(own), Some(partner)) => FrictionLanes {
            coefficient: rounded(&own.coefficient, &partner.coefficient),
            impulse: joined_vectors(&own.impulse, &partner.impulse),
        },
        _ => FrictionLanes::default(),
    };
    ContactLanes {
        normal: joined_vectors(&own.normal, &partner.normal),
        bias: rounded(&own.bias, &partner.bias),
        regularisation: rounded(&own.regularisation, &partner.regularisation),
        impulse_normal: rounded(&own.impulse_normal, &partner.impulse_normal),
        tangential,
    }
}

/// Rounds the groups of a task; see [`SingleGroups::take`].
struct Take<'a> {
    copy: &'a mut SingleGroups,
    task: &'a TaskGroups,
    grains: u32,
    dummies: u32,
}

impl Kernel for Take<'_> {
    type Output = ();

    // Plain loops: the compiler vectorises the conversions for the register width.
    #[inline(always)]
    fn run<L: Lanes>(self) {
        self.copy.take(self.task, self.grains, self.dummies);
    }
}

/// Returns the impulses of the lower (0) or upper (1) eight lanes.
fn give_impulses<T: Tangential>(from: &ContactLanes<Sixteen>, half: u8, to: &mut ContactLanes<Eight, T>) {
    let copy = |from: &Sixteen, to: &mut Eight| {
        let lanes = &from.0[usize::from(half) * LANES..][..LANES];
        to.0.iter_mut().zip(lanes).for_each(|(to, &from)| *to = f64::from(from));
    };
    copy(&from.impulse_normal, &mut to.impulse_normal);
    if let Some(tangential) = to.tangential.lanes_mut() {
        for axis in 0..3 {
            copy(&from.tangential.impulse[axis], &mut tangential.impulse[axis]);
        }
    }
}
