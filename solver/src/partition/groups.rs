//! Lane groups: eight contacts that share no body.

use crate::detect::Impulse;
use crate::sweep::Lanes;
use crate::world::LANES;

/// Marks a lane that holds no contact.
const NO_SOURCE: u32 = u32::MAX;

/// Constraint data and impulses of eight contacts.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct ContactLanes {
    /// Unit normals from the first body to the second, or to the wall.
    pub normal: [Lanes; 3],
    /// Biases q, m/s.
    pub bias: Lanes,
    /// Regularisations Sigma', 1/kg.
    pub regularisation: Lanes,
    /// Friction coefficients.
    pub friction: Lanes,
    /// Normal impulses, N s.
    pub impulse_normal: Lanes,
    /// Tangential impulses on the second body, or on the wall, N s.
    pub impulse_tangential: [Lanes; 3],
    /// Candidates that the contacts came from.
    source: [u32; LANES],
}

/// Eight contacts of pairs of grains that share no body.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct PairGroup {
    /// First bodies.
    pub first: [u32; LANES],
    /// Second bodies.
    pub second: [u32; LANES],
    /// Their contacts.
    pub contacts: ContactLanes,
}

/// Eight contacts of different grains with walls.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct WallGroup {
    /// Grains.
    pub body: [u32; LANES],
    /// Velocities of the wall at the contacts, m/s.
    pub wall_velocity: [Lanes; 3],
    /// Their contacts.
    pub contacts: ContactLanes,
}

/// Constraint data of one contact on its way into a lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Constraint {
    pub normal: [f64; 3],
    pub bias: f64,
    pub regularisation: f64,
    pub friction: f64,
    pub impulse: Impulse,
    pub source: u32,
}

impl ContactLanes {
    fn padding() -> ContactLanes {
        ContactLanes {
            normal: [Lanes::default(); 3],
            bias: Lanes::default(),
            regularisation: Lanes::default(),
            friction: Lanes::default(),
            impulse_normal: Lanes::default(),
            impulse_tangential: [Lanes::default(); 3],
            source: [NO_SOURCE; LANES],
        }
    }

    pub(super) fn set(&mut self, lane: usize, constraint: &Constraint) {
        for axis in 0..3 {
            self.normal[axis].0[lane] = constraint.normal[axis];
            self.impulse_tangential[axis].0[lane] = constraint.impulse.tangential[axis];
        }
        self.bias.0[lane] = constraint.bias;
        self.regularisation.0[lane] = constraint.regularisation;
        self.friction.0[lane] = constraint.friction;
        self.impulse_normal.0[lane] = constraint.impulse.normal;
        self.source[lane] = constraint.source;
    }

    /// Lanes that hold a contact, with the candidates that these came from.
    pub fn occupied(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let occupied = |&(_, &source): &(usize, &u32)| source != NO_SOURCE;
        self.source.iter().enumerate().filter(occupied).map(|(lane, &source)| (lane, source as usize))
    }

    /// Impulse of the contact in a lane, N s.
    pub fn impulse(&self, lane: usize) -> Impulse {
        Impulse {
            normal: self.impulse_normal.0[lane],
            tangential: std::array::from_fn(|axis| self.impulse_tangential[axis].0[lane]),
        }
    }

    /// Normal of the contact in a lane.
    pub fn normal(&self, lane: usize) -> [f64; 3] {
        std::array::from_fn(|axis| self.normal[axis].0[lane])
    }
}

impl PairGroup {
    /// A group of padding lanes, which point at the dummies behind `grains` bodies.
    pub(super) fn padding(grains: u32) -> PairGroup {
        PairGroup {
            first: std::array::from_fn(|lane| grains + lane as u32),
            second: std::array::from_fn(|lane| grains + (LANES + lane) as u32),
            contacts: ContactLanes::padding(),
        }
    }
}

impl WallGroup {
    /// As [`PairGroup::padding`].
    pub(super) fn padding(grains: u32) -> WallGroup {
        WallGroup {
            body: std::array::from_fn(|lane| grains + lane as u32),
            wall_velocity: [Lanes::default(); 3],
            contacts: ContactLanes::padding(),
        }
    }
}
