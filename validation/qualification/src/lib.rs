//! Qualification of a build: its tiers, its verdicts, and the report on them.

pub mod qualify;
pub mod report;
