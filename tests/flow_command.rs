//! Scenes in which grains come and go, from the file to tables, pages and exports.

use crate::support::makadam;
use makadam_frames::run_frames::RunFrames;
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;

/// Writes the stream of `makadam new`, with changes.
fn stream(folder: &Path, changes: &[(&str, &str)]) {
    let mut text = include_str!("../validation/templates/stream.toml").to_string();
    for (from, to) in changes {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    std::fs::write(folder.join("stream.toml"), text).unwrap();
}

/// A short stream onto a small plate, from which grains fall soon.
const SHORT: [(&str, &str); 3] =
    [("duration = 3.0", "duration = 0.6"), ("radius = 0.07", "radius = 0.03"), ("from = 2.0", "from = 0.3")];

fn said(folder: &Path, arguments: &[&str]) -> String {
    let output = makadam(folder).args(arguments).output().unwrap();
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn refusal(folder: &Path, arguments: &[&str]) -> String {
    let output = makadam(folder).args(arguments).output().unwrap();
    assert!(!output.status.success(), "{arguments:?}");
    String::from_utf8(output.stderr).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

#[test]
fn tables_summary_and_observables_agree_on_what_came_and_went() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    stream(folder, &SHORT);
    let summary: Value =
        serde_json::from_str(&said(folder, &["run", "stream.toml", "--ledger", "--json", "--output", "out"])).unwrap();
    let flow = &summary["flow"];
    let (came, went) = (&flow["inserted"][0], &flow["removed"][0]);
    assert!(number(&came["grains"]) > 400.0 && number(&went["grains"]) > 50.0, "{flow}");
    assert_eq!(number(&came["grains"]) - number(&went["grains"]), number(&summary["particles"]));
    let balance = &summary["balance"];
    assert!(number(&balance["closure"]).abs() < 1e-9 * number(&balance["inflow"]), "{balance}");
    assert_eq!(number(&summary["observables"]["discharged_mass"]["value"]), number(&went["mass"]));

    let table = std::fs::read_to_string(folder.join("out/observables.csv")).unwrap();
    let mut lines = table.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let head = lines.next().unwrap();
    let rows: Vec<Vec<&str>> = lines.collect();
    let column = |name: &str| -> Vec<f64> {
        let place = head.iter().position(|known| *known == name).unwrap_or_else(|| panic!("no {name} in {head:?}"));
        rows.iter().map(|row| row[place].parse().unwrap()).collect()
    };
    let [grains, grains_in, grains_out] = ["grains", "grains_in", "grains_out"].map(column);
    let [mass_in, mass_out] = ["mass_in", "mass_out"].map(column);
    for row in 0..grains.len() {
        assert_eq!(grains[row], grains_in[row] - grains_out[row]);
    }
    for rising in [&grains_in, &grains_out, &mass_in, &mass_out] {
        assert!(rising.is_sorted(), "{rising:?}");
    }
    assert_eq!((grains[0], *mass_in.last().unwrap()), (0.0, number(&came["mass"])));

    // What is read from the folder is what the run has measured.
    let measured: Value =
        serde_json::from_str(&said(folder, &["measure", "out", "--scene", "stream.toml", "--json"])).unwrap();
    assert!(measured.to_string().contains(&number(&went["mass"]).to_string()), "{measured}");
    let text = said(folder, &["run", "stream.toml", "--output", "again"]);
    assert!(text.contains("insert[0]") && text.contains("remove[0]") && !text.contains("late by"), "{text}");
}

#[test]
fn frames_name_grains_for_good_and_become_pictures_pages_and_files() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    stream(folder, &SHORT);
    said(folder, &["run", "stream.toml", "--output", "out"]);
    let run = RunFrames::open(&folder.join("out")).unwrap();
    let mut seen = BTreeSet::new();
    let mut counts = BTreeSet::new();
    for number in 0..run.count() {
        let frame = run.read(number).unwrap();
        let values = |name: &str| frame.quantity(name).unwrap().values;
        let (ids, population) = (values("id"), values("population"));
        assert!(ids.is_sorted_by(|a, b| a < b));
        assert!(population.iter().all(|population| *population == 0.0), "the source comes after no populations");
        counts.insert(ids.len());
        seen.extend(ids.iter().map(|id| *id as u64));
    }
    assert!(counts.len() > 4 && seen.len() > *counts.last().unwrap() + 30, "{counts:?}, {} grains", seen.len());
    said(folder, &["picture", "out", "-o", "last.png"]);
    said(folder, &["view", "out", "-o", "page.html"]);
    for format in ["vtp", "vtkhdf", "gsd"] {
        said(folder, &["export", "out", "--format", format]);
    }
}

#[test]
fn a_stopped_run_goes_on_with_the_grains_to_come() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    stream(folder, &SHORT);
    said(folder, &["run", "stream.toml", "--output", "whole"]);
    // The watchdog's state serves as a run that ends before its time.
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_makadam"))
        .args(["run", "stream.toml", "--output", "broken", "--checkpoint-interval", "0.002", "--quiet"])
        .current_dir(folder)
        .spawn()
        .unwrap();
    while !folder.join("broken/run.checkpoint").exists() && child.try_wait().unwrap().is_none() {
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    let _ = child.kill();
    child.wait().unwrap();
    said(folder, &["run", "stream.toml", "--output", "broken", "--resume"]);
    for file in ["observables.csv", "frames.mkd"] {
        let [whole, broken] = ["whole", "broken"].map(|run| std::fs::read(folder.join(run).join(file)).unwrap());
        assert!(whole == broken, "{file}");
    }
}

#[test]
fn a_source_that_is_late_says_so_and_what_cannot_be_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    stream(
        folder,
        &[("duration = 3.0", "duration = 0.3"), ("rate = 800", "total = 4000"), ("from = 2.0", "from = 0.0")],
    );
    let text = said(folder, &["run", "stream.toml", "--output", "late"]);
    assert!(text.contains("late by 0.3000 s: grains find no free place"), "{text}");
    let error = refusal(folder, &["export", "stream.toml", "--for", "liggghts"]);
    assert!(error.contains("it has no inflow: grains of material 'grain' come from insert[0]"), "{error}");
    stream(folder, &[("rate = 800", "rate = 8e6")]);
    let error = refusal(folder, &["run", "stream.toml", "--output", "never"]);
    assert!(error.contains("insert[0].rate: 8000000 cannot be met") && error.contains("stream.toml:25"), "{error}");
    stream(folder, &[("[solver]", "[prepare]\nduration = 1.0\nstep = 4e-4\n[solver]")]);
    let error = refusal(folder, &["run", "stream.toml", "--output", "never"]);
    assert!(error.contains("prepare: given where grains come or go"), "{error}");
}
