//! Tables on a terminal, on a page, in Markdown, as CSV.

use super::document::{DocumentError, File};
use makadam_frames::output::cells::csv_below;
use makadam_view::draw::columns;
use makadam_view::draw::svg::escape;
use serde::Serialize;
use serde_json::{Map, Value};
use std::fmt::Write;

/// Makes the cells of a row.
#[macro_export]
macro_rules! cells {
    ($($cell:expr),* $(,)?) => { vec![$($crate::study::Cell::from($cell)),*] };
}
pub use crate::cells;

/// Heads, and rows with as many cells.
pub struct Table {
    class: &'static str,
    heads: Vec<Head>,
    rows: Vec<Row>,
}

struct Head {
    short: String,
    long: Cell,
    is_words: bool,
    /// Style class of the column.
    class: &'static str,
}

impl Head {
    fn new(long: impl Into<Cell>, is_words: bool) -> Head {
        let long = long.into();
        Head { short: long.plain().into(), long, is_words, class: "" }
    }
}

struct Row {
    cells: Vec<Cell>,
    /// True of the first row of a group.
    first: bool,
}

/// Text, or an empty cell.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cell {
    text: Option<String>,
    /// Value behind the text, at full precision; absent where the text is the value.
    raw: Option<Raw>,
    /// Style classes and texts below on a page.
    below: Vec<(String, String)>,
    mark: Option<String>,
    strong: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
enum Raw {
    Number(f64),
    Count(u64),
    Truth(bool),
}

impl Table {
    /// Returns a table of columns of numbers; spaces separate their names.
    pub fn named(names: &str) -> Table {
        Table::new(&[], &names.split_whitespace().collect::<Vec<_>>())
    }

    /// Returns a table of columns of text, then of numbers.
    pub fn new(words: &[&str], numbers: &[&str]) -> Table {
        let words = words.iter().map(|head| Head::new(*head, true));
        let numbers = numbers.iter().map(|head| Head::new(*head, false));
        Table { class: "", heads: words.chain(numbers).collect(), rows: Vec::new() }
    }

    /// Returns the table with a class of its own on the page.
    pub fn styled(self, class: &'static str) -> Table {
        Table { class, ..self }
    }

    /// Adds a column of text.
    pub fn with_words(mut self, head: &str) -> Table {
        self.heads.push(Head::new(head, true));
        self
    }

    /// Adds columns of numbers.
    pub fn with_numbers<T: AsRef<str>>(mut self, heads: impl IntoIterator<Item = T>) -> Table {
        self.heads.extend(heads.into_iter().map(|head| Head::new(head.as_ref(), false)));
        self
    }

