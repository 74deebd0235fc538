//! Payload of a page: a head with the offsets of all arrays, and the arrays.
//!
//! ```text
//! bytes of the head (u32), head (JSON), padding to 8 bytes, arrays (little endian), each from a multiple of 8 on
//! state     frames x grains x 4 u16   x, y, z over the box of all frames, and the first field over its range
//! others    frames x grains x u16     further fields that change
//! once      grains x u16              fields that do not; for each frame if grains come and go
//! radii     grains x f32              m; for each frame if grains come and go
//! contacts  frames x n x 7 u16        both ends over the box, force over the largest of the frame
//! walls     n x 3 f32                 corners of triangles, and ends of edges, m; once if walls rest
//! ```

use crate::draw::numbers::plural;
use crate::pictures::{
    MOST_KINDS, PALETTE, Scale, Subject, VIRIDIS, is_stone, kind_name, sizes, telling, ticks, wall_edges,
};
use makadam_frames::run_frames::{ContactLine, Quantity, RunFolderError, RunFrame, RunFrames, Walls};
use serde_json::{Value, json};
use std::collections::{BTreeSet, HashSet};

/// Largest number of 16 bits.
const FULL: f64 = 65_535.0;

/// Fraction of the contacts with forces beyond the end of the scale.
const STRONGEST: f64 = 0.005;

/// Playback rate, frames per second.
const RATE: f64 = 20.0;

/// Fields constant over time.
const CONSTANT: [&str; 4] = ["diameter", "mass", "material", "population"];

/// Options of a page.
#[derive(Clone, Debug)]
pub struct Wishes {
    /// Time-dependent fields for colouring grains, the first one selected initially.
    pub fields: Vec<String>,
    /// Interval of the shown frames; if absent, the smallest that fits.
    pub every: Option<usize>,
    /// Size limit of the payload before compression, bytes.
    pub most_bytes: f64,
    /// True if force chains are shown.
    pub contacts: bool,
    /// True if the initial view shows all grains, also those far from the walls.
    pub all_grains: bool,
}

/// Additional fields on the page, if none are requested.
const BESIDE: [&str; 2] = ["speed", "pressure"];

/// Returns the fields for colouring grains: the requested ones, or the most informative ones. None is listed twice.
pub fn fields_of(frame: &RunFrame, requested: Option<&[String]>) -> Vec<String> {
    let mut fields = requested.map_or_else(|| vec![telling(frame).to_string()], <[String]>::to_vec);
    if requested.is_none() {
        let known = frame.quantities();
        let beside = BESIDE.iter().filter(|name| known.iter().any(|known| known == *name));
        fields.extend(beside.map(|name| (*name).to_string()));
    }
    let mut seen = HashSet::new();
    fields.retain(|name| seen.insert(name.replace('-', "_")));
    fields
}

/// Bytes of a page.
#[derive(Clone, Debug)]
pub struct Payload {
    /// Head and arrays.
    pub bytes: Vec<u8>,
    /// Number of frames.
    pub frames: usize,
    /// Note on omitted content; empty if complete.
    pub note: String,
}

/// Arrays after the head.
#[derive(Default)]
struct Arrays {
    bytes: Vec<u8>,
}

impl Arrays {
    /// Adds numbers; returns their offset and count.
    fn add<const SIZE: usize>(&mut self, numbers: impl Iterator<Item = [u8; SIZE]>) -> Value {
        self.bytes.resize(self.bytes.len().next_multiple_of(8), 0);
        let offset = self.bytes.len();
        self.bytes.extend(numbers.flatten());
        json!([offset, (self.bytes.len() - offset) / SIZE])
    }

    fn shorts(&mut self, numbers: impl Iterator<Item = u16>) -> Value {
        self.add(numbers.map(u16::to_le_bytes))
    }

    fn floats(&mut self, numbers: impl Iterator<Item = f64>) -> Value {
        self.add(numbers.map(|number| (number as f32).to_le_bytes()))
    }
}

