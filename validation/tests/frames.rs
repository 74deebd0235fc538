//! Frames on disk: what they say of forces and stresses is physics, and they are read back as they were written.

use makadam::Simulation;
use makadam::scene::GravityChange;
use makadam_frames::output::RunFiles;
use makadam_frames::plan::MeasuredScene;
use makadam_frames::run_frames::{RunFrame, RunFrames, StoreWriter};
use std::f64::consts::PI;
use std::path::Path;

const GRAVITY: f64 = 9.81;

/// A box without friction, with grains of two materials.
fn bed(walls: &str, grains: &str, duration: f64) -> MeasuredScene {
    let text = format!(
        r#"
        name = "bed"
        description = "grains that come to rest"
        duration = {duration}
        domain = {{ min = [-0.03, -0.03, -0.01], max = [0.03, 0.03, 0.3] }}
        [material.heavy]
        density = 5000.0
        youngs_modulus = 1e7
        poisson_ratio = 0.3
        friction = 0.5
        restitution = 0.1
        [material.light]
        density = 1000.0
        youngs_modulus = 1e7
        poisson_ratio = 0.3
        friction = 0.5
        restitution = 0.1
        [material.wall]
        density = 2500.0
        youngs_modulus = 1e7
        poisson_ratio = 0.3
        friction = 0.0
        restitution = 0.1
        [solver]
        step = 2e-4
        stop = {{ kind = "residual", tolerance = 1e-8, max_sweeps = 2000 }}
        {walls}
        {grains}
        "#
    );
    MeasuredScene::parse(&text).unwrap_or_else(|error| panic!("{error}"))
}

/// Simulates a scene to its end, with a frame at the start and one there.
fn simulate(scene: &MeasuredScene, folder: &Path) {
    let mut simulation = Simulation::builder(scene).time_step(scene.solver.step).build().unwrap();
    let mut frames = StoreWriter::create(&folder.join(RunFiles::FRAMES), scene).unwrap();
    frames.append(&simulation.snapshot()).unwrap();
    for _ in 0..(scene.duration / scene.solver.step) as usize {
        simulation.step();
    }
    frames.append(&simulation.snapshot()).unwrap();
}

fn last_frame(scene: &MeasuredScene) -> RunFrame {
    let folder = tempfile::tempdir().unwrap();
    simulate(scene, folder.path());
    let run = RunFrames::open(folder.path()).unwrap();
    assert_eq!(run.count(), 2);
    run.read(1).unwrap()
}

const BOX: &str = r#"
    [[wall]]
    name = "box"
    material = "wall"
    shape = { kind = "box", min = [-0.02, -0.02, 0.0], max = [0.02, 0.02, 0.2], open = ["+z"] }
"#;

#[test]
fn a_grain_at_rest_bears_its_weight() {
    let scene = bed(BOX, "[[grain]]\nmaterial = \"light\"\nradius = 0.005\nposition = [0.0, 0.0, 0.005]", 0.5);
    let frame = last_frame(&scene);
    let mass = 1000.0 * 4.0 / 3.0 * PI * 0.005_f64.powi(3);
    let value = |name: &str| frame.quantity(name).unwrap().values[0];
    assert!((value("mass") / mass - 1.0).abs() < 1e-6);
    assert!((value("force") / (mass * GRAVITY) - 1.0).abs() < 1e-4, "{}", value("force"));
    assert_eq!((value("coordination_number"), value("population"), value("material")), (1.0, -1.0, 1.0));
    // One force m g at the lowest point: sigma_zz = m g r / V = rho g r, and nothing else.
    let pressure = 1000.0 * GRAVITY * 0.005 / 3.0;
    assert!((value("pressure") / pressure - 1.0).abs() < 1e-4, "{} {pressure}", value("pressure"));
    assert!(value("speed") < 1e-6);
}