    /// Adds columns of numbers, each with its head on a page and a style class.
    pub fn with_columns(mut self, heads: impl IntoIterator<Item = (Cell, &'static str)>) -> Table {
        self.heads.extend(heads.into_iter().map(|(head, class)| Head { class, ..Head::new(head, false) }));
        self
    }

    /// Sets the style class of the last column.
    pub fn of_class(mut self, class: &'static str) -> Table {
        self.heads.iter_mut().last().expect("a column").class = class;
        self
    }

    /// Gives the last columns longer heads on a page.
    pub fn on_a_page(mut self, long: &[&str]) -> Table {
        let from = self.heads.len() - long.len();
        self.heads[from..].iter_mut().zip(long).for_each(|(head, long)| head.long = (*long).into());
        self
    }

    /// Adds a row, with as many cells as there are heads.
    pub fn row(&mut self, cells: impl IntoIterator<Item = Cell>) {
        self.rows.push(Row { cells: cells.into_iter().collect(), first: false });
    }

    /// Adds the first row of a group.
    pub fn first_row(&mut self, cells: impl IntoIterator<Item = Cell>) {
        self.row(cells);
        self.rows.last_mut().expect("it was added").first = true;
    }

    /// Adds a row per item.
    pub fn of<T>(mut self, items: impl IntoIterator<Item = T>, cells: impl Fn(T) -> Vec<Cell>) -> Table {
        items.into_iter().for_each(|item| self.row(cells(item)));
        self
    }

    /// Adds rows of fields by the names of the columns; absent fields are empty cells.
    pub fn of_fields(mut self, items: impl IntoIterator<Item = Map<String, Value>>) -> Table {
        for fields in items {
            let cells: Vec<Cell> = self
                .heads
                .iter()
                .map(|head| fields.get(head.long.plain()).map_or_else(Cell::default, Cell::from))
                .collect();
            self.row(cells);
        }
        self
    }

    /// Adds a group of rows; the first one begins with the group's name.
    pub fn group<T>(&mut self, name: &str, items: impl IntoIterator<Item = T>, cells: impl Fn(T) -> Vec<Cell>) {
        for (place, item) in items.into_iter().enumerate() {
            let name = if place == 0 { name } else { "" };
            let cells = [Cell::from(name)].into_iter().chain(cells(item)).collect();
            self.rows.push(Row { cells, first: place == 0 });
        }
    }

    /// Returns true if the table has no row.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Aligned plain text: text to the left, numbers to the right, "-" for empty cells, "*" behind bold cells.
    pub(crate) fn text(&self) -> String {
        let heads: Vec<String> = self.heads.iter().map(|head| head.short.clone()).collect();
        let plain = |(column, cell): (usize, &Cell)| {
            let text = cell.text.as_deref().unwrap_or("-");
            let any = self.rows.iter().any(|row| row.cells[column].strong);
            let star = if !any {
                ""
            } else if cell.strong {
                " *"
            } else {
                "  "
            };
            format!("{text}{star}")
        };
        let rows = self.rows.iter().map(|row| row.cells.iter().enumerate().map(plain).collect::<Vec<_>>());
        columns(&[heads].into_iter().chain(rows).collect::<Vec<_>>(), |column| self.heads[column].is_words)
    }

    /// Element of a page that scrolls where it is too wide; the first column of text names its row.
    pub fn html(&self) -> String {
        let mut html = format!("<div class=\"scroll\">\n<table{}>\n<thead><tr>", class(self.class));
        for head in &self.heads {
            let kind = if head.is_words { "" } else { "num" };
            let _ = write!(html, "<th{}>{}</th>", class(&format!("{kind} {}", head.class)), head.long.html());
        }
        html += "</tr></thead>\n<tbody>\n";
        for row in &self.rows {
            html += if row.first { "<tr class=\"first\">" } else { "<tr>" };
            for (column, (cell, head)) in row.cells.iter().zip(&self.heads).enumerate() {
                let kind = match (head.is_words, head.class) {
                    (false, _) => "num",
                    (true, "") => "setting",
                    (true, _) => "",
                };
                html += &match (column, head.is_words) {
                    (0, true) => format!("<th scope=\"row\">{}</th>", cell.html()),
                    _ => format!("<td{}>{}</td>", class(&format!("{kind} {}", head.class)), cell.html()),
                };
            }
            html += "</tr>\n";
        }
        html + "</tbody>\n</table>\n</div>"
    }

    /// File NAME.csv: numbers at full precision, empty cells for missing values; with a head even if there are no rows.
    pub fn csv(&self, name: &str) -> Result<File, DocumentError> {
        let heads: Vec<&str> = self.heads.iter().map(|head| head.short.as_str()).collect();
        let rows = self.rows.iter().map(|row| row.cells.iter().map(Cell::written).collect::<Vec<_>>());
        Ok((format!("{name}.csv"), csv_below(&heads, rows)?))
    }

    /// Table in Markdown, with empty cells for missing values.
    pub(crate) fn markdown(&self) -> String {
        let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
        let plain = |cell: &Cell| if cell.strong { format!("**{}**", cell.plain()) } else { cell.plain().into() };
        let rows = self.rows.iter().map(|row| line(row.cells.iter().map(plain).collect()));
        let heads = line(self.heads.iter().map(|head| plain(&head.long)).collect());
        heads + &line(vec!["---".into(); self.heads.len()]) + &rows.collect::<String>()
    }
}

/// A cell of a CSV file.
#[derive(Serialize)]
#[serde(untagged)]
enum Written<'a> {
    Raw(Raw),
    Text(&'a str),
}

impl Cell {
    /// Adds a smaller text below, on a page.
    pub fn above(self, below: Option<String>) -> Cell {
        self.with("interval", below)
    }

