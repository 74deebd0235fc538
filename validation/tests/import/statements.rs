//! Statements of files and manifests: what is missing is refused with its line, and so is what contradicts the scene.

use super::*;
use makadam_frames::import::unlike;
use std::path::PathBuf;

/// A scene of one grain of each of two materials, of one size.
fn two_materials() -> MeasuredScene {
    scene_of(&["m", "heavy"], "{ kind = 'fixed', value = 0.005 }")
}

/// A scene with one population of one grain for each name of a material.
fn scene_of(populations: &[&str], radius: &str) -> MeasuredScene {
    let material = |name: &str, density: f64| {
        format!(
            "[material.{name}]\ndensity = {density}\nyoungs_modulus = 1e7\npoisson_ratio = 0.3\nfriction = 0.5\nrestitution = 0.5\n"
        )
    };
    let population = |(place, name): (usize, &&str)| {
        format!(
            "[[population]]\ncount = 1\nmaterial = '{name}'\nradius = {radius}\nregion = {{ kind = 'box', min = [0.0, 0.0, {}], max = [0.05, 0.05, {}] }}\n",
            0.05 * place as f64,
            0.05 * place as f64 + 0.04
        )
    };
    let populations: String = populations.iter().enumerate().map(population).collect();
    let text = format!(
        "name = 'two'\nduration = 1.0\ngravity = [0, 0, -9.81]\ndomain = {{ min = [-0.01, -0.01, -0.01], max = [0.11, 0.11, 0.11] }}\n{}{}{populations}[measure]\nobservables = ['balances']\n",
        material("m", 2500.0),
        material("heavy", 20000.0)
    );
    MeasuredScene::parse(&text).unwrap()
}

fn read(scene: &MeasuredScene, files: &[(&str, String)], manifest: &Manifest) -> Result<Recording, String> {
    let found = tables(files, &[]).and_then(|tables| assemble(scene, manifest, &tables));
    found.map_err(|error| error.to_string())
}

fn kinds(pairs: &[(&str, &str)]) -> Manifest {
    let kinds = pairs.iter().map(|(value, name)| (value.to_string(), name.to_string())).collect();
    Manifest { kinds, ..stated() }
}

fn first_id(first: i64) -> Manifest {
    Manifest { first_id: Some(first), ..stated() }
}

/// Numbers of the grains of a frame.
fn ids(imported: &Recording, frame: usize) -> Vec<u32> {
    imported.frames[frame].particles.iter().map(|grain| grain.id).collect()
}

fn heights(imported: &Recording) -> Vec<f64> {
    imported.frames.iter().map(|frame| frame.particles[0].position[2]).collect()
}

#[test]
fn kinds_are_types() {
    let scene = two_materials();
    // The second grain is of the light material, and moves at 1 m/s: half of 2500 kg/m3 times its volume.
    let columns = "x y z vx vy vz omegax omegay omegaz radius";
    let rows = ["1 2 0.02 0.02 0.07 0 0 0 0 0 0 0.005", "2 1 0.02 0.02 0.02 1 0 0 0 0 0 0.005"];
    let file = [("g.dump", dump(&format!("id type {columns}"), &rows))];
    let error = read(&scene, &file, &stated()).unwrap_err();
    assert!(
        error.contains("g.dump: line 10")
            && error.contains("kinds = { 1 = \"KIND\", 2 = \"KIND\" }   # each KIND one of")
            && error.contains("heavy, m"),
        "{error}"
    );
    let energy = |imported: &Recording| {
        measure(&scene, imported).into_iter().find(|one| one.observable == "kinetic_energy").unwrap().value
    };
    let right = 0.5 * 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * 0.005_f64.powi(3);
    for given in [kinds(&[("1", "m"), ("2", "heavy")]), kinds(&[("1", "population.0"), ("2", "population.1")])] {
        let imported = read(&scene, &file, &given).unwrap();
        approx::assert_relative_eq!(energy(&imported), right, max_relative = 1e-12);
    }
    // Names of the scene's materials state themselves.
    let rows = rows.map(|row| row.replacen(" 2 ", " heavy ", 1).replacen(" 1 ", " m ", 1));
    let named = [("g.dump", dump(&format!("id material {columns}"), &rows.each_ref().map(String::as_str)))];
    approx::assert_relative_eq!(energy(&read(&scene, &named, &stated()).unwrap()), right, max_relative = 1e-12);
    let error = read(&scene, &file, &kinds(&[("1", "m")])).unwrap_err();
    assert!(error.contains("kinds = { 1 = \"KIND\", 2 = \"KIND\" }"), "{error}");
    let error = read(&scene, &file, &kinds(&[("1", "m"), ("2", "m")])).unwrap_err();
    assert!(error.contains("grain 2 is one more of its kind (material m"), "{error}");
    let error = kinds(&[("1", "glass")]).check(&scene).unwrap_err();
    assert!(error.contains("1=glass: the scene has no glass; it has heavy, m, population.0, population.1"), "{error}");
}

