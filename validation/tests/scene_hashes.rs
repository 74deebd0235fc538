//! One document, two readers: what a scene says of measuring is checked, and hashes of scenes are those of recorded results.

use makadam_compare::scenes;
use makadam_frames::plan::MeasuredScene;
use makadam_frames::plan::physics_hash;

/// Reference scenes with the hash of what other codes are given of them, by which recorded results are known.
const HASHES: [(&str, &str); 20] = [
    ("cohesive-heap", "cd83bba4ba6d56bb"),
    ("drum", "6b1ce0781e5c37d5"),
    ("drum-caps", "f370629e4d422826"),
    ("drum-inelastic", "71e1a1e51d7f5faf"),
    ("drum-rolling", "097b1b6c0377fe23"),
    ("frictionless-packing", "1da13efe8358f726"),
    ("heap", "4ac7ca2cead7bcd6"),
    ("heap-rolling", "fcf081bd58b7642d"),
    ("oedometer", "6ea3a3f15c6b76c9"),
    ("packing", "d4a0ed254a056927"),
    ("packing-100", "fc5b3a7b01223ca8"),
    ("packing-20k", "d080f6e7091d0491"),
    ("packing-deep", "d6fb5b9ada57c35d"),
    ("packing-high-friction", "7dae9461a7456f11"),
    ("packing-high-friction-stiff", "ec4bc32c19063151"),
    ("packing-inelastic", "02571126395fcfcd"),
    ("packing-low-friction", "8653e7e5915dbbe7"),
    ("packing-low-friction-stiff", "9d4349d46f79a689"),
    ("packing-stiff", "55316167efd8bee9"),
    ("vibrated-bed", "8856ff0207b596e6"),
];

#[test]
fn hashes_of_reference_scenes_are_those_of_recorded_results() {
    for (name, hash) in HASHES {
        let scene = scenes::load(&scenes::find(name, &[]).unwrap()).unwrap();
        assert_eq!(physics_hash(&scene), hash, "{name}");
    }
}

fn refusal(from: &str, to: &str) -> String {
    let text = scenes::text(&scenes::find("packing", &[]).unwrap()).unwrap();
    assert!(text.contains(from), "the scene no longer holds {from:?}");
    MeasuredScene::parse(&text.replacen(from, to, 1)).expect_err("accepted").to_string()
}

#[test]
fn what_a_scene_says_of_measuring_is_checked() {
    let message = refusal("interval = 0.05", "interval = 1e-6");
    assert!(message.contains("measure.interval") && message.contains("too many frames"), "{message}");
    let message = refusal("interval = 0.05", "intervall = 0.05");
    assert!(message.contains("unknown field `intervall`"), "{message}");
    let message = refusal("[measure]", "[prepare]\nduration = 1.0\nstep = 1.0\n[measure]");
    assert!(message.contains("prepare.step: 1 is out of range"), "{message}");
}

#[test]
fn a_scene_is_written_as_it_was_read() {
    for name in scenes::names() {
        let scene = scenes::load(&scenes::find(name, &[]).unwrap()).unwrap();
        let mut read = scene.clone();
        // An accuracy chooses the step, and a written scene holds both.
        read.accuracy = None;
        let again = MeasuredScene::parse(&toml::to_string(&read).unwrap()).unwrap();
        assert_eq!(again, read, "{name}");
    }
}

#[test]
fn reference_scenes_have_no_findings() {
    assert!(scenes::names().count() >= 18);
    for name in scenes::names() {
        let scene = scenes::load(&scenes::find(name, &[]).unwrap()).unwrap();
        let findings = scene.findings(None);
        assert!(findings.is_empty(), "{name}: {findings:?}");
    }
}

#[test]
fn a_wall_that_would_jump_after_the_preparation_is_refused() {
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenes/smoke.toml");
    let text = std::fs::read_to_string(file).unwrap();
    let box_shape = text.lines().find(|line| line.starts_with("shape = { kind = \"box\"")).expect("a box");
    let floor = "shape = { kind = \"plane\", point = [0.0, 0.0, 0.0], normal = [0.0, 0.0, 1.0] }";
    let read = |shape: &str, motion: &str, prepare: &str| {
        let text = text.replacen(box_shape, &format!("{shape}\nmotion = {{ {motion} }}"), 1);
        MeasuredScene::parse(&format!("{text}\n{prepare}")).map(drop).map_err(|error| error.to_string())
    };
    let prepare = "[prepare]\nduration = 0.4\nstep = 5e-4\n";
    let accepted = |shape: &str, motion: &str| assert_eq!(read(shape, motion, prepare), Ok(()), "{motion}");
    let refused = |shape: &str, motion: &str, remedy: &str| {
        let message = read(shape, motion, prepare).expect_err(motion);
        for words in
            ["wall[0].motion: wall 'box' moves", "would jump back", remedy, "start = 0.4", "leave out [prepare]"]
        {
            assert!(message.contains(words), "{message}");
        }
    };
    let along = |velocity: &str, more: &str| format!("kind = \"translating\", velocity = {velocity}{more}");
    let rises = along("[0.0, 0.0, 0.05]", "");
    refused(box_shape, &rises, "give start");
    refused(box_shape, &along("[0.0, 0.0, 0.05]", ", start = 0.1, stop = 0.2"), "give start");
    refused(floor, &along("[0.0, 0.0, -0.05]", ""), "give start");
    assert_eq!(read(box_shape, &rises, ""), Ok(()), "nothing is prepared");
    accepted(box_shape, &along("[0.0, 0.0, 0.05]", ", start = 0.4"));
    accepted(floor, &along("[0.05, 0.0, 0.0]", ""));

    // Eight periods; 8.4; 8.5, at the end of which it is in its place and goes the other way.
    let shaken = |amplitude: &str, frequency: f64| {
        format!("kind = \"vibrating\", amplitude = {amplitude}, frequency = {frequency:?}")
    };
    accepted(box_shape, &shaken("[0.0, 0.0, 1e-3]", 20.0));
    refused(box_shape, &shaken("[0.0, 0.0, 1e-3]", 21.0), "whole number of periods");
    refused(box_shape, &shaken("[0.0, 0.0, 1e-3]", 21.25), "whole number of periods");
    accepted(floor, &shaken("[1e-3, 0.0, 0.0]", 21.0));

    let turning =
        |axis: &str, rate: f64| format!("kind = \"rotating\", point = [0.0, 0.0, 0.0], axis = {axis}, rate = {rate:?}");
    refused(box_shape, &turning("[0.0, 0.0, 1.0]", 1.0), "whole number of turns");
    refused(floor, &turning("[0.0, 1.0, 0.0]", 1.0), "whole number of turns");
    accepted(box_shape, &turning("[0.0, 0.0, 1.0]", std::f64::consts::TAU / 0.4));
    accepted(floor, &turning("[0.0, 0.0, 1.0]", 1.0));
    let shell = "shape = { kind = \"cylinder\", base = [0.0, -0.02, 0.1], axis = [0.0, 1.0, 0.0], radius = 0.05, length = 0.04 }";
    accepted(shell, "kind = \"rotating\", point = [0.0, 0.0, 0.1], axis = [0.0, 1.0, 0.0], rate = 1.0");
    refused(shell, "kind = \"rotating\", point = [0.0, 0.0, 0.0], axis = [0.0, 1.0, 0.0], rate = 1.0", "turns");

    // What a force drives stays where it is.
    accepted(floor, "kind = \"force-driven\", axis = [0.0, 0.0, 1.0], force = 1.0, mass = 0.1");
}
