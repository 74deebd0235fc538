//! Motions of walls: prescribed, or driven by a force or a torque.

use super::check::interval;
use super::document::{Checked, Document, DocumentPath};
use super::error::short;
use super::{Scene, Wall};
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

/// Motion of a wall: prescribed, or driven by a force or a torque. A list of prescribed motions is composed in
/// its order: the first acts on the wall first, and each later one carries it along. Points and axes are those of the scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields, remote = "Self")]
pub enum Motion {
    /// At rest.
    #[default]
    Fixed,
    /// Constant velocity between two times.
    Translating {
        /// Velocity, m/s.
        velocity: [f64; 3],
        /// Time at which it begins, s.
        #[serde(default)]
        start: f64,
        /// Time at which it ends, s; default: never.
        stop: Option<f64>,
    },
    /// Constant rotation about an axis between two times.
    Rotating {
        /// A point of the axis, metres.
        point: [f64; 3],
        /// Direction of the axis; need not be of unit length.
        axis: [f64; 3],
        /// Angular velocity about the axis by the right-hand rule, rad/s.
        rate: f64,
        /// Time at which it begins, s.
        #[serde(default)]
        start: f64,
        /// Time at which it ends, s; default: never.
        stop: Option<f64>,
        /// Time of reversal to the opposite rate, s; default: never.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        reverse: Option<f64>,
    },
    /// Sinusoidal motion about the initial position, between two times.
    Vibrating {
        /// Largest displacement, m.
        amplitude: [f64; 3],
        /// Frequency, Hz.
        frequency: f64,
        /// Time at which it begins, s.
        #[serde(default)]
        start: f64,
        /// Time at which it ends and the wall stops, s; default: never.
        stop: Option<f64>,
    },
    /// Poses over time from a CSV file, with constant velocity and angular velocity between two rows; at rest before the first and after the last.
    Table {
        /// File, relative to the folder of the scene's file. Its first line names the columns: time (s), and any of x, y, z, the displacement (m), and
        /// rx, ry, rz, the rotation vector (rad).
        file: String,
        /// Point about which it rotates, in the scene, metres.
        #[serde(default, skip_serializing_if = "crate::is_default")]
        point: [f64; 3],
        /// Time of the scene at time zero of the table, s.
        #[serde(default)]
        start: f64,
        /// Time at which it ends, s; default: never.
        stop: Option<f64>,
        /// Rows of the file. Scenes that Makadam writes have this key, so that they are complete without the file.
        #[serde(default)]
        content: PoseTable,
    },
    /// Motion along an axis under a force, its weight and contact forces.
    ForceDriven {
        /// Direction of motion; need not be of unit length.
        axis: [f64; 3],
        /// Applied force along the axis, N.
        force: f64,
        /// Mass, kg; gravity acts on it.
        mass: f64,
        /// Largest speed, m/s, as that of a press; default: none.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        largest_speed: Option<f64>,
        /// Time of release, s; fixed until then.
        #[serde(default)]
        start: f64,
    },
    /// Rotation about an axis under a torque and contact forces.
    TorqueDriven {
        /// A point of the axis, metres.
        point: [f64; 3],
        /// Direction of the axis; need not be of unit length.
        axis: [f64; 3],
        /// Applied torque about the axis by the right-hand rule, N m.
        torque: f64,
        /// Moment of inertia about the axis, kg m2.
        moment_of_inertia: f64,
        /// Largest angular speed, rad/s; default: none.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        largest_speed: Option<f64>,
        /// Time of release, s; fixed until then.
        #[serde(default)]
        start: f64,
    },
    /// Prescribed motions, composed in their order.
    #[serde(skip)]
    List(Vec<Motion>),
}

impl Serialize for Motion {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Motion::List(parts) => parts.serialize(serializer),
            one => Motion::serialize(one, serializer),
        }
    }
}

impl<'de> Deserialize<'de> for Motion {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Motion, D::Error> {
        struct TableOrList;
        impl<'de> Visitor<'de> for TableOrList {
            type Value = Motion;
            fn expecting(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
                out.write_str("a table with a kind, or a list of such tables")
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Motion, A::Error> {
                Motion::deserialize(MapAccessDeserializer::new(map))
            }
            fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Motion, A::Error> {
                Vec::deserialize(SeqAccessDeserializer::new(list)).map(Motion::List)
            }
        }
        deserializer.deserialize_any(TableOrList)
    }
}

impl Motion {
    /// Returns the motions of a list in their order, or the motion itself.
    pub fn parts(&self) -> &[Motion] {
        match self {
            Motion::List(parts) => parts,
            one => std::slice::from_ref(one),
        }
    }

