//! Every operation gives the same bits on every instruction set.

use crate::common::{Setup, grain};
use makadam::SettingError;
use makadam::lanes::{Eight, InstructionSet, Kernel, Lanes, Line, Octet, Quad, SingleLanes, Sixteen};

/// Kernels take nothing but `Available`, so what these refuse to make cannot be run. Processors that lack a set, valgrind's among them,
/// see the refusal.
#[test]
fn instruction_sets_that_are_missing_are_refused() {
    let body = grain(0.01, [0.0; 3], [0.0; 3]);
    let mut simulation = Setup { body, ..Setup::default() }.start();
    let mut available = InstructionSet::ALL.into_iter().filter(|set| set.is_available());
    assert_eq!(Some(InstructionSet::detect()), available.next_back(), "the widest of those that are there");
    assert_eq!(simulation.instruction_set(), InstructionSet::detect());
    assert!(InstructionSet::Generic.is_available());
    for set in InstructionSet::ALL {
        let before = simulation.instruction_set();
        assert_eq!(set.on_this_processor().map(|one| one.name()), set.is_available().then_some(set));
        match simulation.use_instruction_set(set) {
            Ok(()) => assert!(set.is_available() && simulation.instruction_set() == set),
            Err(error) => {
                assert!(!set.is_available());
                assert!(matches!(error, SettingError::NoInstructionSet { wanted, .. } if wanted == set), "{error}");
                assert!(error.to_string().starts_with(&format!("this processor has no {}", set.name())), "{error}");
                assert_eq!(simulation.instruction_set(), before, "what was refused changes nothing");
            }
        }
        simulation.step();
    }
}

const VALUES: [f64; 8] = [1.5, -0.0, 0.0, -2.25, 1e-310, f64::INFINITY, f64::NAN, 3.0];
const OTHERS: [f64; 8] = [0.1, 0.0, -0.0, -2.25, 7.0, 2.0, 1.0, -4.0];

struct Operations<'a> {
    results: &'a mut Vec<Eight>,
    singles: &'a mut Vec<Sixteen>,
    bits: &'a mut Vec<u32>,
}

/// The values, then the values negated.
fn sixteen(values: [f64; 8]) -> Sixteen {
    Sixteen(std::array::from_fn(|lane| values[lane % 8] as f32 * if lane < 8 { 1.0 } else { -1.0 }))
}

/// Every operation in single precision.
#[inline(always)]
fn single_operations<S: SingleLanes>(results: &mut Vec<Sixteen>) {
    let (a, b) = (S::load(&sixteen(VALUES)), S::load(&sixteen(OTHERS)));
    let masks = [a.below(b), a.at_most(b), !a.below(b), a.at_most(b) & !a.below(b)];
    let values = [a + b, a - b, a * b, a / b, -a, a.abs().sqrt(), a.larger(b), a.smaller(b), S::splat(0.1)];
    let selected = masks.map(|mask| S::select(mask, a, b));
    let mut put = |value: S| {
        let mut out = Sixteen::default();
        value.store(&mut out);
        results.push(out);
    };
    values.into_iter().chain(selected).for_each(&mut put);
    let mut records: Vec<Octet> = (0..40).map(|i| Octet(std::array::from_fn(|part| (8 * i + part) as f32))).collect();
    let indices = [3, 0, 17, 12, 5, 6, 19, 1, 39, 21, 33, 30, 22, 27, 35, 8];
    // SAFETY: all indices are below 40, and the vector is this function's own.
    unsafe {
        let octets = S::load_octets(records.as_ptr(), &indices);
        octets.into_iter().for_each(&mut put);
        S::store_octets(records.as_mut_ptr(), &indices, octets.map(|part| part + part));
    }
    for pair in records.chunks_exact(2) {
        let both: Vec<f32> = pair.iter().flat_map(|octet| octet.0).collect();
        results.push(Sixteen(both.try_into().expect("two octets are sixteen numbers")));
    }
}

