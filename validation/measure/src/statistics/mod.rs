//! Statistics of measurements: blocks, ensembles, equivalence, inequality of forces.
//!
//! The seed is the unit of replication. Frames of one run are first grouped into blocks ([`block_average`]); runs of one code
//! form an [`Ensemble`]; two ensembles are compared by [`equivalence`]; a live run is compared with recorded ones by a
//! [`prediction_interval`].
//!
//! ```
//! use makadam_measure::statistics::{Ensemble, Outcome, equivalence};
//!
//! let [makadam, yade] = [[0.596, 0.598, 0.595, 0.597], [0.597, 0.598, 0.596, 0.599]].map(|seeds| Ensemble::of(&seeds).unwrap());
//! let verdict = equivalence(&makadam, &yade, Some(0.006), 2);
//! assert_eq!(verdict.outcome, Some(Outcome::Agree));
//! ```

mod distributions;
mod ensemble;
mod equivalence;

pub use distributions::{gini, ranked, second_moment, share_below_mean, weak_load_share};
pub use ensemble::{
    Average, CONFIDENCE, Ensemble, block_average, block_count, confidence_of_each, mean, median, prediction_interval,
    standard_deviation, standard_error, student_quantile,
};
pub use equivalence::{Equivalence, Outcome, equivalence, seeds_needed};