#[test]
fn numbers_state_grains_without_type() {
    let scene = two_materials();
    let rows = ["1 0.02 0.02 0.07 0.005", "2 0.02 0.02 0.02 0.005"];
    let file = [("g.dump", dump("id x y z radius", &rows))];
    let error = read(&scene, &file, &stated()).unwrap_err();
    assert!(error.contains("\n  first-id = NUMBER   # number of the scene's first grain"), "{error}");
    let heights =
        |imported: Recording| imported.frames[0].particles.iter().map(|grain| grain.position[2]).collect::<Vec<_>>();
    assert_eq!(heights(read(&scene, &file, &first_id(1)).unwrap()), [0.07, 0.02]);
    let error = read(&scene, &file, &first_id(0)).unwrap_err();
    assert!(error.contains("there is no grain 2: first-id states numbers from 0 to 1"), "{error}");
    let unnumbered = [("g.dump", dump("x y z radius", &["0.02 0.02 0.07 0.005", "0.02 0.02 0.02 0.005"]))];
    assert_eq!(heights(read(&scene, &unnumbered, &first_id(0)).unwrap()), [0.07, 0.02]);
    // Two populations of one material and size are told apart by nothing but what is stated.
    let twice = scene_of(&["m", "m"], "{ kind = 'fixed', value = 0.005 }");
    let typed = [("g.dump", dump("id type x y z radius", &["1 1 0 0 0.07 0.005", "2 2 0 0 0.02 0.005"]))];
    let error = read(&twice, &typed, &kinds(&[("1", "m"), ("2", "m")])).unwrap_err();
    assert!(error.contains("kinds = { 1 = ") && error.contains("population.0, population.1"), "{error}");
    assert_eq!(
        heights(read(&twice, &typed, &kinds(&[("2", "population.0"), ("1", "population.1")])).unwrap()),
        [0.02, 0.07]
    );
}

#[test]
fn radii_by_file_or_seed() {
    let drawn = scene_of(&["m", "m"], "{ kind = 'uniform', mean = 0.005, spread = 0.2 }");
    let file = [("g.dump", dump("id x y z v_diameter", &["1 0.05 0.05 0.02 0.0075", "2 0.05 0.0585 0.02 0.0095"]))];
    let first = first_id(1);
    let error = read(&drawn, &file, &first).unwrap_err();
    assert!(
        error.contains("\n  seed = NUMBER ")
            && error.contains("no column radius or diameter among id, x, y, z, v_diameter")
            && error.contains("0.004 to 0.006 m"),
        "{error}"
    );
    let placed = read(&drawn, &file, &Manifest { seed: Some(3), ..first }).unwrap();
    let own = makadam::scene::populate(&drawn, 3).unwrap();
    let found: Vec<f64> = placed.frames[0].particles.iter().map(|grain| grain.radius).collect();
    assert_eq!(found, own.iter().map(|grain| grain.radius).collect::<Vec<_>>());
    assert_eq!(placed.seed, 3);
    // One radius is what the scene states.
    let fixed = two_materials();
    let imported = read(&fixed, &file, &first_id(1)).unwrap();
    assert!(imported.frames[0].particles.iter().all(|grain| grain.radius == 0.005));
    assert!(imported.notes.contains(&"radii are those of the scene, 0.005 m".to_string()), "{:?}", imported.notes);
}

