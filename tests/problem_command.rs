//! `makadam lab problem`: export, check, and what is said of bad files.

use crate::support::makadam;
use crate::support::small_scene::smoke;
use serde_json::Value;
use std::path::Path;

fn run(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    let output = makadam(folder).args(["lab", "problem"]).args(arguments).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

#[test]
fn a_problem_is_exported_and_checked() {
    let folder = tempfile::tempdir().unwrap();
    let scene = smoke();
    let scene = scene.to_str().unwrap();
    let (code, said, errors) = run(folder.path(), &["export", scene, "--time", "0.15", "--output", "a.hdf5"]);
    assert_eq!(code, 0, "{errors}");
    assert!(said.contains("contacts, a.hdf5"), "{said}");
    let (code, said, errors) = run(folder.path(), &["check", "a.hdf5", "--json"]);
    assert_eq!(code, 0, "{errors}");
    let document: Value = serde_json::from_str(&said).unwrap();
    assert_eq!((document["version"].as_u64(), document["command"].as_str()), (Some(1), Some("problem check")));
    assert_eq!(document["problems"][0]["answers"][0]["converged"], true);
    let (code, said, errors) = run(folder.path(), &["check", "a.hdf5", "a.hdf5"]);
    assert_eq!(code, 0, "{errors}{said}");
    assert!(said.contains("reference: converged") && said.contains("lanes: converged"), "{said}");
    // Too few sweeps do not converge.
    let (code, said, _) = run(folder.path(), &["check", "a.hdf5", "--sweeps", "1"]);
    assert_eq!(code, 4, "{said}");
    assert!(said.contains("not converged after 1 iterations"), "{said}");
}

#[test]
fn only_problems_are_replaced_by_problems() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("victim.toml");
    std::fs::copy(smoke(), &scene).unwrap();
    let whole = std::fs::read(&scene).unwrap();
    let export = |output: &str| run(folder.path(), &["export", "victim.toml", "--time", "0.15", "--output", output]);
    for output in ["victim.toml", "."] {
        let (code, said, errors) = export(output);
        assert!(code == 2 && said.is_empty(), "{said}{errors}");
        assert!(errors.contains("is no problem file (HDF5)") && errors.contains("another file"), "{errors}");
    }
    for _ in 0..2 {
        let (code, _, errors) = export("a.hdf5");
        assert_eq!(code, 0, "an earlier problem is replaced: {errors}");
    }
    assert!(std::fs::read(&scene).unwrap() == whole);
}

#[test]
fn bad_files_and_missing_programs_have_their_exit_codes() {
    let folder = tempfile::tempdir().unwrap();
    let recorded = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/src/problem/recorded/drum.hdf5");
    let bytes = std::fs::read(&recorded).unwrap();
    std::fs::write(folder.path().join("cut.hdf5"), &bytes[..bytes.len() / 2]).unwrap();
    for (name, words) in [("cut.hdf5", "write it anew"), ("none.hdf5", "check the path")] {
        let (code, _, errors) = run(folder.path(), &["check", name]);
        assert_eq!(code, 3, "{errors}");
        assert!(errors.contains(name) && errors.contains(words), "{errors}");
    }
    let scene = smoke();
    let (code, _, errors) =
        run(folder.path(), &["export", scene.to_str().unwrap(), "--steps", "0", "--output", "a.hdf5"]);
    assert_eq!(code, 2, "{errors}");
    assert!(errors.contains("no contacts at 0 s"), "{errors}");
    let output = makadam(folder.path())
        .args(["lab", "problem", "check", "--siconos"])
        .arg(&recorded)
        .env("MAKADAM_SICONOS_PYTHON", "/nowhere/python3")
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(5));
    assert!(String::from_utf8_lossy(&output.stderr).contains("python3-siconos is missing"));
    // It is there, and fails: what was asked for was not done.
    let failing = folder.path().join("python3");
    std::fs::write(
        &failing,
        "#!/bin/sh\ncase \"$2\" in *print\\(version*) echo 4.4;; *) echo 'out of memory' >&2; exit 1;; esac\n",
    )
    .unwrap();
    std::fs::set_permissions(&failing, std::os::unix::fs::PermissionsExt::from_mode(0o755)).unwrap();
    let output = makadam(folder.path())
        .args(["lab", "problem", "check", "--siconos"])
        .arg(&recorded)
        .env("MAKADAM_SICONOS_PYTHON", &failing)
        .output()
        .unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{errors}");
    assert!(errors.contains("Siconos failed: out of memory"), "{errors}");
}
