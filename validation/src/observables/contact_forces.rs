//! Statistics of the contact forces between grains in the bulk.
//!
//! The shape of the distribution of normal forces: share of contacts below the mean, Gini coefficient, second moment
//! `<f^2>/<f>^2`, share of the load that the contacts below the mean carry (the weak network of Radjai et al., Phys. Rev.
//! Lett. 77, 274, 1996). Friction: mean of ft/(mu fn) by the static coefficient, and the share of contacts whose force of
//! friction is at a limit, as that of a contact that slides: within 1% of the kinetic limit, or no more than 1% below the static one.
//! Fabric: with F the mean of n n^T over contacts, a = 15/2 (F - 1/3) is the second-order coefficient of the
//! distribution of contact directions, and its size is sqrt(3/2 a:a) (Guo & Zhao, J. Mech. Phys. Solids 61, 1, 2013).

use super::measurement::{Quantity, Readings};
use super::view::View;
use crate::statistics::{gini, mean, second_moment, share_below_mean, weak_load_share};
use nalgebra::{Matrix3, Vector3};

const SHARE_BELOW_MEAN: Quantity = Quantity::mean("share_below_mean", "");
const GINI: Quantity = Quantity::mean("gini", "");
const SECOND_MOMENT: Quantity = Quantity::mean("force_second_moment", "");
const WEAK_LOAD_SHARE: Quantity = Quantity::mean("weak_load_share", "");
const MOBILISATION: Quantity = Quantity::mean("friction_mobilisation", "");
const SLIDING: Quantity = Quantity::mean("sliding_share", "");
const ANISOTROPY: Quantity = Quantity::mean("fabric_anisotropy", "");
const MEAN_FORCE: Quantity = Quantity::mean("mean_normal_force", "N");

/// Fewest contacts of which a distribution is taken.
const FEWEST: usize = 20;

/// Share of a limit of friction within which a tangential force is at it.
const AT_LIMIT: f64 = 0.01;

/// Adds the statistics of a frame's contacts.
///
/// # Errors
/// Why there are none.
pub fn read(view: &View<'_>, readings: &mut Readings) -> Result<(), String> {
    view.bulk()?;
    let contacts = view.bulk_contacts();
    if contacts.len() < FEWEST {
        return Err(format!("{} contacts between grains of the bulk are fewer than {FEWEST}", contacts.len()));
    }
    let forces: Vec<f64> = contacts.iter().map(|contact| contact.normal_force).collect();
    readings.add(SHARE_BELOW_MEAN, share_below_mean(&forces));
    readings.add(GINI, gini(&forces));
    readings.add(SECOND_MOMENT, second_moment(&forces));
    readings.add(WEAK_LOAD_SHARE, weak_load_share(&forces));

    // Tangential forces over the static limit, and the kinetic limits over it.
    let mobilised: Vec<[f64; 2]> = (contacts.iter())
        .filter_map(|contact| Some((view.setting.coulomb_bounds(view.frame, contact)?, contact.tangential_force)))
        .filter(|([bound, _], _)| *bound > 0.0)
        .map(|([bound, kinetic], tangential)| [Vector3::from(tangential).norm() / bound, kinetic / bound])
        .collect();
    if !mobilised.is_empty() {
        readings.add(MOBILISATION, mean(&mobilised.iter().map(|[share, _]| *share).collect::<Vec<f64>>()));
        let slides = |[share, kinetic]: &&[f64; 2]| {
            *share >= 1.0 - AT_LIMIT || (*kinetic > 0.0 && (share / kinetic - 1.0).abs() <= AT_LIMIT)
        };
        let sliding = mobilised.iter().filter(slides).count();
        readings.add(SLIDING, sliding as f64 / mobilised.len() as f64);
    }

    let outer = contacts.iter().map(|contact| Vector3::from(contact.normal)).map(|n| n * n.transpose());
    let fabric = outer.sum::<Matrix3<f64>>() / contacts.len() as f64;
    let coefficient = (fabric - Matrix3::identity() / 3.0) * 7.5;
    readings.add(ANISOTROPY, (1.5 * coefficient.norm_squared()).sqrt());
    readings.add(MEAN_FORCE, mean(&forces));
    Ok(())
}
