//! Unit tests of `src/output/cache.rs`.

use super::*;
use std::fs::{Permissions, set_permissions};
use std::os::unix::fs::{PermissionsExt, symlink};

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
