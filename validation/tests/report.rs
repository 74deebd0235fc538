//! The report: self-contained, well formed, complete, and never half-written.

use crate::support::sample;
use makadam_compare::compare::{Comparison, Row, Timing};
use makadam_compare::study::DocumentError;
use makadam_measure::statistics::Outcome;
use makadam_qualification::report::{Qualification, REPORT_VERSION, ReportDocument, Standing, comparison_table, write};
use roxmltree::{Document, ParsingOptions};
use std::fs;
use std::sync::LazyLock;

fn page(qualification: &Qualification) -> String {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let page_file = write(qualification, folder.path()).expect("a report");
    fs::read_to_string(&page_file).expect("the page")
}

/// The page is written so that it is XML too: every tag closes.
fn parse(page: &str) -> Document<'_> {
    Document::parse_with_options(page, ParsingOptions { allow_dtd: true, ..Default::default() })
        .expect("well-formed markup")
}

/// All text of a page, without its style sheet.
fn text(page: &str) -> String {
    parse(page)
        .descendants()
        .filter(|node| node.is_text() && node.parent().is_none_or(|parent| !parent.has_tag_name("style")))
        .filter_map(|node| node.text())
        .collect::<Vec<_>>()
        .join(" ")
}

fn full() -> Qualification {
    sample::qualification(vec![sample::drum(true), sample::packing(), sample::alone()])
}

/// Page of the whole sample. Its pictures take time to draw: it is written once.
fn full_page() -> &'static str {
    static PAGE: LazyLock<String> = LazyLock::new(|| page(&full()));
    &PAGE
}

/// A drum without pictures in which every test has one outcome.
fn all(outcome: Outcome) -> Qualification {
    let mut drum = sample::drum(false);
    drum.final_states.clear();
    for row in &mut drum.rows {
        row.outcome = row.margin.and(Some(outcome));
    }
    sample::qualification(vec![drum])
}

#[test]
fn a_live_value_outside_the_recorded_spread_is_a_disagreement() {
    let mut qualification = all(Outcome::Agree);
    assert_eq!(qualification.verdict().standing, Standing::Agree);
    qualification.outside_spread.push("drum: live YADE lies outside".into());
    let verdict = qualification.verdict();
    assert_eq!(verdict.standing, Standing::Disagree);
    assert!(verdict.sentence.contains("1 live value of a reference code outside"), "{}", verdict.sentence);
    assert!(page(&qualification).contains("drum: live YADE lies outside"));
}

#[test]
fn the_page_loads_nothing_and_runs_nothing() {
    let page = full_page();
    let document = parse(page);
    for node in document.descendants().filter(|node| node.is_element()) {
        let name = node.tag_name().name();
        assert!(!["script", "link", "iframe", "object", "embed", "image"].contains(&name), "<{name}>");
        for attribute in node.attributes() {
            assert!(!attribute.name().starts_with("on"), "{name} {}", attribute.name());
            if ["src", "href", "action", "srcset", "data"].contains(&attribute.name()) {
                // A link leads to a place of the page, or to a file next to it; a picture holds itself.
                let link = attribute.name() == "href" && name == "a" && !attribute.value().contains([':', '/']);
                let picture = name == "img" && attribute.value().starts_with("data:image/png;base64,");
                assert!(attribute.value().starts_with('#') || link || picture, "{name} {}", attribute.value());
            }
        }
    }
    assert!(!page.contains("@import") && !page.contains("url(http") && !page.contains("url(//"));
    assert!(page.contains("Content-Security-Policy"));
}

#[test]
fn every_reference_within_the_page_has_a_target() {
    let page = full_page();
    let document = parse(page);
    let ids: Vec<&str> = document.descendants().filter_map(|node| node.attribute("id")).collect();
    let mut unique = ids.clone();
    unique.sort_unstable();
    unique.dedup();
    assert_eq!(ids.len(), unique.len(), "an id stands twice");
    let targets = document.descendants().filter_map(|node| node.attribute("href"));
    for target in targets.filter_map(|target| target.strip_prefix('#')) {
        assert!(ids.contains(&target), "{target}");
    }
}

