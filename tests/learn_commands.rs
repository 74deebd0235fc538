//! The commands by which the program is learnt, and what a scene can be given by: `new`, `scenes`, `check`, `observables`, `schema`,
//! `sweep`, `--set`, standard input.

use crate::support::makadam;
use crate::support::small_scene::smoke;
use serde_json::Value;
use std::path::Path;

/// Exit code, standard output and standard error.
fn outcome(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    let output = makadam(folder).args(arguments).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code().unwrap(), text(&output.stdout), text(&output.stderr))
}

/// Standard output of a command that succeeds.
fn said(folder: &Path, arguments: &[&str]) -> String {
    let (code, output, errors) = outcome(folder, arguments);
    assert_eq!(code, 0, "{arguments:?}: {errors}");
    output
}

#[test]
fn in_an_empty_folder_a_new_scene_is_checked_and_run() {
    let folder = tempfile::tempdir().unwrap();
    said(folder.path(), &["new", "drum"]);
    let text = said(folder.path(), &["check", "drum.toml"]);
    for words in ["grains ", "Froude number", "Rayleigh step", "a step of ", "no objection"] {
        assert!(text.contains(words), "no '{words}' in {text}");
    }
    said(folder.path(), &["run", "drum.toml", "--steps", "20", "--quiet"]);
    let summary = std::fs::read(folder.path().join("results/drum/run.json")).unwrap();
    let summary: Value = serde_json::from_slice(&summary).unwrap();
    assert_eq!((&summary["complete"], &summary["steps"]), (&true.into(), &20.into()));
    let (code, _, errors) = outcome(folder.path(), &["new", "drum"]);
    assert!(code == 2 && errors.contains("drum.toml exists already"), "{code}: {errors}");
    let (code, _, errors) = outcome(folder.path(), &["new", "durm"]);
    assert!(code == 2 && errors.contains("'drum'"), "{code}: {errors}");
}

#[test]
fn a_new_scene_goes_to_standard_output_and_a_full_disk_leaves_nothing_in_the_way() {
    let folder = tempfile::tempdir().unwrap();
    let text = said(folder.path(), &["new", "drum", "-"]);
    assert!(text.contains("[[wall]]"), "{text}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    // A disk that takes nothing: no file may grow.
    let script = format!("trap '' XFSZ; ulimit -f 0; exec {} new drum", env!("CARGO_BIN_EXE_makadam"));
    let output = std::process::Command::new("sh").args(["-c", &script]).current_dir(folder.path()).output().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.code() == Some(1) && errors.contains("drum.toml") && errors.contains("the disk has room"),
        "{errors}"
    );
    said(folder.path(), &["new", "drum"]);
}

#[test]
fn help_and_manual_begin_with_what_the_program_does() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in [&["--help"][..], &["print", "manual"]] {
        let text = said(folder.path(), arguments);
        assert!(text.contains("Simulates grains in contact") && !text.contains("Judges Makadam against"), "{text}");
    }
    assert!(said(folder.path(), &["--help"]).starts_with("Simulates grains"));
}

#[test]
fn the_book_lists_the_commands_of_the_help() {
    let folder = tempfile::tempdir().unwrap();
    let help = said(folder.path(), &["--help"]);
    let book = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/README.md");
    let book = std::fs::read_to_string(book).unwrap();
    let table = book.split_once("| group | commands |\n| --- | --- |\n").unwrap().1;
    let mut count = 0;
    for row in table.lines().take_while(|line| line.starts_with('|')) {
        let (group, commands) = row.trim_matches(|c| "| ".contains(c)).split_once(" | ").unwrap();
        let listed: Vec<&str> =
            commands.split(", ").map(|name| name.trim_matches('`').trim_start_matches("makadam ")).collect();
        let title = format!("{}{}:\n", group[..1].to_uppercase(), &group[1..]);
        let helped = help.split_once(&title).unwrap().1.lines().take_while(|line| !line.is_empty());
        assert_eq!(listed, helped.map(|line| line.split_whitespace().next().unwrap()).collect::<Vec<_>>(), "{group}");
        count += listed.len();
    }
    assert_eq!(count, 16);
}

