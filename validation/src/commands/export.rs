//! `makadam export`: the frames of a run for other programs, and scenes for other codes.

use super::arguments::{load, one_of, rayleigh_fraction};
use super::{Console, Failure};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use makadam_compare::codes::{CodeName, Job, Purpose};
use makadam_compare::scenes::Change;
use makadam_frames::export::csv::{COLUMNS, line};
use makadam_frames::export::{Written, write};
use makadam_frames::import::{Column, FrameTable, ImportError, StatedColumns, parse};
use makadam_frames::output::{create_folder, file_stem, write_whole};
use makadam_frames::plan::FrameFormat;
use makadam_frames::run_frames::RunFrames;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

#[derive(Debug, Args)]
pub(super) struct ExportArguments {
    /// Folder of a run, or the name of a folder below results; with --format csv, also a file of frames of any code; with --for, a scene.
    #[arg(value_name = "RUN or SCENE")]
    pub what: String,
    /// Format of the frames of a run, as `[output] formats` of a scene.
    #[arg(long, value_parser = one_of(FrameFormat::ALL, FrameFormat::name))]
    pub format: Option<FrameFormat>,
    /// Code for which the scene is written: deck or driver, grains, meshes of walls.
    #[arg(long = "for", id = "code", value_parser = another_code(), value_name = "CODE", conflicts_with = "format")]
    pub code: Option<CodeName>,
    /// With --for, replace a value of the scene; can be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE", requires = "code")]
    pub changes: Vec<Change>,
    /// With --for, seed of the initial positions; if absent, the scene's.
    #[arg(long, requires = "code", conflicts_with = "format")]
    pub seed: Option<u64>,
    /// With --for, time step of the code, as a fraction of the Rayleigh step.
    #[arg(long, default_value_t = 0.1, value_parser = rayleigh_fraction, requires = "code")]
    pub rayleigh_fraction: f64,
    /// Folder to write into; if absent, the run's folder, or one named after scene and code.
    #[arg(short, long)]
    pub output: Option<PathBuf>,
}

/// Parses the name of a code with an input other than a scene.
fn another_code() -> impl TypedValueParser<Value = CodeName> {
    let others = CodeName::value_variants().iter().filter(|name| **name != CodeName::Makadam);
    PossibleValuesParser::new(others.filter_map(ValueEnum::to_possible_value)).try_map(|name| CodeName::of(&name))
}

pub(super) fn export(arguments: &ExportArguments, console: &Console) -> Result<ExitCode, Failure> {
    match (arguments.code, arguments.format) {
        (Some(code), _) => export_scene(arguments, code, console),
        (None, Some(format)) => export_run(arguments, format, console),
        (None, None) => {
            Err(Failure::Usage("give --format for the frames of a run, or --for and a code for a scene".into()))
        }
    }
}

/// Writes the input of a code for a scene.
fn export_scene(arguments: &ExportArguments, code: CodeName, console: &Console) -> Result<ExitCode, Failure> {
    let (file, scene) = load(&arguments.what, &arguments.changes)?;
    let scene = if scene.stage.is_empty() { scene } else { scene.without_stages().map_err(Failure::Usage)? };
    let code = code.code();
    let name = format!("{}-{}", file_stem(&scene.name), code.name().to_lowercase());
    let folder = arguments.output.clone().unwrap_or_else(|| PathBuf::from(name));
    if std::fs::read_dir(&folder).is_ok_and(|mut entries| entries.next().is_some()) {
        let problem = format!("{} is not empty; give another folder with --output, or empty it", folder.display());
        return Err(Failure::Usage(problem));
    }
    let job = Job {
        scene: &scene,
        scene_file: &file,
        purpose: Purpose::Measuring,
        seed: arguments.seed.unwrap_or(scene.seed),
        stiffness_factor: 1.0,
        rayleigh_fraction: arguments.rayleigh_fraction,
        work_folder: &folder,
        time_limit: Duration::ZERO,
        progress: &|_| {},
    };
    let command = code.write_input(&job)?;
    let manifest = folder.join("frames.toml");
    let after = match manifest.is_file() {
        true => format!("\nmeasure its frames with: makadam measure {} --scene {}", manifest.display(), arguments.what),
        false => String::new(),
    };
    console.result(&format!("{}; run it there with: {command}{after}", folder.display()))?;
    Ok(ExitCode::SUCCESS)
}

