//! Builder of the scenes of stress tests and laws.

use makadam::scene::{
    Domain, GrainEntry, Material, Motion, Placement, Population, RadiusDistribution, Region, Shape, Stop, Wall,
};
use makadam_frames::plan::{Measure, MeasuredScene};

/// Default radius of a grain, m.
pub const RADIUS: f64 = 0.005;

/// Acceleration of gravity, m/s2.
pub const GRAVITY: f64 = 9.81;

/// Default density of a grain, kg/m3.
pub(crate) const DENSITY: f64 = 2500.0;

/// Pitch of the lattice of polydisperse grains, over the largest grain's diameter.
pub(crate) const SPACING: f64 = 1.04;

/// Poisson's ratio of all materials.
const POISSON_RATIO: f64 = 0.3;

/// Scene under construction. Grains are of "grain" and walls of "wall", unless stated otherwise.
pub struct Sketch(MeasuredScene);

impl Sketch {
    /// Returns a scene without grains and walls, in which every step is solved accurately; frames are taken at 50 times.
    pub fn new(name: impl Into<String>, duration: f64) -> Sketch {
        let material = Material {
            density: DENSITY,
            youngs_modulus: 1e7,
            poisson_ratio: POISSON_RATIO,
            friction: 0.5,
            restitution: 0.5,
            ..Material::default()
        };
        let materials = [("grain", material.clone()), ("wall", material)];
        let measure = Measure { interval: duration / 50.0, from: Some(0.0), ..Measure::default() };
        let simulated = makadam::scene::Scene::default();
        let mut scene = MeasuredScene { simulated, prepare: None, measure, output: None, compare: Vec::new() };
        scene.name = name.into();
        scene.description = "A hard case of makadam stability.".into();
        scene.duration = duration;
        scene.domain = Domain { min: [-0.5, -0.5, -0.1], max: [0.5, 0.5, 0.9], periodic: Vec::new() };
        scene.material = materials.into_iter().map(|(name, material)| (name.to_string(), material)).collect();
        scene.solver.step = 5e-4;
        scene.solver.stop = Stop::Residual { tolerance: 1e-6, max_sweeps: 1000 };
        Sketch(scene)
    }

    /// Applies any change to the scene.
    pub fn with(mut self, change: impl FnOnce(&mut MeasuredScene)) -> Sketch {
        change(&mut self.0);
        self
    }

    /// Returns the sketch with every material changed.
    pub fn materials(self, change: impl Fn(&mut Material)) -> Sketch {
        self.with(|scene| scene.material.values_mut().for_each(change))
    }

    /// Adds a material, a changed copy of "grain".
    pub fn material(self, name: &str, change: impl FnOnce(&mut Material)) -> Sketch {
        self.with(|scene| {
            let mut material = scene.material["grain"].clone();
            change(&mut material);
            scene.material.insert(name.into(), material);
        })
    }

    /// Young's modulus of all materials, Pa.
    pub fn modulus(self, modulus: f64) -> Sketch {
        self.materials(|material| material.youngs_modulus = modulus)
    }

    /// Friction of all materials.
    pub fn friction(self, friction: f64) -> Sketch {
        self.materials(|material| material.friction = friction)
    }

    /// Restitution of all materials.
    pub fn restitution(self, restitution: f64) -> Sketch {
        self.materials(|material| material.restitution = restitution)
    }

    /// Acceleration of gravity, m/s2.
    pub fn gravity(self, gravity: [f64; 3]) -> Sketch {
        self.with(|scene| scene.gravity = gravity)
    }

    /// Corners of the domain, m.
    pub fn domain(self, min: [f64; 3], max: [f64; 3]) -> Sketch {
        self.with(|scene| (scene.domain.min, scene.domain.max) = (min, max))
    }

    /// Time step, s.
    pub fn step(self, step: f64) -> Sketch {
        self.with(|scene| scene.solver.step = step)
    }

    /// Fixed number of sweeps per step.
    pub fn sweeps(self, sweeps: u32) -> Sketch {
        self.with(|scene| scene.solver.stop = Stop::Sweeps { sweeps })
    }

    /// Time between frames, s.
    pub fn interval(self, interval: f64) -> Sketch {
        self.with(|scene| scene.measure.interval = interval)
    }

    /// Adds a wall at rest.
    pub fn wall(self, shape: Shape) -> Sketch {
        self.moving_wall(shape, Motion::Fixed)
    }

    /// Returns the sketch with one more wall, which moves.
    pub fn moving_wall(self, shape: Shape, motion: Motion) -> Sketch {
        let name = format!("wall{}", self.0.wall.len());
        self.named_wall(&name, "wall", shape, motion)
    }

