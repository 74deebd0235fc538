//! Unit tests of `src/output/record.rs`.

use super::*;

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
