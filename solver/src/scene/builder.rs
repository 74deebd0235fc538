//! Scenes made in code.

use super::{
    Accuracy, Axis, GrainEntry, Material, Motion, PairRule, Population, RadiusDistribution, Region, Scene, SceneError,
    Shape, SolverSettings, Wall, Watch,
};

/// Puts a scene together: [`Scene::builder`].
///
/// What is not said has the defaults of a scene's file. Without a [`domain`](SceneBuilder::domain) the scene has the smallest one that
/// holds the regions of its populations, its grains and the walls that end somewhere.
#[derive(Clone, Debug)]
pub struct SceneBuilder {
    scene: Scene,
    domain: Option<([f64; 3], [f64; 3])>,
}

/// A scene without grains and walls, under the gravity of the earth along -z.
impl Default for Scene {
    fn default() -> Scene {
        let form =
            "name = 'scene'\nduration = 1.0\ndomain = { min = [0.0, 0.0, 0.0], max = [0.0, 0.0, 0.0] }\nmaterial = {}";
        toml::from_str(form).expect("all that a scene has to give")
    }
}

impl Scene {
    /// A scene in the making, without grains and walls, under the gravity of the earth along -z.
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
        /// Name, used in messages; "scene" where none is given.
        name(name: impl Into<String>) |builder| builder.scene.name = name.into();
        /// Simulated time for which what the scene says has to hold, s; 1 s where none is given.
        duration(duration: f64) |builder| builder.scene.duration = duration;
        /// Acceleration of gravity, m/s2.
        gravity(gravity: [f64; 3]) |builder| builder.scene.gravity = gravity;
        /// Makes space periodic along an axis, with the length of the domain.
        periodic(axis: Axis) |builder| builder.scene.domain.periodic.push(axis);
        /// Adds coefficients of a particular pair of materials.
        pair(rule: PairRule) |builder| builder.scene.pair.push(rule);
        /// Adds a wall.
        wall(wall: Wall) |builder| builder.scene.wall.push(wall);
        /// Adds grains placed by rule.
        population(population: Population) |builder| builder.scene.population.push(population);
        /// Adds a grain.
        grain(grain: GrainEntry) |builder| builder.scene.grain.push(grain);
        /// Settings of the time step and of the contact solver.
        solver(settings: SolverSettings) |builder| builder.scene.solver = settings;
        /// Requests an accuracy, which decides on the solver's step and stop when the scene is built.
        accuracy(accuracy: Accuracy) |builder| builder.scene.accuracy = Some(accuracy);
        /// Settings of the watchdogs.
        watch(watch: Watch) |builder| builder.scene.watch = watch;
    }

    /// Adds a material, or replaces the one of that name.
    pub fn material(mut self, name: impl Into<String>, material: Material) -> SceneBuilder {
        self.scene.material.insert(name.into(), material);
        self
    }

    /// Lower and upper corner of the box that no grain may leave, m.
    pub fn domain(mut self, min: [f64; 3], max: [f64; 3]) -> SceneBuilder {
        self.domain = Some((min, max));
        self
    }

    /// The scene, checked by the rules that scenes from files have to keep.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] with the first fault, such as a material that there is not.
    pub fn build(self) -> Result<Scene, SceneError> {
        let SceneBuilder { mut scene, domain } = self;
        (scene.domain.min, scene.domain.max) = domain.unwrap_or_else(|| extent(&scene));
        // What the law of an accuracy reads has to be sound.
        super::check::check(&scene)?;
        if let Some(accuracy) = scene.accuracy {
            scene.ask(accuracy);
        }
        scene.check()?;
        Ok(scene)
    }
}

