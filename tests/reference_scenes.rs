//! Physics regressions: Makadam on the reference scenes, held against what YADE and LIGGGHTS recorded there, and
//! against closed forms.
//!
//! A few seeds each, so this guards against a change that moves the physics; the verdict over all seeds is `makadam qualify`'s.

use approx::assert_relative_eq;
use makadam::scene::Stop;
use makadam_compare::codes::{Code, Job, Makadam, Purpose};
use makadam_compare::compare::{CodeRuns, Harvest, MeasuredRun, Reference, comparison};
use makadam_frames::plan::{MeasuredScene, physics_hash};
use makadam_measure::statistics::{Ensemble, Outcome};
use makadam_qualification::qualify::Tier;
use makadam_qualification::report::Test;
use std::f64::consts::PI;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Runs a scene over the first seeds.
fn simulate(scene: &MeasuredScene, file: &Path, seeds: u64) -> Vec<MeasuredRun> {
    let one = |seed| {
        let job = Job {
            scene,
            scene_file: file,
            purpose: Purpose::Measuring,
            seed,
            stiffness_factor: 1.0,
            rayleigh_fraction: 0.1,
            work_folder: Path::new("."),
            time_limit: Duration::MAX,
            progress: &|_| {},
        };
        Harvest::of(scene, &Makadam.simulate(&job).unwrap(), "", String::new()).run
    };
    (1..=seeds).map(one).collect()
}

/// The file of a reference scene.
fn file_of(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-scenes").join(name).join("scene.toml")
}

/// Mean of what was measured of the runs.
fn mean_of(runs: &[MeasuredRun], observable: &str) -> f64 {
    let value = |run: &MeasuredRun| run.value(observable).unwrap_or_else(|| panic!("{observable} was not measured"));
    runs.iter().map(value).sum::<f64>() / runs.len() as f64
}

/// Runs a reference scene over the first seeds and checks each mean against that of each reference code, to within the scene's margin or,
/// where that is more, three standard errors of the difference of so few seeds.
fn regression(name: &str, seeds: u64) -> Vec<MeasuredRun> {
    let file = file_of(name);
    let scene = MeasuredScene::load(&file).unwrap();
    let runs = simulate(&scene, &file, seeds);
    let reference = Reference::load(&Reference::folder(&file)).unwrap().expect("recorded references");
    let mut checks = 0;
    for expectation in scene.compare.iter().filter(|expectation| expectation.margin.is_some()) {
        let (observable, margin) = (expectation.observable.as_str(), expectation.margin.unwrap());
        let own = mean_of(&runs, observable);
        for code in reference.codes() {
            let recorded = Ensemble::of(&reference.code(&code).unwrap().values(observable)).unwrap();
            let difference = own - recorded.mean;
            let error = recorded.standard_deviation * (1.0 / seeds as f64 + 1.0 / recorded.seeds as f64).sqrt();
            let margin = f64::max(margin, 3.0 * error);
            println!("{name} {observable}: {own:.4}, {difference:+.4} against {code}");
            assert!(
                difference.abs() <= margin,
                "{name} {observable}: {difference:+.4} against {code}, margin {margin}"
            );
            checks += 1;
        }
    }
    assert!(checks >= 2, "{name}: nothing was compared");
    runs
}

#[test]
fn packing_agrees_with_the_recorded_codes_and_carries_its_weight() {
    for run in regression("packing", 3) {
        let carried = run.value("wall_force_over_weight").unwrap();
        assert!((carried - 1.0).abs() < 1e-3, "seed {}: the walls carry {carried} of the weight", run.seed);
    }
}