/// Ranges over all frames.
#[derive(Clone, Debug)]
struct Survey {
    low: [f64; 3],
    span: [f64; 3],
    /// Smallest and largest value of each time-dependent field.
    ranges: Vec<[f64; 2]>,
    /// Values of some frames, for the ends of the colour scale.
    samples: Vec<Vec<f64>>,
    grains: usize,
    /// True if grains come and go, so that fields of single grains differ from frame to frame.
    changes: bool,
    /// Distinct values of the constant fields in all frames, at most [`MOST_DISTINCT`], with the smallest and the largest; as bits.
    distinct: Vec<BTreeSet<u64>>,
}

/// Largest number of values from which the colours of a constant field are chosen.
const MOST_DISTINCT: usize = 4096;

/// Field constant over time, with its colours.
struct Constant {
    name: String,
    values: Vec<f64>,
    range: [f64; 2],
    scale: Scale,
}

impl Constant {
    /// Returns the positions of values in the scale.
    fn shares(&self, values: &[f64]) -> impl Iterator<Item = u16> {
        values.iter().map(|value| match &self.scale {
            Scale::Kinds(kinds) => kinds.iter().position(|kind| *kind == *value as i64).unwrap_or(0) as u16,
            Scale::Range(_) => share(*value, self.range),
        })
    }
}

/// Reads the frames of a run and assembles their shown content. `progress` receives the fraction done.
///
/// # Errors
/// [`RunFolderError`] if a frame cannot be read or has none of the fields.
pub fn payload(run: &RunFrames, wishes: &Wishes, progress: &dyn Fn(f64)) -> Result<Payload, RunFolderError> {
    let last = run.read(run.count() - 1)?;
    let asked: Vec<String> = wishes.fields.iter().map(|name| name.replace('-', "_")).collect();
    asked.iter().try_for_each(|field| run.field(&last, field).map(|_| ()))?;
    // Constant fields are always included.
    let fields: Vec<String> = asked.iter().filter(|name| !CONSTANT.contains(&name.as_str())).cloned().collect();
    let (numbers, contacts, note) = choose(run, &last, wishes, fields.len());
    let survey = survey((run, &last), &numbers, &fields, contacts, &|share| progress(0.5 * share))?;
    let constants = survey.constants(&last);
    let mut arrays = Arrays::default();
    let mut frames = Vec::new();
    let mut walls: Vec<Value> = Vec::new();
    let mut seen: Option<Walls> = None;
    for (place, &number) in numbers.iter().enumerate() {
        let frame = run.read(number)?;
        let quantities: Vec<Quantity> =
            fields.iter().map(|field| run.field(&frame, field)).collect::<Result<_, _>>()?;
        let first = quantities.first();
        let state = frame.grains.positions.iter().enumerate().flat_map(|(grain, position)| {
            let value = first.map_or(0, |quantity| share(quantity.values[grain], survey.ranges[0]));
            let [x, y, z] = survey.place(position);
            [x, y, z, value]
        });
        let state = arrays.shorts(state);
        let others: Vec<Value> = (quantities.iter().zip(&survey.ranges).skip(1))
            .map(|(quantity, range)| arrays.shorts(quantity.values.iter().map(|value| share(*value, *range))))
            .collect();
        let shown = match &frame.walls {
            None => Value::Null,
            Some(here) => {
                if seen.as_ref() != Some(here) {
                    walls.push(surfaces(here, &mut arrays));
                    seen = Some(here.clone());
                }
                json!(walls.len() - 1)
            }
        };
        let lines = frame.contacts.as_ref().filter(|_| contacts).map(|lines| {
            let most_force = strongest(lines);
            arrays.shorts(strong(lines).flat_map(|line| {
                let [[a, b, c], [d, e, f]] = line.ends.map(|end| survey.place(&end));
                [a, b, c, d, e, f, share(line.normal_force, [0.0, most_force])]
            }))
        });
        let mut listed = json!({ "time": frame.time, "stage": frame.stage, "state": state, "others": others, "walls": shown, "contacts": lines });
        if survey.changes {
            listed["radii"] = arrays.floats(frame.grains.radii.iter().copied());
            let once = constants.iter().map(|constant| match frame.quantity(&constant.name) {
                Some(quantity) => arrays.shorts(constant.shares(&quantity.values)),
                None => Value::Null,
            });
            listed["once"] = once.collect();
        }
        frames.push(listed);
        progress(0.5 + 0.5 * (place + 1) as f64 / numbers.len() as f64);
    }
    let radii = arrays.floats(last.grains.radii.iter().copied());
    let mut listed: Vec<Value> = Vec::new();
    for (number, name) in fields.iter().enumerate() {
        let quantity = run.field(&last, name)?;
        listed.push(field(&quantity, &survey.samples[number], survey.ranges[number], json!({ "number": number })));
    }
    for (number, constant) in constants.iter().enumerate() {
        let Some(quantity) = last.quantity(&constant.name) else { continue };
        let once = arrays.shorts(constant.shares(&quantity.values));
        listed.push(field(&quantity, &constant.values, constant.range, json!({ "once": once, "constant": number })));
    }
    let chosen = asked.first().map(|name| name.replace('_', " "));
    let chosen = listed.iter().position(|field| field["title"].as_str() == chosen.as_deref()).unwrap_or(0);
    let head = json!({
        "chosen": chosen,
        "scene": run.scene(),
        "about": format!("{}; {}", sizes(&last), plural(numbers.len(), "frame")),
        "note": note,
        "low": survey.low,
        "span": survey.span,
        "rate": RATE,
        "radii": radii,
        "thick": last.grains.radii.iter().sum::<f64>() / last.grains.radii.len().max(1) as f64,
        "fields": listed,
        "viridis": VIRIDIS,
        "palette": PALETTE,
        "eye": Subject::of(std::iter::once(&last), wishes.all_grains).outlook(&last),
        "frames": frames,
        "walls": walls,
    });
    Ok(Payload { bytes: assemble(head, &arrays.bytes), frames: numbers.len(), note })
}

