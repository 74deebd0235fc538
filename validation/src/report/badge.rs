//! The verdict as a badge: a small picture for a page that links to the report.

use super::qualification::{Qualification, Standing};
use crate::draw::numbers::plural;
use crate::draw::svg::escape;

/// Width of a letter at 11 pixels, on the safe side.
const LETTER: usize = 7;

/// The badge as SVG.
pub(super) fn svg(qualification: &Qualification) -> String {
    let verdict = qualification.verdict();
    let (agree, tests) = (verdict.passed(), verdict.tests());
    let of_studies = verdict.studies.iter().map(|study| study.not_measured.len()).sum::<usize>();
    let untold = verdict.not_measured + verdict.differences_not_measured + of_studies;
    let (word, colour) = match verdict.standing {
        Standing::Agree => ("agree", "#2a7a2f"),
        Standing::Disagree => ("agree", "#b3261e"),
        Standing::Exploratory => ("agree, of seeds that are not registered", "#8a6100"),
        Standing::Undecided => ("agree, others undecided", "#8a6100"),
        Standing::NotMeasured if untold == 0 => ("agree, live runs failed or unchecked", "#8a6100"),
        Standing::NotMeasured => ("agree, others not measured", "#8a6100"),
        Standing::NothingCompared => ("", "#5f6368"),
    };
    let right = match verdict.standing {
        Standing::NothingCompared => "nothing compared".to_string(),
        _ => format!("{agree} of {tests} tests {word}"),
    };
    let right = match verdict.studies.iter().map(|study| study.known_exceptions.len()).sum() {
        0 => right,
        known => format!("{right}, {}", plural(known, "known exception")),
    };
    let left = format!("{} qualification", qualification.tier);
    let [first, second] = [&left, &right].map(|text| LETTER * text.chars().count() + 16);
    let width = first + second;
    let middles = [first / 2, first + second / 2];
    let title = escape(&format!("{left}: {right}"));
    let text = |x: usize, words: &str| format!("<text x=\"{x}\" y=\"14\">{}</text>", escape(words));
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"20\" role=\"img\" aria-label=\"{title}\">\
         <title>{title}</title><rect width=\"{first}\" height=\"20\" fill=\"#3c4043\"/>\
         <rect x=\"{first}\" width=\"{second}\" height=\"20\" fill=\"{colour}\"/>\
         <g fill=\"#fff\" text-anchor=\"middle\" font-family=\"Verdana,DejaVu Sans,sans-serif\" font-size=\"11\">{}{}</g></svg>\n",
        text(middles[0], &left),
        text(middles[1], &right),
    )
}
