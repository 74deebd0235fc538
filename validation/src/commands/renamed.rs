//! Former names of commands and options: the error message states the present name.

use super::Arguments;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use std::ffi::OsString;

/// Former and present names of commands.
const COMMANDS: [(&str, &str); 11] = [
    ("animate", "picture RUN --output FILE.gif"),
    ("completions", "print completions"),
    ("convergence", "lab convergence"),
    ("judge", "compare SCENE --own-code FILE"),
    ("manual", "print manual"),
    ("observables", "print observables"),
    ("problem", "lab problem"),
    ("reports", "qualify --against REPORT"),
    ("scaling", "lab scaling"),
    ("scenes", "print scenes"),
    ("schema", "print schema"),
];

/// Former and present names of options.
const OPTIONS: [(&str, &str); 4] =
    [("again", "restart"), ("against", "codes"), ("code", "own-code"), ("threads", "jobs")];

/// Adds the present name to the error about a former name.
pub fn with_new_name(mut error: clap::Error, words: &[OsString]) -> clap::Error {
    let tip = match (error.kind(), error.get(ContextKind::InvalidSubcommand), error.get(ContextKind::InvalidArg)) {
        (ErrorKind::InvalidSubcommand, Some(ContextValue::String(name)), _) => {
            let known = COMMANDS.iter().find(|(former, _)| former == name);
            known.map(|(_, present)| format!("this command is now 'makadam {present}'"))
        }
        (ErrorKind::UnknownArgument, _, Some(ContextValue::String(name))) => option(name, words),
        _ => None,
    };
    if let Some(tip) = tip {
        error.remove(ContextKind::SuggestedArg);
        error.remove(ContextKind::SuggestedSubcommand);
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
    }
    error
}

/// Returns the tip for the former name of an option, if the command has the present one.
fn option(unknown: &str, words: &[OsString]) -> Option<String> {
    let all = Arguments::definition();
    let command = words.iter().skip(1).find_map(|word| all.find_subcommand(word))?;
    let has = |name: &str| command.get_arguments().any(|argument| argument.get_long() == Some(name));
    let (former, present) =
        OPTIONS.into_iter().find(|(former, present)| unknown.strip_prefix("--") == Some(former) && has(present))?;
    Some(format!("--{former} of this command is called --{present} now"))
}

#[cfg(test)]
#[path = "../../tests/unit/commands_renamed.rs"]
mod tests;
