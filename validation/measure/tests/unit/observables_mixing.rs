//! Unit tests of `src/observables/mixing.rs`.

use super::lacey_index;

/// Marks on a cube of 12 x 12 x 12 grains a unit apart.
fn index(mark: impl Fn([i64; 3]) -> bool) -> Option<f64> {
    let places = (0..1728).map(|n| [n % 12, n / 12 % 12, n / 144]);
    lacey_index(places.map(|at| (at.map(|x| x as f64 + 0.5), mark(at))), 3.0)
}

#[test]
fn halves_are_unmixed_and_chessboards_better_than_random() {
    assert!(index(|[x, ..]| x < 6).unwrap().abs() < 1e-12, "no cell holds both kinds");
    let chess = index(|[x, y, z]| (x + y + z) % 2 == 0).unwrap();
    assert!(chess > 1.0, "every cell holds both alike, which chance does not do: {chess}");
}

#[test]
fn random_marks_have_an_index_of_one() {
    // A generator good enough to have no pattern in cells of 27.
    let hash =
        |[x, y, z]: [i64; 3]| ((x * 73_856_093) ^ (y * 19_349_663) ^ (z * 83_492_791)).wrapping_mul(2_654_435_761);
    let random = index(|at| (hash(at) >> 13) % 10 < 4).unwrap();
    assert!((random - 1.0).abs() < 0.03, "{random}");
}

#[test]
fn too_few_grains_have_none() {
    assert_eq!(lacey_index([([0.0; 3], true), ([1.0; 3], false)].into_iter(), 3.0), None);
}
