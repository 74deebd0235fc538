//! `makadam view`: a run as one HTML file.

use super::arguments::ViewArguments;
use super::{Console, Failure};
use crate::pictures::telling;
use crate::run_frames::RunFrames;
use crate::viewer::{ViewerError, Wishes, write};
use std::process::ExitCode;

/// Fields that can be chosen on the page beside the one that was asked for.
const BESIDE: [&str; 2] = ["speed", "pressure"];

/// Writes the page of a run and says how to open it.
pub(super) fn view(arguments: &ViewArguments, console: &Console) -> Result<ExitCode, Failure> {
    let run = RunFrames::open(&arguments.frames.run)?;
    let last = run.read(run.count() - 1)?;
    let mut fields = match &arguments.field {
        Some(names) => names.clone(),
        None => vec![telling(&last).to_string()],
    };
    if arguments.field.is_none() {
        let known = last.quantities();
        fields.extend(
            BESIDE.iter().filter(|name| known.iter().any(|known| known == *name)).map(|name| (*name).to_string()),
        );
    }
    let mut seen = std::collections::HashSet::new();
    fields.retain(|name| seen.insert(name.replace('-', "_")));
    let wishes = Wishes {
        fields,
        every: arguments.every.map(|every| every as usize),
        most_bytes: 1e6 * arguments.megabytes,
        contacts: !arguments.no_contacts,
    };
    let output = arguments.output.clone().unwrap_or_else(|| run.folder().join("view.html"));
    let bar = console.bar("gathering frames");
    let page = write(&output, &run, &wishes, &|share| bar.set(share))?;
    drop(bar);
    if !page.note.is_empty() {
        console.note(&page.note);
    }
    let path = std::path::absolute(&output).unwrap_or_else(|_| output.clone());
    console.result(&format!(
        "{}: {} frames, {:.1} MB\nopen it in a browser: file://{}",
        output.display(),
        page.frames,
        page.bytes as f64 / 1e6,
        path.display()
    ))?;
    Ok(ExitCode::SUCCESS)
}

impl From<ViewerError> for Failure {
    fn from(error: ViewerError) -> Failure {
        match error {
            ViewerError::Frames(error) => error.into(),
            ViewerError::Write(error) => error.into(),
        }
    }
}
