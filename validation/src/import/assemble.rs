//! From tables to a recording: times, grains by number, contacts with their partners, and what all of them lack.

use super::columns::{Column, Places};
use super::frame_table::{FrameTable, ImportError};
use super::sequence::{one_after_the_other, series};
use super::{Tables, contact_from_force, measurable, merge_wall_contacts};
use crate::plan::Scene;
use crate::recording::{Content, Recording};
use makadam::effects::period::Period;
use makadam::scene::populate;
use makadam::snapshot::{Contact, Particle, Partner, Snapshot};
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::path::Path;

/// Two times are the same if they are nearer than this part of the time between frames.
const SAME_TIME: f64 = 1e-3;

/// What is known of frames beside their files.
pub struct Assembly<'a> {
    /// The scene that was simulated.
    pub scene: &'a Scene,
    /// Name of the code.
    pub code: &'a str,
    /// Its version.
    pub version: &'a str,
    /// Seed of the initial positions: radii are those of the scene's grains where files have none.
    pub seed: u64,
    /// Time step by which frames are numbered, s.
    pub time_step: Option<f64>,
    /// Time between frames that are not numbered, s; the first is at time 0. They follow the numbers in the names of their files.
    pub interval: Option<f64>,
}

/// Frames as a recording, and what had to be assumed.
#[derive(Debug)]
pub struct Imported {
    /// The frames.
    pub recording: Recording,
    /// What a reader must know, in sentences.
    pub notes: Vec<String>,
}

/// Numbers that a code gives its grains, and ours, from 0 in their order.
type Numbers = BTreeMap<i64, u32>;

