//! Profile of a flowing layer over its height: velocity, solid volume and stresses, in bins, summed over frames.
//!
//! Stresses are those of contacts, the force on one partner times the branch vector to it from the other, and of the velocities
//! about their mean (Irving & Kirkwood 1950; Goldhirsch, Granular Matter 12, 239, 2010), compression positive. A contact counts in
//! the bin of its point. Grains here overlap by some ten thousandths, so the branch is as long as the sum of the radii.

use super::super::results::{least, line};
use super::{DIAMETER, PERIOD};
use crate::sketch::DENSITY;
use makadam::snapshot::{Contact, Particle, Partner, Snapshot};
use std::f64::consts::PI;

/// Height of a bin, in diameters.
const BIN: f64 = 0.5;
/// Least distance of the fitted range from the bed and from the surface, in diameters.
pub(super) const MARGIN: f64 = 3.0;
/// Summed components of a stress: along the chute, across it, normal to it, and the shear.
const COMPONENTS: [(usize, usize); 4] = [(0, 0), (1, 1), (2, 2), (0, 2)];

/// Sums over the grains and the contacts of a bin.
#[derive(Clone, Copy, Default)]
struct Bin {
    /// Solid volume, m3.
    volume: f64,
    /// Solid volume times velocity, m4/s.
    flow: [f64; 3],
    /// Solid volume times velocity squared, m5/s2, by component of the stress.
    flux: [f64; 4],
    /// Force times branch vector, N m, by component of the stress.
    virial: [f64; 4],
}

/// Bins of a layer.
#[derive(Default)]
pub(super) struct Profile {
    bins: Vec<Bin>,
    frames: usize,
}

/// Fit to a profile.
pub(super) struct Fit {
    pub(super) solid_fraction: f64,
    /// Height of the layer at its mean solid fraction, m.
    pub(super) depth: f64,
    /// v_s, m/s, and A, m^(-1/2)/s, of Bagnold's profile.
    pub(super) surface_speed: f64,
    pub(super) bagnold: f64,
    /// Exponent of the depth with the best fit.
    pub(super) exponent: f64,
    /// Mean stress over the fitted range.
    pub(super) stress: Stress,
}

/// Components of a stress, Pa, compression positive.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stress {
    pub(super) along: f64,
    pub(super) across: f64,
    pub(super) normal: f64,
    pub(super) shear: f64,
}

impl Stress {
    /// Mean of the normal stresses, Pa.
    pub(super) fn pressure(&self) -> f64 {
        (self.along + self.across + self.normal) / 3.0
    }
}

impl Profile {
    pub(super) fn add(&mut self, frame: &Snapshot) {
        self.frames += 1;
        for grain in &frame.particles {
            let volume = 4.0 / 3.0 * PI * grain.radius.powi(3);
            let (bin, velocity) = (self.bin(grain.position[2]), grain.velocity);
            bin.volume += volume;
            bin.flow.iter_mut().zip(velocity).for_each(|(sum, velocity)| *sum += volume * velocity);
            for (sum, (i, j)) in bin.flux.iter_mut().zip(COMPONENTS) {
                *sum += volume * velocity[i] * velocity[j];
            }
        }
        for contact in &frame.contacts {
            let Partner::Grain(second) = contact.second else { continue };
            let [first, second] = [contact.first, second].map(|id| &frame.particles[id as usize]);
            self.add_contact(contact, first, second);
        }
    }

    fn add_contact(&mut self, contact: &Contact, first: &Particle, second: &Particle) {
        let force = contact.force_on_partner();
        let branch = contact.normal.map(|component| (first.radius + second.radius) * component);
        let bin = self.bin(contact.point[2]);
        for (sum, (i, j)) in bin.virial.iter_mut().zip(COMPONENTS) {
            *sum += force[i] * branch[j];
        }
    }

    fn bin(&mut self, height: f64) -> &mut Bin {
        let number = (height / (BIN * DIAMETER)).max(0.0) as usize;
        if self.bins.len() <= number {
            self.bins.resize(number + 1, Bin::default());
        }
        &mut self.bins[number]
    }

    /// Fits velocities over depths, and averages stresses over the same range.
    pub(super) fn fit(&self) -> Fit {
        let room = BIN * DIAMETER * PERIOD[0] * PERIOD[1] * DIAMETER * DIAMETER * self.frames as f64;
        let solid: Vec<f64> = self.bins.iter().map(|bin| bin.volume / room).collect();
        // Solid above the middle of each bin, m.
        let above: Vec<f64> = (0..solid.len())
            .map(|bin| BIN * DIAMETER * (0.5 * solid[bin] + solid[bin + 1..].iter().sum::<f64>()))
            .collect();
        let inside = |&number: &usize| {
            (number as f64 + 0.5) * BIN >= MARGIN
                && above[number] >= 0.57 * MARGIN * DIAMETER
                && self.bins[number].volume > 0.0
        };
        let fitted: Vec<usize> = (0..solid.len()).filter(inside).collect();
        let solid_fraction = fitted.iter().map(|&number| solid[number]).sum::<f64>() / fitted.len() as f64;
        let speed = |bin: &Bin| bin.flow[0] / bin.volume;
        let points: Vec<[f64; 2]> =
            fitted.iter().map(|&number| [above[number] / solid_fraction, speed(&self.bins[number])]).collect();
        let raised =
            |exponent: f64| points.iter().map(|&[depth, speed]| [depth.powf(exponent), speed]).collect::<Vec<_>>();
        let misfit = |exponent: f64| {
            let points = raised(exponent);
            let (slope, start) = line(&points);
            points.iter().map(|[x, y]| (y - start - slope * x).powi(2)).sum::<f64>()
        };
        let (slope, surface_speed) = line(&raised(1.5));
        Fit {
            solid_fraction,
            depth: solid.iter().sum::<f64>() * BIN * DIAMETER / solid_fraction,
            surface_speed,
            bagnold: -slope,
            exponent: least(misfit, 0.3, 4.0),
            stress: stress(fitted.iter().map(|&number| &self.bins[number]), room),
        }
    }
}

/// Mean stress over bins with this volume times frames each (m3).
fn stress<'a>(bins: impl Iterator<Item = &'a Bin>, room: f64) -> Stress {
    let (mut sum, mut count) = ([0.0; 4], 0);
    for bin in bins {
        count += 1;
        for (number, (i, j)) in COMPONENTS.into_iter().enumerate() {
            let about_the_mean = bin.flux[number] - bin.flow[i] * bin.flow[j] / bin.volume;
            sum[number] += (bin.virial[number] + DENSITY * about_the_mean) / room;
        }
    }
    let [along, across, normal, shear] = sum.map(|sum| sum / f64::from(count));
    // The layer above a plane drags the layer below along the chute: the component is negative.
    Stress { along, across, normal, shear: -shear }
}

#[cfg(test)]
#[path = "../../../tests/unit/laws_chute_profile.rs"]
mod tests;
