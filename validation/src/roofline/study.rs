//! A roofline as data.

use super::machine::Roofs;
use super::point::{Kernel, Point};
use crate::execution::MeasureError;
use crate::output::JSON_VERSION;
use makadam::Simulation;
use makadam::lanes::InstructionSet;
use makadam::sweep::Operations;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Steps that fill caches and buffers first.
const WARM_UP: usize = 3;

/// Roofs and the sweeps beneath them, from one run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Study {
    /// Version of this layout.
    pub version: u32,
    /// Always "roofline".
    pub command: String,
    /// Instruction set of roofs and kernels.
    pub instruction_set: String,
    /// Operations of a contact of two grains.
    pub pair: Operations,
    /// Operations of a contact with a wall.
    pub wall: Operations,
    /// By number of threads.
    pub roofs: Vec<Roofs>,
    /// Measured sweeps.
    pub points: Vec<Point>,
    /// Where they came from.
    pub provenance: BTreeMap<String, String>,
}

impl Study {
    /// The roofs of one thread and of `most`, without sweeps; none where the processor does not have the instruction set.
    pub fn of_machine(set: InstructionSet, most: usize, provenance: BTreeMap<String, String>) -> Study {
        let mut counts = vec![1, most];
        counts.dedup();
        counts.retain(|_| set.is_available());
        Study {
            version: JSON_VERSION,
            command: "roofline".into(),
            instruction_set: set.name().into(),
            pair: Operations::of_pair(),
            wall: Operations::of_wall(),
            roofs: counts.into_iter().map(|threads| Roofs::measure(set, threads)).collect(),
            points: Vec::new(),
            provenance,
        }
    }

    /// Adds the sweeps of a flowing state beneath every roof; whether it has contacts to sweep over.
    ///
    /// # Errors
    /// [`MeasureError`] if the machine cannot step as asked, or the user asked to stop.
    pub fn measure(&mut self, scene: &str, simulation: &mut Simulation) -> Result<bool, MeasureError> {
        (0..WARM_UP).for_each(|_| {
            simulation.step();
        });
        if simulation.layout().contacts == 0 {
            return Ok(false);
        }
        let set = simulation.instruction_set();
        for roofs in &self.roofs {
            for kernel in [Kernel::Scalar, Kernel::Lanes] {
                self.points.push(Point::measure(scene, simulation, kernel, set, roofs)?);
                if crate::interrupt::requested() {
                    return Err(MeasureError::Interrupted);
                }
            }
        }
        Ok(true)
    }
}
