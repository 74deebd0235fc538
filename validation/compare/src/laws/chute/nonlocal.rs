//! Velocity profile of a layer by the nonlocal theory of Kamrin and Henann: the range of Bagnold's law.
//!
//! Bagnold's profile needs a friction that depends on the local inertial number alone. Near the slope on which a layer comes to rest, the
//! bed slows the flow over many diameters: the profile turns from `D^(3/2)` to a straight line (Silbert, Landry & Grest, Phys. Fluids 15,
//! 1, 2003). Kamrin & Henann (Soft Matter 11, 179, 2015) describe this by a fluidity `g = (dv/dz)/mu` that diffuses. In lengths of a
//! diameter, with the height z and the pressure P of the layer above:
//!
//! ```text
//! A^2 g'' + (mu_2 - mu_s) (mu - mu_s)/(mu_2 - mu) g - (mu_2 - mu_s)/I_0 sqrt(rho d^2/P) mu g^2 = 0
//! g = 0 at the bed, g' = 0 at the surface
//! ```
//!
//! `mu_s`, `mu_2` and `I_0` are those of glass beads (Jop, Forterre & Pouliquen 2006), `A` = 0.48 the amplitude of the cooperativity length
//! of glass beads (Henann & Kamrin, PNAS 110, 6730, 2013). Without `A` the profile is Bagnold's. No constant is fitted here.

use super::super::results::{least, line};
use super::profile::MARGIN;
use super::{BEADS, INERTIAL_OF_BEADS};

/// Amplitude of the cooperativity length.
const AMPLITUDE: f64 = 0.48;
/// Heights per diameter at which the fluidity is known.
const POINTS: usize = 20;

/// Returns the exponent of the depth that fits the velocity of a layer best, by a slope (degrees) and a depth (diameters), over the range
/// in which measured profiles are fitted; NaN where the theory has no steady flow.
pub(super) fn exponent(angle: f64, depth: f64) -> f64 {
    let friction = angle.to_radians().tan();
    let [least_friction, most_friction] = BEADS.map(|angle: f64| angle.to_radians().tan());
    let growth = (most_friction - least_friction) * (friction - least_friction) / (most_friction - friction);
    // The quarter wave of the linear equation is the shallowest layer that flows.
    if !(growth > 0.0 && depth * growth.sqrt() > AMPLITUDE * 0.5 * std::f64::consts::PI) {
        return f64::NAN;
    }
    let count = (depth * POINTS as f64).round() as usize;
    let height = depth / count as f64;
    let below = |number: usize| depth - number as f64 * height;
    // Pressure in units of the weight of a solid diameter; its unit is a factor of the velocity. A depth above zero is that of a grain.
    let damping = |number: usize| {
        (most_friction - least_friction) / INERTIAL_OF_BEADS * friction / below(number).max(0.05).sqrt()
    };
    let fluidity = steady(count, AMPLITUDE * AMPLITUDE / (height * height), growth, damping);
    let mut speed = 0.0;
    let mut points = Vec::new();
    for number in 1..=count {
        speed += 0.5 * (fluidity[number - 1] + fluidity[number]) * height;
        if number as f64 * height >= MARGIN && below(number) >= MARGIN {
            points.push([below(number), speed]);
        }
    }
    let misfit = |exponent: f64| {
        let raised: Vec<[f64; 2]> = points.iter().map(|[depth, speed]| [depth.powf(exponent), *speed]).collect();
        let (slope, start) = line(&raised);
        raised.iter().map(|[x, y]| (y - start - slope * x).powi(2)).sum::<f64>()
    };
    least(misfit, 0.3, 4.0)
}

/// Solves `diffusion (g[i-1] - 2 g[i] + g[i+1]) + growth g[i] - damping(i) g[i]^2 = 0` by Newton's method, from the local solution.
fn steady(count: usize, diffusion: f64, growth: f64, damping: impl Fn(usize) -> f64) -> Vec<f64> {
    let start = |number: usize| if number == 0 { 0.0 } else { growth / damping(number) };
    let mut fluidity: Vec<f64> = (0..=count).map(start).collect();
    for _ in 0..100 {
        // Elimination of the tridiagonal system for the change, upwards from the bed, where the change is zero.
        let (mut upper, mut right) = (vec![0.0; count + 1], vec![0.0; count + 1]);
        for number in 1..=count {
            let (own, damping) = (fluidity[number], damping(number));
            // The surface mirrors the point below it.
            let (below, above) = if number == count { (2.0 * diffusion, 0.0) } else { (diffusion, diffusion) };
            let next = if number == count { 0.0 } else { fluidity[number + 1] };
            let flow = below * fluidity[number - 1] + above * next + (growth - 2.0 * diffusion - damping * own) * own;
            let pivot = growth - 2.0 * (diffusion + damping * own) - below * upper[number - 1];
            upper[number] = above / pivot;
            right[number] = (-flow - below * right[number - 1]) / pivot;
        }
        let (mut change, mut largest) = (0.0, 0.0);
        for number in (1..=count).rev() {
            change = right[number] - upper[number] * change;
            fluidity[number] = (fluidity[number] + change).max(0.0);
            largest = f64::max(largest, f64::abs(change));
        }
        if largest < 1e-12 * fluidity[count] {
            break;
        }
    }
    fluidity
}

#[cfg(test)]
#[path = "../../../tests/unit/laws_chute_nonlocal.rs"]
mod tests;
