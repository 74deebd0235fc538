//! Suggestions for unknown names.

use crate::common::parse;
use makadam::scene::{nearest, suggestion, wish};

#[test]
fn known_wishes_have_an_answer() {
    for (word, way) in
        [("mesh", "CAD file"), ("Insert", "[[insert]]"), ("time_step", "solver.step"), ("rpm", "0.10472")]
    {
        assert!(wish(word).is_some_and(|answer| answer.contains(way)), "{word}");
    }
    assert_eq!(wish("zzz"), None);
}

/// A key of the scene is spelt better, or its wish is answered.
#[test]
fn unknown_keys_get_a_remedy() {
    for (line, remedy) in [("gravty = 1", "did you mean `gravity`?"), ("rpm = 1", "0.10472")] {
        let message = parse(line).unwrap_err();
        assert!(message.contains(remedy), "{message}");
    }
}

/// The second answer to a word would never be given.
#[test]
fn no_wish_is_listed_twice() {
    let source = include_str!("../src/scene/suggestions.rs");
    let table = source.split("const WISHES").nth(1).and_then(|rest| rest.split("\n];").next()).unwrap();
    let rows = table.lines().filter_map(|line| line.trim().strip_prefix('"')?.split_once(": "));
    let mut words: Vec<&str> = rows.flat_map(|(words, _)| words.split(' ')).collect();
    let number = words.len();
    assert!(number > 80 && words.iter().all(|word| wish(word).is_some()), "{words:?}");
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