/// Stiff grains jump off each other by less than they fall in a step; while a contact is open so, its neighbours must not slide.
/// At 1 GPa a step of 1 ms is eight times a contact's own time: with contacts left out wherever there is a gap, it packed to
/// 0.606.
#[test]
fn a_stiff_packing_needs_no_small_step() {
    // Three seeds at 0.125 ms and 20 sweeps: 0.5935 and, with gaps left out, 0.5936.
    const CONVERGED: f64 = 0.5935;
    let file = file_of("packing");
    let mut scene = MeasuredScene::load(&file).unwrap().with_stiffness_factor(100.0);
    scene.solver.step = 1e-3;
    scene.solver.stop = Stop::Sweeps { sweeps: 20 };
    let fraction = mean_of(&simulate(&scene, &file, 3), "packing_fraction");
    assert!((fraction - CONVERGED).abs() < 0.006, "packing fraction {fraction}");
}

#[test]
fn drum_agrees_with_the_recorded_codes() {
    for run in regression("drum", 4) {
        let excess = run.value("coulomb_excess").unwrap();
        assert!(excess < 1e-12, "seed {}: a contact exceeds Coulomb's bound by {excess}", run.seed);
    }
}

#[test]
fn heap_agrees_with_the_recorded_codes() {
    regression("heap", 4);
}

#[test]
fn frictionless_packing_agrees_with_the_recorded_code() {
    regression("frictionless-packing", 3);
}

/// Smooth rigid spheres at rest are isostatic: three conditions of balance a grain, six contacts a grain. With an overlap there are more
/// of them by a multiple of its root (O'Hern, Silbert, Liu & Nagel, Phys. Rev. E 68, 011306, 2003).
#[test]
#[ignore = "takes long: scripts/nightly slow-tests"]
fn a_frictionless_packing_becomes_isostatic_as_its_grains_become_rigid() {
    /// Contacts a grain beyond six, over the root of the mean overlap over the radius.
    const EXCESS: f64 = 9.0;
    let file = file_of("frictionless-packing");
    let contacts_at = |stiffness_factor: f64| {
        let scene = MeasuredScene::load(&file).unwrap().with_stiffness_factor(stiffness_factor);
        let runs = simulate(&scene, &file, 3);
        (mean_of(&runs, "mechanical_coordination_number"), mean_of(&runs, "mean_overlap"))
    };
    for factor in [1.0, 10.0, 100.0] {
        let (contacts, overlap) = contacts_at(factor);
        let isostatic = 6.0 + EXCESS * overlap.sqrt();
        println!("stiffness x {factor}: {contacts:.3} contacts a grain, {isostatic:.3} foretold, overlap {overlap:.5}");
        assert!((contacts - isostatic).abs() < 0.1, "{contacts} contacts a grain at an overlap of {overlap}");
    }
}

/// A sphere that spins about the normal of its contact is slowed down by resistance to twisting alone, by `5/2 mu_t g / r`.
#[test]
fn spinning_tops_slow_down_by_the_formula() {
    let file = file_of("spinning-tops");
    let scene = MeasuredScene::load(&file).unwrap();
    let radius = scene.grain[0].radius;
    let material = &scene.material["grain"];
    let slowing = 2.5 * material.twisting_friction * scene.gravity[2].abs() / radius;
    let inertia = 0.4 * material.density * 4.0 / 3.0 * PI * radius.powi(5);
    let energy_at = |time: f64| {
        let spins = scene.grain.iter().map(|grain| (grain.spin[2].abs() - slowing * time).max(0.0));
        0.5 * inertia * spins.map(|spin| spin * spin).sum::<f64>()
    };
    let frames = (scene.duration / scene.measure.interval).round() as usize;
    let foretold =
        (0..=frames).map(|frame| energy_at(frame as f64 * scene.measure.interval)).sum::<f64>() / (frames + 1) as f64;
    let measured = mean_of(&simulate(&scene, &file, 1), "kinetic_energy");
    assert_relative_eq!(measured, foretold, max_relative = 1e-4);
}

