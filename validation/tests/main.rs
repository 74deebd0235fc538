//! Tests of the judge as a library: one program, since each program is linked anew.

mod support;

mod baseline;
mod codes;
mod codes_live;
mod convergence;
mod drums_and_heaps;
mod export;
mod frames;
mod geometry;
mod import;
mod invariants;
mod kept_states;
mod lammps;
mod measured_bits;
mod measured_frames;
mod migflow;
mod observables;
mod pictures;
mod problem;
mod report;
mod report_files;
mod report_studies;
mod report_unsettled;
mod scaling;
mod scene_hashes;
mod slopes_and_flow;
mod sphere_volume;
mod statistics;
mod timed_inputs;
mod tradeoff;
mod tradeoff_recorded;
mod viewer;
