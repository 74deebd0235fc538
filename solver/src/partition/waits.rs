//! Which groups of pairs have to wait for the group before them.

use super::TaskGroups;
use crate::lanes::{Kernel, Lanes};

/// Finds the groups of pairs of a task that share a body with the one before them, where sweeps have several groups on their way.
pub(crate) struct FindWaits<'a> {
    pub groups: &'a mut TaskGroups,
    /// Places from here on are those of dummies.
    pub grains: u32,
}

impl Kernel for FindWaits<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let TaskGroups { pairs, waits, .. } = self.groups;
        if L::OVERLAPPED && !pairs.is_empty() {
            // As much room as the groups have, so that it grows no oftener.
            waits.reserve_exact(pairs.capacity());
            waits.push(false);
            for both in pairs.windows(2) {
                // Padding lanes do not count: no impulse moves their bodies.
                let [one, other] = [&both[0], &both[1]].map(|group| [&group.first, &group.second]);
                waits.push(L::meet(one, other, self.grains));
            }
        }
    }
}
