//! Suggestions for a name that is not known.

/// The known names that are close to a word, the closest first, at most `most`; none where none is close.
///
/// A name is close if at most a third of the word's letters must be added, dropped, changed or swapped with a neighbour, or if one
/// of both is a run of whole parts of the other, as `below` is of `share_below_mean`. Hyphens and underscores, and capitals and small
/// letters, count as the same.
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>, most: usize) -> Vec<&'a str> {
    let word = plain(word);
    let letters = letters_of(&word);
    let mut ranked: Vec<(usize, &str)> = known
        .into_iter()
        .filter_map(|name| {
            let plain = plain(name);
            let slips = match is_part(&word, &plain) || is_part(&plain, &word) {
                true => 0,
                false => edits(&letters, &letters_of(&plain)),
            };
            (3 * slips <= letters.len()).then_some((slips, name))
        })
        .collect();
    ranked.sort();
    ranked.dedup();
    ranked.into_iter().take(most).map(|(_, name)| name).collect()
}

/// `did you mean a, b or c?`, or `otherwise` where no known name is close to the word.
pub fn suggestion<'a>(word: &str, known: impl IntoIterator<Item = &'a str>, otherwise: &str) -> String {
    const MOST: usize = 3;
    match nearest(word, known, MOST)[..] {
        [] => otherwise.into(),
        [only] => format!("did you mean {only}?"),
        [ref others @ .., last] => format!("did you mean {} or {last}?", others.join(", ")),
    }
}

fn plain(name: &str) -> String {
    name.to_lowercase().replace('_', "-")
}

/// Letters of a name without the hyphens between its parts.
fn letters_of(name: &str) -> Vec<char> {
    name.chars().filter(|letter| *letter != '-').collect()
}

/// Returns true if one name is a run of whole parts, between hyphens, of another one.
fn is_part(part: &str, name: &str) -> bool {
    !part.is_empty() && format!("-{name}-").contains(&format!("-{part}-"))
}

/// Letters to add, drop, change or swap with a neighbour (optimal string alignment).
fn edits(word: &[char], name: &[char]) -> usize {
    let mut table = vec![vec![0; name.len() + 1]; word.len() + 1];
    for (row, line) in table.iter_mut().enumerate() {
        line[0] = row;
    }
    for (column, cell) in table[0].iter_mut().enumerate() {
        *cell = column;
    }
    for row in 1..=word.len() {
        for column in 1..=name.len() {
            let changed = table[row - 1][column - 1] + usize::from(word[row - 1] != name[column - 1]);
            let mut least = changed.min(table[row - 1][column] + 1).min(table[row][column - 1] + 1);
            let swapped =
                row > 1 && column > 1 && word[row - 1] == name[column - 2] && word[row - 2] == name[column - 1];
            if swapped {
                least = least.min(table[row - 2][column - 2] + 1);
            }
            table[row][column] = least;
        }
    }
    table[word.len()][name.len()]
}

#[cfg(test)]
mod tests {
    use super::{nearest, suggestion};

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
}
