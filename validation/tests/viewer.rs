//! The page of a run: what it holds is what the run has left, to within its sixteen bits.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use makadam::Simulation;
use makadam_frames::output::RunFiles;
use makadam_frames::plan::MeasuredScene;
use makadam_frames::run_frames::{RunFrames, StoreWriter};
use makadam_view::viewer::{Wishes, unpack, write};
use serde_json::Value;
use std::io::Read;
use std::path::Path;

fn run(folder: &Path) -> RunFrames {
    let scene =
        std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenes/smoke.toml")).unwrap();
    let scene = MeasuredScene::parse(&scene).unwrap();
    let mut simulation = Simulation::builder(&scene).time_step(1e-3).build().unwrap();
    let mut frames = StoreWriter::create(&folder.join(RunFiles::FRAMES), &scene).unwrap();
    for _ in 0..4 {
        frames.append(&simulation.snapshot()).unwrap();
        (0..60).for_each(|_| {
            simulation.step();
        });
    }
    RunFrames::open(folder).unwrap()
}

fn wishes() -> Wishes {
    Wishes {
        fields: vec!["speed".into(), "pressure".into()],
        every: None,
        most_bytes: 1e9,
        contacts: true,
        all_grains: false,
    }
}

/// Head and arrays of a page.
fn read(page: &str) -> (Value, Vec<u8>) {
    let packed = page.split_once("application/octet-stream\">").unwrap().1.split_once("</script>").unwrap().0;
    let packed = STANDARD.decode(packed).unwrap();
    let mut bytes = Vec::new();
    flate2::read::ZlibDecoder::new(&packed[..]).read_to_end(&mut bytes).unwrap();
    let (head, arrays) = unpack(&bytes).unwrap();
    (head, arrays.to_vec())
}

fn shorts(arrays: &[u8], place: &Value) -> Vec<f64> {
    let [start, count] = [0, 1].map(|number| place[number].as_u64().unwrap() as usize);
    arrays[start..start + 2 * count]
        .chunks(2)
        .map(|bytes| f64::from(u16::from_le_bytes([bytes[0], bytes[1]])) / 65_535.0)
        .collect()
}

#[test]
fn places_and_fields_are_within_their_sixteen_bits() {
    let folder = tempfile::tempdir().unwrap();
    let run = run(folder.path());
    let file = folder.path().join("view.html");
    let page = write(&file, &run, &wishes(), &|_| {}).unwrap();
    let text = std::fs::read_to_string(&file).unwrap();
    assert_eq!((page.frames, page.bytes, page.note.as_str()), (4, text.len(), ""));
    // Nothing is asked for from outside.
    assert!(
        !text.contains("http:") && !text.contains("https:") && !text.contains("src=") && !text.contains("@import"),
        "the page wants the network"
    );
    assert!(text.contains("default-src 'none'"));
    // What is on the screen before the payload is read says how large it is.
    let (before, after) = (text.find("Loading ").unwrap(), text.find("id=\"payload\"").unwrap());
    assert!(before < after && text[before..after].contains(" MB "), "{}", &text[before..after]);
    let (head, arrays) = read(&text);
    let numbers =
        |name: &str| -> Vec<f64> { head[name].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect() };
    let (low, span) = (numbers("low"), numbers("span"));
    let fields = head["fields"].as_array().unwrap();
    let title = |number: usize| fields[number]["title"].as_str().unwrap();
    assert_eq!((title(0), title(1)), ("speed", "pressure"));
    assert!(fields.iter().any(|field| field["title"] == "material" && field["kinds"] == serde_json::json!(["grain"])));
    for number in 0..4 {
        let (frame, shown) = (run.read(number).unwrap(), &head["frames"][number]);
        assert_eq!(shown["time"].as_f64().unwrap(), frame.time);
        let state = shorts(&arrays, &shown["state"]);
        let pressure = shorts(&arrays, &shown["others"][0]);
        for (grain, position) in frame.grains.positions.iter().enumerate() {
            for axis in 0..3 {
                let place = low[axis] + span[axis] * state[4 * grain + axis];
                assert!((place - position[axis]).abs() <= 0.5001 * span[axis] / 65_535.0 + 1e-9);
            }
            for (name, value, field) in [("speed", state[4 * grain + 3], 0), ("pressure", pressure[grain], 1)] {
                let [from, to] = [0, 1].map(|end| fields[field]["stored"][end].as_f64().unwrap());
                let expected = frame.quantity(name).unwrap().values[grain];
                let found = from + (to - from) * value;
                assert!((found - expected).abs() <= 0.501 * (to - from) / 65_535.0, "{name}: {found} {expected}");
            }
        }
        // Force chains are the contacts above the mean, and their ends those of the lines.
        let lines = frame.contacts.unwrap();
        let mean = lines.iter().map(|line| line.normal_force).sum::<f64>() / lines.len().max(1) as f64;
        let strong: Vec<_> = lines.iter().filter(|line| line.normal_force >= mean && line.normal_force > 0.0).collect();
        let drawn = shorts(&arrays, &shown["contacts"]);
        assert_eq!(drawn.len(), 7 * strong.len());
        for (drawn, line) in drawn.chunks(7).zip(strong) {
            for (k, place) in line.ends.iter().flatten().enumerate() {
                assert!((low[k % 3] + span[k % 3] * drawn[k] - place).abs() <= 0.51 * span[k % 3] / 65_535.0 + 1e-9);
            }
        }
    }
    let radii = &head["radii"];
    assert_eq!(radii[1], 200);
    // Eight bytes per grain and frame, two for each further field; the box rests and is there once.
    assert_eq!(head["walls"].as_array().unwrap().len(), 1);
    assert_eq!(head["frames"][3]["state"][1], 4 * 200);
}

