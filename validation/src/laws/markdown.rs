//! Laws as a page in Markdown: figures with their bounds, and the drawings that lie beside it in the folder of each law.

use super::{LawResult, all, in_words};
use crate::study::{Cell, Table};

/// A section a law.
pub(crate) fn markdown(results: &[LawResult]) -> String {
    let mut text = String::from("# Published laws\n");
    for result in results {
        let table = Table::new(&["figure", "value", "bounds", ""], &[]).of(&result.findings, |finding| {
            let [value, bounds] = in_words(finding);
            let verdict = match (finding.bounds(), finding.holds()) {
                ([None, None], _) => "",
                (_, true) => "within",
                (_, false) => "**outside**",
            };
            [finding.what.clone(), value, bounds, verdict.into()].map(Cell::from).into()
        });
        let name = result.name;
        text += &format!("\n## {name}\n\n{}. {}\n\n{}", result.statement, result.source, table.markdown());
        let law = all().into_iter().find(|law| law.name() == name).expect("a result is of a law");
        for figure in law.figures(&result.means) {
            text += &format!("\n![{}]({name}/{}.svg)\n", figure.caption, figure.name);
        }
    }
    text
}
