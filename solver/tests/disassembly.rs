//! Machine code of the 512-bit kernels, read back from the executable that runs these tests.

use iced_x86::{CpuidFeature, Decoder, DecoderOptions, Instruction, OpKind, Register};
use object::{Object, ObjectSection, ObjectSymbol, SymbolKind};
use std::collections::BTreeSet;
use std::path::PathBuf;

/// Instruction sets that an instruction may require: AVX-512F and CD and older ones, as the Xeon Phi x200 has them.
///
/// Fused multiply-add is not among them although that processor has it: kernels do without (see `lanes`).
const ALLOWED: [CpuidFeature; 24] = [
    CpuidFeature::INTEL8086,
    CpuidFeature::INTEL186,
    CpuidFeature::INTEL286,
    CpuidFeature::INTEL386,
    CpuidFeature::INTEL486,
    CpuidFeature::X64,
    CpuidFeature::CMOV,
    CpuidFeature::CX8,
    CpuidFeature::MULTIBYTENOP,
    CpuidFeature::PAUSE,
    CpuidFeature::SSE,
    CpuidFeature::SSE2,
    CpuidFeature::SSE3,
    CpuidFeature::SSSE3,
    CpuidFeature::SSE4_1,
    CpuidFeature::SSE4_2,
    CpuidFeature::POPCNT,
    CpuidFeature::LZCNT,
    CpuidFeature::BMI1,
    CpuidFeature::BMI2,
    CpuidFeature::AVX,
    CpuidFeature::AVX2,
    CpuidFeature::AVX512F,
    CpuidFeature::AVX512CD,
];

/// A function of an executable.
struct Function {
    symbol: String,
    instructions: Vec<Instruction>,
}

impl Function {
    /// Returns true if it is a kernel compiled for 512 bits. The mangled name holds these words in both of rustc's manglings.
    fn is_kernel(&self) -> bool {
        self.symbol.contains("5lanes10run_avx512")
    }
}

fn name(instruction: Instruction) -> String {
    format!("{:?}", instruction.mnemonic()).to_lowercase()
}

/// The functions of an executable that were compiled from this crate, or from intrinsics of AVX-512.
fn functions_of(executable: &[u8]) -> Vec<Function> {
    let file = object::File::parse(executable).expect("an executable that can be read");
    let functions = file.symbols().filter(|symbol| symbol.kind() == SymbolKind::Text && symbol.size() > 0);
    functions
        .filter_map(|symbol| {
            let name = symbol.name().ok()?;
            let is_intrinsic = name.contains("9core_arch") && name.contains("avx512");
            if !name.contains("7makadam") && !is_intrinsic {
                return None;
            }
            let section = file.section_by_index(symbol.section_index()?).ok()?;
            let code = section.data_range(symbol.address(), symbol.size()).ok()??;
            let instructions = Decoder::with_ip(64, code, symbol.address(), DecoderOptions::NONE).into_iter().collect();
            Some(Function { symbol: name.to_owned(), instructions })
        })
        .collect()
}

fn own_functions() -> Vec<Function> {
    let path = std::env::current_exe().expect("a path of this test");
    functions_of(&std::fs::read(path).expect("this test can be read"))
}

/// Returns the reason for which the Xeon Phi x200 does not have an instruction, if it does not.
fn objection(instruction: &Instruction) -> Option<String> {
    let foreign: Vec<_> = instruction.cpuid_features().iter().filter(|feature| !ALLOWED.contains(feature)).collect();
    if instruction.is_invalid() {
        return Some("no instruction".to_owned());
    }
    if name(*instruction).starts_with("vfm") || name(*instruction).starts_with("vfnm") {
        return Some(format!("{:?} is fused", instruction.code()));
    }
    (!foreign.is_empty()).then(|| format!("{:?} needs {foreign:?}", instruction.code()))
}

fn uses_zmm(instruction: &Instruction) -> bool {
    let register =
        |operand| instruction.op_kind(operand) == OpKind::Register && instruction.op_register(operand).is_zmm();
    (0..instruction.op_count()).any(register)
}