#[test]
fn check_says_what_escaping_grains_cost_and_asks_for_units() {
    let folder = tempfile::tempdir().unwrap();
    said(folder.path(), &["new", "silo"]);
    let text = said(folder.path(), &["check", "silo.toml"]);
    assert!(text.contains("note: watch.on_escape is ignored") && text.contains("a wall that catches them"), "{text}");
    assert!(!said(folder.path(), &["check", "packing"]).contains("note: "));
    // Larger grains fit into a larger region alone: what is asked about stands in the way of nothing.
    let region = "population.region={ kind = \"box\", min = [-400, -400, -400], max = [400, 400, 400] }";
    let shape = "wall.shape={ kind = \"box\", min = [-500, -500, -500], max = [500, 500, 500] }";
    let domain = "domain={ min = [-900, -900, -900], max = [900, 900, 900] }";
    for (changes, words) in [
        (vec!["population.radius.mean=5", region, shape, domain], "are lengths in metres?"),
        (vec!["material.grain.density=2.5"], "is it in g/cm3? 2.5 g/cm3 are 2500 kg/m3"),
        (vec!["material.grain.friction=26.6"], "is it an angle in degrees?"),
    ] {
        let changes = changes.iter().flat_map(|change| ["--set", change]);
        let arguments: Vec<&str> = ["check", "packing"].into_iter().chain(changes).collect();
        let (code, _, errors) = outcome(folder.path(), &arguments);
        assert!(code == 0 && errors.contains(words), "{arguments:?}: {code}: {errors}");
    }
}

#[test]
fn check_is_a_document_too_and_says_what_accuracy_decides() {
    let folder = tempfile::tempdir().unwrap();
    let text = said(folder.path(), &["check", "packing", "--accuracy", "packing_fraction=0.002", "--json"]);
    let document: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(document["grains"], 2000);
    assert!(document["solver"].as_str().unwrap().contains("a step of "), "{document}");
    assert!(document["bytes"].as_u64().unwrap() > 1_000_000 && document["wall_seconds"].as_f64().unwrap() > 0.0);
    assert!(document["threads"].as_u64().unwrap() >= 1 && document["notes"].as_array().unwrap().is_empty());
    for (restitution, warned) in [("0.3", false), ("0.6", true)] {
        let value = format!("material.grain.restitution={restitution}");
        let text = said(folder.path(), &["check", "packing", "--accuracy", "1%", "--set", &value, "--json"]);
        assert_eq!(text.contains("the accuracy is no bound"), warned, "{text}");
    }
}

#[test]
fn scenes_and_observables_are_listed() {
    let folder = tempfile::tempdir().unwrap();
    let list: Value = serde_json::from_str(&said(folder.path(), &["print", "scenes", "--json"])).unwrap();
    let drum = list.as_array().unwrap().iter().find(|scene| scene["name"] == "drum").unwrap();
    assert!(drum["description"].as_str().unwrap().contains("turning drum") && drum["grains"] == 1600);
    let text = said(folder.path(), &["print", "observables", "discharge", "gini"]);
    assert!(text.contains("mass_flow_rate (W) [kg/s]") && text.contains("Gini coefficient"), "{text}");
    let all: Value = serde_json::from_str(&said(folder.path(), &["print", "observables", "--json"])).unwrap();
    for entry in all.as_array().unwrap() {
        let words = ["name", "symbol", "formula", "group"].map(|key| entry[key].as_str().unwrap());
        assert!(words.iter().all(|word| !word.is_empty()), "{entry}");
    }
    let (code, _, errors) = outcome(folder.path(), &["print", "observables", "pakcing_fraction"]);
    assert!(code == 2 && errors.contains("packing_fraction"), "{errors}");
}