    /// Returns the parts with their paths in the document, given that of the motion.
    pub(super) fn parts_at(&self, at: &DocumentPath) -> impl Iterator<Item = (DocumentPath, &Motion)> {
        let of = |index: usize| if matches!(self, Motion::List(_)) { at.index(index) } else { at.clone() };
        self.parts().iter().enumerate().map(move |(index, part)| (of(index), part))
    }

    /// Returns true if a force or a torque drives the wall.
    pub fn is_driven(&self) -> bool {
        matches!(self, Motion::ForceDriven { .. } | Motion::TorqueDriven { .. })
    }

    /// Returns a point (m) and the direction of the axis of a rotation; `None` for other motions.
    pub fn axis(&self) -> Option<([f64; 3], [f64; 3])> {
        match self {
            Motion::Rotating { point, axis, .. } | Motion::TorqueDriven { point, axis, .. } => Some((*point, *axis)),
            _ => None,
        }
    }

    /// Returns the times at which a prescribed or driven motion begins and ends, s.
    pub fn span(&self) -> (f64, Option<f64>) {
        match self {
            Motion::Fixed | Motion::List(_) => (0.0, None),
            Motion::Translating { start, stop, .. }
            | Motion::Rotating { start, stop, .. }
            | Motion::Vibrating { start, stop, .. } => (*start, *stop),
            Motion::Table { start, stop, content, .. } => {
                let [first, last] = content.ends().map(|time| start + time);
                (first, Some(stop.map_or(last, |stop| stop.min(last))))
            }
            Motion::ForceDriven { start, .. } | Motion::TorqueDriven { start, .. } => (*start, None),
        }
    }

    /// Checks the values of a motion.
    pub(super) fn check(&self, motion: &DocumentPath) -> Checked {
        match self {
            Motion::Fixed => Ok(()),
            Motion::Translating { velocity, start, stop } => {
                motion.key("velocity").finite(velocity)?;
                interval(motion, *start, *stop)
            }
            Motion::Rotating { point, axis, rate, start, stop, reverse } => {
                motion.key("point").finite(point)?;
                motion.key("axis").direction(axis)?;
                motion.key("rate").range(*rate, -1e5, 1e5, "rad/s")?;
                interval(motion, *start, *stop)?;
                motion.key("reverse").range(reverse.unwrap_or(*start), *start, 1e6, "s")
            }
            Motion::Vibrating { amplitude, frequency, start, stop } => {
                motion.key("amplitude").finite(amplitude)?;
                motion.key("frequency").range(*frequency, 0.0, 1e6, "Hz")?;
                interval(motion, *start, *stop)
            }
            Motion::Table { file, point, start, stop, content } => {
                motion.key("point").finite(point)?;
                interval(motion, *start, *stop)?;
                let (problem, remedy) = content.fault().unwrap_or_default();
                motion.key("file").require(problem.is_empty(), || format!("'{file}' {problem}"), remedy)
            }
            Motion::ForceDriven { axis, force, mass, largest_speed, start } => {
                motion.key("largest_speed").range(largest_speed.unwrap_or(1.0), 1e-12, 1e4, "m/s")?;
                motion.key("axis").direction(axis)?;
                motion.key("force").range(*force, -1e12, 1e12, "N")?;
                motion.key("mass").range(*mass, 1e-12, 1e12, "kg")?;
                interval(motion, *start, None)
            }
            Motion::TorqueDriven { point, axis, torque, moment_of_inertia, largest_speed, start } => {
                motion.key("largest_speed").range(largest_speed.unwrap_or(1.0), 1e-12, 1e5, "rad/s")?;
                motion.key("point").finite(point)?;
                motion.key("axis").direction(axis)?;
                motion.key("torque").range(*torque, -1e12, 1e12, "N m")?;
                motion.key("moment_of_inertia").range(*moment_of_inertia, 1e-15, 1e15, "kg m2")?;
                interval(motion, *start, None)
            }
            Motion::List(parts) => {
                let problem = || "an empty list".into();
                motion.require(!parts.is_empty(), problem, "list one motion or more, or leave it out")?;
                parts.iter().enumerate().try_for_each(|(index, part)| {
                    let fits = !part.is_driven() && !matches!(part, Motion::List(_));
                    let problem = || "a list composes prescribed motions alone".into();
                    motion.index(index).require(fits, problem, "use translating, rotating, vibrating or table")?;
                    part.check(&motion.index(index))
                })
            }
        }
    }

