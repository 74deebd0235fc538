//! From tables to a recording: times, grains by number, contacts with their partners, and what all of them lack.

use super::columns::{Column, Places};
use super::completeness::{Completeness, Named};
use super::frame_table::{FrameTable, ImportError, Periods};
use super::identity::{Group, Numbers, numbers, range};
use super::plausible::{apart, askew, beside, image, is_same, of_other_scene, standing};
use super::stated::{Stated, numbered};
use super::timing::Given;
use super::{Tables, contact_from_force, measurable, merge_wall_contacts};
use crate::plan::Scene;
use crate::recording::{Content, Recording};
use makadam::effects::period::Period;
use makadam::scene::{Domain, populate};
use makadam::snapshot::{Contact, Particle, Partner, Snapshot};
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::path::Path;

/// What is known of frames beside their files.
pub struct Assembly<'a> {
    /// The scene that was simulated.
    pub scene: &'a Scene,
    /// Name of the code.
    pub code: &'a str,
    /// Its version.
    pub version: &'a str,
    /// Statements that the files do not make.
    pub stated: &'a Stated,
}

/// Frames as a recording, and what had to be assumed.
#[derive(Debug)]
pub struct Imported {
    /// The frames.
    pub recording: Recording,
    /// What a reader must know, in sentences.
    pub notes: Vec<String>,
}

