//! Constraint data of eight contacts at a time.

use super::coefficients::{Contacts, LaneMaterial, OnSurfaces};
use super::{StepContext, write_contacts};
use crate::contact::ContactGeometry;
use crate::detect::{AngularImpulse, Impulse, WallCandidate};
use crate::effects::impact::Impact;
use crate::effects::resistance::TorqueLanes;
use crate::effects::restitution::{at_speed, impact_on_the_way};
use crate::effects::term::{Tangential, TermState};
use crate::groups::{ContactLayout, Effects, ImpactLanes, ImpactMemory, PairGroup, Sources, with_pairs};
use crate::lanes::{
    Eight, Kernel, Lanes, PREFETCH, Slots, dot, minus, prefetch_lines, prefetch_places, prefetch_range,
};
use crate::laws::compliance::effective_radius;
use crate::partition::{PlannedTask, TaskGroups};
use crate::sweep::kernel::Contact;
use nalgebra::Vector3;
use std::marker::PhantomData;

/// Fills the groups of pairs of a task.
pub(super) struct FillPairs<'a, const PERIODIC: bool, T> {
    pub context: &'a StepContext<'a>,
    pub task: &'a PlannedTask,
    pub pairs: &'a mut [PairGroup<T>],
    pub sources: &'a [Sources],
    pub impacts: &'a mut [ImpactLanes],
    pub impulses: Slots<'a, Impulse>,
    pub known_impacts: Slots<'a, ImpactMemory>,
}

impl<const PERIODIC: bool, T: Tangential> Kernel for FillPairs<'_, PERIODIC, T> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let StepContext { world, spheres, before, .. } = self.context;
        let impulses = self.impulses;
        let nothing = self.context.candidates.pairs.len() as u32;
        let (groups, sources, impacts) = (self.pairs, self.sources, self.impacts);
        // Interior grains are contiguous in memory; grains of faces, edges and corners are scattered.
        let interior = self.task.is_interior();
        if self.context.fetches && interior {
            prefetch_range(&world.before[self.context.candidates.grains_of_box(self.task.home as usize)]);
        }
        let fetch = |groups: &[PairGroup<T>], number: usize| {
            if let (Some(group), Some(sources)) = (groups.get(number), sources.get(number)) {
                prefetch_lines(group, size_of::<PairGroup<T>>());
                prefetch_places(impulses.as_ptr(), &sources.or(nothing));
                if !interior {
                    prefetch_places(before.as_ptr(), &group.first);
                    prefetch_places(before.as_ptr(), &group.second);
                }
            }
        };
        if self.context.fetches {
            (0..PREFETCH).for_each(|number| fetch(groups, number));
        }
        for (number, sources) in sources.iter().enumerate() {
            if self.context.fetches {
                fetch(groups, number + PREFETCH);
            }
            let group = &mut groups[number];
            // Lanes refer to grains or padding bodies, and to candidates or the final zero.
            let [x, y, z, radius]: [L; 4] = spheres.load_quads(&group.first);
            let [to_x, to_y, to_z, to_radius]: [L; 4] = spheres.load_quads(&group.second);
            let [u, v, w, inverse_mass]: [L; 4] = before.load_differences(&group.first, &group.second);
            let arm = [to_x - x, to_y - y, to_z - z];
            let arm = if PERIODIC { world.period.shortest(arm) } else { arm };
            let geometry = ContactGeometry::of_pair(arm, [radius, to_radius]);
            let normal = geometry.normal;
            let mut material = match self.context.material {
                Some(material) => LaneMaterial::of_all(material),
                None => LaneMaterial::of_each(|lane| group.material(self.context, lane)),
            };
            let velocity = [u, v, w];
            let motion = [dot(normal, velocity), inverse_mass];
            let candidates = sources.or(nothing);
            let remembered = impulses.load_quads(&candidates);
            let known = ImpactLanes::load::<L>(self.known_impacts, &candidates);
            let impact = Impact::of([geometry.overlap, motion[0]], known, remembered[0] * inverse_mass);
            let speed = impact.speed_of_restitution(motion[0]);
            material.adapt(self.context, group, speed, [normal, velocity], remembered);
            let constants = &self.context.constants;
            impacts[number] =
                write_contacts(&mut group.contacts, &geometry, motion, &material, (remembered, &impact), constants);
        }
    }
}

