//! When frames are: grains and contacts in the order of time, each with what belongs to it.

use super::assemble::Assembly;
use super::columns::{Column, Places};
use super::contact_series::{ContactSeries, OfSeries, span};
use super::frame_table::{FrameTable, ImportError};
use super::number_in;
use super::numbering::{by_numbers, has_points, pattern};
use super::sequence::{one_after_the_other, side_by_side};
use crate::recording::Content;
use std::collections::BTreeMap;
use std::path::Path;

/// Two times are the same if they are nearer than this part of the time between frames.
const SAME_TIME: f64 = 1e-3;

/// Contacts as files give them.
pub(super) struct Given<'t> {
    /// The tables of each frame of grains.
    pub tables: Vec<Vec<&'t FrameTable>>,
    /// What they may lack, since they tell nothing of some measured frames.
    pub unsure: Vec<Content>,
}

impl Assembly<'_> {
    /// Time of a frame, s: what it tells itself, that of its step, or that of its place among the others.
    fn time_of(&self, table: &FrameTable, place: usize) -> Option<f64> {
        let stepped = || Some(table.step? as f64 * self.stated.time_step?);
        table.time.or_else(stepped).or_else(|| Some(place as f64 * self.stated.interval?))
    }

    /// Whether some of these frames get their times by their place among the others.
    fn counts<'t>(&self, tables: impl IntoIterator<Item = &'t FrameTable>) -> bool {
        let untold =
            |table: &FrameTable| table.time.is_none() && (table.step.is_none() || self.stated.time_step.is_none());
        self.stated.interval.is_some() && tables.into_iter().any(untold)
    }

    /// Frames with their times, in the order of time.
    pub(super) fn timed<'t>(
        &self,
        tables: &'t [FrameTable],
        notes: &mut Vec<String>,
    ) -> Result<Vec<(f64, &'t FrameTable)>, ImportError> {
        if self.stated.time_step.is_some() {
            steps_rise(tables)?;
        }
        let mut timed = Vec::with_capacity(tables.len());
        let ordered = if self.counts(tables) { one_after_the_other(tables, notes)? } else { tables.iter().collect() };
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
        timed.dedup_by(|(later, table), (earlier, known)| {
            is_same_time(*earlier, *later) && (&table.columns, &table.values) == (&known.columns, &known.values)
        });
        if timed.len() < all {
            notes.push(format!("{} frames are the same as another one at their time", all - timed.len()));
        }
        if let Some(pair) = timed.windows(2).find(|pair| is_same_time(pair[0].0, pair[1].0)) {
            let ((time, one), (_, other)) = (pair[0], pair[1]);
            let problem = format!(
                "it has a frame at {time} s, as {} has (line {}); leave one frame at each time, with all grains",
                one.file.display(),
                one.line
            );
            return Err(other.fault(0, problem));
        }
        Ok(timed)
    }

    /// Notes frames that have no grains, and others than those of the scene.
    ///
    /// # Errors
    /// [`ImportError`] where a frame has more grains than the scene.
    pub(super) fn count(&self, grains: &[(f64, &FrameTable)], notes: &mut Vec<String>) -> Result<(), ImportError> {
        let counts: Vec<usize> = grains.iter().map(|(_, table)| table.rows().count()).collect();
        let filled = || counts.iter().filter(|count| **count > 0);
        let empty = counts.len() - filled().count();
        if empty > 0 {
            notes.push(format!("{empty} of {} frames have no grains: they are not measured", counts.len()));
        }
        let (fewest, most) = (filled().min().copied().unwrap_or(0), filled().max().copied().unwrap_or(0));
        let wanted = self.scene.grain_count();
        if let Some((_, table)) = grains.iter().find(|(_, table)| table.rows().count() > wanted) {
            let problem = format!(
                "a frame has {} grains, and the scene has {wanted}; leave one frame at each time, in files of its own or told apart by a \
                 column time or step",
                table.rows().count()
            );
            return Err(table.fault(0, problem));
        }
        if (fewest, most) != (wanted, wanted) {
            let found = if fewest == most { format!("{most}") } else { format!("{fewest} to {most}") };
            notes.push(format!(
                "the frames have {found} grains, and the scene has {wanted}: those that are there are measured"
            ));
        }
        Ok(())
    }

    /// Which of the frames are measured.
    pub(super) fn measured(&self, grains: &[(f64, &FrameTable)]) -> Vec<bool> {
        let last = grains.iter().rposition(|(_, table)| table.rows().next().is_some());
        let is_measured = |(place, (time, _)): (usize, &(f64, &FrameTable))| match self.scene.measure.from {
            Some(_) => self.scene.measure.covers(*time),
            None => Some(place) == last,
        };
        grains.iter().enumerate().map(is_measured).collect()
    }

    /// The tables of contacts of each frame.
    pub(super) fn contacts<'t>(
        &self,
        tables: &'t [FrameTable],
        grains: &[(f64, &FrameTable)],
        notes: &mut Vec<String>,
    ) -> Result<Given<'t>, ImportError> {
        let mut given = Given { tables: vec![Vec::new(); grains.len()], unsure: Vec::new() };
        if tables.is_empty() {
            return Ok(given);
        }
        let mut apart = f64::INFINITY;
        grains.windows(2).for_each(|pair| apart = apart.min(pair[1].0 - pair[0].0));
        let single = grains.len() == 1 && tables.iter().all(|table| table.time.is_none());
        let near = |time: f64| grains.iter().position(|(own, _)| (own - time).abs() <= SAME_TIME * apart.min(1.0));
        let mut strangers = 0;
        let mut all_series = ContactSeries::default();
        let counts_grains = self.counts(grains.iter().map(|(_, table)| *table));
        // Where frames are counted, files of different contacts count their own.
        let all = if self.counts(tables) { side_by_side(tables, notes)? } else { vec![tables.iter().collect()] };
        for (place, table) in all.iter().flat_map(|series| series.iter().enumerate()) {
            let time = self.time_of(table, place);
            let at = if single { Some(0) } else { time.and_then(near) };
            all_series.add(OfSeries { table, time, at });
            let Some(at) = at else {
                if counts_grains && self.counts([*table]) {
                    let problem = format!(
                        "its contacts are of frame {} by their place, and there are {} frames of grains; leave one of contacts for each",
                        place + 1,
                        grains.len()
                    );
                    return Err(table.fault(0, problem));
                }
                strangers += 1;
                continue;
            };
            if let Some(problem) = of_another_step(table, grains[at].1) {
                return Err(table.fault(0, problem));
            }
            if let Some(known) = given.tables[at].iter().find(|known: &&&FrameTable| known.file == table.file) {
                // A code that is started twice tells the step in between twice.
                if known.values == table.values {
                    continue;
                }
                let problem = format!("it has two frames of contacts at {} s; leave one at each time", grains[at].0);
                return Err(table.fault(0, problem));
            }
            given.tables[at].push(table);
        }
        // Contacts with walls may be told apart from those between grains: each must be told of every measured frame.
        let measured = self.measured(grains);
        let count = measured.iter().filter(|measured| **measured).count();
        for series in all_series.apart() {
            let tells = |at: usize| series.iter().any(|one| one.at == Some(at));
            let untold = || (0..grains.len()).filter(|&at| measured[at] && !tells(at));
            if let Some(first) = untold().next() {
                given.unsure.extend(untold_contacts(&series, grains[first].0, [untold().count(), count], notes)?);
            }
        }
        if strangers > 0 {
            notes.push(format!(
                "{strangers} frames of contacts have no frame of grains at their time: they are not measured"
            ));
        }
        match given.tables.iter().position(Vec::is_empty) {
            Some(place) if !tables.iter().all(is_by_rows) => {
                let (time, table) = grains[place];
                Err(table.fault(0, untold_at(time)))
            }
            _ => Ok(given),
        }
    }
}

