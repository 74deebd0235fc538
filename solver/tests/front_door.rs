//! Scenes and simulations made in code: the same rules as for files, and settings that cannot be had are errors.

use crate::common::bits;
use makadam::{
    Error, Execution, Face, InstructionSet, Material, Population, Precision, RadiusDistribution, Region, Scene,
    SceneBuilder, SceneError, Scheduler, SettingError, Shape, Simulation, SolverMethod, Stop, Wall,
};

const MIN: [f64; 3] = [0.0; 3];
const MAX: [f64; 3] = [0.08, 0.08, 0.2];

fn grains(material: &str) -> Population {
    Population::new(100, material, RadiusDistribution::uniform(0.005, 0.05), Region::cuboid(MIN, MAX))
}

fn sketch() -> SceneBuilder {
    let floor = Wall::new("box", "glass", Shape::cuboid(MIN, MAX, &[Face::Top]));
    Scene::builder().material("glass", Material::default()).wall(floor)
}

fn steps(mut simulation: Simulation, count: usize) -> Simulation {
    for _ in 0..count {
        simulation.step();
    }
    simulation
}

#[test]
fn a_scene_made_in_code_is_the_one_that_its_text_says() {
    let scene = sketch().population(grains("glass")).build().unwrap();
    assert_eq!((scene.domain.min, scene.domain.max), (MIN, MAX), "around the box and the region");
    let text = toml::to_string(&scene).unwrap();
    assert_eq!(Scene::parse(&text).unwrap(), scene);
    let ends = sketch().wall(Wall::new(
        "cap",
        "glass",
        Shape::Disc { centre: [0.5, 0.0, 0.1], normal: [0.0, 0.0, 3.0], radius: 0.1, hole: 0.0 },
    ));
    let scene = ends.build().unwrap();
    assert_eq!((scene.domain.min, scene.domain.max), ([0.0, -0.1, 0.0], [0.6, 0.1, 0.2]));
}

#[test]
fn what_is_wrong_with_a_scene_made_in_code_is_an_error_that_names_the_place() {
    let refused = |builder: SceneBuilder| match builder.build() {
        Err(error @ SceneError::Invalid(_)) => error.to_string(),
        other => panic!("{other:?}"),
    };
    let message = refused(sketch().population(grains("gold")));
    assert!(message.starts_with("population[0].material: there is no material 'gold'"), "{message}");
    let message = refused(sketch().wall(Wall::new("lid", "gold", Shape::plane(MAX, [0.0, 0.0, -1.0]))));
    assert!(message.starts_with("wall[1].material: there is no material 'gold'"), "{message}");
    let message = refused(sketch().material("glass", Material { restitution: 2.0, ..Material::default() }));
    assert!(message.starts_with("material.glass.restitution: 2 is out of range"), "{message}");
    let message = refused(Scene::builder().material("glass", Material::default()));
    assert!(message.starts_with("domain.min"), "nothing says where: {message}");
}

#[test]
fn a_builder_gives_the_bits_of_the_settings_one_by_one() {
    let scene = sketch().population(grains("glass")).build().unwrap();
    let mut halved = scene.clone();
    halved.solver.step *= 0.5;
    let expected = steps(Simulation::new(&halved, 3).unwrap(), 50);
    let builder = Simulation::builder(&scene).seed(3).threads(2).scheduler(Scheduler::CentralQueue);
    let simulation = builder.instruction_set(InstructionSet::Generic).time_step(halved.solver.step).build().unwrap();
    assert_eq!((simulation.team().threads(), simulation.instruction_set()), (2, InstructionSet::Generic));
    assert_eq!(steps(simulation, 50).state_hash(), expected.state_hash());
    let serial = Simulation::builder(&halved).seed(3).execution(Execution::serial()).build().unwrap();
    assert_eq!(steps(serial, 50).state_hash(), expected.state_hash());
}

#[test]
fn what_cannot_be_had_is_an_error() {
    let scene = sketch().population(grains("glass")).build().unwrap();
    let builder = Simulation::builder(&scene).method(SolverMethod::Anderson { memory: 3 }).precision(Precision::Single);
    assert!(matches!(builder.build(), Err(Error::Scene(_))));
    assert!(matches!(Simulation::builder(&scene).time_step(-1.0).build(), Err(Error::Scene(_))));
    for set in InstructionSet::ALL.into_iter().filter(|set| !set.is_available()) {
        let refused = Simulation::builder(&scene).instruction_set(set).build();
        assert!(matches!(refused, Err(Error::Setting(SettingError::NoInstructionSet { .. }))), "{}", set.name());
    }
}

#[test]
fn a_frame_has_the_grains_by_their_ids_and_a_report_tells_what_has_not_converged() {
    let scene = bits::reference_scene("packing");
    let stop = Stop::Residual { tolerance: 1e-12, max_sweeps: 2 };
    let mut simulation = Simulation::builder(&scene).stop(stop).build().unwrap();
    let first = simulation.step();
    assert!(first.solve.require_converged().is_ok(), "nothing touches yet");
    let touching = (0..2000).map(|_| simulation.step()).find(|report| report.contacts > 500).unwrap();
    let error = touching.solve.require_converged().unwrap_err();
    assert!(error.to_string().contains("2 sweeps"), "{error}");
    let (frame, snapshot) = (simulation.frame(), simulation.snapshot());
    assert_eq!((frame.time(), frame.grains()), (simulation.time(), 2000));
    assert_eq!(frame.contacts(), snapshot.contacts);
    for (id, grain) in snapshot.particles.iter().enumerate() {
        assert_eq!((frame.positions()[id], frame.velocities()[id]), (grain.position, grain.velocity));
        assert_eq!((frame.spins()[id], frame.radii()[id]), (grain.spin, grain.radius));
    }
}
