//! Unit tests of `src/output/folders.rs`.

use super::*;
use std::fs::{Permissions, set_permissions};
use std::os::unix::fs::{PermissionsExt, symlink};

#[test]
fn a_name_becomes_a_part_of_a_file_name_that_stands_for_itself_alone() {
    assert_eq!(file_stem("drum-50k_v1.2"), "drum-50k_v1.2");
    assert_eq!(file_stem("a/../b c"), "a-..-b-c");
    for name in ["", ".", "..", "..."] {
        let stem = file_stem(name);
        assert!(stem.starts_with("scene") && !stem.contains('.'), "{name}: {stem}");
    }
    let long = "n".repeat(4000);
    let other = long.clone() + "m";
    assert!(file_stem(&long).len() <= LONGEST_STEM);
    assert_ne!(file_stem(&long), file_stem(&other));
    assert!(file_stem(&".".repeat(4000)).len() <= LONGEST_STEM);
}

#[test]
fn folders_are_named_after_the_processor_in_plain_words() {
    let folder = |file: &str, processor: &str, cores: Option<usize>| {
        record_folder("scaling", Path::new(file), processor, Some(InstructionSet::Avx512), cores)
    };
    assert_eq!(folder("drum/scene.toml", "AMD EPYC", None), Path::new("drum/scaling/amd-epyc-avx512"));
    let xeon = "Intel(R) Xeon(R) Processor";
    let of_sixteen = Path::new("drum/fast-scaling/intel-xeon-processor-avx512-16-cores");
    assert_eq!(folder("drum/fast.toml", xeon, Some(16)), of_sixteen);
}

#[test]
fn two_runs_of_one_name_have_folders_of_their_own() {
    assert_ne!(run_folder("packing-yade-s1").unwrap(), run_folder("packing-yade-s1").unwrap());
}

#[test]
fn a_folder_among_temporary_files_is_taken_only_from_its_user() {
    let shared = tempfile::tempdir().unwrap();
    let user = shared.path().metadata().unwrap().uid();
    let folder = private_folder(shared.path(), user).unwrap();
    assert_eq!(folder.metadata().unwrap().mode() & 0o777, 0o700);
    assert_eq!(private_folder(shared.path(), user).unwrap(), folder, "it is taken again");

    let refused = |user: u32, words: &str| {
        let message = private_folder(shared.path(), user).unwrap_err().to_string();
        assert!(message.contains(words) && message.contains("XDG_CACHE_HOME"), "{message}");
    };
    set_permissions(&folder, Permissions::from_mode(0o770)).unwrap();
    refused(user, "others may write");
    refused(user + 1, "belongs to somebody else");
    set_permissions(&folder, Permissions::from_mode(0o700)).unwrap();
    symlink(&folder, shared.path().join(format!("makadam-{}", user + 2))).unwrap();
    refused(user + 2, "not a folder");
}
