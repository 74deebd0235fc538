//! Stored states of the command: a checkpoint of another build is refused, a damaged flowing state is prepared again.

use makadam::checkpoint::{open, seal};
use makadam::{BUILD, Simulation};
use makadam_frames::plan::MeasuredScene;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;

/// The command in a folder, with a cache of its own there.
fn makadam(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_makadam"));
    command.args(arguments).env("XDG_CACHE_HOME", folder.join("cache")).current_dir(folder);
    command
}

/// The small scene in a file of the folder, with lines added.
fn scene(folder: &Path, more: &str) -> PathBuf {
    let text =
        std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenes/smoke.toml")).unwrap();
    let file = folder.join("scene.toml");
    std::fs::write(&file, text + more).unwrap();
    file
}

fn words(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A sealed file with one piece of text in place of another one of the same length, and the seal made to fit.
fn forge(file: &Path, from: &str, to: &str) {
    let bytes = std::fs::read(file).unwrap();
    let mark: [u8; 8] = bytes[..8].try_into().unwrap();
    let mut body = open(mark, &bytes).unwrap().to_vec();
    let place = body.windows(from.len()).position(|piece| piece == from.as_bytes()).expect("it names its build");
    body[place..place + to.len()].copy_from_slice(to.as_bytes());
    std::fs::write(file, seal(mark, &body)).unwrap();
}

/// Another build of the same version.
fn other_build() -> String {
    let (version, key) = BUILD.rsplit_once('-').unwrap();
    format!("{version}-{}", key.chars().rev().map(|digit| if digit == 'f' { '0' } else { 'f' }).collect::<String>())
}

#[test]
fn a_checkpoint_of_another_build_is_refused_and_the_way_out_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    scene(folder, "");
    let arguments = ["run", "scene.toml", "--output", "out", "--quiet"];
    let mut child = makadam(folder, &arguments)
        .args(["--steps", "100000000", "--checkpoint-interval", "0.01"])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let checkpoint = folder.join("out/run.checkpoint");
    while !checkpoint.is_file() {
        assert!(child.try_wait().unwrap().is_none(), "the run ended by itself");
        std::thread::sleep(Duration::from_millis(2));
    }
    child.kill().unwrap();
    child.wait().unwrap();

    let other = other_build();
    forge(&checkpoint, BUILD, &other);
    let resumed = makadam(folder, &arguments).arg("--resume").output().unwrap();
    let message = words(&resumed);
    assert_eq!(resumed.status.code(), Some(2), "{message}");
    assert!([BUILD, &other, "--restart"].iter().all(|piece| message.contains(piece)), "{message}");
    // This build's own goes on.
    forge(&checkpoint, &other, BUILD);
    let steps = ["--resume", "--steps", "100000"];
    let mut child = makadam(folder, &arguments).args(steps).stderr(Stdio::piped()).spawn().unwrap();
    std::thread::sleep(Duration::from_millis(300));
    let ended = child.try_wait().unwrap();
    assert!(ended.is_none_or(|status| status.success()), "{ended:?}");
    child.kill().unwrap();
    child.wait().unwrap();
}

#[test]
fn a_prepared_state_is_taken_and_a_damaged_one_is_prepared_again() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    scene(folder, "\n[prepare]\nduration = 0.05\nstep = 5e-4\n");
    let run = |seed: &str| {
        let arguments = ["run", "scene.toml", "--steps", "20", "--seed", seed, "--output", seed, "--restart", "--json"];
        let output = makadam(folder, &arguments).output().unwrap();
        assert!(output.status.success(), "{}", words(&output));
        let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        (summary["state_hash"].to_string(), words(&output))
    };
    let (first, _) = run("1");
    let (second, _) = run("2");
    assert_ne!(first, second);
    let state = |seed: &str| {
        let states = std::fs::read_dir(folder.join("cache/makadam/prepared")).unwrap();
        let mut states = states.map(|state| state.unwrap().path());
        states.find(|state| state.to_string_lossy().contains(&format!("-s{seed}-"))).unwrap()
    };
    let (kept, said) = run("1");
    assert!(kept == first && said.contains("starting from the flowing state"), "{said}");
    let (file, whole) = (state("1"), std::fs::read(state("1")).unwrap());
    std::fs::write(&file, &whole[..whole.len() - 1]).unwrap();
    assert_eq!(run("1").0, first);
    assert!(std::fs::read(&file).unwrap() == whole, "it is whole again");
}

#[test]
fn other_codes_start_from_the_state_that_a_scene_prepares() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let file = scene(folder, "\n[prepare]\nduration = 0.05\nstep = 5e-4\n");
    let mut simulation = Simulation::new(&MeasuredScene::load(&file).unwrap(), 1).unwrap();
    (0..100).for_each(|_| {
        simulation.step();
    });
    for code in ["liggghts", "lammps"] {
        let output = makadam(folder, &["export", "scene.toml", "--for", code, "-o", code]).output().unwrap();
        assert!(output.status.success(), "{}", words(&output));
        let data = std::fs::read_to_string(folder.join(code).join("grains.data")).unwrap();
        let table = |head: &str| {
            let rows = data.split_once(head).unwrap().1.trim_start().lines().take_while(|line| !line.is_empty());
            rows.map(|line| line.split(' ').map(|word| word.parse().unwrap()).collect()).collect::<Vec<Vec<f64>>>()
        };
        let (places, motions) = (table("Atoms\n"), table("Velocities\n"));
        let grains = simulation.snapshot().particles;
        assert_eq!((places.len(), motions.len()), (grains.len(), grains.len()));
        for grain in grains {
            let row = grain.id as usize;
            assert_eq!(places[row][4..], grain.position, "{code}, grain {row}");
            assert_eq!(motions[row][1..], [grain.velocity, grain.spin].concat(), "{code}, grain {row}");
        }
    }
}

#[test]
fn what_another_code_lacks_is_said_before_a_state_is_prepared() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    scene(folder, "\n[prepare]\nduration = 0.05\nstep = 5e-4\n");
    let export = |code: &str, more: &[&str]| {
        let fixed = ["export", "scene.toml", "--for", code, "-o", code];
        makadam(folder, &[&fixed, more].concat()).output().unwrap()
    };
    let prepared = folder.join("cache/makadam/prepared");
    for code in ["yade", "liggghts", "lammps"] {
        let refused = export(code, &["--set", "material.grain.kinetic_friction=0.3"]);
        assert!(!refused.status.success() && words(&refused).contains("kinetic friction"), "{}", words(&refused));
        assert!(!prepared.exists(), "a state was prepared in vain for {code}");
    }
    assert!(export("liggghts", &[]).status.success());
    assert!(prepared.is_dir(), "what a code can run is prepared there");
}
