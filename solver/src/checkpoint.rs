//! A state that a later run starts from: grains and the impulses of their contacts.

use crate::Simulation;
use crate::detect::{Impulse, PairCandidate, WallCandidate};
use crate::partition::Plan;
use crate::scene::Scene;
use crate::world::{Body, Sphere, World};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// First bytes of a file; the last one is the version of the format.
const MAGIC: [u8; 8] = *b"makadam\x01";

/// Why a state could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum CheckpointError {
    /// The system refused.
    #[error("{}: {source}; check that the path is right and the disk has room", file.display())]
    Io {
        /// The file.
        file: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The bytes are not a state of this version.
    #[error("{}: {problem}; delete the file, it will be made anew", file.display())]
    Format {
        /// The file.
        file: PathBuf,
        /// What is wrong.
        problem: String,
    },
    /// The scene has no such state.
    #[error(transparent)]
    Scene(#[from] crate::scene::SceneError),
}

#[derive(Serialize, Deserialize)]
struct State {
    step: f64,
    grains: Vec<GrainState>,
    pairs: Vec<(u32, u32, f64, [f64; 3])>,
    walls: Vec<(u32, u32, f64, [f64; 3])>,
}

#[derive(Serialize, Deserialize)]
struct GrainState {
    position: [f64; 3],
    velocity: [f64; 3],
    surface_speed: [f64; 3],
    radius: f64,
    inverse_mass: f64,
    material: u8,
}

impl Simulation {
    /// Writes the grains and their contacts' impulses, through a temporary name so that half a file is never read.
    ///
    /// # Errors
    /// [`CheckpointError::Io`] if the file cannot be written.
    pub fn save(&self, file: &Path) -> Result<(), CheckpointError> {
        let world = &self.world;
        let grains = self.places_by_id().into_iter().map(|place| place as usize).map(|i| GrainState {
            position: world.spheres[i].centre.into(),
            velocity: world.bodies[i].velocity,
            surface_speed: world.bodies[i].surface_speed,
            radius: world.spheres[i].radius,
            inverse_mass: world.bodies[i].inverse_mass,
            material: world.materials[i],
        });
        let id = |place: u32| world.ids[place as usize];
        let live = |impulse: &Impulse| impulse.normal > 0.0;
        let pairs = self.candidates.pairs.iter().zip(&self.candidates.pair_impulses).filter(|(_, i)| live(i));
        let walls = self.candidates.walls.iter().zip(&self.candidates.wall_impulses).filter(|(_, i)| live(i));
        let state = State {
            step: self.settings.step,
            grains: grains.collect(),
            pairs: pairs.map(|(pair, i)| (id(pair.first), id(pair.second), i.normal, i.tangential)).collect(),
            walls: walls.map(|(wall, i)| (id(wall.body), wall.surface, i.normal, i.tangential)).collect(),
        };
        let mut bytes = MAGIC.to_vec();
        let body = postcard::to_stdvec(&state)
            .map_err(|error| CheckpointError::Format { file: file.into(), problem: error.to_string() })?;
        bytes.extend(checksum(&body).to_le_bytes());
        bytes.extend(body);
        let io = |source| CheckpointError::Io { file: file.into(), source };
        if let Some(folder) = file.parent() {
            std::fs::create_dir_all(folder).map_err(io)?;
        }
        let draft = file.with_extension(format!("part{}", std::process::id()));
        std::fs::write(&draft, bytes).map_err(io)?;
        std::fs::rename(&draft, file).map_err(io)
    }

    /// Starts a scene at time zero from a saved state in place of its lattice gas.
    ///
    /// # Errors
    /// [`CheckpointError`] if the file cannot be read, is damaged, or holds another number of grains than the scene.
    pub fn resume(scene: &Scene, file: &Path) -> Result<Simulation, CheckpointError> {
        let bytes = std::fs::read(file).map_err(|source| CheckpointError::Io { file: file.into(), source })?;
        let refuse = |problem: String| CheckpointError::Format { file: file.into(), problem };
        let Some((head, body)) = bytes.split_at_checked(MAGIC.len() + 8) else {
            return Err(refuse("is too short for a state".into()));
        };
        if head[..MAGIC.len()] != MAGIC {
            return Err(refuse("is not a state of this version".into()));
        }
        if head[MAGIC.len()..] != checksum(body).to_le_bytes() {
            return Err(refuse("its checksum does not fit: it is damaged".into()));
        }
        let state: State = postcard::from_bytes(body).map_err(|error| refuse(error.to_string()))?;
        let expected = scene.grain.len() + scene.population.iter().map(|group| group.count).sum::<usize>();
        if state.grains.len() != expected {
            return Err(refuse(format!("holds {} grains where the scene has {expected}", state.grains.len())));
        }
        let mut simulation = Simulation::of_world(scene, restore(scene, &state, &refuse)?);
        let scale = scene.solver.step / state.step;
        let impulse = |normal: f64, tangential: [f64; 3]| Impulse {
            normal: normal * scale,
            tangential: tangential.map(|component| component * scale),
        };
        let (grains, surfaces) = (state.grains.len() as u32, simulation.world.surfaces.len() as u32);
        // Grains lie in the order of their ids until the first list is built.
        let candidates = &mut simulation.candidates;
        candidates.pair_impulses.clear();
        candidates.wall_impulses.clear();
        for &(first, second, normal, tangential) in &state.pairs {
            if first >= grains || second >= grains {
                return Err(refuse("names a grain that is not there".into()));
            }
            candidates.pairs.push(PairCandidate { first, second });
            candidates.pair_impulses.push(impulse(normal, tangential));
        }
        for &(body, surface, normal, tangential) in &state.walls {
            if body >= grains || surface >= surfaces {
                return Err(refuse("names a grain or wall that is not there".into()));
            }
            candidates.walls.push(WallCandidate { body, surface });
            candidates.wall_impulses.push(impulse(normal, tangential));
        }
        candidates.pair_impulses.push(Impulse::default());
        candidates.wall_impulses.push(Impulse::default());
        simulation.layout.plan = Plan::single(state.pairs.len() as u32, state.walls.len() as u32);
        Ok(simulation)
    }
}

fn restore(
    scene: &Scene,
    state: &State,
    refuse: &impl Fn(String) -> CheckpointError,
) -> Result<World, CheckpointError> {
    let mut world = World::new(scene, &[]);
    for (id, grain) in state.grains.iter().enumerate() {
        if usize::from(grain.material) >= scene.material.len() {
            return Err(refuse("names a material that is not there".into()));
        }
        world.ids.push(id as u32);
        world.spheres.push(Sphere { centre: Vector3::from(grain.position), radius: grain.radius });
        world.materials.push(grain.material);
        world.bodies.push(Body {
            velocity: grain.velocity,
            inverse_mass: grain.inverse_mass,
            surface_speed: grain.surface_speed,
            spare: 0.0,
        });
    }
    Ok(world)
}

/// FNV-1a, 64 bits.
pub(crate) fn checksum(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3))
}
