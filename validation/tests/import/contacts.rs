//! Lists of contacts: complete as stated, at the times of frames, each contact once.

use super::*;
use makadam_frames::import::unlike;

const TWO: &str = "id,x,y,z,r\n1,0,0,0,0.005\n2,0,0,0.0095,0.005\n3,0,0,0.045,0.005\n";

fn refused(rows: &str, words: &str) {
    let (scene, _) = packing();
    let error = refusal(&scene, &at(0.6), &[("g.csv", TWO.into())], &[("c.csv", rows.into())]);
    assert!(error.contains(words), "{error}");
}

/// Frames of a packing with those contacts that are kept, and the text of contacts changed.
fn kept(keep: &dyn Fn(usize, &Contact) -> bool, change: &dyn Fn(String) -> String) -> Result<Recording, ImportError> {
    let (scene, frames) = packing();
    let kept = |frame: &Snapshot| Snapshot {
        contacts: (0..).zip(&frame.contacts).filter(|(index, one)| keep(*index, one)).map(|(_, one)| *one).collect(),
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

#[test]
fn complete_lists_are_checked() {
    let whole = kept(&|_, _| true, &|text| text).unwrap();
    assert_eq!((&whole.lacks[..], whole.notes.len()), (&[Content::DrivenWalls][..], 0), "{:?}", whole.notes);
    // Contacts that bear nothing need not be listed.
    assert!(kept(&|_, contact| contact.force_on_partner().norm() > 0.0, &|text| text).is_ok());
    for keep in [
        |index: usize, contact: &Contact| !contact.second.is_grain() || !index.is_multiple_of(10),
        |_: usize, contact: &Contact| !contact.second.is_grain() || contact.normal_force > 1e-3,
    ] {
        let error = kept(&keep, &|text| text).unwrap_err().to_string();
        assert!(error.contains("contacts.csv: line ") && error.contains("contacts-complete is wrong"), "{error}");
    }
}

#[test]
fn completeness_must_be_stated() {
    let (scene, _) = packing();
    let contacts = [("c.csv", "first,second,fx,fy,fz\n1,2,0,0,-1\n".to_string())];
    let manifest = Manifest { contacts_complete: false, ..at(0.6) };
    let error = refusal(&scene, &manifest, &[("g.csv", TWO.into())], &contacts);
    assert!(
        error.starts_with("c.csv: line 2: statements are missing")
            && error.contains("\n  contacts-complete = true   #"),
        "{error}"
    );
    assert!(assemble(&scene, &at(0.6), &tables(&[("g.csv", TWO.into())], &contacts).unwrap()).is_ok());
}

/// A row of grains, each of which has approached the next for a step or for longer.
#[test]
fn new_and_opening_contacts_may_be_unlisted() {
    let (scene, _) = packing();
    let step = 1e-5;
    let read = |overlap: f64, approach: f64| {
        let grains = format!(
            "id,x,y,z,r,vx,vy,vz\n1,0,0,0,0.005,0,0,{approach}\n2,0,0,{},0.005,0,0,0\n3,0,0,0.05,0.005,0,0,0\n4,0,0,0.059,0.005,0,0,0\n",
            0.01 - overlap
        );
        let contacts = [("c.csv", "first,second,fx,fy,fz\n3,4,0,0,-1\n".to_string())];
        let manifest = Manifest { time_step: Some(step), ..at(0.6) };
        assemble(&scene, &manifest, &tables(&[("g.csv", grains)], &contacts).unwrap())
    };
    assert!(read(1e-5, 2.0).is_ok(), "the positions are a step younger than contacts");
    assert!(read(1e-4, -2.0).is_ok(), "the grains part");
    assert!(read(1e-4, 2.0).unwrap_err().problem.contains("press on each other, with an overlap of 1.000e-4 m"));
}

#[test]
fn contradictory_contacts_are_refused() {
    let pair = "first,second,fx,fy,fz\n";
    refused(&format!("{pair}1,7,0,0,1\n"), "c.csv: line 2: there is no grain 7 in this frame");
    refused(&format!("{pair}1,2,0,0,-1\n2,1,0,0,1\n"), "c.csv: line 3: grain 2 and grain 1 are listed twice");
    refused(&format!("{pair}1,1,0,0,1\n"), "grain 1 and grain 1 are listed twice, or are one");
    refused(&format!("{pair}2,3,0,0,-1\n"), "grain 2 and grain 3 are 2.550e-2 m apart");
    refused(&format!("{pair}1,2,0,0,-1e200\n"), "beyond all numbers");
    refused("first,second,fx,fy,fz,nx,ny,nz\n1,2,0,0,-1,0,0,-1\n", "normal of grain 1 and grain 2 leads away");
    let wall = "first,wall,fx,fy,fz,px,py,pz\n";
    refused(&format!("{wall}1,9,0,0,1,0,0,0\n"), "there is no wall 9");
    refused(
        &format!("{wall}1,0,0,0,1,0,0,-0.005\n2,0,0,0,1,0,0,-0.005\n"),
        "c.csv: line 3: grain 2 and wall 0 are 9.500e-3 m apart",
    );
    refused(&format!("{wall}1,0,0,0,1,0,0,0\n"), "the centres of grain 1 and wall 0 coincide");
    let row = "1,0,0,0,1,0,0,-0.005\n";
    refused(&format!("{wall}{row}{row}"), "c.csv: line 3: grain 1 and wall 0 are listed twice");
    refused("first,wall,fx,fy,fz\n1,0,0,0,1\n", "needs its point");
    refused(
        "first,second\n1,2\n",
        "contact-columns = [\"first\", \"second\", ...]   # names of the columns first, second",
    );
    // Two triangles of one wall are touched at two points.
    let (scene, _) = packing();
    let two = format!("{wall}{row}1,0,0,0,2,0,0.001,-0.005\n");
    assert!(assemble(&scene, &at(0.6), &tables(&[("g.csv", TWO.into())], &[("c.csv", two)]).unwrap()).is_ok());
}

#[test]
fn reversed_forces_are_noted() {
    let (scene, mut frames) = packing();
    assert!(unlike(&scene, frames.iter()).is_empty());
    let last = frames.last_mut().unwrap();
    last.contacts.iter_mut().for_each(|contact| contact.normal_force = -contact.normal_force.abs());
    let notes = unlike(&scene, std::iter::once(&*last));
    assert!(notes.len() == 1 && notes[0].contains("no contact pushes"), "{notes:?}");
    for contact in &mut last.contacts {
        (contact.normal_force, contact.tangential_force) =
            (contact.normal_force.abs(), [1e-5 * contact.normal_force; 3]);
    }
    let notes = unlike(&scene, std::iter::once(&*last));
    assert!(notes.len() == 1 && notes[0].contains("no contact has a tangential force"), "{notes:?}");
}

/// A measured frame of which no file lists contacts would count as one without any.
#[test]
fn measured_frames_need_contacts() {
    let (scene, frames) = packing();
    let last = frames.len() - 1;
    let text = |head: &str, rows: Rows, of: &dyn Fn(usize) -> bool| {
        let mut text = format!("time {head}\n");
        for (_, frame) in frames.iter().enumerate().filter(|(index, _)| of(*index)) {
            rows(frame, &|to| _ = write!(to, "{:e} ", frame.time), &mut text);
        }
        text.replace(' ', ",")
    };
    let grains = [("grains.csv", text(GRAINS, &grain_rows, &|_| true))];
    let with = |of: &dyn Fn(usize) -> bool| {
        assembled(&scene, &tables(&grains, &[("contacts.csv", text(CONTACTS, &contact_rows, of))]).unwrap())
    };
    let late = with(&|index| frames[index].time > 0.19).unwrap();
    assert_eq!((late.lacks, late.notes), (vec![Content::DrivenWalls], vec![]));
    for only in [2, last] {
        let error = with(&|index| index == only).unwrap_err().to_string();
        assert!(
            error.contains("contacts.csv: line ")
                && error.contains("no file lists contacts between grains of the frame at 0."),
            "{error}"
        );
    }
    // The names of columns alone state that there are no contacts.
    let files = |lost: usize| -> Vec<(&'static str, String)> {
        let file = |index| (&*format!("walls.{index}.csv").leak(), "first,wall,fx,fy,fz,px,py,pz\n".to_string());
        (0..=last).filter(|index| *index != lost).map(file).collect()
    };
    let walls = |lost: usize| {
        let contacts = files(lost);
        let mut found = tables(&grains, &contacts).unwrap();
        for (index, table) in (0..=last).filter(|index| *index != lost).zip(&mut found.contacts) {
            table.time = Some(frames[index].time);
        }
        assembled(&scene, &found)
    };
    assert!(walls(1).is_ok());
    let error = walls(last).unwrap_err().to_string();
    assert!(error.contains("no file lists contacts with walls of the frame at 0.3"), "{error}");
}

#[test]
fn repeated_frames_of_contacts() {
    let (scene, _) = packing();
    let grains = [("a.csv", TWO.to_string())];
    let frame = |force: f64| {
        format!(
            "ITEM: TIME\n0.5\nITEM: TIMESTEP\n0\nITEM: NUMBER OF ENTRIES\n1\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\nITEM: ENTRIES first second fx fy fz\n1 2 0 0 {force}\n"
        )
    };
    let given = |second: f64| {
        let contacts = [("pairs.dump", frame(-1.0) + &frame(second))];
        assemble(&scene, &at(0.5), &tables(&grains, &contacts).unwrap())
    };
    // A code that is started twice writes the frame in between twice.
    assert_eq!(given(-1.0).unwrap().frames[0].contacts.len(), 1);
    let error = given(-2.0).unwrap_err().to_string();
    assert!(error.contains("pairs.dump: line 24: it has two frames of contacts at 0.5 s"), "{error}");
    // Contacts of another time are none of the frame.
    let error = assemble(&scene, &at(0.6), &tables(&grains, &[("pairs.dump", frame(-1.0))]).unwrap()).unwrap_err();
    assert!(error.to_string().contains("no file lists contacts between grains of the frame at 0.6 s"), "{error}");
}