impl Assembly<'_> {
    /// Puts the frames together.
    ///
    /// # Errors
    /// [`ImportError`] with file and line.
    pub fn assemble(&self, tables: &Tables) -> Result<Imported, ImportError> {
        let mut notes = tables.notes.clone();
        notes.extend(tables.runs.iter().filter_map(|run| of_other_scene(run, self.scene)));
        let grains = self.timed(&tables.grains, &mut notes)?;
        let Some((_, first)) = grains.first() else {
            return Err(ImportError::new(Path::new("-"), 1, "no file has a frame; give files of grains"));
        };
        let places = Places::of(first);
        position(first, &places)?;
        grains
            .iter()
            .map(|(_, table)| *table)
            .chain(&tables.contacts)
            .try_for_each(|table| same_box(table, &self.scene.domain))?;
        let has = |of: fn(usize) -> Column| grains.iter().all(|(_, table)| Places::of(table).vector(of).is_some());
        let driven: Vec<u32> =
            (0..).zip(&self.scene.wall).filter(|(_, wall)| wall.motion.is_driven()).map(|(wall, _)| wall).collect();
        let states_poses =
            |table: &FrameTable| driven.iter().all(|wall| table.driven_walls.iter().any(|stated| stated.wall == *wall));
        let mut lacks = Vec::new();
        if driven.is_empty() || !grains.iter().all(|(_, table)| states_poses(table)) {
            lacks.push(Content::DrivenWalls);
        }
        if !has(Column::Velocity) {
            lacks.push(Content::Velocities);
        }
        if !has(Column::Spin) {
            lacks.push(Content::Spins);
        }
        if tables.contacts.is_empty() {
            lacks.extend([Content::Contacts, Content::WallContacts]);
        } else if !tables.contacts.iter().any(|table| Places::of(table).find(Column::Wall).is_some()) {
            lacks.push(Content::WallContacts);
        }
        // More grains than the scene has are one frame too many, whatever their kinds.
        self.count(&grains, &mut notes)?;
        let numbers = numbers(self.scene, self.stated, &grains, &mut notes)?;
        let radii = match places.radius() {
            Some(_) => None,
            None => Some(self.radii(first, &mut notes)?),
        };
        let Given { tables: mut contacts, unsure } = self.contacts(&tables.contacts, &grains, &mut notes)?;
        for content in unsure {
            if !lacks.contains(&content) {
                lacks.push(content);
            }
        }
        let measured = self.measured(&grains);
        let mut completeness = Completeness::new(!lacks.contains(&Content::Velocities));
        let mut frames = Vec::with_capacity(grains.len());
        for (place, (time, table)) in grains.iter().enumerate() {
            let particles = particles(table, &numbers, radii.as_deref(), &self.scene.domain)?;
            let mut found = Found::default();
            let of_frame = std::mem::take(&mut contacts[place]);
            for table in &of_frame {
                self.add_contacts(table, &particles, &numbers, &mut found)?;
            }
            let snapshot = Snapshot {
                time: *time,
                particles,
                contacts: merge_wall_contacts(found.contacts),
                driven_walls: table.driven_walls.clone(),
                ..Snapshot::default()
            };
            let snapshot = measurable(snapshot).map_err(|problem| table.fault(0, problem))?;
            if measured[place] && !of_frame.is_empty() {
                completeness.look(self.scene, &snapshot, &found.named, !lacks.contains(&Content::WallContacts));
            }
            frames.push(snapshot);
        }
        notes.extend(completeness.unseen());
        for (content, problem) in completeness.lacking(self.scene) {
            notes.push(problem);
            if !lacks.contains(&content) {
                lacks.push(content);
            }
        }
        notes.extend(standing(frames.iter().zip(&measured).filter(|(_, measured)| **measured).map(|(frame, _)| frame)));
        let simulated_seconds = frames.last().map_or(0.0, |frame| frame.time);
        let recording = Recording {
            scene: self.scene.name.clone(),
            code: self.code.into(),
            version: self.version.into(),
            seed: self.stated.seed.unwrap_or(self.scene.seed),
            // Frames tell no step of the code; that by which they are numbered need not be it.
            time_step: 0.0,
            rayleigh_fraction: None,
            stiffness_factor: 1.0,
            threads: 1,
            wall_seconds: 0.0,
            core_seconds: None,
            simulated_seconds,
            frames,
            lacks,
            alarms: Vec::new(),
            notes: Vec::new(),
        };
        Ok(Imported { recording, notes })
    }

    /// Radii of the scene's grains, m, where a scene has one radius per kind, or the caller states that grains are numbered and were placed as
    /// the scene numbers and places them.
    fn radii(&self, table: &FrameTable, notes: &mut Vec<String>) -> Result<Vec<f64>, ImportError> {
        let columns = Places::of(table).names();
        let missing = format!("there is no column radius or diameter among {columns}");
        let groups = Group::all(self.scene);
        if groups.iter().all(|group| group.radii.0 == group.radii.1) {
            let radii: Vec<f64> = groups.iter().flat_map(Group::each_radius).collect();
            notes.push(format!("radii are those of the scene, {}", range(bounds(&groups))));
            return Ok(radii);
        }
        if self.stated.first_id.is_some()
            && let Some(seed) = self.stated.seed
        {
            let grains = populate(self.scene, seed).map_err(|error| table.fault(0, format!("{missing}; {error}")))?;
            notes
                .push(format!("radii are those of the scene's grains with seed {seed}, in the order of their numbers"));
            return Ok(grains.iter().map(|grain| grain.radius).collect());
        }
        let problem = format!(
            "{missing}, and the scene has radii of {}: leave the radii in a column radius, or name it with --columns; where grains are numbered \
             and were placed as the scene does, add --first-id NUMBER --seed SEED",
            range(bounds(&groups))
        );
        Err(table.fault(0, problem))
    }

    fn add_contacts(
        &self,
        table: &FrameTable,
        particles: &[Particle],
        numbers: &Numbers,
        found: &mut Found,
    ) -> Result<(), ImportError> {
        let places = Places::of(table);
        let missing = |what: &str| {
            let remedy = nameless(table).unwrap_or_else(|| "name the columns with --contact-columns".into());
            table.fault(0, format!("no column {what} among {}; {remedy}", places.names()))
        };
        let first =
            places.find(Column::First).or(places.find(Column::Id)).ok_or_else(|| missing("first (the first grain)"))?;
        let (second, wall) = (places.find(Column::Second), places.find(Column::Wall));
        if second.is_none() && wall.is_none() {
            return Err(missing("second (the second grain) or wall"));
        }
        let point = places.vector(Column::Point).or(places.vector(Column::Position));
        let forces = Forces::of(&places).ok_or_else(|| {
            missing(
                "fx, fy, fz (force on the first grain), or normal_force and tangential_force_x, _y, _z, \
                 or fnx, fny, fnz and ftx, fty, ftz (its parts on the first grain)",
            )
        })?;
        let normal = places.vector(Column::Normal);
        let period = self.scene.domain.period();
        for (row, numbers_of_row) in table.rows().enumerate() {
            let fault = |problem: String| table.fault(row, problem);
            let grain = |place: usize| {
                let own = numbers_of_row[place];
                let id = numbers.get(&(own as i64)).filter(|_| own.fract() == 0.0);
                let known = id.and_then(|id| particles.binary_search_by_key(id, |particle| particle.id).ok());
                known
                    .map(|place| &particles[place])
                    .ok_or_else(|| fault(format!("there is no grain {own} in this frame")))
            };
            let a = grain(first)?;
            let named = |place: Option<usize>| place.filter(|place| numbers_of_row[*place] >= 0.0);
            let (partner, other) = match (named(second), named(wall)) {
                (Some(place), None) => {
                    let other = grain(place)?;
                    found.named.meet(a.id, other.id).map_err(|how| {
                        fault(format!("grains {} and {} {how}", numbers_of_row[first], numbers_of_row[place]))
                    })?;
                    (Partner::Grain(other.id), Some(other))
                }
                (None, Some(place)) => {
                    let number = numbers_of_row[place];
                    let stated = &self.stated.walls;
                    let known = if stated.is_empty() { self.scene.wall.len() } else { stated.len() };
                    if number.fract() != 0.0 || number >= known as f64 {
                        return Err(fault(format!("there is no wall {number}: the scene has {known}, from 0")));
                    }
                    let wall = stated.get(number as usize).copied().unwrap_or(number as u32);
                    if wall as usize >= self.scene.wall.len() {
                        return Err(fault(format!(
                            "walls names wall {wall}, and the scene has {}",
                            self.scene.wall.len()
                        )));
                    }
                    (Partner::Wall(wall), None)
                }
                _ => {
                    return Err(fault(
                        "a contact has either a second grain or a wall; the other number is negative".into(),
                    ));
                }
            };
            let given = normal.map(|places| vector(numbers_of_row, places));
            let (point, towards) = geometry(a, other, point.map(|places| vector(numbers_of_row, places)), period)
                .ok_or_else(|| fault("a contact with a wall needs its point: px, py, pz".into()))?;
            if let Some(problem) = apart(a, other, &towards) {
                let own = |place: Option<usize>| place.map_or(f64::NAN, |place| numbers_of_row[place]);
                let what = match partner {
                    Partner::Grain(_) => format!("grain {}", own(second)),
                    Partner::Wall(_) => format!("wall {}", own(wall)),
                };
                return Err(fault(format!("grain {} and {what} {problem}", numbers_of_row[first])));
            }
            if let Some(off) = other.and_then(|other| beside(a, other, &point, period)) {
                return Err(fault(format!(
                    "the point of grain {} and grain {} lies {off:.3e} m from the grains; give points px, py, pz, or leave them out",
                    numbers_of_row[first],
                    numbers_of_row[second.unwrap_or(first)]
                )));
            }
            let given = given.filter(|normal| *normal != Vector3::zeros());
            if let Some(angle) = given.and_then(|normal| askew(&normal, &towards, a.radius)) {
                return Err(fault(format!(
                    "the normal of grain {} is {angle:.0} degrees off the way to its partner; normals lead from the first grain to its \
                     partner, and may be left out",
                    numbers_of_row[first]
                )));
            }
            let Some(towards) = given.unwrap_or(towards).try_normalize(0.0) else {
                if !forces.bear(numbers_of_row) {
                    continue;
                }
                return Err(fault(format!(
                    "grain {} touches its partner in its own centre, which leaves the direction open; give normals nx, ny, nz",
                    numbers_of_row[first]
                )));
            };
            let whole = |force| contact_from_force(a.id, partner, point.into(), towards, force);
            if let Partner::Wall(wall) = partner {
                found.named.walls.entry((a.id, wall)).or_default().push(towards);
            }
            match forces {
                Forces::OnFirst(force) => found.add(whole(vector(numbers_of_row, force))),
                Forces::Parts(parts) => found.add(whole(parts.map(|part| vector(numbers_of_row, part)).iter().sum())),
                Forces::Split(normal_force, tangential) => found.add(Some(Contact {
                    first: a.id,
                    second: partner,
                    point: point.into(),
                    normal: towards.into(),
                    normal_force: numbers_of_row[normal_force],
                    tangential_force: vector(numbers_of_row, tangential).into(),
                })),
            }
            .map_err(|how| fault(format!("grain {} {how}", numbers_of_row[first])))?;
        }
        Ok(())
    }
}

