//! A list of contacts that lacks some is not measured as if it were whole, and what contradicts the places of grains is refused.

use super::*;

/// What is made of frames with contacts of which some are left out, and of the text of the rest changed.
fn told(keep: &dyn Fn(usize, &Contact) -> bool, change: &dyn Fn(String) -> String) -> Result<Imported, ImportError> {
    let (scene, frames) = packing();
    let kept = |frame: &Snapshot| Snapshot {
        contacts: (0..).zip(&frame.contacts).filter(|(place, one)| keep(*place, one)).map(|(_, one)| *one).collect(),
        ..frame.clone()
    };
    let text = |head: &str, frames: &[Snapshot], rows: Rows| {
        let mut text = format!("time {head}\n");
        frames.iter().for_each(|frame| rows(frame, &|to| _ = write!(to, "{:e} ", frame.time), &mut text));
        text.replace(' ', ",")
    };
    let grains = text(GRAINS, &frames, &grain_rows);
    let contacts = text(CONTACTS, &frames.iter().map(kept).collect::<Vec<_>>(), &contact_rows);
    assembled(&scene, &tables(&[("grains.csv", grains)], &[("contacts.csv", change(contacts))])?)
}

fn lacks(keep: &dyn Fn(usize, &Contact) -> bool) -> (Vec<Content>, Vec<String>) {
    let Imported { recording, notes } = told(keep, &|text| text).unwrap();
    (recording.lacks, notes)
}

#[test]
fn a_list_that_lacks_contacts_is_not_measured_as_whole() {
    let (whole, notes) = lacks(&|_, _| true);
    assert_eq!((&whole[..], notes.len()), (&[Content::DrivenWalls][..], 0), "{notes:?}");
    // Contacts that bear nothing need not be told.
    assert_eq!(lacks(&|_, contact| contact.force_on_partner().norm() > 0.0), (whole.clone(), vec![]));
    let (some, notes) = lacks(&|place, contact| !contact.second.is_grain() || place % 10 > 0);
    assert_eq!(some, [Content::DrivenWalls, Content::Contacts]);
    assert!(notes.len() == 1 && notes[0].contains("are in no list of contacts, such as grains "), "{notes:?}");
    let (none, notes) = lacks(&|_, contact| !contact.second.is_grain());
    assert_eq!(none, [Content::DrivenWalls, Content::Contacts], "{notes:?}");
    // Weak contacts count, too.
    let (whole_frames, mut mean) = (packing().1, 0.0);
    let pairs = || whole_frames.iter().flat_map(|frame| &frame.contacts).filter(|contact| contact.second.is_grain());
    pairs().for_each(|contact| mean += contact.normal_force / pairs().count() as f64);
    let (no_weak, notes) = lacks(&|_, contact| !contact.second.is_grain() || contact.normal_force > 0.2 * mean);
    assert_eq!(no_weak, [Content::DrivenWalls, Content::Contacts], "{notes:?}");
    // The floor and the sides are one wall.
    let (no_floor, notes) = lacks(&|_, contact| contact.second.is_grain() || contact.normal[2].abs() < 0.9);
    assert_eq!(no_floor, [Content::DrivenWalls, Content::WallContacts]);
    assert!(notes.len() == 1 && notes[0].contains("overlaps of grains with one face of the wall 0 ("), "{notes:?}");
}

/// A row of 24 grains of radius 1 m, each of which overlaps the next one by as much, and the contacts of those that are kept.
fn row(overlap: f64, digits: usize, keep: fn(usize) -> bool) -> Imported {
    let place = |grain: usize| (2.0 - overlap) * grain as f64;
    let grains: String = (0..24).map(|grain| format!("{grain},0,0,{:.digits$e},1\n", place(grain))).collect();
    let contacts: String =
        (0..23).filter(|grain| keep(*grain)).map(|grain| format!("{grain},{},0,1,-1\n", grain + 1)).collect();
    let files = [("g.csv", format!("id,x,y,z,r\n{grains}"))];
    let contacts = [("c.csv", format!("first,second,fx,fy,fz\n{contacts}"))];
    assembled(&packing().0, &tables(&files, &contacts).unwrap()).unwrap()
}

#[test]
fn stiff_grains_overlap_by_little_and_their_lists_are_looked_at_all_the_same() {
    let lacks = |imported: &Imported| imported.recording.lacks.contains(&Content::Contacts);
    let says = |imported: &Imported, words: &str| imported.notes.iter().any(|note| note.contains(words));
    let whole = row(1e-6, 15, |_| true);
    assert!(!lacks(&whole) && !says(&whole, "contacts"), "{:?}", whole.notes);
    let half = row(1e-6, 15, |grain| grain % 2 == 0);
    assert!(lacks(&half) && says(&half, "of 23 pairs of grains that overlap in the measured"), "{:?}", half.notes);
    // With digits that hide the overlaps nothing can be told, which is said.
    let hidden = row(1e-9, 4, |grain| grain % 2 == 0);
    assert!(
        !lacks(&hidden) && says(&hidden, "whether the lists have all contacts cannot be seen"),
        "{:?}",
        hidden.notes
    );
}

