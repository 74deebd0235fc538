//! From measurements to verdicts: blocks, ensembles, equivalence, distances between distributions.
//!
//! The seed is the unit of replication. Frames of one run are put into blocks first ([`blocks`]); runs of one code
//! form an [`Ensemble`]; two ensembles are judged by [`equivalence`](equivalence()); a live run is held against recorded ones by a
//! [`prediction`].
//!
//! ```
//! use makadam_validation::statistics::{Ensemble, Outcome, equivalence};
//!
//! let [makadam, yade] = [[0.596, 0.598, 0.595, 0.597], [0.597, 0.598, 0.596, 0.599]].map(|seeds| Ensemble::of(&seeds).unwrap());
//! let verdict = equivalence(&makadam, &yade, Some(0.006), 2);
//! assert_eq!(verdict.outcome, Some(Outcome::Agree));
//! ```

pub mod blocks;
pub mod distances;
pub mod ensemble;
pub mod equivalence;
pub mod inequality;
pub mod prediction;
pub mod rank;

pub use blocks::{Average, block_average, block_count};
pub use distances::{kolmogorov_smirnov, wasserstein};
pub use ensemble::{Ensemble, mean, median, standard_deviation, standard_error, student_quantile};
pub use equivalence::{Equivalence, Outcome, equivalence, seeds_needed};
pub use inequality::{gini, second_moment, share_below_mean, weak_load_share};
pub use prediction::{CONFIDENCE, Spread, confidence_of_each, inside_recorded_spread, prediction_interval};
pub use rank::ranked;
