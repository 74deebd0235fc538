//! What the numbers in the names of files say of their order. A point between digits stands before decimals (`f_0.15.csv`) or between two
//! numbers (`wall1.2000.vtk`): an order is taken only where both ways to read it agree, or the digits allow but one.

use super::frame_table::ImportError;
use std::collections::BTreeSet;
use std::path::Path;

/// What may stand before decimals.
const POINTS: [char; 3] = ['.', ',', 'p'];

/// Digits without leading zeros behind their count, and decimals without trailing zeros: in the order of values.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Number {
    size: (usize, String),
    decimals: String,
}

impl Number {
    fn new(digits: &str, decimals: &str) -> Number {
        let digits = digits.trim_start_matches('0');
        let size = (digits.len(), digits.to_string());
        Number { size, decimals: decimals.trim_end_matches('0').to_string() }
    }

    fn value(&self) -> f64 {
        format!("0{}.{}0", self.size.1, self.decimals).parse().unwrap_or(f64::NAN)
    }
}

/// A path with `#` in place of each run of digits and points, and the digits between the points of each.
struct Name {
    text: String,
    runs: Vec<Vec<String>>,
}

impl Name {
    fn of(path: &Path) -> Name {
        let digits = |text: &str| text.find(|letter: char| !letter.is_ascii_digit()).unwrap_or(text.len());
        let (mut text, mut runs) = (String::new(), Vec::new());
        let name = path.to_string_lossy();
        let mut rest = &name[..];
        while let Some(start) = rest.find(|letter: char| letter.is_ascii_digit()) {
            text += &rest[..start];
            text.push('#');
            rest = &rest[start..];
            let mut groups = Vec::new();
            loop {
                let (group, after) = rest.split_at(digits(rest));
                groups.push(group.to_string());
                rest = after;
                match rest.strip_prefix(POINTS).filter(|after| digits(after) > 0) {
                    Some(after) => rest = after,
                    None => break,
                }
            }
            runs.push(groups);
        }
        Name { text: text + rest, runs }
    }
}

/// A path with `#` in place of each number.
pub(super) fn pattern(path: &Path) -> String {
    Name::of(path).text
}

/// Whether a path has a number with a point.
pub(super) fn has_points(path: &Path) -> bool {
    Name::of(path).runs.iter().any(|groups| groups.len() > 1)
}

/// All digits in a path, number after number.
pub(super) fn all_digits(path: &Path) -> Vec<String> {
    Name::of(path).runs.concat()
}

/// Runs as counts, which differ in one group of digits alone. None where a filling with zeros says that they are none, or where decimals and
/// one more number may follow one another.
fn as_counts(runs: &[&Vec<String>]) -> Option<Vec<Number>> {
    let groups = runs[0].len();
    if runs.iter().any(|run| run.len() != groups) {
        return None;
    }
    let mut differing = (0..groups).filter(|place| runs.iter().any(|run| run[*place] != runs[0][*place]));
    let (place, None) = (differing.next()?, differing.next()) else { return None };
    let all: Vec<&String> = runs.iter().map(|run| &run[place]).collect();
    // What is filled with zeros to some width has none before where it is wider.
    let width = all.iter().map(|digits| digits.len()).min()?;
    let is_filled = all.iter().all(|digits| digits.len() == width || !digits.starts_with('0'));
    let is_between = place > 0 && place + 1 < groups;
    (place == 0 || is_filled && !is_between).then(|| all.iter().map(|digits| Number::new(digits, "")).collect())
}

/// Runs as numbers with decimals. None where zeros at the end say that they are none, or where each number before the point is there with
/// each of those behind it, as where several things count their frames.
fn with_decimals(runs: &[&Vec<String>]) -> Option<Vec<Number>> {
    if runs.iter().any(|run| run.len() > 2) || runs.iter().all(|run| run.len() < 2) {
        return None;
    }
    let decimals: Vec<&str> = runs.iter().map(|run| run.get(1).map_or("", String::as_str)).collect();
    let before: BTreeSet<&str> = runs.iter().map(|run| &*run[0]).collect();
    let behind: BTreeSet<&str> = decimals.iter().copied().collect();
    if before.len() > 1 && behind.len() > 1 && before.len() * behind.len() == runs.len() {
        return None;
    }
    let is_short = |digits: &&str| *digits == "0" || !digits.ends_with('0');
    let are_as_many = decimals.iter().all(|digits| digits.len() == decimals[0].len());
    let number = |(run, decimals): (&&Vec<String>, &&str)| Number::new(&run[0], decimals);
    (are_as_many || decimals.iter().all(is_short)).then(|| runs.iter().zip(&decimals).map(number).collect())
}

/// Places of numbers in their order; none where two are equal.
fn order_of(numbers: &[Number]) -> Option<Vec<usize>> {
    let mut places: Vec<usize> = (0..numbers.len()).collect();
    places.sort_by_key(|place| &numbers[*place]);
    places.windows(2).all(|pair| numbers[pair[0]] != numbers[pair[1]]).then_some(places)
}

/// Whether numbers in their order are evenly apart, but for their last digit.
fn is_even(numbers: &[Number], order: &[usize]) -> bool {
    let steps = || order.windows(2).map(|pair| numbers[pair[1]].value() - numbers[pair[0]].value());
    let (least, most) = (steps().fold(f64::INFINITY, f64::min), steps().fold(0.0, f64::max));
    let digits = numbers.iter().map(|number| number.decimals.len()).max().unwrap_or(0);
    let last_digit = 1.01 * 10_f64.powi(-(digits.min(300) as i32));
    most - least <= last_digit.min(0.3 * least).max(1e-6 * least)
}

