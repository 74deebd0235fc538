"""Faults put into a copy of the sources, each behind a question at run time, so that one build holds them all.

A fault is asked for by its number, from 1, in the environment variable MAKADAM_FAULT.
"""

import pathlib
import shutil
import subprocess
import sys
import tomllib

ROOT = pathlib.Path(__file__).resolve().parent.parent

QUESTION = """
/// Whether the fault of this number is asked for.
#[doc(hidden)]
#[inline(always)]
pub fn has_fault(number: u32) -> bool {
    use std::sync::atomic::{AtomicU32, Ordering::Relaxed};
    static ASKED: AtomicU32 = AtomicU32::new(u32::MAX);
    #[cold]
    fn ask() -> u32 {
        let asked = std::env::var("MAKADAM_FAULT").ok().and_then(|text| text.parse().ok()).unwrap_or(0);
        ASKED.store(asked, Relaxed);
        asked
    }
    let asked = ASKED.load(Relaxed);
    number == if asked == u32::MAX { ask() } else { asked }
}
"""


def spans(text, name, faults):
    """Where each fault's expression stands in a file, the widest first."""
    found = []
    for number, fault in faults:
        find = fault["find"].strip()
        if text.count(find) != 1:
            sys.exit(f"faults: '{find}' stands {text.count(find)} times in {name}: '{fault['what']}'")
        start = text.index(find)
        found.append((start, start + len(find), number, fault["change"].strip()))
    return sorted(found, key=lambda span: (span[0] - span[1], span[2]))


def put_in(copy, faults):
    """Writes every fault behind its question into the copy."""
    by_file = {}
    for number, fault in enumerate(faults, 1):
        by_file.setdefault(fault["file"], []).append((number, fault))
    for name, entries in by_file.items():
        file, crate = copy / name, "crate" if name.startswith("solver/") else "makadam"
        text = file.read_text()
        # Expressions within an expression are changed as parts of it.
        outer = []
        for start, end, number, change in spans(text, name, entries):
            home = next((known for known in outer if known[0] <= start and end <= known[1]), None)
            if home is None:
                home = (start, end, [])
                outer.append(home)
            home[2].append((number, text[home[0]:start] + change + text[end:home[1]]))
        for start, end, changes in sorted(outer, reverse=True):
            asked = "".join(f"if {crate}::has_fault({number}) {{ {change} }} else " for number, change in changes)
            text = f"{text[:start]}({asked}{{ {text[start:end]} }}){text[end:]}"
        file.write_text(text)
    library = copy / "solver/src/lib.rs"
    library.write_text(library.read_text() + QUESTION)


def read_table(name, key):
    """The faults of a table: dictionaries with the words what, file, find and change."""
    return tomllib.loads((ROOT / name).read_text())[key]


def copy_with_faults(folder, faults):
    """Copies what the repository tracks, or would, into a folder, and puts the faults in; returns the copy's folder."""
    copy = folder / "copy"
    shutil.rmtree(copy, ignore_errors=True)
    command = ["git", "ls-files", "-z", "-co", "--exclude-standard"]
    listed = subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    for name in filter(None, listed.stdout.decode().split("\0")):
        if (ROOT / name).is_file() or (ROOT / name).is_symlink():
            (copy / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, copy / name, follow_symlinks=False)
    put_in(copy, faults)
    return copy
