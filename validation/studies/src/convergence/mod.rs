//! Convergence of each method on the problem of one step: the thesis's figure 6.1, for every method and against wall time.
//!
//! ```text
//! flowing state ─> the problem of its next step ─> method by method ─> residual after each iteration ─> study
//!                                                                                                        │
//!                                    terminal, page, figures, CSV <── tolerances reached <───────────────┘
//! ```
//!
//! Every method starts from the same state of the same problem, with one measure for all of them: the natural map of
//! [`makadam::methods`].

mod figures;
mod report;
mod study;

pub use study::{Curve, Effort, LeftOut, Problem, Reached, Study, TOLERANCES, measure, methods};
