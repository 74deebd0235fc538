//! How many steps a time takes, and after which of them a frame is due.

/// Whole steps nearest to a duration.
pub fn steps_in(duration: f64, step: f64) -> u64 {
    (duration / step).round() as u64
}

/// Whether a frame is due after a step: the first one at or after each multiple of the interval.
pub fn frame_is_due(step: u64, step_seconds: f64, interval: f64) -> bool {
    // A thousandth of a step absorbs rounding where the interval is a whole number of steps.
    let intervals = |step: u64| ((step as f64 + 1e-3) * step_seconds / interval).floor();
    step > 0 && intervals(step) > intervals(step - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_fall_on_multiples_of_the_interval() {
        let due: Vec<u64> = (0..=300).filter(|&step| frame_is_due(step, 5e-4, 0.05)).collect();
        assert_eq!(due, [100, 200, 300]);
        let due: Vec<u64> = (0..=10).filter(|&step| frame_is_due(step, 1.0, 2.5)).collect();
        assert_eq!(due, [3, 5, 8, 10]);
    }
}
