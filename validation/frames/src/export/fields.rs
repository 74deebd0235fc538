//! Coarse-grained fields on a grid, as VTK image data: one file per frame, and one of the mean over the frames of the measurement.
//!
//! With the mass m, the centre x and the velocity v of each grain, the force f of the first grain of a contact on its partner, and the branch l
//! from the centre of the first grain to that of its partner, or to the contact point on a wall, at a node r:
//!
//! ```text
//! density           rho(r)     = sum m phi(r - x)
//! velocity          V(r)       = sum m v phi(r - x) / rho(r)
//! kinetic stress    s^k_ab(r)  = sum m (v_a - V_a(r)) (v_b - V_b(r)) phi(r - x)
//! contact stress    s^c_ab(r)  = sum f_a l_b  int_0^1 phi(r - x - s l) ds
//! ```
//!
//! Compression is positive. With both stresses these fields satisfy the balances of mass and momentum for any phi (Goldhirsch, Granul. Matter 12,
//! 239, 2010); contacts with walls as in Weinhart et al., Granul. Matter 14, 289 (2012). phi is Lucy's function,
//!
//! ```text
//! phi(a) = 105/(16 pi c^3) (1 - a/c)^3 (1 + 3 a/c)          for a < c
//! ```
//!
//! with a support c of two mean diameters; its width, `c/2`, is one diameter. Nodes are half a support apart. The volume of a grain in place of its
//! mass gives the solid fraction.

use super::vtp::{ImageData, write_collection};
use super::{ExportError, Written, for_each};
use crate::output::{create_folder, write_whole};
use crate::run_frames::columns::{Column, Number, REAL, Shape, VECTOR};
use crate::run_frames::{RunFrame, RunFrames};
use makadam::laws::period::Period;
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::PI;
use std::path::Path;

/// Folder of the frames inside the output folder.
const FOLDER: &str = "fields";

/// Support of the coarse-graining function, mean diameters.
const SUPPORT: f64 = 2.0;

/// Distance of the nodes over the support.
const SPACING: f64 = 0.5;

/// Largest number of nodes: some 150 bytes each.
const MOST_NODES: f64 = 2e7;

/// Points and weights of the Gauss-Legendre rule on the branch of a contact, 0 to 1 (Abramowitz and Stegun, table 25.4).
const BRANCH: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// Tensors of a file, row by row.
const TENSOR: Shape = (Number::Float32, 9);

/// Writes `fields/fields-NUMBER.vti`, `fields.pvd` and `fields-mean.vti` into a folder.
pub(super) fn write(run: &RunFrames, folder: &Path, progress: &dyn Fn(f64)) -> Result<Vec<Written>, ExportError> {
    create_folder(&folder.join(FOLDER))?;
    let grid = Grid::of(run)?;
    let from = run.read(0)?.tables.scene.measure.from.unwrap_or(0.0);
    let (mut mean, mut measured, mut has_contacts) = (Fields::new(grid), 0, true);
    let mut list = Vec::new();
    for_each(0..run.count(), progress, |number| {
        let frame = run.read(number)?;
        let mut fields = Fields::new(grid);
        fields.add(&frame);
        has_contacts &= frame.contacts.is_some();
        let file = format!("{FOLDER}/fields-{number:05}.vti");
        write_whole(&folder.join(&file), &fields.encode(frame.time, 1.0, has_contacts))?;
        list.push((frame.time, file));
        if frame.time >= from {
            mean.nodes.iter_mut().zip(&fields.nodes).for_each(|(sum, node)| sum.merge(node));
            measured += 1;
        }
        Ok(())
    })?;
    let mut written = vec![write_collection(folder.join("fields.pvd"), &list)?];
    if measured > 0 {
        let path = folder.join("fields-mean.vti");
        write_whole(&path, &mean.encode(from, measured as f64, has_contacts))?;
        written.push(Written { path, frames: measured });
    }
    Ok(written)
}

/// Regular grid of nodes around the grains of all frames; along a periodic axis, whole cells fill the period.
#[derive(Clone, Copy)]
struct Grid {
    origin: Vector3<f64>,
    spacing: Vector3<f64>,
    counts: [usize; 3],
    support: f64,
    period: Period,
}

