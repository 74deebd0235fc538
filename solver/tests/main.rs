//! Tests of the solver by what users see of it: one program, since each program is linked anew.

mod common;

mod build_key;
mod checkpoint;
mod cohesion;
mod containment;
mod corpus;
mod discs;
mod driven_walls;
mod effect_combinations;
mod effects_catalogue;
mod empty_domain;
mod front_door;
mod golden;
mod gravity;
mod impact;
mod interventions;
mod invariants;
mod kinetic_friction;
mod ledger;
mod ledger_closure;
mod methods;
mod periodic;
mod problem;
mod random_scenes;
mod resistance;
mod rest;
mod restitution_speed;
mod ring;
mod same_bits;
mod scene;
mod scene_checks;
mod settings;
mod unsafe_code;
mod vibration;
mod watch;
