//! Published distributions of normal forces, as densities over the mean force.

use std::f64::consts::PI;

/// A published density of f, the force over its mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LiteratureCurve {
    /// Mueth, Jaeger & Nagel, Phys. Rev. E 57, 3164 (1998): P(f) = 3 (1 - 0.75 exp(-f^2)) exp(-1.5 f), from forces on
    /// the walls of a bead packing.
    Mueth,
    /// Radjai et al., Phys. Rev. Lett. 77, 274 (1996): a power f^-0.3 below the mean, exp(1.4 (1 - f)) above it, from
    /// contact dynamics.
    Radjai,
    /// exp(-f), the reference of the q model.
    Exponential,
}

impl LiteratureCurve {
    /// How it is named in a plot.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mueth => "Mueth et al. 1998",
            Self::Radjai => "Radjai et al. 1996",
            Self::Exponential => "exponential",
        }
    }

    /// Probability density of f = force over mean force, scaled so that both its integral and its mean are 1.
    ///
    /// The published coefficients are rounded: the fit of Mueth integrates to 0.989 with a mean of 1.01.
    pub fn density(self, force: f64) -> f64 {
        let (integral, mean) = self.moments();
        mean * self.published(mean * force) / integral
    }

    fn published(self, force: f64) -> f64 {
        match self {
            Self::Mueth => 3.0 * (1.0 - 0.75 * (-force * force).exp()) * (-1.5 * force).exp(),
            Self::Radjai if force < 1.0 => force.powf(-0.3),
            Self::Radjai => (1.4 * (1.0 - force)).exp(),
            Self::Exponential => (-force).exp(),
        }
    }

    /// Integral and mean of the published form, in closed form.
    fn moments(self) -> (f64, f64) {
        match self {
            Self::Mueth => {
                // With I the integral of exp(-f^2 - b f): I = sqrt(pi)/2 exp(b^2/4) erfc(b/2), and the integral of
                // f exp(-f^2 - b f) is (1 - b I)/2.
                let b = 1.5_f64;
                let gaussian = 0.5 * PI.sqrt() * (b * b / 4.0).exp() * statrs::function::erf::erfc(b / 2.0);
                let integral = 3.0 * (1.0 / b - 0.75 * gaussian);
                let first = 3.0 * (1.0 / (b * b) - 0.75 * 0.5 * (1.0 - b * gaussian));
                (integral, first / integral)
            }
            Self::Radjai => {
                let (below, above) = (1.0 / 0.7, 1.0 / 1.4);
                let first = 1.0 / 1.7 + 1.0 / 1.4 + 1.0 / (1.4 * 1.4);
                (below + above, first / (below + above))
            }
            Self::Exponential => (1.0, 1.0),
        }
    }
}
