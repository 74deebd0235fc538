//! Unit tests of `src/scene/suggestions.rs`.

use super::*;
use super::{nearest, suggestion};

#[test]
fn wishes_are_answered_with_a_way() {
    for (word, way) in
        [("mesh", "wall spheres"), ("Insert", "Simulation.insert"), ("time_step", "solver.step"), ("rpm", "0.10472")]
    {
        assert!(wish(word).is_some_and(|answer| answer.contains(way)), "{word}");
    }
    assert_eq!(wish("zzz"), None);
    assert_eq!(remedy("frcition", ["friction"]).unwrap(), "did you mean `friction`?");
}

#[test]
fn no_word_is_listed_twice() {
    let mut words: Vec<&str> = WISHES.iter().flat_map(|(words, _)| words.iter().copied()).collect();
    let number = words.len();
    words.sort_unstable();
    words.dedup();
    assert_eq!(words.len(), number);
}

#[test]
fn slips_find_the_intended_name() {
    let known = ["packing_fraction", "coordination_number", "gini", "share_below_mean"];
    assert_eq!(nearest("pakcing-fraction", known, 1), ["packing_fraction"]);
    assert_eq!(nearest("Gnii", known, 1), ["gini"]);
    assert_eq!(nearest("below", known, 1), ["share_below_mean"]);
    assert_eq!(nearest("drum-of-mine", ["drum", "heap"], 3), ["drum"]);
    assert_eq!(nearest("sizeratio", ["size-ratio-10", "stack"], 3), ["size-ratio-10"]);
    assert!(nearest("anything", [], 3).is_empty() && nearest("", known, 2).is_empty());
}

#[test]
fn other_words_have_no_suggestion() {
    let known = ["name", "seed", "gravity", "material", "wall", "grain", "solver", "drum"];
    for word in ["insert", "mesh", "rpm", "clump", "cube", "cone", "bond", "dog"] {
        assert!(nearest(word, known, 3).is_empty(), "{word}: {:?}", nearest(word, known, 3));
    }
    // A third of the letters is close, more is not.
    assert_eq!((nearest("gan", ["grain"], 1).len(), nearest("gra", ["gro"], 1).len()), (0, 1));
}

#[test]
fn suggestions_are_questions() {
    assert_eq!(suggestion("wal", ["wall", "grain"], "see the list"), "did you mean wall?");
    assert_eq!(suggestion("drumm", ["drum", "drums"], ""), "did you mean drum or drums?");
    assert_eq!(suggestion("mesh", ["wall"], "see the list"), "see the list");
}
