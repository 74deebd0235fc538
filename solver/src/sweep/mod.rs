//! One relaxation of a task's lane groups, in the same arithmetic on every instruction set.
//!
//! The kernel is written once, over [`Lanes`]; it is compiled for the baseline, for AVX2 and for AVX-512F, with and
//! without friction, and the best that the processor has is chosen once at start. All give the same bits.

mod kernel;
mod lanes;
mod residual;

pub use lanes::Lanes;
pub(crate) use residual::GroupResidual;
pub use residual::{Residual, Residuals};

use crate::partition::{PairGroup, WallGroup};
use crate::world::Body;
use serde::{Deserialize, Serialize};

/// Instruction set of the kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum InstructionSet {
    /// Whatever the build's target has.
    Generic,
    /// 256-bit registers.
    Avx2,
    /// 512-bit registers.
    Avx512,
}

impl InstructionSet {
    /// The widest that this processor has.
    pub fn detect() -> InstructionSet {
        [InstructionSet::Avx512, InstructionSet::Avx2]
            .into_iter()
            .find(|set| set.is_available())
            .unwrap_or(InstructionSet::Generic)
    }

    /// Whether this processor has it.
    pub fn is_available(self) -> bool {
        match self {
            InstructionSet::Generic => true,
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx2 => is_x86_feature_detected!("avx2"),
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx512 => is_x86_feature_detected!("avx512f"),
            #[cfg(not(target_arch = "x86_64"))]
            _ => false,
        }
    }
}

/// The relaxation that a scene calls for, on the instruction set that was chosen.
#[derive(Clone, Copy, Debug)]
pub struct Relaxation {
    /// Instruction set of the kernel.
    pub instruction_set: InstructionSet,
    /// Whether contacts have friction; without it bodies carry no spin through the sweep.
    pub friction: bool,
}

macro_rules! kernels {
    ($name:ident, $($feature:literal)?) => {
        $(#[target_feature(enable = $feature)])?
        fn $name<const FRICTION: bool, const MEASURE: bool>(
            bodies: &mut [Body],
            pairs: &mut [PairGroup],
            walls: &mut [WallGroup],
            factor: f64,
            residual: &mut GroupResidual,
        ) {
            kernel::sweep_pairs::<FRICTION, MEASURE>(bodies, pairs, factor, residual);
            kernel::sweep_walls::<FRICTION, MEASURE>(bodies, walls, factor, residual);
        }
    };
}
kernels!(sweep_generic,);
#[cfg(target_arch = "x86_64")]
kernels!(sweep_avx2, "avx2");
#[cfg(target_arch = "x86_64")]
kernels!(sweep_avx512, "avx512f");

impl Relaxation {
    /// Relaxes every group once, pairs first; adds to `residual` only if `measure`.
    pub(crate) fn sweep(
        &self,
        bodies: &mut [Body],
        pairs: &mut [PairGroup],
        walls: &mut [WallGroup],
        factor: f64,
        measure: bool,
        residual: &mut GroupResidual,
    ) {
        match (self.friction, measure) {
            (true, true) => self.dispatch::<true, true>(bodies, pairs, walls, factor, residual),
            (true, false) => self.dispatch::<true, false>(bodies, pairs, walls, factor, residual),
            (false, true) => self.dispatch::<false, true>(bodies, pairs, walls, factor, residual),
            (false, false) => self.dispatch::<false, false>(bodies, pairs, walls, factor, residual),
        }
    }

    fn dispatch<const FRICTION: bool, const MEASURE: bool>(
        &self,
        bodies: &mut [Body],
        pairs: &mut [PairGroup],
        walls: &mut [WallGroup],
        factor: f64,
        residual: &mut GroupResidual,
    ) {
        match self.instruction_set {
            // SAFETY: the set was found on this processor before it was chosen.
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx512 => unsafe {
                sweep_avx512::<FRICTION, MEASURE>(bodies, pairs, walls, factor, residual);
            },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx2 => unsafe {
                sweep_avx2::<FRICTION, MEASURE>(bodies, pairs, walls, factor, residual);
            },
            _ => sweep_generic::<FRICTION, MEASURE>(bodies, pairs, walls, factor, residual),
        }
    }

    /// Gives bodies the impulses that their contacts start from.
    pub(crate) fn warm_start(&self, bodies: &mut [Body], pairs: &[PairGroup], walls: &[WallGroup]) {
        if self.friction {
            kernel::apply_pairs::<true>(bodies, pairs);
            kernel::apply_walls::<true>(bodies, walls);
        } else {
            kernel::apply_pairs::<false>(bodies, pairs);
            kernel::apply_walls::<false>(bodies, walls);
        }
    }
}
