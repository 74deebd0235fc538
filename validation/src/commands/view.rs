//! `makadam view`: a run as one HTML file.

use super::arguments::ViewArguments;
use super::{Console, Failure};
use crate::output::create_folder_of;
use crate::run_frames::RunFrames;
use crate::viewer::{ViewerError, Wishes, fields_of, write};
use std::os::unix::ffi::OsStrExt;
use std::path::Path;
use std::process::ExitCode;

/// Writes the page of a run and says how to open it.
pub(super) fn view(arguments: &ViewArguments, console: &Console) -> Result<ExitCode, Failure> {
    let run = RunFrames::open(&arguments.frames.run)?;
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
        // A browser shows the text of a page by another name.
        return Err(Failure::Usage(format!("{}: its name must end in .html or .htm", output.display())));
    }
    create_folder_of(&output)?;
    let bar = console.bar("gathering frames");
    let page = write(&output, &run, &wishes, &|share| bar.set(share))?;
    drop(bar);
    if !page.note.is_empty() {
        console.note(&page.note);
    }
    if page.bytes as f64 > 1e6 * arguments.megabytes {
        console.warn(&format!(
            "the page takes {:.2} MB, more than --megabytes {}: its program and the frames that are left take as much; give a larger --every \
             or fewer fields, if there are any to leave out",
            page.bytes as f64 / 1e6,
            arguments.megabytes
        ));
    }
    let path = std::path::absolute(&output).unwrap_or_else(|_| output.clone());
    console.result(&format!(
        "{}: {} frames, {:.1} MB\nopen it in a browser: {}",
        output.display(),
        page.frames,
        page.bytes as f64 / 1e6,
        address(&path)
    ))?;
    Ok(ExitCode::SUCCESS)
}

/// The address of a file, with what an address cannot hold as %XX (RFC 3986).
fn address(file: &Path) -> String {
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"/-._~".contains(&byte);
    let part = |byte: &u8| if plain(*byte) { char::from(*byte).to_string() } else { format!("%{byte:02X}") };
    format!("file://{}", file.as_os_str().as_bytes().iter().map(part).collect::<String>())
}

impl From<ViewerError> for Failure {
    fn from(error: ViewerError) -> Failure {
        match error {
            ViewerError::Frames(error) => error.into(),
            ViewerError::Write(error) => error.into(),
        }
    }
}

#[cfg(test)]
#[path = "../../tests/unit/commands_view.rs"]
mod tests;