/// Looks at this test, or at the executable that `MAKADAM_EXECUTABLE` names: the one of `scripts/build-xeon-phi`.
#[test]
fn kernels_need_only_what_a_xeon_phi_has() {
    // Named here, a step is linked into this test, and with it every kernel.
    std::hint::black_box(makadam::Simulation::step as fn(&mut makadam::Simulation) -> _);
    let functions = match std::env::var_os("MAKADAM_EXECUTABLE").map(PathBuf::from) {
        Some(path) => functions_of(&std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))),
        None => own_functions(),
    };
    let kernels: Vec<_> = functions.iter().filter(|function| function.is_kernel()).collect();
    // Sweeps of four sorts, two sorts of start, detection and set-up.
    assert!(kernels.len() >= 10, "only {} kernels were found", kernels.len());
    let has = |mnemonic: &str| {
        let all = kernels.iter().flat_map(|kernel| &kernel.instructions);
        all.filter(|instruction| uses_zmm(instruction)).any(|instruction| name(*instruction) == mnemonic)
    };
    for mnemonic in ["vmulpd", "vdivpd", "vsqrtpd", "vmaxpd", "vpermt2pd"] {
        assert!(has(mnemonic), "no 512-bit {mnemonic} in any kernel");
    }
    // Whatever is not inlined into a kernel is looked at too: all of this crate's code.
    let objections: Vec<_> = functions
        .iter()
        .flat_map(|function| {
            let all = function.instructions.iter().filter_map(objection).collect::<BTreeSet<_>>();
            all.into_iter().map(|objection| format!("{}: {objection}", function.symbol))
        })
        .collect();
    assert!(objections.is_empty(), "{}", objections.join("\n"));
}

#[test]
fn instructions_of_other_extensions_are_rejected() {
    let decoded = |code: &[u8]| Decoder::new(64, code, DecoderOptions::NONE).decode();
    let objection_to = |code: &[u8]| objection(&decoded(code));
    let foreign: [(&str, &str, &[u8]); 8] = [
        ("vxorpd zmm0, zmm1, zmm2", "AVX512DQ", &[0x62, 0xf1, 0xf5, 0x48, 0x57, 0xc2]),
        ("vpaddw zmm0, zmm1, zmm2", "AVX512BW", &[0x62, 0xf1, 0x75, 0x48, 0xfd, 0xc2]),
        ("vaddpd ymm16, ymm1, ymm2", "AVX512VL", &[0x62, 0xe1, 0xf5, 0x28, 0x58, 0xc2]),
        ("kmovb eax, k1", "AVX512DQ", &[0xc5, 0xf9, 0x93, 0xc1]),
        ("kmovd eax, k1", "AVX512BW", &[0xc5, 0xfb, 0x93, 0xc1]),
        ("vrcp28pd zmm0, zmm1", "AVX512ER", &[0x62, 0xf2, 0xfd, 0x48, 0xca, 0xc1]),
        ("vfmadd231pd ymm0, ymm1, ymm2", "fused", &[0xc4, 0xe2, 0xf5, 0xb8, 0xc2]),
        ("vfmadd231pd zmm0, zmm1, zmm2", "fused", &[0x62, 0xf2, 0xf5, 0x48, 0xb8, 0xc2]),
    ];
    for (text, why, code) in foreign {
        let objection = objection_to(code).unwrap_or_else(|| panic!("{text} was let through"));
        assert!(objection.contains(why), "{text}: {objection}");
    }
    let allowed: [(&str, &[u8]); 5] = [
        ("vaddpd zmm0, zmm1, zmm2", &[0x62, 0xf1, 0xf5, 0x48, 0x58, 0xc2]),
        ("vpxorq zmm0, zmm1, zmm2", &[0x62, 0xf1, 0xf5, 0x48, 0xef, 0xc2]),
        ("vplzcntq zmm0, zmm1", &[0x62, 0xf2, 0xfd, 0x48, 0x44, 0xc1]),
        ("kmovw eax, k1", &[0xc5, 0xf8, 0x93, 0xc1]),
        ("vaddpd ymm0, ymm1, ymm2", &[0xc5, 0xf5, 0x58, 0xc2]),
    ];
    for (text, code) in allowed {
        assert_eq!(objection_to(code), None, "{text}");
    }
    assert!(uses_zmm(&decoded(&[0x62, 0xf1, 0xf5, 0x48, 0x58, 0xc2])));
    assert_ne!(decoded(&[0xc5, 0xf5, 0x58, 0xc2]).op_register(0), Register::ZMM0);
}