impl Grid {
    fn of(run: &RunFrames) -> Result<Grid, ExportError> {
        let (mut low, mut high) = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
        let [mut radii, mut grains] = [0.0; 2];
        for number in 0..run.count() {
            for particle in &run.snapshot(number)?.particles {
                (low, high) = (low.inf(&particle.position.into()), high.sup(&particle.position.into()));
                radii += particle.radius;
                grains += 1.0;
            }
        }
        let refused = |problem: String| ExportError::Format { file: FOLDER.into(), problem };
        let domain = &run.read(0)?.tables.scene.domain;
        let support = match grains > 0.0 {
            true => SUPPORT * 2.0 * radii / grains,
            // Without grains the fields are zero: a coarse grid over the domain.
            false => {
                (low, high) = (domain.min.into(), domain.max.into());
                (high - low).max()
            }
        };
        let period = domain.period();
        let mut grid =
            Grid { origin: low, spacing: Vector3::repeat(SPACING * support), counts: [0; 3], support, period };
        let mut nodes = [0.0; 3];
        for axis in 0..3 {
            if period.is_periodic(axis) {
                nodes[axis] = (period.length(axis) / grid.spacing[axis] - 1e-9).ceil().max(1.0);
                (grid.origin[axis], grid.spacing[axis]) = (domain.min[axis], period.length(axis) / nodes[axis]);
            } else {
                grid.origin[axis] -= support;
                nodes[axis] = ((high[axis] - low[axis] + 2.0 * support) / grid.spacing[axis] - 1e-9).ceil() + 1.0;
            }
        }
        let all: f64 = nodes.iter().product();
        if all > MOST_NODES {
            return Err(refused(format!(
                "the grid around the grains has {all:.2e} nodes, more than {MOST_NODES:e}; grains far from the others need a smaller \
                 domain, or a watch.on_escape that stops the run"
            )));
        }
        grid.counts = nodes.map(|count| count as usize);
        Ok(grid)
    }

    /// Returns the indices of the nodes of one axis within a support of some coordinates (m); along a periodic axis, images are beyond the counts.
    fn reach(&self, axis: usize, [low, high]: [f64; 2]) -> std::ops::RangeInclusive<i64> {
        let node = |place: f64| (place - self.origin[axis]) / self.spacing[axis];
        let (first, last) = (node(low - self.support).ceil() as i64, node(high + self.support).floor() as i64);
        match self.period.is_periodic(axis) {
            true => first..=last,
            false => first.max(0)..=last.min(self.counts[axis] as i64 - 1),
        }
    }

    /// Visits the nodes, and the images of nodes, within a support of the box around some points (m): index and position (m).
    fn for_each_near(&self, points: &[Vector3<f64>], mut visit: impl FnMut(usize, Vector3<f64>)) {
        let span = |axis: usize| {
            let all = || points.iter().map(|point| point[axis]);
            self.reach(axis, [all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max)])
        };
        let own = |axis: usize, index: i64| index.rem_euclid(self.counts[axis] as i64) as usize;
        for k in span(2) {
            for j in span(1) {
                for i in span(0) {
                    let place = self.origin + Vector3::new(i as f64, j as f64, k as f64).component_mul(&self.spacing);
                    visit((own(2, k) * self.counts[1] + own(1, j)) * self.counts[0] + own(0, i), place);
                }
            }
        }
    }
}

/// Sums of one node.
#[derive(Clone, Copy, Debug, Default)]
struct Node {
    volume: f64,
    mass: f64,
    momentum: Vector3<f64>,
    /// Sum of `m v v`.
    flux: Matrix3<f64>,
    contact_stress: Matrix3<f64>,
}

impl Node {
    fn merge(&mut self, other: &Node) {
        self.volume += other.volume;
        self.mass += other.mass;
        self.momentum += other.momentum;
        self.flux += other.flux;
        self.contact_stress += other.contact_stress;
    }
}

