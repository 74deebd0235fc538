//! End-to-end tests of the command: one program, since each program is linked anew.

mod support;

mod architecture;
mod bad_input;
mod book;
mod compare_command;
mod convergence_command;
mod defect_scenes;
mod effects_command;
mod fault_tables;
mod faults;
mod flow_command;
mod foreign_commands;
mod judged_frames;
mod language;
mod laws_command;
mod learn_commands;
mod measured_runs;
mod mesh_walls;
mod output_folder;
mod problem_command;
mod qualify_command;
mod reference_scenes;
mod resume_command;
mod run_command;
mod scaling_command;
mod see_commands;
mod stability;
mod stages_command;
mod tradeoff_command;
mod wall_loads_command;
mod watch_command;