fn export_run(arguments: &ExportArguments, format: FrameFormat, console: &Console) -> Result<ExitCode, Failure> {
    let file = Path::new(&arguments.what);
    if file.is_file() && format == FrameFormat::Csv {
        return convert(arguments, file, console);
    }
    let run = RunFrames::open(Path::new(&arguments.what))?;
    let folder = arguments.output.clone().unwrap_or_else(|| run.folder().to_path_buf());
    console.result(&export_frames(&run, format, &folder, console)?)?;
    Ok(ExitCode::SUCCESS)
}

/// Writes the frames of a file of any code as tables of grains.
fn convert(arguments: &ExportArguments, file: &Path, console: &Console) -> Result<ExitCode, Failure> {
    let bytes = std::fs::read(file).map_err(|error| Failure::Input(format!("{}: {error}", file.display())))?;
    let frames = parse(file, bytes, &StatedColumns::default())?;
    let folder = arguments.output.clone().unwrap_or_else(|| PathBuf::from("."));
    create_folder(&folder)?;
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    for (number, frame) in frames.iter().enumerate() {
        let name = if frames.len() == 1 { format!("{stem}-start.csv") } else { format!("{stem}-{number:05}.csv") };
        write_whole(&folder.join(&name), of_table(frame)?.as_bytes())?;
        let grains = frame.rows().len();
        console.result(&format!("{}: {grains} grains; give start.material for them", folder.join(name).display()))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Meanings of the columns of tables of grains.
const MEANINGS: [Column; 10] = [
    Column::Position(0),
    Column::Position(1),
    Column::Position(2),
    Column::Radius,
    Column::Velocity(0),
    Column::Velocity(1),
    Column::Velocity(2),
    Column::Spin(0),
    Column::Spin(1),
    Column::Spin(2),
];

/// Returns the text for a frame of another code, in the order of its numbers: the columns that it has, without materials.
///
/// # Errors
/// [`ImportError`] for a frame without coordinates or sizes.
fn of_table(table: &FrameTable) -> Result<String, ImportError> {
    let find = |column: Column| match (table.find(column), column) {
        (None, Column::Radius) => table.find(Column::Diameter).map(|place| (place, 0.5)),
        (place, _) => place.map(|place| (place, 1.0)),
    };
    let all = || COLUMNS.into_iter().zip(MEANINGS);
    let columns: Vec<_> = all().filter_map(|(name, column)| Some((name, find(column)?))).collect();
    if let Some((name, _)) = all().take(4).find(|(_, column)| find(*column).is_none()) {
        let problem = format!("there is no column {name}; write it, or name the columns of the file in its first line");
        return Err(ImportError { file: table.file.clone(), line: table.line, problem });
    }
    let mut rows: Vec<&[f64]> = table.rows().collect();
    if let Some(id) = table.find(Column::Id) {
        rows.sort_by(|one, other| one[id].total_cmp(&other[id]));
    }
    let mut text = line(columns.iter().map(|(name, _)| name.to_string()));
    for row in rows {
        text += &line(columns.iter().map(|(_, (place, factor))| (factor * row[*place]).to_string()));
    }
    Ok(text)
}

/// Writes the frames of a run into a folder in a format; returns one line per file.
pub(super) fn export_frames(
    run: &RunFrames,
    format: FrameFormat,
    folder: &Path,
    console: &Console,
) -> Result<String, Failure> {
    let bar = console.bar("exporting");
    let written = write(format, run, folder, &|share| bar.set(share))?;
    let lines = written.iter().map(|Written { path, frames }| format!("{}: {frames} frames", path.display()));
    Ok(lines.collect::<Vec<_>>().join("\n"))
}