/// Fills the groups of wall contacts of a task.
pub(super) struct FillWalls<'a> {
    pub context: &'a StepContext<'a>,
    pub groups: &'a mut TaskGroups,
    pub candidates: Slots<'a, WallCandidate>,
    pub impulses: Slots<'a, Impulse>,
    pub known_impacts: Slots<'a, ImpactMemory>,
}

impl Kernel for FillWalls<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let StepContext { world, before, walls: placed, constants, .. } = self.context;
        let nothing = self.candidates.count();
        let falling = world.gravity * constants.scheme.step;
        // Padding lanes are far from all walls.
        let far = [Eight([1e6; 8]), Eight::default(), Eight::default(), Eight([1.0; 8]), Eight([1.0; 8])];
        let TaskGroups { walls, wall_sources, wall_impacts, wall_drifts, .. } = self.groups;
        for (number, ((group, sources), impacts)) in walls.iter_mut().zip(wall_sources).zip(wall_impacts).enumerate() {
            // Faces differ per lane, so their geometry is scalar.
            let [mut distances, mut normal_x, mut normal_y, mut normal_z, mut radii] = far;
            let [mut wall_velocity, mut wall_before] = [[Eight::default(); 3]; 2];
            let mut surfaces = [0; crate::lanes::LANES];
            let mut swept = 0_u8;
            for (lane, candidate) in sources.occupied() {
                let wall = self.candidates.get(candidate as u32);
                let sphere = &world.spheres[wall.body as usize];
                let [u, v, w, _] = world.before[wall.body as usize].0;
                let (state, step) = ([&sphere.centre, &Vector3::new(u, v, w)], constants.scheme.step);
                let (distance, normal, is_swept, [velocity, gain, drift]) =
                    placed.contact(wall.surface, state, sphere.radius, step, &falling);
                if let Some(drifts) = wall_drifts.get_mut(number) {
                    (0..3).for_each(|axis| drifts[axis].0[lane] = drift[axis]);
                }
                swept |= u8::from(is_swept) << lane;
                let velocity_before = velocity - gain;
                distances.0[lane] = distance;
                radii.0[lane] = sphere.radius;
                (normal_x.0[lane], normal_y.0[lane], normal_z.0[lane]) = (normal.x, normal.y, normal.z);
                for axis in 0..3 {
                    wall_velocity[axis].0[lane] = velocity[axis];
                    wall_before[axis].0[lane] = velocity_before[axis];
                }
                surfaces[lane] = wall.surface;
            }
            group.wall_velocity = wall_velocity;
            // Lanes refer to grains or padding bodies, and to candidates or the final zero.
            let candidates_of_lanes = sources.or(nothing);
            let (body, remembered): ([L; 4], [L; 4]) =
                (before.load_quads(&group.body), self.impulses.load_quads(&candidates_of_lanes));
            let normal = [&normal_x, &normal_y, &normal_z].map(L::load);
            let (distance, radius) = (L::load(&distances), L::load(&radii));
            let mut material =
                LaneMaterial::of_each(|lane| world.wall_material(group.body[lane] as usize, surfaces[lane]));
            let velocity = minus(wall_before.each_ref().map(L::load), [body[0], body[1], body[2]]);
            let geometry = ContactGeometry::with_wall(distance, normal, radius);
            let motion = [dot(normal, velocity), body[3]];
            let known = ImpactLanes::load::<L>(self.known_impacts, &candidates_of_lanes);
            let impact = Impact::of([geometry.overlap, motion[0]], known, remembered[0] * body[3]);
            let (speed, contacts) = (impact.speed_of_restitution(motion[0]), OnSurfaces(group, &surfaces));
            material.adapt(self.context, &contacts, speed, [normal, velocity], remembered);
            *impacts =
                write_contacts(&mut group.contacts, &geometry, motion, &material, (remembered, &impact), constants);
            // Few grains are this fast, and most scenes have none.
            for lane in (0..crate::lanes::LANES).filter(|lane| swept >> lane & 1 == 1) {
                let [u, v, w, _] = world.before[group.body[lane] as usize].0;
                let towards = Vector3::from(group.contacts.normal(lane));
                let wall = Vector3::from([0, 1, 2].map(|axis| wall_velocity[axis].0[lane]));
                let velocity = towards.dot(&(wall - Vector3::new(u, v, w)));
                let material = world.wall_material(group.body[lane] as usize, surfaces[lane]);
                let restitution = at_speed(material.restitution, material.restitution_speed, -velocity);
                let gap = distances.0[lane] - radii.0[lane];
                group.contacts.bias.0[lane] = impact_on_the_way(&constants.scheme, gap, velocity, restitution);
                group.contacts.regularisation.0[lane] = 0.0;
                group.contacts.tangential.spring.make_rigid(lane);
            }
        }
    }
}

