//! Each series of contacts tells every measured frame, or what it tells is not measured.

use super::*;

/// Two frames of two grains, both measured.
const BOTH: &str = "time,id,x,y,z,r\n0.3,1,0,0,1,1\n0.3,2,0,0,3,1\n0.4,1,0,0,1,1\n0.4,2,0,0,3,1\n";
const WALLS: &str = "first,wall,fx,fy,fz,px,py,pz\n";

/// Contacts of a grain with a wall at some times, in one table.
fn walls_at(times: &[f64], grain: u32) -> String {
    let height = if grain == 1 { 0 } else { 2 };
    let rows = times.iter().map(|time| format!("{time},{grain},0,0,0,0.5,0,0,{height}\n"));
    format!("time,{WALLS}{}", rows.collect::<String>())
}

fn given(contacts: &[(&str, String)]) -> Result<Imported, ImportError> {
    let (scene, _) = packing();
    assembled(&scene, &tables(&[("grains.csv", BOTH.to_string())], contacts)?)
}

const PAIRS: &str = "time,first,second,fx,fy,fz\n0.3,1,2,0,0,-1\n0.4,1,2,0,0,-1\n";

fn lacks_walls(recording: &Recording) -> bool {
    recording.lacks.contains(&Content::WallContacts)
}

#[test]
fn each_of_two_files_with_the_same_columns_tells_every_measured_frame() {
    // The files tell what they are by other words, or by other numbers.
    for [one, other] in [["a.csv", "b.csv"], ["wall0.csv", "wall1.csv"]] {
        let both = |times: &[f64]| {
            given(&[("pairs.csv", PAIRS.into()), (one, walls_at(&[0.3, 0.4], 1)), (other, walls_at(times, 2))])
        };
        let whole = both(&[0.3, 0.4]).unwrap().recording;
        assert_eq!((lacks_walls(&whole), whole.frames[1].contacts.len()), (false, 3));
        match both(&[0.3]) {
            Ok(Imported { recording, notes }) => {
                assert!(lacks_walls(&recording) && !recording.lacks.contains(&Content::Contacts));
                assert!(notes.iter().any(|note| note.starts_with("b.csv has no rows at 0.4 s")), "{notes:?}");
            }
            // The number is taken for that of a step.
            Err(error) => {
                assert_eq!((&*error.file, other), (Path::new("wall1.csv"), "wall1.csv"));
                assert!(error.problem.starts_with("no contacts are given for the frame at 0.4 s"), "{error}");
            }
        }
    }
    // A file for each frame of each wall, and one of them is missing.
    let file = |name: &'static str| (name, format!("{WALLS}1,0,0,0,0.5,0,0.{},0\n", &name[4..5]));
    let all = ["wall0_1500.csv", "wall0_2000.csv", "wall1_1500.csv", "wall1_2000.csv"].map(file);
    assert_eq!(given(&all).unwrap().recording.frames[1].contacts.len(), 1, "one face of one wall");
    let error = given(&all[..3]).unwrap_err().to_string();
    assert!(error.contains("wall1_1500.csv: line 2: no contacts are given for the frame at 0.4 s"), "{error}");
    // One table in two pieces is whole.
    let pieces = given(&[("walls_1.csv", walls_at(&[0.3], 1)), ("walls_2.csv", walls_at(&[0.4], 1))]).unwrap();
    assert!(!lacks_walls(&pieces.recording));
}

#[test]
fn contacts_at_other_times_than_all_frames_are_no_absence_of_contacts() {
    let Imported { recording, notes } =
        given(&[("pairs.csv", PAIRS.into()), ("walls.csv", walls_at(&[0.35, 0.45], 1))]).unwrap();
    assert!(lacks_walls(&recording) && !recording.lacks.contains(&Content::Contacts));
    let words = "walls.csv has no rows at 0.3 s, and of 2 of 2 measured frames (its times are from 0.35 to 0.45 s)";
    assert!(notes.iter().any(|note| note.starts_with(words)), "{notes:?}");
    let error = given(&[("pairs.csv", PAIRS.into()), ("walls_7.csv", format!("{WALLS}1,0,0,0,0.5,0,0,0\n"))]);
    let error = error.unwrap_err().to_string();
    assert!(
        error.contains("no contacts are given for the frame at 0.3 s") && error.contains("(its time is "),
        "{error}"
    );
}

#[test]
fn contacts_count_no_more_frames_than_grains() {
    let (scene, _) = packing();
    let grains = [("f_0.csv", marked(0)), ("f_1.csv", marked(0))];
    let contact = |name: &'static str| (name, "first,second,fx,fy,fz\n1,2,0,0,-1\n".to_string());
    let counted = |names: &[&'static str]| {
        let contacts: Vec<_> = names.iter().map(|name| contact(name)).collect();
        let found = tables(&grains, &contacts).unwrap();
        let interval = Some(INTERVAL);
        stated(&scene, &found, &Stated { interval, ..Stated::default() })
    };
    assert!(counted(&["c_0.csv", "c_1.csv"]).is_ok());
    let error = counted(&["c_0.csv", "c_1.csv", "c_2.csv"]).unwrap_err().to_string();
    assert!(error.contains("c_2.csv: line 2: its contacts are of frame 3 by their place"), "{error}");
}
