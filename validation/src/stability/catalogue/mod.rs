//! The hard cases, group by group.
//!
//! Each case says what is right and why. Bounds come from closed forms, conservation laws or what the wall of a container is
//! for, never from what a code happened to give.

mod contacts;
mod drums;
mod impacts;
mod loads;
mod starts;

use super::Case;

/// All cases, in the order in which they are shown.
pub fn catalogue() -> Vec<Case> {
    [loads::cases(), starts::cases(), impacts::cases(), contacts::cases(), drums::cases()]
        .into_iter()
        .flatten()
        .collect()
}

#[cfg(test)]
mod tests {
    use makadam::scene::Severity;

    /// Frictions that no two solids have are deliberate in some cases.
    #[test]
    fn no_case_is_refused_and_few_are_told_to_go_wrong() {
        let cases = super::catalogue();
        let findings: Vec<(String, String)> = (cases.iter())
            .flat_map(|case| case.scene.findings(None).into_iter().map(|finding| (case.name.clone(), finding)))
            .inspect(|(name, finding)| assert_eq!(finding.severity, Severity::Warning, "{name}: {finding}"))
            .map(|(name, finding)| (name, finding.to_string()))
            .filter(|(_, finding)| !finding.contains("more than any two dry solids have"))
            .collect();
        assert!(findings.len() < 10, "{findings:#?}");
    }
}