#[test]
fn the_schema_takes_every_template_and_has_every_key_of_theirs() {
    let folder = tempfile::tempdir().unwrap();
    let schema: Value = serde_json::from_str(&said(folder.path(), &["print", "schema"])).unwrap();
    assert_eq!(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
    let step = &schema["$defs"]["SolverSettings"]["properties"]["step"];
    // The default of the step follows the scene.
    assert!(step["description"].as_str().unwrap().contains("Time step") && step.get("default").is_none(), "{step}");
    assert_eq!(schema["$defs"]["SolverSettings"]["properties"]["skin"]["default"], 0.6);
    let page = said(folder.path(), &["print", "schema", "--markdown"]);
    for key in ["`spacing`", "`agitation`", "`over_relaxation`", "`\"packing-fraction\"`", "`rate`"] {
        assert!(page.contains(key), "{key} stands in no table");
    }
}

#[test]
fn the_schema_of_reports_is_printed_and_has_no_page() {
    let folder = tempfile::tempdir().unwrap();
    let schema: Value = serde_json::from_str(&said(folder.path(), &["print", "schema", "--report"])).unwrap();
    assert_eq!(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
    assert_eq!(schema["title"], "Makadam report");
    assert_eq!(schema["required"], serde_json::json!(["version", "verdict", "qualification"]));
    let step = &schema["$defs"]["SolverSettings"]["properties"]["step"];
    assert!(step["description"].as_str().unwrap().contains("Time step"), "{step}");
    let (code, _, errors) = outcome(folder.path(), &["print", "schema", "--report", "--markdown"]);
    assert!(code == 2 && errors.contains("cannot be used with"), "{code}: {errors}");
}

#[test]
fn a_scene_is_changed_by_set_and_read_from_standard_input() {
    let folder = tempfile::tempdir().unwrap();
    let smoke = smoke().display().to_string();
    let hash = |arguments: &[&str], input: Option<&str>| {
        let mut command = makadam(folder.path());
        command.arg("run").args(arguments).args(["--steps", "40", "--json", "--quiet", "--restart", "--output", "out"]);
        if let Some(input) = input {
            command.write_stdin(input);
        }
        let output = command.output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
        (summary["state_hash"].to_string(), summary["provenance"]["scene_file"].as_str().unwrap().to_string())
    };
    let text = std::fs::read_to_string(&smoke).unwrap();
    let (plain, file) = hash(&[&smoke], None);
    let (piped, place) = hash(&["-"], Some(&text));
    assert!(plain == piped && file == smoke && place == "<standard input>", "{place}");
    let (changed, place) = hash(&[&smoke, "--set", "population.agitation=0.3"], None);
    assert!(changed != plain && place.ends_with("with --set population.agitation=0.3"), "{place}");
    assert_eq!(hash(&["-", "--set", "population.agitation=0.3"], Some(&text)).0, changed);
}

#[test]
fn changes_that_lead_nowhere_are_refused_with_what_was_meant() {
    let folder = tempfile::tempdir().unwrap();
    for (change, code, words) in [
        ("material.grain.frction=0.3", 3, "did you mean `friction`?"),
        ("solver.method=\"jacobi\"", 3, "write it as { kind ="),
        ("materail.grain.friction=0.3", 2, "did you mean material?"),
        ("wall.material=shell", 2, "say which, such as wall.shell"),
        ("duration", 2, "KEY=VALUE"),
        ("material.grain.friction=-1", 3, "friction"),
        ("duration=long", 3, "with --set duration=long"),
    ] {
        let (found, _, errors) = outcome(folder.path(), &["run", "drum", "--set", change]);
        assert!(found == code && errors.contains(words), "{change}: {found}: {errors}");
        assert!(!folder.path().join("results").exists(), "{change} has left something");
    }
    let (code, _, errors) = outcome(folder.path(), &["compare", "drum", "--record", "--set", "duration=4"]);
    assert!(code == 2 && errors.contains("no folder to record into"), "{code}: {errors}");
    let (code, _, errors) = outcome(folder.path(), &["run", "dram"]);
    assert!(code == 3 && errors.contains("did you mean drum"), "{code}: {errors}");
}

#[test]
fn a_sweep_runs_every_combination_and_goes_on_from_what_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let smoke = smoke().display().to_string();
    let sweep = ["sweep", &smoke, "--over", "material.grain.friction=0.1,0.6", "--seeds", "2", "--set", "duration=0.1"];
    let more = ["--set", "measure.from=0.05", "--output", "out", "--quiet"];
    let arguments: Vec<&str> = sweep.into_iter().chain(more).collect();
    let text = said(folder.path(), &arguments);
    assert!(text.contains("material.grain.friction") && text.contains(" ± ") && text.contains(" (2)"), "{text}");
    let points = std::fs::read_to_string(folder.path().join("out/points.csv")).unwrap();
    assert_eq!(points.lines().count(), 3, "{points}");
    let runs = std::fs::read_to_string(folder.path().join("out/runs.csv")).unwrap();
    assert_eq!(runs.lines().count(), 5, "{runs}");
    assert_eq!(said(folder.path(), &arguments), text, "the same from what is kept");
    assert_eq!(
        std::fs::read_to_string(folder.path().join("out/runs.csv")).unwrap(),
        runs,
        "wall times too: nothing ran"
    );
    let (code, _, errors) = outcome(folder.path(), &["sweep", &smoke, "--over", "material.grain.friction=0.1,-1"]);
    assert!(code == 3 && errors.contains("friction=-1"), "{code}: {errors}");
}

#[test]
fn a_sweep_without_keys_is_one_row_over_seeds() {
    let folder = tempfile::tempdir().unwrap();
    let smoke = smoke().display().to_string();
    let short = ["sweep", &smoke, "--seeds", "3", "--set", "duration=0.1", "-q"];
    let alarmed = [
        "--set",
        "measure.observables=[\"balances\", \"coordination-number\", \"size-mixing\"]",
        "--set",
        "watch.residual=1e-12",
        "--set",
        "watch.every=16",
    ];
    let shown = ["--observables", "largest_overlap,size_mixing_index"];
    let text = said(folder.path(), &short.into_iter().chain(alarmed).chain(shown).collect::<Vec<_>>());
    let row = text.lines().find(|line| line.starts_with("largest_overlap")).unwrap();
    let cells: Vec<&str> = row.split_whitespace().collect();
    assert!(text.contains("1 combination.") && row.contains(" * ") && cells[3] == "3", "{text}");
    let [mean, low, high] = [4, 6, 7].map(|cell| cells[cell].parse::<f64>().unwrap());
    assert!(low < mean && mean < high, "{row}");
    assert!(text.contains("* seed 2: NOT SOUND: "), "{text}");
    assert!(text.contains("seed 1: size_mixing_index: no value: "), "{text}");
    let runs = std::fs::read_to_string(folder.path().join("results/sweep/smoke/runs.csv")).unwrap();
    assert!(runs.starts_with("seed,wall_seconds,sound,") && runs.contains(",false,"), "{runs}");
    let other =
        ["sweep", &smoke, "--over", "material.grain.friction=0.1", "--seeds", "1", "--set", "duration=0.1", "-q"];
    let (code, _, errors) = outcome(folder.path(), &other);
    assert!(code == 2 && errors.contains("tables of a sweep over no key; give another folder"), "{errors}");
    said(folder.path(), &other.into_iter().chain(["--restart"]).collect::<Vec<_>>());
}

#[test]
fn unknown_words_are_answered_with_a_way_or_without_a_guess() {
    let folder = tempfile::tempdir().unwrap();
    for (change, code, words, never) in [
        ("wall.shell.mesh=\"drum.stl\"", 3, "a wall of a CAD file is", "did you mean"),
        ("insert.rate=3", 2, "grains that come during a run are an [[insert]]", "did you mean"),
        ("wall.shell.motion.rpm=20", 3, "rate = rpm * 0.10472", "did you mean"),
        ("population.diameter=0.01", 3, "sizes are given as radius", "did you mean"),
        ("friction=0.3", 3, "it is a key of a material", "did you mean"),
        ("accuracy=0.01", 3, "expected a table", "struct"),
        ("zzz.y=1", 2, "it has name", "did you mean"),
    ] {
        let (found, _, errors) = outcome(folder.path(), &["check", "drum", "--set", change]);
        assert!(found == code && errors.contains(words) && !errors.contains(never), "{change}: {found}: {errors}");
    }
    let (code, _, errors) = outcome(folder.path(), &["run", "avalanche"]);
    assert!(code == 3 && !errors.contains("did you mean") && errors.contains("makadam print scenes"), "{errors}");
    let (code, _, errors) = outcome(folder.path(), &["print", "observables", "zzz"]);
    assert!(code == 2 && !errors.contains("did you mean") && errors.contains("lists all names"), "{errors}");
}

#[test]
fn help_is_wrapped_to_the_terminal() {
    let folder = tempfile::tempdir().unwrap();
    for command in ["run", "sweep", "compare", "measure", "qualify", "tradeoff"] {
        let output = makadam(folder.path()).env("COLUMNS", "80").args([command, "--help"]).output().unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        let widest = text.lines().map(|line| line.chars().count()).max().unwrap();
        assert!(widest <= 80, "{command}: {widest}");
    }
}

#[test]
fn shells_and_man_get_what_they_want() {
    let folder = tempfile::tempdir().unwrap();
    for shell in ["bash", "zsh", "fish"] {
        assert!(said(folder.path(), &["print", "completions", shell]).contains("makadam"), "{shell}");
    }
    said(folder.path(), &["print", "manual", "--output", "man"]);
    assert!(folder.path().join("man/makadam-run.1").is_file());
}
