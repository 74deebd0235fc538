//! What the numbers in the names of files say of their order. A point between digits stands before decimals (`f_0.15.csv`) or between two
//! numbers (`wall1.2000.vtk`): names are read in both ways, and one order is taken only where the other way does not tell another one.

use super::frame_table::ImportError;
use std::collections::BTreeSet;
use std::path::Path;

/// What may stand before decimals.
const POINTS: [char; 3] = ['.', ',', 'p'];

/// Most ways in which the points in names are read.
const MOST_READINGS: usize = 64;

/// A number in a name: digits before the point without leading zeros, behind their count, and decimals without trailing zeros.
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

/// Digits and points that follow one another.
#[derive(Clone, Debug, PartialEq)]
struct Run {
    /// The digits between the points.
    groups: Vec<String>,
    /// `e-05` and the like.
    exponent: String,
}

/// A path with `#` in place of each number, and the numbers.
struct Name {
    text: String,
    runs: Vec<Run>,
}

/// Bytes of the digits at the beginning.
fn digits(text: &str) -> usize {
    text.find(|letter: char| !letter.is_ascii_digit()).unwrap_or(text.len())
}

/// Bytes of an exponent at the beginning.
fn exponent(text: &str) -> usize {
    let Some(rest) = text.strip_prefix(['e', 'E']) else { return 0 };
    let sign = usize::from(rest.starts_with(['-', '+']));
    match digits(&rest[sign..]) {
        0 => 0,
        count => 1 + sign + count,
    }
}

fn split(path: &Path) -> Name {
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
        let (exponent, after) = rest.split_at(exponent(rest));
        rest = after;
        runs.push(Run { groups, exponent: exponent.into() });
    }
    Name { text: text + rest, runs }
}

/// A path with `#` in place of each number.
pub(super) fn pattern(path: &Path) -> String {
    split(path).text
}

/// Whether a path has a number with a point.
pub(super) fn has_points(path: &Path) -> bool {
    split(path).runs.iter().any(|run| run.groups.len() > 1)
}

/// All digits in a path, number after number.
pub(super) fn all_digits(path: &Path) -> Vec<String> {
    split(path).runs.into_iter().flat_map(|run| run.groups).collect()
}

/// One way to read the numbers in names that differ in numbers alone: those of each file.
struct Reading {
    numbers: Vec<Vec<Number>>,
    /// Whether some numbers have decimals.
    has_decimals: bool,
}

/// The order of files in one reading.
struct Order {
    /// Places of the files.
    places: Vec<usize>,
    /// Time between frames, if numbers with decimals are times that far apart.
    apart: Option<f64>,
    /// Whether numbers follow one another evenly, as counted frames do.
    even: bool,
}

/// Why a reading tells no order: places of two files between which one number rises and another falls, or none does.
struct Disorder {
    pair: [usize; 2],
    /// Whether each of some numbers is there with each of others, as where several things count their frames.
    is_grid: bool,
}

/// One number of all files in one way to read it; `points` tells which of its points stand before decimals. None where the digits say
/// that it is written otherwise.
fn read_run(runs: &[&Run], points: &[bool]) -> Option<Vec<Vec<Number>>> {
    let mut whole: Vec<Vec<&str>> = vec![Vec::new(); runs.len()];
    let mut decimals: Vec<Vec<&str>> = whole.clone();
    for (file, run) in runs.iter().enumerate() {
        for (place, group) in run.groups.iter().enumerate() {
            match place.checked_sub(1).is_some_and(|before| points[before]) {
                true => *decimals[file].last_mut()? = group,
                false => {
                    whole[file].push(group);
                    decimals[file].push("");
                }
            }
        }
    }
    let count = whole[0].len();
    let column = |of: &[Vec<&str>], place: usize| of.iter().map(|row| row[place].to_string()).collect::<Vec<_>>();
    for place in 0..count {
        if (place > 0 && !may_count(&column(&whole, place))) || !may_be_decimals(&column(&decimals, place)) {
            return None;
        }
    }
    let numbers = |(whole, decimals): (&Vec<&str>, &Vec<&str>)| {
        whole.iter().zip(decimals).map(|(whole, decimals)| Number::new(whole, decimals)).collect()
    };
    Some(whole.iter().zip(&decimals).map(numbers).collect())
}

/// Whether digits may be a count: one that is filled with zeros to some width has no zeros before where it is wider.
fn may_count(all: &[String]) -> bool {
    let width = all.iter().map(String::len).min().unwrap_or(0);
    all.iter().all(|digits| digits.len() == width || !digits.starts_with('0'))
}

/// Whether digits may be decimals: as many as others, or without zeros at their end.
fn may_be_decimals(all: &[String]) -> bool {
    let is_short = |digits: &String| digits == "0" || !digits.ends_with('0');
    all.windows(2).all(|pair| pair[0].len() == pair[1].len()) || all.iter().all(is_short)
}

