//! Arguments of the commands that take frames of any code.

use super::shared::{CodeRunArguments, SourceArguments};
use super::values::positive;
use crate::peers::CodeName;
use crate::scenes::Change;
use clap::Args;
use std::path::PathBuf;

/// Arguments of `makadam measure`.
#[derive(Debug, Args)]
pub struct MeasureArguments {
    /// Files of grains: dumps of LIGGGHTS or LAMMPS, VTK or text of YADE, CSV, VTKHDF; or the folder of a run of Makadam.
    #[arg(required = true, value_name = "FILES")]
    pub grains: Vec<PathBuf>,
    /// Scene that was simulated: a file, a name (see `makadam scenes`), or - for standard input.
    #[arg(long)]
    pub scene: String,
    /// Replace a value of the scene, such as measure.from=0.5; can be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub changes: Vec<Change>,
    /// Files of contacts, of grains and of walls.
    #[arg(long, num_args = 1.., value_name = "FILES")]
    pub contacts: Vec<PathBuf>,
    /// Names of the columns of grains in place of those in the files, such as id,_,x,y,z,radius; _ for what is not wanted.
    #[arg(long, value_delimiter = ',', value_name = "NAMES")]
    pub columns: Vec<String>,
    /// Names of the columns of contacts, such as first,second,_,fx,fy,fz,px,py,pz.
    #[arg(long, value_delimiter = ',', value_name = "NAMES")]
    pub contact_columns: Vec<String>,
    /// Time step (s) of frames or files that are numbered by steps.
    #[arg(long, value_parser = positive)]
    pub time_step: Option<f64>,
    /// Time (s) between frames that tell neither time nor step; the first is at 0, and files follow the numbers in their names.
    #[arg(long, value_parser = positive, conflicts_with = "time_step")]
    pub interval: Option<f64>,
    /// Seed of the initial positions: of the grains whose radii are taken where files have none; if absent, the scene's.
    #[arg(long)]
    pub seed: Option<u64>,
    /// Name of the code that left the frames.
    #[arg(long, default_value = "frames")]
    pub name: String,
    /// Print the measurements as JSON.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `makadam judge`.
#[derive(Debug, Args)]
pub struct JudgeArguments {
    /// The scene; what it names under [[compare]] is judged.
    #[command(flatten)]
    pub source: SourceArguments,
    /// TOML file that describes the code: name, version, command, and where it leaves its frames (docs/own-code.md lists the keys).
    #[arg(long, value_name = "FILE", required_unless_present = "frames")]
    pub code: Option<PathBuf>,
    /// Folders of frames that exist, one for each seed, whose number ends the folder's name: 'seed*/'. Nothing is run of the code;
    /// without --code a folder is that of a run of Makadam, or all its files hold grains.
    #[arg(long, num_args = 1.., value_name = "FOLDERS", conflicts_with = "seeds")]
    pub frames: Vec<String>,
    /// Codes that it is compared with, separated by commas; if absent, makadam and those that are recorded on the scene, or with
    /// --live makadam,yade,liggghts.
    #[arg(long, value_enum, value_delimiter = ',')]
    pub against: Option<Vec<CodeName>>,
    /// How the codes are run, and what is told.
    #[command(flatten)]
    pub runs: CodeRunArguments,
}
