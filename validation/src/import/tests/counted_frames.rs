//! Frames that tell neither time nor step are counted, by the numbers in the names of their files.

use super::*;

#[test]
fn frames_that_are_counted_follow_the_numbers_of_their_files() {
    let (scene, _) = packing();
    let owned =
        |name: &str, frame: usize| -> (&'static str, String) { (format!("{name}{frame}.csv").leak(), marked(frame)) };
    let counted = |tables: &Tables| {
        let interval = Some(INTERVAL);
        stated(&scene, tables, &Stated { interval, ..Stated::default() })
    };
    // As a shell gives them: 1, 10, 11, 2, ...
    let names = |name: &str| {
        let mut files: Vec<_> = (0..12).map(|frame| owned(name, frame)).collect();
        files.sort();
        files
    };
    let grains = names("grains_");
    let force = |(name, _): &(&'static str, String)| {
        let frame: usize = name.trim_end_matches(".csv").rsplit('_').next().unwrap().parse().unwrap();
        (
            name.replace("grains", "pairs").leak() as &str,
            format!("first,second,fx,fy,fz\n1,2,0,0,{}\n", -1.0 - frame as f64),
        )
    };
    let contacts: Vec<_> = grains.iter().map(force).collect();
    let imported = counted(&tables(&grains, &contacts).unwrap()).unwrap();
    let wanted: Vec<f64> = (0..12).map(f64::from).collect();
    assert_eq!(heights(&imported), wanted);
    let times: Vec<f64> = imported.recording.frames.iter().map(|frame| frame.time).collect();
    assert_eq!(times, wanted.iter().map(|frame| frame * INTERVAL).collect::<Vec<_>>());
    let forces = imported.recording.frames.iter().map(|frame| frame.contacts[0].normal_force - 1.0).collect::<Vec<_>>();
    assert_eq!(forces, wanted);
    // Two names with numbers of their own: which follows which is not made up.
    let both = [names("small_"), names("large_")].concat();
    let error = counted(&tables(&both, &[]).unwrap()).unwrap_err().to_string();
    assert!(error.contains("files of several names (large_#.csv, small_#.csv)"), "{error}");
}

/// Frames of files in the order in which a shell gives them.
fn files_of_frames(names: &[&'static str]) -> Vec<(&'static str, String)> {
    let mut files: Vec<_> = names.iter().enumerate().map(|(frame, name)| (*name, marked(frame))).collect();
    files.sort();
    files
}

#[test]
fn decimals_in_the_names_of_frames_are_no_numbers_of_their_own() {
    let (scene, _) = packing();
    let names = ["f_0.0.csv", "f_0.05.csv", "f_0.1.csv", "f_0.15.csv", "f_0.2.csv"];
    let found = tables(&files_of_frames(&names), &[]).unwrap();
    let given = |time_step: Option<f64>, interval: Option<f64>, found: &Tables| {
        stated(&scene, found, &Stated { time_step, interval, ..Stated::default() })
    };
    let imported = given(None, Some(0.05), &found).unwrap();
    assert_eq!(heights(&imported), [0.0, 1.0, 2.0, 3.0, 4.0]);
    assert!(imported.notes.iter().all(|note| !note.contains("evenly apart")), "{:?}", imported.notes);
    // They are no steps either.
    let error = given(Some(0.01), None, &found).unwrap_err().to_string();
    assert!(error.contains("f_0.1.csv: line 1: the number in its name has decimals, and is no step"), "{error}");
    let unclear = tables(&files_of_frames(&["f_0.25.csv", "f_0.5.csv"]), &[]).unwrap();
    let error = given(Some(0.01), None, &unclear).unwrap_err().to_string();
    assert!(error.contains("a number in its name may have decimals, and be no step"), "{error}");
    let exponents = tables(&files_of_frames(&["f_1e-04.csv", "f_2e-05.csv"]), &[]).unwrap();
    let error = given(None, Some(5e-5), &exponents).unwrap_err().to_string();
    assert!(error.contains("which number in the names counts frames is not clear"), "{error}");
}

#[test]
fn gaps_in_counted_files_are_noted() {
    let (scene, _) = packing();
    let noted = |names: &[&'static str]| {
        let found = tables(&files_of_frames(names), &[]).unwrap();
        let interval = Some(INTERVAL);
        let notes = stated(&scene, &found, &Stated { interval, ..Stated::default() }).unwrap().notes;
        notes
            .iter()
            .any(|note| note.starts_with("the numbers in the names of files, from f_0.csv to f_3.csv, are not evenly"))
    };
    assert!(noted(&["f_0.csv", "f_1.csv", "f_3.csv"]));
    assert!(!noted(&["f_0.csv", "f_1.csv", "f_2.csv", "f_3.csv"]));
}
