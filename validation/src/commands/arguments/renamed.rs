//! Options that had other names: the error names the new one.

use super::Arguments;
use clap::CommandFactory;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use std::ffi::OsString;

/// Old names with the new ones.
const RENAMED: [(&str, &str); 3] = [("again", "restart"), ("against", "codes"), ("threads", "jobs")];

/// Adds the new name of an option to the error about its old one, where the command has the new one.
pub fn with_new_name(mut error: clap::Error, words: impl IntoIterator<Item = OsString>) -> clap::Error {
    if let Some((old, new)) = renamed(&error, words) {
        error.remove(ContextKind::SuggestedArg);
        let tip = format!("--{old} of this command is called --{new} now");
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
    }
    error
}

/// Old and new name of the option that an error is about.
fn renamed(error: &clap::Error, words: impl IntoIterator<Item = OsString>) -> Option<(&'static str, &'static str)> {
    let (ErrorKind::UnknownArgument, Some(ContextValue::String(unknown))) =
        (error.kind(), error.get(ContextKind::InvalidArg))
    else {
        return None;
    };
    let all = Arguments::command();
    let command = words.into_iter().skip(1).find_map(|word| all.find_subcommand(word))?;
    let has = |name: &str| command.get_arguments().any(|argument| argument.get_long() == Some(name));
    RENAMED.into_iter().find(|(old, new)| unknown.strip_prefix("--") == Some(old) && has(new))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[test]
    fn old_names_point_to_the_new_ones() {
        let message = |line: &str| {
            let words: Vec<OsString> = line.split_whitespace().map(OsString::from).collect();
            let error = Arguments::try_parse_from(&words).unwrap_err();
            let error = with_new_name(error, words);
            (error.exit_code(), error.to_string())
        };
        for (line, tip) in [
            ("makadam sweep drum --over a=1 --again", "--again of this command is called --restart now"),
            ("makadam qualify --threads 2", "--threads of this command is called --jobs now"),
            ("makadam judge drum --code c --against makadam", "--against of this command is called --codes now"),
        ] {
            let (code, message) = message(line);
            assert!(code == 2 && message.contains(tip), "{line}: {message}");
        }
        assert!(!message("makadam scenes --again").1.contains("is called"));
    }
}