#[test]
fn boxes_of_dumps() {
    let mut scene = scene_of(&["m"], "{ kind = 'fixed', value = 0.005 }");
    let rows = ["1 0.01 0.05 0.05 0.005"];
    let file = |flags: &str, bounds: &str| [("g.dump", dump_in(flags, bounds, "id x y z radius", &rows))];
    let refused = |scene: &MeasuredScene, flags: &str, bounds: &str, words: &str| {
        let error = read(scene, &file(flags, bounds), &stated()).unwrap_err();
        assert!(error.contains(words), "{error}");
    };
    assert!(read(&scene, &file("ff fm ff", "0 0.12"), &stated()).is_ok());
    refused(
        &scene,
        "pp ff ff",
        "0 0.12",
        "periodic along x, with a length of 0.12 m, and the scene is not periodic along x",
    );
    scene.domain =
        serde_json::from_value(serde_json::json!({ "min": [0, 0, 0], "max": [0.1, 0.1, 0.1], "periodic": ["x"] }))
            .unwrap();
    refused(
        &scene,
        "pp ff ff",
        "0 0.12",
        "with a length of 0.12 m, and the scene is periodic along x, with a length of 0.1 m",
    );
    refused(&scene, "ff ff ff", "0 0.1", "its box is not periodic along x");
    refused(&scene, "xy xz yz pp ff ff", "0 0.1 0.01", "g.dump: line 6: the box is tilted");
    refused(&scene, "abc origin pp ff ff", "0.1 0.01 0 0", "g.dump: line 6: the box is tilted");
    refused(&scene, "pp ff ff", "0", "the bounds of the box belong here");
    // Six digits, another origin, no tilt; and a dump that states no boundaries.
    for (flags, bounds) in [("pp ff ff", "-0.0500001 0.05"), ("xy xz yz pp ff ff", "0 0.1 0"), ("", "0 0.12")] {
        assert!(read(&scene, &file(flags, bounds), &stated()).is_ok(), "{flags} {bounds}");
    }
}

#[test]
fn grains_that_leave_need_numbers() {
    let (scene, _) = packing();
    let frame =
        |time: usize, ids: &[i64]| ids.iter().map(|id| format!("{time},{id},0,0,{id},0.005\n")).collect::<String>();
    let text = format!("time,id,x,y,z,radius\n{}{}{}", frame(0, &[10, 11, 12]), frame(1, &[11, 12]), frame(2, &[12]));
    let imported = read(&scene, &[("f.csv", text.clone())], &stated()).unwrap();
    assert_eq!([0, 1, 2].map(|frame| ids(&imported, frame)), [vec![0, 1, 2], vec![1, 2], vec![2]]);
    let unnumbered = [("f.csv", text.replace("id,", "_,"))];
    let error = read(&scene, &unnumbered, &stated()).unwrap_err();
    assert!(error.contains("\n  first-id = 0   # each frame has the scene's grains row by row"), "{error}");
    let error = read(&scene, &unnumbered, &first_id(0)).unwrap_err();
    assert!(error.contains("first-id states that rows are the scene's grains, and there are 3 for 100"), "{error}");
}

/// Fifty grains of one size and fifty of another, two frames: numbers by `number`, in the order of `rows`.
fn two_kinds(number: &dyn Fn(usize) -> i64, rows: &dyn Fn(usize, usize) -> usize) -> Result<Recording, ImportError> {
    let (mut scene, _) = packing();
    let [population] = &mut scene.population[..] else { unreachable!("it has one population") };
    population.count = 50;
    let mut large = population.clone();
    large.radius = serde_json::from_value(serde_json::json!({ "kind": "fixed", "value": 0.02 })).unwrap();
    scene.population.push(large);
    let low = scene.population[0].radius.bounds().0;
    let mut text = String::from("time,id,x,y,z,r\n");
    for frame in 0..2 {
        for place in 0..100 {
            let grain = rows(frame, place);
            let radius = if grain < 50 { low } else { 0.02 };
            let _ = writeln!(text, "{},{},0,{frame},{grain},{radius}", 0.3 + 0.1 * frame as f64, number(grain));
        }
    }
    assembled(&scene, &tables(&[("a.csv", text)], &[]).unwrap())
}

