//! Thread for measurement and output: frames, the table over time, the frames measured at the end.
//!
//! The run passes a frame and continues. One frame is in progress at a time, which bounds the memory; a run with the next frame waits.
//! A failure of the thread is reported with the next order.

use super::measured::{Mark, MeasuredFrames};
use super::progress::Progress;
use crate::commands::Failure;
use makadam::checkpoint::sync_folder;
use makadam::snapshot::Snapshot;
use makadam_frames::output::{TableWritten, TimeTable, WriteError};
use makadam_frames::plan::MeasuredScene;
use makadam_frames::run_frames::{StoreMark, StoreWriter};
use makadam_measure::observables::setting::Properties;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel};
use std::thread::JoinHandle;

pub(super) struct Outputs {
    pub folder: PathBuf,
    pub frames: StoreWriter,
    pub table: TimeTable,
    pub measured: MeasuredFrames,
}

/// Extent of all outputs.
#[derive(Clone)]
pub(super) struct Marks {
    frames: StoreMark,
    table: TableWritten,
    measured: Mark,
}

impl Marks {
    pub fn put_into(self, progress: Progress) -> Progress {
        Progress { frames: self.frames, table: self.table, measured: self.measured, ..progress }
    }
}

impl Outputs {
    /// Writes a frame, or a row of the table (the given cells, then the measurements of the frame), or both.
    fn take(
        &mut self,
        properties: &Properties<'_>,
        FrameToWrite { mut frame, written, row }: FrameToWrite,
    ) -> Result<(), Failure> {
        let scene = &*properties.scene;
        if written {
            let has_contacts = scene.output.as_ref().is_none_or(|output| output.contacts);
            let hidden = if has_contacts { Vec::new() } else { std::mem::take(&mut frame.contacts) };
            self.frames.append(&frame)?;
            if !has_contacts {
                frame.contacts = hidden;
            }
        }
        let Some(mut cells) = row else { return Ok(()) };
        let known = cells.len();
        let driven_walls = frame.driven_walls.clone();
        let measured = self.measured.push(properties, frame)?.measurements.into_iter();
        let measured = measured.map(|one| (one.observable, one.value));
        let unknown: Vec<_> =
            measured.filter(|(name, _)| cells[..known].iter().all(|(cell, _)| cell != name)).collect();
        cells.extend(unknown);
        cells.retain(|(_, value)| value.is_finite());
        for driven in &driven_walls {
            let name = &scene.wall[driven.wall as usize].name;
            cells.push((format!("{name}_displacement"), driven.displacement));
            cells.push((format!("{name}_rate"), driven.rate));
        }
        Ok(self.table.push(cells)?)
    }

    fn marks(&self) -> Marks {
        let Outputs { frames, table, measured, .. } = self;
        Marks { frames: frames.mark(), table: table.written().clone(), measured: measured.mark() }
    }

    /// Flushes all outputs to the disk.
    pub fn sync(&mut self) -> Result<(), WriteError> {
        self.frames.sync()?;
        self.table.sync()?;
        self.measured.sync()?;
        sync_folder(&self.folder).map_err(|source| WriteError::new(&self.folder, source))
    }
}

/// Frame on its path to the disk.
pub(super) struct FrameToWrite {
    pub frame: Snapshot,
    /// True for a frame of the store.
    pub written: bool,
    /// First cells of the frame's row of the table, if it is measured; values that are not finite stay empty.
    pub row: Option<Vec<(String, f64)>>,
}

enum Order {
    Frame(Box<FrameToWrite>),
    /// Request for the marks after all earlier frames are written, and on the disk if requested.
    Marks {
        on_disk: bool,
        answer: Sender<Marks>,
    },
}

/// Marks available once all earlier frames are written.
pub(super) struct MarksToCome(Receiver<Marks>);

