//! Contacts of a frame: from the rows of files to the measured contact list.

use super::columns::{Column, numbered};
use super::identity::Numbers;
use super::manifest::{Manifest, Missing};
use super::table::{FrameTable, ImportError};
use crate::neighbours::close_pairs_in;
use crate::plan::MeasuredScene;
use crate::recording::LARGEST;
use makadam::effects::period::Period;
use makadam::snapshot::{Contact, Particle, Partner, Snapshot};
use nalgebra::Vector3;
use std::collections::{BTreeMap, BTreeSet};

/// Cosine of 15 degrees: contacts of one grain with one wall at a smaller angle of their normals are one contact. Neighbouring triangles of
/// a curved wall differ by a few degrees; the corners of containers are sharper.
const SAME_FACE: f64 = 0.966;

/// Relative error of coordinates: files have at least six digits.
const ROUNDING: f64 = 1e-5;

/// Columns of a contact table.
pub(super) struct Columns {
    first: usize,
    second: Option<usize>,
    wall: Option<usize>,
    point: Option<[usize; 3]>,
    normal: Option<[usize; 3]>,
    forces: Forces,
}

impl Columns {
    /// Finds the columns of a table; `None` if statements are missing, which are added to `missing`.
    pub fn of(table: &FrameTable, missing: &mut Missing) -> Option<Columns> {
        let (second, wall) = (table.find(Column::Second), table.find(Column::Wall));
        let first = table.find(Column::First).or(table.find(Column::Id));
        let forces = Forces::of(table);
        let (Some(first), Some(forces), true) = (first, forces, second.or(wall).is_some()) else {
            add_missing(table, missing);
            return None;
        };
        let point = table.vector(Column::Point).or(table.vector(Column::Position));
        Some(Columns { first, second, wall, point, normal: table.vector(Column::Normal), forces })
    }
}

/// Adds the manifest line with the columns of a contact table, in their order or as numbered by LIGGGHTS (`c_pairs[1]`).
fn add_missing(table: &FrameTable, missing: &mut Missing) {
    let needed = "needed are first; second or wall; fx, fy, fz (force on the first grain), or its parts fnx, fny, fnz and ftx, fty, ftz, or \
                  normal_force and tangential_force_x, _y, _z; px, py, pz with walls";
    let Some(compute) = table.unread.iter().find_map(|name| numbered(name)) else {
        let meaning = format!("names of the columns {} in their order; {needed}", table.names());
        return missing.add(table, 0, "contact-columns = [\"first\", \"second\", ...]", meaning);
    };
    let count = table.unread.iter().filter(|name| numbered(name) == Some(compute)).count();
    let known: &[(&str, &str)] = match count {
        9 => &[("pair/gran/local id force contactPoint", "first,second,_,fx,fy,fz,px,py,pz")],
        12 => &[
            ("pair/gran/local pos id force", "_,_,_,_,_,_,first,second,_,fx,fy,fz"),
            ("wall/gran/local pos id force", "px,py,pz,_,_,_,wall,_,first,fx,fy,fz"),
        ],
        _ => &[],
    };
    let mut add = |names: &str, meaning: &str| {
        let names: Vec<String> = names.split(',').map(|name| format!("\"{name}\"")).collect();
        missing.add(table, 0, format!("contact-columns.{compute} = [{}]", names.join(", ")), meaning);
    };
    for (words, names) in known {
        add(names, &format!("where it is compute {words}; the first grain is that which feels the force"));
    }
    if known.is_empty() {
        add(
            "first,second,_,fx,fy,fz",
            &format!("names of its {count} columns in their order, such as these; {needed}"),
        );
    }
}

/// Forces in a contact table.
#[derive(Clone, Copy)]
enum Forces {
    /// Total force on the first grain.
    OnFirst([usize; 3]),
    /// Normal and tangential force on the first grain.
    Parts([[usize; 3]; 2]),
    /// Normal force, and tangential force on the partner.
    Split(usize, [usize; 3]),
}