/// Height of the grain with a number, which differs from row to row.
fn height(imported: &Recording, id: u32) -> f64 {
    let frame = imported.frames.last().unwrap();
    frame.particles.iter().find(|grain| grain.id == id).unwrap().position[2]
}

#[test]
fn sizes_state_kinds() {
    let back = |frame: usize, place: usize| if frame == 0 { place } else { 99 - place };
    for number in [&|grain| grain as i64, &|grain| grain as i64 + 1, &|grain| grain as i64 * 3 + 1000]
        as [&dyn Fn(usize) -> i64; 3]
    {
        let imported = two_kinds(number, &back).unwrap();
        assert_eq!([0, 49, 50, 99].map(|id| height(&imported, id)), [0.0, 49.0, 50.0, 99.0]);
        assert!(imported.notes.is_empty(), "{:?}", imported.notes);
    }
    // Counted down: the large ones come first, and are the second population all the same.
    let imported = two_kinds(&|grain| 99 - grain as i64, &|_, place| place).unwrap();
    assert_eq!([0, 49, 50, 99].map(|id| height(&imported, id)), [49.0, 0.0, 99.0, 50.0]);
}

#[test]
fn sizes_state_listed_grains() {
    let (mut scene, _) = packing();
    scene.population[0].count = 3;
    scene.grain = vec![
        serde_json::from_value(serde_json::json!({ "material": "grain", "radius": 0.02, "position": [0, 0, 0.1] }))
            .unwrap(),
    ];
    let small = scene.population[0].radius.bounds().0;
    let read = |rows: &[(i64, f64)], first_id: Option<i64>| {
        let row = |(id, radius): &(i64, f64)| format!("{id},0,0,{id},{radius}\n");
        let text = format!("id,x,y,z,r\n{}", rows.iter().map(row).collect::<String>());
        assemble(&scene, &Manifest { first_id, ..at(0.6) }, &tables(&[("a.csv", text)], &[]).unwrap())
    };
    let ids = |imported: Recording| imported.frames[0].particles.iter().map(|grain| grain.id).collect::<Vec<_>>();
    assert_eq!(ids(read(&[(1, small), (2, small), (3, small)], None).unwrap()), [1, 2, 3], "the listed one has left");
    assert_eq!(ids(read(&[(1, 0.02), (2, small), (3, small)], None).unwrap()), [0, 1, 2]);
    assert_eq!(ids(read(&[(0, small), (1, small), (2, small), (1000, 0.02)], None).unwrap()), [0, 1, 2, 3]);
    // Where numbers are stated to be the scene's, a radius that contradicts them is refused.
    let error = read(&[(1, small), (2, small)], Some(1)).unwrap_err().to_string();
    assert!(error.contains("a.csv: line 2: grain 1 has a radius of"), "{error}");
    let error = read(&[(1, 0.5)], None).unwrap_err().to_string();
    assert!(error.contains("grain 1 has a radius of 0.5 m, and the scene has no such grain"), "{error}");
}

/// A frame without grains has no columns in legacy VTK: the others keep their velocities and radii.
#[test]
fn frames_without_grains_state_nothing() {
    let scene = scene_of(&["m"], "{ kind = 'uniform', mean = 0.005, spread = 0.2 }");
    let empty = "# vtk DataFile Version 5.1\nx\nASCII\nDATASET POLYDATA\nPOINTS 0 float\n";
    let full = "time,id,x,y,z,r,vx,vy,vz\n0.4,1,0,0,0,0.005,1,0,0\n";
    let mut tables = tables(&[("a.vtk", empty.into()), ("b.csv", full.into())], &[]).unwrap();
    tables.grains[0].time = Some(0.3);
    let recording = assembled(&scene, &tables).unwrap();
    assert_eq!(recording.frames.iter().map(|frame| frame.particles.len()).collect::<Vec<_>>(), [0, 1]);
    assert_eq!(recording.frames[1].particles[0].radius, 0.005);
    assert!(!recording.lacks.contains(&Content::Velocities), "{:?}", recording.lacks);
}