    /// Reads the files of tables, unless the motion holds their rows.
    pub(super) fn read_tables(&mut self, at: &DocumentPath, document: &Document<'_>) -> Checked {
        match self {
            Motion::List(parts) => {
                (0..).zip(parts).try_for_each(|(index, part)| part.read_tables(&at.index(index), document))
            }
            Motion::Table { file, content, .. } if content.0.is_empty() => {
                let at = at.key("file");
                let (path, bytes) = document.file(file, "a CSV", &at)?;
                *content = PoseTable::read(&String::from_utf8_lossy(&bytes))
                    .map_err(|(line, problem, remedy)| at.fault(format!("'{path}', line {line}: {problem}"), remedy))?;
                Ok(())
            }
            _ => Ok(()),
        }
    }
}

/// Rows of a table of poses: time (s), displacement (m), rotation vector (rad).
// Copies of a motion share the rows.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PoseTable(#[cfg_attr(feature = "schema", schemars(with = "Vec<[f64; 7]>"))] Arc<[[f64; 7]]>);

impl<'de> Deserialize<'de> for PoseTable {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<PoseTable, D::Error> {
        Vec::deserialize(deserializer).map(|rows| PoseTable(rows.into()))
    }
}

impl Serialize for PoseTable {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.serialize(serializer)
    }
}

/// Columns of a table of poses.
const COLUMNS: [&str; 7] = ["time", "x", "y", "z", "rx", "ry", "rz"];

impl PoseTable {
    /// Reads the text of a CSV file.
    fn read(text: &str) -> Result<PoseTable, (usize, String, &'static str)> {
        let mut lines =
            (1..).zip(text.trim_start_matches('\u{feff}').lines()).filter(|(_, line)| !line.trim().is_empty());
        let names = "name the columns time and any of x, y, z, rx, ry, rz, each once";
        let (_, header) = lines.next().ok_or((1, "no columns".into(), names))?;
        let mut places = Vec::new();
        for name in header.split(',').map(str::trim) {
            match COLUMNS.iter().position(|column| *column == name).filter(|place| !places.contains(place)) {
                Some(place) => places.push(place),
                None => return Err((1, format!("'{name}' is no column of poses, or given twice"), names)),
            }
        }
        if !places.contains(&0) || places.len() < 2 {
            return Err((1, "a column is missing".into(), names));
        }
        let mut rows: Vec<[f64; 7]> = Vec::new();
        for (line, text) in lines {
            let values: Vec<&str> = text.split(',').map(str::trim).collect();
            if values.len() != places.len() {
                let problem = format!("{} values where the first line names {}", values.len(), places.len());
                return Err((line, problem, "give one value for each column"));
            }
            let mut row = [0.0; 7];
            for (place, value) in places.iter().zip(values) {
                row[*place] =
                    value.parse().map_err(|_| (line, format!("'{value}' is not a number"), "give SI numbers"))?;
            }
            rows.push(row);
            if let Some((problem, remedy)) = fault_of_last(&rows) {
                return Err((line, problem, remedy));
            }
        }
        Ok(PoseTable(rows.into()))
    }

    /// Returns the rows.
    pub(crate) fn rows(&self) -> &[[f64; 7]] {
        &self.0
    }

    /// Returns true if the table has a rotation.
    pub(super) fn turns(&self) -> bool {
        self.0.iter().any(|row| row[4..] != [0.0; 3])
    }

    /// Returns the speed (m/s) and the largest angular velocity (rad/s) between any two rows.
    pub(super) fn speeds(&self) -> impl Iterator<Item = [f64; 2]> {
        let change = |rows: &[[f64; 7]], columns: [usize; 3]| {
            columns.map(|axis| (rows[1][axis] - rows[0][axis]).powi(2)).iter().sum::<f64>().sqrt()
                / (rows[1][0] - rows[0][0])
        };
        self.0.windows(2).map(move |rows| [change(rows, [1, 2, 3]), change(rows, [4, 5, 6])])
    }

    /// Returns the first and the last time, s.
    fn ends(&self) -> [f64; 2] {
        [self.0.first(), self.0.last()].map(|row| row.map_or(0.0, |row| row[0]))
    }

    /// Returns a problem of the rows, and its remedy.
    fn fault(&self) -> Option<(String, &'static str)> {
        if self.0.len() < 2 {
            return Some((format!("has {} rows", self.0.len()), "give two rows or more"));
        }
        (1..=self.0.len()).find_map(|rows| fault_of_last(&self.0[..rows]))
    }
}

