//! Unit tests of `src/output/folders.rs`.

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
