//! What is cut off, told twice, of another time or of another scene is refused or noted.

use super::*;

const GRAINS_APART: &str = "id,x,y,z,r\n1,0,0,0,1\n2,0,0,1.9,1\n3,0,0,9,1\n";

fn refused(grains: &[(&'static str, &str)], contacts: &[(&'static str, &str)]) -> String {
    let owned =
        |files: &[(&'static str, &str)]| files.iter().map(|(name, text)| (*name, text.to_string())).collect::<Vec<_>>();
    let (scene, _) = packing();
    let found = tables(&owned(grains), &owned(contacts)).and_then(|tables| assembled(&scene, &tables));
    found.expect_err("it is refused").to_string()
}

#[test]
fn a_row_that_may_be_cut_off_is_refused() {
    let error = refused(&[("a.csv", "id,x,y,z,r\n1,0,0,0,1\n2,0,0,1.9,1.5e")], &[]);
    assert!(error.contains("a.csv: line 3: the last row has no line end"), "{error}");
    let dump = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\nITEM: ATOMS id x y z\n1 0 0 5.07";
    let error = refused(&[("a.dump", dump)], &[]);
    assert!(error.contains("a.dump: line 10: the last row has no line end"), "{error}");
    assert!(parse(Path::new("a.csv"), b"x,y\r\n1,2\r\n".to_vec(), &StatedColumns::default()).is_ok());
}

#[test]
fn contacts_of_another_step_are_refused() {
    let pair = "first,second,fx,fy,fz\n1,2,0,0,-1\n";
    let error = refused(&[("g_800.csv", GRAINS_APART)], &[("c_300.csv", pair)]);
    assert!(
        error.contains("c_300.csv") && error.contains("of step 300") && error.contains("g_800.csv are of step 800"),
        "{error}"
    );
    let (scene, _) = packing();
    for contacts in ["c_800.csv", "c.csv"] {
        let files = tables(&[("g_800.csv", GRAINS_APART.into())], &[(contacts, pair.into())]).unwrap();
        assert!(assembled(&scene, &files).is_ok(), "{contacts}");
    }
}

#[test]
fn contacts_counted_from_another_frame_are_refused() {
    let (scene, _) = packing();
    let files = |name: &str, first: usize, text: &str| -> Vec<(&'static str, String)> {
        (first..first + 3).map(|place| (&*format!("{name}_{place}.csv").leak(), text.to_string())).collect()
    };
    let grains = files("g", 4, GRAINS_APART);
    let assembled = |first: usize| {
        let contacts = files("c", first, "first,second,fx,fy,fz\n1,2,0,0,-1\n");
        let counted = Stated { interval: Some(0.02), ..Stated::default() };
        stated(&scene, &tables(&grains, &contacts).unwrap(), &counted)
    };
    assert!(assembled(4).is_ok());
    let error = assembled(3).unwrap_err().to_string();
    assert!(error.contains("its contacts are of step 3") && error.contains("g_4.csv are of step 4"), "{error}");
}

#[test]
fn contacts_of_grains_that_are_apart_are_refused() {
    let apart = refused(&[("g.csv", GRAINS_APART)], &[("c.csv", "first,second,fx,fy,fz\n2,3,0,0,-1\n")]);
    assert!(apart.contains("c.csv: line 2: grain 2 and grain 3 are 5.100e0 m apart, and do not touch"), "{apart}");
    let wall = "first,wall,fx,fy,fz,px,py,pz\n1,0,0,0,1,0,0,-1\n2,0,0,0,1,0,0,-1\n";
    let apart = refused(&[("g.csv", GRAINS_APART)], &[("c.csv", wall)]);
    assert!(apart.contains("c.csv: line 3: grain 2 and wall 0 are 1.900e0 m apart"), "{apart}");
}

#[test]
fn contacts_with_walls_that_are_told_twice_are_refused() {
    let row = "1,0,0,0,1,0,0,-1\n";
    let other = "1,0,0,0,2,0,0.1,-1\n";
    let wall = |rows: [&str; 2]| format!("first,wall,fx,fy,fz,px,py,pz\n{}", rows.concat());
    let twice = refused(&[("g.csv", GRAINS_APART)], &[("c.csv", &wall([row, row]))]);
    assert!(twice.contains("c.csv: line 3: grain 1 touches a wall twice"), "{twice}");
    // Two triangles of one wall are touched at two points.
    let (scene, _) = packing();
    assert!(
        assembled(&scene, &tables(&[("g.csv", GRAINS_APART.into())], &[("c.csv", wall([row, other]))]).unwrap())
            .is_ok()
    );
}

#[cfg(unix)]
#[test]
fn a_file_that_is_given_under_two_names_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let [file, link] = ["walls.csv", "latest.csv"].map(|name| folder.path().join(name));
    std::fs::write(&file, "first,wall,fx,fy,fz,px,py,pz\n").unwrap();
    std::os::unix::fs::symlink(&file, &link).unwrap();
    let mut tables = Tables::default();
    tables.add_contacts(&file, &StatedColumns::default()).unwrap();
    for other in [link, folder.path().join(".").join("walls.csv")] {
        let error = tables.add_contacts(&other, &StatedColumns::default()).unwrap_err().to_string();
        assert!(error.contains("given twice"), "{error}");
    }
}

#[test]
fn a_vtk_file_of_several_pieces_is_refused() {
    let piece = |points: &str| {
        let count = points.split_whitespace().count() / 3;
        format!(
            "<Piece NumberOfPoints=\"{count}\" NumberOfCells=\"0\"><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" \
             format=\"ascii\">{points}</DataArray></Points></Piece>"
        )
    };
    let file = |pieces: &[&str]| {
        let pieces: String = pieces.iter().map(|points| piece(points)).collect();
        let text =
            format!("<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid>{pieces}</UnstructuredGrid></VTKFile>");
        parse(Path::new("a.vtu"), text.into_bytes(), &StatedColumns::default())
    };
    assert_eq!(file(&["0 0 0 1 1 1"]).unwrap()[0].rows().count(), 2);
    assert_eq!(file(&["", "0 0 0 1 1 1"]).unwrap()[0].rows().count(), 2, "empty pieces are none");
    let error = file(&["0 0 0", "1 1 1"]).unwrap_err().to_string();
    assert!(error.contains("several pieces") && error.contains("Merge Blocks"), "{error}");
}

#[test]
fn fields_of_legacy_vtk_files_are_columns() {
    let file = |arrays: &str| {
        let text = format!(
            "# vtk DataFile Version 5.1\nLIGGGHTS\nASCII\nDATASET POLYDATA\nFIELD FieldData 1\nTIME 1 1 double\n0.5\nPOINTS 2 float\n\
             1 2 3 4 5 6\nMETADATA\nINFORMATION 2\nNAME L2_NORM_RANGE LOCATION vtkDataArray\nDATA 2 0 17\n\nVERTICES 3 2\nOFFSETS \
             vtktypeint64\n0 1 2\nCONNECTIVITY vtktypeint64\n0 1\nPOINT_DATA 2\n{arrays}"
        );
        parse(Path::new("a.vtk"), text.into_bytes(), &StatedColumns::default())
    };
    let two = "FIELD FieldData 2\nradius 1 2 double\n0.5 0.25\nMETADATA\nINFORMATION 0\n\nv 3 2 float\n1 2 3 4 5 6\n";
    let frames = file(two).unwrap();
    let rows: Vec<&[f64]> = frames[0].rows().collect();
    assert_eq!(rows, [[1.0, 2.0, 3.0, 0.5, 1.0, 2.0, 3.0], [4.0, 5.0, 6.0, 0.25, 4.0, 5.0, 6.0]]);
    let columns: Vec<Option<Column>> = frames[0].columns.iter().map(|name| column_of(name)).collect();
    let axes = |of: fn(usize) -> Column| (0..3).map(move |axis| Some(of(axis)));
    let wanted: Vec<_> = axes(Column::Position).chain([Some(Column::Radius)]).chain(axes(Column::Velocity)).collect();
    assert_eq!(columns, wanted);
    let error = file("POINT_DATA 3\n").unwrap_err().to_string();
    assert!(error.contains("data of 3 points, and there are 2"), "{error}");
    for (arrays, words) in [
        ("FIELD FieldData 1\nid 1 2 string\na\nb\n", "id has 2 rows of string"),
        ("FIELD FieldData 1\nradius 1 3 double\n1 2 3\n", "radius has 3 rows of double, and there are 2 points"),
        ("FIELD FieldData many\n", "no number of arrays"),
        ("FIELD FieldData 1\nradius one 2 double\n1 2\n", "'one' is no number of components"),
        ("FIELD FieldData 1\nradius 1 2 double\n1\n", "radius ends before its last number"),
    ] {
        let error = file(arrays).unwrap_err().to_string();
        assert!(error.contains(words), "{words}: {error}");
    }
}

#[test]
fn grains_and_forces_that_a_scene_cannot_have_are_noted() {
    let (scene, mut frames) = packing();
    assert!(unlike(&scene, frames.iter()).is_empty());
    let last = frames.last_mut().unwrap();
    last.contacts.iter_mut().for_each(|contact| contact.normal_force = -contact.normal_force.abs());
    let reversed = unlike(&scene, std::iter::once(&*last));
    assert!(reversed.len() == 1 && reversed[0].contains("no contact pushes"), "{reversed:?}");
    for contact in &mut last.contacts {
        (contact.normal_force, contact.tangential_force) = (-contact.normal_force, [0.0; 3]);
    }
    let normal = unlike(&scene, std::iter::once(&*last));
    assert!(normal.len() == 1 && normal[0].contains("no contact has a tangential force"), "{normal:?}");
    last.particles[7].radius *= 2.0;
    let notes = unlike(&scene, std::iter::once(&*last));
    assert!(notes[0].contains("grain 7 has a radius of"), "{notes:?}");
}

#[test]
fn grains_behind_walls_are_noted() {
    let (mut scene, mut frames) = packing();
    let last = frames.last_mut().unwrap();
    assert!(unlike(&scene, std::iter::once(&*last)).is_empty());
    let radius = last.particles[3].radius;
    let mut low = |depths: [f64; 2]| {
        for (place, depth) in [3, 5].into_iter().zip(depths) {
            last.particles[place].position[2] = -depth * radius;
        }
        last.clone()
    };
    let shallow = low([0.9, 0.5]);
    assert!(unlike(&scene, std::iter::once(&shallow)).is_empty());
    let deep = low([1.5, 1.9]);
    let notes = unlike(&scene, std::iter::once(&deep));
    assert!(
        notes.len() == 1 && notes[0].contains("2 of ") && notes[0].contains("the first of them grain 3"),
        "{notes:?}"
    );
    assert!(notes[0].contains(&format!("{:.3e} m behind '{}'", 1.5 * radius, scene.wall[0].name)), "{notes:?}");
    // Beside an open box, where grains are meant to leave it.
    scene.watch.on_escape = makadam::scene::Reaction::Ignore;
    assert!(unlike(&scene, std::iter::once(&deep)).is_empty());
}
