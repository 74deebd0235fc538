//! One frame, with intermediate results that several measures need, computed once.

use super::bed_surface::{MeanField, NO_MEAN_FIELD, outline};
use super::bulk::Bulk;
use super::contour::Loop;
use super::drum::Drum;
use super::setting::Setting;
use super::static_angle::HeapFields;
use super::walls::PlacedWalls;
use makadam::snapshot::{Contact, Particle, Partner, Snapshot};
use makadam_frames::neighbours::{Pair, close_pairs_in};
use nalgebra::Vector3;
use std::cell::OnceCell;

/// Largest gap of grains in contact, over the mean diameter.
pub const TOUCHING: f64 = 0.01;

/// Frame in its setting. Each quantity follows from the frame alone, independent of the other measured quantities.
pub struct View<'a> {
    /// Scene at the frame's time.
    pub setting: &'a Setting<'a>,
    /// Frame.
    pub frame: &'a Snapshot,
    /// Walls at their pose at the frame's time.
    pub walls: PlacedWalls,
    outline: OnceCell<Result<Option<Loop>, &'static str>>,
    heap: OnceCell<Result<HeapFields, String>>,
    bulk: OnceCell<Result<Bulk, String>>,
    pairs: OnceCell<Vec<Pair>>,
    wall_distances: OnceCell<Vec<f64>>,
}

impl<'a> View<'a> {
    /// Makes a view of a frame.
    pub fn new(setting: &'a Setting<'a>, frame: &'a Snapshot) -> Self {
        Self {
            setting,
            frame,
            walls: PlacedWalls::at(setting.scene(), frame),
            outline: OnceCell::new(),
            heap: OnceCell::new(),
            bulk: OnceCell::new(),
            pairs: OnceCell::new(),
            wall_distances: OnceCell::new(),
        }
    }

    /// Returns the distances of the grains' centres from the nearest wall or periodic end, m, in the order of the frame's table.
    pub fn wall_distances(&self) -> &[f64] {
        let distance = |grain: &Particle| self.walls.distance(&grain.position.into());
        self.wall_distances.get_or_init(|| self.frame.particles.iter().map(distance).collect())
    }

    /// Returns the outline of the bed in the cross-section of the drum; `None` without a bed. The error is the reason for an unknown outline.
    pub fn outline(&self, drum: &Drum) -> Result<Option<&Loop>, &'static str> {
        let found = self.outline.get_or_init(|| {
            let mut mean = MeanField::new(self.setting, drum, self.frame.particles.len());
            mean.add(self.frame);
            mean.finish().map(|field| outline(&field)).ok_or(NO_MEAN_FIELD)
        });
        found.as_ref().map(Option::as_ref).map_err(|why| *why)
    }

    /// Returns the fields of the heap.
    pub fn heap(&self) -> Result<&HeapFields, &str> {
        let fields = || {
            let Ok(fields) = HeapFields::new(self.setting, &[self.frame][..]);
            fields
        };
        self.heap.get_or_init(fields).as_ref().map_err(String::as_str)
    }

    /// Returns the bulk of the frame's bed.
    pub fn bulk(&self) -> Result<&Bulk, &str> {
        self.bulk.get_or_init(|| Bulk::of(self)).as_ref().map_err(String::as_str)
    }

    /// Returns the pairs of grains with a gap below 1% of the mean diameter, across periodic ends too.
    pub fn pairs(&self) -> &[Pair] {
        let domain = &self.setting.scene().domain;
        let reach = TOUCHING * self.setting.diameter;
        self.pairs.get_or_init(|| close_pairs_in(domain, &self.frame.particles, reach))
    }

    /// Returns flags of the grains in the bulk, in the order of the frame's table; empty without a bulk.
    pub fn in_bulk(&self) -> &[bool] {
        self.bulk().map_or(&[], |bulk| &bulk.inside)
    }

    /// Returns the repulsive contacts between grains (a soft code may also have cohesive ones) with their point in the bulk.
    pub fn bulk_contacts(&self) -> Vec<&'a Contact> {
        let Ok(bulk) = self.bulk() else { return Vec::new() };
        let inside = |contact: &&Contact| match contact.second {
            Partner::Wall(_) => false,
            Partner::Grain(second) => contact.normal_force > 0.0 && self.point_in_bulk(bulk, contact.first, second),
        };
        self.frame.contacts.iter().filter(inside).collect()
    }

    /// Returns the index of a grain in the frame's table, by its id.
    pub fn place(&self, id: u32) -> Option<usize> {
        let grains = &self.frame.particles;
        // Ids are contiguous unless a code lost a grain.
        match grains.get(id as usize) {
            Some(grain) if grain.id == id => Some(id as usize),
            _ => grains.binary_search_by_key(&id, |grain| grain.id).ok(),
        }
    }

    /// Returns true for a contact point in the bulk. The point follows from the grains rather than from the code's own table, which may have
    /// another definition. Across the end of a periodic axis it lies between a grain and the nearest image of the other one.
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
        if self.in_bulk()[first] && self.in_bulk()[second] {
            return true;
        }
        // The distance of the grain's centre bounds the distance of the walls.
        let (distance, step) = (self.wall_distances()[first], share * arm.norm());
        if distance + step < (1.0 - 1e-6) * bulk.inset {
            return false;
        }
        let point = from.lerp(&to, share);
        match distance - step > bulk.inset {
            true => bulk.is_covered(&point),
            false => bulk.contains(&self.walls, &point),
        }
    }
}