/// Smallest and largest radius of a scene, m.
fn bounds(groups: &[Group<'_>]) -> (f64, f64) {
    groups.iter().fold((f64::INFINITY, 0.0), |(low, high), group| (group.radii.0.min(low), group.radii.1.max(high)))
}

/// Refuses a file whose periodic box is another one than the scene's: contacts and overlaps across it would be others.
fn same_box(table: &FrameTable, domain: &Domain) -> Result<(), ImportError> {
    let Some(Periods { lengths, rounding }) = table.periods else { return Ok(()) };
    let period = domain.period();
    let name = |axis: usize| ["x", "y", "z"][axis];
    for (axis, length) in lengths.into_iter().enumerate() {
        let own = if period.is_periodic(axis) { domain.max[axis] - domain.min[axis] } else { 0.0 };
        if (length - own).abs() <= rounding && (length > 0.0) == (own > 0.0) {
            continue;
        }
        let words = |length: f64| match length > 0.0 {
            true => format!("periodic along {}, with a length of {length} m", name(axis)),
            false => format!("not periodic along {}", name(axis)),
        };
        let problem =
            format!("its box is {}, and the scene is {}; give the scene that was run", words(length), words(own));
        return Err(table.fault(0, problem));
    }
    Ok(())
}

/// The option that names columns which a file only numbers, such as `c_pairs[1]`: those of LIGGGHTS's local computes.
fn nameless(table: &FrameTable) -> Option<String> {
    let compute = table.unread.iter().find_map(|name| numbered(name))?;
    let count = table.unread.iter().filter(|name| numbered(name) == Some(compute)).count();
    let known: &[(&str, &str)] = match count {
        9 => &[("pair/gran/local id force contactPoint", "first,second,_,fx,fy,fz,px,py,pz")],
        12 => &[
            ("pair/gran/local pos id force", "_,_,_,_,_,_,first,second,_,fx,fy,fz"),
            ("wall/gran/local pos id force", "px,py,pz,_,_,_,wall,_,first,fx,fy,fz"),
        ],
        _ => &[],
    };
    let option = |(words, names): &(&str, &str)| format!("--contact-columns {compute}:{names} (compute {words})");
    let options = known.iter().map(option).collect::<Vec<_>>().join(", or ");
    Some(match known {
        [] => format!(
            "state what the {count} columns of {compute} are, in their order: --contact-columns {compute}:first,second,_,fx,fy,fz,..."
        ),
        _ => format!(
            "state what the {count} columns of {compute} are: {options}; the first grain is that which feels the force"
        ),
    })
}

/// The contacts of a frame.
#[derive(Default)]
struct Found {
    contacts: Vec<Contact>,
    /// What touches: two spheres touch once, and a contact that is listed twice would count twice.
    named: Named,
    /// Places of the contacts of a grain with a wall.
    walls: BTreeMap<(u32, u32), Vec<usize>>,
}

impl Found {
    /// Adds a contact, if there is one. Triangles of one wall are touched at points of their own.
    ///
    /// # Errors
    /// What is wrong with it, in words that follow the grain's name.
    fn add(&mut self, contact: Option<Contact>) -> Result<(), &'static str> {
        let Some(contact) = contact else { return Ok(()) };
        if let Partner::Wall(wall) = contact.second {
            let known = self.walls.entry((contact.first, wall)).or_default();
            if known.iter().any(|place| is_same(&self.contacts[*place], &contact)) {
                return Err("touches a wall twice in this frame at one point with one force; list each contact once");
            }
            known.push(self.contacts.len());
        }
        self.contacts.push(contact);
        Ok(())
    }
}