/// Contacts and grains that are told to be of different steps, where no time says otherwise.
fn of_another_step(contacts: &FrameTable, grains: &FrameTable) -> Option<String> {
    let steps = contacts.step.zip(grains.step).filter(|_| contacts.time.is_none() && grains.time.is_none());
    let (own, other) = steps.filter(|(own, other)| own != other)?;
    Some(format!(
        "its contacts are of step {own}, and the grains of {} are of step {other}; give contacts and grains of one time (a number in the \
         name of a file counts as its step)",
        grains.file.display()
    ))
}

/// Whether a table was cut out of one with a column of times: that has no rows where there are no contacts, and other files have a
/// frame then.
fn is_by_rows(table: &FrameTable) -> bool {
    table.time.is_some() && table.step.is_none()
}

/// What is unsure of contacts that are told in some of the measured frames only: not in `untold[0]` of `untold[1]`, the first at
/// `time`.
fn untold_contacts(
    series: &[OfSeries<'_>],
    time: f64,
    untold: [usize; 2],
    notes: &mut Vec<String>,
) -> Result<Vec<Content>, ImportError> {
    let first = series[0].table;
    let [untold, measured] = untold;
    let own = match span(series).filter(|_| untold == measured) {
        Some([from, to]) if from < to => format!(" (its times are from {from} to {to} s)"),
        Some([at, _]) => format!(" (its time is {at} s)"),
        None => String::new(),
    };
    if !series.iter().all(|one| is_by_rows(one.table)) {
        return Err(first.fault(0, untold_at(time) + &own));
    }
    notes.push(format!(
        "{} has no rows at {time} s, and of {untold} of {measured} measured frames{own}: there may be none, or they are not told, so \
         what needs its contacts is not measured; leave a file of contacts for each frame, without a column of times, and with the \
         heads of its columns alone where there are none",
        first.file.file_name().unwrap_or_default().display()
    ));
    let places = Places::of(first);
    let kinds = [(Column::Second, Content::Contacts), (Column::Wall, Content::WallContacts)];
    Ok(kinds.into_iter().filter(|(column, _)| places.find(*column).is_some()).map(|(_, content)| content).collect())
}

/// What is wrong with contacts that are not told at a time (s).
fn untold_at(time: f64) -> String {
    format!("no contacts are given for the frame at {time} s; give those of all frames, or of none")
}

/// Refuses steps that are decimals of times in the names of files: 0.05 would be step 5, and later than 0.1.
fn steps_rise(tables: &[FrameTable]) -> Result<(), ImportError> {
    let mut alike: BTreeMap<String, BTreeMap<&Path, &FrameTable>> = BTreeMap::new();
    let is_by_name = |table: &&FrameTable| {
        table.time.is_none() && table.step.is_some_and(|step| number_in(&table.file) == Some(step))
    };
    for table in tables.iter().filter(is_by_name) {
        alike.entry(pattern(&table.file)).or_default().insert(&table.file, table);
    }
    for of_file in alike.into_values().filter(|of_file| of_file.keys().any(|file| has_points(file))) {
        let all: Vec<&Path> = of_file.keys().copied().collect();
        let Ok(in_order) = by_numbers(all.clone()) else {
            let problem = "a number in its name may have decimals, and be no step; leave names that differ in one whole number, or a \
                           column time";
            return Err(ImportError::new(all[0], 1, problem));
        };
        if let Some(pair) = in_order.files.windows(2).find(|pair| of_file[pair[0]].step >= of_file[pair[1]].step) {
            let problem = "the number in its name has decimals, and is no step; give --interval in place of --time-step, or leave a \
                           column time";
            return Err(ImportError::new(pair[1], 1, problem));
        }
    }
    Ok(())
}

/// Whether two times are one but for rounding.
fn is_same_time(earlier: f64, later: f64) -> bool {
    later - earlier <= 1e-9 * later.abs()
}