/// Joins head and arrays.
fn assemble(mut head: Value, arrays: &[u8]) -> Vec<u8> {
    // The head states the start of the arrays; the number has a fixed length.
    head["start"] = json!(0);
    let length = head.to_string().len() + 16;
    let start = (4 + length).next_multiple_of(8);
    head["start"] = json!(start);
    let mut text = head.to_string();
    text.extend(std::iter::repeat_n(' ', length - text.len()));
    let mut bytes = (length as u32).to_le_bytes().to_vec();
    bytes.extend(text.as_bytes());
    bytes.resize(start, 0);
    bytes.extend(arrays);
    bytes
}

/// Splits a payload into the head and the arrays.
///
/// # Errors
/// Message about the invalid payload.
pub fn unpack(bytes: &[u8]) -> Result<(Value, &[u8]), String> {
    let length = bytes.first_chunk().map(|bytes| u32::from_le_bytes(*bytes) as usize).ok_or("it is empty")?;
    let head: Value = serde_json::from_slice(bytes.get(4..4 + length).ok_or("its head is cut off")?)
        .map_err(|error| format!("its head is no JSON: {error}"))?;
    let start = head["start"].as_u64().ok_or("it does not say where arrays begin")? as usize;
    Ok((head, bytes.get(start..).ok_or("it has no arrays")?))
}