/// All ways to read the numbers in which names differ; none where one has an exponent.
fn readings(names: &[Name]) -> Vec<Reading> {
    let mut readings = vec![Reading { numbers: vec![Vec::new(); names.len()], has_decimals: false }];
    for place in 0..names[0].runs.len() {
        let runs: Vec<&Run> = names.iter().map(|name| &name.runs[place]).collect();
        if runs.iter().all(|run| *run == runs[0]) {
            continue;
        }
        let (fewest, most) = runs
            .iter()
            .map(|run| run.groups.len())
            .fold((usize::MAX, 0), |(fewest, most), count| (fewest.min(count), most.max(count)));
        // Where some have no decimals, others have some; longer ones are versions, dates or lists.
        let differ = fewest != most;
        if runs.iter().any(|run| !run.exponent.is_empty()) || most > 8 || (differ && most > 2) {
            return Vec::new();
        }
        let mut longer = Vec::new();
        for bits in 0..1_usize << (most - 1) {
            let points: Vec<bool> = (0..most - 1).map(|point| bits >> point & 1 == 1).collect();
            if points.windows(2).any(|pair| pair[0] && pair[1]) || (differ && !points[0]) {
                continue;
            }
            let Some(own) = read_run(&runs, &points) else { continue };
            for reading in &readings {
                let joined = reading.numbers.iter().zip(&own).map(|(before, own)| [&before[..], own].concat());
                longer.push(Reading { numbers: joined.collect(), has_decimals: reading.has_decimals || bits > 0 });
            }
        }
        readings = longer;
        if readings.len() > MOST_READINGS {
            return Vec::new();
        }
    }
    readings
}

/// Steps between numbers that are evenly apart, but for their last digit.
fn even_step(numbers: &[&Number]) -> Option<f64> {
    let values: Vec<f64> = numbers.iter().map(|number| number.value()).collect();
    let steps = || values.windows(2).map(|pair| pair[1] - pair[0]);
    let (least, most) = (steps().fold(f64::INFINITY, f64::min), steps().fold(0.0, f64::max));
    let rounding = last_digit(numbers).min(0.3 * least).max(1e-6 * least);
    (least > 0.0 && most - least <= rounding)
        .then(|| (values[values.len() - 1] - values[0]) / (values.len() - 1) as f64)
}

/// Worth of the last digit of numbers, and a little more.
fn last_digit(numbers: &[&Number]) -> f64 {
    let digits = numbers.iter().map(|number| number.decimals.len()).max().unwrap_or(0);
    1.01 * 10_f64.powi(-(digits.min(300) as i32))
}

impl Reading {
    fn order(&self, interval: Option<f64>) -> Result<Order, Disorder> {
        let mut places: Vec<usize> = (0..self.numbers.len()).collect();
        places.sort_by_key(|place| &self.numbers[*place]);
        let width = self.numbers[0].len();
        let column = |at: usize| places.iter().map(|place| &self.numbers[*place][at]).collect::<Vec<_>>();
        for pair in places.windows(2) {
            let (earlier, later) = (&self.numbers[pair[0]], &self.numbers[pair[1]]);
            if earlier == later || earlier.iter().zip(later).any(|(before, after)| after < before) {
                let distinct = (0..width).map(|at| column(at).into_iter().collect::<BTreeSet<_>>().len());
                let is_grid = distinct.fold(1_usize, usize::saturating_mul) == self.numbers.len();
                return Err(Disorder { pair: [pair[0], pair[1]], is_grid });
            }
        }
        let even: Vec<(Vec<&Number>, f64)> =
            (0..width).map(column).filter_map(|numbers| even_step(&numbers).map(|step| (numbers, step))).collect();
        let is_interval = |(numbers, step): &&(Vec<&Number>, f64)| {
            let off = interval.map_or(f64::INFINITY, |interval| (step - interval).abs() * (numbers.len() - 1) as f64);
            off <= last_digit(numbers).max(1e-6 * step)
        };
        let apart = even.iter().find(is_interval).map(|(_, step)| *step).filter(|_| self.has_decimals);
        Ok(Order { apart, even: self.numbers.len() < 2 || !even.is_empty(), places })
    }
}

/// Files in order, and whether their numbers follow one another without gaps.
pub(super) struct InOrder<'p> {
    pub files: Vec<&'p Path>,
    pub even: bool,
}

