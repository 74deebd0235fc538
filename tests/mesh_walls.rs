//! Scenes with walls from CAD files, from the file to the picture.

use crate::support::makadam;
use std::path::Path;

/// The hopper with its file, in a folder.
fn hopper(folder: &Path) {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenes/hopper");
    for name in ["scene.toml", "funnel.stl"] {
        std::fs::copy(source.join(name), folder.join(name)).unwrap();
    }
}

#[test]
fn a_run_with_a_mesh_goes_on_without_its_file() {
    let folder = tempfile::tempdir().unwrap();
    hopper(folder.path());
    // The path is relative to the scene, not to the current folder.
    let inner = folder.path().join("elsewhere");
    std::fs::create_dir(&inner).unwrap();
    let run = ["run", "../scene.toml", "--set", "duration=0.1", "-o", "out", "--quiet"];
    makadam(&inner).args(run).assert().success();
    std::fs::remove_file(folder.path().join("funnel.stl")).unwrap();
    makadam(&inner).args(["picture", "out", "-o", "last.png"]).assert().success();
    assert!(inner.join("last.png").metadata().unwrap().len() > 10_000);
    makadam(&inner).args(["view", "out", "-o", "page.html"]).assert().success();
    makadam(&inner).args(["export", "out", "--format", "vtp"]).assert().success();
    // The folder of the run holds the scene with its triangles, at any place.
    std::fs::rename(inner.join("out"), folder.path().join("moved")).unwrap();
    std::fs::remove_file(folder.path().join("scene.toml")).unwrap();
    for words in [&["measure", "moved"][..], &["measure", "moved", "--set", "measure.interval=0.05"]] {
        makadam(folder.path()).args(words).assert().success();
    }
    let output = makadam(folder.path()).args(["measure", "moved/observables.csv"]).assert().failure();
    let errors = String::from_utf8_lossy(&output.get_output().stderr).into_owned();
    assert!(errors.contains("give it by --scene"), "{errors}");
    hopper(folder.path());
    std::fs::remove_file(folder.path().join("funnel.stl")).unwrap();
    let output = makadam(&inner).args(run).assert().code(3);
    let errors = String::from_utf8_lossy(&output.get_output().stderr).into_owned();
    assert!(errors.contains("funnel.stl' cannot be read") && errors.contains(":17: wall[0].shape.file"), "{errors}");
}

#[test]
fn other_codes_get_the_triangles_or_refuse() {
    let folder = tempfile::tempdir().unwrap();
    hopper(folder.path());
    let export = |code: &str| makadam(folder.path()).args(["export", "scene.toml", "--for", code, "-o", code]).assert();
    export("liggghts").success();
    export("yade").success();
    let files = std::fs::read_dir(folder.path().join("liggghts")).unwrap().map(|entry| entry.unwrap().path());
    let facets =
        files.filter_map(|path| std::fs::read_to_string(path).ok()).map(|text| text.matches("outer loop").count());
    assert!(facets.into_iter().any(|count| count == 32));
    let job = std::fs::read_to_string(folder.path().join("yade/job.json")).unwrap();
    let job: serde_json::Value = serde_json::from_str(&job).unwrap();
    assert_eq!(job["walls"][0]["triangles"].as_array().unwrap().len(), 32);
    let output = export("lammps").failure();
    let errors = String::from_utf8_lossy(&output.get_output().stderr).into_owned();
    assert!(errors.contains("no region like a mesh of triangles"), "{errors}");
}

#[test]
fn other_codes_get_the_facets_of_frusta_and_rectangles() {
    let folder = tempfile::tempdir().unwrap();
    let text = include_str!("scenes/hopper/scene.toml").replace(
        "kind = \"mesh\", file = \"funnel.stl\", scale = 0.001",
        "kind = \"frustum\", base = [0, 0, 0], axis = [0, 0, 1], radii = [0.01, 0.06], length = 0.06",
    );
    let chute =
        "shape = { kind = \"rectangle\", corner = [-0.05, -0.05, -0.03], edges = [[0.1, 0, 0], [0, 0.1, -0.04]] }";
    let text = text.replace(
        "[[population]]",
        &format!("[[wall]]\nname = \"chute\"\nmaterial = \"glass\"\n{chute}\n\n[[population]]"),
    );
    std::fs::write(folder.path().join("scene.toml"), text).unwrap();
    let export = |code: &str| makadam(folder.path()).args(["export", "scene.toml", "--for", code, "-o", code]).assert();
    export("liggghts").success();
    export("yade").success();
    let job = std::fs::read_to_string(folder.path().join("yade/job.json")).unwrap();
    let job: serde_json::Value = serde_json::from_str(&job).unwrap();
    let [cone, chute] = [0, 2].map(|wall| job["walls"][wall]["triangles"].as_array().unwrap().len());
    assert!(cone > 40 && chute == 2, "{cone} and {chute}");
    let files = std::fs::read_dir(folder.path().join("liggghts")).unwrap().map(|entry| entry.unwrap().path());
    let mut facets: Vec<usize> =
        files.filter_map(|path| Some(std::fs::read_to_string(path).ok()?.matches("outer loop").count())).collect();
    facets.sort_unstable();
    assert!(facets.contains(&cone) && facets.contains(&2), "{facets:?}");
    let output = export("lammps").failure();
    let errors = String::from_utf8_lossy(&output.get_output().stderr).into_owned();
    assert!(errors.contains("no region is written for a frustum"), "{errors}");
}

#[test]
fn check_names_the_unit_of_a_file() {
    let folder = tempfile::tempdir().unwrap();
    hopper(folder.path());
    let text = std::fs::read_to_string(folder.path().join("scene.toml")).unwrap();
    std::fs::write(folder.path().join("large.toml"), text.replace(", scale = 0.001", "")).unwrap();
    let output = makadam(folder.path()).args(["check", "large.toml"]).assert();
    let output = output.get_output();
    let said = format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(said.contains("is the file in millimetres? scale = 0.001 makes it fit"), "{said}");
}
