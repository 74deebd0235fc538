//! Exported files: the structure that their readers ask for, and the numbers of the frames.

use hdf5_pure::File;
use makadam::Simulation;
use makadam_frames::export::write;
use makadam_frames::output::RunFiles;
use makadam_frames::plan::{FrameFormat, MeasuredScene};
use makadam_frames::run_frames::{Kind, RunFrames, StoreWriter};
use std::path::Path;

const FRAMES: usize = 3;

/// The small scene with a lid that moves.
fn run(folder: &Path) -> RunFrames {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenes/smoke.toml");
    let lid = "[[wall]]\nname = \"lid\"\nmaterial = \"wall\"\nshape = { kind = \"disc\", centre = [0.0, 0.0, 0.29], \
               normal = [0.0, 0.0, -1.0], radius = 0.01 }\nmotion = { kind = \"translating\", velocity = [0.0, 0.0, -0.1] }\n[[population]]";
    let scene =
        MeasuredScene::parse(&std::fs::read_to_string(file).unwrap().replacen("[[population]]", lid, 1)).unwrap();
    let mut simulation = Simulation::builder(&scene).time_step(1e-3).build().unwrap();
    let mut frames = StoreWriter::create(&folder.join(RunFiles::FRAMES), &scene).unwrap();
    for _ in 0..FRAMES {
        frames.append(&simulation.snapshot()).unwrap();
        (0..80).for_each(|_| {
            simulation.step();
        });
    }
    RunFrames::open(folder).unwrap()
}

#[test]
fn a_vtkhdf_file_says_where_each_frame_begins() {
    let folder = tempfile::tempdir().unwrap();
    let run = run(folder.path());
    let written = write(FrameFormat::Vtkhdf, &run, folder.path(), &|_| {}).unwrap();
    assert!(written.iter().map(|written| written.frames).eq([FRAMES; 3]), "{written:?}");
    for kind in Kind::ALL {
        let path = folder.path().join(format!("{}.vtkhdf", kind.name()));
        let file = File::open(&path).unwrap();
        let whole = |name: &str| file.dataset(&format!("VTKHDF/{name}")).unwrap().read_i64().unwrap();
        let (points, starts) = (whole("NumberOfPoints"), whole("Steps/PointOffsets"));
        let times = file.dataset("VTKHDF/Steps/Values").unwrap().read_f64().unwrap();
        let coordinates = file.dataset("VTKHDF/Points").unwrap().read_f32().unwrap();
        assert_eq!(coordinates.len() as i64, 3 * points.iter().sum::<i64>());
        let topology = ["Vertices", "Lines", "Polygons"][kind as usize];
        let (cells, offsets) = (whole(&format!("{topology}/NumberOfCells")), whole(&format!("{topology}/Offsets")));
        // One more offset than cells in each frame.
        assert_eq!(offsets.len() as i64, cells.iter().sum::<i64>() + FRAMES as i64);
        assert_eq!(whole("Strips/Offsets"), [0; FRAMES]);
        for number in 0..FRAMES {
            let frame = run.read(number).unwrap();
            assert_eq!(times[number], frame.time);
            let own: Vec<[f64; 3]> = match kind {
                Kind::Grains => frame.grains.positions.clone(),
                Kind::Contacts => frame.contacts.iter().flatten().flat_map(|line| line.ends).collect(),
                Kind::Walls => frame.walls.as_ref().unwrap().points.clone(),
            };
            assert_eq!(points[number], own.len() as i64);
            let first = 3 * starts[number] as usize;
            let stored = coordinates[first..first + 3 * own.len()].iter().copied();
            assert!(stored.eq(own.into_iter().flatten().map(|place| place as f32)), "{kind:?}, frame {number}");
        }
        if kind == Kind::Grains {
            let speeds = file.dataset("VTKHDF/PointData/speed").unwrap().read_f32().unwrap();
            assert_eq!(speeds.len(), 200 * FRAMES);
            assert_eq!(file.dataset("VTKHDF/PointData/stress").unwrap().shape().unwrap(), [200 * FRAMES as u64, 6]);
            let last = run.read(2).unwrap().quantity("speed").unwrap().values;
            assert!(speeds[400..].iter().map(|speed| f64::from(*speed)).eq(last));
        }
    }
}