/// How a table tells forces.
#[derive(Clone, Copy)]
enum Forces {
    /// The whole force on the first grain.
    OnFirst([usize; 3]),
    /// Normal and tangential force on the first grain.
    Parts([[usize; 3]; 2]),
    /// The normal force, and the tangential force on the partner.
    Split(usize, [usize; 3]),
}

impl Forces {
    /// Where a table has them, if it has them in one of these ways.
    fn of(places: &Places<'_>) -> Option<Forces> {
        let whole = || Some(Forces::OnFirst(places.vector(Column::Force)?));
        let split = || Some(Forces::Split(places.find(Column::NormalForce)?, places.vector(Column::Tangential)?));
        let parts = || {
            let normal = places.vector(Column::NormalOnFirst)?;
            Some(Forces::Parts([normal, places.vector(Column::TangentialOnFirst)?]))
        };
        whole().or_else(split).or_else(parts)
    }

    /// Whether a row has a force.
    fn bear(self, row: &[f64]) -> bool {
        let is_one = |place: usize| row[place] != 0.0;
        match self {
            Forces::OnFirst(force) => force.into_iter().any(is_one),
            Forces::Parts(parts) => parts.into_iter().flatten().any(is_one),
            Forces::Split(normal, tangential) => is_one(normal) || tangential.into_iter().any(is_one),
        }
    }
}

