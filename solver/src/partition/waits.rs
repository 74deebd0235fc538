//! Which groups of pairs have to wait for the group before them.

use super::TaskGroups;
use crate::effects::EffectSet;
use crate::groups::with_pairs;
use crate::lanes::{Kernel, Lanes};

/// Whether sweeps have several lane groups on their way at a time. Contacts that bear torques need the bodies themselves for that, and
/// without friction a group's chain of operations is too short to gain.
pub(crate) const fn overlapped<L: Lanes>(friction: bool, torques: bool) -> bool {
    L::OVERLAPPED && friction && !torques
}

/// Finds the groups of pairs of a task that share a body with the one before them, where sweeps have to know.
pub(crate) struct FindWaits<'a> {
    pub groups: &'a mut TaskGroups,
    pub effects: EffectSet,
    /// Places from here on are those of dummies.
    pub grains: u32,
}

impl Kernel for FindWaits<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let TaskGroups { pairs, pair_waits, .. } = self.groups;
        // What was packed for an earlier step waits as it did then.
        if pair_waits.len() == pairs.len() || !overlapped::<L>(self.effects.tangential(), self.effects.torques()) {
            return;
        }
        // As much room as the groups have, so that it grows no oftener.
        pair_waits.reserve_exact(pairs.capacity());
        pair_waits.push(false);
        with_pairs!(pairs, pairs => for both in pairs.windows(2) {
            // Padding lanes do not count: no impulse moves their bodies.
            let [one, other] = [&both[0], &both[1]].map(|group| [&group.first, &group.second]);
            pair_waits.push(L::share_places(one, other, self.grains));
        });
    }
}