/// Operations of lanes on records of two bodies each.
#[inline(always)]
fn line_operations<L: Lanes>(results: &mut Vec<Eight>) {
    let line =
        |i: usize| Line([0, 1].map(|half| Quad(std::array::from_fn(|part| (8 * i + 4 * half + part) as f64 + 0.1))));
    let mut lines: Vec<Line> = (0..24).map(line).collect();
    let (first, second) = ([3, 0, 17, 12, 5, 6, 19, 1], [22, 2, 16, 9, 7, 11, 23, 20]);
    let mut put = |value: L| {
        let mut out = Eight::default();
        value.store(&mut out);
        results.push(out);
    };
    // SAFETY: all indices are below 24, and the vector is this function's own.
    unsafe {
        let [motion, turning] = L::load_pairs(lines.as_ptr(), &first, &second);
        let half = L::load_differences::<2>(lines.as_ptr().cast(), &first, &second);
        motion.into_iter().chain(turning).chain(half).for_each(&mut put);
        let [shares, others] = [motion, turning].map(|[x, y, z, _]| [x, y, z]);
        L::add_shares::<true>(lines.as_mut_ptr(), &first, [shares, others], [-1.0, -2.5]);
        L::add_shares::<false>(lines.as_mut_ptr(), &second, [shares, others], [1.0, -2.5]);
    }
    let eight = |Line([motion, turning]): &Line| {
        let both: Vec<f64> = motion.0.into_iter().chain(turning.0).collect();
        Eight(both.try_into().expect("a line is eight numbers"))
    };
    results.extend(lines.iter().map(eight));
    // First halves alone: of lines that are kept, and by way of memory.
    for keeps in [true, false] {
        let mut lines: Vec<Line> = (0..24).map(line).collect();
        // SAFETY: as above.
        unsafe {
            let (differences, kept) = L::load_keeping(lines.as_ptr(), &first, &second);
            let share = [differences[0], differences[1], differences[2]];
            for (places, kept, sign) in [(&first, kept[0], -1.0), (&second, kept[1], 1.0)] {
                if keeps {
                    L::add_to_kept(lines.as_mut_ptr(), places, kept, share, sign);
                } else {
                    L::add_shares::<false>(lines.as_mut_ptr(), places, [share; 2], [sign, 0.0]);
                }
            }
        }
        results.extend(lines.iter().map(eight));
    }
    // Whole lines, read and written: each doubles.
    let mut lines: Vec<Line> = (0..24).map(line).collect();
    // SAFETY: as above.
    unsafe {
        let halves = L::load_lines(lines.as_ptr(), &first);
        L::store_lines(lines.as_mut_ptr(), &first, halves.map(|half| half.map(|part| part + part)));
    }
    results.extend(lines.iter().map(eight));
}

impl Kernel for Operations<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let (a, b) = (L::load(&Eight(VALUES)), L::load(&Eight(OTHERS)));
        let masks = [a.below(b), a.at_most(b), !a.below(b), a.at_most(b) & !a.below(b)];
        self.bits.extend(masks.map(L::bits));
        let values = [a + b, a - b, a * b, a / b, -a, a.abs().sqrt(), a.larger(b), a.smaller(b), L::splat(0.1)];
        let selected = masks.map(|mask| L::select(mask, a, b));
        for value in values.into_iter().chain(selected) {
            let mut out = Eight::default();
            value.store(&mut out);
            self.results.push(out);
        }
        let mut records: Vec<Quad> = (0..40).map(|i| Quad(std::array::from_fn(|part| (4 * i + part) as f64))).collect();
        let indices = [3, 0, 17, 12, 5, 6, 19, 1];
        // SAFETY: 2 * 19 < 40, and the vector is this function's own.
        unsafe {
            let quads = L::load_quads::<2>(records.as_ptr(), &indices);
            for part in quads {
                let mut out = Eight::default();
                part.store(&mut out);
                self.results.push(out);
            }
            let doubled = quads.map(|part| part + part);
            L::store_quads::<2>(records.as_mut_ptr(), &indices, doubled);
        }
        for pair in records.chunks_exact(2) {
            let both: Vec<f64> = pair.iter().flat_map(|quad| quad.0).collect();
            self.results.push(Eight(both.try_into().expect("two quads are eight numbers")));
        }
        let (some, others) = ([&[1, 2, 3, 4, 5, 6, 7, 8], &[9; 8]], [&[11, 12, 13, 14, 15, 16, 17, 18], &[8; 8]]);
        let (far, met) = ([&[20; 8], &[21, 22, 23, 24, 25, 26, 27, 28]], L::share_places(some, others, 9));
        self.bits.extend(
            [met, L::share_places(others, some, 8), L::share_places(some, far, 30), L::share_places(far, far, 21)]
                .map(u32::from),
        );
        line_operations::<L>(self.results);
        single_operations::<L::Single>(self.singles);
    }
}