/// The numbers of a chunk of a frame of a GSD file.
fn chunk(bytes: &[u8], frame: u64, wanted: &str) -> Option<Vec<f64>> {
    let long = |place: usize| u64::from_le_bytes(bytes[place..place + 8].try_into().unwrap());
    let (index, entries, names) = (long(8) as usize, long(16) as usize, long(24) as usize);
    let names: Vec<&[u8]> = bytes[names..].split(|byte| *byte == 0).collect();
    let at = (0..entries).map(|entry| index + 32 * entry).find(|at| {
        let name = u16::from_le_bytes(bytes[at + 28..at + 30].try_into().unwrap());
        long(*at) == frame && names[usize::from(name)] == wanted.as_bytes()
    })?;
    let columns = u32::from_le_bytes(bytes[at + 24..at + 28].try_into().unwrap()) as usize;
    let (count, place) = (long(at + 8) as usize * columns, long(at + 16) as usize);
    Some(match bytes[at + 30] {
        3 => bytes[place..place + 4 * count]
            .chunks(4)
            .map(|bytes| f64::from(u32::from_le_bytes(bytes.try_into().unwrap())))
            .collect(),
        4 => (0..count).map(|number| long(place + 8 * number) as f64).collect(),
        10 => (0..count).map(|number| f64::from_bits(long(place + 8 * number))).collect(),
        9 => bytes[place..place + 4 * count]
            .chunks(4)
            .map(|bytes| f64::from(f32::from_le_bytes(bytes.try_into().unwrap())))
            .collect(),
        kind => panic!("{wanted} is of kind {kind}"),
    })
}

#[test]
fn a_gsd_file_has_the_period_of_the_scene_and_the_steps_of_its_frames() {
    let folder = tempfile::tempdir().unwrap();
    let text = r#"
        name = "repeated"
        description = "two grains that almost meet across the end of the domain"
        duration = 1.0
        gravity = [0.0, 0.0, 0.0]
        domain = { min = [0.0, -0.03, 0.0], max = [0.1, 0.03, 0.2], periodic = ["x", "y"] }
        [material.glass]
        density = 2500.0
        youngs_modulus = 1e7
        poisson_ratio = 0.3
        friction = 0.5
        restitution = 0.5
        [[grain]]
        material = "glass"
        radius = 0.005
        position = [0.002, 0.0, 0.1]
        [[grain]]
        material = "glass"
        radius = 0.005
        position = [0.0915, 0.0, 0.1]
        [solver]
        step = 1e-3
    "#;
    let scene = MeasuredScene::parse(text).unwrap();
    let mut simulation = Simulation::builder(&scene).time_step(1e-3).build().unwrap();
    let mut frames = StoreWriter::create(&folder.path().join(RunFiles::FRAMES), &scene).unwrap();
    for _ in 0..2 {
        frames.append(&simulation.snapshot()).unwrap();
        (0..40).for_each(|_| {
            simulation.step();
        });
    }
    let run = RunFrames::open(folder.path()).unwrap();
    let frame = run.read(1).unwrap();
    assert_eq!(frame.repeats.unwrap()[0], [0.1, 0.06, 0.0]);
    write(FrameFormat::Gsd, &run, folder.path(), &|_| {}).unwrap();
    let bytes = std::fs::read(folder.path().join("grains.gsd")).unwrap();
    let cell = chunk(&bytes, 0, "configuration/box").unwrap();
    assert!((cell[0] - 0.1).abs() < 1e-8 && (cell[1] - 0.06).abs() < 1e-8 && (cell[2] - 0.02).abs() < 1e-8, "{cell:?}");
    // All grains lie in the box about its middle.
    let places = chunk(&bytes, 0, "particles/position").unwrap();
    assert!((places[0] + 0.048).abs() < 1e-8 && (places[3] - 0.0415).abs() < 1e-8, "{places:?}");
    assert_eq!([0, 1].map(|frame| chunk(&bytes, frame, "configuration/step").unwrap()[0]), [0.0, 40.0]);
    assert_eq!(chunk(&bytes, 0, "particles/mass").map(|masses| masses.len()), Some(2));
}

#[test]
fn a_gsd_file_has_the_layout_of_its_schema() {
    let folder = tempfile::tempdir().unwrap();
    let run = run(folder.path());
    assert_eq!(write(FrameFormat::Gsd, &run, folder.path(), &|_| {}).unwrap()[0].frames, FRAMES);
    let bytes = std::fs::read(folder.path().join("grains.gsd")).unwrap();
    let long = |place: usize| u64::from_le_bytes(bytes[place..place + 8].try_into().unwrap());
    assert_eq!(long(0), 0x65df_65df_65df_65df);
    let (index, entries, names, blocks) = (long(8) as usize, long(16) as usize, long(24) as usize, long(32) as usize);
    assert!(bytes[48..].starts_with(b"Makadam ") && bytes[112..].starts_with(b"hoomd\0"));
    assert_eq!(bytes.len(), names + 64 * blocks);
    let names: Vec<&str> =
        bytes[names..].split(|byte| *byte == 0).map(|name| std::str::from_utf8(name).unwrap()).collect();
    let frame = run.read(1).unwrap();
    let mut seen = 0;
    let mut before = (0, 0);
    for entry in 0..entries {
        let at = index + 32 * entry;
        let (of, rows, place) = (long(at), long(at + 8) as usize, long(at + 16) as usize);
        let columns = u32::from_le_bytes(bytes[at + 24..at + 28].try_into().unwrap()) as usize;
        let name = u16::from_le_bytes(bytes[at + 28..at + 30].try_into().unwrap());
        // Readers search the index by halves.
        assert!(entry == 0 || (of, name) > before, "the index is not in order");
        before = (of, name);
        if of == 1 && names[usize::from(name)] == "particles/diameter" {
            assert_eq!((rows, columns), (200, 1));
            let diameters =
                bytes[place..place + 800].chunks(4).map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap()));
            assert!(diameters.zip(&frame.grains.radii).all(|(diameter, radius)| diameter == (2.0 * radius) as f32));
            seen += 1;
        }
        if of == 1 && names[usize::from(name)] == "particles/position" {
            assert_eq!((rows, columns), (200, 3));
            seen += 1;
        }
    }
    assert_eq!(seen, 2);
}

