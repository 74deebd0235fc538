//! Recorded trade-offs, read back from their tables: reproduced cell by cell, and figures without overlapping text.

use makadam_compare::study::Document as _;
use makadam_studies::tradeoff::{Bound, Convergence, Deviation, Point, Reference, Study, Terms};
use roxmltree::{Document, Node};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

type Record = BTreeMap<String, String>;

fn records(file: &Path) -> Vec<Record> {
    csv::Reader::from_path(file).unwrap().deserialize().collect::<Result<_, _>>().unwrap()
}

fn number(record: &Record, column: &str) -> Option<f64> {
    record.get(column).and_then(|cell| cell.parse().ok())
}

fn truth(record: &Record, column: &str) -> Option<bool> {
    record.get(column).and_then(|cell| cell.parse().ok())
}

fn deviation(record: &Record) -> Option<Deviation> {
    Some(Deviation {
        observable: record["observable"].clone(),
        unit: record["unit"].clone(),
        seeds: number(record, "seeds")? as usize,
        mean: number(record, "mean")?,
        standard_error: number(record, "standard_error"),
        deviation: number(record, "deviation")?,
        deviation_standard_error: number(record, "deviation_standard_error"),
        interval90: number(record, "interval90_low").zip(number(record, "interval90_high")).map(|(a, b)| [a, b]),
        bound: number(record, "bound"),
        within: truth(record, "within"),
        interval_within: truth(record, "interval_within"),
        on_front: truth(record, "on_front")?,
        differences: BTreeMap::new(),
    })
}

fn point(record: &Record) -> Point {
    let wall = |which: &str| number(record, &format!("wall_seconds_per_simulated_second{which}")).unwrap();
    Point {
        code: record["code"].clone(),
        version: record["version"].clone(),
        setting: record["setting"].clone(),
        stiffness_factor: number(record, "stiffness_factor").unwrap(),
        youngs_modulus: number(record, "youngs_modulus").unwrap(),
        time_step: number(record, "time_step").unwrap(),
        rayleigh_fraction: number(record, "rayleigh_fraction"),
        sweeps: number(record, "sweeps").map(|sweeps| sweeps as u32),
        variation: record.get("variation").filter(|words| !words.is_empty()).cloned(),
        seeds: (1..=number(record, "seeds").unwrap() as u64).collect(),
        wall_seconds_per_simulated_second: wall(""),
        wall_seconds_per_simulated_second_least: wall("_least"),
        wall_seconds_per_simulated_second_most: wall("_most"),
        simulated_seconds: number(record, "simulated_seconds").unwrap(),
        failed: truth(record, "failed").unwrap_or(false),
        reference: truth(record, "reference").unwrap(),
        deviations: Vec::new(),
        within_bounds: truth(record, "within_bounds"),
        intervals_within_bounds: truth(record, "intervals_within_bounds"),
    }
}

fn reference(record: &Record) -> Reference {
    let value = |column: &str| number(record, column).unwrap();
    let grids = ["coarse_mean", "middle_mean", "fine_mean"].map(|column| number(record, column));
    Reference {
        stiffness_factor: value("stiffness_factor"),
        youngs_modulus: value("youngs_modulus"),
        setting: record["setting"].clone(),
        observable: record["observable"].clone(),
        unit: record["unit"].clone(),
        seeds: value("seeds") as usize,
        mean: value("mean"),
        standard_deviation: value("standard_deviation"),
        standard_error: number(record, "standard_error"),
        steps: ["coarse_step", "middle_step", "fine_step"].map(value),
        grid_means: grids.iter().copied().collect::<Option<Vec<f64>>>().map(|means| [means[0], means[1], means[2]]),
        convergence: number(record, "safety_factor").map(|safety_factor| Convergence {
            observed_order: number(record, "observed_order"),
            richardson: number(record, "richardson"),
            safety_factor,
            grid_convergence_index: value("grid_convergence_index"),
        }),
        shift: number(record, "shift"),
        shift_standard_error: number(record, "shift_standard_error"),
    }
}

/// The study of a folder of tables.
fn study(folder: &Path) -> Study {
    let mut points: Vec<Point> = Vec::new();
    let mut bounds: Vec<Bound> = Vec::new();
    for record in records(&folder.join("points.csv")) {
        let known = point(&record);
        let same = |other: &Point| {
            (&other.code, &other.setting, other.stiffness_factor)
                == (&known.code, &known.setting, known.stiffness_factor)
        };
        if !points.last().is_some_and(same) {
            points.push(known);
        }
        let Some(deviation) = deviation(&record) else { continue };
        if let Some(value) = deviation.bound
            && !bounds.iter().any(|bound| bound.observable == deviation.observable)
        {
            bounds.push(Bound { observable: deviation.observable.clone(), value });
        }
        points.last_mut().unwrap().deviations.push(deviation);
    }
    Study {
        version: 1,
        command: "tradeoff".into(),
        scene: String::new(),
        particles: 0,
        complete: true,
        terms: Terms { seeds: 1, bounds, time_limit: 1.0, provenance: BTreeMap::new() },
        references: records(&folder.join("references.csv")).iter().map(reference).collect(),
        points,
        fastest: csv::Reader::from_path(folder.join("fastest.csv"))
            .unwrap()
            .deserialize()
            .map(Result::unwrap)
            .collect(),
        findings: Vec::new(),
        notes: Vec::new(),
    }
}

/// Folders of recorded tables.
fn folders() -> Vec<PathBuf> {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-scenes/*/tradeoff/*/points.csv");
    let files = glob::glob(scenes.to_str().unwrap()).unwrap();
    files.map(|file| file.unwrap().parent().unwrap().to_path_buf()).collect()
}