#[test]
fn instruction_sets_agree_on_every_operation() {
    let run = |set: InstructionSet| {
        let set = set.on_this_processor().expect("it was asked for");
        let (mut results, mut singles, mut bits) = (Vec::new(), Vec::new(), Vec::new());
        set.run(Operations { results: &mut results, singles: &mut singles, bits: &mut bits });
        // Every NaN is as good as any other: IEEE leaves their payload open.
        let plain = |x: f64| if x.is_nan() { u64::MAX } else { x.to_bits() };
        let singles: Vec<_> = singles.iter().map(|sixteen| sixteen.0.map(|x| plain(x.into()))).collect();
        (results.iter().map(|eight| eight.0.map(plain)).collect::<Vec<_>>(), bits, singles)
    };
    let generic = run(InstructionSet::Generic);
    assert_eq!(generic.1[0], 0b0001_0000, "only 1e-310 is below its partner");
    assert_eq!(generic.1[4..], [1, 0, 0, 1], "8 is in both, but not below 8; 20 is in both and below 21");
    assert_eq!(generic.0[13][2], 136_f64.to_bits(), "first number of quad 2 * 17");
    // Behind 37 results of other operations: four of each half, four of first halves alone, then the lines.
    let (pairs, lines) = (&generic.0[37..49], &generic.0[49..73]);
    assert_eq!(pairs[0][0], ((8.0 * 22.0 + 0.1) - (8.0 * 3.0 + 0.1_f64)).to_bits(), "first numbers: second less first");
    assert_eq!(pairs[3][1], ((8.0 * 2.0 + 3.0 + 0.1) + (3.0 + 0.1_f64)).to_bits(), "fourth numbers: both");
    assert_eq!(pairs[8..], pairs[..4], "halves alone");
    let (own, turning) = (8.0 * 3.0 + 3.0 + 0.1_f64, (8.0 * 22.0 + 4.0 + 0.1) + (8.0 * 3.0 + 4.0 + 0.1_f64));
    assert_eq!(
        lines[3][4],
        ((8.0 * 3.0 + 4.0 + 0.1) + turning * (own * -2.5)).to_bits(),
        "a share by the line's own fourth number"
    );
    assert_eq!(generic.0[73..97], generic.0[97..121], "lines that were kept");
    let doubled = generic.0[121 + 3].map(f64::from_bits);
    assert_eq!(doubled, std::array::from_fn(|part| 2.0 * (8.0 * 3.0 + part as f64 + 0.1)), "line 3, doubled");
    assert_eq!(generic.0[121 + 4][7], (8.0 * 4.0 + 7.0 + 0.1_f64).to_bits(), "a line that is not written");
    assert_eq!(lines[22][4], (8.0 * 22.0 + 4.0 + 0.1_f64).to_bits(), "a half that is left as it was");
    assert_eq!(generic.2[13][2], 136_f64.to_bits(), "first number of octet 17");
    assert_eq!(generic.2[20][15], (8.0 * 8.0 + 7.0_f64).to_bits(), "last number of octet 8");
    for set in InstructionSet::ALL.into_iter().filter(|set| set.is_available()) {
        assert_eq!(run(set), generic, "{set:?}");
    }
}
