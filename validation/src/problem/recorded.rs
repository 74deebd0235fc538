//! Problems that the program holds, each with the answer that Siconos gave.

use super::{ProblemFile, parse, solution};
use crate::plan::Scene;
use makadam::scene::SceneError;
use nalgebra::Vector3;

/// A problem on record.
pub struct Recorded {
    /// Its name.
    pub name: &'static str,
    /// Time of the step, s.
    pub time: f64,
    scene: &'static str,
    file: &'static [u8],
}

/// The version of Siconos whose answers are on record.
pub const SICONOS: &str = "4.4.0";

/// The problems on record.
pub const RECORDED: [Recorded; 4] = [
    Recorded {
        name: "packing",
        time: 0.45,
        scene: include_str!("recorded/packing.toml"),
        file: include_bytes!("recorded/packing.hdf5"),
    },
    Recorded {
        name: "drum",
        time: 1.5,
        scene: include_str!("recorded/drum.toml"),
        file: include_bytes!("recorded/drum.hdf5"),
    },
    Recorded {
        name: "oedometer",
        time: 0.7,
        scene: include_str!("recorded/oedometer.toml"),
        file: include_bytes!("recorded/oedometer.hdf5"),
    },
    Recorded {
        name: "packing-100",
        time: 0.5,
        scene: include_str!("../../reference-scenes/packing-100/scene.toml"),
        file: include_bytes!("recorded/packing-100.hdf5"),
    },
];

impl Recorded {
    /// The scene whose step it is.
    ///
    /// # Errors
    /// [`SceneError`] if the scene is refused.
    pub fn scene(&self) -> Result<Scene, SceneError> {
        Scene::parse(self.scene)
    }

    /// The problem.
    ///
    /// # Errors
    /// What is wrong with it, in words.
    pub fn problem(&self) -> Result<ProblemFile, String> {
        parse(self.file.to_vec())
    }

    /// The impulses that Siconos found, in the frames of the contacts, N s.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn siconos(&self) -> Result<Vec<Vector3<f64>>, String> {
        solution(self.file.to_vec())
    }
}