#[test]
fn grains_keep_size_and_kind() {
    let scene = scene_of(&["m", "m"], "{ kind = 'uniform', mean = 0.005, spread = 0.2 }");
    let text = |second: &str| format!("time,id,x,y,z,r,material\n0.3,1,0,0,0,0.005,m\n0.4,1,0,0,0,{second}\n");
    for (second, words) in [
        ("0.0055,m", "grain 1 has a radius of 0.0055 m, and had one of 0.005 m before"),
        ("0.005,heavy", "grain 1 is of heavy, and was of m before"),
    ] {
        let error = read(&scene, &[("a.csv", text(second))], &stated()).unwrap_err();
        assert!(error.starts_with("a.csv: line 3: ") && error.contains(words), "{error}");
    }
    let error = read(&scene, &[("a.csv", "id,x,y,z,r\n1,0,0,0,5\n".into())], &at(0.6)).unwrap_err();
    assert!(
        error.contains("grain 1 has a radius of 5 m, and the scene has no such grain: it has 0.004 to 0.006 m"),
        "{error}"
    );
}

#[test]
fn periodic_images() {
    let (mut scene, _) = packing();
    scene.domain = serde_json::from_value(
        serde_json::json!({ "min": [-0.1, -0.1, 0.0], "max": [0.1, 0.1, 1.0], "periodic": ["x"] }),
    )
    .unwrap();
    // What lies inside keeps its bits.
    let text = "id,x,y,z,r\n0,0.35,0.05,0.5,0.005\n1,-0.72,0.05,0.5,0.005\n2,0.05,0.35,0.5,0.005\n";
    let imported = assemble(&scene, &at(0.6), &tables(&[("a.csv", text.into())], &[]).unwrap()).unwrap();
    let frame = &imported.frames[0];
    for (grain, x) in frame.particles.iter().zip([-0.05, 0.08, 0.05]) {
        assert!((grain.position[0] - x).abs() < 1e-12, "{grain:?}");
    }
    assert_eq!(frame.particles[2].position, [0.05, 0.35, 0.5]);
    let notes = unlike(&scene, imported.frames.iter());
    let left = notes.iter().find(|note| note.contains("outside the domain")).unwrap();
    assert!(left.contains("1 of 3 grains lie") && left.contains("grain 2 at [0.05, 0.35, 0.5] m"), "{left}");
}

#[test]
fn columns_have_one_meaning() {
    let file = PathBuf::from("a.csv");
    let added = |text: &str, columns: &[&str]| {
        let columns = if columns.is_empty() { StatedColumns::default() } else { columns.join(",").parse().unwrap() };
        parse(&file, text.as_bytes().to_vec(), &columns).map_err(|error| error.to_string()).err().unwrap_or_default()
    };
    let twice = "id,x,y,z,r,X\n1,0,0,0,1,2\n";
    let error = added(twice, &[]);
    assert!(error.contains("a.csv: line 1: two columns have one meaning, x and X"), "{error}");
    assert!(
        added("id,x,y,z,r\n1,0,0,0,1\n", &["id", "x", "y", "z", "x"]).contains("two columns have one meaning, x and x")
    );
    let names = ["id", "x", "y", "z", "vx", "velocity_x", "radius", "diameter"];
    let errors = [&names[..6], &[names[0], names[1], names[2], names[3], names[6], names[7]]].map(|names| {
        let row = vec!["1"; names.len()].join(",");
        added(&format!("{}\n{row}\n", names.join(",")), &[])
    });
    assert!(errors[0].contains("two columns have one meaning, vx and velocity_x"), "{}", errors[0]);
    assert!(errors[1].contains("two columns have one meaning, radius and diameter"), "{}", errors[1]);
    assert!(added("time,Time,x\n1,0,0\n", &[]).contains("two columns have one meaning, time and Time"));
    // A temperature, or a time of another clock, has no meaning by its name.
    assert_eq!(added("time,t,T,x\n1,0,300,0\n", &[]), "");
    // Named anew, each once; what means nothing may be there twice.
    assert_eq!(added(twice, &["id", "x", "y", "z", "r", "_"]), "");
    assert_eq!(added("id,x,y,z,r,mass,mass\n1,0,0,0,1,2,2\n", &[]), "");
}