#[test]
fn stresses_of_a_bed_at_rest_balance_its_weight() {
    let grains = r#"
        [[population]]
        count = 60
        material = "heavy"
        radius = { kind = "uniform", mean = 0.003, spread = 0.2 }
        region = { kind = "box", min = [-0.02, -0.02, 0.0], max = [0.02, 0.02, 0.05] }
        [[population]]
        count = 80
        material = "light"
        radius = { kind = "fixed", value = 0.004 }
        region = { kind = "box", min = [-0.02, -0.02, 0.05], max = [0.02, 0.02, 0.2] }
    "#;
    let frame = last_frame(&bed(BOX, grains, 2.0));
    let values = |name: &str| frame.quantity(name).unwrap().values;
    let (masses, pressures, forces) = (values("mass"), values("pressure"), values("force"));
    let (materials, populations) = (values("material"), values("population"));
    for (grain, radius) in frame.grains.radii.iter().enumerate() {
        let (density, population) = if grain < 60 { (5000.0, 0.0) } else { (1000.0, 1.0) };
        assert!((masses[grain] / (density * 4.0 / 3.0 * PI * radius.powi(3)) - 1.0).abs() < 1e-5);
        assert_eq!((materials[grain], populations[grain]), (population, population));
        assert!((forces[grain] / (masses[grain] * GRAVITY) - 1.0).abs() < 0.02, "grain {grain} is not at rest");
    }
    // At rest the contact forces on each grain are its weight, up. The walls have no friction, so that sides give no moment in z and the
    // floor stands at z = 0: sum of V sigma_zz = sum of m g z, by the virial. Sides: V (sigma_xx + sigma_yy) is theirs alone.
    let contacts = frame.contacts.as_ref().unwrap();
    let sides: f64 = contacts
        .iter()
        .filter(|contact| frame.grains.positions.iter().all(|centre| distance(centre, &contact.ends[1]) > 1e-9))
        .map(|contact| {
            let [from, to] = contact.ends;
            let along = [0, 1].map(|axis| (to[axis] - from[axis]) / distance(&from, &to));
            contact.normal_force * (along[0].abs() + along[1].abs()) * 0.02
        })
        .sum();
    let weight: f64 = masses.iter().zip(&frame.grains.positions).map(|(mass, centre)| mass * GRAVITY * centre[2]).sum();
    let volume = |radius: &f64| 4.0 / 3.0 * PI * radius.powi(3);
    let virial: f64 =
        pressures.iter().zip(&frame.grains.radii).map(|(pressure, radius)| 3.0 * pressure * volume(radius)).sum();
    assert!(sides > 0.0 && weight > 0.0);
    assert!((virial / (weight + sides) - 1.0).abs() < 0.01, "{virial} {weight} {sides}");
}

fn distance(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>().sqrt()
}

#[test]
fn forces_and_lines_of_contacts_reach_through_a_periodic_side() {
    let walls = "[[wall]]\nname = \"floor\"\nmaterial = \"wall\"\n\
                 shape = { kind = \"plane\", point = [0.0, 0.0, 0.0], normal = [0.0, 0.0, 1.0] }";
    // Two columns of one row: the outer grain leans through the side on the first one.
    let grain =
        |x: f64, z: f64| format!("[[grain]]\nmaterial = \"heavy\"\nradius = 0.005\nposition = [{x}, 0.0, {z}]\n");
    let mut grains: String = (0..6).map(|n| grain(0.01 * f64::from(n) - 0.025, 0.005)).collect();
    grains += &grain(-0.03, 0.005 + 0.00866);
    let mut scene = bed(walls, &grains, 0.3);
    scene.domain.periodic = vec![makadam::scene::Axis::X];
    let frame = last_frame(&scene);
    let contacts = frame.contacts.as_ref().unwrap();
    assert!(contacts.len() > 8);
    assert!(contacts.iter().all(|contact| distance(&contact.ends[0], &contact.ends[1]) < 0.0101), "{contacts:?}");
    let (masses, forces) = (frame.quantity("mass").unwrap().values, frame.quantity("force").unwrap().values);
    assert!((forces[6] / (masses[6] * GRAVITY) - 1.0).abs() < 0.01, "the grain on the side is borne by both");
    let pressures = frame.quantity("pressure").unwrap().values;
    // A branch vector through the whole domain would make it six times as large.
    let largest = 5000.0 * GRAVITY * 0.005 * 3.0;
    assert!(pressures.iter().all(|pressure| pressure.abs() < largest), "{pressures:?} {largest}");
}