impl Forces {
    fn of(table: &FrameTable) -> Option<Forces> {
        let whole = || Some(Forces::OnFirst(table.vector(Column::Force)?));
        let split = || Some(Forces::Split(table.find(Column::NormalForce)?, table.vector(Column::Tangential)?));
        let parts = || {
            let normal = table.vector(Column::NormalOnFirst)?;
            Some(Forces::Parts([normal, table.vector(Column::TangentialOnFirst)?]))
        };
        whole().or_else(split).or_else(parts)
    }

    /// Makes the contact of a row; `None` if its force is zero.
    fn contact(
        self,
        row: &[f64],
        first: u32,
        second: Partner,
        at: Vector3<f64>,
        along: Vector3<f64>,
    ) -> Option<Contact> {
        let (point, normal) = (at.into(), along.into());
        let whole = |force| contact_from_force(first, second, point, along, force);
        match self {
            Forces::OnFirst(force) => whole(vector(row, force)),
            Forces::Parts(parts) => whole(parts.map(|part| vector(row, part)).iter().sum()),
            Forces::Split(normal_force, tangential) => {
                let tangential_force = vector(row, tangential).into();
                Some(Contact { first, second, point, normal, normal_force: row[normal_force], tangential_force })
            }
        }
    }
}

pub(super) fn vector(row: &[f64], [x, y, z]: [usize; 3]) -> Vector3<f64> {
    Vector3::new(row[x], row[y], row[z])
}

/// Contacts of a frame, from its files.
pub(super) struct ContactList<'a> {
    scene: &'a MeasuredScene,
    manifest: &'a Manifest,
    numbers: &'a Numbers,
    particles: &'a [Particle],
    /// Force-carrying contacts.
    pub contacts: Vec<Contact>,
    /// Listed pairs of grains, with or without a force: the smaller number first.
    pairs: BTreeSet<(u32, u32)>,
    /// Indices of the contacts of a grain with a wall.
    walls: BTreeMap<(u32, u32), Vec<usize>>,
}

impl<'a> ContactList<'a> {
    pub fn new(
        scene: &'a MeasuredScene,
        manifest: &'a Manifest,
        numbers: &'a Numbers,
        particles: &'a [Particle],
    ) -> Self {
        let (contacts, pairs, walls) = (Vec::new(), BTreeSet::new(), BTreeMap::new());
        ContactList { scene, manifest, numbers, particles, contacts, pairs, walls }
    }

