//! Same bits, checkpoints, ledger, driven and turning meshes, effects.
