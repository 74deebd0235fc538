//! `makadam view`: a run as one HTML file.

use super::arguments::positive;
use super::{Console, Failure};
use clap::Args;
use makadam_frames::output::create_folder_of;
use makadam_frames::run_frames::RunFrames;
use makadam_view::viewer::{Wishes, fields_of, write};
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(Debug, Args)]
pub(super) struct ViewArguments {
    /// Folder of a run, or the name of a folder below results; the run may be in progress.
    pub run: PathBuf,
    /// Fields of the frames that can colour the grains, with commas; each takes two bytes per grain and frame. If absent, speed and
    /// pressure.
    #[arg(long, value_delimiter = ',')]
    pub field: Option<Vec<String>>,
    /// Show every n-th frame only; if absent, as many frames as fit into --megabytes.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    pub every: Option<u32>,
    /// Largest size of the file, MB: contacts are omitted first, then frames.
    #[arg(long, default_value_t = 200.0, value_parser = positive)]
    pub megabytes: f64,
    /// Leave out contacts, and with them force chains.
    #[arg(long)]
    pub no_contacts: bool,
    /// Begin with a view of all grains, also those far from the walls.
    #[arg(long)]
    pub all_grains: bool,
    /// HTML file to write; view.html in the folder of the run, if absent.
    #[arg(short, long)]
    pub output: Option<PathBuf>,
}

pub(super) fn view(arguments: &ViewArguments, console: &Console) -> Result<ExitCode, Failure> {
    let run = RunFrames::open(&arguments.run)?;
    let last = run.read(run.count() - 1)?;
    let wishes = Wishes {
        fields: fields_of(&last, arguments.field.as_deref()),
        every: arguments.every.map(|every| every as usize),
        most_bytes: 1e6 * arguments.megabytes,
        contacts: !arguments.no_contacts,
        all_grains: arguments.all_grains,
    };
    let output = arguments.output.clone().unwrap_or_else(|| run.folder().join("view.html"));
    let ending = output.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
    if !matches!(ending.as_deref(), Some("html" | "htm")) {
        // A browser would show a page of another extension as text.
        return Err(Failure::Usage(format!("{}: its name must end in .html or .htm", output.display())));
    }
    create_folder_of(&output)?;
    let bar = console.bar("gathering frames");
    let page = write(&output, &run, &wishes, &|fraction| bar.set(fraction))?;
    drop(bar);
    if !page.note.is_empty() {
        console.note(&page.note);
    }
    let megabytes = page.bytes as f64 / 1e6;
    if megabytes > arguments.megabytes {
        console.warn(&format!(
            "the page takes {megabytes:.2} MB, more than --megabytes {}: its program and the frames that are left take as much; give a \
             larger --every or fewer fields, if there are any to leave out",
            arguments.megabytes
        ));
    }
    let path = std::path::absolute(&output).unwrap_or_else(|_| output.clone());
    console.result(&format!(
        "{}: {} frames, {megabytes:.1} MB\nopen it in a browser: {}",
        output.display(),
        page.frames,
        address(&path)
    ))?;
    Ok(ExitCode::SUCCESS)
}

/// Returns the address of a file, with reserved bytes as %XX (RFC 3986).
fn address(file: &Path) -> String {
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"/-._~".contains(&byte);
    let part = |byte: &u8| if plain(*byte) { char::from(*byte).to_string() } else { format!("%{byte:02X}") };
    format!("file://{}", file.as_os_str().as_bytes().iter().map(part).collect::<String>())
}

#[cfg(test)]
#[path = "../../tests/unit/commands_view.rs"]
mod tests;