impl StepContext<'_> {
    /// Fills the cohesive impulses of a task after the layout of its contacts.
    pub(super) fn fill_pulls(&self, groups: &mut TaskGroups, candidates: Slots<'_, WallCandidate>) {
        let StepContext { world, walls: placed, constants, .. } = self;
        let h = constants.scheme.step;
        let TaskGroups { pairs, pair_sources, pair_pulls, walls, wall_sources, wall_pulls, .. } = groups;
        with_pairs!(pairs, pairs => for ((group, sources), pulls) in pairs.iter().zip(pair_sources).zip(pair_pulls) {
            *pulls = Eight::default();
            for (lane, _) in sources.occupied() {
                let [i, j] = [group.first[lane] as usize, group.second[lane] as usize];
                let geometry = world.pair_geometry(i, j);
                pulls.0[lane] = group.material(self, lane).pull(geometry.effective_radius).impulse(geometry.gap, h);
            }
        });
        for ((group, sources), pulls) in walls.iter().zip(wall_sources).zip(wall_pulls) {
            *pulls = Eight::default();
            for (lane, candidate) in sources.occupied() {
                let (grain, surface) = (group.body[lane] as usize, candidates.get(candidate as u32).surface);
                let sphere = &world.spheres[grain];
                let (distance, normal) = placed.face(surface).nearest(&sphere.centre, Vector3::zeros);
                let geometry = ContactGeometry::with_wall(distance, normal.into(), sphere.radius);
                let material = world.wall_material(grain, surface);
                pulls.0[lane] = material.pull(geometry.effective_radius).impulse(geometry.gap, h);
            }
        }
    }
}

/// Fills the torques of a task after its contacts.
pub(super) struct FillTorques<'a, E: Effects> {
    pub context: &'a StepContext<'a>,
    pub groups: &'a mut TaskGroups,
    pub candidates: Slots<'a, WallCandidate>,
    pub pairs: Slots<'a, AngularImpulse>,
    pub walls: Slots<'a, AngularImpulse>,
    pub effects: PhantomData<E>,
}

impl<E: Effects> Kernel for FillTorques<'_, E> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let StepContext { world, walls: placed, constants, .. } = self.context;
        let started =
            |AngularImpulse(impulse): AngularImpulse| impulse.map(|component| component * constants.warm_start);
        let TaskGroups { pairs, pair_sources, pair_torques, walls, wall_sources, wall_torques, .. } = self.groups;
        for ((group, sources), torques) in E::Tangential::of(pairs).iter().zip(pair_sources).zip(pair_torques) {
            *torques = TorqueLanes::default();
            for (lane, candidate) in sources.occupied() {
                let radius = |place: u32| world.spheres[place as usize].radius;
                let effective_radius = effective_radius(radius(group.first[lane]), radius(group.second[lane]));
                torques.fill(
                    lane,
                    group.material(self.context, lane),
                    effective_radius,
                    started(self.pairs.get(candidate as u32)),
                );
            }
            start::<L, E>(torques, &Contact::<L, E>::read(&group.contacts, L::load));
        }
        for ((group, sources), lanes) in walls.iter().zip(wall_sources).zip(wall_torques) {
            *lanes = Default::default();
            for (lane, candidate) in sources.occupied() {
                let (grain, surface) = (group.body[lane] as usize, self.candidates.get(candidate as u32).surface);
                let material = world.wall_material(grain, surface);
                let radius = world.spheres[grain].radius;
                lanes.torques.fill(lane, material, radius, started(self.walls.get(candidate as u32)));
                for (axis, spin) in placed.face(surface).spin().iter().enumerate() {
                    lanes.wall_spin[axis].0[lane] = *spin;
                }
            }
            start::<L, E>(&mut lanes.torques, &Contact::<L, E>::read(&group.contacts, L::load));
        }
    }
}

/// Sets the torques of eight contacts to those of the last step, projected onto the present limits of the contacts.
#[inline(always)]
fn start<L: Lanes, E: Effects>(torques: &mut TorqueLanes, contact: &Contact<L, E>) {
    let mut torque = TermState::<L, E::Torque<L>>::angular(torques, L::load);
    torque.start((contact.normal, contact.impulse_normal));
    torque.write(&mut torques.impulse, L::store);
}
