//! Coefficients of eight contacts: material constants, and coefficients that depend on approach or sliding speed.

use super::StepContext;
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
    /// Tangential over normal stiffness, if contacts have a tangential spring.
    pub stiffness_ratio: Option<L>,
}

/// Eight contacts with their materials.
pub(super) trait Contacts {
    /// Material of the contact in a lane.
    fn material<'a>(&self, context: &'a StepContext<'_>, lane: usize) -> &'a ContactMaterial;

    /// Sum of the scaled spins of both grains at the start of the step, m/s.
    fn spin<L: Lanes>(&self, context: &StepContext<'_>) -> [L; 3];

    /// Gathers a property of the materials.
    #[inline(always)]
    fn property<L: Lanes>(&self, context: &StepContext<'_>, property: fn(&ContactMaterial) -> f64) -> L {
        L::load(&Eight(std::array::from_fn::<f64, LANES, _>(|lane| property(self.material(context, lane)))))
    }
}

impl<T> Contacts for PairGroup<T> {
    #[inline(always)]
    fn material<'a>(&self, context: &'a StepContext<'_>, lane: usize) -> &'a ContactMaterial {
        let (world, lanes) = (&context.world, [self.first[lane], self.second[lane]]);
        let [first, second] = lanes.map(|place| world.materials[place as usize]);
        context.material.unwrap_or_else(|| world.table.between_grains(first, second))
    }

    #[inline(always)]
    fn spin<L: Lanes>(&self, context: &StepContext<'_>) -> [L; 3] {
        let [a, b] = [&self.first, &self.second].map(|places| context.spins_before.load_quads::<L>(places));
        plus([a[0], a[1], a[2]], [b[0], b[1], b[2]])
    }
}

/// Contacts with walls, and their surfaces.
pub(super) struct OnSurfaces<'a>(pub &'a WallGroup, pub &'a [u32; LANES]);

impl Contacts for OnSurfaces<'_> {
    #[inline(always)]
    fn material<'a>(&self, context: &'a StepContext<'_>, lane: usize) -> &'a ContactMaterial {
        context.world.wall_material(self.0.body[lane] as usize, self.1[lane])
    }

    #[inline(always)]
    fn spin<L: Lanes>(&self, context: &StepContext<'_>) -> [L; 3] {
        let [x, y, z, _] = context.spins_before.load_quads(&self.0.body);
        [x, y, z]
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
        // One lookup per lane: four of the properties are read.
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

    /// Sets restitution by impact speed (m/s), friction by sliding velocity (m/s, without the spin of the grains) and the
    /// stiffness of springs. `borne` holds the normal and tangential impulses of the last step, N s.
    #[inline(always)]
    pub fn adapt(
        &mut self,
        context: &StepContext<'_>,
        contacts: &impl Contacts,
        speed: L,
        [normal, velocity]: [[L; 3]; 2],
        borne: [L; 4],
    ) {
        if context.effects.falling_restitution() {
            let limit = contacts.property(context, |material| material.restitution_speed);
            self.restitution = at_speed(self.restitution, limit, speed);
        }
        if context.effects.kinetic_friction() {
            let kinetic = contacts.property(context, |material| material.kinetic_friction);
            let velocity = minus(velocity, cross(contacts.spin(context), normal));
            let sliding = minus(velocity, times(normal, dot(normal, velocity)));
            let slip = L::splat(context.constants.slip_speed);
            self.friction = while_sliding(self.friction, kinetic, sliding, slip, borne);
        }
        if context.effects.spring() {
            self.stiffness_ratio = Some(contacts.property(context, |material| material.stiffness_ratio));
        }
    }
}
