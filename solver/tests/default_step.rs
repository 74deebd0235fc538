//! Step of a scene without `solver.step`: closed form, and similar scenes move alike.

use makadam::scene::{GrainEntry, Material, Population, RadiusDistribution, Region, Stop};
use makadam::{Scene, Simulation, SolverSettings};

/// A bed of 60 grains that fall into a box, with all lengths times a factor, moduli by the factor, times and speeds by its root.
fn bed(factor: f64, solver: &str) -> String {
    let root = factor.sqrt();
    let [side, top, radius] = [0.02, 0.1, 0.005].map(|length| length * factor);
    let material = format!(
        "density = 2500.0\nyoungs_modulus = {:?}\npoisson_ratio = 0.3\nfriction = 0.5\nrestitution = 0.3\n",
        1e7 * factor
    );
    format!(
        "name = 'bed'\nduration = {:?}\ndomain = {{ min = [{:?}, {:?}, {:?}], max = [{:?}, {:?}, {:?}] }}\n\
         [material.a]\n{material}{solver}[[wall]]\nname = 'box'\nmaterial = 'a'\n\
         shape = {{ kind = 'box', min = [-{side:?}, -{side:?}, 0.0], max = [{side:?}, {side:?}, {top:?}], open = ['+z'] }}\n\
         [[population]]\ncount = 60\nmaterial = 'a'\nradius = {{ kind = 'uniform', mean = {radius:?}, spread = 0.05 }}\n\
         region = {{ kind = 'box', min = [-{side:?}, -{side:?}, 0.0], max = [{side:?}, {side:?}, {top:?}] }}\nagitation = {:?}\n",
        0.2 * root,
        -1.1 * side,
        -1.1 * side,
        -0.5 * side,
        1.1 * side,
        1.1 * side,
        2.0 * top,
        0.2 * root,
    )
}

fn step_of(text: &str) -> f64 {
    Scene::parse(text).unwrap_or_else(|error| panic!("{error}\n{text}")).solver.step
}

#[test]
fn the_step_follows_gravity_the_smallest_radius_and_the_largest_speed() {
    assert_eq!(step_of(&bed(1.0, "")), 5e-4);
    // sqrt(5e-4 r/g), rounded down to two digits.
    assert_eq!(step_of(&bed(0.1, "")), 1.5e-4);
    assert_eq!(step_of(&bed(10.0, "")), 1.5e-3);
    let with = |more: &str| step_of(&(bed(1.0, "") + more));
    let grain = |radius: f64, speed: f64| {
        format!(
            "[[grain]]\nmaterial = 'a'\nradius = {radius:?}\nposition = [0.0, 0.0, 0.15]\nvelocity = [0.0, {speed:?}, 0.0]\n"
        )
    };
    assert_eq!(with(&grain(0.0005, 0.0)), 1.5e-4);
    assert_eq!(with(&grain(0.01, 0.0)), 5e-4);
    // 0.1 r/v.
    assert_eq!(with(&grain(0.005, -2.5)), 2e-4);
    let source = "[[insert]]\nmaterial = 'a'\nradius = { kind = 'fixed', value = 0.002 }\nrate = 10.0\nvelocity = [0.0, 0.0, -1.0]\n\
                  region = { kind = 'box', min = [-0.01, -0.01, 0.12], max = [0.01, 0.01, 0.15] }\n";
    assert_eq!(with(source), 2e-4);
    let under = |gravity: &str| step_of(&bed(1.0, "").replacen("\n[material", &format!("\n{gravity}\n[material"), 1));
    assert_eq!(under("gravity = [0.0, 0.0, -981.0]"), 5e-5);
    assert_eq!(under("gravity = [0.0, 0.0, 0.0]"), 5e-4);
    assert_eq!(under("gravity_changes = [{ time = 0.1, gravity = [0.0, 0.0, -981.0] }]"), 5e-5);
    assert_eq!(under("gravity = [0.0, 0.0, -1e-9]"), 2.5e-3, "agitation of 0.2 m/s");
    let staged = bed(1.0, "").replacen("duration = 0.2\n", "", 1);
    let stages =
        "[[stage]]\nname = 'a'\nduration = 0.1\n[[stage]]\nname = 'b'\nduration = 0.1\ngravity = [0.0, 0.0, -981.0]\n";
    let staged = Scene::parse(&(staged + stages)).unwrap();
    assert_eq!((staged.solver.step, staged.duration), (5e-5, 0.2));
}

#[test]
fn a_step_that_is_given_stays_and_the_written_scene_has_the_step() {
    assert_eq!(step_of(&bed(0.1, "[solver]\nstep = 5e-4\n")), 5e-4);
    let scene = Scene::parse(&bed(0.1, "[solver]\nskin = 0.5\n")).unwrap();
    assert_eq!((scene.solver.step, scene.solver.skin), (1.5e-4, 0.5));
    let written = toml::to_string(&scene).unwrap();
    assert!(written.contains("step = 0.00015"), "{written}");
    assert_eq!(Scene::parse(&written).unwrap(), scene);
    let error = Scene::parse(&bed(1.0, "[solver]\nstep = 0.0\n")).unwrap_err().to_string();
    assert!(error.contains("solver.step: 0 is out of range"), "{error}");
}

#[test]
fn scenes_made_in_code_have_the_same_step() {
    let region = Region::cuboid([0.0; 3], [0.01, 0.01, 0.02]);
    let grains = Population::new(20, "a", RadiusDistribution::uniform(0.0005, 0.05), region);
    let builder = || Scene::builder().material("a", Material::default()).population(grains.clone());
    let built = builder().build().unwrap();
    assert_eq!(built.solver.step, 1.5e-4);
    let settings = SolverSettings { stop: Stop::Sweeps { sweeps: 20 }, ..SolverSettings::default() };
    assert_eq!(builder().solver(settings.clone()).build().unwrap().solver, SolverSettings { step: 1.5e-4, ..settings });
    // Without grains, and with a grain that came after the scene was built.
    let mut empty = Scene::builder().material("a", Material::default()).domain([0.0; 3], [1.0; 3]).build().unwrap();
    assert_eq!(empty.solver.step, 5e-4);
    empty.grain.push(GrainEntry {
        material: "a".into(),
        radius: 1e-3,
        position: [0.5; 3],
        velocity: [0.0; 3],
        spin: [0.0; 3],
    });
    assert_eq!((empty.solver.step, empty.default_step()), (5e-4, 2.2e-4));
}

/// No length, time or speed of the solver's own enters a motion, so that an accuracy holds for grains of any size.
#[test]
fn similar_scenes_move_alike_to_the_bit() {
    let run = |factor: f64| {
        let mut simulation = Simulation::new(&Scene::parse(&bed(factor, "")).unwrap(), 1).unwrap();
        for _ in 0..400 {
            simulation.step();
        }
        simulation.snapshot()
    };
    let one = run(1.0);
    assert!(one.contacts.len() > 100, "{}", one.contacts.len());
    for factor in [4.0, 0.25] {
        let other = run(factor);
        let times = |of: [f64; 3], factor: f64| of.map(|component| component * factor);
        for (a, b) in one.particles.iter().zip(&other.particles) {
            assert_eq!(times(a.position, factor), b.position, "{factor}");
            assert_eq!(times(a.velocity, factor.sqrt()), b.velocity, "{factor}");
        }
        assert_eq!(one.contacts.len(), other.contacts.len());
    }
}
