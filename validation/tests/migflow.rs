//! MigFlow: its input without the program, and closed forms of one contact where it is installed.

use makadam::snapshot::{Partner, Snapshot};
use makadam_compare::codes::{Code, CodeError, Job, Migflow, Purpose};
use makadam_frames::plan::MeasuredScene;
use makadam_frames::recording::Recording;
use nalgebra::Vector3;
use serde_json::Value;
use std::path::Path;
use std::time::Duration;

const RADIUS: f64 = 0.005;
const GRAVITY: f64 = 9.81;
const STEP: f64 = 5e-4;

fn scene(solver: &str, body: &str) -> MeasuredScene {
    let mut text = format!(
        "name = 'rigid'\ndescription = 'x'\nduration = 0.2\ngravity = [0, 0, -{GRAVITY}]\n\
         domain = {{ min = [-0.3, -0.3, -0.3], max = [0.3, 0.3, 0.3] }}\n\
         [solver]\nstep = {STEP}\n{solver}[measure]\ninterval = 0.01\nfrom = 0.0\n"
    );
    for (name, friction) in [("grain", 0.5), ("slick", 0.05)] {
        text += &format!(
            "[material.{name}]\ndensity = 2500\nyoungs_modulus = 1e7\npoisson_ratio = 0.3\nfriction = {friction}\n\
             restitution = 0.0\n"
        );
    }
    MeasuredScene::parse(&(text + body)).unwrap_or_else(|error| panic!("{error}"))
}

const RIGID: &str = "normal_law = { kind = 'rigid' }\n";

fn wall(name: &str, material: &str, shape: &str, motion: &str) -> String {
    format!("[[wall]]\nname = '{name}'\nmaterial = '{material}'\nshape = {{ {shape} }}\nmotion = {{ {motion} }}\n")
}

fn disc(x: f64) -> String {
    format!("kind = 'disc', centre = [{x}, 0, 0], normal = [0, 0, 1], radius = 0.04")
}

const FIXED: &str = "kind = 'fixed'";

fn grain(position: [f64; 3], velocity: [f64; 3]) -> String {
    format!("[[grain]]\nmaterial = 'grain'\nradius = {RADIUS}\nposition = {position:?}\nvelocity = {velocity:?}\n")
}

fn run(code: &Migflow, scene: &MeasuredScene, folder: &Path) -> Result<Recording, CodeError> {
    code.simulate(&Job {
        scene,
        scene_file: Path::new("rigid.toml"),
        purpose: Purpose::Measuring,
        seed: 1,
        stiffness_factor: 1.0,
        rayleigh_fraction: 0.2,
        work_folder: folder,
        time_limit: Duration::from_secs(300),
        progress: &|_| {},
    })
}

/// Returns the job of a scene, or the reason for a refusal; a program that fails stands in for MigFlow.
fn input(scene: &MeasuredScene) -> Result<Value, String> {
    let folder = tempfile::tempdir().unwrap();
    match run(&Migflow::new("false"), scene, folder.path()).unwrap_err() {
        CodeError::Crashed { .. } => {
            let text = std::fs::read_to_string(folder.path().join("job.json")).unwrap();
            Ok(serde_json::from_str(&text).unwrap())
        }
        error => Err(error.to_string()),
    }
}

#[test]
fn walls_have_edges_where_grains_could_meet_them() {
    let turning = "kind = 'rotating', point = [0.01, 0, 0], axis = [0, 2, 0], rate = 3.0, stop = 0.1";
    let body = wall("box", "slick", "kind = 'box', min = [-0.1, -0.1, -0.1], max = [0.1, 0.1, 0.1]", FIXED)
        + &wall("disc", "grain", &disc(0.05), turning)
        + &grain([0.0; 3], [0.0; 3]);
    let job = input(&scene(RIGID, &body)).unwrap();
    let number = |value: &Value| value.as_f64().unwrap();
    assert_eq!([&job["time_step"], &job["steps"], &job["tolerance"]].map(number), [STEP, 400.0, 1e-4 * RADIUS]);
    let friction = job["pairs"].as_array().unwrap().iter().map(|pair| pair[2].as_f64().unwrap()).collect::<Vec<_>>();
    let expected = scene(RIGID, &body).contact_coefficients("grain", "slick", true).friction;
    assert!(friction.contains(&0.5) && friction.contains(&expected) && friction.len() == 3, "{friction:?}");
    // A closed box has no rim, a disc of 32 corners has one.
    let counts = |wall: usize| ["edges", "corners"].map(|key| job["walls"][wall][key].as_array().unwrap().len());
    assert_eq!((counts(0), counts(1)), ([0, 0], [32, 32]));
    let turning = &job["walls"][1];
    assert_eq!(turning["point"], serde_json::json!([0.01, 0.0, 0.0]));
    assert_eq!(["rate", "last"].map(|key| number(&turning["motions"][0][key])), [3.0, 200.0]);
}

