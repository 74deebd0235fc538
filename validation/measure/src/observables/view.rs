//! One frame, with what several measures need of it worked out once.

use super::bulk::Bulk;
use super::setting::Setting;
use super::walls::PlacedWalls;
use makadam::snapshot::{Contact, Particle, Partner, Snapshot};
use makadam_frames::neighbours::{Pair, close_pairs_in};
use nalgebra::Vector3;
use std::cell::OnceCell;

/// Grains count as touching if their gap is below this part of the mean diameter.
pub const TOUCHING: f64 = 0.01;

/// A frame in its setting. Each quantity of a frame follows from it alone, so that no quantity depends on which others are measured.
pub struct View<'a> {
    /// The scene at the frame's time.
    pub setting: &'a Setting<'a>,
    /// The frame.
    pub frame: &'a Snapshot,
    /// The walls, where they are at the frame's time.
    pub walls: PlacedWalls,
    bulk: OnceCell<Result<Bulk, String>>,
    pairs: OnceCell<Vec<Pair>>,
    in_bulk: OnceCell<Vec<bool>>,
}

impl<'a> View<'a> {
    /// A view of a frame.
    pub fn new(setting: &'a Setting<'a>, frame: &'a Snapshot) -> Self {
        let walls = PlacedWalls::at(setting.scene(), frame);
        let (bulk, pairs, in_bulk) = (OnceCell::new(), OnceCell::new(), OnceCell::new());
        Self { setting, frame, walls, bulk, pairs, in_bulk }
    }

    /// The bulk of the frame's bed.
    pub fn bulk(&self) -> Result<&Bulk, &str> {
        self.bulk.get_or_init(|| Bulk::of(self.setting, self.frame, &self.walls)).as_ref().map_err(String::as_str)
    }

    /// Pairs of grains whose gap is below 1% of the mean diameter, across periodic ends too.
    pub fn pairs(&self) -> &[Pair] {
        let domain = &self.setting.scene().domain;
        let reach = TOUCHING * self.setting.diameter;
        self.pairs.get_or_init(|| close_pairs_in(domain, &self.frame.particles, reach))
    }

    /// Which grains lie in the bulk, in the order of the frame's table; none where there is no bulk.
    pub fn in_bulk(&self) -> &[bool] {
        self.in_bulk.get_or_init(|| {
            let inside =
                |grain: &Particle| self.bulk().is_ok_and(|bulk| bulk.contains(&self.walls, &grain.position.into()));
            self.frame.particles.iter().map(inside).collect()
        })
    }

    /// Contacts between grains that push (a soft code may also pull) and whose point lies in the bulk.
    pub fn bulk_contacts(&self) -> Vec<&'a Contact> {
        let Ok(bulk) = self.bulk() else { return Vec::new() };
        let inside = |contact: &&Contact| match contact.second {
            Partner::Wall(_) => false,
            Partner::Grain(second) => contact.normal_force > 0.0 && self.point_in_bulk(bulk, contact.first, second),
        };
        self.frame.contacts.iter().filter(inside).collect()
    }

    /// Place of a grain in the frame's table, by its id.
    pub fn place(&self, id: u32) -> Option<usize> {
        let grains = &self.frame.particles;
        // Ids have no holes unless a code lost a grain.
        match grains.get(id as usize) {
            Some(grain) if grain.id == id => Some(id as usize),
            _ => grains.binary_search_by_key(&id, |grain| grain.id).ok(),
        }
    }

    /// The contact point follows from the grains rather than from the code's own table, whose meaning may vary. Across the end of a
    /// periodic axis it lies between a grain and the nearest image of the other one.
    fn point_in_bulk(&self, bulk: &Bulk, first: u32, second: u32) -> bool {
        let (Some(first), Some(second)) = (self.place(first), self.place(second)) else {
            return false;
        };
        let (a, b) = (&self.frame.particles[first], &self.frame.particles[second]);
        let (share, domain) = (a.radius / (a.radius + b.radius), &self.setting.scene().domain);
        let (from, to, period) = (Vector3::from(a.position), Vector3::from(b.position), domain.period());
        let arm = period.arm(&from, &to);
        if arm != to - from {
            let point = period.wrapped(&(from + arm * share), &domain.min.into());
            return bulk.contains(&self.walls, &point);
        }
        self.in_bulk()[first] && self.in_bulk()[second] || bulk.contains(&self.walls, &from.lerp(&to, share))
    }
}
