//! One table, shown on a terminal, on a page and in Markdown.

use crate::draw::columns;
use crate::draw::svg::escape;
use std::fmt::Write;

/// A table of finished texts: heads and rows of as many cells.
pub(crate) struct Table {
    heads: Vec<Head>,
    rows: Vec<Row>,
}

struct Head {
    short: String,
    long: String,
    is_words: bool,
}

struct Row {
    cells: Vec<Cell>,
    /// Whether it is the first of a group.
    first: bool,
}

/// A cell: a text, or nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Cell {
    text: Option<String>,
    below: Option<String>,
    mark: Option<String>,
    strong: bool,
}

impl Table {
    /// A table of these columns, words first, then numbers.
    pub(crate) fn new(words: &[&str], numbers: &[&str]) -> Table {
        let words = words.iter().map(|head| (head, true));
        let numbers = numbers.iter().map(|head| (head, false));
        let head = |(head, is_words): (&&str, bool)| Head { short: head.to_string(), long: head.to_string(), is_words };
        Table { heads: words.chain(numbers).map(head).collect(), rows: Vec::new() }
    }

    /// Adds a column of words.
    pub(crate) fn with_words(mut self, head: &str) -> Table {
        self.heads.push(Head { short: head.into(), long: head.into(), is_words: true });
        self
    }

    /// Adds columns of numbers.
    pub(crate) fn with_numbers<T: AsRef<str>>(mut self, heads: impl IntoIterator<Item = T>) -> Table {
        let head = |head: T| Head { short: head.as_ref().into(), long: head.as_ref().into(), is_words: false };
        self.heads.extend(heads.into_iter().map(head));
        self
    }

    /// Gives the columns from the last one with other heads on a page, where there is more room.
    pub(crate) fn on_a_page(mut self, long: &[&str]) -> Table {
        let from = self.heads.len() - long.len();
        self.heads[from..].iter_mut().zip(long).for_each(|(head, long)| head.long = long.to_string());
        self
    }

    /// Adds a row.
    pub(crate) fn row(&mut self, cells: impl IntoIterator<Item = Cell>) {
        self.rows.push(Row { cells: cells.into_iter().collect(), first: false });
    }

    /// Adds the first row of a group.
    pub(crate) fn first_row(&mut self, cells: impl IntoIterator<Item = Cell>) {
        self.row(cells);
        self.rows.last_mut().expect("it was added").first = true;
    }

    /// The table with a row of each.
    pub(crate) fn of<T>(mut self, items: impl IntoIterator<Item = T>, cells: impl Fn(T) -> Vec<Cell>) -> Table {
        items.into_iter().for_each(|item| self.row(cells(item)));
        self
    }

    /// Whether it has no rows.
    pub(crate) fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Aligned plain text: words to the left, numbers to the right, "-" where there is nothing.
    pub(crate) fn text(&self) -> String {
        let heads: Vec<String> = self.heads.iter().map(|head| head.short.clone()).collect();
        let plain = |cell: &Cell| cell.text.clone().unwrap_or_else(|| "-".into());
        let rows = self.rows.iter().map(|row| row.cells.iter().map(plain).collect::<Vec<_>>());
        columns(&[heads].into_iter().chain(rows).collect::<Vec<_>>(), |column| self.heads[column].is_words)
    }

    /// An element of a page that scrolls where it is too wide; the first column of words names its row.
    pub(crate) fn html(&self) -> String {
        let mut html = String::from("<div class=\"scroll\">\n<table>\n<thead><tr>");
        for head in &self.heads {
            let class = if head.is_words { "" } else { " class=\"num\"" };
            let _ = write!(html, "<th{class}>{}</th>", escape(&head.long));
        }
        html += "</tr></thead>\n<tbody>\n";
        for row in &self.rows {
            html += if row.first { "<tr class=\"first\">" } else { "<tr>" };
            for (column, (cell, head)) in row.cells.iter().zip(&self.heads).enumerate() {
                html += &match (column, head.is_words) {
                    (0, true) => format!("<th scope=\"row\">{}</th>", cell.html()),
                    (_, true) => format!("<td class=\"setting\">{}</td>", cell.html()),
                    (_, false) => format!("<td class=\"num\">{}</td>", cell.html()),
                };
            }
            html += "</tr>\n";
        }
        html + "</tbody>\n</table>\n</div>"
    }

    /// A table in Markdown, empty cells where there is nothing.
    pub(crate) fn markdown(&self) -> String {
        let line = |cells: Vec<&str>| format!("| {} |\n", cells.join(" | "));
        let rows = self.rows.iter().map(|row| line(row.cells.iter().map(Cell::plain).collect()));
        let heads = line(self.heads.iter().map(|head| head.long.as_str()).collect());
        heads + &line(vec!["---"; self.heads.len()]) + &rows.collect::<String>()
    }
}

impl Cell {
    /// The same with a smaller text below on a page, if there is one.
    pub(crate) fn above(self, below: Option<String>) -> Cell {
        Cell { below, ..self }
    }

    /// The same behind a mark of these style classes.
    pub(crate) fn marked(self, classes: impl Into<String>) -> Cell {
        Cell { mark: Some(classes.into()), ..self }
    }

    /// The same in bold on a page, if so.
    pub(crate) fn strong(self, strong: bool) -> Cell {
        Cell { strong, ..self }
    }

    fn plain(&self) -> &str {
        self.text.as_deref().unwrap_or_default()
    }

    fn html(&self) -> String {
        let text = escape(self.text.as_deref().unwrap_or("–"));
        let text = if self.strong { format!("<strong>{text}</strong>") } else { text };
        let mark = self.mark.as_ref().map(|classes| format!("<span class=\"swatch {}\"></span>", escape(classes)));
        let below = self.below.as_ref().map(|below| format!("<span class=\"interval\">{}</span>", escape(below)));
        mark.unwrap_or_default() + &text + &below.unwrap_or_default()
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Cell {
        Cell { text: Some(text), ..Cell::default() }
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Cell {
        text.to_string().into()
    }
}

impl From<usize> for Cell {
    fn from(number: usize) -> Cell {
        number.to_string().into()
    }
}

impl<T: Into<Cell>> From<Option<T>> for Cell {
    fn from(text: Option<T>) -> Cell {
        text.map_or_else(Cell::default, Into::into)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_table_is_shown_in_three_ways() {
        let mut table = Table::new(&["code"], &["s"]).on_a_page(&["seconds"]).with_words("verdict");
        table.first_row(["a<b".into(), Cell::from("12").above(Some("11 to 13".into())), "within".into()]);
        table.row([Cell::from("c").marked("code-c"), None::<String>.into(), Cell::from("beyond").strong(true)]);
        assert_eq!(table.text(), "code   s  verdict\na<b   12  within\nc      -  beyond\n");
        assert_eq!(
            table.markdown(),
            "| code | seconds | verdict |\n| --- | --- | --- |\n| a<b | 12 | within |\n| c |  | beyond |\n"
        );
        let html = table.html();
        for part in [
            "<th>code</th><th class=\"num\">seconds</th><th>verdict</th>",
            "<tr class=\"first\"><th scope=\"row\">a&lt;b</th><td class=\"num\">12<span class=\"interval\">11 to 13</span></td>",
            "<th scope=\"row\"><span class=\"swatch code-c\"></span>c</th><td class=\"num\">–</td>",
            "<strong>beyond</strong>",
        ] {
            assert!(html.contains(part), "{part} in\n{html}");
        }
    }
}
