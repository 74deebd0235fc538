//! What is measured from frames, whichever code they came from.
