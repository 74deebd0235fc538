//! Arguments of `makadam measure`.

use super::values::{kind, positive};
use crate::import::{FilePattern, StatedColumns};
use crate::scenes::Change;
use clap::Args;

/// Arguments of `makadam measure`.
#[derive(Debug, Args)]
pub struct MeasureArguments {
    /// Files of grains: dumps of LIGGGHTS or LAMMPS, VTK or text of YADE, CSV, VTKHDF, plain or packed by gzip, where {step} or {time} in a
    /// name stands for a number; or the folder of a run of Makadam; or a manifest (.toml) that names the files of a run and states what
    /// they do not.
    #[arg(required = true, value_name = "FILES")]
    pub grains: Vec<FilePattern>,
    /// Scene that was simulated: a file, a name (see `makadam print scenes`), or - for standard input.
    #[arg(long)]
    pub scene: String,
    /// Replace a value of the scene, such as measure.from=0.5; can be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub changes: Vec<Change>,
    /// Files of contacts, of grains and of walls.
    #[arg(long, num_args = 1.., value_name = "FILES")]
    pub contacts: Vec<FilePattern>,
    /// Names of the columns of grains in place of those in the files, such as id,_,x,y,z,radius; _ for what is not wanted.
    #[arg(long, value_name = "NAMES")]
    pub columns: Vec<StatedColumns>,
    /// Names of the columns of contacts, such as first,second,_,fx,fy,fz,px,py,pz; with a name and a colon before them those of the columns
    /// that files number under it: c_pairs:first,second,_,fx,fy,fz for c_pairs[1] to c_pairs[6]. Can be given several times.
    #[arg(long, value_name = "NAMES")]
    pub contact_columns: Vec<StatedColumns>,
    /// The files of contacts list all contacts of their frames.
    #[arg(long)]
    pub contacts_complete: bool,
    /// Time (s) between frames whose numbers differ by one: the time step, where frames are numbered by steps.
    #[arg(long, value_parser = positive)]
    pub time_step: Option<f64>,
    /// Time (s) of the only frame.
    #[arg(long)]
    pub time: Option<f64>,
    /// Number in the files of the scene's first grain, where they number grains as the scene does: listed ones first, then each
    /// population.
    #[arg(long, value_name = "NUMBER", allow_negative_numbers = true)]
    pub first_id: Option<i64>,
    /// Seed by which the grains were placed as the scene places them; with --first-id it states radii that the files lack.
    #[arg(long)]
    pub seed: Option<u64>,
    /// Material of the scene, or population (population.0), that each value of a column type or material stands for, such as
    /// 1=glass,2=steel.
    #[arg(long, value_delimiter = ',', value_name = "VALUE=NAME", value_parser = kind)]
    pub kinds: Vec<(String, String)>,
    /// Name of the code that left the frames; "frames" if absent.
    #[arg(long)]
    pub name: Option<String>,
    /// Print the measurements as JSON.
    #[arg(long)]
    pub json: bool,
}
