//! `makadam run` in memory that does not grow with the frames that it measures.

use std::path::Path;
use std::process::Command;

/// Peak memory (bytes) of a run of so many frames, each of which is measured.
fn peak(folder: &Path, frames: u64) -> u64 {
    let smoke = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenes/smoke.toml");
    let text = std::fs::read_to_string(smoke).unwrap();
    let scene = folder.join("frames.toml");
    std::fs::write(&scene, text.replacen("interval = 0.05", "interval = 0.001\nfrom = 0.0", 1)).unwrap();
    let steps = (frames * 2).to_string();
    let output = Command::new(env!("CARGO_BIN_EXE_makadam"))
        .args(["run", "frames.toml", "--steps", &steps, "--threads", "1", "--output", &steps, "--json", "--quiet"])
        .current_dir(folder)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(summary["frames"], frames + 1);
    assert!(summary["observables"]["coordination_number"]["value"].as_f64().unwrap() > 0.0);
    assert!(!folder.join(&steps).join("measured-frames.mkd").exists(), "it is not needed any more");
    summary["peak_bytes"].as_u64().unwrap()
}

#[test]
fn memory_does_not_grow_with_measured_frames() {
    let folder = tempfile::tempdir().unwrap();
    let (few, many) = (peak(folder.path(), 50), peak(folder.path(), 650));
    // A frame holds 200 grains and some 500 contacts, 70 kB: 600 more of them would be 42 MB. Numbers by frame are 1 MB.
    let growth = many.saturating_sub(few);
    assert!(growth < 15_000_000, "{growth} bytes for 600 more frames");
}
