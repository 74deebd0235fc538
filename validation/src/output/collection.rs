//! A list of files over time, which ParaView opens as one. It grows at its end and is well-formed XML after every entry.

use super::{WriteError, write_durably, write_whole};
use makadam::checkpoint::sync_file;
use rustix::fs::OFlags;
use std::fs::{File, OpenOptions};
use std::io::{Error, ErrorKind};
use std::os::unix::fs::{FileExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

const HEAD: &str = "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n<Collection>\n";

/// What closes the list; each entry is written over it, together with the next one.
const TAIL: &str = "</Collection>\n</VTKFile>\n";

/// A `.pvd` file that grows.
pub(super) struct Collection {
    path: PathBuf,
    file: File,
    /// Bytes before [`TAIL`].
    body: u64,
}

impl Collection {
    /// A list without entries, in place of what stood there.
    pub fn create(path: &Path) -> Result<Collection, WriteError> {
        write_whole(path, [HEAD, TAIL].concat().as_bytes())?;
        Ok(Collection { path: path.into(), file: open_to_grow(path)?, body: HEAD.len() as u64 })
    }

    /// The list that an earlier part of the run has left, as it was when its entries ended at `body`.
    pub fn go_on(path: &Path, body: u64) -> Result<Collection, WriteError> {
        let refused = |source| WriteError::new(path, source);
        let file = open_to_grow(path)?;
        check_length(path, &file, body)?;
        let mut whole = vec![0; body as usize];
        file.read_exact_at(&mut whole, 0).map_err(refused)?;
        whole.extend(TAIL.as_bytes());
        // What stood there stays well-formed until this is, and on the disk: a list that cannot be shortened is no list.
        write_durably(path, &whole)?;
        Ok(Collection { path: path.into(), file: open_to_grow(path)?, body })
    }

    /// Adds an entry.
    pub fn push(&mut self, time: f64, name: &str) -> Result<(), WriteError> {
        let entry = format!("<DataSet timestep=\"{time}\" part=\"0\" file=\"{name}\"/>\n");
        let written = self.file.write_all_at([&entry, TAIL].concat().as_bytes(), self.body);
        written.map_err(|source| {
            // The list without the entry lies where blocks are taken already: a full disk has room for it.
            let _ = self.close();
            WriteError::new(&self.path, source)
        })?;
        self.body += entry.len() as u64;
        Ok(())
    }

    /// Ends the list after its last entry.
    fn close(&self) -> Result<(), Error> {
        self.file.write_all_at(TAIL.as_bytes(), self.body)?;
        self.file.set_len(self.body + TAIL.len() as u64)
    }

    /// Where the entries end, bytes from the beginning.
    pub fn body(&self) -> u64 {
        self.body
    }

    /// Writes it to the disk.
    pub fn sync(&self) -> Result<(), WriteError> {
        sync_file(&self.path).map_err(|source| WriteError::new(&self.path, source))
    }
}

/// Opens a file of ours to write in it, and no link to one of somebody else's.
pub(super) fn open_to_grow(path: &Path) -> Result<File, WriteError> {
    let flags = OFlags::NOFOLLOW.bits() as i32;
    let opened = OpenOptions::new().read(true).write(true).custom_flags(flags).open(path);
    opened.map_err(|source| WriteError::new(path, source))
}

/// A file that is shorter than a checkpoint says is not the one that it speaks of.
pub(super) fn check_length(path: &Path, file: &File, least: u64) -> Result<(), WriteError> {
    let length = file.metadata().map_err(|source| WriteError::new(path, source))?.len();
    if length < least {
        return Err(does_not_fit(path, &format!("it has {length} of {least} bytes")));
    }
    Ok(())
}

/// A file that a run cannot go on with.
pub(super) fn does_not_fit(path: &Path, what: &str) -> WriteError {
    let text = format!("is not what the checkpoint beside it speaks of: {what}; --restart begins anew");
    WriteError::new(path, Error::new(ErrorKind::InvalidData, text))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entries(path: &Path) -> Vec<String> {
        let text = std::fs::read_to_string(path).unwrap();
        let document = roxmltree::Document::parse(&text).unwrap_or_else(|error| panic!("{error} in\n{text}"));
        let sets = document.descendants().filter(|node| node.has_tag_name("DataSet"));
        sets.map(|set| set.attribute("file").unwrap().to_string()).collect()
    }

    #[test]
    fn a_list_is_whole_after_every_entry_and_goes_on_from_an_earlier_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("grains.pvd");
        let mut list = Collection::create(&path).unwrap();
        assert!(entries(&path).is_empty());
        list.push(0.0, "frames/a").unwrap();
        assert_eq!(entries(&path), ["frames/a"]);
        let body = list.body();
        for name in ["frames/b", "frames/a name that is longer than what closes the list", "frames/d"] {
            list.push(0.5, name).unwrap();
        }
        assert_eq!(entries(&path).len(), 4);
        let mut list = Collection::go_on(&path, body).unwrap();
        assert_eq!(entries(&path), ["frames/a"]);
        list.push(0.5, "frames/b").unwrap();
        assert_eq!(entries(&path), ["frames/a", "frames/b"]);
        let refused = Collection::go_on(&path, 10_000).err().unwrap().to_string();
        assert!(refused.contains("grains.pvd") && refused.contains("--restart"), "{refused}");
    }

    #[test]
    fn a_list_cut_off_in_its_last_entry_is_made_whole() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("grains.pvd");
        let mut list = Collection::create(&path).unwrap();
        list.push(0.0, "frames/a").unwrap();
        let body = list.body();
        list.push(0.5, "frames/b").unwrap();
        list.file.set_len(body + 7).unwrap();
        drop(Collection::go_on(&path, body).unwrap());
        assert_eq!(entries(&path), ["frames/a"]);
    }
}
