//! Unit tests of `src/scenes/mod.rs`.

use super::*;
use crate::compare::Reference;

#[test]
fn every_reference_scene_is_held_with_its_references() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let entries = std::fs::read_dir(folder.join("reference-scenes")).unwrap().flatten();
    let scenes = entries.filter(|entry| entry.path().join("scene.toml").is_file());
    let mut on_disk: Vec<String> = scenes.map(|entry| entry.file_name().into_string().unwrap()).collect();
    on_disk.sort();
    assert_eq!(names().collect::<Vec<_>>(), on_disk);
    for name in names() {
        let file = find(name, &[]).unwrap();
        assert!(is_built_in(&file), "{}", file.display());
        let on_disk = folder.join("reference-scenes").join(name).join("scene.toml");
        assert_eq!(load(&file).unwrap(), load(&on_disk).unwrap(), "{name}");
        assert_eq!(Reference::of_scene(&file).unwrap(), Reference::of_scene(&on_disk).unwrap(), "{name}");
    }
    assert!(Reference::of_scene(&find("packing", &[]).unwrap()).unwrap().is_some());
}

#[test]
fn a_folder_of_scenes_goes_before_what_is_held() {
    let folder = tempfile::tempdir().unwrap();
    let own = folder.path().join("reference-scenes/packing");
    std::fs::create_dir_all(&own).unwrap();
    std::fs::write(own.join("scene.toml"), text(&find("packing", &[]).unwrap()).unwrap()).unwrap();
    let roots = [folder.path().to_path_buf()];
    assert_eq!(find("packing", &roots).unwrap(), own.join("scene.toml"));
    assert!(is_built_in(&find("drum", &roots).unwrap()));
}

#[test]
fn a_path_that_is_no_file_is_told_from_a_name_that_is_no_scene() {
    for path in ["nowhere/scene.toml", "scene-that-is-not-there.toml", "./drum-of-mine"] {
        let message = find(path, &[]).unwrap_err().to_string();
        assert!(message.contains(path) && message.contains("cannot be read: No such file"), "{message}");
    }
    let message = find("drumm", &[]).unwrap_err().to_string();
    assert!(message.contains("no scene 'drumm'") && message.contains("did you mean drum"), "{message}");
    let folder = tempfile::tempdir().unwrap();
    let message = find(folder.path().to_str().unwrap(), &[]).unwrap_err().to_string();
    assert!(message.contains("folder without a scene.toml"), "{message}");
    let message = find("/dev/null", &[]).unwrap_err().to_string();
    assert!(message.contains("no regular file"), "{message}");
}