#[test]
fn what_is_too_large_is_left_out_and_said() {
    let folder = tempfile::tempdir().unwrap();
    let run = run(folder.path());
    let file = folder.path().join("view.html");
    let page = |wishes: Wishes| {
        let page = write(&file, &run, &wishes, &|_| {}).unwrap();
        (page, read(&std::fs::read_to_string(&file).unwrap()).0)
    };
    let (small, head) = page(Wishes { most_bytes: 9_000.0, ..wishes() });
    assert!(
        small.note.contains("Force chains are left out") && small.note.contains("One frame in 2"),
        "{}",
        small.note
    );
    assert_eq!(head["note"].as_str().unwrap(), small.note);
    assert_eq!(head["frames"].as_array().unwrap().len(), 2);
    assert!(head["frames"][0]["contacts"].is_null());
    // The last frame is always there.
    assert_eq!(head["frames"][1]["time"].as_f64().unwrap(), run.time(3));
    let (third, head) = page(Wishes { every: Some(3), contacts: false, ..wishes() });
    assert_eq!((third.frames, head["frames"].as_array().unwrap().len()), (2, 2));
    let unknown = Wishes { fields: vec!["sped".into()], ..wishes() };
    let message = write(&file, &run, &unknown, &|_| {}).unwrap_err().to_string();
    assert!(message.contains("sped") && message.contains("angular_velocity"), "{message}");
}

#[test]
fn a_page_shows_grains_that_come_and_go_with_their_own_radii_and_materials() {
    let folder = tempfile::tempdir().unwrap();
    let text = include_str!("../templates/stream.toml")
        .replace("radius = 0.07", "radius = 0.02")
        .replace("[solver]", "[material.other]\ndensity = 1000.0\nyoungs_modulus = 1e7\npoisson_ratio = 0.3\nfriction = 0.5\nrestitution = 0.3\n\
                 [[grain]]\nmaterial = \"other\"\nradius = 0.006\nposition = [0.1, 0.0, 0.0]\n[solver]");
    let scene = MeasuredScene::parse(&text).unwrap();
    let mut simulation = Simulation::new(&scene, 1).unwrap();
    let mut frames = StoreWriter::create(&folder.path().join(RunFiles::FRAMES), &scene).unwrap();
    for _ in 0..5 {
        frames.append(&simulation.snapshot()).unwrap();
        (0..200).for_each(|_| {
            simulation.step();
        });
    }
    assert!(simulation.passed()[1].grains > 10);
    let run = RunFrames::open(folder.path()).unwrap();
    let file = folder.path().join("view.html");
    write(&file, &run, &wishes(), &|_| {}).unwrap();
    let (head, arrays) = read(&std::fs::read_to_string(&file).unwrap());
    let fields = head["fields"].as_array().unwrap();
    let field = |title: &str| fields.iter().find(|field| field["title"] == title).unwrap();
    // The grain of the other material falls out before the last frame, and keeps its colour in the first.
    assert_eq!(field("material")["kinds"], serde_json::json!(["grain", "other"]));
    let of_material = field("material")["constant"].as_u64().unwrap() as usize;
    for number in 0..run.count() {
        let (frame, shown) = (run.read(number).unwrap(), &head["frames"][number]);
        let [start, count] = [0, 1].map(|part| shown["radii"][part].as_u64().unwrap() as usize);
        let radii =
            arrays[start..start + 4 * count].chunks(4).map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap()));
        assert!(radii.eq(frame.grains.radii.iter().map(|radius| *radius as f32)), "frame {number}");
        assert_eq!(shorts(&arrays, &shown["state"]).len(), 4 * count);
        let materials: Vec<f64> =
            shorts(&arrays, &shown["once"][of_material]).iter().map(|share| share * 65_535.0).collect();
        assert_eq!(materials, frame.quantity("material").unwrap().values, "frame {number}");
    }
    assert_eq!(run.read(0).unwrap().quantity("material").unwrap().values, [1.0]);
    assert!(run.read(4).unwrap().quantity("material").unwrap().values.iter().all(|material| *material == 0.0));
}
