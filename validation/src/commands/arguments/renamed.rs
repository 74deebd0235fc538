//! Former names of commands and options: the error states the present one.

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

/// Adds the present name to the error about a former one.
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
mod tests {
    use super::*;

    #[test]
    fn old_names_point_to_the_new_ones() {
        let message = |line: &str| {
            let words: Vec<OsString> = line.split_whitespace().map(OsString::from).collect();
            let error = Arguments::read(&words).unwrap_err();
            let error = with_new_name(error, &words);
            (error.exit_code(), error.to_string())
        };
        for (line, tip) in [
            ("makadam sweep drum --over a=1 --again", "--again of this command is called --restart now"),
            ("makadam qualify --threads 2", "--threads of this command is called --jobs now"),
            ("makadam compare drum --own-code c --against makadam", "--against of this command is called --codes now"),
            ("makadam compare drum --code c", "--code of this command is called --own-code now"),
            ("makadam judge drum --code c", "this command is now 'makadam compare SCENE --own-code FILE'"),
            ("makadam animate small", "this command is now 'makadam picture RUN --output FILE.gif'"),
        ] {
            let (code, message) = message(line);
            assert!(code == 2 && message.contains(tip), "{line}: {message}");
        }
        assert!(!message("makadam print scenes --again").1.contains("is called"));
    }
}