    /// Returns the grain with a number of the files, if the frame has it.
    fn grain(&self, own: f64) -> Option<&'a Particle> {
        let id = self.numbers.get(&(own as i64)).filter(|_| own.fract() == 0.0)?;
        let index = self.particles.binary_search_by_key(id, |particle| particle.id).ok()?;
        Some(&self.particles[index])
    }

    /// Adds the rows of a table.
    ///
    /// # Errors
    /// [`ImportError`] for a contact of missing grains or walls, of separate grains or walls, or listed twice.
    pub fn add(&mut self, table: &FrameTable, columns: &Columns) -> Result<(), ImportError> {
        let period = self.scene.domain.period();
        for (index, row) in table.rows().enumerate() {
            let fault = |problem: String| table.fault(index, problem);
            let grain = |column: usize| {
                let missing = || fault(format!("there is no grain {} in this frame", row[column]));
                self.grain(row[column]).ok_or_else(missing)
            };
            let first = grain(columns.first)?;
            let stated = |column: Option<usize>| column.filter(|column| row[*column] >= 0.0);
            let (partner, second, other) = match (stated(columns.second), stated(columns.wall)) {
                (Some(column), None) => {
                    let second = grain(column)?;
                    (Partner::Grain(second.id), Some(second), ("grain", row[column]))
                }
                (None, Some(column)) => {
                    (Partner::Wall(self.wall(row[column]).map_err(fault)?), None, ("wall", row[column]))
                }
                _ => {
                    let problem = "a contact has either a second grain or a wall; the other number is negative";
                    return Err(fault(problem.into()));
                }
            };
            let both = || format!("grain {} and {} {}", row[columns.first], other.0, other.1);
            if let Some(second) = second {
                let pair = (first.id.min(second.id), first.id.max(second.id));
                if first.id == second.id || !self.pairs.insert(pair) {
                    return Err(fault(format!("{} are listed twice, or are one; list each contact once", both())));
                }
            }
            let point = columns.point.map(|point| vector(row, point));
            let (point, towards) = geometry(first, second, point, period)
                .ok_or_else(|| fault("a contact with a wall needs its point: px, py, pz".into()))?;
            // No contact law has a cutoff beyond one radius.
            let (touch, reach) = second.map_or((first.radius, first.radius), |second| {
                (first.radius + second.radius, first.radius.min(second.radius))
            });
            if towards.norm() > touch + reach {
                let gap = towards.norm() - touch;
                return Err(fault(format!(
                    "{} are {gap:.3e} m apart: contacts have to number grains as the frames do, and to be of their time",
                    both()
                )));
            }
            let given = columns.normal.map(|normal| vector(row, normal)).filter(|normal| *normal != Vector3::zeros());
            if given.is_some_and(|normal| normal.dot(&towards) < 0.0) {
                return Err(fault(format!("the normal of {} leads away from the partner; turn it", both())));
            }
            let normal = given.unwrap_or(towards).try_normalize(0.0);
            let contact = columns.forces.contact(row, first.id, partner, point, normal.unwrap_or_default());
            let Some(contact) = contact else { continue };
            if normal.is_none() {
                return Err(fault(format!("the centres of {} coincide; give normals nx, ny, nz", both())));
            }
            if let Partner::Wall(wall) = partner {
                // Contacts with several triangles of one wall have a point each.
                let known = self.walls.entry((first.id, wall)).or_default();
                if table.first_id.is_none() && known.iter().any(|index| self.contacts[*index] == contact) {
                    return Err(fault(format!("{} are listed twice, at one point; list each contact once", both())));
                }
                known.push(self.contacts.len());
            }
            self.contacts.push(contact);
        }
        Ok(())
    }

    /// Returns the wall of the scene for a wall number of the files.
    fn wall(&self, number: f64) -> Result<u32, String> {
        let stated = &self.manifest.walls;
        let count = if stated.is_empty() { self.scene.wall.len() } else { stated.len() };
        if number.fract() != 0.0 || number >= count as f64 {
            return Err(format!("there is no wall {number}: there are {count}, from 0 (key walls states others)"));
        }
        Ok(stated.get(number as usize).copied().unwrap_or(number as u32))
    }

    /// Checks complete contact lists. Two grains are in contact if they approach each other and their overlap exceeds their approach in `step`
    /// (s), the largest age difference between positions and contacts.
    ///
    /// # Errors
    /// [`ImportError`] with the first pair in contact that no list has.
    pub fn check_complete(&self, tables: &[&FrameTable], step: f64) -> Result<(), ImportError> {
        let is_stated = |table: &&&FrameTable| table.first_id.is_none() && table.find(Column::Second).is_some();
        let Some(table) = tables.iter().find(is_stated) else { return Ok(()) };
        for pair in close_pairs_in(&self.scene.domain, self.particles, 0.0) {
            let (one, other) = (&self.particles[pair.first], &self.particles[pair.second]);
            let [a, b] = [one.position, other.position];
            let towards = self.scene.domain.period().arm(&a.into(), &b.into()).try_normalize(0.0).unwrap_or_default();
            let approach = (Vector3::from(one.velocity) - Vector3::from(other.velocity)).dot(&towards);
            let largest = a.iter().chain(&b).fold(0.0, |most: f64, x| most.max(x.abs()));
            let is_pressed = approach > 0.0 && -pair.gap > approach * step + ROUNDING * largest;
            if is_pressed && !self.pairs.contains(&(one.id.min(other.id), one.id.max(other.id))) {
                let problem = format!(
                    "the grains at {a:?} m and at {b:?} m press on each other, with an overlap of {:.3e} m, and no file lists their contact: \
                     contacts-complete is wrong; list all contacts, or leave the files of contacts out",
                    -pair.gap
                );
                return Err(table.fault(0, problem));
            }
        }
        Ok(())
    }
}

