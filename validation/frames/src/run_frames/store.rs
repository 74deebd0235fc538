//! Frame store: one file with the frames of a run, exact to the last bit, appended during the run.
//!
//! ```text
//! record of the scene (TOML), then one record per frame; a record: magic bytes (8), length (8), checksum (8), body (postcard)
//! ```
//!
//! A killed process leaves at most its last record incomplete: readers end before it, and a resumed run overwrites it.

use crate::output::{WriteError, open_to_grow};
use crate::plan::MeasuredScene;
use makadam::checkpoint::{open, seal, seal_value};
use makadam::snapshot::{
    Beginning, Contact, DrivenWall, FaceWear, Origin, Particle, Passages, Passed, PresentStage, Snapshot, WallLoad,
};
use serde::{Deserialize, Serialize};
use std::fs::{File, OpenOptions};
use std::io::{BufReader, Error, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Magic bytes of the scene record; the last byte is the format version.
const SCENE: [u8; 8] = *b"mkd-scn\x02";
/// Magic bytes of a frame record; the last byte is the format version.
const FRAME: [u8; 8] = *b"mkd-frm\x07";

/// Bytes before the body of a record.
const HEAD: u64 = 24;

/// Position of a frame in a store.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// First byte of the record.
    start: u64,
    /// Bytes of the record.
    length: u64,
    /// Simulated time, s.
    pub time: f64,
    /// Stage; absent for a scene without stages.
    pub stage: Option<PresentStage>,
    /// Number of grains.
    pub grains: u32,
}

impl Entry {
    fn end(&self) -> u64 {
        self.start + self.length
    }
}

/// Extent of a store at a checkpoint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct StoreMark {
    /// Number of frames.
    pub frames: usize,
    /// Bytes of the file.
    pub bytes: u64,
}

/// Appends frames to a store.
pub struct StoreWriter {
    store: Store,
    file: File,
}

impl StoreWriter {
    /// Creates a store of a scene; replaces an existing store.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses.
    pub fn create(path: &Path, scene: &MeasuredScene) -> Result<StoreWriter, WriteError> {
        let refused = |error| WriteError::new(path, error);
        // A link would lead to a file of another owner.
        let _ = std::fs::remove_file(path);
        let mut file = OpenOptions::new().write(true).create_new(true).open(path).map_err(refused)?;
        let text = toml::to_string(scene).expect("a scene is made of plain tables");
        let head = seal(SCENE, text.as_bytes());
        file.write_all(&head).map_err(refused)?;
        let store = Store { path: path.into(), scene: scene.clone(), head: head.len() as u64, entries: Vec::new() };
        Ok(StoreWriter { store, file })
    }

    /// Opens a store to append after the frames of a checkpoint; later frames are cut off.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses, or the file lacks frames of the checkpoint.
    pub fn resume(path: &Path, mark: StoreMark) -> Result<StoreWriter, WriteError> {
        let refused = |error| WriteError::new(path, error);
        let unfit = |problem: String| {
            let text = format!("{problem}, so it does not fit the checkpoint next to it; --restart begins again");
            refused(Error::new(ErrorKind::InvalidData, text))
        };
        let mut store = Store::open(path).map_err(unfit)?;
        store.entries.truncate(mark.frames);
        if (store.count(), store.bytes()) != (mark.frames, mark.bytes) {
            return Err(unfit(format!(
                "holds {} frames in {} bytes, not {} in {}",
                store.count(),
                store.bytes(),
                mark.frames,
                mark.bytes
            )));
        }
        store.visit(0..store.count(), &mut |_| ()).map_err(unfit)?;
        let mut file = open_to_grow(path)?;
        file.set_len(mark.bytes).and_then(|()| file.seek(SeekFrom::End(0))).map_err(refused)?;
        Ok(StoreWriter { store, file })
    }

