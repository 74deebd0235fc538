//! The report: one self-contained HTML file, and JSON and CSV beside it.
