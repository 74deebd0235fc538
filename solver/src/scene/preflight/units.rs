//! Checks for values that no known granular material has: most often a value in a unit other than the SI unit of the key.
//!
//! Each bound is that of an existing material or machine, so that a value beyond the bound is either in other units or
//! of a thought experiment. The scene runs nevertheless.

use crate::scene::Scene;
use crate::scene::document::DocumentPath;
use crate::scene::error::{Fault, short};

/// Largest diameter below a boulder's on Wentworth's scale, m.
const BOULDER: f64 = 0.256;
/// Diameter of a colloid, which Brownian motion moves more than gravity does, m.
const COLLOID: f64 = 1e-6;
/// Density of osmium, the densest element, kg/m3. In g/cm3 it is 22.59: a density below this number may be one in g/cm3.
const OSMIUM: f64 = 22_590.0;
/// Number of kg/m3 in one g/cm3.
const GRAMS_PER_CUBIC_CENTIMETRE: f64 = 1e3;
/// Young's modulus of diamond, Pa.
const DIAMOND: f64 = 1.22e12;
/// Young's modulus of hydrogel beads, Pa.
const HYDROGEL: f64 = 1e4;
/// Largest measured coefficient of friction between dry solids: clean metals in vacuum, rubber.
const STICKIEST: f64 = 4.0;
/// Largest acceleration of geotechnical centrifuges, m/s2. Gravity of the Earth in mm/s2 is twice this number.
const CENTRIFUGE: f64 = 5_000.0;

/// Returns the findings on values that no known material or machine has.
pub(super) fn faults(scene: &Scene) -> Vec<Fault> {
    let root = DocumentPath::default();
    let mut faults: Vec<Fault> = sizes(scene).into_iter().collect();
    for (name, material) in &scene.material {
        let at = root.key("material").name(name);
        faults.extend(density(&at.key("density"), material.density));
        faults.extend(modulus(&at.key("youngs_modulus"), material.youngs_modulus));
        faults.extend(friction(&at.key("friction"), material.friction));
    }
    for (index, rule) in scene.pair.iter().enumerate() {
        faults.extend(rule.friction.and_then(|value| friction(&root.key("pair").index(index).key("friction"), value)));
    }
    let gravity = scene.gravity.iter().map(|part| part * part).sum::<f64>().sqrt();
    if gravity > CENTRIFUGE {
        let problem = format!("{} m/s2 is more than any centrifuge has ({CENTRIFUGE} m/s2)", short(gravity));
        faults.push(root.key("gravity").fault(problem, "is it in mm/s2? 9810 mm/s2 is 9.81 m/s2"));
    }
    faults
}

/// Returns the fault of the first population or grain with an implausible size in metres; one fault is enough.
fn sizes(scene: &Scene) -> Option<Fault> {
    scene.radii().find_map(|(at, (least, most))| {
        let (least, most) = (2.0 * least, 2.0 * most);
        if most > BOULDER {
            let problem = format!("grains of {} m in diameter are boulders (above {BOULDER} m)", short(most));
            let remedy = format!("are lengths in metres? {} mm are {} m", short(most), short(most * 1e-3));
            return Some(at.fault(problem, &remedy));
        }
        let problem = || {
            format!(
                "grains of {} m in diameter are colloids (below 1 µm): Brownian motion is not simulated",
                short(least)
            )
        };
        (least < COLLOID).then(|| at.fault(problem(), "are lengths in metres? 1 µm is 1e-6 m"))
    })
}

fn density(at: &DocumentPath, value: f64) -> Option<Fault> {
    if value > OSMIUM {
        let problem = format!("{} kg/m3 is denser than any material (osmium has {OSMIUM} kg/m3)", short(value));
        return Some(at.fault(problem, "is it in kg/m3?"));
    }
    let remedy = || {
        let value = short(value);
        format!(
            "is it in g/cm3? {value} g/cm3 are {} kg/m3",
            short(GRAMS_PER_CUBIC_CENTIMETRE * value.parse().unwrap_or(0.0))
        )
    };
    let problem = || format!("{} kg/m3 is lighter than 22.59 kg/m3, as foams alone are", short(value));
    (value < OSMIUM / GRAMS_PER_CUBIC_CENTIMETRE).then(|| at.fault(problem(), &remedy()))
}

fn modulus(at: &DocumentPath, value: f64) -> Option<Fault> {
    let (problem, remedy) = if value > DIAMOND {
        (format!("{} Pa is stiffer than diamond ({} Pa)", short(value), short(DIAMOND)), "is it in Pa?")
    } else if value < HYDROGEL {
        (
            format!("{} Pa is softer than beads of hydrogel ({} Pa)", short(value), short(HYDROGEL)),
            "is it in MPa or GPa? 1 GPa is 1e9 Pa",
        )
    } else {
        return None;
    };
    Some(at.fault(problem, remedy))
}

fn friction(at: &DocumentPath, value: f64) -> Option<Fault> {
    let remedy = || match value < 90.0 {
        true => format!("is it an angle in degrees? the coefficient is its tangent, {:.3}", value.to_radians().tan()),
        false => "is it the coefficient? 1 stands for an angle of 45 degrees".into(),
    };
    let problem = || format!("{} is more than any two dry solids have ({STICKIEST})", short(value));
    (value > STICKIEST).then(|| at.fault(problem(), &remedy()))
}
