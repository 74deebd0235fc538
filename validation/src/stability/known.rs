//! Cases that are known not to end as stated in Makadam.

/// Each with the reason; `validation/docs/stability.md` tells more. One that does end as stated is to be taken off.
pub const KNOWN_EXCEPTIONS: [(&str, &str); 1] = [(
    "impossible-gap-rigid",
    "two rigid contacts that contradict each other have no solution: impulses grow with sweeps",
)];

/// The reason why a case is known not to end as stated; absent where it must.
pub fn known_exception(case: &str) -> Option<&'static str> {
    KNOWN_EXCEPTIONS.iter().find(|(name, _)| *name == case).map(|(_, reason)| *reason)
}