/// A margin, a scene or a recorded reference that changes needs an edit of the baseline.
#[test]
fn baseline_has_the_tests_of_the_scenes() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../validation/baseline.json");
    for tier in [Tier::Quick, Tier::Full, Tier::Release] {
        let extent = tier.extent();
        let baseline = Test::read(&file, extent.name).unwrap();
        let mut count = 0;
        for name in extent.scenes {
            let scene = MeasuredScene::load(&file_of(name)).unwrap();
            let reference = Reference::load(&Reference::folder(&file_of(name))).unwrap().expect("recorded references");
            for code in reference.codes() {
                let runs = reference.of(&code).count();
                for expectation in scene.compare.iter().filter(|expectation| expectation.margin.is_some()) {
                    let title = format!("{} against {code}", expectation.observable);
                    let is = |test: &&Test| (test.group.as_str(), &test.name) == (*name, &title);
                    let test = baseline.iter().find(is).unwrap_or_else(|| panic!("{name}: {title}"));
                    let made = test.runs.expect("runs of both codes");
                    assert_eq!((test.margin, made[1]), (expectation.margin, runs), "{name}: {title}");
                    assert!(made[0] as u64 >= extent.fewest_seeds, "{name}: {title}");
                    assert_eq!(test.scene_hash, Some(physics_hash(&scene)), "{name}: {title}");
                    count += 1;
                }
            }
        }
        assert_eq!(count, baseline.iter().filter(|test| test.margin.is_some()).count(), "{}", extent.name);
    }
}

/// The tiers beyond the quick one judge every scene that can be judged.
#[test]
fn full_and_release_compare_every_scene_with_margins_and_two_references() {
    let mut found: Vec<String> = Vec::new();
    for entry in std::fs::read_dir(file_of("packing").parent().unwrap().parent().unwrap()).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let file = file_of(&name);
        let has_margin = |scene: &MeasuredScene| scene.compare.iter().any(|expectation| expectation.margin.is_some());
        if !file.is_file() || !has_margin(&MeasuredScene::load(&file).unwrap()) {
            continue;
        }
        let reference = Reference::load(&Reference::folder(&file)).unwrap().unwrap_or_default();
        if ["YADE", "LIGGGHTS"].iter().all(|reference_code| reference.codes().iter().any(|code| code == reference_code))
        {
            found.push(name);
        }
    }
    found.sort();
    for tier in [Tier::Full, Tier::Release] {
        let mut scenes = tier.extent().scenes.to_vec();
        scenes.sort_unstable();
        assert_eq!(scenes, found);
    }
}

/// Margins follow from the recorded codes alone: one that is widened by hand is seen.
#[test]
fn margins_keep_to_their_rule() {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scripts/margins");
    let output = std::process::Command::new("python3").arg(script).arg("--check").output().expect("python3 is there");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    assert!(output.status.success(), "{}{}", text(&output.stdout), text(&output.stderr));
    assert!(text(&output.stdout).lines().count() > 60, "{}", text(&output.stdout));
}

/// Meshes of the scenes are those that their script writes.
#[test]
fn meshes_are_those_of_their_script() {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scripts/reference-meshes");
    let output = std::process::Command::new("python3").arg(script).arg("--check").output().expect("python3 is there");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
}

/// Grains half as stiff overlap half as much again.
#[test]
#[ignore = "takes long: scripts/nightly slow-tests"]
fn half_the_stiffness_disagrees() {
    let file = file_of("drum");
    let scene = MeasuredScene::load(&file).unwrap();
    let runs = simulate(&scene.with_stiffness_factor(0.5), &file, 2);
    let own = CodeRuns { runs, ..CodeRuns::live("Makadam", 1, Vec::new()) };
    let reference = Reference::load(&Reference::folder(&file)).unwrap().expect("recorded references");
    let recorded = ["YADE", "LIGGGHTS", "LAMMPS"].map(|code| reference.code_on(code, &scene).unwrap());
    let codes: Vec<CodeRuns> = std::iter::once(own).chain(recorded).collect();
    let rows = comparison(&scene, &codes, Vec::new()).rows;
    let outcomes = rows.iter().filter(|row| row.code == "Makadam" && row.observable == "mean_overlap");
    let outcomes: Vec<_> = outcomes.map(|row| (row.difference, row.outcome)).collect();
    assert!(outcomes.iter().all(|(_, outcome)| *outcome == Some(Outcome::Disagree)), "{outcomes:?}");
}
