//! The frame of a page: one file that loads nothing, runs no script, follows light and dark, and prints.

use crate::draw::figure::Figure;
use minijinja::{AutoEscape, Environment, Value, context};

/// Style sheet of a page with figures.
pub(crate) fn style() -> &'static str {
    concat!(include_str!("../draw/figure.css"), include_str!("page.css"))
}

/// Templates whose every value is escaped, with the parts that all pages share: "head" takes `title` and `style`,
/// "answer" takes `answer`, "figures" takes `figures`, "provenance" takes pairs.
pub(crate) fn environment() -> Result<Environment<'static>, minijinja::Error> {
    let mut environment = Environment::new();
    environment.set_trim_blocks(true);
    environment.set_lstrip_blocks(true);
    environment.set_auto_escape_callback(|_| AutoEscape::Html);
    environment.add_template("head", include_str!("head.html"))?;
    environment.add_template("answer", include_str!("answer.html"))?;
    environment.add_template("figures", include_str!("figures.html"))?;
    environment.add_template("provenance", include_str!("provenance.html"))?;
    Ok(environment)
}

/// The page of a study: its template with a title, figures, where it came from by name, and what else the template takes.
pub(crate) fn page<K: AsRef<str>>(
    template: &'static str,
    title: &str,
    figures: &[Figure],
    provenance: impl IntoIterator<Item = (K, String)>,
    others: Value,
) -> Result<String, minijinja::Error> {
    let mut environment = environment()?;
    environment.add_template("page", template)?;
    let provenance = provenance.into_iter().map(|(key, value)| (key.as_ref().replace('_', " "), value));
    let provenance = provenance.collect::<Vec<_>>();
    environment.get_template("page")?.render(context! { title, style => style(), figures, provenance, ..others })
}