/// Chooses the shown frames and whether to show contacts, and returns a note on omitted content.
fn choose(run: &RunFrames, last: &RunFrame, wishes: &Wishes, fields: usize) -> (Vec<usize>, bool, String) {
    let grains = last.grains.radii.len() as f64 * (6 + 2 * fields.max(1)) as f64;
    let strong = last.contacts.as_ref().map_or(0.0, |lines| 0.5 * 14.0 * lines.len() as f64);
    let walls = last.walls.as_ref().map_or(0.0, |walls| 36.0 * walls.triangles.len() as f64);
    let count = |every: usize| run.count().div_ceil(every) as f64;
    let mut note = Vec::new();
    let every = wishes.every.unwrap_or_else(|| {
        let fit = (1..=run.count()).find(|every| count(*every) * (grains + walls) <= wishes.most_bytes);
        fit.unwrap_or(run.count())
    });
    let contacts =
        wishes.contacts && last.contacts.is_some() && count(every) * (grains + walls + strong) <= wishes.most_bytes;
    if wishes.contacts && last.contacts.is_some() && !contacts {
        note.push("Force chains are left out: the file would be too large (--megabytes).".to_string());
    }
    if every > 1 {
        note.push(format!("One frame in {every} is shown."));
    }
    // The last frame is always included.
    let mut numbers: Vec<usize> = (0..run.count()).rev().step_by(every).collect();
    numbers.reverse();
    (numbers, contacts, note.join(" "))
}

fn survey(
    (run, last): (&RunFrames, &RunFrame),
    numbers: &[usize],
    fields: &[String],
    contacts: bool,
    progress: &dyn Fn(f64),
) -> Result<Survey, RunFolderError> {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    let mut survey = Survey {
        low: [0.0; 3],
        span: [1.0; 3],
        ranges: vec![[f64::INFINITY, f64::NEG_INFINITY]; fields.len()],
        samples: vec![Vec::new(); fields.len()],
        grains: 0,
        changes: false,
        distinct: vec![BTreeSet::new(); CONSTANT.len()],
    };
    let step = numbers.len().div_ceil(9).max(1);
    for (place, &number) in numbers.iter().enumerate() {
        let frame = run.read(number)?;
        survey.grains = survey.grains.max(frame.grains.radii.len());
        let ends = frame.contacts.iter().flatten().flat_map(|line| line.ends).filter(|_| contacts);
        for position in frame.grains.positions.iter().copied().chain(ends) {
            for axis in 0..3 {
                low[axis] = low[axis].min(position[axis]);
                high[axis] = high[axis].max(position[axis]);
            }
        }
        survey.changes |= !frame.has_same_grains(last);
        for (name, distinct) in CONSTANT.iter().zip(&mut survey.distinct) {
            let values = frame.quantity(name).map(|quantity| quantity.values).unwrap_or_default();
            let ends: [fn(f64, f64) -> f64; 2] = [f64::min, f64::max];
            let ends = ends.iter().filter_map(|choose| values.iter().copied().reduce(choose));
            let room = MOST_DISTINCT.saturating_sub(distinct.len());
            distinct.extend(values.iter().take(room).copied().chain(ends).map(f64::to_bits));
        }
        for (number, name) in fields.iter().enumerate() {
            let values = run.field(&frame, name)?.values;
            let [least, most] = range_of(&values);
            let range = &mut survey.ranges[number];
            *range = [range[0].min(least), range[1].max(most)];
            if place % step == 0 || place + 1 == numbers.len() {
                survey.samples[number].extend(values);
            }
        }
        progress((place + 1) as f64 / numbers.len() as f64);
    }
    if survey.grains > 0 {
        survey.low = low;
        survey.span = std::array::from_fn(|axis| (high[axis] - low[axis]).max(1e-9));
    }
    survey
        .ranges
        .iter_mut()
        .filter(|[low, high]| low >= high)
        .for_each(|range| *range = [range[0].min(0.0), range[0].min(0.0) + 1.0]);
    Ok(survey)
}

impl Survey {
    /// Returns the constant fields of the last frame, with colours for the values of all frames.
    fn constants(&self, last: &RunFrame) -> Vec<Constant> {
        let one = |(name, distinct): (&&str, &BTreeSet<u64>)| {
            let Quantity { title, values, .. } = last.quantity(name)?;
            let values = match self.changes {
                true => distinct.iter().map(|bits| f64::from_bits(*bits)).collect(),
                false => values,
            };
            let (range, scale) = (range_of(&values), Scale::of(&title, &values));
            Some(Constant { name: name.to_string(), values, range, scale })
        };
        CONSTANT.iter().zip(&self.distinct).filter_map(one).collect()
    }