#[test]
fn exports_hold_poses_of_driven_walls() {
    let folder = tempfile::tempdir().unwrap();
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenes/smoke.toml");
    let lid = "[[wall]]\nname = \"lid\"\nmaterial = \"wall\"\nshape = { kind = \"disc\", centre = [0.0, 0.0, 0.29], \
               normal = [0.0, 0.0, -1.0], radius = 0.01 }\n\
               motion = { kind = \"force-driven\", axis = [0.0, 0.0, -1.0], force = 1.0, mass = 1.0 }\n[[population]]";
    let scene =
        MeasuredScene::parse(&std::fs::read_to_string(file).unwrap().replacen("[[population]]", lid, 1)).unwrap();
    let mut simulation = Simulation::builder(&scene).time_step(1e-3).build().unwrap();
    let mut frames = StoreWriter::create(&folder.path().join(RunFiles::FRAMES), &scene).unwrap();
    let mut poses = Vec::new();
    for _ in 0..FRAMES {
        let frame = simulation.snapshot();
        poses.extend(frame.driven_walls.clone());
        frames.append(&frame).unwrap();
        (0..20).for_each(|_| {
            simulation.step();
        });
    }
    assert!(poses.len() == FRAMES && poses[2].displacement > 1e-4, "{poses:?}");
    let run = RunFrames::open(folder.path()).unwrap();
    let [gsd, hdf] = ["grains.gsd", "grains.vtkhdf"].map(|name| folder.path().join(name));
    for format in [FrameFormat::Gsd, FrameFormat::Vtkhdf] {
        write(format, &run, folder.path(), &|_| {}).unwrap();
    }
    let (bytes, hdf) = (std::fs::read(&gsd).unwrap(), File::open(&hdf).unwrap());
    let of_hdf = |name: &str| hdf.dataset(&format!("VTKHDF/{name}")).unwrap().read_f64().unwrap();
    assert_eq!(of_hdf("Steps/FieldDataSizes/driven_wall"), [1.0; 2 * FRAMES]);
    for (number, pose) in poses.iter().enumerate() {
        let values = [f64::from(pose.wall), pose.displacement, pose.rate];
        for (name, value) in ["driven_wall", "driven_wall_displacement", "driven_wall_rate"].iter().zip(values) {
            assert_eq!(chunk(&bytes, number as u64, &format!("log/{name}")), Some(vec![value]));
            let first = of_hdf(&format!("Steps/FieldDataOffsets/{name}"))[number] as usize;
            assert_eq!(of_hdf(&format!("FieldData/{name}"))[first], value);
        }
    }
}

#[test]
fn a_csv_file_starts_another_scene() {
    let folder = tempfile::tempdir().unwrap();
    let run = run(folder.path());
    let written = write(FrameFormat::Csv, &run, folder.path(), &|_| {}).unwrap();
    assert!(written.iter().map(|written| written.frames).eq([FRAMES]), "{written:?}");
    let text = std::fs::read_to_string(folder.path().join("csv/grains-00002.csv")).unwrap();
    assert_eq!(text.lines().count(), 201);
    // The scene of the run, with these grains instead of its population.
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenes/smoke.toml");
    let mut scene: toml::Table = toml::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
    scene.remove("population");
    scene.insert("start".into(), toml::from_str::<toml::Value>("file = 'csv/grains-00002.csv'").unwrap());
    scene.insert("largest_start_overlap".into(), toml::Value::Float(0.1));
    let scene = MeasuredScene::parse_in(&toml::to_string(&scene).unwrap(), folder.path()).unwrap();
    let grains = makadam::scene::populate(&scene, 1).unwrap();
    let last = run.snapshot(2).unwrap();
    assert_eq!(grains.len(), 200);
    for (grain, particle) in grains.iter().zip(&last.particles) {
        assert_eq!((grain.position, grain.velocity, grain.spin), (particle.position, particle.velocity, particle.spin));
        assert_eq!((grain.radius, grain.material.as_str()), (particle.radius, "grain"));
    }
}
