//! The commands of `makadam`.
