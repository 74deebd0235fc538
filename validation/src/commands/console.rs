//! Output of commands: results on standard output, all other messages on standard error.

use super::{Failure, json};
use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};
use makadam_compare::compare::Share;
use makadam_compare::study::Document;
use makadam_frames::output::shown;
use std::ffi::OsStr;
use std::io::{ErrorKind, IsTerminal, Write};
use std::path::Path;

/// Standard output and standard error of a command.
pub struct Console {
    quiet: bool,
    verbose: bool,
    /// True for colours on standard output.
    colour: bool,
    /// True for colours on standard error.
    colour_of_errors: bool,
    bars: MultiProgress,
}

impl Console {
    /// Makes a console. Progress is drawn only on a terminal and unless `quiet`; colours follow `NO_COLOR`.
    pub fn new(quiet: bool, verbose: bool) -> Console {
        let drawn = !quiet && std::io::stderr().is_terminal();
        let target = if drawn { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let no_colour = std::env::var_os("NO_COLOR");
        let wanted = |is_terminal| wants_colour(is_terminal, no_colour.as_deref());
        Console {
            quiet,
            verbose,
            colour: wanted(std::io::stdout().is_terminal()),
            colour_of_errors: wanted(std::io::stderr().is_terminal()),
            bars: MultiProgress::with_draw_target(target),
        }
    }

    /// Prints a result.
    ///
    /// # Errors
    /// [`Failure`] if standard output is closed or full.
    pub fn result(&self, text: &str) -> Result<(), Failure> {
        self.page(&shown(text, self.colour))
    }

    /// Prints a text of the program's own, without sanitizing it.
    pub(super) fn page(&self, text: &str) -> Result<(), Failure> {
        let mut output = std::io::stdout().lock();
        output.write_all(text.as_bytes()).and_then(|()| output.write_all(b"\n")).and_then(|()| output.flush()).map_err(
            |error| match error.kind() {
                ErrorKind::BrokenPipe => Failure::ClosedOutput,
                _ => Failure::Running(format!("standard output: {error}; check that the disk has room")),
            },
        )
    }

    /// Prints a message, unless quiet.
    pub fn note(&self, text: &str) {
        if !self.quiet {
            self.say("", Colour::Plain, text);
        }
    }

    /// Prints a message if verbose.
    pub fn detail(&self, text: &str) {
        if self.verbose && !self.quiet {
            self.say("", Colour::Plain, text);
        }
    }

    /// Prints a warning at any verbosity.
    pub fn warn(&self, text: &str) {
        self.say("warning: ", Colour::Yellow, text);
    }

    /// Prints an error at any verbosity.
    pub fn error(&self, text: &str) {
        self.say("error: ", Colour::Red, text);
    }

    fn say(&self, kind: &str, colour: Colour, text: &str) {
        let kind = if self.colour_of_errors { colour.paint(kind) } else { kind.to_string() };
        // A closed standard error does not stop the program.
        self.bars.suspend(|| {
            let _ = writeln!(std::io::stderr(), "{kind}{}", shown(text, false));
        });
    }

    /// Opens a progress bar over the completed fraction of work, 0 to 1.
    pub fn bar(&self, label: &str) -> Bar {
        let style = ProgressStyle::with_template("{prefix:<24} [{wide_bar}] {percent:>3}% {msg} {eta} left")
            .unwrap_or_else(|_| ProgressStyle::default_bar());
        let bar = self.bars.add(ProgressBar::new(Bar::TICKS));
        bar.set_style(style.progress_chars("=> "));
        bar.set_prefix(shown(label, false).into_owned());
        Bar { bar }
    }

    /// Returns a function that opens progress bars by their labels.
    pub(super) fn bars(&self) -> impl Fn(&str) -> Share + Sync {
        |label| {
            let bar = self.bar(label);
            Box::new(move |fraction| bar.set(fraction))
        }
    }

    /// Prints a document as JSON, or as its text.
    pub(super) fn document(
        &self,
        document: &impl serde::Serialize,
        as_json: bool,
        text: impl FnOnce() -> String,
    ) -> Result<(), Failure> {
        self.result(&if as_json { json(document) } else { text() })
    }

    /// Writes a study into a folder and prints it in full, or its tables and the path of its page.
    pub(super) fn publish(&self, study: &impl Document, folder: &Path, as_json: bool) -> Result<(), Failure> {
        let page = study.write(folder)?;
        self.document(study, as_json, || format!("{}\npage: {}", study.report().text(), page.display()))
    }

    /// Returns true for colours on standard output.
    pub fn colour(&self) -> bool {
        self.colour
    }

    /// Colours a text for standard output, if colours are enabled.
    pub fn paint(&self, text: &str, colour: Colour) -> String {
        if self.colour { colour.paint(text) } else { text.to_string() }
    }
}

/// Returns true for a stream with colours: a terminal, unless `NO_COLOR` is set and not empty.
fn wants_colour(is_terminal: bool, no_colour: Option<&OsStr>) -> bool {
    is_terminal && no_colour.is_none_or(OsStr::is_empty)
}

/// Colours of texts on a terminal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colour {
    /// Default colour of the terminal.
    Plain,
    /// Colour of passes.
    Green,
    /// Colour of warnings and of undecided verdicts.
    Yellow,
    /// Colour of errors and failures.
    Red,
}

impl Colour {
    fn paint(self, text: &str) -> String {
        match self {
            Colour::Plain => text.to_string(),
            Colour::Green => format!("\x1b[32m{text}\x1b[0m"),
            Colour::Yellow => format!("\x1b[33m{text}\x1b[0m"),
            Colour::Red => format!("\x1b[31;1m{text}\x1b[0m"),
        }
    }
}

/// Progress bar, removed when dropped.
pub struct Bar {
    bar: ProgressBar,
}

impl Bar {
    const TICKS: u64 = 10_000;

    /// Sets the completed fraction.
    pub fn set(&self, share: f64) {
        self.bar.set_position((share.clamp(0.0, 1.0) * Self::TICKS as f64) as u64);
    }

    /// Sets the text next to the bar.
    pub fn say(&self, text: String) {
        self.bar.set_message(shown(&text, false).into_owned());
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

#[cfg(test)]
#[path = "../../tests/unit/commands_console.rs"]
mod tests;
