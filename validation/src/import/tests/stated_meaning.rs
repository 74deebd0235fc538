//! Kinds, radii, boxes and numbers of grains are what the files or the caller state, or the files are refused.

use super::*;

/// A scene of one grain of each of two materials, of one size.
fn two_materials() -> Scene {
    scene_of(&["m", "heavy"], "{ kind = 'fixed', value = 0.005 }")
}

/// A scene with one population of one grain for each name of a material.
fn scene_of(populations: &[&str], radius: &str) -> Scene {
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
    Scene::parse(&text).unwrap()
}

fn dump(columns: &str, rows: &[&str]) -> String {
    dump_in("ff ff ff", "0 0.1", columns, rows)
}

fn dump_in(flags: &str, bounds: &str, columns: &str, rows: &[&str]) -> String {
    format!(
        "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n{}\nITEM: BOX BOUNDS {flags}\n{bounds}\n{bounds}\n{bounds}\nITEM: ATOMS {columns}\n{}\n",
        rows.len(),
        rows.join("\n")
    )
}

fn read(scene: &Scene, files: &[(&str, String)], given: &Stated) -> Result<Imported, String> {
    let found = tables(files, &[]).map_err(|error| error.to_string())?;
    stated(scene, &found, given).map_err(|error| error.to_string())
}

fn kinds(pairs: &[(&str, &str)]) -> Stated {
    let kinds = pairs.iter().map(|(value, name)| (value.to_string(), name.to_string())).collect();
    Stated { kinds, ..Stated::default() }
}

#[test]
fn the_kind_of_a_grain_is_its_type_and_not_its_number() {
    let scene = two_materials();
    // The second grain is of the light material, and moves at 1 m/s: half of 2500 kg/m3 times its volume.
    let columns = "x y z vx vy vz omegax omegay omegaz radius";
    let rows = ["1 2 0.02 0.02 0.07 0 0 0 0 0 0 0.005", "2 1 0.02 0.02 0.02 1 0 0 0 0 0 0.005"];
    let file = [("g.dump", dump(&format!("id type {columns}"), &rows))];
    let error = read(&scene, &file, &Stated::default()).unwrap_err();
    assert!(
        error.contains("g.dump: line 10")
            && error.contains("add --kinds 1=MATERIAL,2=MATERIAL")
            && error.contains("heavy, m"),
        "{error}"
    );
    let energy = |imported: &Imported| {
        measure(&scene, &imported.recording).into_iter().find(|one| one.observable == "kinetic_energy").unwrap().value
    };
    let right = 0.5 * 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * 0.005_f64.powi(3);
    for given in [kinds(&[("1", "m"), ("2", "heavy")]), kinds(&[("1", "population.0"), ("2", "population.1")])] {
        let imported = read(&scene, &file, &given).unwrap();
        approx::assert_relative_eq!(energy(&imported), right, max_relative = 1e-12);
    }
    // Names of the scene's materials state themselves.
    let rows = rows.map(|row| row.replacen(" 2 ", " heavy ", 1).replacen(" 1 ", " m ", 1));
    let named = [("g.dump", dump(&format!("id material {columns}"), &rows.each_ref().map(String::as_str)))];
    approx::assert_relative_eq!(
        energy(&read(&scene, &named, &Stated::default()).unwrap()),
        right,
        max_relative = 1e-12
    );
    let error = read(&scene, &file, &kinds(&[("1", "m")])).unwrap_err();
    assert!(error.contains("does not state what its value 2 is"), "{error}");
    let error = read(&scene, &file, &kinds(&[("1", "m"), ("2", "m")])).unwrap_err();
    assert!(error.contains("grain 2 is one more of its kind (material m"), "{error}");
    let error = check_kinds(&scene, &kinds(&[("1", "glass")]).kinds).unwrap_err();
    assert!(error.contains("1=glass: the scene has no glass; it has heavy, m, population.0, population.1"), "{error}");
}

#[test]
fn grains_without_a_type_are_told_apart_by_stated_numbers_or_by_radius() {
    let scene = two_materials();
    let rows = ["1 0.02 0.02 0.07 0.005", "2 0.02 0.02 0.02 0.005"];
    let file = [("g.dump", dump("id x y z radius", &rows))];
    let error = read(&scene, &file, &Stated::default()).unwrap_err();
    assert!(error.contains("does not state which grain 1 is") && error.contains("--first-id NUMBER"), "{error}");
    let first = |first_id| Stated { first_id: Some(first_id), ..Stated::default() };
    let heights = |imported: Imported| {
        imported.recording.frames[0].particles.iter().map(|grain| grain.position[2]).collect::<Vec<_>>()
    };
    assert_eq!(heights(read(&scene, &file, &first(1)).unwrap()), [0.07, 0.02]);
    let error = read(&scene, &file, &first(0)).unwrap_err();
    assert!(error.contains("there is no grain 2: the scene's grains are numbered from 0 to 1"), "{error}");
    let unnumbered = [("g.dump", dump("x y z radius", &["0.02 0.02 0.07 0.005", "0.02 0.02 0.02 0.005"]))];
    let error = read(&scene, &unnumbered, &first(0)).unwrap_err();
    assert!(error.contains("there is no column id"), "{error}");
    // Two populations of one material and size are told apart by nothing but what is stated.
    let twice = scene_of(&["m", "m"], "{ kind = 'fixed', value = 0.005 }");
    let typed = [("g.dump", dump("id type x y z radius", &["1 1 0 0 0.07 0.005", "2 2 0 0 0.02 0.005"]))];
    let error = read(&twice, &typed, &kinds(&[("1", "m"), ("2", "m")])).unwrap_err();
    assert!(error.contains("several populations of the scene are of m") && error.contains("population.0"), "{error}");
    assert_eq!(
        heights(read(&twice, &typed, &kinds(&[("2", "population.0"), ("1", "population.1")])).unwrap()),
        [0.02, 0.07]
    );
}

