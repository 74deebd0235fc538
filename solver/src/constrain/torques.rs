//! Levers and starting impulses of the torques that contacts bear, in scenes that call for them.

use super::StepContext;
use crate::detect::AngularImpulse;
use crate::effects::Effects;
use crate::effects::compliance::effective_radius;
use crate::effects::resistance::bearable;
use crate::groups::{ContactLanes, ContactLayout, TorqueLanes};
use crate::lanes::{Eight, Kernel, Lanes, Number, Slots};
use crate::partition::TaskGroups;
use std::marker::PhantomData;

/// Fills the torques of a task whose contacts are filled.
pub(super) struct FillTorques<'a, E: Effects> {
    pub context: &'a StepContext<'a>,
    pub groups: &'a mut TaskGroups,
    pub pairs: Slots<'a, AngularImpulse>,
    pub walls: Slots<'a, AngularImpulse>,
    pub effects: PhantomData<E>,
}

impl<E: Effects> Kernel for FillTorques<'_, E> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let StepContext { world, candidates, walls: placed, constants, .. } = self.context;
        let share = constants.warm_start;
        let TaskGroups { pairs, pair_sources, pair_torques, walls, wall_sources, wall_torques, .. } = self.groups;
        for ((group, sources), torques) in E::Tangential::of(pairs).iter().zip(pair_sources).zip(pair_torques) {
            *torques = TorqueLanes::default();
            for (lane, candidate) in sources.occupied() {
                let [i, j] = [group.first[lane] as usize, group.second[lane] as usize];
                let (a, b) = (world.spheres[i].radius, world.spheres[j].radius);
                let material = world.table.between_grains(world.materials[i], world.materials[j]);
                let effective_radius = effective_radius(a, b);
                torques.rolling_lever.0[lane] = material.rolling_friction * effective_radius;
                torques.twisting_lever.0[lane] = material.twisting_friction * effective_radius;
                torques.remember(lane, self.pairs.get(candidate as u32), share);
            }
            start::<L, E, _>(torques, &group.contacts);
        }
        for ((group, sources), lanes) in walls.iter().zip(wall_sources).zip(wall_torques) {
            *lanes = Default::default();
            for (lane, candidate) in sources.occupied() {
                let (grain, surface) = (group.body[lane] as usize, candidates.walls[candidate].surface);
                let material = world.wall_material(grain, surface);
                let radius = world.spheres[grain].radius;
                let torques = &mut lanes.torques;
                torques.rolling_lever.0[lane] = material.rolling_friction * radius;
                torques.twisting_lever.0[lane] = material.twisting_friction * radius;
                torques.remember(lane, self.walls.get(candidate as u32), share);
                for (axis, spin) in placed.face(surface).spin().iter().enumerate() {
                    lanes.wall_spin[axis].0[lane] = *spin;
                }
            }
            start::<L, E, _>(&mut lanes.torques, &group.contacts);
        }
    }
}

impl TorqueLanes {
    fn remember(&mut self, lane: usize, AngularImpulse(impulse): AngularImpulse, share: f64) {
        for (own, component) in self.impulse.iter_mut().zip(impulse) {
            own.0[lane] = component * share;
        }
    }
}

/// What is remembered, as far as the contact can bear it with the normal impulse that it starts from. A contact that has just
/// closed starts from none, whatever it bore when it opened.
#[inline(always)]
fn start<L: Lanes, E: Effects, T>(torques: &mut TorqueLanes, contacts: &ContactLanes<Eight, T>) {
    let load = |number: &Eight| L::load(number);
    let (normal, normal_impulse) = (contacts.normal.each_ref().map(load), load(&contacts.impulse_normal));
    let bears = <L as Number>::zero().below(normal_impulse);
    let [rolling_cap, twisting_cap] =
        [&torques.rolling_lever, &torques.twisting_lever].map(|lever| load(lever) * normal_impulse);
    let borne = bearable::<E, L>(torques.impulse.each_ref().map(load), normal, rolling_cap, twisting_cap);
    for (component, impulse) in borne.into_iter().zip(&mut torques.impulse) {
        L::select(bears, component, <L as Number>::zero()).store(impulse);
    }
}