/// Files whose names differ in numbers alone, by these numbers; `interval` is the time between their frames, s.
///
/// # Errors
/// [`ImportError`] where the names do not tell one order beyond doubt.
pub(super) fn by_numbers<'p>(mut files: Vec<&'p Path>, interval: Option<f64>) -> Result<InOrder<'p>, ImportError> {
    files.sort_unstable();
    let remedy = "or tell times by steps (--time-step) or by a column time";
    let unclear = |file: &Path, why: String, names: &str| {
        let problem =
            format!("which number in the names counts frames is not clear: {why}; leave names {names}, {remedy}");
        Err(ImportError::new(file, 1, problem))
    };
    let names: Vec<Name> = files.iter().map(|file| split(file)).collect();
    let found: Vec<Result<Order, Disorder>> = readings(&names).iter().map(|reading| reading.order(interval)).collect();
    let ordered: Vec<&Order> = found.iter().flatten().collect();
    let disordered: Vec<&Disorder> = found.iter().filter_map(|order| order.as_ref().err()).collect();
    let one_of = |orders: &[&Order]| -> Option<InOrder<'p>> {
        let (first, others) = orders.split_first()?;
        let files = first.places.iter().map(|place| files[*place]).collect();
        let even = orders.iter().any(|order| order.even);
        others.iter().all(|other| other.places == first.places).then_some(InOrder { files, even })
    };
    let those = |which: &dyn Fn(&Order) -> bool| -> Vec<&Order> {
        ordered.iter().copied().filter(|order| which(order)).collect()
    };
    // Decimals that are as far apart as the frames are their times.
    let of_times = one_of(&those(&|order| order.apart.is_some()));
    let of_all = one_of(&ordered).filter(|_| disordered.is_empty());
    // Frames that are counted are evenly apart: a reading in which they are is the right one where they are not in others.
    let of_even =
        || one_of(&those(&|order| order.even)).filter(|_| !disordered.iter().any(|disorder| disorder.is_grid));
    if let Some(order) = of_times.or(of_all).or_else(of_even) {
        return Ok(order);
    }
    match (disordered.first(), &ordered[..]) {
        (Some(Disorder { pair: [earlier, later], .. }), []) => {
            let why = format!("from {} on, one rises and another falls, or none does", files[*earlier].display());
            unclear(files[*later], why, "that differ in one number")
        }
        _ => {
            let why = format!(
                "those of {} and of other files can be read in several ways, with decimals and without, or in none",
                files[0].display()
            );
            unclear(files[files.len() - 1], why, "that differ in one whole number")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::PathBuf;

    /// Names without what is alike in them, in order; an error's words where there is none.
    fn ordered(names: &str, interval: Option<f64>) -> Result<String, String> {
        let files: Vec<PathBuf> = names.split(' ').rev().map(|name| format!("f_{name}.csv").into()).collect();
        let found =
            by_numbers(files.iter().map(|file| &**file).collect(), interval).map_err(|error| error.to_string())?;
        let name = |file: &&Path| file.to_str().unwrap()[2..].trim_end_matches(".csv").to_string();
        Ok(found.files.iter().map(name).collect::<Vec<_>>().join(" "))
    }

    #[test]
    fn decimals_in_names_follow_by_value() {
        for names in [
            "0.0 0.05 0.1 0.15 0.2",
            "0 0.05 0.1 1",
            "0.9 1.0 1.1",
            "0.25 0.5 0.75 1.0",
            "0.25 0.5 0.75",
            "0.0 0.1 0.2 0.30000000000000004 0.4",
            "9.50 10.00 10.50",
            "0.33 0.67 1.00",
            "0,05 0,1 0,15",
            "0p05 0p1 0p15",
            // Numbers behind one another, and a version beside a count.
            "1.8000 1.10000 1.12000",
            "1.9 1.10 1.11",
            "1.9 1.11 1.13",
            "1.2_frame_3 1.2_frame_10",
            "2024.1.9 2024.1.10",
            "0001 0002 0010",
            "0.05.7 0.1.7 0.15.7",
        ] {
            assert_eq!(ordered(names, None).as_deref(), Ok(names));
        }
        // A number behind the last point of a name is no decimal of the one before.
        for names in [["out.9", "out.100"], ["a.1.csv", "a.10.csv"], ["run.0009.csv", "run.0010.csv"]] {
            let found = by_numbers(names.map(Path::new).to_vec(), None).unwrap();
            assert_eq!(found.files, names.map(Path::new));
        }
    }

    #[test]
    fn names_of_which_the_order_is_not_beyond_doubt_are_refused() {
        for names in [
            "5e-05 0.0001 0.00015",
            "0.0 5e-05",
            "0.5 0.25",
            "0.05 0.15 0.125",
            "1 1.0",
            "1 01",
            // Two things that count their frames.
            "0.1 0.2 1.1 1.2",
            "0.0 0.1 0.2 0.3 0.4 0.5 0.6 0.7 0.8 0.9 1.0 1.1 1.2 1.3 1.4 1.5 1.6 1.7 1.8 1.9",
            // A time and a number behind it, or a version.
            "0.5.7 0.25.7",
        ] {
            let error = ordered(names, None).unwrap_err();
            assert!(error.contains("which number in the names counts frames is not clear"), "{error}");
        }
        // Where the numbers are as far apart as the frames, they are times.
        assert_eq!(ordered("0.5 0.25", Some(0.25)).as_deref(), Ok("0.25 0.5"));
        assert_eq!(ordered("0.0 0.5 1.0 1.5", Some(0.5)).as_deref(), Ok("0.0 0.5 1.0 1.5"));
    }

    #[test]
    fn gaps_are_seen() {
        let even = |names: &[&str]| by_numbers(names.iter().map(Path::new).collect(), None).unwrap().even;
        assert!(even(&["f_0", "f_1", "f_2"]) && even(&["f_7"]) && even(&["f_333", "f_667", "f_1000"]));
        assert!(even(&["f_0.0", "f_0.05", "f_0.1"]));
        assert!(!even(&["f_0", "f_1", "f_3"]) && !even(&["f_0.0", "f_0.05", "f_0.1", "f_0.2"]));
    }
}
