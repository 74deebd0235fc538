//! Rows are the grains of the scene that they are taken for, or the files are refused.

use super::*;

/// Fifty grains of one size and fifty of another, two frames: numbers by `number`, in the order of `rows`.
fn two_kinds(number: &dyn Fn(usize) -> i64, rows: &dyn Fn(usize, usize) -> usize) -> Result<Imported, ImportError> {
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

/// Height of the grain with a number, which tells the row that it was taken for.
fn height(imported: &Imported, id: u32) -> f64 {
    let frame = imported.recording.frames.last().unwrap();
    frame.particles.iter().find(|grain| grain.id == id).unwrap().position[2]
}

#[test]
fn kinds_of_different_sizes_are_told_apart_by_radius_whatever_their_numbers() {
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
fn a_listed_grain_is_told_apart_by_radius_where_others_are_missing() {
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
        stated(&scene, &tables(&[("a.csv", text)], &[]).unwrap(), &Stated { first_id, ..Stated::default() })
    };
    let ids =
        |imported: Imported| imported.recording.frames[0].particles.iter().map(|grain| grain.id).collect::<Vec<_>>();
    assert_eq!(ids(read(&[(1, small), (2, small), (3, small)], None).unwrap()), [1, 2, 3], "the listed one has left");
    assert_eq!(ids(read(&[(1, 0.02), (2, small), (3, small)], None).unwrap()), [0, 1, 2]);
    assert_eq!(ids(read(&[(0, small), (1, small), (2, small), (1000, 0.02)], None).unwrap()), [0, 1, 2, 3]);
    // Where numbers are stated to be the scene's, a radius that contradicts them is refused.
    let error = read(&[(1, small), (2, small)], Some(1)).unwrap_err().to_string();
    assert!(error.contains("a.csv: line 2: grain 1 has a radius of"), "{error}");
    let error = read(&[(1, 0.5)], None).unwrap_err().to_string();
    assert!(error.contains("grain 1 has a radius of 0.5 m, and the scene has no such grain"), "{error}");
}

#[test]
fn rows_without_numbers_are_the_same_grains_in_all_frames() {
    let (scene, _) = packing();
    let text = |second: [f64; 2]| {
        let [a, b] = second;
        format!("time,x,y,z,r\n0.3,0,0,0,1\n0.3,0,0,2,1.01\n0.4,0,0,0,{a}\n0.4,0,0,2,{b}\n")
    };
    let read = |text: String| assembled(&scene, &tables(&[("a.csv", text)], &[]).unwrap());
    let notes = read(text([1.0, 1.01])).unwrap().notes;
    assert!(notes.iter().any(|note| note.starts_with("grains have no numbers (a column id)")), "{notes:?}");
    let error = read(text([1.01, 1.0])).unwrap_err().to_string();
    assert!(
        error.contains("row 0 has a radius of 1.01 m at 0.4 s, and of 1 m before: rows are in another order"),
        "{error}"
    );
    let numbered = "time,id,x,y,z,r\n0.3,7,0,0,0,1\n0.4,7,0,0,0,1.01\n";
    let error = read(numbered.into()).unwrap_err().to_string();
    assert!(error.contains("a.csv: line 3: grain 7 has a radius of 1.01 m at 0.4 s"), "{error}");
}

#[test]
fn grains_are_measured_at_their_images_in_a_periodic_domain() {
    let (mut scene, _) = packing();
    scene.domain = serde_json::from_value(
        serde_json::json!({ "min": [-0.1, -0.1, 0.0], "max": [0.1, 0.1, 1.0], "periodic": ["x"] }),
    )
    .unwrap();
    // What lies inside keeps its bits.
    let text = "id,x,y,z,r\n0,0.35,0.05,0.5,0.01\n1,-0.72,0.05,0.5,0.01\n2,0.05,0.35,0.5,0.01\n";
    let imported = assembled(&scene, &tables(&[("a.csv", text.into())], &[]).unwrap()).unwrap();
    let frame = &imported.recording.frames[0];
    for (grain, x) in frame.particles.iter().zip([-0.05, 0.08, 0.05]) {
        assert!((grain.position[0] - x).abs() < 1e-12, "{grain:?}");
    }
    assert_eq!(frame.particles[2].position, [0.05, 0.35, 0.5]);
    let notes = unlike(&scene, imported.recording.frames.iter());
    let left = notes.iter().find(|note| note.contains("outside the domain")).unwrap();
    assert!(left.contains("1 of 3 grains lie") && left.contains("grain 2 at [0.05, 0.35, 0.5] m"), "{left}");
}
