//! Small scenes for closed-form tests.

pub mod bits;
pub mod lattice;

use makadam::Simulation;
use makadam::scene::Scene;

/// Mass density of every test grain, kg/m3.
pub const DENSITY: f64 = 2500.0;

/// A test scene, put together from a few values.
pub struct Setup {
    pub gravity: [f64; 3],
    pub youngs_modulus: f64,
    pub friction: f64,
    pub wall_friction: f64,
    pub restitution: f64,
    pub solver: String,
    /// Further TOML: walls, grains, populations.
    pub body: String,
}

impl Default for Setup {
    fn default() -> Self {
        Setup {
            gravity: [0.0, 0.0, -9.81],
            youngs_modulus: 1e7,
            friction: 0.5,
            wall_friction: 0.5,
            restitution: 0.5,
            solver: CONVERGED_RIGID.into(),
            body: String::new(),
        }
    }
}

/// Rigid contacts, solved to rounding.
pub const CONVERGED_RIGID: &str = "step = 1e-4\nnormal_law = { kind = 'rigid' }\nover_relaxation = 1.0\n\
                                   stop = { kind = 'residual', tolerance = 1e-13, max_sweeps = 20000 }";

/// Hertzian contacts, solved to rounding.
pub const CONVERGED_HERTZ: &str = "step = 1e-4\nnormal_law = { kind = 'hertz' }\nover_relaxation = 1.0\n\
                                   stop = { kind = 'residual', tolerance = 1e-13, max_sweeps = 20000 }";

/// A plane through the origin with the normal along z.
pub const FLOOR: &str =
    "[[wall]]\nname = 'floor'\nmaterial = 'wall'\nshape = { kind = 'plane', point = [0, 0, 0], normal = [0, 0, 1] }\n";

impl Setup {
    /// Parses the scene and places its grains.
    pub fn start(&self) -> Simulation {
        self.start_from(1)
    }

    /// Returns the same from a seed.
    pub fn start_from(&self, seed: u64) -> Simulation {
        Simulation::new(&self.scene(), seed).unwrap_or_else(|error| panic!("{error}"))
    }

    /// The scene.
    pub fn scene(&self) -> Scene {
        self.scene_with("")
    }

    /// The scene, with further lines of TOML for both of its materials.
    pub fn scene_with(&self, lines: &str) -> Scene {
        let text = self.text(lines);
        Scene::parse(&text).unwrap_or_else(|error| panic!("{error}\n{text}"))
    }

    /// Text of the scene, with further lines of TOML for both of its materials.
    pub fn text(&self, lines: &str) -> String {
        let [x, y, z] = self.gravity;
        let material = |name: &str, friction: f64| {
            format!(
                "[material.{name}]\ndensity = {DENSITY}\nyoungs_modulus = {:e}\npoisson_ratio = 0.3\nfriction = {friction}\n\
                 restitution = {}\n{lines}",
                self.youngs_modulus, self.restitution
            )
        };
        format!(
            "name = 'test'\ndescription = 'test'\nduration = 1.0\ngravity = [{x:?}, {y:?}, {z:?}]\n\
             domain = {{ min = [-10, -10, -1], max = [10, 10, 10] }}\n{}{}[solver]\n{}\n{}",
            material("grain", self.friction),
            material("wall", self.wall_friction),
            self.solver,
            self.body
        )
    }
}

/// TOML of one grain.
pub fn grain(radius: f64, position: [f64; 3], velocity: [f64; 3]) -> String {
    format!("[[grain]]\nmaterial = 'grain'\nradius = {radius:?}\nposition = {position:?}\nvelocity = {velocity:?}\n")
}

/// Steps until the given simulated time, s.
pub fn run_until(simulation: &mut Simulation, time: f64) {
    while simulation.time() < time - 0.5 * simulation.time_step() {
        simulation.step();
    }
}

/// Reads a scene's text as if it stood in `test.toml`, which errors name.
pub fn parse(text: &str) -> Result<Scene, String> {
    Scene::parse(text).map_err(|error| error.in_file(std::path::Path::new("test.toml"), Some(text)).to_string())
}