#[test]
fn fewer_grains_are_noted() {
    let (scene, _) = packing();
    let grains = |text: &str| tables(&[("a.csv", format!("time,id,x,y,z,r\n{text}"))], &[]).unwrap();
    let notes = |text: &str| assembled(&scene, &grains(text)).unwrap().notes;
    assert_eq!(
        notes("0.3,1,0,0,0,0.005\n0.4,1,0,0,0,0.005\n0.4,2,0,0,0,0.005\n"),
        ["the frames have 1 to 2 grains, and the scene has 100: these are measured"]
    );
    let all: String = (0..100).map(|id| format!("0.3,{id},0,0,{id},0.005\n")).collect();
    assert!(notes(&all).is_empty());
}

#[test]
fn frames_have_times_of_their_own() {
    let (scene, _) = packing();
    let at = |name: &'static str, height: usize| (name, format!("time,id,x,y,z,r\n0.5,1,0,0,{height},0.005\n"));
    let imported = read(&scene, &[at("a.csv", 3), at("b.csv", 3)], &stated()).unwrap();
    assert_eq!(heights(&imported), [3.0]);
    assert!(imported.notes.contains(&"1 frames are the same as another one at their time".to_string()));
    let error = read(&scene, &[at("a.csv", 3), at("b.csv", 4)], &stated()).unwrap_err();
    assert!(error.contains("b.csv: line 2: it has a frame at 0.5 s, as a.csv has (line 2)"), "{error}");
    let rows = |step: usize, count: usize| {
        (0..count).map(|grain| format!("{step},{grain},0,0,{grain},0.005\n")).collect::<String>()
    };
    let frames = |head: &str, count: usize| {
        let text = format!("{head},id,x,y,z,r\n{}{}", rows(1000, count), rows(1500, count));
        read(&scene, &[("a.csv", text)], &stated())
    };
    let times: Vec<f64> = frames("step", 100).unwrap().frames.iter().map(|frame| frame.time).collect();
    assert_eq!(times, [1000.0, 1500.0].map(|step| step * (INTERVAL / STEPS as f64)));
    let error = frames("step", 101).unwrap_err();
    assert!(error.contains("a frame has 101 grains, and the scene has 100"), "{error}");
}

/// Writes files, reads them by a manifest, and gives heights or the error.
fn by_manifest(files: &[&str], text: &str) -> Result<Vec<f64>, String> {
    let folder = tempfile::tempdir().unwrap();
    for (height, file) in files.iter().enumerate() {
        std::fs::write(folder.path().join(file), format!("id,x,y,z,r\n1,0,0,{height},0.005\n")).unwrap();
    }
    let read = || {
        let manifest = Manifest::parse(&folder.path().join("m.toml"), text)?;
        assemble(&packing().0, &manifest, &Tables::read(&manifest)?)
    };
    read().map(|imported| heights(&imported)).map_err(|error| error.to_string())
}

#[test]
fn names_state_steps_and_times() {
    let counted = ["f_9.csv", "f_10.csv", "f_101.csv"];
    assert_eq!(by_manifest(&counted, "grains = ['f_{step}.csv']\ntime-step = 0.1"), Ok(vec![0.0, 1.0, 2.0]));
    let timed = ["f_0.05.csv", "f_0.1.csv", "f_2e-1.csv", "f_last.csv"];
    assert_eq!(by_manifest(&timed, "grains = ['f_{time}.csv']"), Ok(vec![0.0, 1.0, 2.0]));
    let refused = |files: &[&str], text: &str, words: &str| {
        let error = by_manifest(files, text).unwrap_err();
        assert!(error.contains(words), "{error}");
    };
    refused(&counted, "grains = ['f_*.csv']", "\n  grains = [\"f_{step}.csv\"]   # the number of a step, or {time}");
    refused(&counted, "grains = ['f_*.csv']", "\n  time-step = SECONDS   #");
    refused(&counted[..1], "grains = ['f_9.csv']", "\n  time = SECONDS   # time of the only frame");
    refused(
        &counted,
        "grains = ['f_{step}.csv']\ntime = 1.0",
        "time states the time of one frame, and the files have 3",
    );
    refused(&counted, "grains = ['f_{step}_*.csv']", "f_{step}_*.csv: line 1: there is no file of this pattern");
    refused(&["g_1.csv"], "grains = ['f_{step}.csv']", "f_{step}.csv: line 1: there is no file of this pattern");
    refused(&["g_1.csv"], "grains = ['g_1.csv', 'g_1.csv']\ntime = 1", "the file is given twice");
    refused(&["g_1.csv"], "grains = ['g_1.csv']\ntimestep = 1", "m.toml: line 2: unknown field `timestep`");
    refused(&["g_1.csv"], "grains = []", "m.toml: line 1: grains names no file");
    refused(&["g_1.csv"], "grains = ['g_1.csv']\ntime-step = 0.0", "time-step is a time above zero");
    refused(&["g_1.csv"], "grains = ['g_2.csv']\ntime = 1", "g_2.csv: line 1: ");
}

