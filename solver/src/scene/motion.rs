//! Motions of walls: prescribed, controlled by a force, or driven by one.

use super::check::interval;
use super::document::{Checked, Document, DocumentPath};
use super::error::short;
use super::{Scene, Wall};
use crate::surface::is_nowhere;
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;

/// Motion of a wall: prescribed, controlled by a force, or driven by a force or a torque. A list of prescribed motions is composed in
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
        #[serde(default, skip_serializing_if = "is_nowhere")]
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
    /// Motion along an axis, with the velocity `gain (force - F)` in each step: F is the force along the axis that the wall exerted on grains
    /// in the last step.
    Servo {
        /// Direction in which the wall presses; need not be of unit length.
        axis: [f64; 3],
        /// Target force on the grains along the axis, N; or give `pressure` and `area`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        force: Option<f64>,
        /// Target pressure, Pa.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pressure: Option<f64>,
        /// Area of the pressure, m2.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        area: Option<f64>,
        /// Velocity per difference from the target, m/(N s). Steady where the product of gain, step and stiffness of the bed (N/m) is below 1.
        gain: f64,
        /// Largest velocity, m/s.
        largest_velocity: f64,
        /// Time at which it begins, s.
        #[serde(default)]
        start: f64,
    },
    /// Motion along an axis under a force, its weight and contact forces.
    ForceDriven {
        /// Direction of motion; need not be of unit length.
        axis: [f64; 3],
        /// Applied force along the axis, N.
        force: f64,
        /// Mass, kg; gravity acts on it.
        mass: f64,
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

    /// Returns true if contact forces move the wall: frames hold its position.
    pub fn is_driven(&self) -> bool {
        self.is_dynamic() || matches!(self, Motion::Servo { .. })
    }

    /// Returns true if a force or a torque drives the wall, so that its velocity is an unknown of the solve.
    pub fn is_dynamic(&self) -> bool {
        matches!(self, Motion::ForceDriven { .. } | Motion::TorqueDriven { .. })
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
            Motion::Servo { start, .. } | Motion::ForceDriven { start, .. } | Motion::TorqueDriven { start, .. } => {
                (*start, None)
            }
        }
    }

    /// Returns the target force of a servo, N.
    pub fn target(&self) -> Option<f64> {
        match self {
            Motion::Servo { force, pressure, area, .. } => force.or(pressure.zip(*area).map(|(p, a)| p * a)),
            _ => None,
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
                match content.fault() {
                    Some((problem, remedy)) => Err(motion.key("file").fault(format!("'{file}' {problem}"), remedy)),
                    None => Ok(()),
                }
            }
            Motion::Servo { axis, force, pressure, area, gain, largest_velocity, start } => {
                motion.key("axis").direction(axis)?;
                if force.is_some() == (pressure.is_some() && area.is_some()) || pressure.is_some() != area.is_some() {
                    let problem = "force, or pressure and area, must be given".into();
                    return Err(motion.fault(problem, "give force (N), or both of pressure (Pa) and area (m2)"));
                }
                motion.key("force").range(force.unwrap_or(0.0), -1e12, 1e12, "N")?;
                motion.key("pressure").range(pressure.unwrap_or(0.0), -1e12, 1e12, "Pa")?;
                motion.key("area").range(area.unwrap_or(1.0), 1e-18, 1e12, "m2")?;
                motion.key("gain").range(*gain, 1e-15, 1e15, "m/(N s)")?;
                motion.key("largest_velocity").range(*largest_velocity, 1e-12, 1e4, "m/s")?;
                interval(motion, *start, None)
            }
            Motion::ForceDriven { axis, force, mass, start } => {
                motion.key("axis").direction(axis)?;
                motion.key("force").range(*force, -1e12, 1e12, "N")?;
                motion.key("mass").range(*mass, 1e-12, 1e12, "kg")?;
                interval(motion, *start, None)
            }
            Motion::TorqueDriven { point, axis, torque, moment_of_inertia, start } => {
                motion.key("point").finite(point)?;
                motion.key("axis").direction(axis)?;
                motion.key("torque").range(*torque, -1e12, 1e12, "N m")?;
                motion.key("moment_of_inertia").range(*moment_of_inertia, 1e-15, 1e15, "kg m2")?;
                interval(motion, *start, None)
            }
            Motion::List(parts) => {
                if parts.is_empty() {
                    return Err(motion.fault("an empty list".into(), "list one motion or more, or leave it out"));
                }
                for (index, part) in parts.iter().enumerate() {
                    let at = motion.index(index);
                    if part.is_driven() || matches!(part, Motion::List(_)) {
                        let problem = "a list composes prescribed motions alone".into();
                        return Err(at.fault(problem, "use translating, rotating, vibrating or table"));
                    }
                    part.check(&at)?;
                }
                Ok(())
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
                let (path, bytes) = document.file(file);
                let fault = |problem: String, remedy: &str| {
                    at.key("file").fault(format!("'{}'{problem}", path.display()), remedy)
                };
                let bytes = bytes.map_err(|error| {
                    let remedy = "give the path of a CSV file, relative to the folder of the scene";
                    fault(format!(" cannot be read: {error}"), remedy)
                })?;
                *content = PoseTable::read(&String::from_utf8_lossy(&bytes))
                    .map_err(|(line, problem, remedy)| fault(format!(", line {line}: {problem}"), remedy))?;
                Ok(())
            }
            _ => Ok(()),
        }
    }
}

