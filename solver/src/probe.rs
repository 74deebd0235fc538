//! Single phases of a step, and what the processor delivers at best: for benches and rooflines, not for simulating.
//!
//! A phase is repeated on the state that the last step left, and time stands still. Work on a clone: a simulation that was
//! probed no longer takes the steps that it would have taken.

use crate::Simulation;
use crate::effects::EffectSet;
use crate::lanes::{Available, Eight, InstructionSet, Kernel, Lanes};
use crate::partition::TaskGroups;
use crate::scene::Precision;
use crate::sweep::{ResidualLevel, SweepBytes, SweepOperands, SweepPass, start_driven};
use crate::world::Body;
use std::hint::black_box;

impl Simulation {
    /// Bytes of a sweep over the contacts of the last step.
    pub fn sweep_bytes(&self) -> SweepBytes {
        let effects = self.effects();
        let bodies = self.world.grains() * size_of::<Body>();
        let groups = |of: fn(&TaskGroups) -> usize| self.layout.tasks().map(|(_, task)| of(task)).sum();
        let (pairs, walls): (usize, usize) = (groups(|task| task.pairs.len()), groups(|task| task.walls.len()));
        let read = pairs * effects.bytes_of_pairs() + walls * effects.bytes_of_walls();
        let written = (pairs + walls) * effects.bytes_written();
        SweepBytes { touched: read + bodies, moved: read + written + 2 * bodies }
    }

    /// Builds the candidate list anew, whether it is stale or not. What was laid out before is gone: [`Self::constrain_once`]
    /// comes before the next sweep.
    pub fn detect_once(&mut self) {
        let (set, team) = (self.relaxation.instruction_set, self.team.here());
        // The groups name bodies by places that are about to change.
        self.layout.contacts = 0;
        for groups in &mut self.layout.groups {
            groups.empty(self.relaxation.effects);
        }
        team.enter(|| self.candidates.rebuild(&mut self.world, &mut self.layout, set, &team));
    }

    /// Whether the candidate list is stale: what a step asks first.
    pub fn is_stale_once(&mut self) -> bool {
        let team = self.team.here();
        team.enter(|| self.candidates.are_stale(&self.world, &team))
    }

    /// Lays out the contacts of the present positions as constraints and gives bodies the impulses of the last step to start
    /// from; repeated, they receive these again and again. Returns the number of contacts.
    pub fn constrain_once(&mut self) -> usize {
        let team = self.team.here();
        if self.steps == 0 {
            // A first step does this before.
            self.detect_once();
        }
        team.enter(|| {
            self.apply_gravity(0.0, &team);
            self.constrain(&team);
            start_driven(&self.layout, &mut self.world.drives);
        });
        self.layout.contacts
    }

    /// Compiles in other effects than the scene calls for, to see what they cost; coefficients that the scene does not name are
    /// zero. [`Self::constrain_once`] comes before the next sweep.
    pub fn compile_effects(&mut self, effects: EffectSet) {
        self.relaxation.effects = effects;
        self.constrainer.compile_effects(effects);
        self.candidates.bear_torques(effects.torques());
        self.layout.contacts = 0;
        for groups in &mut self.layout.groups {
            groups.empty(effects);
        }
    }

    /// Relaxes the contacts that are laid out so many times, without over-relaxation and without measuring residuals. Returns
    /// the number of contact sweeps.
    pub fn sweep_times(&mut self, sweeps: u32) -> u64 {
        let team = self.team.here();
        let Simulation { world, layout, solver, relaxation, settings, .. } = self;
        let (single, mut nowhere) = (&mut solver.workspace.single, Vec::new());
        team.enter(|| {
            if settings.precision == Precision::Single {
                single.take(&world.bodies, layout, relaxation.instruction_set, &team);
            }
            for _ in 0..sweeps {
                let operands = match settings.precision {
                    Precision::Double => {
                        SweepOperands::Double { bodies: &mut world.bodies, groups: &mut layout.groups }
                    }
                    Precision::Single => SweepOperands::Single(single),
                };
                let pass = SweepPass { factor: 1.0, inner: 1, stops: || false, level: ResidualLevel::Off };
                relaxation.sweep_all(&layout.plan, operands, &pass, &mut nowhere, &team);
                if !world.drives.is_empty() {
                    relaxation.sweep_driven(&mut world.bodies, layout, &mut world.drives, 1.0, ResidualLevel::Off);
                }
            }
        });
        u64::from(sweeps) * self.layout.contacts as u64
    }
}