/// The contact point and the way from the first grain to the second, or to a wall; none where a wall's point is not known.
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

fn vector(row: &[f64], [x, y, z]: [usize; 3]) -> Vector3<f64> {
    Vector3::new(row[x], row[y], row[z])
}

/// Where the coordinates stand.
fn position(table: &FrameTable, places: &Places<'_>) -> Result<[usize; 3], ImportError> {
    let scaled = table.unread.iter().any(|name| ["xs", "xsu"].contains(&name.as_str()));
    places.vector(Column::Position).ok_or_else(|| {
        let hint = match scaled {
            true => "coordinates are scaled to the box: dump x y z instead",
            false => "name the columns with --columns",
        };
        table.fault(0, format!("no columns x, y, z among {}; {hint}", places.names()))
    })
}

/// The grains of a frame, in the order of their numbers; along periodic axes where the scene repeats them.
fn particles(
    table: &FrameTable,
    numbers: &Numbers,
    radii: Option<&[f64]>,
    domain: &Domain,
) -> Result<Vec<Particle>, ImportError> {
    let places = Places::of(table);
    let position = position(table, &places)?;
    let id = places.find(Column::Id);
    let size = places.radius();
    let (velocity, spin) = (places.vector(Column::Velocity), places.vector(Column::Spin));
    let mut particles = Vec::with_capacity(table.rows().count());
    for (row, r) in table.rows().enumerate() {
        let own = id.map_or(row as i64, |place| r[place] as i64);
        let id = numbers.get(&own).copied().unwrap_or_default();
        let radius = match (size, radii) {
            (Some((place, factor)), _) => factor * r[place],
            (None, Some(radii)) => radii.get(id as usize).copied().unwrap_or_default(),
            (None, None) => return Err(table.fault(row, "a frame has no radii, where others have")),
        };
        if radius <= 0.0 {
            return Err(table.fault(row, format!("a radius of {radius} m")));
        }
        let of = |places: Option<[usize; 3]>| places.map_or([0.0; 3], |places| places.map(|place| r[place]));
        let position = image(domain, vector(r, position)).into();
        particles.push(Particle { id, position, radius, velocity: of(velocity), spin: of(spin) });
    }
    particles.sort_by_key(|particle| particle.id);
    match particles.windows(2).find(|pair| pair[0].id == pair[1].id) {
        None => Ok(particles),
        Some(_) => Err(table.fault(0, "two grains of a frame have one number")),
    }
}