    /// Adds style class and name of an outcome, on a page.
    pub fn outcome(self, outcome: Option<(&'static str, &'static str)>) -> Cell {
        let classes = format!("outcome {}", outcome.map_or("", |(class, _)| class));
        self.with(&classes, outcome.map(|(_, word)| word.into()))
    }

    fn with(mut self, classes: &str, below: Option<String>) -> Cell {
        self.below.extend(below.map(|below| (classes.to_string(), below)));
        self
    }

    /// Adds a mark of these style classes in front.
    pub fn marked(self, classes: impl Into<String>) -> Cell {
        Cell { mark: Some(classes.into()), ..self }
    }

    /// Sets bold type on a page and in Markdown, and a star on a terminal.
    pub fn strong(self, strong: bool) -> Cell {
        Cell { strong, ..self }
    }

    fn written(&self) -> Written<'_> {
        self.raw.map_or_else(|| Written::Text(self.plain()), Written::Raw)
    }

    fn plain(&self) -> &str {
        self.text.as_deref().unwrap_or_default()
    }

    fn html(&self) -> String {
        let absent = if self.below.is_empty() { "–" } else { "" };
        let text = escape(self.text.as_deref().unwrap_or(absent));
        let text = if self.strong { format!("<strong>{text}</strong>") } else { text };
        let mark = self.mark.as_ref().map(|classes| format!("<span class=\"swatch {}\"></span>", escape(classes)));
        let below =
            self.below.iter().map(|(classes, text)| format!("<span class=\"{classes}\">{}</span>", escape(text)));
        mark.unwrap_or_default() + &text + &below.collect::<String>()
    }
}

/// Attribute of style classes; empty without any.
fn class(classes: &str) -> String {
    let classes = classes.trim();
    if classes.is_empty() { String::new() } else { format!(" class=\"{classes}\"") }
}

macro_rules! cell_of_text {
    ($($type:ty),*) => {
        $(impl From<$type> for Cell {
            fn from(text: $type) -> Cell {
                Cell { text: Some(text.into()), ..Cell::default() }
            }
        })*
    };
}
cell_of_text!(String, &str, &String);

impl From<Raw> for Cell {
    fn from(raw: Raw) -> Cell {
        let text = match raw {
            Raw::Number(number) => number.to_string(),
            Raw::Count(count) => count.to_string(),
            Raw::Truth(truth) => if truth { "yes" } else { "no" }.into(),
        };
        Cell { raw: Some(raw), ..text.into() }
    }
}

impl From<&Value> for Cell {
    fn from(value: &Value) -> Cell {
        match value {
            Value::String(text) => text.into(),
            Value::Bool(truth) => (*truth).into(),
            Value::Number(number) => match number.as_u64() {
                Some(count) => count.into(),
                None => number.as_f64().into(),
            },
            Value::Null | Value::Array(_) | Value::Object(_) => Cell::default(),
        }
    }
}

macro_rules! cell_of {
    ($($type:ty => $raw:expr),*) => {
        $(impl From<$type> for Cell {
            fn from(value: $type) -> Cell {
                $raw(value.into()).into()
            }
        })*
    };
}
cell_of!(f64 => Raw::Number, u32 => Raw::Count, u64 => Raw::Count, bool => Raw::Truth);

impl From<usize> for Cell {
    fn from(count: usize) -> Cell {
        Raw::Count(count as u64).into()
    }
}

impl<T: Into<Cell>> From<Option<T>> for Cell {
    fn from(text: Option<T>) -> Cell {
        text.map_or_else(Cell::default, Into::into)
    }
}

#[cfg(test)]
#[path = "../../tests/unit/study_table.rs"]
mod tests;