/// Rows of a table of poses: time (s), displacement (m), rotation vector (rad).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PoseTable(Vec<[f64; 7]>);

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
        Ok(PoseTable(rows))
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

impl Wall {
    /// Returns the index of the wall that carries this one, among the walls of its scene.
    pub fn parent_in(&self, walls: &[Wall]) -> Option<usize> {
        let parent = self.parent.as_ref()?;
        walls.iter().position(|wall| wall.name == *parent)
    }
}

impl Scene {
    /// Returns the motions that move a wall, by its index: its own in their order, then those of the walls that carry it.
    pub fn motions_of(&self, wall: usize) -> impl Iterator<Item = &Motion> {
        let chain = std::iter::successors(self.wall.get(wall), |wall| {
            wall.parent_in(&self.wall).map(|parent| &self.wall[parent])
        });
        // A chain without a cycle has at most all walls.
        chain.take(self.wall.len()).flat_map(|wall| wall.motion.parts())
    }
}

/// Checks the walls that carry a wall: their motions are prescribed, and none carries itself.
pub(super) fn check_parents(scene: &Scene) -> Checked {
    for (index, wall) in scene.wall.iter().enumerate() {
        let Some(parent) = &wall.parent else { continue };
        let at = DocumentPath::default().key("wall").index(index).key("parent");
        let mut next = wall.parent_in(&scene.wall);
        if next.is_none() {
            return Err(at.fault(format!("there is no wall '{parent}'"), "name another wall of the scene"));
        }
        if wall.motion.is_driven() {
            let problem = format!("a force moves wall '{}', and '{parent}' would move it too", wall.name);
            return Err(at.fault(problem, "leave parent out, or prescribe the motion of the wall"));
        }
        for _ in 0..=scene.wall.len() {
            let Some(carrier) = next else { break };
            if carrier == index {
                return Err(at.fault(format!("wall '{}' would carry itself", wall.name), "leave one parent out"));
            }
            if scene.wall[carrier].motion.is_driven() {
                let problem =
                    format!("a force moves wall '{}', so that it carries no other wall", scene.wall[carrier].name);
                return Err(at.fault(problem, "name a wall with a prescribed motion"));
            }
            next = scene.wall[carrier].parent_in(&scene.wall);
        }
    }
    Ok(())
}
