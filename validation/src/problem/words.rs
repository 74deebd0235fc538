//! Answers and checks for a terminal.

use super::{Answer, Check};

/// One answer in a line.
pub fn words(answer: &Answer) -> String {
    let ended = if answer.converged { "converged" } else { "not converged" };
    let iterations = answer.iterations.map_or_else(String::new, |count| format!(" after {count} iterations"));
    let seconds = answer.seconds.map_or_else(String::new, |seconds| format!(", {seconds:.3} s"));
    let residual =
        answer.residual.map_or_else(String::new, |residual| format!(", largest residual {residual:.2e} m/s"));
    format!("{}: {ended}{iterations}{residual}{seconds}", answer.method.name())
}

/// A check as lines of text.
pub fn table(check: &Check) -> String {
    let unique = if check.unique_impulses { "impulses are unique" } else { "impulses are not unique" };
    let mut lines = vec![format!("{}: {} contacts, {unique}", check.title, check.contacts)];
    for answer in &check.answers {
        let mut line = format!("  {}", words(answer));
        if let Some(difference) = answer.velocity_difference {
            line += &format!(", velocities {:.1e} of {:.1e} m/s from the first", difference / check.unit, check.unit);
        }
        if let Some(difference) = answer.impulse_difference {
            line += &format!(", impulses {difference:.1e} N s");
        }
        lines.push(line);
    }
    lines.extend(check.left_out.iter().map(|why| format!("  left out: {why}")));
    lines.join("\n")
}
