//! What the user sees: results on standard output, everything else on standard error.

use super::failure::Failure;
use crate::output::shown;
use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{ErrorKind, IsTerminal, Write};

/// Where messages go, and how many of them.
pub struct Console {
    quiet: bool,
    verbose: bool,
    colour: bool,
    bars: MultiProgress,
}

impl Console {
    /// Progress is drawn only on a terminal and unless `quiet`; colours follow `NO_COLOR`.
    pub fn new(quiet: bool, verbose: bool) -> Console {
        let drawn = !quiet && std::io::stderr().is_terminal();
        let target = if drawn { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let colour =
            std::io::stdout().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty());
        Console { quiet, verbose, colour, bars: MultiProgress::with_draw_target(target) }
    }

    /// Prints a result.
    ///
    /// # Errors
    /// [`Failure`] if standard output is closed or full.
    pub fn result(&self, text: &str) -> Result<(), Failure> {
        self.page(&shown(text, self.colour))
    }

    /// Prints a text of the program's own, whatever characters it holds.
    ///
    /// # Errors
    /// As [`Console::result`].
    pub(super) fn page(&self, text: &str) -> Result<(), Failure> {
        let mut output = std::io::stdout().lock();
        output.write_all(text.as_bytes()).and_then(|()| output.write_all(b"\n")).and_then(|()| output.flush()).map_err(
            |error| match error.kind() {
                ErrorKind::BrokenPipe => Failure::ClosedOutput,
                _ => Failure::Running(format!("standard output: {error}; check that the disk has room")),
            },
        )
    }

    /// Says something that a user should know, unless quiet.
    pub fn note(&self, text: &str) {
        if !self.quiet {
            self.say(text);
        }
    }

    /// Says something that only a curious user wants to know.
    pub fn detail(&self, text: &str) {
        if self.verbose && !self.quiet {
            self.say(text);
        }
    }

    /// Says something whatever the verbosity.
    pub fn warn(&self, text: &str) {
        self.say(&format!("warning: {text}"));
    }

    /// Says why the command failed, whatever the verbosity.
    pub fn error(&self, text: &str) {
        self.say(&format!("error: {text}"));
    }

    fn say(&self, text: &str) {
        // A closed standard error is no reason to stop.
        self.bars.suspend(|| {
            let _ = writeln!(std::io::stderr(), "{}", shown(text, false));
        });
    }

    /// A progress bar over a share of work, 0 to 1.
    pub fn bar(&self, label: &str) -> Bar {
        let style = ProgressStyle::with_template("{prefix:<24} [{wide_bar}] {percent:>3}% {msg} {eta} left")
            .unwrap_or_else(|_| ProgressStyle::default_bar());
        let bar = self.bars.add(ProgressBar::new(Bar::TICKS));
        bar.set_style(style.progress_chars("=> "));
        bar.set_prefix(shown(label, false).into_owned());
        Bar { bar }
    }

    /// Whether standard output wants colours.
    pub fn colour(&self) -> bool {
        self.colour
    }

    /// A word in green (good) or red (bad) where colours are wanted.
    pub fn paint(&self, word: &str, good: bool) -> String {
        match (self.colour, good) {
            (false, _) => word.to_string(),
            (true, true) => format!("\x1b[32m{word}\x1b[0m"),
            (true, false) => format!("\x1b[31m{word}\x1b[0m"),
        }
    }
}

/// A progress bar; it goes away when dropped.
pub struct Bar {
    bar: ProgressBar,
}

impl Bar {
    const TICKS: u64 = 10_000;

    /// Sets the share that is done.
    pub fn set(&self, share: f64) {
        self.bar.set_position((share.clamp(0.0, 1.0) * Self::TICKS as f64) as u64);
    }

    /// Sets the text beside the bar.
    pub fn say(&self, text: String) {
        self.bar.set_message(shown(&text, false).into_owned());
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