#[test]
fn points_beside_the_grains_are_refused() {
    let (scene, _) = packing();
    let grains = [("g.csv", "id,x,y,z,r\n1,0,0,0,1\n2,0,0,1.9,1\n".to_string())];
    let point = |z: f64| [("c.csv", format!("first,second,fx,fy,fz,px,py,pz\n1,2,0,0,-1,0,0,{z}\n"))];
    assert!(assembled(&scene, &tables(&grains, &point(0.95)).unwrap()).is_ok());
    let error = assembled(&scene, &tables(&grains, &point(-1.5)).unwrap()).unwrap_err().to_string();
    assert!(error.contains("c.csv: line 2: the point of grain 1 and grain 2 lies 2.4"), "{error}");
}

#[test]
fn normals_that_contradict_the_places_of_grains_are_refused() {
    let reversed = |text: String| {
        let turned = |(line, row): (usize, &str)| {
            let mut cells: Vec<String> = row.split(',').map(String::from).collect();
            if line > 0 {
                let places = cells.len() - 3..cells.len();
                cells[places].iter_mut().for_each(|cell| *cell = (-cell.parse::<f64>().unwrap()).to_string());
            }
            cells.join(",")
        };
        text.lines().enumerate().map(turned).collect::<Vec<_>>().join("\n") + "\n"
    };
    let error = told(&|_, _| true, &reversed).unwrap_err().to_string();
    assert!(error.contains("contacts.csv: line ") && error.contains("is 180 degrees off the way"), "{error}");
    let (scene, _) = packing();
    let grains = ("g.csv", "id,x,y,z,r\n1,0,0,0,1\n".to_string());
    let wall = |force: f64| ("c.csv", format!("first,wall,fx,fy,fz,px,py,pz\n1,0,0,0,{force},0,0,0\n"));
    let error =
        assembled(&scene, &tables(std::slice::from_ref(&grains), &[wall(1.0)]).unwrap()).unwrap_err().to_string();
    assert!(error.contains("c.csv: line 2: grain 1 touches its partner in its own centre"), "{error}");
    assert!(assembled(&scene, &tables(&[grains], &[wall(0.0)]).unwrap()).is_ok());
}

#[test]
fn frames_are_told_apart_by_steps_and_are_no_larger_than_the_scene() {
    let (scene, _) = packing();
    let rows = |step: usize| (0..100).map(|grain| format!("{step},{grain},0,0,{grain},0.005\n")).collect::<String>();
    let text = |head: &str| format!("{head},id,x,y,z,r\n{}{}", rows(1000), rows(1500));
    let frames = |head: &str| assembled(&scene, &tables(&[("a.csv", text(head))], &[]).unwrap());
    let times: Vec<f64> = frames("step").unwrap().recording.frames.iter().map(|frame| frame.time).collect();
    assert_eq!(times, [1000.0, 1500.0].map(|step| step * (INTERVAL / 100.0)));
    let error = frames("_").unwrap_err().to_string();
    assert!(
        error.contains("two grains of a frame have one number") || error.contains("a frame has 200 grains"),
        "{error}"
    );
    let rows: String = (0..101).map(|grain| format!("{grain},0,0,{grain},0.005\n")).collect();
    let error = assembled(&scene, &tables(&[("a.csv", format!("id,x,y,z,r\n{rows}"))], &[]).unwrap()).unwrap_err();
    assert!(error.to_string().contains("a frame has 101 grains, and the scene has 100"), "{error}");
}

#[test]
fn a_file_of_yade_has_one_format() {
    let text = "#format x_y_z_r\n0 0 0 0.005\n#format r_x_y_z\n0.005 1 0 0\n";
    let error = tables(&[("a.txt", text.into())], &[]).unwrap_err().to_string();
    assert!(error.contains("a.txt: line 3: a second line #format"), "{error}");
}

#[test]
fn frames_that_stand_still_are_noted_and_huge_forces_refused() {
    let (scene, frames) = packing();
    let mut text = format!("time {GRAINS}\n");
    for place in [12, 12, 14] {
        let time = 0.2 + 0.01 * text.lines().count() as f64;
        grain_rows(&frames[place], &|to| _ = write!(to, "{time:e} "), &mut text);
    }
    let imported = assembled(&scene, &tables(&[("a.csv", text.replace(' ', ","))], &[]).unwrap()).unwrap();
    let said = "1 of 3 measured frames are the same as the one before";
    assert!(imported.notes.iter().any(|note| note.contains(said)), "{:?}", imported.notes);
    let files = [("c.csv", "first,second,fx,fy,fz\n1,2,0,0,-1e200\n".to_string())];
    let grains = [("g.csv", "id,x,y,z,r\n1,0,0,0,1\n2,0,0,1.9,1\n".to_string())];
    let error = assembled(&scene, &tables(&grains, &files).unwrap()).unwrap_err().to_string();
    assert!(error.contains("beyond all numbers"), "{error}");
}
