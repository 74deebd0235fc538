//! Scenes made in code.

use super::types::usual_spacing;
use super::{
    Accuracy, Axis, GrainEntry, Insertion, Material, Motion, PairRule, Placement, Population, RadiusDistribution,
    Region, Removal, Scene, SceneError, Shape, SolverSettings, Stage, Wall, Watch,
};
use crate::surface::{FACES, around};

/// Builder of a scene: [`Scene::builder`].
///
/// Absent values have the defaults of a scene file. Without a [`domain`](SceneBuilder::domain), the domain of the scene
/// is the smallest box around the regions of its populations and sources, its grains and its bounded walls.
#[derive(Clone, Debug)]
pub struct SceneBuilder {
    scene: Scene,
    domain: Option<([f64; 3], [f64; 3])>,
}

/// Scene without grains and walls, under the gravity of the Earth along -z.
impl Default for Scene {
    fn default() -> Scene {
        let form =
            "name = 'scene'\nduration = 1.0\ndomain = { min = [0.0, 0.0, 0.0], max = [0.0, 0.0, 0.0] }\nmaterial = {}";
        toml::from_str(form).expect("all that a scene has to give")
    }
}

impl Scene {
    /// Returns a builder of a scene without grains and walls, under the gravity of the Earth along -z.
    pub fn builder() -> SceneBuilder {
        SceneBuilder { scene: Scene::default(), domain: None }
    }

    /// Scene of the examples in this documentation: 40 grains above an open box.
    #[doc(hidden)]
    pub fn example() -> Scene {
        let [min, max] = [[0.0; 3], [0.04, 0.04, 0.12]];
        let grains = Population::new(40, "glass", RadiusDistribution::uniform(0.005, 0.05), Region::cuboid(min, max));
        let walls = Wall::new("box", "glass", Shape::cuboid(min, max, &[Face::Top]));
        let scene = Scene::builder().material("glass", Material::default()).wall(walls).population(grains).build();
        scene.expect("all values are in their ranges")
    }
}

impl SceneBuilder {
    crate::setters! {
        /// Name in messages; default: "scene".
        name(name: impl Into<String>) |builder| builder.scene.name = name.into();
        /// Simulated time (s) for which the values of the scene must be valid; default: 1 s.
        duration(duration: f64) |builder| builder.scene.duration = duration;
        /// Acceleration of gravity, m/s2.
        gravity(gravity: [f64; 3]) |builder| builder.scene.gravity = gravity;
        /// Makes space periodic along an axis, with the length of the domain.
        periodic(axis: Axis) |builder| builder.scene.domain.periodic.push(axis);
        /// Adds coefficients of a particular pair of materials.
        pair(rule: PairRule) |builder| builder.scene.pair.push(rule);
        /// Adds a wall.
        wall(wall: Wall) |builder| builder.scene.wall.push(wall);
        /// Adds a group of grains placed by rule.
        population(population: Population) |builder| builder.scene.population.push(population);
        /// Adds a source of grains.
        insert(source: Insertion) |builder| builder.scene.insert.push(source);
        /// Adds a sink of grains.
        remove(sink: Removal) |builder| builder.scene.remove.push(sink);
        /// Adds a stage after those before; the stages give the duration.
        stage(stage: Stage) |builder| builder.scene.stage.push(stage);
        /// Adds a grain.
        grain(grain: GrainEntry) |builder| builder.scene.grain.push(grain);
        /// Settings of the time step and of the contact solver.
        solver(settings: SolverSettings) |builder| builder.scene.solver = settings;
        /// Requests an accuracy, which sets the step and stop of the solver when the scene is built.
        accuracy(accuracy: Accuracy) |builder| builder.scene.accuracy = Some(accuracy);
        /// Settings of the watchdogs.
        watch(watch: Watch) |builder| builder.scene.watch = watch;
    }

    /// Adds a material, or replaces the material of the same name.
    pub fn material(mut self, name: impl Into<String>, material: Material) -> SceneBuilder {
        self.scene.material.insert(name.into(), material);
        self
    }

    /// Lower and upper corner of the box that no grain may leave, m.
    pub fn domain(mut self, min: [f64; 3], max: [f64; 3]) -> SceneBuilder {
        self.domain = Some((min, max));
        self
    }