    /// Appends a frame.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses; the frames before it stay readable.
    pub fn append(&mut self, frame: &Snapshot) -> Result<(), WriteError> {
        let Snapshot {
            time,
            particles,
            contacts,
            driven_walls,
            origins,
            passed,
            stage,
            beginnings,
            gauges,
            wall_loads,
            wear,
        } = frame;
        let parts: (Grains<_, _, _, _, _>, _) = (
            (*time, *stage, particles, driven_walls, origins, *passed, beginnings, gauges),
            (contacts, wall_loads, wear),
        );
        let record = seal_value(FRAME, &parts);
        let start = self.store.bytes();
        // A failed write may have left part of a record.
        let written = self.file.seek(SeekFrom::Start(start)).and_then(|_| self.file.write_all(&record));
        written.map_err(|error| WriteError::new(&self.store.path, error))?;
        let (length, grains) = (record.len() as u64, frame.particles.len() as u32);
        self.store.entries.push(Entry { start, length, time: frame.time, stage: frame.stage, grains });
        Ok(())
    }

    /// Flushes the frames to the disk.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses.
    pub fn sync(&self) -> Result<(), WriteError> {
        self.file.sync_all().map_err(|error| WriteError::new(&self.store.path, error))
    }

    /// Returns the extent of the store.
    pub fn mark(&self) -> StoreMark {
        StoreMark { frames: self.store.count(), bytes: self.store.bytes() }
    }

    /// Returns the frames for reading.
    pub fn store(&self) -> &Store {
        &self.store
    }
}

/// Frames of a store, for reading.
#[derive(Clone, Debug)]
pub struct Store {
    path: PathBuf,
    scene: MeasuredScene,
    /// Bytes of the scene record.
    head: u64,
    entries: Vec<Entry>,
}

impl Store {
    /// Reads the scene and the positions of all complete frames.
    ///
    /// # Errors
    /// Message, to follow the file name.
    pub(crate) fn open(path: &Path) -> Result<Store, String> {
        let mut file = File::open(path).map_err(unread)?;
        let size = file.metadata().map_err(unread)?.len();
        let head = record_length(&mut file, 0, size, SCENE)?;
        let head = head.ok_or("holds no whole scene: the run was killed at its start")?;
        let mut record = vec![0; head as usize];
        file.rewind().and_then(|()| file.read_exact(&mut record)).map_err(unread)?;
        let text = open(SCENE, &record)?;
        let text = std::str::from_utf8(text).map_err(|error| format!("is damaged: {error}"))?;
        let scene = toml::from_str(text).map_err(|error| format!("is of another version of the program: {error}"))?;
        let mut store = Store { path: path.into(), scene, head, entries: Vec::new() };
        while let Some(entry) = read_entry(&mut file, store.bytes(), size)? {
            store.entries.push(entry);
        }
        Ok(store)
    }

    /// Returns the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the scene.
    pub(crate) fn scene(&self) -> &MeasuredScene {
        &self.scene
    }

    /// Returns the times and grain counts of the frames.
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// Returns the number of frames.
    pub fn count(&self) -> usize {
        self.entries.len()
    }

    /// Reads a frame.
    ///
    /// # Errors
    /// Message, to follow the file name.
    pub(crate) fn read(&self, number: usize) -> Result<Snapshot, String> {
        self.read_from(&mut self.reader()?, number)
    }

    /// Reads frames by their numbers, in ascending order.
    ///
    /// # Errors
    /// Message, to follow the file name.
    pub fn visit(&self, numbers: impl Iterator<Item = usize>, look: &mut dyn FnMut(&Snapshot)) -> Result<(), String> {
        let mut file = self.reader()?;
        numbers.into_iter().try_for_each(|number| self.read_from(&mut file, number).map(|frame| look(&frame)))
    }

    /// Reads frames without their contacts, by their numbers, in ascending order.
    ///
    /// # Errors
    /// Message, to follow the file name.
    pub fn visit_grains(
        &self,
        numbers: impl Iterator<Item = usize>,
        look: &mut dyn FnMut(&Snapshot),
    ) -> Result<(), String> {
        let mut file = self.reader()?;
        numbers.into_iter().try_for_each(|number| {
            let bytes = self.bytes_of(&mut file, number)?;
            let (grains, _) = postcard::take_from_bytes(open(FRAME, &bytes)?).map_err(unfit)?;
            look(&frame_of(grains, Default::default()));
            Ok(())
        })
    }