    /// Returns a position over the box of all frames.
    fn place(&self, position: &[f64; 3]) -> [u16; 3] {
        std::array::from_fn(|axis| share(position[axis], [self.low[axis], self.low[axis] + self.span[axis]]))
    }
}

/// Returns the contacts of force chains: those with at least the mean force of their frame (F. Radjai, D. E. Wolf, M. Jean and
/// J.-J. Moreau, Bimodal character of stress transmission in granular packings, Physical Review Letters 80 (1998), 61-64).
fn strong(lines: &[ContactLine]) -> impl Iterator<Item = &ContactLine> {
    let mean = lines.iter().map(|line| line.normal_force).sum::<f64>() / lines.len().max(1) as f64;
    lines.iter().filter(move |line| line.normal_force >= mean && line.normal_force > 0.0)
}

/// Returns a force that nearly all contacts of a frame stay below, N.
fn strongest(lines: &[ContactLine]) -> f64 {
    let mut sorted: Vec<f64> = lines.iter().map(|line| line.normal_force).collect();
    sorted.sort_by(f64::total_cmp);
    let place = ((1.0 - STRONGEST) * sorted.len() as f64) as usize;
    sorted.get(place.min(sorted.len().saturating_sub(1))).copied().filter(|force| *force > 0.0).unwrap_or(1.0)
}

/// Returns the relative position of a value in a range, in 16 bits.
fn share(value: f64, [low, high]: [f64; 2]) -> u16 {
    let share = (value - low) / (high - low);
    if share.is_finite() { (FULL * share.clamp(0.0, 1.0)).round() as u16 } else { 0 }
}

fn range_of(values: &[f64]) -> [f64; 2] {
    let finite = values.iter().copied().filter(|value| value.is_finite());
    let [low, high] =
        finite.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)]);
    match low < high {
        true => [low, high],
        false if low.is_finite() => [low, low + low.abs().max(1e-12)],
        false => [0.0, 1.0],
    }
}

/// Returns the page's entry of a field: its name, its unit, the ends of its range and of its colour scale, ticks.
fn field(quantity: &Quantity, samples: &[f64], range: [f64; 2], mut listed: Value) -> Value {
    listed["title"] = json!(quantity.title);
    listed["range"] = json!(range);
    match Scale::of(&quantity.title, samples) {
        Scale::Kinds(kinds) => {
            let names: Vec<String> = kinds.iter().take(MOST_KINDS).map(|kind| kind_name(quantity, *kind)).collect();
            listed["kinds"] = json!(names);
            listed["unit"] = json!("");
            listed["shown"] = json!([0.0, 1.0]);
            listed["ticks"] = json!([]);
        }
        Scale::Range([low, high]) => {
            let (unit, ticks) = ticks(quantity.unit, [low, high]);
            let ticks: Vec<Value> = ticks.into_iter().map(|(at, text)| json!({ "at": at, "text": text })).collect();
            listed["unit"] = json!(unit);
            listed["shown"] = json!([low, high].map(|end| (end - range[0]) / (range[1] - range[0])));
            listed["range"] = json!([low, high]);
            listed["stored"] = json!(range);
            listed["ticks"] = json!(ticks);
        }
    }
    listed
}

fn surfaces(walls: &Walls, arrays: &mut Arrays) -> Value {
    let mut corners = |stone: bool| {
        let of_kind = walls.triangles.iter().zip(&walls.wall).filter(|(_, wall)| is_stone(walls, **wall) == stone);
        arrays.floats(of_kind.flat_map(|(corners, _)| corners.iter().flat_map(|corner| walls.points[*corner as usize])))
    };
    let (glass, stone) = (corners(false), corners(true));
    let edges = arrays.floats(wall_edges(walls).into_iter().flatten().flatten());
    json!({ "glass": glass, "stone": stone, "edges": edges })
}