#[test]
fn all_missing_statements_at_once() {
    let scene = two_materials();
    let grains = ["1 2 0.02 0.02 0.07", "2 1 0.02 0.02 0.02"];
    let contacts =
        dump("c_p[1] c_p[2] c_p[3] c_p[4] c_p[5] c_p[6]", &["1 2 0 1 0 0"]).replace("ATOMS c_p", "ENTRIES c_p");
    let error =
        refusal(&scene, &Manifest::default(), &[("g.dump", dump("id type x y z", &grains))], &[("c.dump", contacts)]);
    for line in
        ["contact-columns.c_p = [\"first\"", "contacts-complete = true", "time-step = SECONDS", "kinds = { 1 = "]
    {
        assert!(error.contains(&format!("\n  {line}")), "{line}: {error}");
    }
}

#[test]
fn columns_of_grains() {
    let (scene, _) = packing();
    let refused = |text: &str, words: &str| {
        let error = read(&scene, &[("a.csv", text.into())], &at(0.6)).unwrap_err();
        assert!(error.contains(words), "{error}");
    };
    refused("", "a.csv: line 1: the file is empty");
    refused("1,2,3,4\n", "the first row must name the columns");
    refused("x,y,z,r\n0,0,0,1\n0,0,nan,1\n", "a.csv: line 3: column z: 'nan' is not finite");
    refused("x,y,z,r\r\n0,0,0,1\r\n0,0,1\r\n", "a.csv: line 3:");
    refused("x,y,r\n0,0,0.005\n", "no columns x, y, z among x, y, r");
    refused("id,x,y,z,r\n1,0,0,0,0.005\n1,0,0,0,0.005\n", "two grains of a frame have one number");
    refused("id,x,y,z,r\n1.5,0,0,0,0.005\n", "1.5 is not the number of a grain");
}

#[test]
fn lists_of_column_names() {
    let read = |text: &str| text.parse::<StatedColumns>();
    let text = dump("c_pairs[1] id c_pairs[2]", &["1 2 3"]);
    let columns = |stated: &StatedColumns| {
        parse(Path::new("a"), text.clone().into_bytes(), stated).map(|mut frames| frames.remove(0).columns)
    };
    let pairs = read("c_pairs:first,second").unwrap();
    assert_eq!(columns(&pairs).unwrap(), ["first", "id", "second"]);
    let joined = StatedColumns::joined([pairs, read("c_walls:wall,first").unwrap(), read("x, y,c_pairs[2]").unwrap()]);
    assert!(columns(&joined).unwrap_err().problem.contains("1 columns c_pairs[...], and 2 are named"));
    assert_eq!(columns(&read("Points:0,Points:1,_").unwrap()).unwrap(), ["Points:0", "Points:1"]);
    assert!(read("id,,x").unwrap_err().contains("write _"));
    assert!(columns(&read("x,y").unwrap()).unwrap_err().problem.contains("3 numbers, and 2 columns are named"));
}

#[cfg(unix)]
#[test]
fn links_to_files_count_once() {
    let folder = tempfile::tempdir().unwrap();
    let [file, link] = ["walls.csv", "latest.csv"].map(|name| folder.path().join(name));
    std::fs::write(&file, "first,wall,fx,fy,fz,px,py,pz\n").unwrap();
    std::os::unix::fs::symlink(&file, &link).unwrap();
    let (pattern, manifest) = ("*".into(), Manifest::default());
    let mut tables = Tables::default();
    tables.add(true, &file, &pattern, &manifest).unwrap();
    let error = tables.add(true, &link, &pattern, &manifest).unwrap_err().to_string();
    assert!(error.contains("the file is given twice"), "{error}");
}