/// Left, upper, right and lower edge.
type Area = [f64; 4];

fn meet(one: &Area, other: &Area) -> bool {
    one[0] < other[2] && other[0] < one[2] && one[1] < other[3] && other[1] < one[3]
}

/// The edges of a text: a digit is 6.4 pixels wide and 8.5 high in the font of ticks.
fn words(node: Node<'_, '_>) -> Area {
    let at = |name: &str| node.attribute(name).unwrap().parse::<f64>().unwrap();
    let width = 6.4 * node.text().unwrap().chars().count() as f64;
    let left = match node.attribute("text-anchor") {
        Some("middle") => at("x") - width / 2.0,
        _ => at("x"),
    };
    [left, at("y") - 8.5, left + width, at("y")]
}

/// The edges of a marker.
fn mark(node: Node<'_, '_>) -> Area {
    let at = |name: &str| node.attribute(name).unwrap().parse::<f64>().unwrap();
    match node.tag_name().name() {
        "circle" => [at("cx") - at("r"), at("cy") - at("r"), at("cx") + at("r"), at("cy") + at("r")],
        "rect" => [at("x"), at("y"), at("x") + at("width"), at("y") + at("height")],
        _ => {
            let corners = node.attribute("points").unwrap().split([' ', ',']).map(|text| text.parse::<f64>().unwrap());
            let corners: Vec<f64> = corners.collect();
            let edge = |axis: usize, pick: fn(f64, f64) -> f64| {
                corners.iter().skip(axis).step_by(2).copied().reduce(pick).unwrap()
            };
            [edge(0, f64::min), edge(1, f64::min), edge(0, f64::max), edge(1, f64::max)]
        }
    }
}

/// Overlaps of the text of a figure, and the number of its numbered settings.
fn faults(svg: &str) -> (Vec<String>, usize) {
    let drawing = Document::parse(svg).unwrap();
    let of_class = |class: &str| {
        let nodes = drawing.descendants().filter(move |node| {
            node.attribute("class").is_some_and(|classes| classes.split(' ').any(|one| one == class))
        });
        nodes.collect::<Vec<_>>()
    };
    let numbers = of_class("beside");
    let marks: Vec<Area> = [of_class("marker"), of_class("hollow")].concat().into_iter().map(mark).collect();
    let key = of_class("tick").into_iter().filter(|node| node.text().is_some_and(|text| text.contains(": ")));
    let key: Vec<Node<'_, '_>> = key.collect();
    let mut faults = Vec::new();
    for (place, number) in numbers.iter().enumerate() {
        let text = number.text().unwrap();
        let area = words(*number);
        faults.extend(marks.iter().any(|mark| meet(mark, &area)).then(|| format!("{text} lies on a mark")));
        let others = numbers[..place].iter().filter(|other| meet(&words(**other), &area));
        faults.extend(others.map(|other| format!("{text} lies on {}", other.text().unwrap())));
        let named = key.iter().filter(|node| node.text().unwrap().starts_with(&format!("{text}: "))).count();
        faults.extend((named != 1).then(|| format!("{text} is named {named} times")));
    }
    let all = drawing.descendants().filter(|node| node.has_tag_name("text") && node.attribute("x").is_some());
    let all: Vec<Area> = all.map(words).collect();
    for (place, entry) in key.iter().enumerate() {
        let area = words(*entry);
        let text = entry.text().unwrap();
        faults.extend((area[2] > 545.0).then(|| format!("'{text}' reaches beyond the figure")));
        let met = all.iter().filter(|other| meet(other, &area)).count();
        faults.extend((met > 1).then(|| format!("'{text}' lies on other words")));
        faults.extend((numbers.len() != key.len() && place == 0).then(|| "a number is missing".to_string()));
    }
    (faults, numbers.len())
}

#[test]
fn figures_have_no_overlapping_text() {
    let (mut figures, mut numbers) = (0, 0);
    for folder in folders() {
        for figure in study(&folder).figures() {
            let (faults, found) = faults(&figure.svg);
            assert!(faults.is_empty(), "{} of {}: {faults:?}", figure.name, folder.display());
            (figures, numbers) = (figures + 1, numbers + found);
        }
    }
    assert!(figures > 30 && numbers > 150, "{figures} figures, {numbers} numbers");
}

#[test]
fn tables_are_reproduced_from_their_rows() {
    let (mut cells, mut whole) = (0, 0);
    for folder in folders() {
        for (name, bytes) in study(&folder).tables().unwrap() {
            let file = folder.join(&name);
            if !name.ends_with(".csv") {
                continue;
            }
            let recorded = std::fs::read(&file).unwrap();
            let read = |bytes: &[u8]| {
                csv::Reader::from_reader(bytes).deserialize().map(Result::unwrap).collect::<Vec<Record>>()
            };
            let (before, after) = (read(&recorded), read(&bytes));
            assert_eq!(before.len(), after.len(), "{}", file.display());
            // Earlier versions had fewer columns, and these in addition.
            let earlier = ["core_share_least", "extrapolated", "deviation_from_scene"];
            for (line, (before, after)) in before.iter().zip(&after).enumerate() {
                for (column, cell) in before.iter().filter(|(column, _)| !earlier.contains(&column.as_str())) {
                    assert_eq!(after.get(column), Some(cell), "{}:{}: {column}", file.display(), line + 2);
                    cells += 1;
                }
            }
            let head = |bytes: &[u8]| bytes.split(|&byte| byte == b'\n').next().unwrap_or_default().to_vec();
            if head(&recorded) == head(&bytes) {
                assert!(recorded == bytes, "{}", file.display());
                whole += 1;
            }
        }
    }
    assert!(cells > 20_000 && whole > 10, "{cells} cells, {whole} whole tables");
}