impl MarksToCome {
    /// Waits for the marks; `None` if writing has failed, which the writer reports.
    pub fn wait(self) -> Option<Marks> {
        self.0.recv().ok()
    }
}

/// Handle of the thread.
pub(super) struct Writer {
    /// Absent after the end of the thread.
    working: Option<Working>,
    /// Outputs returned by the thread.
    ended: Option<Outputs>,
}

struct Working {
    orders: Sender<Order>,
    /// Channel with one token, for the frame in progress.
    under_way: SyncSender<()>,
    thread: JoinHandle<(Outputs, Result<(), Failure>)>,
}

impl Writer {
    pub fn start(scene: MeasuredScene, outputs: Outputs) -> Writer {
        let (orders, taken) = channel();
        let (under_way, done) = sync_channel(1);
        let thread = std::thread::spawn(move || work(&scene, outputs, &taken, &done));
        Writer { working: Some(Working { orders, under_way, thread }), ended: None }
    }

    /// Waits until the previous frame is written.
    pub fn wait_for_room(&mut self) -> Result<(), Failure> {
        match self.working.as_ref().is_some_and(|working| working.under_way.send(()).is_ok()) {
            true => Ok(()),
            false => Err(self.failure()),
        }
    }

    /// Passes a frame to the thread, after [`Writer::wait_for_room`].
    pub fn write(&mut self, frame: FrameToWrite) -> Result<(), Failure> {
        self.order(Order::Frame(Box::new(frame)))
    }

    /// Requests the marks after the frames so far, without waiting for them.
    pub fn ask_for_marks(&mut self) -> Result<MarksToCome, Failure> {
        let (answer, marks) = channel();
        self.order(Order::Marks { on_disk: false, answer })?;
        Ok(MarksToCome(marks))
    }

    /// Waits until all is on the disk.
    pub fn sync(&mut self) -> Result<Marks, Failure> {
        let (answer, marks) = channel();
        self.order(Order::Marks { on_disk: true, answer })?;
        MarksToCome(marks).wait().ok_or_else(|| self.failure())
    }

    /// Ends the thread; returns the outputs and a failure since the last order.
    pub fn end(mut self) -> (Outputs, Result<(), Failure>) {
        let ended = self.join();
        (self.ended.take().expect("it has been joined"), ended)
    }

    fn order(&mut self, order: Order) -> Result<(), Failure> {
        match self.working.as_ref().is_some_and(|working| working.orders.send(order).is_ok()) {
            true => Ok(()),
            false => Err(self.failure()),
        }
    }

    /// Returns the failure that ended the thread.
    fn failure(&mut self) -> Failure {
        let unnamed = || Failure::Running("what the run leaves is no longer written".into());
        self.join().err().unwrap_or_else(unnamed)
    }

    fn join(&mut self) -> Result<(), Failure> {
        let Some(Working { orders, under_way, thread }) = self.working.take() else { return Ok(()) };
        // Without senders the thread finishes its orders and ends.
        drop((orders, under_way));
        let (outputs, ended) = thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        self.ended = Some(outputs);
        ended
    }
}

/// Executes orders until none is left, or one fails.
fn work(
    scene: &MeasuredScene,
    mut outputs: Outputs,
    orders: &Receiver<Order>,
    under_way: &Receiver<()>,
) -> (Outputs, Result<(), Failure>) {
    let properties = Properties::new(scene);
    loop {
        let Ok(order) = orders.recv() else { return (outputs, Ok(())) };
        let done = match order {
            Order::Frame(frame) => outputs.take(&properties, *frame).inspect(|()| {
                let _ = under_way.try_recv();
            }),
            Order::Marks { on_disk, answer } => {
                let synced = if on_disk { outputs.sync() } else { Ok(()) };
                synced.map_err(Failure::from).inspect(|()| {
                    // The receiver may have been dropped.
                    let _ = answer.send(outputs.marks());
                })
            }
        };
        if done.is_err() {
            return (outputs, done);
        }
    }
}