#[test]
fn a_material_that_changes_is_refused() {
    let scene = two_materials();
    let frame =
        |material: &str| format!("time,id,x,y,z,radius,material\n0.1,1,0,0,0,0.005,m\n0.2,1,0,0,0,0.005,{material}\n");
    assert!(read(&scene, &[("a.csv", frame("m"))], &Stated::default()).is_ok());
    let error = read(&scene, &[("a.csv", frame("heavy"))], &Stated::default()).unwrap_err();
    assert!(error.contains("a.csv: line 3: grain 1 is of heavy at 0.2 s, and of m before"), "{error}");
}

#[test]
fn radii_are_in_the_file_or_stated() {
    let drawn = scene_of(&["m", "m"], "{ kind = 'uniform', mean = 0.005, spread = 0.2 }");
    let file = [("g.dump", dump("id x y z v_diameter", &["1 0.05 0.05 0.02 0.0075", "2 0.05 0.0585 0.02 0.0095"]))];
    let first = Stated { first_id: Some(1), ..Stated::default() };
    let error = read(&drawn, &file, &first).unwrap_err();
    assert!(
        error.contains("no column radius or diameter among id, x, y, z, v_diameter")
            && error.contains("0.004 to 0.006 m"),
        "{error}"
    );
    let placed = read(&drawn, &file, &Stated { seed: Some(3), ..first }).unwrap();
    let own = makadam::scene::populate(&drawn, 3).unwrap();
    let found: Vec<f64> = placed.recording.frames[0].particles.iter().map(|grain| grain.radius).collect();
    assert_eq!(found, own.iter().map(|grain| grain.radius).collect::<Vec<_>>());
    assert_eq!(placed.recording.seed, 3);
    // One radius is what the scene states.
    let fixed = two_materials();
    let imported = read(&fixed, &file, &Stated { first_id: Some(1), ..Stated::default() }).unwrap();
    assert!(imported.recording.frames[0].particles.iter().all(|grain| grain.radius == 0.005));
    assert!(imported.notes.contains(&"radii are those of the scene, 0.005 m".to_string()), "{:?}", imported.notes);
}

#[test]
fn the_periodic_box_of_a_dump_is_that_of_the_scene() {
    let mut scene = scene_of(&["m"], "{ kind = 'fixed', value = 0.005 }");
    let rows = ["1 0.01 0.05 0.05 0.005"];
    let file = |flags: &str, bounds: &str| [("g.dump", dump_in(flags, bounds, "id x y z radius", &rows))];
    let refused = |scene: &Scene, flags: &str, bounds: &str, words: &str| {
        let error = read(scene, &file(flags, bounds), &Stated::default()).unwrap_err();
        assert!(error.contains(words), "{error}");
    };
    assert!(read(&scene, &file("ff fm ff", "0 0.12"), &Stated::default()).is_ok());
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
        assert!(read(&scene, &file(flags, bounds), &Stated::default()).is_ok(), "{flags} {bounds}");
    }
}

#[test]
fn grains_that_leave_keep_their_numbers_and_need_them() {
    let (scene, _) = packing();
    let frame = |ids: &[i64]| {
        let rows = ids.iter().map(|id| format!("{id},0,0,{id},0.005\n"));
        format!("id,x,y,z,radius\n{}", rows.collect::<String>())
    };
    let files = [("f_0.csv", frame(&[10, 11, 12])), ("f_1.csv", frame(&[11, 12])), ("f_2.csv", frame(&[12]))];
    let counted = Stated { interval: Some(0.1), ..Stated::default() };
    let imported = read(&scene, &files, &counted).unwrap();
    let ids: Vec<Vec<u32>> =
        imported.recording.frames.iter().map(|frame| frame.particles.iter().map(|grain| grain.id).collect()).collect();
    assert_eq!(ids, [vec![0, 1, 2], vec![1, 2], vec![2]]);
    let unnumbered = files.map(|(name, text)| (name, text.replace("id,", "_,")));
    let error = read(&scene, &unnumbered, &counted).unwrap_err();
    assert!(error.contains("no column id states which grains came or went"), "{error}");
}

#[test]
fn a_legacy_vtk_file_that_is_cut_off_is_refused() {
    let whole = "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS 2 double\n0 0 0\n0.1 0 0\nPOINT_DATA 2\n\
                 SCALARS radius double 1\nLOOKUP_TABLE default\n0.005\n0.005\nVECTORS v double\n0 0 0\n0 0 2.5\n";
    let read = |text: &str| parse(Path::new("a.vtk"), text.as_bytes().to_vec(), &StatedColumns::default());
    assert_eq!(read(whole).unwrap()[0].values[13], 2.5);
    let error = read(whole.strip_suffix("5\n").unwrap()).unwrap_err().to_string();
    assert!(error.contains("a.vtk: line 15: the last row has no line end"), "{error}");
    let error = read(whole.strip_suffix("2.5\n").unwrap()).unwrap_err().to_string();
    assert!(error.contains("a.vtk: line 15"), "{error}");
}

#[test]
fn columns_of_a_dump_have_the_meaning_that_its_code_gives_them() {
    let text = dump("id type type x y z radius v_x f_y vx", &["1 2 2 0.1 0.2 0.3 0.005 7 8 9"]);
    let frames = parse(Path::new("a.dump"), text.into_bytes(), &StatedColumns::default()).unwrap();
    assert_eq!(frames[0].columns.join(" "), "id type x y z radius vx");
    assert_eq!(frames[0].values, [1.0, 2.0, 0.1, 0.2, 0.3, 0.005, 9.0]);
}
