//! Readers of bytes from outside accept or refuse any bytes; none panics, hangs, or asks for memory without bound.
//!
//! The long run: `MAKADAM_FUZZ_INPUTS=1000000 cargo test --test readers -- --ignored --nocapture`, of all readers or of those
//! that `MAKADAM_FUZZ_READERS` names (with commas between), from `MAKADAM_FUZZ_FIRST` on.

#[path = "support/readers/mod.rs"]
mod readers;

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use readers::damage::{damage, input};
use readers::{READERS, Reader};
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// No reader of a document of at most 64 kB has a use for as much in one piece, bytes.
const LARGEST_PIECE: usize = 1 << 28;

/// Time after which an input counts as a hang.
const PATIENCE: Duration = Duration::from_secs(60);

/// The system's allocator, which gives no more than [`LARGEST_PIECE`]: asking for more ends the test.
struct Bounded;

// SAFETY: the system's allocator does the work, or nothing is allocated.
unsafe impl GlobalAlloc for Bounded {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        match layout.size() <= LARGEST_PIECE {
            // SAFETY: the caller's promise.
            true => unsafe { System.alloc(layout) },
            false => std::ptr::null_mut(),
        }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise.
        unsafe { System.dealloc(place, layout) }
    }

    unsafe fn realloc(&self, place: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        match size <= LARGEST_PIECE {
            // SAFETY: the caller's promise.
            true => unsafe { System.realloc(place, layout, size) },
            false => std::ptr::null_mut(),
        }
    }
}

#[global_allocator]
static ALLOCATOR: Bounded = Bounded;

#[test]
fn sound_documents_are_accepted() {
    for reader in &READERS {
        for document in (reader.documents)() {
            assert!((reader.read)(&document), "{} refuses {}", reader.name, String::from_utf8_lossy(&document));
        }
    }
}

/// A sound document of a reader with a piece changed.
fn changed(name: &str, from: &str, to: &str) -> Vec<u8> {
    let text = String::from_utf8((readers::named(name).documents)().swap_remove(0)).unwrap();
    assert!(text.contains(from), "no {from} in {text}");
    text.replace(from, to).into_bytes()
}

#[test]
fn numbers_that_are_none_are_refused_wherever_they_stand() {
    let refuses = |name: &str, bytes: Vec<u8>| assert!(!(readers::named(name).read)(&bytes), "{name} accepts it");
    refuses("reference", changed("reference", ",12.5,1.5,a processor", ",inf,1.5,a processor"));
    refuses("reference", changed("reference", "YADE,1,angle,0.5,31.5", "YADE,1,angle,0.5,NaN"));
    refuses("reference", changed("reference", "0,0.005,0.1", "0,0.005,-inf"));
    refuses("yade_result", changed("yade_result", "12.5", "-12.5"));
    refuses("liggghts_log", changed("liggghts_log", "Loop time of 12.5", "Loop time of inf"));
    refuses("lammps_log", changed("lammps_log", "Loop time of 12.5", "Loop time of inf"));
    // Forces that are finite in the file, and not in sums and products.
    let mut frames = (readers::named("yade_frames").documents)().swap_remove(0);
    let one = 1.0_f64.to_le_bytes();
    for place in (0..frames.len()).step_by(8).filter(|place| place / 8 > 66) {
        if frames[place..place + 8] == one {
            frames[place..place + 8].copy_from_slice(&1e300_f64.to_le_bytes());
        }
    }
    refuses("yade_frames", frames);
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, rng_seed: RngSeed::Fixed(1), ..ProptestConfig::with_cases(256) })]

    #[test]
    fn arbitrary_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..600)) {
        for reader in &READERS {
            (reader.read)(&bytes);
        }
    }

    #[test]
    fn damaged_documents_are_read_or_refused(which in any::<u64>(), edits in prop::collection::vec(any::<u64>(), 1..7)) {
        for reader in &READERS {
            let documents = (reader.documents)();
            let mut bytes = documents[which as usize % documents.len()].clone();
            edits.iter().for_each(|&edit| damage(&mut bytes, &documents, edit));
            (reader.read)(&bytes);
        }
    }
}

/// Reads the inputs of these numbers; returns how many were accepted, and the longest time that one took.
fn run(reader: &Reader, numbers: std::ops::Range<u64>) -> (u64, Duration) {
    let documents = (reader.documents)();
    let at = AtomicU64::new(numbers.start);
    let done = AtomicU64::new(0);
    let (mut accepted, mut longest) = (0, Duration::ZERO);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let (mut last, mut since) = (u64::MAX, Instant::now());
            while done.load(Ordering::Relaxed) == 0 {
                std::thread::sleep(Duration::from_millis(20));
                let now = at.load(Ordering::Relaxed);
                if now != last {
                    (last, since) = (now, Instant::now());
                } else if since.elapsed() > PATIENCE {
                    eprintln!("{}: input {now} takes more than {PATIENCE:?}", reader.name);
                    std::process::abort();
                }
            }
        });
        let read = || {
            for number in numbers {
                at.store(number, Ordering::Relaxed);
                let bytes = input(&documents, number);
                let start = Instant::now();
                accepted += u64::from((reader.read)(&bytes));
                longest = longest.max(start.elapsed());
            }
        };
        let outcome = std::panic::catch_unwind(std::panic::AssertUnwindSafe(read));
        done.store(1, Ordering::Relaxed);
        if let Err(panic) = outcome {
            let number = at.load(Ordering::Relaxed);
            eprintln!("{}: input {number}:\n{}", reader.name, String::from_utf8_lossy(&input(&documents, number)));
            std::panic::resume_unwind(panic);
        }
    });
    (accepted, longest)
}

#[test]
#[ignore = "takes as long as MAKADAM_FUZZ_INPUTS says"]
fn many_inputs_are_read_or_refused() {
    let number = |name: &str, otherwise: u64| match std::env::var(name) {
        Ok(text) => text.parse().unwrap_or_else(|_| panic!("{name} is no number")),
        Err(_) => otherwise,
    };
    let (first, inputs) = (number("MAKADAM_FUZZ_FIRST", 0), number("MAKADAM_FUZZ_INPUTS", 100_000));
    let chosen = std::env::var("MAKADAM_FUZZ_READERS").unwrap_or_default();
    let is_chosen = |reader: &&Reader| chosen.is_empty() || chosen.split(',').any(|name| name == reader.name);
    for reader in READERS.iter().filter(is_chosen) {
        let start = Instant::now();
        let (accepted, longest) = run(reader, first..first + inputs);
        let seconds = start.elapsed().as_secs_f64();
        println!(
            "{}: {inputs} inputs, {accepted} accepted, {:.0} a second, longest {longest:?}",
            reader.name,
            inputs as f64 / seconds
        );
        assert!(accepted > 0, "{}: damage that nothing survives tests little", reader.name);
    }
}
