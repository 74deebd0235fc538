//! Comparison of codes: one scene in Makadam, YADE, LIGGGHTS and LAMMPS, one measurement code, and a verdict; also published laws and stress
//! tests.

pub mod codes;
pub mod compare;
pub mod laws;
pub mod prepared;
pub mod scenes;
pub mod sketch;
pub mod stability;
pub mod study;

/// Key of the sources that measure and compare: builds with another key may measure differently.
pub const BUILD: &str = env!("MAKADAM_COMPARE_KEY");