/// Fields on a grid.
struct Fields {
    grid: Grid,
    nodes: Vec<Node>,
}

impl Fields {
    fn new(grid: Grid) -> Fields {
        Fields { grid, nodes: vec![Node::default(); grid.counts.iter().product()] }
    }

    /// Adds the grains and contacts of a frame.
    fn add(&mut self, frame: &RunFrame) {
        let masses = frame.column("mass").expect("a column of every frame").values;
        let Fields { grid, nodes } = self;
        for (particle, mass) in frame.snapshot.particles.iter().zip(masses) {
            let (centre, velocity) = (Vector3::from(particle.position), Vector3::from(particle.velocity));
            let (volume, flux) = (4.0 / 3.0 * PI * particle.radius.powi(3), velocity * velocity.transpose() * mass);
            grid.for_each_near(&[centre], |node, place| {
                let weight = lucy((place - centre).norm(), grid.support);
                nodes[node].volume += volume * weight;
                nodes[node].mass += mass * weight;
                nodes[node].momentum += velocity * (mass * weight);
                nodes[node].flux += flux * weight;
            });
        }
        let ends = frame.tables.ends(&frame.snapshot);
        for (contact, ends) in frame.snapshot.contacts.iter().zip(ends) {
            let [from, to] = ends.map(Vector3::from);
            let branch = to - from;
            let moment = contact.force_on_partner() * branch.transpose();
            grid.for_each_near(&[from, to], |node, place| {
                let arm = place - from;
                let weight: f64 =
                    BRANCH.iter().map(|(s, share)| share * lucy((arm - branch * *s).norm(), grid.support)).sum();
                nodes[node].contact_stress += moment * weight;
            });
        }
    }

    /// Returns the bytes of a file, with the sums of this number of frames; without contacts in the frames, the file has neither their stress
    /// nor the pressure.
    fn encode(&self, time: f64, frames: f64, has_contacts: bool) -> Vec<u8> {
        let nodes = || self.nodes.iter();
        let velocity = |node: &Node| if node.mass > 0.0 { node.momentum / node.mass } else { Vector3::zeros() };
        let kinetic = |node: &Node| (node.flux - node.momentum * velocity(node).transpose()) / frames;
        let temperature =
            |node: &Node| if node.mass > 0.0 { kinetic(node).trace() * frames / (3.0 * node.mass) } else { 0.0 };
        let pressure = |node: &Node| (node.contact_stress / frames + kinetic(node)).trace() / 3.0;
        let rows = |tensor: Matrix3<f64>| tensor.transpose().iter().copied().collect::<Vec<f64>>();
        let mut columns = vec![
            Column::new("solid_fraction", REAL, nodes().map(|node| node.volume / frames)),
            Column::new("density", REAL, nodes().map(|node| node.mass / frames)),
            Column::new("velocity", VECTOR, nodes().flat_map(|node| <[f64; 3]>::from(velocity(node)))),
            Column::new("granular_temperature", REAL, nodes().map(temperature)),
            Column::new("kinetic_stress", TENSOR, nodes().flat_map(|node| rows(kinetic(node)))),
        ];
        if has_contacts {
            columns.push(Column::new(
                "contact_stress",
                TENSOR,
                nodes().flat_map(|node| rows(node.contact_stress / frames)),
            ));
            columns.push(Column::new("pressure", REAL, nodes().map(pressure)));
        }
        let Grid { origin, spacing, counts, .. } = self.grid;
        ImageData { time, origin: origin.into(), spacing: spacing.into(), counts, columns: &columns }.encode()
    }
}

/// Returns Lucy's function (1/m3) at a distance (m) for a support (m); its integral over space is 1 (Lucy, Astron. J. 82, 1013, 1977).
fn lucy(distance: f64, support: f64) -> f64 {
    let share = distance / support;
    if share >= 1.0 {
        return 0.0;
    }
    105.0 / (16.0 * PI * support.powi(3)) * (1.0 - share).powi(3) * (1.0 + 3.0 * share)
}

#[cfg(test)]
#[path = "../../tests/unit/export_fields.rs"]
mod tests;
