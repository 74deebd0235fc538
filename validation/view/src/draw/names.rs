//! Names and markers of observables, units and codes in tables and figures.

use super::numbers::Rounding;

/// Returns the display name of an observable.
pub fn observable(name: &str) -> String {
    match name {
        "gini" => "Gini coefficient of normal forces".into(),
        "share_below_mean" => "share of forces below the mean".into(),
        "weak_load_share" | "weak_share_of_load" => "share of load on weak contacts".into(),
        "lacey_index" | "mixing_index" => "mixing index (Lacey)".into(),
        "size_mixing_index" => "mixing index of sizes (Lacey)".into(),
        "wall_force_over_weight" => "wall force over weight".into(),
        "largest_overlap_over_radius" => "largest overlap over radius".into(),
        _ => name.replace('_', " "),
    }
}

/// Returns a unit for display next to a number.
pub fn unit(unit: &str) -> &str {
    match unit {
        "degree" | "degrees" | "deg" => "°",
        "m2" => "m²",
        "m3" => "m³",
        "m/s2" => "m/s²",
        "kg/m3" => "kg/m³",
        "-" | "1" | "(no unit)" => "",
        other => other,
    }
}

/// Returns an observable with its unit in brackets, and the common power of ten of its values.
pub fn with_unit(name: &str, of: &str, rounding: Rounding) -> String {
    let symbol = if unit(of) == "°" { "degrees" } else { unit(of) };
    match [rounding.factor().as_str(), symbol].join(" ").trim() {
        "" => observable(name),
        words => format!("{} ({words})", observable(name)),
    }
}

/// Shape of a code's marker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marker {
    /// Disc.
    Circle,
    /// Square.
    Square,
    /// Triangle.
    Triangle,
    /// Square on its corner.
    Diamond,
    /// Triangle on its tip.
    Wedge,
    /// Two crossed lines.
    Cross,
}

/// Style of a code: colour, marker and kind of line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CodeStyle {
    /// Style class with colour and dashes.
    pub class: &'static str,
    /// Marker of the points.
    pub marker: Marker,
}

/// Returns the style of a code by its name; published numbers of a code have its style.
pub fn code_style(code: &str) -> CodeStyle {
    let name = code.strip_suffix(" (published)").unwrap_or(code).to_ascii_lowercase();
    let (class, marker) = match name.as_str() {
        "makadam" => ("code-makadam", Marker::Circle),
        "liggghts" => ("code-liggghts", Marker::Square),
        "yade" => ("code-yade", Marker::Triangle),
        "lammps" => ("code-lammps", Marker::Diamond),
        "siconos" => ("code-siconos", Marker::Wedge),
        "migflow" => ("code-migflow", Marker::Cross),
        _ => ("code-other", Marker::Diamond),
    };
    CodeStyle { class, marker }
}