/// Returns the contact point, and the vector from the first grain to the second, or to a wall; `None` if a wall's point is unknown.
fn geometry(
    first: &Particle,
    second: Option<&Particle>,
    point: Option<Vector3<f64>>,
    period: Period,
) -> Option<(Vector3<f64>, Vector3<f64>)> {
    let centre = Vector3::from(first.position);
    let Some(second) = second else {
        return point.map(|point| (point, period.arm(&centre, &point)));
    };
    let towards = period.arm(&centre, &second.position.into());
    let between = centre + towards * (first.radius / (first.radius + second.radius));
    Some((point.unwrap_or(between), towards))
}

/// Merges the contacts of a grain with several triangles of one face of a wall; forces are summed.
pub fn merge_wall_contacts(contacts: Vec<Contact>) -> Vec<Contact> {
    let mut merged: Vec<Contact> = Vec::with_capacity(contacts.len());
    let mut last_of = std::collections::HashMap::<(u32, u32), Vec<usize>>::new();
    for contact in contacts {
        let Partner::Wall(wall) = contact.second else {
            merged.push(contact);
            continue;
        };
        let places = last_of.entry((contact.first, wall)).or_default();
        let normal = Vector3::from(contact.normal);
        match places.iter().find(|&&place| Vector3::from(merged[place].normal).dot(&normal) > SAME_FACE) {
            Some(&place) => merged[place] = sum(&merged[place], &contact),
            None => {
                places.push(merged.len());
                merged.push(contact);
            }
        }
    }
    merged
}

fn sum(a: &Contact, b: &Contact) -> Contact {
    let force = |contact: &Contact| {
        Vector3::from(contact.normal) * contact.normal_force + Vector3::from(contact.tangential_force)
    };
    let (share_a, share_b) = match a.normal_force.abs() + b.normal_force.abs() {
        total if total > 0.0 => (a.normal_force.abs() / total, b.normal_force.abs() / total),
        _ => (0.5, 0.5),
    };
    let mean = |x: [f64; 3], y: [f64; 3]| Vector3::from(x) * share_a + Vector3::from(y) * share_b;
    let normal = mean(a.normal, b.normal).normalize();
    let total = force(a) + force(b);
    let normal_force = total.dot(&normal);
    Contact {
        first: a.first,
        second: a.second,
        point: mean(a.point, b.point).into(),
        normal: normal.into(),
        normal_force,
        tangential_force: (total - normal * normal_force).into(),
    }
}

/// Returns the frame if the magnitudes of its contact forces are admissible: huge numbers in a file overflow in products.
///
/// # Errors
/// The grain with a force above the limit.
pub fn measurable(frame: Snapshot) -> Result<Snapshot, String> {
    let finite = |contact: &Contact| {
        let vectors = [contact.normal, contact.tangential_force, contact.point];
        contact.normal_force.abs() < LARGEST && vectors.iter().flatten().all(|component| component.abs() < LARGEST)
    };
    match frame.contacts.iter().find(|contact| !finite(contact)) {
        None => Ok(frame),
        Some(contact) => Err(format!("a force on grain {} is beyond all numbers: the run diverged", contact.first)),
    }
}

/// Makes a contact from the force on its first grain; `None` if the force is zero.
pub fn contact_from_force(
    first: u32,
    second: Partner,
    point: [f64; 3],
    normal: Vector3<f64>,
    force_on_first: Vector3<f64>,
) -> Option<Contact> {
    if force_on_first == Vector3::zeros() {
        return None;
    }
    let on_partner = -force_on_first;
    let normal_force = on_partner.dot(&normal);
    Some(Contact {
        first,
        second,
        point,
        normal: normal.into(),
        normal_force,
        tangential_force: (on_partner - normal * normal_force).into(),
    })
}