#[test]
fn effects_that_it_lacks_are_refused_with_their_keys() {
    let body = wall("floor", "grain", &disc(0.0), FIXED) + &grain([0.0, 0.0, 0.1], [0.0; 3]);
    let refused = input(&scene("", &body)).unwrap_err();
    assert!(refused.contains("it has no elastic compliance") && refused.contains("(solver.normal_law)"), "{refused}");
    let mut bouncing = scene(RIGID, &body);
    bouncing.material.values_mut().for_each(|one| one.restitution = 0.3);
    let refused = input(&bouncing).unwrap_err();
    assert!(refused.contains("it has no restitution") && refused.contains("(material.grain.restitution)"), "{refused}");
}

fn velocity(frame: &Snapshot, id: usize) -> Vector3<f64> {
    frame.particles[id].velocity.into()
}

#[track_caller]
fn close(what: &str, value: f64, expected: f64, tolerance: f64) {
    assert!((value - expected).abs() <= tolerance, "{what} is {value}, not {expected} within {tolerance}");
}

#[test]
fn closed_forms_of_one_contact() {
    let code = Migflow::default();
    if code.version().is_none() {
        eprintln!("skipped: MigFlow is not installed (scripts/install-codes migflow)");
        return;
    }
    let shell = "kind = 'cylinder', base = [0, 0.1, 0.2], axis = [0, 1, 0], radius = 0.05, length = 0.1";
    let turning = "kind = 'rotating', point = [0, 0, 0.2], axis = [0, 2, 0], rate = 5.0";
    let mut body = wall("rough", "grain", &disc(-0.2), FIXED)
        + &wall("slick", "slick", &disc(-0.1), FIXED)
        + &wall("rim", "grain", &disc(0.0), FIXED)
        + &wall("drum", "grain", shell, turning)
        + &wall("lift", "grain", &disc(0.1), "kind = 'translating', velocity = [0, 0, 0.1], stop = 0.05")
        + &wall("table", "grain", &disc(0.2), FIXED)
        + &grain([-0.22, 0.001, RADIUS + 0.0015], [1.0, 0.0, -1.0])
        + &grain([-0.12, 0.001, RADIUS], [0.3, 0.0, 0.0])
        + &grain([0.0415, 0.0, 1.2 * RADIUS], [0.0; 3])
        + &grain([0.0, 0.157, 0.15 + RADIUS], [0.0; 3])
        + &grain([0.107, 0.003, RADIUS], [0.0; 3]);
    for layer in 0..5 {
        body += &grain([0.207, 0.003, RADIUS * f64::from(2 * layer + 1)], [0.0; 3]);
    }
    let folder = tempfile::tempdir().unwrap();
    let recording = run(&code, &scene(RIGID, &body), folder.path()).unwrap_or_else(|error| panic!("{error}"));
    let [early, last] = [1, 20].map(|frame| &recording.frames[frame]);
    close("time of the second frame", early.time, 0.01, 1e-9);
    // Restitution 0 and friction above 2/7 tan(45 degrees): the grain rolls with 5/7 of its speed.
    close("speed after the impact", velocity(early, 0).x, 5.0 / 7.0, 1e-4);
    close("rebound", velocity(early, 0).z, 0.0, 1e-4);
    close("spin after the impact", early.particles[0].spin[1] * RADIUS, 5.0 / 7.0, 1e-4);
    // Sliding: friction slows by mu g and turns by 2.5 mu g / R.
    let friction = scene(RIGID, &body).contact_coefficients("grain", "slick", true).friction;
    close("speed of the sliding grain", velocity(early, 1).x, 0.3 - friction * GRAVITY * 0.01, 1e-4);
    close("spin of the sliding grain", early.particles[1].spin[1] * RADIUS, 2.5 * friction * GRAVITY * 0.01, 1e-4);
    // Beside the rim a grain meets the edge of the disc, and rolls off it without sinking into it.
    for frame in &recording.frames {
        let [x, _, z] = frame.particles[2].position;
        // The sides of the disc lie at 0.04 m or beyond.
        assert!((x - 0.04).hypot(z) > 0.9 * RADIUS || z > 0.99 * RADIUS, "{x} {z} at {} s", frame.time);
    }
    // The drum drags its grain to -x by mu g while it slips.
    close("speed in the drum", velocity(early, 3).x, -0.5 * GRAVITY * 0.01, 0.04 * 0.5 * GRAVITY * 0.01);
    close("height on the lift", last.particles[4].position[2], RADIUS + 0.005, 1e-3 * RADIUS);
    // Five grains on each other carry their weights and sink by less than a hundredth of a radius.
    let weight = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * RADIUS.powi(3) * GRAVITY;
    close("height of the column", last.particles[9].position[2], 9.0 * RADIUS, 0.01 * RADIUS);
    let force_between = |first: u32, second: Partner| {
        let mut found = last.contacts.iter().filter(|one| one.first == first && one.second == second);
        let contact = found.next().unwrap_or_else(|| panic!("{first} does not touch {second:?}"));
        assert!(found.next().is_none(), "one contact, not two");
        contact.normal_force / weight
    };
    close("force on the table", force_between(5, Partner::Wall(5)), 5.0, 0.01);
    let on_top = last.contacts.iter().find(|one| one.second == Partner::Grain(9) || one.first == 9).unwrap();
    close("force on the highest grain", on_top.normal_force / weight, 1.0, 0.01);
}
