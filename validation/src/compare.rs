//! The same scene in several codes: runs, recorded references, rows with verdicts.
