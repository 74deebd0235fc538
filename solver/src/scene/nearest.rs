//! Names that are near to one that is not known: what a message offers in its place.

/// The known names that are nearest to a word, the nearest first, at most so many.
///
/// Hyphens and underscores, and capitals and small letters, count as the same; a name that contains the word comes before those that
/// are merely spelt alike.
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>, most: usize) -> Vec<&'a str> {
    let word = plain(word);
    let mut ranked: Vec<(usize, &str)> =
        known.into_iter().map(|name| (distance_from(&word, &plain(name)), name)).collect();
    ranked.sort();
    ranked.dedup();
    ranked.into_iter().take(most).map(|(_, name)| name).collect()
}

fn plain(name: &str) -> Vec<char> {
    name.to_lowercase().replace('_', "-").chars().collect()
}

/// Letters to add, drop or change (Levenshtein); none where one contains the other.
fn distance_from(word: &[char], name: &[char]) -> usize {
    let holds =
        |long: &[char], short: &[char]| !short.is_empty() && long.windows(short.len()).any(|part| part == short);
    if holds(name, word) || holds(word, name) {
        return 0;
    }
    let mut row: Vec<usize> = (0..=name.len()).collect();
    for (place, letter) in word.iter().enumerate() {
        let mut diagonal = row[0];
        row[0] = place + 1;
        for (column, other) in name.iter().enumerate() {
            let changed = diagonal + usize::from(letter != other);
            diagonal = row[column + 1];
            row[column + 1] = changed.min(diagonal + 1).min(row[column] + 1);
        }
    }
    row[name.len()]
}

#[cfg(test)]
mod tests {
    use super::nearest;

    #[test]
    fn a_slip_finds_the_name_that_was_meant() {
        let known = ["packing_fraction", "coordination_number", "gini", "share_below_mean"];
        assert_eq!(nearest("pakcing-fraction", known, 1), ["packing_fraction"]);
        assert_eq!(nearest("Gnii", known, 1), ["gini"]);
        assert_eq!(nearest("below", known, 1), ["share_below_mean"]);
        assert_eq!(nearest("", known, 2).len(), 2);
        assert!(nearest("anything", [], 3).is_empty());
    }
}