    /// Returns the sketch with one more plane, through a point (m).
    pub fn plane(self, point: [f64; 3], normal: [f64; 3]) -> Sketch {
        self.wall(Shape::Plane { point, normal })
    }

    /// Adds the plane z = 0.
    pub fn floor(self) -> Sketch {
        self.plane([0.0; 3], [0.0, 0.0, 1.0])
    }

    /// Adds a box with an open top.
    pub fn open_box(self, min: [f64; 3], max: [f64; 3]) -> Sketch {
        self.wall(Shape::Box { min, max, open: vec!["+z".into()] })
    }

    /// Adds a grain at rest.
    pub fn grain(self, radius: f64, position: [f64; 3]) -> Sketch {
        self.moving_grain(radius, position, [0.0; 3], [0.0; 3])
    }

    /// Returns the sketch with one more grain: radius and position (m), velocity (m/s), spin (rad/s).
    pub fn moving_grain(self, radius: f64, position: [f64; 3], velocity: [f64; 3], spin: [f64; 3]) -> Sketch {
        self.with(|scene| {
            scene.grain.push(GrainEntry { material: "grain".into(), radius, position, velocity, spin });
        })
    }

    /// Gives the last grain another material.
    pub fn made_of(self, material: &str) -> Sketch {
        self.with(|scene| {
            if let Some(grain) = scene.grain.last_mut() {
                grain.material = material.into();
            }
        })
    }

    /// Adds equal grains on the lowest sites of a region.
    pub fn population(self, count: usize, value: f64, region: Region) -> Sketch {
        self.grains(count, RadiusDistribution::Fixed { value }, region, 1.1, 0.0)
    }

    /// Adds grains with radii between (1 - spread) and (1 + spread) times the mean, slightly off the lowest sites of a region.
    pub fn polydisperse(self, count: usize, [mean, spread]: [f64; 2], region: Region, agitation: f64) -> Sketch {
        self.grains(count, RadiusDistribution::Uniform { mean, spread }, region, SPACING, agitation)
    }

    fn grains(self, count: usize, radius: RadiusDistribution, region: Region, spacing: f64, agitation: f64) -> Sketch {
        let material = "grain".into();
        self.with(|scene| {
            scene.population.push(Population {
                count,
                material,
                radius,
                region,
                placement: Placement::Lattice,
                spacing,
                agitation,
            })
        })
    }

    /// Adds a wall with a name, of a material.
    pub fn named_wall(self, name: &str, material: &str, shape: Shape, motion: Motion) -> Sketch {
        self.with(|scene| scene.wall.push(Wall::new(name, material, shape).moving(motion)))
    }

    /// Changes a material.
    pub fn change_material(self, name: &str, change: impl FnOnce(&mut Material)) -> Sketch {
        self.with(|scene| change(scene.material.get_mut(name).expect("a declared material")))
    }

    /// Returns the scene, checked like one from a file.
    ///
    /// # Panics
    /// The scene breaks a rule for scenes from files: the catalogue has an error then.
    pub fn scene(self) -> MeasuredScene {
        self.0.check().unwrap_or_else(|error| panic!("{}: {error}", self.0.name));
        self.0
    }
}

/// Returns a rotation about the y axis, rad/s, that stops or reverses at a time, s.
pub fn turning(rate: f64, stop: Option<f64>, reverse: Option<f64>) -> Motion {
    Motion::Rotating { point: [0.0; 3], axis: [0.0, 1.0, 0.0], rate, start: 0.0, stop, reverse }
}

/// Mass of a grain of the default density, kg.
pub fn mass(radius: f64) -> f64 {
    4.0 / 3.0 * std::f64::consts::PI * radius.powi(3) * DENSITY
}

/// Overlap at which Hertz's law gives a force, m: `F = 4/3 E* sqrt(R*) d^(3/2)` with `1/E*` the sum of `(1 - nu^2)/E` of
/// both (Johnson, Contact Mechanics, 1985, 4.2).
pub fn hertz_overlap(force: f64, moduli: [f64; 2], effective_radius: f64) -> f64 {
    let softness = (1.0 - POISSON_RATIO * POISSON_RATIO) * (1.0 / moduli[0] + 1.0 / moduli[1]);
    (0.75 * force * softness / effective_radius.sqrt()).powf(2.0 / 3.0)
}

/// Force of Hertz's law at an overlap, N: the inverse of [`hertz_overlap`].
pub fn hertz_force(overlap: f64, moduli: [f64; 2], effective_radius: f64) -> f64 {
    let softness = (1.0 - POISSON_RATIO * POISSON_RATIO) * (1.0 / moduli[0] + 1.0 / moduli[1]);
    4.0 / 3.0 / softness * effective_radius.sqrt() * overlap.powf(1.5)
}
