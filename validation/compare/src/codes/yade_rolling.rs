//! Rolling resistance in YADE's terms.
//!
//! `Law2_ScGeom_MindlinPhys_Mindlin(includeMoment=True)` carries a moment by an elastic spring `krot` (N m) up to `eta` times the mean
//! radius of the pair times the normal force. In Makadam (and LIGGGHTS's epsd2) the limit is `mu_r` times the effective radius. For
//! two grains of radius R the mean radius is R and the effective one R/2. A facet counts as a sphere of twice the grain's
//! radius, so the mean radius there is 1.5 R and the effective one is R. (A `hertzian` facet has an infinite radius, which
//! would lock rolling; without it contacts with facets have sqrt(2/3) of the stiffness of a flat wall.)
//!
//! At zero normal force, as at the end of a damped impact, YADE treats a cap of zero as no cap, and the spring continues to turn.
//! A grain that hits another at 1 m/s with a spin of 50 rad/s loses twice the amount that the cap allows. Permanent contacts are not
//! affected.
//!
//! `eta` is one number for all contacts. So `eta = mu_r/2` holds for grains, and at walls only if their coefficient is three quarters
//! of the grains'.
//!
//! `krot` is one number for all contacts too. In epsd2 the stiffness grows with the overlap: the tangential spring's times the effective
//! radius squared. The driver sets each contact's own stiffness (`kr`) to that value every few steps; `krot` applies until then. A
//! heap's angle depends on it: with springs everywhere as stiff as at an overlap of 1% the heap is one degree steeper.

use super::input::Palette;
use makadam::scene::{Grain, Material};
use serde::Serialize;

/// Mean radius over the grain's radius at a facet.
const FACET: f64 = 1.5;

/// Overlap, over the radius, that sets the spring stiffness of a new contact: the largest of an impact with 0.1 m/s at 10 MPa.
const OVERLAP: f64 = 0.01;

/// Largest ratio of radii for which the effective radius is half the mean one for every pair, within 4%.
const LARGEST_RATIO: f64 = 1.5;

/// Rolling resistance of all contacts.
#[derive(Serialize)]
pub(super) struct Rolling {
    /// Cap of the moment over the mean radius and the normal force.
    eta: f64,
    /// Stiffness of a new contact's spring, N m.
    krot: f64,
}

/// Returns the scene's rolling resistance in YADE's terms, if it has any; an error states a limit of YADE.
pub(super) fn rolling(palette: &Palette<'_>, grains: &[Grain]) -> Result<Option<Rolling>, String> {
    let eta = |(_, b, pair): (usize, usize, makadam::scene::ContactCoefficients)| {
        pair.rolling_friction / if palette.is_wall(b) { FACET } else { 2.0 }
    };
    let etas: Vec<f64> = palette.pairs().map(eta).collect();
    let (least, most) =
        etas.iter().fold((f64::INFINITY, 0.0_f64), |(least, most), &eta| (least.min(eta), most.max(eta)));
    if most == 0.0 {
        return Ok(None);
    }
    if most - least > 1e-9 * most {
        return Err("it has one rolling coefficient for all contacts: give walls three quarters of the grains' \
                    rolling_friction"
            .into());
    }
    let radii = || grains.iter().map(|grain| grain.radius);
    let (smallest, largest) = (radii().fold(f64::INFINITY, f64::min), radii().fold(0.0, f64::max));
    if largest > LARGEST_RATIO * smallest {
        let ratio = largest / smallest;
        return Err(format!("its rolling torque goes with the mean radius, and grains differ by a factor {ratio:.2}"));
    }
    let radius = radii().sum::<f64>() / grains.len() as f64;
    let softness = |material: &Material| {
        let shear = material.youngs_modulus / (2.0 * (1.0 + material.poisson_ratio));
        2.0 * (2.0 - material.poisson_ratio) / shear
    };
    let shear = palette.materials().map(|material| 1.0 / softness(material)).fold(0.0, f64::max);
    let effective = 0.5 * radius;
    let tangential = 8.0 * shear * (effective * OVERLAP * radius).sqrt();
    Ok(Some(Rolling { eta: most, krot: tangential * effective * effective }))
}