/// Files in order, and whether their numbers follow one another without gaps.
pub(super) struct InOrder<'p> {
    pub files: Vec<&'p Path>,
    pub even: bool,
}

/// Files whose names differ in one number alone, by this number.
///
/// # Errors
/// [`ImportError`] where the names do not tell one order beyond doubt.
pub(super) fn by_numbers<'p>(mut files: Vec<&'p Path>) -> Result<InOrder<'p>, ImportError> {
    files.sort_unstable();
    let names: Vec<Name> = files.iter().map(|file| Name::of(file)).collect();
    let unclear = |why: &str| {
        let problem = format!(
            "which number in the names counts frames is not clear: between {} and other files {why}; leave names that differ in one \
             whole number, or tell times by steps (--time-step) or by a column time",
            files[0].display()
        );
        ImportError::new(files[files.len() - 1], 1, problem)
    };
    let runs_at = |place: usize| names.iter().map(|name| &name.runs[place]).collect::<Vec<_>>();
    let differs = |place: &usize| runs_at(*place).iter().any(|run| *run != &names[0].runs[*place]);
    let differing: Vec<usize> = (0..names[0].runs.len()).filter(differs).collect();
    let [place] = differing[..] else {
        return match files.len() {
            1 => Ok(InOrder { files, even: true }),
            _ => Err(unclear(&format!("{} numbers differ", differing.len()))),
        };
    };
    let runs = runs_at(place);
    let readings: Vec<Vec<Number>> = [as_counts(&runs), with_decimals(&runs)].into_iter().flatten().collect();
    let orders: Option<Vec<Vec<usize>>> = readings.iter().map(|numbers| order_of(numbers)).collect();
    let Some([order, others @ ..]) = orders.as_deref() else {
        return Err(unclear("two numbers are alike, or one is written otherwise"));
    };
    if others.iter().any(|other| other != order) {
        return Err(unclear("the order depends on whether a point stands before decimals"));
    }
    let even = readings.iter().any(|numbers| is_even(numbers, order));
    Ok(InOrder { files: order.iter().map(|place| files[*place]).collect(), even })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::PathBuf;

    /// Names without what is alike in them, in order; an error's words where there is none.
    fn ordered(names: &str) -> Result<String, String> {
        let files: Vec<PathBuf> = names.split(' ').rev().map(|name| format!("f_{name}.csv").into()).collect();
        let found = by_numbers(files.iter().map(|file| &**file).collect()).map_err(|error| error.to_string())?;
        let name = |file: &&Path| file.to_str().unwrap()[2..].trim_end_matches(".csv").to_string();
        Ok(found.files.iter().map(name).collect::<Vec<_>>().join(" "))
    }

    #[test]
    fn numbers_in_names_follow_by_value() {
        for names in [
            "0.0 0.05 0.1 0.15 0.2",
            "0 0.05 0.1 1",
            "0.9 1.0 1.1",
            "0.25 0.5 0.75 1.0",
            "0.05 0.10 0.15",
            "9.50 10.00 10.50",
            "0.33 0.67 1.00",
            "0,05 0,1 0,15",
            "0p05 0p1 0p15",
            // Numbers behind one another, and a version beside a count.
            "1.8000 1.10000 1.12000",
            "1.2_frame_3 1.2_frame_10",
            "2024.1.9 2024.1.10",
            "0001 0002 0010",
        ] {
            assert_eq!(ordered(names).as_deref(), Ok(names));
        }
        // A number behind the last point of a name is no decimal of the one before.
        for names in [["out.9", "out.100"], ["a.1.csv", "a.10.csv"], ["run.0009.csv", "run.0010.csv"]] {
            let found = by_numbers(names.map(Path::new).to_vec()).unwrap();
            assert_eq!(found.files, names.map(Path::new));
        }
    }

    #[test]
    fn names_of_which_the_order_is_not_beyond_doubt_are_refused() {
        for names in [
            "1e-04 2e-05",
            "0.5 0.25",
            "0.05 0.15 0.125",
            "1.9 1.11 1.13",
            "0.1 0.2 0.30000000000000004 0.4",
            "1 1.0",
            "1 01",
            // Two things that count their frames.
            "0.1 0.2 1.1 1.2",
            "1_1 1_2 2_1",
            // A time, and a number or a version behind it.
            "0.5.7 0.25.7",
        ] {
            let error = ordered(names).unwrap_err();
            assert!(error.contains("which number in the names counts frames is not clear"), "{names}: {error}");
        }
    }

    #[test]
    fn gaps_are_seen() {
        let even = |names: &[&str]| by_numbers(names.iter().map(Path::new).collect()).unwrap().even;
        assert!(even(&["f_0", "f_1", "f_2"]) && even(&["f_7"]) && even(&["f_333", "f_667", "f_1000"]));
        assert!(even(&["f_0.0", "f_0.05", "f_0.1"]));
        assert!(!even(&["f_0", "f_1", "f_3"]) && !even(&["f_0.0", "f_0.05", "f_0.1", "f_0.2"]));
    }
}
