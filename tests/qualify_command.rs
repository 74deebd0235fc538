//! `makadam qualify`: every finished run is kept in the folder of the report, whatever ends the command, and none is made twice; each part
//! of a tier counts.

use crate::support::child::wait_for;
use crate::support::invented::record;
use crate::support::makadam;
use crate::support::small_scene::{compared_once, smoke};
use makadam_compare::compare::Row;
use makadam_qualification::qualify::{Ablated, Extent, Settings, Study, qualify};
use makadam_qualification::report::{Qualification, ReportDocument, Standing, StudyOutcome};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, SystemTime};

/// Scenes of the quick tier.
const SCENES: [&str; 4] = ["packing", "drum", "drum-caps", "heap"];

/// Runs of Makadam in a quick qualification of tiny scenes: eight seeds each, and two scenes timed by a seed more.
const RUNS: usize = 34;

/// Writes a tiny scene and what is recorded of two codes on it, under `reference-scenes` in a folder.
fn tiny(folder: &Path, name: &str) {
    let text = compared_once(&std::fs::read_to_string(smoke()).unwrap());
    let text = text.replace("\"smoke\"", &format!("\"{name}\"")).replace("count = 200", "count = 40");
    let scene = folder.join("reference-scenes").join(name);
    std::fs::create_dir_all(&scene).unwrap();
    std::fs::write(scene.join("scene.toml"), text).unwrap();
    record(&scene.join("reference"), &scene.join("scene.toml"));
}

fn bench() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    SCENES.iter().for_each(|name| tiny(folder.path(), name));
    folder
}

/// Runs the quick tier to its end.
fn ended(folder: &Path, output: &str) -> Qualification {
    let ended = makadam(folder).args(["qualify", "--jobs", "2", "--output", output]).output().unwrap();
    let message = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(0), "{message}");
    let json = std::fs::read(folder.join(output).join("report.json")).unwrap();
    serde_json::from_slice::<ReportDocument>(&json).unwrap().qualification
}