    /// Builds the scene, with the checks of scenes from files.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] with the first fault, such as an unknown material.
    pub fn build(self) -> Result<Scene, SceneError> {
        let SceneBuilder { mut scene, domain } = self;
        (scene.domain.min, scene.domain.max) = domain.unwrap_or_else(|| extent(&scene));
        scene.duration = scene.longest_of_stages().unwrap_or(scene.duration);
        if scene.solver.step == 0.0 {
            scene.solver.step = scene.default_step();
        }
        // The law of an accuracy needs valid values.
        super::check::check(&scene)?;
        if let Some(accuracy) = scene.accuracy {
            scene.ask(accuracy);
        }
        scene.check()?;
        Ok(scene)
    }
}

/// Returns the corners (m) of the smallest box around all positions in a scene; an empty box for a scene without positions.
fn extent(scene: &Scene) -> ([f64; 3], [f64; 3]) {
    let mut all: Vec<_> = scene.wall.iter().flat_map(|wall| wall.shape.bounds()).collect();
    all.extend(scene.population.iter().map(|population| population.region.bounds()));
    all.extend(scene.insert.iter().map(|source| source.region.bounds()));
    all.extend(scene.grain.iter().map(|grain| around(&grain.position, &[grain.radius; 3])));
    let none = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    all.into_iter().fold(none, |(low, high), (min, max)| {
        (std::array::from_fn(|i| low[i].min(min[i])), std::array::from_fn(|i| high[i].max(max[i])))
    })
}

impl PairRule {
    /// Creates a rule of two materials, in any order, without coefficients.
    pub fn between(first: impl Into<String>, second: impl Into<String>) -> PairRule {
        PairRule { between: [first.into(), second.into()], ..PairRule::default() }
    }
}

/// Face of a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Face {
    /// At the smallest x.
    Left,
    /// At the largest x.
    Right,
    /// At the smallest y.
    Front,
    /// At the largest y.
    Back,
    /// At the smallest z.
    Bottom,
    /// At the largest z.
    Top,
}

impl Face {
    /// Returns the name of the face in a scene file.
    pub fn name(self) -> &'static str {
        FACES[self as usize]
    }
}

impl Wall {
    /// Creates a wall at rest.
    pub fn new(name: impl Into<String>, material: impl Into<String>, shape: Shape) -> Wall {
        Wall {
            name: name.into(),
            material: material.into(),
            shape,
            motion: Motion::Fixed,
            parent: None,
            surface_velocity: [0.0; 3],
        }
    }

    /// Sets the wall that carries this one, by its name.
    pub fn on(self, parent: impl Into<String>) -> Wall {
        Wall { parent: Some(parent.into()), ..self }
    }

    /// Sets the motion.
    pub fn moving(self, motion: Motion) -> Wall {
        Wall { motion, ..self }
    }

    /// Sets the velocity of the surface along itself, m/s.
    pub fn with_surface_velocity(self, surface_velocity: [f64; 3]) -> Wall {
        Wall { surface_velocity, ..self }
    }
}

impl Shape {
    /// Creates a plane through a point (m); grains are on the side of the normal.
    pub fn plane(point: [f64; 3], normal: [f64; 3]) -> Shape {
        Shape::Plane { point, normal }
    }

    /// Creates a box seen from inside, between two corners (m), without the open faces.
    pub fn cuboid(min: [f64; 3], max: [f64; 3], open: &[Face]) -> Shape {
        Shape::Box { min, max, open: open.iter().map(|face| face.name().to_string()).collect() }
    }
}

impl Population {
    /// Creates a group of `count` grains of a material, at rest, on a lattice with a clearance of a tenth of their diameter.
    pub fn new(count: usize, material: impl Into<String>, radius: RadiusDistribution, region: Region) -> Population {
        Population {
            count,
            material: material.into(),
            radius,
            region,
            placement: Placement::Lattice,
            spacing: usual_spacing(),
            agitation: 0.0,
        }
    }
}

impl RadiusDistribution {
    /// Creates a uniform distribution between `mean (1 - spread)` and `mean (1 + spread)`, with the mean in m.
    pub fn uniform(mean: f64, spread: f64) -> RadiusDistribution {
        RadiusDistribution::Uniform { mean, spread }
    }
}

impl Region {
    /// Creates an axis-aligned box between two corners (m).
    pub fn cuboid(min: [f64; 3], max: [f64; 3]) -> Region {
        Region::Box { min, max }
    }
}
