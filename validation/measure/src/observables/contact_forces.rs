//! Contact forces between grains in the bulk: distribution of normal forces, mobilised friction, fabric.

use super::catalogue::{CONTACTS, Group, define};
use super::measurement::Readings;
use super::view::View;
use crate::statistics::{gini, mean, second_moment, share_below_mean, weak_load_share};
use makadam_frames::plan::Observable;
use nalgebra::{Matrix3, Vector3};

pub(super) const GROUP: Group = Group {
    observable: Observable::ContactForces,
    name: "contact-forces",
    read,
    definitions: &[
        define(
            ["share_below_mean", "s", ""],
            "fraction of contacts between grains, with points in the bulk, with f_n < ⟨f_n⟩",
        )
        .needs(CONTACTS),
        define(["gini", "G", ""], "Gini coefficient of f_n: Σ_ij |f_i − f_j| / (2 N² ⟨f⟩); 0 where all are equal")
            .needs(CONTACTS),
        define(["force_second_moment", "M_2", ""], "⟨f_n²⟩ / ⟨f_n⟩²").needs(CONTACTS),
        define(
            ["weak_load_share", "w", ""],
            "Σ f_n over contacts below the mean, over Σ f_n of all: the load on the weak network",
        )
        .source("Radjai et al., Phys. Rev. Lett. 77, 274 (1996)")
        .needs(CONTACTS),
        define(["friction_mobilisation", "I_m", ""], "⟨f_t / (μ f_n)⟩ with the static friction μ").needs(CONTACTS),
        define(
            ["sliding_share", "χ_s", ""],
            "fraction of contacts at a limit of friction: f_t ≥ 0.99 μ f_n, or f_t within 1% of μ_k f_n, with the \
             static friction μ and the kinetic friction μ_k",
        )
        .needs(CONTACTS),
        define(["fabric_anisotropy", "a_c", ""], "√(3/2 a:a) with a = 15/2 (⟨n nᵀ⟩ − 1/3) over contact normals n")
            .source("Guo & Zhao, J. Mech. Phys. Solids 61, 1 (2013)")
            .needs(CONTACTS),
        define(
            ["mean_normal_force", "⟨f_n⟩", "N"],
            "mean normal force of contacts between grains whose points lie in the bulk",
        )
        .needs(CONTACTS),
    ],
};

/// Smallest number of contacts for a distribution.
const FEWEST: usize = 20;

/// Relative tolerance of tangential forces at a limit of friction.
const AT_LIMIT: f64 = 0.01;

fn read(view: &View<'_>, readings: &mut Readings) -> Result<(), String> {
    view.bulk()?;
    let contacts = view.bulk_contacts();
    if contacts.len() < FEWEST {
        return Err(format!("{} contacts between grains of the bulk are fewer than {FEWEST}", contacts.len()));
    }
    let forces: Vec<f64> = contacts.iter().map(|contact| contact.normal_force).collect();
    readings.add("share_below_mean", share_below_mean(&forces));
    readings.add("gini", gini(&forces));
    readings.add("force_second_moment", second_moment(&forces));
    readings.add("weak_load_share", weak_load_share(&forces));

    // Tangential forces over the static limit, and the kinetic limits over the static limit.
    let mobilised: Vec<[f64; 2]> = (contacts.iter())
        .filter_map(|contact| Some((view.setting.coulomb_bounds(view.frame, contact)?, contact.tangential_force)))
        .filter(|([bound, _], _)| *bound > 0.0)
        .map(|([bound, kinetic], tangential)| [Vector3::from(tangential).norm() / bound, kinetic / bound])
        .collect();
    if !mobilised.is_empty() {
        readings.add("friction_mobilisation", mean(&mobilised.iter().map(|[share, _]| *share).collect::<Vec<f64>>()));
        let slides = |[share, kinetic]: &&[f64; 2]| {
            *share >= 1.0 - AT_LIMIT || (*kinetic > 0.0 && (share / kinetic - 1.0).abs() <= AT_LIMIT)
        };
        let sliding = mobilised.iter().filter(slides).count();
        readings.add("sliding_share", sliding as f64 / mobilised.len() as f64);
    }

    let outer = contacts.iter().map(|contact| Vector3::from(contact.normal)).map(|n| n * n.transpose());
    let fabric = outer.sum::<Matrix3<f64>>() / contacts.len() as f64;
    let coefficient = (fabric - Matrix3::identity() / 3.0) * 7.5;
    readings.add("fabric_anisotropy", (1.5 * coefficient.norm_squared()).sqrt());
    readings.add("mean_normal_force", mean(&forces));
    Ok(())
}