#[test]
fn folders_without_frames_are_refused_with_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |run: &Path| RunFrames::open(run).unwrap_err().to_string();
    let message = refused(&folder.path().join("nowhere"));
    assert!(message.contains("no run") && message.contains("nowhere") && message.contains("makadam run"), "{message}");
    assert!(refused(folder.path()).contains("no frames.mkd"));
    let scene = bed(BOX, "[[grain]]\nmaterial = \"light\"\nradius = 0.005\nposition = [0.0, 0.0, 0.005]", 0.01);
    drop(StoreWriter::create(&folder.path().join(RunFiles::FRAMES), &scene).unwrap());
    assert!(refused(folder.path()).contains("no whole frame yet"));
    simulate(&scene, folder.path());
    let run = RunFrames::open(folder.path()).unwrap();
    assert_eq!((run.at(0.0).unwrap(), run.at(0.007).unwrap(), run.at(0.01).unwrap()), (0, 1, 1));
    let message = run.at(3.0).unwrap_err().to_string();
    assert!(message.contains("3 s lies outside") && message.contains("2 frames are from 0 s to 0.01 s"), "{message}");
    let frame = run.read(1).unwrap();
    assert!(run.field(&frame, "sped").unwrap_err().to_string().starts_with("no field 'sped' in the frames of "));
    assert_eq!(run.field(&frame, "angular-velocity").unwrap().unit, "rad/s");
    // The end of a file that a kill has cut is no frame; damage inside is an error.
    let file = folder.path().join(RunFiles::FRAMES);
    let whole = std::fs::read(&file).unwrap();
    std::fs::write(&file, &whole[..whole.len() - 1]).unwrap();
    assert_eq!(RunFrames::open(folder.path()).unwrap().count(), 1);
    let mut damaged = whole.clone();
    *damaged.last_mut().unwrap() ^= 1;
    std::fs::write(&file, &damaged).unwrap();
    let message = RunFrames::open(folder.path()).unwrap().read(1).unwrap_err().to_string();
    assert!(message.contains("frames.mkd") && message.contains("damaged"), "{message}");
    std::fs::write(&file, "no frames").unwrap();
    assert!(refused(folder.path()).contains("frames.mkd"));
}

#[test]
fn a_frame_states_gravity_and_grains_of_its_time() {
    let populations = "[[population]]\ncount = 3\nmaterial = \"light\"\nradius = { kind = \"fixed\", value = 0.003 }\n\
        region = { kind = \"box\", min = [-0.02, -0.02, 0.0], max = [0.02, 0.02, 0.1] }\n\
        [[population]]\ncount = 3\nmaterial = \"heavy\"\nradius = { kind = \"fixed\", value = 0.003 }\n\
        region = { kind = \"box\", min = [-0.02, -0.02, 0.1], max = [0.02, 0.02, 0.2] }\n";
    let mut scene = bed(BOX, populations, 0.1);
    scene.gravity_changes = vec![GravityChange { time: 0.05, gravity: [0.0, 0.0, -2.0] }];
    let mut simulation = Simulation::builder(&scene).time_step(scene.solver.step).build().unwrap();
    for _ in 0..500 {
        simulation.step();
    }
    simulation.remove(&[0, 4]).unwrap();
    let listed = simulation.grain_entries(&scene)[0].clone();
    let above = makadam::GrainEntry { position: [0.0, 0.0, 0.19], ..listed };
    simulation.insert(&scene, &[above]).unwrap();
    simulation.step();
    let folder = tempfile::tempdir().unwrap();
    StoreWriter::create(&folder.path().join(RunFiles::FRAMES), &scene).unwrap().append(&simulation.snapshot()).unwrap();
    let frame = RunFrames::open(folder.path()).unwrap().read(0).unwrap();
    assert!((frame.gravity[2] + 2.0).abs() < 1e-12, "{:?}", frame.gravity);
    let values = |name: &str| frame.quantity(name).unwrap().values;
    // Of the populations the second and third grain, and the first and last; materials are numbered by their names.
    assert_eq!(values("population"), [0.0, 0.0, 1.0, 1.0, -1.0]);
    assert_eq!(values("material"), [1.0, 1.0, 0.0, 0.0, 1.0]);
    let mass = |density: f64| density * 4.0 / 3.0 * PI * 0.003_f64.powi(3);
    for (mass, expected) in values("mass").iter().zip([1000.0, 1000.0, 5000.0, 5000.0, 1000.0].map(mass)) {
        assert!((mass / expected - 1.0).abs() < 1e-6, "{mass} {expected}");
    }
}