/// Returns a problem of the last of these rows.
fn fault_of_last(rows: &[[f64; 7]]) -> Option<(String, &'static str)> {
    let (last, before) = rows.split_last()?;
    if last.iter().any(|value| value.is_nan() || value.abs() >= 1e6) {
        return Some((format!("{last:?} has a value beyond 1e6"), "give finite SI numbers below 1e6"));
    }
    let Some(before) = before.last() else {
        let away = last[1..].iter().any(|value| *value != 0.0) || last[0] < 0.0;
        return away.then(|| {
            let problem = "the first pose is not that of the scene, or its time is below 0".into();
            (problem, "give poses relative to that in the scene: zeros in the first row")
        });
    };
    if last[0] <= before[0] {
        let problem =
            format!("time {} s is not after {} s, the time of the row before", short(last[0]), short(before[0]));
        return Some((problem, "list the rows in the order of their times"));
    }
    let turn = (4..7).map(|axis| (last[axis] - before[axis]).powi(2)).sum::<f64>().sqrt();
    (turn >= std::f64::consts::PI).then(|| {
        let problem = format!("the rotation changes by {} rad from the row before, half a turn or more", short(turn));
        (problem, "give more rows")
    })
}

impl Scene {
    /// Returns the motion of a wall by its index: its own, followed by those of the walls that carry it.
    pub fn course(&self, wall: usize) -> Motion {
        course(&self.wall, wall)
    }
}

/// Returns the motion of a wall among the walls of its scene, as [`Scene::course`] does.
pub(crate) fn course(walls: &[Wall], wall: usize) -> Motion {
    let moving = |wall: &Wall| wall.motion.parts().iter().filter(|part| **part != Motion::Fixed).cloned().collect();
    let mut parts: Vec<Motion> = carriers(walls, wall).flat_map(|wall| -> Vec<Motion> { moving(wall) }).collect();
    match parts.len() {
        0 => Motion::Fixed,
        1 => parts.remove(0),
        _ => Motion::List(parts),
    }
}

/// Returns a wall and those that carry it, from the inside out; of a cycle, each wall once or more.
fn carriers(walls: &[Wall], wall: usize) -> impl Iterator<Item = &Wall> {
    let parent = |wall: &&Wall| wall.parent.as_ref().and_then(|parent| walls.iter().find(|one| one.name == *parent));
    std::iter::successors(walls.get(wall), parent).take(walls.len() + 1)
}

/// Checks the walls that carry others: they exist, no force moves a wall of the chain, and none carries itself.
pub(super) fn check_parents(scene: &Scene) -> Checked {
    for (index, wall) in scene.wall.iter().enumerate() {
        let Some(parent) = &wall.parent else { continue };
        let at = DocumentPath::default().key("wall").index(index).key("parent");
        let is_known = scene.wall.iter().any(|one| one.name == *parent);
        at.require(is_known, || format!("there is no wall '{parent}'"), "name another wall of the scene")?;
        let chain: Vec<&Wall> = carriers(&scene.wall, index).collect();
        let ends = chain.len() <= scene.wall.len();
        at.require(ends, || format!("wall '{}' would carry itself", wall.name), "leave one parent out")?;
        let driven = chain.iter().find(|wall| wall.motion.is_driven()).map(|wall| &wall.name);
        let problem = || format!("a force or a torque moves wall '{}'", driven.map_or("", |name| name));
        at.require(driven.is_none(), problem, "leave parent out, or prescribe the motion of this wall")?;
    }
    Ok(())
}

/// Checks the motions of a stage: times and points of walls that move together count from the same stage.
pub(super) fn check_parents_in_stage(scene: &Scene, at: &DocumentPath, given: &BTreeMap<String, Motion>) -> Checked {
    let is_given = |wall: &&Wall| given.contains_key(&wall.name);
    for index in 0..scene.wall.len() {
        let chain: Vec<&Wall> = carriers(&scene.wall, index).collect();
        let (given, other) = (chain.iter().find(|wall| is_given(wall)), chain.iter().find(|wall| !is_given(wall)));
        let Some((one, other)) = given.zip(other) else { continue };
        let problem = format!("wall '{}' moves together with '{}', which has no motion here", one.name, other.name);
        return Err(at.name(&one.name).fault(problem, "give each of them its motion in this stage"));
    }
    Ok(())
}