/// Corners of the smallest box that holds what a scene says of places, m; no box where it says nothing.
fn extent(scene: &Scene) -> ([f64; 3], [f64; 3]) {
    let mut all = Vec::new();
    for population in &scene.population {
        match &population.region {
            Region::Box { min, max } => all.push((*min, *max)),
            Region::Cylinder { base, axis, radius, length } => all.extend(ends(base, axis, *radius, *length)),
        }
    }
    for wall in &scene.wall {
        match &wall.shape {
            Shape::Plane { .. } => {}
            Shape::Box { min, max, .. } => all.push((*min, *max)),
            Shape::Cylinder { base, axis, radius, length } => all.extend(ends(base, axis, *radius, *length)),
            Shape::Disc { centre, normal, radius, .. } => all.extend(ends(centre, normal, *radius, 0.0)),
            Shape::Spheres { centres, radius } => {
                all.extend(centres.iter().map(|centre| around(centre, &[*radius; 3])))
            }
        }
    }
    all.extend(scene.grain.iter().map(|grain| around(&grain.position, &[grain.radius; 3])));
    let none = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    all.into_iter().fold(none, |(low, high), (min, max)| {
        (std::array::from_fn(|i| low[i].min(min[i])), std::array::from_fn(|i| high[i].max(max[i])))
    })
}

/// Corners of the boxes around the two ends of a cylinder, m.
fn ends(base: &[f64; 3], axis: &[f64; 3], radius: f64, length: f64) -> [([f64; 3], [f64; 3]); 2] {
    let norm = axis.iter().map(|x| x * x).sum::<f64>().sqrt();
    let side = axis.map(|x| radius * (1.0 - x * x / (norm * norm)).max(0.0).sqrt());
    [0.0, length / norm].map(|along| around(&std::array::from_fn(|i| base[i] + axis[i] * along), &side))
}

fn around(centre: &[f64; 3], side: &[f64; 3]) -> ([f64; 3], [f64; 3]) {
    (std::array::from_fn(|i| centre[i] - side[i]), std::array::from_fn(|i| centre[i] + side[i]))
}

impl PairRule {
    /// A rule of two materials, in any order, that decides on nothing yet.
    pub fn between(first: impl Into<String>, second: impl Into<String>) -> PairRule {
        PairRule { between: [first.into(), second.into()], ..PairRule::default() }
    }
}

/// A face of a box.
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
    /// Its name, as a scene's file says it.
    pub fn name(self) -> &'static str {
        ["-x", "+x", "-y", "+y", "-z", "+z"][self as usize]
    }
}

impl Wall {
    /// A wall at rest.
    pub fn new(name: impl Into<String>, material: impl Into<String>, shape: Shape) -> Wall {
        Wall { name: name.into(), material: material.into(), shape, motion: Motion::Fixed }
    }

    /// Sets the motion.
    pub fn moving(self, motion: Motion) -> Wall {
        Wall { motion, ..self }
    }
}

impl Shape {
    /// A plane through a point (m); grains live on the side that the normal points to.
    pub fn plane(point: [f64; 3], normal: [f64; 3]) -> Shape {
        Shape::Plane { point, normal }
    }

    /// A box seen from inside, between two corners (m), without the faces that are open.
    pub fn cuboid(min: [f64; 3], max: [f64; 3], open: &[Face]) -> Shape {
        Shape::Box { min, max, open: open.iter().map(|face| face.name().to_string()).collect() }
    }
}

impl Population {
    /// So many grains of a material, at rest, on a lattice that a tenth of their diameter is free in.
    pub fn new(count: usize, material: impl Into<String>, radius: RadiusDistribution, region: Region) -> Population {
        Population { count, material: material.into(), radius, region, spacing: 1.1, agitation: 0.0 }
    }
}

impl RadiusDistribution {
    /// Uniform between `mean (1 - spread)` and `mean (1 + spread)`, with the mean in m.
    pub fn uniform(mean: f64, spread: f64) -> RadiusDistribution {
        RadiusDistribution::Uniform { mean, spread }
    }
}

impl Region {
    /// An axis-aligned box between two corners, m.
    pub fn cuboid(min: [f64; 3], max: [f64; 3]) -> Region {
        Region::Box { min, max }
    }
}