#[test]
fn no_number_of_a_drawing_is_broken() {
    let page = full_page();
    let document = parse(page);
    let mut drawings = 0;
    for node in document.descendants().filter(|node| node.ancestors().any(|a| a.has_tag_name("svg"))) {
        drawings += usize::from(node.has_tag_name("svg"));
        for attribute in node
            .attributes()
            .filter(|a| ["x", "y", "x1", "y1", "x2", "y2", "cx", "cy", "r", "width", "height"].contains(&a.name()))
        {
            assert!(
                attribute.value().parse::<f64>().is_ok_and(f64::is_finite),
                "{}={}",
                attribute.name(),
                attribute.value()
            );
        }
        for attribute in node.attributes().filter(|a| ["d", "points"].contains(&a.name())) {
            assert!(!attribute.value().contains("NaN") && !attribute.value().contains("inf"), "{}", attribute.value());
        }
    }
    // One series, two force distributions.
    assert!(drawings >= 3, "{drawings}");
    assert_eq!(page.matches("<img ").count(), 6, "two scenes of three codes");
}

#[test]
fn every_row_stands_in_every_file() {
    let qualification = full();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let page_file = write(&qualification, folder.path()).expect("a report");
    let text = text(&fs::read_to_string(&page_file).expect("the page"));
    for said in [
        "dynamic angle of repose (degrees)",
        "27.13",
        "± 0.31",
        "−0.21",
        "[−0.66, +0.24]",
        "±1.5",
        "shell layer speed ratio",
        "wall torque (10⁻⁴ N m)",
        "2.31",
        "packing fraction",
        "0.5846",
        "±0.006",
        "register 9 seeds",
        "references differ by more than the margin",
        "static angle of repose (degrees)",
        "AVX-512F",
        "instruction set",
        "2023.02a",
        "1.62×10⁻⁵ s",
        "1–5",
    ] {
        assert!(text.contains(said), "{said} is missing");
    }

    let rows: usize = qualification.comparisons.iter().map(|c| c.rows.len()).sum();
    let mut reader = csv::Reader::from_path(page_file.with_file_name("rows.csv")).expect("the rows");
    let records: Vec<csv::StringRecord> = reader.records().collect::<Result<_, _>>().expect("rows of one length");
    assert_eq!(records.len(), rows);
    assert_eq!(&records[0][1], "dynamic_angle_of_repose");
    assert_eq!(records[0][5].parse::<f64>(), Ok(27.13));
    assert_eq!(&records[0][15], "agree");
}

#[test]
fn json_round_trips_to_the_last_bit() {
    let qualification = full();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let page_file = write(&qualification, folder.path()).expect("a report");
    let text = fs::read_to_string(page_file.with_file_name("report.json")).expect("the data");
    let document: ReportDocument = serde_json::from_str(&text).expect("a report");
    assert_eq!(document.version, REPORT_VERSION);
    assert_eq!(document.verdict, qualification.verdict());
    assert_eq!(document.qualification, qualification);
}