impl Assembly<'_> {
    /// Puts the frames together.
    ///
    /// # Errors
    /// [`ImportError`] with file and line.
    pub fn assemble(&self, tables: &Tables) -> Result<Imported, ImportError> {
        let mut notes = Vec::new();
        let grains = self.timed(&tables.grains, &mut notes)?;
        let Some((_, first)) = grains.first() else {
            return Err(ImportError::new(Path::new("-"), 1, "no file has a frame; give files of grains"));
        };
        let places = Places::of(first);
        position(first, &places)?;
        let has = |of: fn(usize) -> Column| grains.iter().all(|(_, table)| Places::of(table).vector(of).is_some());
        let mut lacks = vec![Content::DrivenWalls];
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
        let numbers = numbers(&grains)?;
        let radii = match places.find(Column::Radius).or(places.find(Column::Diameter)) {
            Some(_) => None,
            None => Some(self.radii(first, numbers.len(), &mut notes)?),
        };
        let mut contacts = self.contacts(&tables.contacts, &grains, &mut notes)?;
        let mut frames = Vec::with_capacity(grains.len());
        for (place, (time, table)) in grains.iter().enumerate() {
            let particles = particles(table, &numbers, radii.as_deref())?;
            let mut list = Vec::new();
            for of_frame in std::mem::take(&mut contacts[place]) {
                self.add_contacts(of_frame, &particles, &numbers, &mut list)?;
            }
            let snapshot =
                Snapshot { time: *time, particles, contacts: merge_wall_contacts(list), ..Snapshot::default() };
            frames.push(measurable(snapshot).map_err(|problem| table.fault(0, problem))?);
        }
        let simulated_seconds = frames.last().map_or(0.0, |frame| frame.time);
        let recording = Recording {
            scene: self.scene.name.clone(),
            code: self.code.into(),
            version: self.version.into(),
            seed: self.seed,
            time_step: self.time_step.unwrap_or(self.scene.measure.interval),
            rayleigh_fraction: None,
            stiffness_factor: 1.0,
            threads: 1,
            wall_seconds: 0.0,
            core_seconds: None,
            simulated_seconds,
            frames,
            lacks,
            alarms: Vec::new(),
        };
        Ok(Imported { recording, notes })
    }

    /// Time of a frame, s: what it tells itself, that of its step, or that of its place among the others.
    fn time_of(&self, table: &FrameTable, place: usize) -> Option<f64> {
        let stepped = || Some(table.step? as f64 * self.time_step?);
        table.time.or_else(stepped).or_else(|| Some(place as f64 * self.interval?))
    }

    /// Whether some of these frames get their times by their place among the others.
    fn counts(&self, tables: &[FrameTable]) -> bool {
        let untold = |table: &FrameTable| table.time.is_none() && (table.step.is_none() || self.time_step.is_none());
        self.interval.is_some() && tables.iter().any(untold)
    }

    /// Frames with their times, in the order of time.
    fn timed<'t>(
        &self,
        tables: &'t [FrameTable],
        notes: &mut Vec<String>,
    ) -> Result<Vec<(f64, &'t FrameTable)>, ImportError> {
        let mut timed = Vec::with_capacity(tables.len());
        let ordered = if self.counts(tables) { one_after_the_other(tables)? } else { tables.iter().collect() };
        for (place, table) in ordered.into_iter().enumerate() {
            let time = match self.time_of(table, place) {
                Some(time) => time,
                None if tables.len() == 1 => {
                    notes.push(format!(
                        "the frame tells no time: it is taken as the end of the run, {} s",
                        self.scene.duration
                    ));
                    self.scene.duration
                }
                None => {
                    let remedy = "give --time-step where frames or files are numbered by steps, else --interval, the time between them";
                    return Err(table.fault(0, format!("the frame tells no time; {remedy}")));
                }
            };
            timed.push((time, table));
        }
        timed.sort_by(|a, b| a.0.total_cmp(&b.0));
        let all = timed.len();
        timed.dedup_by(|later, earlier| later.0 == earlier.0);
        if timed.len() < all {
            notes.push(format!(
                "{} frames have the time of another one: the first of each is measured",
                all - timed.len()
            ));
        }
        Ok(timed)
    }

    /// The tables of contacts of each frame.
    fn contacts<'t>(
        &self,
        tables: &'t [FrameTable],
        grains: &[(f64, &FrameTable)],
        notes: &mut Vec<String>,
    ) -> Result<Vec<Vec<&'t FrameTable>>, ImportError> {
        let mut found = vec![Vec::new(); grains.len()];
        if tables.is_empty() {
            return Ok(found);
        }
        let mut apart = f64::INFINITY;
        grains.windows(2).for_each(|pair| apart = apart.min(pair[1].0 - pair[0].0));
        let single = grains.len() == 1 && tables.iter().all(|table| table.time.is_none());
        let mut strangers = 0;
        // Each kind of contacts has frames of the same times, in an order of its own.
        for of_kind in series(tables, self.counts(tables))? {
            for (place, table) in of_kind.into_iter().enumerate() {
                let time = self.time_of(table, place);
                let near =
                    |time: f64| grains.iter().position(|(own, _)| (own - time).abs() <= SAME_TIME * apart.min(1.0));
                match if single { Some(0) } else { time.and_then(near) } {
                    Some(place) if !found[place].iter().any(|known: &&FrameTable| known.file == table.file) => {
                        found[place].push(table);
                    }
                    Some(_) => {}
                    None => strangers += 1,
                }
            }
        }
        if strangers > 0 {
            notes.push(format!(
                "{strangers} frames of contacts have no frame of grains at their time: they are not measured"
            ));
        }
        let empty = found.iter().filter(|tables| tables.is_empty()).count();
        // A table with a column of times has no rows where there are no contacts; other files have a frame then.
        let by_rows = tables.iter().all(|table| table.time.is_some() && table.step.is_none());
        if by_rows && empty > 0 {
            notes.push(format!("{empty} of {} frames have no contacts in the files", found.len()));
        }
        match found.iter().position(Vec::is_empty) {
            None => Ok(found),
            Some(_) if by_rows => Ok(found),
            Some(place) => {
                let (time, table) = grains[place];
                Err(table.fault(
                    0,
                    format!("no contacts are given for this frame, at {time} s; give those of all frames, or of none"),
                ))
            }
        }
    }

    /// Radii of the scene's grains, m.
    fn radii(&self, table: &FrameTable, count: usize, notes: &mut Vec<String>) -> Result<Vec<f64>, ImportError> {
        let columns = Places::of(table).names();
        let missing = format!("there is no column radius or diameter among {columns}");
        let grains = populate(self.scene, self.seed).map_err(|error| table.fault(0, format!("{missing}; {error}")))?;
        if grains.len() != count {
            let problem = format!(
                "{missing}, and the scene has {} grains, not {count}: name a column with --columns",
                grains.len()
            );
            return Err(table.fault(0, problem));
        }
        notes.push(format!(
            "radii are those of the scene's grains with seed {}, in the order of their numbers",
            self.seed
        ));
        Ok(grains.iter().map(|grain| grain.radius).collect())
    }

    fn add_contacts(
        &self,
        table: &FrameTable,
        particles: &[Particle],
        numbers: &Numbers,
        to: &mut Vec<Contact>,
    ) -> Result<(), ImportError> {
        let places = Places::of(table);
        let missing = |what: &str| {
            table
                .fault(0, format!("no column {what} among {}; name the columns with --contact-columns", places.names()))
        };
        let first =
            places.find(Column::First).or(places.find(Column::Id)).ok_or_else(|| missing("first (the first grain)"))?;
        let (second, wall) = (places.find(Column::Second), places.find(Column::Wall));
        if second.is_none() && wall.is_none() {
            return Err(missing("second (the second grain) or wall"));
        }
        let point = places.vector(Column::Point).or(places.vector(Column::Position));
        let forces =
            match (places.vector(Column::Force), places.find(Column::NormalForce), places.vector(Column::Tangential)) {
                (Some(force), ..) => Forces::OnFirst(force),
                (None, Some(normal), Some(tangential)) => Forces::Split(normal, tangential),
                _ => {
                    return Err(missing(
                        "fx, fy, fz (force on the first grain), or normal_force and tangential_force_x, _y, _z",
                    ));
                }
            };
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
            let partner = match (named(second), named(wall)) {
                (Some(place), None) => Partner::Grain(grain(place)?.id),
                (None, Some(place)) => {
                    let number = numbers_of_row[place];
                    if number.fract() != 0.0 || number >= self.scene.wall.len() as f64 {
                        return Err(fault(format!(
                            "there is no wall {number}: the scene has {}, from 0",
                            self.scene.wall.len()
                        )));
                    }
                    Partner::Wall(number as u32)
                }
                _ => {
                    return Err(fault(
                        "a contact has either a second grain or a wall; the other number is negative".into(),
                    ));
                }
            };
            let given = normal.map(|places| vector(numbers_of_row, places));
            let (point, towards) =
                geometry(a, partner, particles, point.map(|places| vector(numbers_of_row, places)), period)
                    .ok_or_else(|| fault("a contact with a wall needs its point: px, py, pz".into()))?;
            let Some(towards) = given.unwrap_or(towards).try_normalize(0.0) else { continue };
            match forces {
                Forces::OnFirst(force) => {
                    to.extend(contact_from_force(a.id, partner, point.into(), towards, vector(numbers_of_row, force)));
                }
                Forces::Split(normal_force, tangential) => to.push(Contact {
                    first: a.id,
                    second: partner,
                    point: point.into(),
                    normal: towards.into(),
                    normal_force: numbers_of_row[normal_force],
                    tangential_force: vector(numbers_of_row, tangential).into(),
                }),
            }
        }
        Ok(())
    }
}

