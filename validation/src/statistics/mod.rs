//! From measurements to verdicts: blocks, ensembles, equivalence.
