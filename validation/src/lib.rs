//! The judge of Makadam: the same scene in Makadam, YADE, LIGGGHTS and LAMMPS, one measurement code, a verdict, a report.
//!
//! ```text
//! reference codes (Makadam, YADE, LIGGGHTS) ─> Recording ─> observables ─> statistics ─> compare ─> report
//!
//! convergence, effects, laws, scaling, stability, tradeoff ─> study (tables, files, finished runs) ─> draw
//! ```
//!
//! Rooms import downwards alone: [`stepping`], [`statistics`], [`output`] and `draw` know no study, [`commands`] knows all.

pub mod codes;
pub mod commands;
pub mod compare;
pub mod convergence;
mod draw;
pub mod effects;
pub mod execution;
pub mod export;
mod forecast;
pub mod import;
pub mod interrupt;
mod laws;
pub mod observables;
pub mod output;
mod parameter_study;
pub mod pictures;
pub mod plan;
pub mod prepared;
pub mod problem;
pub mod provenance;
pub mod qualify;
pub mod recording;
pub mod report;
pub mod run_frames;
pub mod scaling;
pub mod scenes;
mod sketch;
pub mod stability;
pub mod statistics;
pub mod stepping;
pub mod study;
pub mod templates;
pub mod tradeoff;
pub mod viewer;
