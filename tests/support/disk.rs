//! Possible content of a disk after a power failure, from a record of system calls: see `faults.c`.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

/// A call of the record.
enum Call {
    Open { file: u32, path: String },
    Write { file: u32, offset: usize, bytes: Vec<u8> },
    Truncate { file: u32, length: usize },
    Sync { file: u32 },
    Rename { from: String, to: String },
    Unlink { path: String },
    MakeFolder { path: String },
    RemoveFolder { path: String },
}

/// Calls in their order.
pub struct Record(Vec<Call>);

/// Part of the unsynced data that has reached the disk.
#[derive(Clone, Copy, Debug)]
pub enum Cut {
    /// Nothing: neither bytes nor names.
    NothingUnsynced,
    /// Names, but no bytes.
    Names,
    /// Names and lengths: zeros stand where bytes should.
    NamesAndLengths,
    /// All of it, as if the process alone had been killed.
    Everything,
}

/// All ways to cut.
pub const CUTS: [Cut; 4] = [Cut::NothingUnsynced, Cut::Names, Cut::NamesAndLengths, Cut::Everything];

impl Record {
    /// Reads a record.
    pub fn parse(mut text: &[u8]) -> Record {
        let mut calls = Vec::new();
        while let Some(end) = text.iter().position(|&byte| byte == b'\n') {
            let line = std::str::from_utf8(&text[..end]).unwrap();
            text = &text[end + 1..];
            let words: Vec<&str> = line.split(' ').collect();
            let number = |word: usize| words[word].parse::<usize>().unwrap();
            let path = |word: usize| words[word].to_string();
            calls.push(match words[0] {
                "open" => Call::Open { file: number(1) as u32, path: path(2) },
                "write" => {
                    let (bytes, rest) = text.split_at(number(3));
                    text = rest;
                    Call::Write { file: number(1) as u32, offset: number(2), bytes: bytes.to_vec() }
                }
                "truncate" => Call::Truncate { file: number(1) as u32, length: number(2) },
                "fsync" => Call::Sync { file: number(1) as u32 },
                "rename" => Call::Rename { from: path(1), to: path(2) },
                "unlink" => Call::Unlink { path: path(1) },
                "mkdir" => Call::MakeFolder { path: path(1) },
                "rmdir" => Call::RemoveFolder { path: path(1) },
                other => panic!("no call is named {other}"),
            });
        }
        Record(calls)
    }

    /// Number of calls.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// The folder `out` of `before` as it may be found after a cut behind so many calls: bytes by path.
    pub fn cut_after(&self, calls: usize, before: &Path, cut: Cut) -> BTreeMap<String, Option<Vec<u8>>> {
        let mut disk = Disk::holding(before);
        self.0.iter().take(calls).for_each(|call| disk.apply(call));
        disk.found(cut)
    }
}

/// Bytes as the program sees them, and those that are on the disk.
#[derive(Clone, Default)]
struct File {
    now: Vec<u8>,
    synced: Vec<u8>,
}

#[derive(Clone, PartialEq)]
enum Node {
    Folder,
    File(usize),
}

/// Names as the program sees them, and those that are on the disk.
#[derive(Default)]
struct Disk {
    files: Vec<File>,
    now: BTreeMap<String, Node>,
    synced: BTreeMap<String, Node>,
    open: HashMap<u32, String>,
    handles: HashMap<u32, Node>,
}

impl Disk {
    fn holding(before: &Path) -> Disk {
        let mut disk = Disk::default();
        let mut folders = vec!["out".to_string()];
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(before.join(&folder)).unwrap().map(Result::unwrap) {
                let path = format!("{folder}/{}", entry.file_name().to_str().unwrap());
                if entry.path().is_dir() {
                    folders.push(path);
                } else {
                    let bytes = std::fs::read(entry.path()).unwrap();
                    disk.files.push(File { now: bytes.clone(), synced: bytes });
                    disk.now.insert(path, Node::File(disk.files.len() - 1));
                }
            }
            disk.now.insert(folder, Node::Folder);
        }
        disk.synced = disk.now.clone();
        disk
    }

    fn apply(&mut self, call: &Call) {
        match call {
            Call::Open { file, path } => {
                let node = self.now.get(path).cloned().unwrap_or_else(|| {
                    self.files.push(File::default());
                    Node::File(self.files.len() - 1)
                });
                self.now.insert(path.clone(), node.clone());
                self.open.insert(*file, path.clone());
                self.handles.insert(*file, node);
            }
            Call::Write { file, offset, bytes } => {
                // Files elsewhere are not followed.
                if let Some(file) = self.file(*file) {
                    let end = offset + bytes.len();
                    file.now.resize(file.now.len().max(end), 0);
                    file.now[*offset..end].copy_from_slice(bytes);
                }
            }
            Call::Truncate { file, length } => {
                if let Some(file) = self.file(*file) {
                    file.now.resize(*length, 0);
                }
            }
            Call::Sync { file } => match self.handles.get(file) {
                Some(Node::File(number)) => self.files[*number].synced = self.files[*number].now.clone(),
                Some(Node::Folder) => {
                    let folder = self.open[file].clone() + "/";
                    let inside = |path: &String| path.strip_prefix(&folder).is_some_and(|name| !name.contains('/'));
                    self.synced.retain(|path, _| !inside(path));
                    self.synced
                        .extend(self.now.iter().filter(|(path, _)| inside(path)).map(|(p, n)| (p.clone(), n.clone())));
                }
                None => {}
            },
            Call::Rename { from, to } => {
                let node = self.now.remove(from).unwrap();
                self.now.insert(to.clone(), node);
            }
            Call::Unlink { path } | Call::RemoveFolder { path } => drop(self.now.remove(path).unwrap()),
            Call::MakeFolder { path } => drop(self.now.insert(path.clone(), Node::Folder)),
        }
    }

    fn file(&mut self, handle: u32) -> Option<&mut File> {
        match self.handles.get(&handle) {
            Some(Node::File(number)) => self.files.get_mut(*number),
            _ => None,
        }
    }

    fn found(&self, cut: Cut) -> BTreeMap<String, Option<Vec<u8>>> {
        let names = if matches!(cut, Cut::NothingUnsynced) { &self.synced } else { &self.now };
        let there = |path: &str| {
            let above = path.match_indices('/').map(|(end, _)| &path[..end]);
            above.into_iter().all(|folder| names.contains_key(folder))
        };
        let bytes = |node: &Node| match node {
            Node::Folder => None,
            Node::File(number) => {
                let File { now, synced } = &self.files[*number];
                Some(match cut {
                    Cut::NothingUnsynced | Cut::Names => synced.clone(),
                    Cut::Everything => now.clone(),
                    Cut::NamesAndLengths => {
                        let known = |(place, _): (usize, &u8)| synced.get(place).copied().unwrap_or(0);
                        now.iter().enumerate().map(known).collect()
                    }
                })
            }
        };
        names.iter().filter(|(path, _)| there(path)).map(|(path, node)| (path.clone(), bytes(node))).collect()
    }
}