/// How a table tells forces.
#[derive(Clone, Copy)]
enum Forces {
    /// The whole force on the first grain.
    OnFirst([usize; 3]),
    /// The normal force, and the tangential force on the partner.
    Split(usize, [usize; 3]),
}

/// The contact point and the way from the first grain to its partner; none where a wall's point is not known.
fn geometry(
    first: &Particle,
    partner: Partner,
    particles: &[Particle],
    point: Option<Vector3<f64>>,
    period: Period,
) -> Option<(Vector3<f64>, Vector3<f64>)> {
    let centre = Vector3::from(first.position);
    match partner {
        Partner::Wall(_) => point.map(|point| (point, period.arm(&centre, &point))),
        Partner::Grain(id) => {
            let place = particles.binary_search_by_key(&id, |particle| particle.id).ok()?;
            let second = &particles[place];
            let towards = period.arm(&centre, &second.position.into());
            let between = centre + towards * (first.radius / (first.radius + second.radius));
            Some((point.unwrap_or(between), towards))
        }
    }
}

fn vector(row: &[f64], [x, y, z]: [usize; 3]) -> Vector3<f64> {
    Vector3::new(row[x], row[y], row[z])
}

/// Numbers of the grains of all frames.
fn numbers(grains: &[(f64, &FrameTable)]) -> Result<Numbers, ImportError> {
    let mut all = Numbers::new();
    for (_, table) in grains {
        match Places::of(table).find(Column::Id) {
            Some(place) => {
                for (row, numbers) in table.rows().enumerate() {
                    let own = numbers[place];
                    if own.fract() != 0.0 || own.abs() > 1e15 {
                        return Err(table.fault(row, format!("{own} is no number of a grain")));
                    }
                    all.insert(own as i64, 0);
                }
            }
            None => all.extend((0..table.rows().count() as i64).map(|row| (row, 0))),
        }
    }
    all.values_mut().zip(0..).for_each(|(number, rank)| *number = rank);
    Ok(all)
}

/// Where the coordinates stand.
fn position(table: &FrameTable, places: &Places<'_>) -> Result<[usize; 3], ImportError> {
    let scaled = table.columns.iter().any(|name| ["xs", "xsu"].contains(&name.as_str()));
    places.vector(Column::Position).ok_or_else(|| {
        let hint = match scaled {
            true => "coordinates are scaled to the box: dump x y z instead",
            false => "name the columns with --columns",
        };
        table.fault(0, format!("no columns x, y, z among {}; {hint}", places.names()))
    })
}

/// The grains of a frame, in the order of their numbers.
fn particles(table: &FrameTable, numbers: &Numbers, radii: Option<&[f64]>) -> Result<Vec<Particle>, ImportError> {
    let places = Places::of(table);
    let position = position(table, &places)?;
    let id = places.find(Column::Id);
    let size = match (places.find(Column::Radius), places.find(Column::Diameter)) {
        (Some(place), _) => Some((place, 1.0)),
        (None, Some(place)) => Some((place, 0.5)),
        (None, None) => None,
    };
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
        particles.push(Particle { id, position: of(Some(position)), radius, velocity: of(velocity), spin: of(spin) });
    }
    particles.sort_by_key(|particle| particle.id);
    match particles.windows(2).find(|pair| pair[0].id == pair[1].id) {
        None => Ok(particles),
        Some(_) => Err(table.fault(0, "two grains of a frame have one number")),
    }
}