    fn reader(&self) -> Result<BufReader<File>, String> {
        File::open(&self.path).map(BufReader::new).map_err(unread)
    }

    fn read_from(&self, file: &mut BufReader<File>, number: usize) -> Result<Snapshot, String> {
        let bytes = self.bytes_of(file, number)?;
        let (grains, loads) = postcard::from_bytes(open(FRAME, &bytes)?).map_err(unfit)?;
        Ok(frame_of(grains, loads))
    }

    /// Reads the record of a frame.
    fn bytes_of(&self, file: &mut BufReader<File>, number: usize) -> Result<Vec<u8>, String> {
        let entry = &self.entries[number];
        let ahead = entry.start as i64 - file.stream_position().map_err(unread)? as i64;
        file.seek_relative(ahead).map_err(unread)?;
        let mut bytes = Vec::with_capacity(entry.length as usize);
        file.take(entry.length).read_to_end(&mut bytes).map_err(unread)?;
        Ok(bytes)
    }

    fn bytes(&self) -> u64 {
        self.entries.last().map_or(self.head, Entry::end)
    }
}

/// First part of a frame record: time, stage, grains, dynamic walls, identities, grains that came and went, beginnings of motions,
/// passages of gauges. The contacts, and the loads and the wear of walls follow.
type Grains<P, W, O, B, G> = (f64, Option<PresentStage>, P, W, O, [Passed; 2], B, G);

/// First part of a frame record, read.
type OwnGrains = Grains<Vec<Particle>, Vec<DrivenWall>, Vec<Origin>, Vec<(u32, Beginning)>, Vec<[Passages; 2]>>;

fn frame_of(
    (time, stage, particles, driven_walls, origins, passed, beginnings, gauges): OwnGrains,
    (contacts, wall_loads, wear): (Vec<Contact>, Vec<WallLoad>, Vec<FaceWear>),
) -> Snapshot {
    Snapshot { time, particles, contacts, driven_walls, origins, passed, stage, beginnings, gauges, wall_loads, wear }
}

fn unfit(error: postcard::Error) -> String {
    format!("does not hold what it should ({error})")
}

fn unread(error: Error) -> String {
    format!("cannot be read: {error}")
}

/// Reads the position, time and grain count of the frame at a byte; `None` if the file ends before the frame does.
fn read_entry(file: &mut File, start: u64, size: u64) -> Result<Option<Entry>, String> {
    let Some(length) = record_length(file, start, size, FRAME)? else { return Ok(None) };
    // A snapshot begins with its time (8 bytes), its stage (at most 35) and its number of grains (at most 5).
    let mut bytes = vec![0; 48.min((length - HEAD) as usize)];
    file.read_exact(&mut bytes).map_err(unread)?;
    let begin: Result<((f64, Option<PresentStage>, u32), _), _> = postcard::take_from_bytes(&bytes);
    let ((time, stage, grains), _) = begin.map_err(unfit)?;
    Ok(Some(Entry { start, length, time, stage, grains }))
}

/// Reads the length of the record at a byte from its head; `None` if the file ends before the record does.
fn record_length(file: &mut File, start: u64, size: u64, magic: [u8; 8]) -> Result<Option<u64>, String> {
    if start + HEAD > size {
        return Ok(None);
    }
    let mut head = [0; HEAD as usize];
    file.seek(SeekFrom::Start(start)).and_then(|_| file.read_exact(&mut head)).map_err(unread)?;
    if head[..8] != magic {
        return Err(match head[..7] == magic[..7] {
            true => format!("has version {} of the format, not {}", head[7], magic[7]),
            false => format!("is damaged at byte {start}, or is no frame store"),
        });
    }
    let length = HEAD.saturating_add(u64::from_le_bytes(head[8..16].try_into().expect("eight bytes")));
    Ok((start.saturating_add(length) <= size).then_some(length))
}