#[test]
fn the_verdict_follows_from_the_rows() {
    let verdict = all(Outcome::Agree).verdict();
    assert_eq!((verdict.standing, verdict.agree), (Standing::Agree, 8));
    assert_eq!(verdict.sentence, "Makadam agrees with LIGGGHTS and YADE within the margins in all 8 tests of 1 scene.");

    let mut some = all(Outcome::Agree);
    some.comparisons[0].rows[1].outcome = Some(Outcome::Disagree);
    some.comparisons[0].rows[3].outcome = Some(Outcome::Undecided);
    let verdict = some.verdict();
    assert_eq!((verdict.standing, verdict.agree, verdict.disagree, verdict.undecided), (Standing::Disagree, 6, 1, 1));
    assert!(page(&some).contains(r#"class="verdict disagree""#));

    let verdict = all(Outcome::Undecided).verdict();
    assert_eq!(verdict.standing, Standing::Undecided);
    assert!(verdict.sentence.starts_with("Undecided: of 8 tests"), "{}", verdict.sentence);

    for empty in [sample::qualification(Vec::new()), sample::qualification(vec![sample::alone()])] {
        assert_eq!(empty.verdict().standing, Standing::NothingCompared);
        assert!(text(&page(&empty)).contains("No verdict"));
    }
}

#[test]
fn the_floor_is_no_test_but_is_spoken_of() {
    let mut qualification = all(Outcome::Agree);
    let floor = |row: &&mut Row| row.code == "LIGGGHTS" && row.observable == "gini";
    let row = qualification.comparisons[0].rows.iter_mut().find(floor).expect("a floor");
    row.outcome = Some(Outcome::Disagree);
    assert_eq!(qualification.verdict().standing, Standing::Agree, "it is no test of its own");
    let row = qualification.comparisons[0].rows.iter_mut().find(floor).expect("a floor");
    row.difference = Some(0.05);
    let tests = |row: &&mut Row| row.code == "Makadam" && row.observable == "gini" && row.reference_code.is_some();
    for row in qualification.comparisons[0].rows.iter_mut().filter(tests) {
        row.outcome = Some(Outcome::Undecided);
    }
    let verdict = qualification.verdict();
    assert_eq!((verdict.standing, verdict.undecided, verdict.floor_above_margin), (Standing::Undecided, 2, 2));
    assert!(
        verdict.sentence.contains("none disagrees, 2 undecided. 2 tests undecided because the references differ"),
        "{}",
        verdict.sentence
    );
}

#[test]
fn names_cannot_break_the_page() {
    let mut drum = sample::drum(false);
    let wicked = r#"<script>alert("&'")</script>"#;
    drum.scene.name = wicked.into();
    drum.scene.description = wicked.into();
    drum.notes = vec![wicked.into()];
    for code in &mut drum.codes {
        code.version = wicked.into();
    }
    drum.codes[2].code = wicked.into();
    drum.final_states[2].code = wicked.into();
    drum.series[2].code = wicked.into();
    drum.series[2].observable = wicked.into();
    drum.forces[2].code = wicked.into();
    for row in &mut drum.rows {
        row.unit = wicked.into();
        row.observable = wicked.into();
        row.reference_code = row.reference_code.as_ref().map(|_| wicked.into());
    }
    let mut qualification = sample::qualification(vec![drum]);
    qualification.title = wicked.into();
    qualification.provenance.insert(wicked.into(), wicked.into());
    let page = page(&qualification);
    assert!(!page.contains("<script"));
    assert!(text(&page).contains(wicked));
}

#[test]
fn missing_data_leave_no_empty_figures() {
    let mut bare = sample::drum(false);
    bare.rows.clear();
    bare.codes.clear();
    bare.series.clear();
    bare.forces.clear();
    bare.final_states.clear();
    let page = page(&sample::qualification(vec![bare]));
    let text = text(&page);
    assert!(text.contains("No observable was measured."));
    assert!(!page.contains("<figure"));
}

#[test]
fn odd_data_do_not_break_the_drawings() {
    let mut odd = sample::drum(false);
    odd.final_states[0].particles[0].position[0] = f64::NAN;
    odd.final_states[1].particles.clear();
    odd.final_states[2].particles.truncate(1);
    odd.series[0].value[5] = f64::INFINITY;
    odd.series[1].time.clear();
    odd.series[1].value.clear();
    odd.forces[0].density.fill(0.0);
    odd.rows[0].interval_of_verdict = Some([f64::NEG_INFINITY, f64::NAN]);
    odd.rows[1].difference = Some(1e9);
    odd.rows[2].mean = Some(f64::NAN);
    odd.codes[1].wall_seconds_per_simulated_second = 0.0;
    let page = page(&sample::qualification(vec![odd]));
    parse(&page);
    assert!(!page.contains("NaN"));
}

#[test]
fn what_was_not_measured_is_said_everywhere_and_does_not_pass() {
    let mut qualification = all(Outcome::Agree);
    let missing = |row: &mut Row| {
        (row.mean, row.standard_deviation, row.seeds) = (None, None, 0);
        (row.difference, row.interval90, row.interval_of_verdict) = (None, None, None);
        (row.outcome, row.missing) = (Some(Outcome::NotMeasured), Some("Makadam has no value".into()));
    };
    qualification.comparisons[0].rows[..2].iter_mut().for_each(missing);
    let verdict = qualification.verdict();
    assert_eq!((verdict.standing, verdict.agree, verdict.not_measured), (Standing::NotMeasured, 6, 2));
    assert_eq!(
        verdict.sentence,
        "Not measured: of 8 tests of 1 scene against LIGGGHTS and YADE, 6 agree, none disagrees, 2 not measured."
    );
    let folder = tempfile::tempdir().expect("a temporary folder");
    let page_file = write(&qualification, folder.path()).expect("a report");
    let html = fs::read_to_string(&page_file).expect("the page");
    assert!(text(&html).contains("not measured") && text(&html).contains("Makadam has no value"));
    let json = fs::read_to_string(page_file.with_file_name("report.json")).expect("the data");
    assert!(json.contains(r#""outcome":"not-measured""#) && json.contains(r#""standing":"not-measured""#));
    assert_eq!(serde_json::from_str::<ReportDocument>(&json).expect("a report").qualification, qualification);
    let csv = fs::read_to_string(page_file.with_file_name("rows.csv")).expect("the rows");
    assert_eq!(csv.matches(",not measured,,Makadam has no value").count(), 2, "{csv}");
    let table = comparison_table(&qualification.comparisons[0], false);
    assert!(table.contains("not measured: Makadam has no value"), "{table}");

    // A disagreement goes before, and still the count is told.
    qualification.comparisons[0].rows[3].outcome = Some(Outcome::Disagree);
    let verdict = qualification.verdict();
    assert_eq!(verdict.standing, Standing::Disagree);
    assert!(verdict.sentence.contains("2 not measured"), "{}", verdict.sentence);

    // Nothing at all, or a live value that could not be checked.
    let verdict = all(Outcome::NotMeasured).verdict();
    assert_eq!((verdict.standing, verdict.not_measured), (Standing::NotMeasured, 8));
    let mut unchecked = all(Outcome::Agree);
    unchecked.unchecked.push("drum: live YADE has no gini".into());
    assert_eq!(unchecked.verdict().standing, Standing::NotMeasured);
    assert!(page(&unchecked).contains("drum: live YADE has no gini"));
    let mut failed = all(Outcome::Agree);
    failed.failed_runs.push("drum: the live run of YADE failed: no memory".into());
    let verdict = failed.verdict();
    assert_eq!((verdict.standing, verdict.failed_runs), (Standing::NotMeasured, 1));
    assert!(verdict.sentence.ends_with(" 1 live run of a reference code failed."), "{}", verdict.sentence);
    assert!(page(&failed).contains("the live run of YADE failed: no memory"));
}

#[test]
fn the_verdict_of_the_page_has_its_word_once() {
    for outcome in [Outcome::Agree, Outcome::Disagree, Outcome::Undecided] {
        let html = page(&all(outcome));
        let verdict = html.split_once("<p class=\"verdict").unwrap().1.split_once("</p>").unwrap().0;
        let words = ["Undecided", "Not measured", "No verdict"];
        assert!(words.iter().all(|word| verdict.matches(word).count() <= 1), "{verdict}");
    }
    let undecided = page(&all(Outcome::Undecided));
    assert!(undecided.contains("<strong>Undecided:</strong> of 8 tests"), "{undecided}");
}

#[test]
fn the_terminal_table_fits_eighty_columns() {
    let plain = comparison_table(&sample::packing(), false);
    assert!(!plain.contains('\x1b'));
    // Tables are indented; sentences are left to the terminal.
    let widest = plain.lines().filter(|line| line.starts_with("  ")).map(|line| line.chars().count()).max();
    assert!(widest.is_some_and(|width| (40..=80).contains(&width)), "{plain}");
    // Outcomes of an observable begin in the same column.
    let column = |line: &str| {
        let words = ["  agree", "  disagree", "  undecided"];
        words.iter().find_map(|word| line.find(word)).map(|at| line[..at].chars().count())
    };
    let blocks = plain.split("\n\n").map(|block| block.lines().filter_map(column).collect::<Vec<_>>());
    let blocks: Vec<Vec<usize>> = blocks.filter(|columns| !columns.is_empty()).collect();
    assert_eq!(blocks.concat().len(), 12, "{plain}");
    assert!(blocks.iter().all(|columns| columns.windows(2).all(|pair| pair[0] == pair[1])), "{plain}");
    let coloured = comparison_table(&sample::packing(), true);
    assert!(coloured.contains("\x1b["));
    let alone: Comparison = sample::alone();
    assert!(comparison_table(&alone, false).contains("23.40 (1)"));
}

#[test]
fn a_folder_that_cannot_be_written_is_named() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("occupied");
    fs::write(&file, "not a folder").expect("a file");
    let error = write(&all(Outcome::Agree), &file).expect_err("no report in a file");
    assert!(matches!(error, DocumentError::Write(_)));
    assert!(error.to_string().contains("occupied"), "{error}");
}

#[test]
fn a_failure_leaves_the_earlier_report_whole() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    // A folder in the place of the last file: the rename fails.
    fs::create_dir(folder.path().join("rows.csv")).expect("a folder");
    write(&all(Outcome::Agree), folder.path()).expect_err("rows.csv is a folder");
    let left: Vec<_> = fs::read_dir(folder.path()).expect("a folder").flatten().map(|e| e.file_name()).collect();
    assert!(!left.iter().any(|name| name.to_string_lossy().ends_with(".part")), "{left:?}");
}

#[test]
fn a_report_of_three_scenes_is_small() {
    let bytes = full_page().len();
    assert!(bytes < 3_000_000, "{bytes} bytes");
}

/// A ratio of speeds is taken between live runs that were timed alone.
#[test]
fn speeds_are_of_runs_timed_alone() {
    let told = |comparison: &Comparison| {
        let table = comparison_table(comparison, false);
        table.lines().find(|line| line.starts_with("time per simulated second: ")).expect("speeds").to_string()
    };
    assert_eq!(
        told(&sample::drum(false)),
        "time per simulated second: Makadam 0.92 s; LIGGGHTS 3.1 s (3.4 times); YADE 14 s (15 times)"
    );
    let recorded = told(&sample::drum(true));
    assert!(recorded.ends_with("YADE 14 s, recorded"), "{recorded}");
    let mut side_by_side = sample::drum(false);
    side_by_side.codes[1].timing = Timing::SideBySide;
    side_by_side.codes[2].timing = Timing::Measuring;
    assert_eq!(told(&side_by_side), "time per simulated second: Makadam 0.92 s");
    let text = text(&page(&sample::qualification(vec![side_by_side])));
    assert!(text.contains("not timed") && text.contains("0.92 s") && !text.contains("3.1 s"), "{text}");
    let mut elsewhere = sample::drum(false);
    elsewhere.codes[1].processor = "another".into();
    assert!(told(&elsewhere).contains("LIGGGHTS 3.1 s; YADE 14 s (15 times)"), "{}", told(&elsewhere));
}
