use super::*;
use crate::compare::comparison;
use makadam_measure::statistics::Outcome;

const TABLE: &str = "code,source,observable,time,value\n\
                     A,\"Author (2024)\",grain_count(bed),0.5,100\n\
                     B,\"Author (2024)\",grain_count(bed),0.5,104\n\
                     A,\"Author (2024)\",grain_count(bed),1,50\n\
                     A,\"Author (2024)\",mass_flow_rate,,2.5\n";

const SCENE: &str = r#"
    name = "count"
    description = "grains of a bed"
    duration = 2.0
    domain = { min = [-1.0, -1.0, -1.0], max = [1.0, 1.0, 1.0] }
    [material.glass]
    density = 2500.0
    youngs_modulus = 1e7
    poisson_ratio = 0.3
    friction = 0.5
    restitution = 0.3
    [[grain]]
    material = "glass"
    radius = 0.005
    position = [0.0, 0.0, 0.0]
    [measure]
    from = 0.25
    interval = 0.25
    observables = ["regions"]
    seeds = 2
    [[measure.region]]
    name = "bed"
    within = { kind = "box", min = [-1.0, -1.0, -1.0], max = [1.0, 1.0, 0.0] }
    [[compare]]
    observable = "grain_count(bed)"
    at = [0.5, 1.0]
    margin = 6.0
"#;

fn read(table: &str) -> Result<Option<Reference>, ReferenceError> {
    Reference::read(Path::new("reference"), &|file| match file.ends_with("published.csv") {
        true => Ok(table.as_bytes().to_vec()),
        false => Err(std::io::Error::from(std::io::ErrorKind::NotFound)),
    })
}

fn own(scene: &MeasuredScene, values: [[f64; 2]; 2]) -> CodeRuns {
    let template = read(TABLE).unwrap().unwrap().published(scene).swap_remove(0);
    let mut own = CodeRuns { code: "Makadam".into(), source: Source::Live, ..template };
    own.runs =
        (1..).zip(values).map(|(seed, values)| MeasuredRun { seed, ..own.runs[0].clone() }.with(values)).collect();
    own
}

impl MeasuredRun {
    fn with(mut self, values: [f64; 2]) -> MeasuredRun {
        self.measurements.truncate(2);
        self.measurements.iter_mut().zip(values).for_each(|(measured, value)| measured.value = value);
        self
    }
}

#[test]
fn published_curves_are_compared_where_they_have_a_value() {
    let scene = MeasuredScene::parse(SCENE).unwrap();
    let names: Vec<&str> = scene.compare.iter().map(|one| one.observable.as_str()).collect();
    assert_eq!(names, ["grain_count(bed) at 0.5 s", "grain_count(bed) at 1 s"]);
    let reference = read(TABLE).unwrap().unwrap();
    let mut codes = vec![own(&scene, [[101.0, 60.0], [101.5, 60.5]])];
    codes.extend(reference.published(&scene));
    // Curves start when measurement does.
    assert_eq!(
        (codes[1].series[0].time.clone(), codes[1].series[0].value.clone()),
        (vec![0.75, 1.25], vec![100.0, 50.0])
    );
    let rows = comparison(&scene, &codes, Vec::new()).rows;
    let of = |name: &str, code: &str| {
        rows.iter()
            .find(|row| row.observable == name && row.reference_code.as_deref() == Some(code) && row.code == "Makadam")
    };
    let outcome = |name: &str, code: &str| of(name, code).and_then(|row| row.outcome);
    assert_eq!(outcome(names[0], "A (published)"), Some(Outcome::Agree));
    assert_eq!(outcome(names[0], "B (published)"), Some(Outcome::Agree));
    assert_eq!(outcome(names[1], "A (published)"), Some(Outcome::Disagree));
    assert_eq!(of(names[1], "B (published)"), None);
    assert_eq!(reference.not_compared(&scene), ["A (published): mass_flow_rate"]);
}

/// The interval of a mean against a number is Student's.
#[test]
fn published_value_adds_no_variance() {
    let scene = MeasuredScene::parse(SCENE).unwrap();
    let codes =
        [own(&scene, [[100.0, 50.0], [102.0, 50.0]]), read(TABLE).unwrap().unwrap().published(&scene).swap_remove(0)];
    let rows = comparison(&scene, &codes, Vec::new()).rows;
    let [low, high] = rows[0].interval90.unwrap();
    // Quantile 6.314 of one degree of freedom, standard deviation 1.414, two seeds.
    assert!((low - (1.0 - 6.314)).abs() < 1e-3 && (high - (1.0 + 6.314)).abs() < 1e-3, "{low} to {high}");
}

#[test]
fn faults_of_published_tables_name_the_line() {
    let message = |table: &str| read(table).unwrap_err().to_string();
    let twice = TABLE.to_string() + "A,\"Author (2024)\",grain_count(bed),1,51\n";
    assert!(message(&twice).contains("published.csv:6: A has a second value of grain_count(bed) at 1 s"));
    assert!(message("code,source,observable,time,value\nA,B,grain_cuont(bed),1,5\n").contains(":2: nothing measures"));
    assert!(message("code,value\nA,5\n").contains(":1: its columns are not"));
}