/// Started so that an interrupt ends it: what runs in the background of a shell is deaf to interrupts.
fn start(folder: &Path, output: &str) -> Child {
    Command::new("env")
        .args(["--default-signal=INT", env!("CARGO_BIN_EXE_makadam")])
        .args(["qualify", "--jobs", "2", "--output", output])
        .env("XDG_CACHE_HOME", folder.join("cache"))
        .current_dir(folder)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// The runs that are kept, with the times at which they were written.
fn kept(folder: &Path) -> BTreeMap<PathBuf, SystemTime> {
    let entries = std::fs::read_dir(folder.join("runs")).into_iter().flatten().map(Result::unwrap);
    let whole =
        entries.map(|entry| entry.path()).filter(|path| path.extension().is_some_and(|ending| ending == "json"));
    whole.map(|path| (path.clone(), std::fs::metadata(&path).unwrap().modified().unwrap())).collect()
}

fn wait_for_runs(child: &mut Child, folder: &Path, count: usize) {
    wait_for(child, &format!("{count} runs"), || kept(folder).len() >= count);
}

fn rows(qualification: &Qualification) -> Vec<&Row> {
    qualification.comparisons.iter().flat_map(|comparison| &comparison.rows).collect()
}

#[test]
fn whatever_ends_a_qualification_it_goes_on_with_the_runs_that_are_kept() {
    let folder = bench();
    let folder = folder.path();
    let undisturbed = ended(folder, "undisturbed");
    assert_eq!(rows(&undisturbed).len(), 4 * 4);
    assert_eq!(kept(&folder.join("undisturbed")).len(), RUNS);
    let verdict = undisturbed.verdict();
    assert_eq!(verdict.standing, Standing::Agree, "{}", verdict.sentence);

    // Killed twice, once in the timed runs and once later; interrupted; terminated.
    let output = folder.join("disturbed");
    let mut known = BTreeMap::new();
    for (count, signal) in [(1, "-KILL"), (6, "-INT"), (12, "-TERM"), (18, "-KILL")] {
        let mut child = start(folder, "disturbed");
        wait_for_runs(&mut child, &output, count);
        assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
        let ended = child.wait_with_output().unwrap();
        if signal != "-KILL" {
            let message = String::from_utf8_lossy(&ended.stderr);
            assert_eq!(ended.status.code(), Some(1), "{message}");
            assert!(
                message.contains("stored run by run in disturbed; the same command continues from there"),
                "{message}"
            );
        }
        assert!(!output.join("report.json").exists(), "{signal}: it had ended");
        let now = kept(&output);
        assert!(
            known.iter().all(|(run, written)| now.get(run) == Some(written)),
            "{signal}: a kept run was made again"
        );
        known = now;
    }
    let resumed = ended(folder, "disturbed");
    let now = kept(&output);
    assert_eq!(now.len(), RUNS);
    assert!(known.iter().all(|(run, written)| now[run] == *written), "a kept run was made again");
    assert_eq!(rows(&resumed), rows(&undisturbed));
    assert_eq!(resumed.verdict(), verdict);
    for (one, other) in resumed.comparisons.iter().zip(&undisturbed.comparisons) {
        assert_eq!((&one.series, &one.forces, &one.final_states), (&other.series, &other.forces, &other.final_states));
    }
    let note = format!("{} of {RUNS} runs of scenes were taken from an earlier start", known.len());
    assert!(resumed.notes.iter().any(|said| said.starts_with(&note)), "{:?}", resumed.notes);

    // A run that is no longer whole is made again, and nothing else.
    let broken = now.keys().nth(5).unwrap();
    let whole = std::fs::read(broken).unwrap();
    std::fs::write(broken, &whole[..whole.len() / 2]).unwrap();
    let mended = ended(folder, "disturbed");
    let then = kept(&output);
    assert_eq!(
        then.iter().filter(|(run, written)| now[*run] != **written).map(|(run, _)| run).collect::<Vec<_>>(),
        [broken]
    );
    assert_eq!(rows(&mended), rows(&undisturbed));

    // All of it again, if that is asked for.
    let again =
        makadam(folder).args(["qualify", "--restart", "--jobs", "2", "--output", "disturbed"]).output().unwrap();
    assert_eq!(again.status.code(), Some(0));
    assert!(kept(&output).iter().all(|(run, written)| then[run] != *written));

    // Against its own tests it passes, and not against those of other scenes.
    let against = |file: &Path| {
        let command = ["qualify", "--jobs", "2", "--output", "disturbed", "--against"];
        let ended = makadam(folder).args(command).arg(file).output().unwrap();
        (ended.status.code(), String::from_utf8_lossy(&ended.stdout).into_owned())
    };
    let (code, text) = against(&output.join("tests.json"));
    assert!(code == Some(0) && text.contains("the same tests with the same verdicts"), "{text}");
    let committed = Path::new(env!("CARGO_MANIFEST_DIR")).join("../validation/baseline.json");
    let (code, text) = against(&committed);
    assert!(code == Some(4) && text.contains("missing: packing: gini against LAMMPS"), "{text}");
}

/// A qualification of one tiny scene with every kind of study that ends soon.
const SMALL: Extent = Extent {
    name: "small",
    scenes: &["tiny"],
    fewest_seeds: 4,
    timed: &["tiny"],
    studies: &[
        Study::HardCases(&["drift", "impossible-gap-rigid"]),
        Study::Ablation(&[Ablated { scene: "tiny", seeds: 2, needed: "Coulomb friction", unmeasurable: "" }]),
        Study::Convergence(&["tiny"]),
    ],
};

fn judged(folder: &Path) -> Qualification {
    let settings = Settings {
        roots: vec![folder.to_path_buf()],
        folder: folder.join("out"),
        again: false,
        live: false,
        time_limit: Duration::from_secs(60),
        announce: &|_| Box::new(|_| {}),
        say: &|_| {},
    };
    let qualified = qualify(&SMALL, &settings).unwrap();
    assert_ne!(qualified.verdict().standing, Standing::Agree);
    qualified
}

#[test]
fn studies_count_and_share_the_runs_of_the_scenes() {
    let folder = tempfile::tempdir().unwrap();
    tiny(folder.path(), "tiny");
    let first = judged(folder.path());
    let [hard, effects, convergence] = &first.studies[..] else { panic!("{:?}", first.studies) };
    // Four seeds of the scene as it is, two of which the ablation has too, one that is timed, and two of each variation.
    let variations = effects.runs / 2 - 1;
    assert!(variations > 3);
    assert_eq!(kept(&folder.path().join("out")).len(), 4 + 1 + 2 * variations);
    let outcomes: Vec<_> = hard.tests.iter().map(|test| (test.name.as_str(), test.outcome)).collect();
    assert_eq!(outcomes, [("drift", StudyOutcome::Passed), ("impossible-gap-rigid", StudyOutcome::KnownException)]);
    // What alone is measured does not depend on friction.
    let outcomes: Vec<_> = effects.tests.iter().map(|test| (test.name.as_str(), test.outcome)).collect();
    assert_eq!(outcomes, [("tiny: as it is", StudyOutcome::Passed), ("tiny: Coulomb friction", StudyOutcome::Failed)]);
    assert!(
        convergence.tests.iter().any(|test| test.name == "tiny: gauss-seidel" && test.outcome == StudyOutcome::Passed)
    );
    let verdict = first.verdict();
    assert_eq!((verdict.agree, verdict.standing), (2, Standing::Disagree));
    assert!(verdict.sentence.contains("1 failed (tiny: Coulomb friction)"), "{}", verdict.sentence);
    assert!(!convergence.figures.is_empty() && !convergence.files.is_empty() && !effects.files.is_empty());

    // Another start computes nothing.
    let before = kept(&folder.path().join("out"));
    let second = judged(folder.path());
    assert_eq!(kept(&folder.path().join("out")), before);
    assert_eq!((&second.studies, rows(&second)), (&first.studies, rows(&first)));
}