/// Most chains that [`multiply_and_add`] can be asked for.
pub const MOST_CHAINS: usize = 6;

/// Multiplies and adds in registers, without memory: `chains` chains of eight multiplications and as many of eight
/// additions, each independent of the others, so many times. Returns the number of operations. A processor that works on
/// several at a time needs several chains; more chains than registers cost.
///
/// # Panics
/// This processor lacks the instruction set, or `chains` is 0 or above [`MOST_CHAINS`].
pub fn multiply_and_add(set: InstructionSet, chains: usize, times: u64) -> u64 {
    let set = available(set);
    let sum = match chains {
        1 => set.run(Arithmetic::<1> { times }),
        2 => set.run(Arithmetic::<2> { times }),
        3 => set.run(Arithmetic::<3> { times }),
        4 => set.run(Arithmetic::<4> { times }),
        5 => set.run(Arithmetic::<5> { times }),
        MOST_CHAINS => set.run(Arithmetic::<MOST_CHAINS> { times }),
        _ => panic!("1 to {MOST_CHAINS} chains, not {chains}"),
    };
    black_box(sum);
    times * 2 * chains as u64 * crate::lanes::LANES as u64
}

/// `a = b + s c`: the triad of the STREAM benchmark, on the shortest of the three.
///
/// # Panics
/// This processor lacks the instruction set.
pub fn triad(set: InstructionSet, a: &mut [Eight], b: &[Eight], c: &[Eight]) {
    let set = available(set);
    set.run(Triad { a, b, c });
}

/// `a = a + s b`: like a sweep it reads what it writes, so that memory carries these three streams and no other.
///
/// # Panics
/// This processor lacks the instruction set.
pub fn update(set: InstructionSet, a: &mut [Eight], b: &[Eight]) {
    let set = available(set);
    set.run(Update { a, b });
}

fn available(set: InstructionSet) -> Available {
    set.on_this_processor().unwrap_or_else(|| panic!("this processor has no {}", set.name()))
}

struct Arithmetic<const CHAINS: usize> {
    times: u64,
}

struct Triad<'a> {
    a: &'a mut [Eight],
    b: &'a [Eight],
    c: &'a [Eight],
}

struct Update<'a> {
    a: &'a mut [Eight],
    b: &'a [Eight],
}

impl<const CHAINS: usize> Kernel for Arithmetic<CHAINS> {
    type Output = Eight;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Eight {
        // Numbers that neither grow nor vanish, and that the compiler does not know.
        let (factor, summand) = (L::splat(black_box(1.0)), L::splat(black_box(1e-9)));
        let mut products: [L; CHAINS] = std::array::from_fn(|chain| L::splat(black_box(1.0 + chain as f64)));
        let mut sums = products;
        for _ in 0..self.times {
            for chain in 0..CHAINS {
                products[chain] = products[chain] * factor;
                sums[chain] = sums[chain] + summand;
            }
        }
        let mut out = Eight::default();
        (0..CHAINS).fold(L::zero(), |all, chain| all + products[chain] + sums[chain]).store(&mut out);
        out
    }
}

impl Kernel for Triad<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let factor = L::splat(3.0);
        for ((a, b), c) in self.a.iter_mut().zip(self.b).zip(self.c) {
            (L::load(b) + factor * L::load(c)).store(a);
        }
    }
}

impl Kernel for Update<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let factor = L::splat(1e-9);
        for (a, b) in self.a.iter_mut().zip(self.b) {
            (L::load(a) + factor * L::load(b)).store(a);
        }
    }
}
