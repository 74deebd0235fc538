//! Coefficients of eight contacts: those of their materials, and those that go by how fast the contacts close or slide.

use super::{StepConstants, StepContext};
use crate::effects::friction::while_sliding;
use crate::effects::restitution::at_speed;
use crate::groups::{PairGroup, WallGroup};
use crate::lanes::{Eight, LANES, Lanes, cross, dot, minus, plus, times};
use crate::world::ContactMaterial;

/// Restitution, friction and the rest for eight contacts.
pub(super) struct LaneMaterial<L> {
    pub effective_modulus: L,
    pub damping_ratio: L,
    pub restitution: L,
    pub friction: L,
    /// Stiffness across the normal over that along it, where contacts have a tangential spring.
    pub stiffness_ratio: Option<L>,
}

/// Eight contacts whose materials can be looked up.
pub(super) trait Contacts {
    /// A property of their materials.
    fn property<L: Lanes>(&self, context: &StepContext<'_>, property: fn(&ContactMaterial) -> f64) -> L;
}

impl<T> Contacts for PairGroup<T> {
    #[inline(always)]
    fn property<L: Lanes>(&self, context: &StepContext<'_>, property: fn(&ContactMaterial) -> f64) -> L {
        let world = context.world;
        let number = |place: u32| world.materials[place as usize];
        let material = |lane: usize| {
            context.material.unwrap_or(world.table.between_grains(number(self.first[lane]), number(self.second[lane])))
        };
        L::load(&Eight(std::array::from_fn::<f64, LANES, _>(|lane| property(material(lane)))))
    }
}

/// Contacts with walls, and the surfaces that they are with.
pub(super) struct OnSurfaces<'a>(pub &'a WallGroup, pub &'a [u32; LANES]);

impl Contacts for OnSurfaces<'_> {
    #[inline(always)]
    fn property<L: Lanes>(&self, context: &StepContext<'_>, property: fn(&ContactMaterial) -> f64) -> L {
        let OnSurfaces(group, surfaces) = *self;
        let material = |lane: usize| context.world.wall_material(group.body[lane] as usize, surfaces[lane]);
        L::load(&Eight(std::array::from_fn::<f64, LANES, _>(|lane| property(material(lane)))))
    }
}

impl<L: Lanes> LaneMaterial<L> {
    #[inline(always)]
    pub fn of_all(material: &ContactMaterial) -> Self {
        Self {
            effective_modulus: L::splat(material.effective_modulus),
            damping_ratio: L::splat(material.damping_ratio),
            restitution: L::splat(material.restitution),
            friction: L::splat(material.friction),
            stiffness_ratio: None,
        }
    }

    #[inline(always)]
    pub fn of_each<'a>(material: impl Fn(usize) -> &'a ContactMaterial) -> Self {
        // Looked up once a lane: four of their properties are read.
        let materials: [_; LANES] = std::array::from_fn(material);
        let lanes = |property: fn(&ContactMaterial) -> f64| L::load(&Eight(materials.map(property)));
        Self {
            effective_modulus: lanes(|material| material.effective_modulus),
            damping_ratio: lanes(|material| material.damping_ratio),
            restitution: lanes(|material| material.restitution),
            friction: lanes(|material| material.friction),
            stiffness_ratio: None,
        }
    }

    /// With the springs that contacts have across the normal.
    #[inline(always)]
    pub fn with_springs(&mut self, context: &StepContext<'_>, contacts: &impl Contacts) {
        self.stiffness_ratio = Some(contacts.property(context, |material| material.stiffness_ratio));
    }

    /// Restitution at the speed of the contacts' impacts, m/s.
    #[inline(always)]
    pub fn at_speed(&mut self, context: &StepContext<'_>, contacts: &impl Contacts, speed: L) {
        let limit = contacts.property(context, |material| material.restitution_speed);
        self.restitution = at_speed(self.restitution, limit, speed);
    }

    /// Friction at the velocity at which the contacts slide, without the spin of the grains: their surfaces move with the cross
    /// product of `spin` and the normal. `borne` are the impulses of the last step, along the normal and across it.
    #[inline(always)]
    pub fn while_sliding(
        &mut self,
        context: &StepContext<'_>,
        contacts: &impl Contacts,
        normal: [L; 3],
        velocity: [L; 3],
        spin: [L; 3],
        borne: [L; 4],
    ) {
        let StepConstants { slip_speed, .. } = context.constants;
        let kinetic = contacts.property(context, |material| material.kinetic_friction);
        let velocity = minus(velocity, cross(spin, normal));
        let sliding = minus(velocity, times(normal, dot(normal, velocity)));
        self.friction = while_sliding(self.friction, kinetic, sliding, L::splat(slip_speed), borne);
    }
}

impl StepContext<'_> {
    /// Sum of the scaled spins that eight pairs had at the start of the step.
    #[inline(always)]
    pub(super) fn spins_of_pairs<L: Lanes, T>(&self, group: &PairGroup<T>) -> [L; 3] {
        let (a, b) = (self.spins_before.load_quads(&group.first), self.spins_before.load_quads(&group.second));
        plus([a[0], a[1], a[2]], [b[0], b[1], b[2]])
    }

    /// Coefficients of eight grains at walls.
    #[inline(always)]
    pub(super) fn spins_at_walls<L: Lanes>(&self, group: &WallGroup) -> [L; 3] {
        let [x, y, z, _] = self.spins_before.load_quads(&group.body);
        [x, y, z]
    }
}
