//! Unit tests of `src/commands/renamed.rs`.

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
