//! `makadam lab convergence`: residuals fall, the JSON contract, what is written.

use crate::support::changed::changed;
use crate::support::makadam;
use crate::support::small_scene::smoke;
use serde_json::Value;

/// Root mean square residual of a point over the three directions, where nothing resists turning.
fn residual(point: &Value) -> f64 {
    let square = |direction: &str| point["residuals"][direction]["rms"].as_f64().unwrap().powi(2);
    (square("normal") + square("tangential_u") + square("tangential_v")).sqrt()
}

#[test]
fn residuals_fall_and_are_written() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["--settle", "0.3", "--iterations", "100", "--json", "--output", "out"];
    let output = makadam(folder.path()).args(["lab", "convergence"]).arg(smoke()).args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let study: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((study["version"].as_u64(), study["command"].as_str()), (Some(1), Some("convergence")));
    assert_eq!((study["scene"].as_str(), study["particles"].as_u64()), (Some("smoke"), Some(200)));
    assert_eq!(study["residual_unit_name"], "g h");
    assert!((study["residual_unit"].as_f64().unwrap() - 9.81 * study["time_step"].as_f64().unwrap()).abs() < 1e-12);
    assert!(study["contacts"].as_u64().unwrap() > 0 && study["start_seconds"].as_f64().unwrap() > 0.29);
    let methods = study["methods"].as_array().unwrap();
    let names: Vec<&str> = methods.iter().map(|row| row["method"].as_str().unwrap()).collect();
    let all = [
        "gauss-seidel",
        "anderson",
        "nonlinear-conjugate-gradients",
        "accelerated-projected-gradients",
        "jacobi",
        "projected-conjugate-gradients",
    ];
    assert_eq!(names, all);
    for row in methods {
        let points = row["points"].as_array().unwrap();
        assert_eq!(points.len(), 101, "the start and each iteration");
        assert_eq!(residual(&points[0]), residual(&methods[0]["points"][0]), "all start from the same state");
        assert!(row["seconds_per_iteration"].as_f64().unwrap() > 0.0);
        for reached in row["reached"].as_array().unwrap() {
            let Some(iterations) = reached["iterations"].as_u64() else { continue };
            let tolerance = reached["tolerance"].as_f64().unwrap();
            assert!(residual(&points[iterations as usize]) <= tolerance);
            assert!(iterations == 0 || residual(&points[iterations as usize - 1]) > tolerance);
            assert_eq!(reached["seconds"], points[iterations as usize]["seconds"]);
        }
    }
    let points = methods[0]["points"].as_array().unwrap();
    assert!(residual(&points[100]) < 1e-2 * residual(&points[0]), "Gauss-Seidel's falls by two orders of magnitude");

    let table = std::fs::read_to_string(folder.path().join("out/convergence.csv")).unwrap();
    assert!(table.starts_with("method,iteration,seconds,normal_rms,normal_max,tangential_u_rms,"), "{table}");
    assert_eq!(table.lines().count(), 1 + 6 * 101);
    for name in ["convergence.html", "convergence.json", "provenance.json", "methods-time.svg", "directions-jacobi.svg"]
    {
        assert!(folder.path().join("out").join(name).is_file(), "{name}");
    }
}

#[test]
fn chosen_methods_are_recorded_beside_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let scene =
        changed(folder.path(), "[measure]", "[solver]\nmethod = { kind = \"anderson\", memory = 5 }\n\n[measure]");
    let arguments = [
        "--methods",
        "anderson,gauss-seidel",
        "--iterations",
        "5",
        "--repetitions",
        "1",
        "--record",
        "--output",
        "out",
        "--quiet",
    ];
    let output = makadam(folder.path()).args(["lab", "convergence"]).arg(&scene).args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(output.stderr.is_empty() && String::from_utf8_lossy(&output.stdout).contains("gauss-seidel"));
    let machine = std::fs::read_dir(folder.path().join("changed-convergence")).unwrap().next().unwrap().unwrap().path();
    let table = std::fs::read_to_string(machine.join("convergence.csv")).unwrap();
    assert_eq!(table.lines().count(), 1 + 2 * 6);
    assert!(machine.join("provenance.json").is_file());
    let study = std::fs::read_to_string(folder.path().join("out/convergence.json")).unwrap();
    let study: Value = serde_json::from_str(&study).unwrap();
    assert_eq!(study["methods"][1]["parameters"]["memory"], 5, "the scene's own method has its parameters");
    // Without --settle the problem is that of the scene's end.
    assert!((study["start_seconds"].as_f64().unwrap() - 0.4).abs() < 1e-9);
}

#[test]
fn methods_that_leave_torques_out_are_not_run_and_the_study_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let scene = changed(folder.path(), "restitution = 0.3", "restitution = 0.3\nrolling_friction = 0.2");
    let study = |methods: &[&str]| {
        let mut command = makadam(folder.path());
        command.args(["lab", "convergence"]).arg(&scene).args([
            "--settle",
            "0.3",
            "--iterations",
            "20",
            "--repetitions",
            "1",
        ]);
        command.args(["--json", "--output", "out"]).args(methods).output().unwrap()
    };
    let output = study(&[]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    let methods = document["methods"].as_array().unwrap();
    assert_eq!(methods.len(), 1);
    assert_eq!(methods[0]["method"], "gauss-seidel");
    let turning = |place: usize| methods[0]["points"][place]["residuals"]["turning"]["rms"].as_f64().unwrap();
    assert!(turning(0) > 0.0 && turning(20) < turning(1), "{} to {}", turning(1), turning(20));
    assert_eq!(document["findings"].as_array().unwrap().len(), 5);
    assert!(
        document["findings"]
            .to_string()
            .contains("Not run: method anderson does not go with contacts that bear torques")
    );
    let table = std::fs::read_to_string(folder.path().join("out/convergence.csv")).unwrap();
    assert!(table.lines().next().unwrap().ends_with(",turning_rms,turning_max"), "{table}");
    // Asked for by name it is an error, before anything runs.
    let output = study(&["--methods", "gauss-seidel,anderson"]);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        output.status.code() == Some(2) && message.contains("anderson") && message.contains("torques"),
        "{message}"
    );
}

#[test]
fn what_cannot_be_done_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let output =
        makadam(folder.path()).args(["lab", "convergence"]).arg(smoke()).args(["--methods", "sor"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    let message = String::from_utf8_lossy(&output.stderr).to_string();
    assert!(message.contains("'sor'") && message.contains("gauss-seidel"), "{message}");
    // After one step the grains still fall freely.
    let output =
        makadam(folder.path()).args(["lab", "convergence"]).arg(smoke()).args(["--settle", "5e-4"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("--settle"));
}
