//! Unit tests of `src/output/names.rs`.

use super::*;

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
