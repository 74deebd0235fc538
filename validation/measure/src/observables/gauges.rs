//! Flux of mass and grains through each gauge of a scene, from the passages that frames state.

use super::catalogue::{Group, define, nothing_of_a_frame};
use super::discharge::{error_of_rate, rate};
use super::frames::Frames;
use super::measurement::Measurement;
use super::setting::Properties;
use makadam_frames::plan::Observable;

pub(super) const GROUP: Group = Group {
    observable: Observable::Gauges,
    name: "gauges",
    read: nothing_of_a_frame,
    definitions: &[
        define(
            ["flux(gauge)", "W", "kg/s"],
            "mass through a gauge, forward minus backward, over the time between the first and the last measured frame",
        )
        .of_span(),
        define(["grain_flux(gauge)", "Q", "1/s"], "as W, of the number of grains").of_span(),
    ],
};

/// Measures the fluxes; empty for a single frame and for frames without passages.
pub fn measure<F: Frames + ?Sized>(properties: &Properties<'_>, frames: &F) -> Result<Vec<Measurement>, F::Error> {
    let gauges = &properties.scene.gauge;
    let mut passed = vec![[Vec::new(), Vec::new()]; gauges.len()];
    frames.visit_grains(0..frames.count(), &mut |frame| {
        for ([mass, grains], [forward, backward]) in passed.iter_mut().zip(&frame.gauges) {
            mass.push([frame.time, forward.mass - backward.mass]);
            grains.push([frame.time, forward.grains as f64 - backward.grains as f64]);
        }
    })?;
    let mut measurements = Vec::new();
    for (gauge, net) in gauges.iter().zip(&passed) {
        for (name, net) in ["flux(gauge)", "grain_flux(gauge)"].into_iter().zip(net) {
            let name = name.replace("(gauge)", &format!("({})", gauge.name));
            measurements.extend(rate(net).map(|rate| Measurement::of(&name, rate, error_of_rate(net), net.len())));
        }
    }
    Ok(measurements)
}
