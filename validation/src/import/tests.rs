use super::*;
use crate::observables::{Measurement, measure};
use crate::plan::Scene;
use crate::recording::{Content, Recording};
use crate::scenes;
use makadam::Simulation;
use makadam::snapshot::{Contact, Partner, Snapshot};
use std::fmt::Write;

mod complete_contacts;
mod contact_series;
mod corpus;
mod counted_frames;
mod same_grains;
mod stated_meaning;
mod whole_frames;

/// Time between frames, s.
const INTERVAL: f64 = 0.02;

/// A small packing and some frames of it at the end of its fall.
fn packing() -> (Scene, Vec<Snapshot>) {
    let mut scene = scenes::load(&scenes::find("packing-100", &[]).unwrap()).unwrap();
    scene.measure.from = Some(0.2);
    scene.measure.interval = INTERVAL;
    let mut simulation = Simulation::new(&scene, 1).unwrap();
    let steps = (INTERVAL / simulation.time_step()).round() as usize;
    let mut frames = vec![simulation.snapshot()];
    for _ in 0..15 {
        (0..steps).for_each(|_| _ = simulation.step());
        frames.push(simulation.snapshot());
    }
    (scene, frames)
}

fn recording(frames: Vec<Snapshot>, lacks: Vec<Content>) -> Recording {
    Recording {
        scene: "packing".into(),
        code: "Makadam".into(),
        version: String::new(),
        seed: 1,
        time_step: 1e-3,
        rayleigh_fraction: None,
        stiffness_factor: 1.0,
        threads: 1,
        wall_seconds: 0.0,
        core_seconds: None,
        simulated_seconds: 0.3,
        frames,
        lacks,
        alarms: Vec::new(),
        notes: Vec::new(),
    }
}

fn grain_rows(frame: &Snapshot, with: &dyn Fn(&mut String), to: &mut String) {
    for grain in frame.particles.iter().rev() {
        with(to);
        let numbers = [grain.position, grain.velocity, grain.spin].concat();
        let _ = write!(to, "{} {:e}", grain.id + 7, grain.radius);
        numbers.iter().for_each(|number| _ = write!(to, " {number:e}"));
        to.push('\n');
    }
}

/// Contacts as the force on the first grain.
fn contact_rows(frame: &Snapshot, with: &dyn Fn(&mut String), to: &mut String) {
    for contact in &frame.contacts {
        with(to);
        let force = -contact.force_on_partner();
        let (second, wall) = match contact.second {
            Partner::Grain(id) => (i64::from(id) + 7, -1),
            Partner::Wall(wall) => (-1, i64::from(wall)),
        };
        let _ = write!(to, "{} {second} {wall}", contact.first + 7);
        let numbers = [force.into(), contact.point, contact.normal].concat();
        numbers.iter().for_each(|number| _ = write!(to, " {number:e}"));
        to.push('\n');
    }
}

/// Writes the rows of a frame, each behind what is to stand in front of it.
type Rows<'a> = &'a dyn Fn(&Snapshot, &dyn Fn(&mut String), &mut String);

const GRAINS: &str = "id radius x y z vx vy vz wx wy wz";
const CONTACTS: &str = "first second wall fx fy fz px py pz nx ny nz";

fn assembled(scene: &Scene, tables: &Tables) -> Result<Imported, ImportError> {
    stated(scene, tables, &Stated { time_step: Some(INTERVAL / 100.0), ..Stated::default() })
}

fn stated(scene: &Scene, tables: &Tables, stated: &Stated) -> Result<Imported, ImportError> {
    Assembly { scene, code: "frames", version: "", stated }.assemble(tables)
}

fn tables(grains: &[(&str, String)], contacts: &[(&str, String)]) -> Result<Tables, ImportError> {
    let all = |files: &[(&str, String)]| -> Result<Vec<FrameTable>, ImportError> {
        let mut frames = Vec::new();
        for (name, text) in files {
            frames.extend(parse(Path::new(name), text.clone().into_bytes(), &StatedColumns::default())?);
        }
        Ok(frames)
    };
    Ok(Tables { grains: all(grains)?, contacts: all(contacts)?, ..Tables::default() })
}

/// Where a table has no normals, they are taken from the centres, which have moved on since the contacts were found.
const MOVED_ON: f64 = 1e-3;

fn same(found: &[Measurement], wanted: &[Measurement], within: f64) {
    let names = |all: &[Measurement]| all.iter().map(|one| one.observable.clone()).collect::<Vec<_>>();
    assert_eq!(names(found), names(wanted));
    // With normals that have moved on, Coulomb's bound is no edge any more.
    let at_the_edge = |name: &str| within == MOVED_ON && ["coulomb_excess", "sliding_share"].contains(&name);
    let pairs = found.iter().zip(wanted).filter(|(found, _)| !at_the_edge(&found.observable));
    for (found, wanted) in pairs {
        let scale = wanted.value.abs().max(1e-6);
        assert!((found.value - wanted.value).abs() <= within * scale, "{found:?} {wanted:?}");
    }
}

/// Contacts whose force vanishes are in no table of forces.
fn bearing(frames: &[Snapshot]) -> Vec<Snapshot> {
    let bears = |contact: &&Contact| contact.force_on_partner().norm() > 0.0;
    let keep = |frame: &Snapshot| Snapshot {
        contacts: frame.contacts.iter().filter(bears).copied().collect(),
        ..frame.clone()
    };
    frames.iter().map(keep).collect()
}

#[test]
fn tables_of_any_code_are_measured_as_the_frames_that_they_were_written_from() {
    let (scene, frames) = packing();
    let wanted = measure(&scene, &recording(bearing(&frames), vec![]));
    assert!(wanted.len() > 15, "{}", wanted.len());
    // CSV: one file with a column of times.
    let csv = |head: &str, rows: Rows| {
        let mut text = format!("time {head}\n");
        for frame in &frames {
            rows(frame, &|to| _ = write!(to, "{:e} ", frame.time), &mut text);
        }
        text.replace(' ', ",")
    };
    let (grains, contacts) = (csv(GRAINS, &grain_rows), csv(CONTACTS, &contact_rows));
    let imported =
        assembled(&scene, &tables(&[("grains.csv", grains)], &[("contacts.csv", contacts)]).unwrap()).unwrap();
    assert_eq!(imported.recording.lacks, [Content::DrivenWalls]);
    same(&measure(&scene, &imported.recording), &wanted, 1e-9);
    // Dumps: pairs and walls apart, in the columns that LIGGGHTS gives them.
    let dump = |what: &str, rows: &dyn Fn(&Snapshot, &mut String)| {
        let mut text = String::new();
        for (place, frame) in frames.iter().enumerate() {
            let mut own = String::new();
            rows(frame, &mut own);
            let count = own.lines().count();
            let _ = write!(
                text,
                "ITEM: TIMESTEP\n{}\nITEM: NUMBER OF ATOMS\n{count}\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\nITEM: {what}\n{own}",
                place * 100
            );
        }
        text
    };
    let names = |name: &str, count: usize| {
        format!("ENTRIES {}", (1..=count).map(|at| format!("c_{name}[{at}]")).collect::<Vec<_>>().join(" "))
    };
    let pairs = |frame: &Snapshot, to: &mut String| {
        for contact in frame.contacts.iter().filter(|contact| contact.second.is_grain()) {
            let Partner::Grain(second) = contact.second else { continue };
            let ([f, g, h], [x, y, z]): ([f64; 3], _) = ((-contact.force_on_partner()).into(), contact.point);
            let _ = writeln!(to, "{} {} 0 {f:e} {g:e} {h:e} {x:e} {y:e} {z:e}", contact.first + 7, second + 7);
        }
    };
    let walls = |frame: &Snapshot, to: &mut String| {
        for contact in &frame.contacts {
            let Partner::Wall(wall) = contact.second else { continue };
            let ([f, g, h], [x, y, z]): ([f64; 3], _) = ((-contact.force_on_partner()).into(), contact.point);
            let _ = writeln!(to, "{x:e} {y:e} {z:e} 0 0 0 {wall} 3 {} {f:e} {g:e} {h:e}", contact.first + 7);
        }
    };
    let grains = dump(&format!("ATOMS {}", GRAINS.replace('w', "omega")), &|frame, to| grain_rows(frame, &|_| {}, to));
    let contacts =
        [("pairs.dump", dump(&names("pairs", 9), &pairs)), ("walls.dump", dump(&names("walls", 12), &walls))];
    let named = |(name, text): &(&str, String)| {
        let columns = ["c_pairs:first,second,_,fx,fy,fz,px,py,pz", "c_walls:px,py,pz,_,_,_,wall,_,first,fx,fy,fz"];
        let columns = StatedColumns::joined(columns.map(|columns| columns.parse().unwrap()));
        parse(Path::new(name), text.clone().into_bytes(), &columns).unwrap()
    };
    let both = Tables {
        contacts: contacts.iter().flat_map(named).collect(),
        ..tables(&[("grains.dump", grains.clone())], &[]).unwrap()
    };
    let imported = assembled(&scene, &both).unwrap();
    same(&measure(&scene, &imported.recording), &wanted, MOVED_ON);
    // Without contacts, what needs none is the same, and the rest is left out.
    let imported = assembled(&scene, &tables(&[("grains.dump", grains)], &[]).unwrap()).unwrap();
    let lacks = [Content::DrivenWalls, Content::Contacts, Content::WallContacts];
    assert_eq!(imported.recording.lacks, lacks);
    let told = measure(&scene, &recording(frames.clone(), lacks.to_vec()));
    assert!(told.len() > 5 && told.len() < wanted.len());
    same(&measure(&scene, &imported.recording), &told, 1e-9);
}

/// What an observable is said to need is what it takes: with anything else lost it keeps its value.
#[test]
fn observables_need_what_they_say() {
    let (scene, frames) = packing();
    let stripped = |lost: Content, frame: &Snapshot| {
        let mut frame = frame.clone();
        match lost {
            Content::Velocities => frame.particles.iter_mut().for_each(|grain| grain.velocity = [7.0, -3.0, 2.0]),
            Content::Spins => frame.particles.iter_mut().for_each(|grain| grain.spin = [70.0, 1.0, 20.0]),
            Content::Contacts => frame.contacts.retain(|contact| !contact.second.is_grain()),
            Content::WallContacts => frame.contacts.retain(|contact| contact.second.is_grain()),
            Content::DrivenWalls => {}
        }
        frame
    };
    let whole = measure(&scene, &recording(frames.clone(), vec![]));
    for lost in [Content::Velocities, Content::Spins, Content::Contacts, Content::WallContacts] {
        let poor: Vec<Snapshot> = frames.iter().map(|frame| stripped(lost, frame)).collect();
        // Nothing is said to be missing: whatever depends on it shows.
        let changed = measure(&scene, &recording(poor, vec![]));
        let told = measure(&scene, &recording(frames.clone(), vec![lost]));
        for one in &whole {
            let find = |all: &[Measurement]| {
                all.iter().find(|other| other.observable == one.observable).map(|other| other.value)
            };
            let is_told = find(&told).is_some();
            if find(&changed) != Some(one.value) {
                assert!(!is_told, "{} changes without {lost:?}", one.observable);
            }
        }
        assert!(told.len() < whole.len(), "{lost:?}");
    }
}

/// Files that YADE 2023.02a has written of one state of sixty grains.
#[test]
fn files_of_yade_tell_the_same_grains() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/frames/yade");
    let read = |name: &str| {
        let file = folder.join(name);
        let mut frames = parse(&file, std::fs::read(&file).unwrap(), &StatedColumns::default()).unwrap();
        assert_eq!(frames.len(), 1, "{name}");
        frames.remove(0)
    };
    let column = |frame: &FrameTable, wanted: Column| -> Vec<f64> {
        let place = frame.columns.iter().position(|name| column_of(name) == Some(wanted)).unwrap();
        frame.rows().map(|row| row[place]).collect()
    };
    let vtu = read("spheres.400.vtu");
    assert_eq!((vtu.step, vtu.rows().count()), (Some(400), 60));
    for name in ["plain.txt", "attributes.txt", "spheres.vtk"] {
        let other = read(name);
        for wanted in [Column::Position(0), Column::Position(2), Column::Radius, Column::Velocity(2)] {
            let is_untold =
                matches!((name, wanted), ("plain.txt", Column::Velocity(_)) | ("spheres.vtk", Column::Radius));
            if !is_untold {
                let (a, b) = (column(&vtu, wanted), column(&other, wanted));
                let off = a.iter().zip(&b).map(|(a, b)| (a - b).abs() / (1e-3 + a.abs())).fold(0.0, f64::max);
                assert!(a.len() == b.len() && off < 2e-3, "{name} {wanted:?}: {off}");
            }
        }
    }
}

#[test]
fn what_is_wrong_is_told_with_file_line_and_remedy() {
    let (scene, _) = packing();
    let refused = |grains: &[(&str, &str)], contacts: &[(&str, &str)], words: &str| {
        let owned = |files: &[(&'static str, &str)]| -> Vec<(&'static str, String)> {
            files.iter().map(|(name, text)| (*name, text.to_string())).collect()
        };
        let leak = |files: &[(&str, &str)]| -> Vec<(&'static str, &'static str)> {
            files.iter().map(|(name, text)| (&*name.to_string().leak(), &*text.to_string().leak())).collect()
        };
        let (grains, contacts) = (leak(grains), leak(contacts));
        let found = tables(&owned(&grains), &owned(&contacts)).and_then(|tables| assembled(&scene, &tables));
        let error = found.expect_err(words).to_string();
        assert!(error.contains(words), "{error}");
    };
    refused(&[("a.csv", "")], &[], "a.csv: line 1: the file is empty");
    refused(&[("a.csv", "1,2,3,4\n")], &[], "the first row must name the columns");
    refused(&[("a.csv", "x,y,z,r\n0,0,0,1\n0,0,nan,1\n")], &[], "a.csv: line 3: column z: 'nan' is not finite");
    refused(&[("a.csv", "x,y,z,r\n0,0,0,1\n0,0,1\n")], &[], "a.csv: line 3:");
    refused(&[("a.csv", "x,y,z,r\r\n0,0,0,1\r\n0,0,nan,1\r\n")], &[], "a.csv: line 3: column z: 'nan' is not finite");
    refused(&[("a.csv", "x,y,z,r\r\n0,0,0,1\r\n0,0,1\r\n")], &[], "a.csv: line 3:");
    refused(&[("a.csv", "x,y,r\n0,0,1\n")], &[], "no columns x, y, z among x, y, r");
    refused(&[("a.csv", "x,y,z\n0,0,0\n")], &[], "no column radius or diameter");
    refused(&[("a.csv", "x,y,z,r\n0,0,0,-1\n")], &[], "a radius of -1 m");
    refused(&[("a.csv", "id,x,y,z,r\n1,0,0,0,1\n1,0,0,0,1\n")], &[], "two grains of a frame have one number");
    refused(&[("a.csv", "x,y,z,r\n0,0,0,1\n"), ("b.csv", "x,y,z,r\n0,0,0,1\n")], &[], "give --time-step");
    let grain = ("a.csv", "id,x,y,z,r\n1,0,0,0,1\n2,0,0,1.9,1\n");
    refused(&[grain], &[("c.csv", "first,second,fx,fy,fz\n1,3,0,0,1\n")], "c.csv: line 2: there is no grain 3");
    let twice = "c.csv: line 3: grains 2 and 1 touch twice in this frame";
    refused(&[grain], &[("c.csv", "first,second,fx,fy,fz\n1,2,0,0,-1\n2,1,0,0,1\n")], twice);
    refused(&[grain], &[("c.csv", "first,second,fx,fy,fz\n1,1,0,0,1\n")], "grains 1 and 1 of a contact are one");
    refused(&[grain], &[("c.csv", "first,wall,fx,fy,fz,px,py,pz\n1,9,0,0,1,0,0,0\n")], "there is no wall 9");
    refused(&[grain], &[("c.csv", "first,wall,fx,fy,fz\n1,0,0,0,1\n")], "needs its point");
    refused(&[grain], &[("c.csv", "first,second\n1,2\n")], "no column fx, fy, fz");
    refused(&[("a.dump", "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\n")], &[], "a.dump: line 5");
    refused(
        &[(
            "a.dump",
            "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS\n0 1\n0 1\n0 1\nITEM: ATOMS id xs ys zs\n1 0 0 0\n",
        )],
        &[],
        "scaled to the box",
    );
}

#[test]
fn files_are_numbered_by_the_last_number_of_their_names() {
    let number = |name: &str| number_in(Path::new(name));
    assert_eq!(number("run3/spheres.2000.vtu"), Some(2000));
    assert_eq!(number("v-spheres-0400.vtk"), Some(400));
    assert_eq!(number("größe7.csv"), Some(7));
    assert_eq!(number("grains.csv"), None);
    assert_eq!(number("99999999999999999999999.csv"), None);
}

#[test]
fn a_dump_in_other_units_than_si_is_refused_by_their_name() {
    let dump = |units: &str| {
        let frame = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\nITEM: ATOMS id x y z\n1 0 0 0\n";
        parse(Path::new("a.dump"), format!("{units}{frame}").into_bytes(), &StatedColumns::default())
    };
    let told = dump("ITEM: UNITS\nsi\nITEM: TIME\n0.5\n").unwrap();
    assert_eq!((told.len(), told[0].time), (1, Some(0.5)));
    assert_eq!(dump("").unwrap().len(), 1, "what tells no units is in SI");
    for units in ["cgs", "lj", "real", "metal", "micro", "SI "] {
        let error = dump(&format!("ITEM: UNITS\n{units}\n")).unwrap_err().to_string();
        let wanted =
            format!("a.dump: line 2: the dump is in units '{}'; write the dump in SI units ('units si')", units.trim());
        assert_eq!(error, wanted);
    }
    assert!(dump("ITEM: UNITS\nsi\nITEM: UNITS\ncgs\n").unwrap_err().to_string().contains("line 4"));
}

/// A grain at a height that tells the frame.
fn marked(frame: usize) -> String {
    format!("id,x,y,z,r\n1,0,0,{frame},1\n2,0,0,{},1\n", frame as f64 + 1.9)
}

/// The first grain's height, or the force on it, in the order of time.
fn heights(imported: &Imported) -> Vec<f64> {
    imported.recording.frames.iter().map(|frame| frame.particles[0].position[2]).collect()
}

#[test]
fn a_file_that_is_given_twice_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.csv");
    std::fs::write(&file, marked(0)).unwrap();
    let mut tables = Tables::default();
    tables.add_grains(&file, &StatedColumns::default()).unwrap();
    assert!(tables.add_grains(&file, &StatedColumns::default()).unwrap_err().to_string().contains("given twice"));
    // Grains and contacts may stand in one file.
    tables.add_contacts(&file, &StatedColumns::default()).unwrap();
    assert!(tables.add_contacts(&file, &StatedColumns::default()).unwrap_err().to_string().contains("given twice"));
}

#[test]
fn a_column_that_is_named_twice_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.csv");
    let added = |text: &str, columns: &[&str]| {
        std::fs::write(&file, text).unwrap();
        let columns = StatedColumns::from(columns.iter().map(ToString::to_string).collect::<Vec<_>>());
        [Tables::add_grains, Tables::add_contacts].map(|add| {
            add(&mut Tables::default(), &file, &columns).map_err(|error| error.to_string()).err().unwrap_or_default()
        })
    };
    let twice = "id,x,y,z,r,X\n1,0,0,0,1,2\n";
    for error in added(twice, &[]) {
        assert!(error.contains("a.csv: line 1: two columns are named X"), "{error}");
    }
    assert!(added("id,x,y,z,r\n1,0,0,0,1\n", &["id", "x", "y", "z", "x"])[0].contains("two columns are named x"));
    let names = ["id", "x", "y", "z", "vx", "velocity_x", "radius", "diameter"];
    let errors = [&names[..6], &[names[0], names[1], names[2], names[3], names[6], names[7]]].map(|names| {
        let row = vec!["1"; names.len()].join(",");
        added(&format!("{}\n{row}\n", names.join(",")), &[])[0].clone()
    });
    assert!(errors[0].contains("two columns tell the same, vx and velocity_x"), "{}", errors[0]);
    assert!(errors[1].contains("two columns tell the same, radius and diameter"), "{}", errors[1]);
    assert!(added("time,Time,x\n1,0,0\n", &[])[0].contains("a.csv: line 1: two columns are named Time"));
    // A temperature, or a time of another clock, has no meaning by its name.
    assert_eq!(added("time,t,T,x\n1,0,300,0\n", &[]), ["", ""]);
    // Named anew, each once; what means nothing may be there twice.
    assert_eq!(added(twice, &["id", "x", "y", "z", "r", "_"]), ["", ""]);
    assert_eq!(added("id,x,y,z,r,mass,mass\n1,0,0,0,1,2,2\n", &[]), ["", ""]);
}

#[test]
fn frames_of_one_time_are_one_only_where_they_are_the_same() {
    let (scene, _) = packing();
    let at = |name: &'static str, frame: usize| {
        let text = marked(frame).replace("id,", "time,id,").replace("\n1,", "\n0.5,1,").replace("\n2,", "\n0.5,2,");
        (name, text)
    };
    let twice = tables(&[at("a.csv", 3), at("b.csv", 3)], &[]).unwrap();
    let imported = assembled(&scene, &twice).unwrap();
    assert_eq!(heights(&imported), [3.0]);
    assert!(imported.notes.contains(&"1 frames are the same as another one at their time".to_string()));
    let error = assembled(&scene, &tables(&[at("a.csv", 3), at("b.csv", 4)], &[]).unwrap()).unwrap_err().to_string();
    assert!(error.contains("b.csv: line 2: it has a frame at 0.5 s, as a.csv has (line 2)"), "{error}");
}

/// A code that is started twice tells the frame in between twice.
#[test]
fn contacts_of_one_time_in_one_file_are_one_only_where_they_are_the_same() {
    let (scene, _) = packing();
    let grains =
        [("a.csv", marked(3).replace("id,", "time,id,").replace("\n1,", "\n0.5,1,").replace("\n2,", "\n0.5,2,"))];
    let frame = |force: f64| {
        format!(
            "ITEM: TIME\n0.5\nITEM: TIMESTEP\n0\nITEM: NUMBER OF ENTRIES\n1\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\nITEM: ENTRIES first second fx fy fz\n1 2 0 0 {force}\n"
        )
    };
    let given = |second: f64| {
        let contacts = [("pairs.dump", frame(-1.0) + &frame(second))];
        assembled(&scene, &tables(&grains, &contacts).unwrap())
    };
    assert_eq!(given(-1.0).unwrap().recording.frames[0].contacts.len(), 1);
    let error = given(-2.0).unwrap_err().to_string();
    assert!(error.contains("pairs.dump: line 24: it has two frames of contacts at 0.5 s"), "{error}");
}

#[test]
fn missing_grains_are_told() {
    let (scene, _) = packing();
    let grains = |text: &str| tables(&[("a.csv", format!("time,id,x,y,z,r\n{text}"))], &[]).unwrap();
    let notes = |text: &str| assembled(&scene, &grains(text)).unwrap().notes;
    assert_eq!(
        notes("0.3,1,0,0,0,1\n0.4,1,0,0,0,1\n0.4,2,0,0,0,1\n"),
        ["the frames have 1 to 2 grains, and the scene has 100: those that are there are measured"]
    );
    let all: String = (0..100).map(|id| format!("0.3,{id},0,0,{id},1\n")).collect();
    assert!(notes(&all).is_empty());
}

/// Contacts that are told of one frame only would count as none in the others.
#[test]
fn contacts_are_told_of_each_measured_frame_or_not_measured() {
    let (scene, frames) = packing();
    let text = |head: &str, rows: Rows, of: &dyn Fn(usize) -> bool| {
        let mut text = format!("time {head}\n");
        for (_, frame) in frames.iter().enumerate().filter(|(place, _)| of(*place)) {
            rows(frame, &|to| _ = write!(to, "{:e} ", frame.time), &mut text);
        }
        text.replace(' ', ",")
    };
    let grains = [("grains.csv", text(GRAINS, &grain_rows, &|_| true))];
    let last = frames.len() - 1;
    let imported = |of: &dyn Fn(usize) -> bool| {
        let contacts = [("contacts.csv", text(CONTACTS, &contact_rows, of))];
        assembled(&scene, &tables(&grains, &contacts).unwrap())
    };
    // Those before the first measured one may be left out.
    let late = imported(&|place| frames[place].time > 0.19).unwrap();
    assert!(measure(&scene, &late.recording).iter().any(|one| one.observable == "friction_mobilisation"));
    assert_eq!((late.recording.lacks, late.notes), (vec![Content::DrivenWalls], vec![]));
    for only in [2, last] {
        let Imported { recording, notes } = imported(&|place| place == only).unwrap();
        assert_eq!(recording.lacks, [Content::DrivenWalls, Content::Contacts, Content::WallContacts]);
        assert!(notes.len() == 1 && notes[0].starts_with("contacts.csv has no rows at "), "{notes:?}");
        assert!(measure(&scene, &recording).iter().all(|one| one.observable != "friction_mobilisation"));
    }
    // A file a frame, numbered by steps: heads alone tell that there are none.
    let files = |name: &'static str, lost: usize| -> Vec<(&'static str, String)> {
        let kept = (0..=last).filter(|place| *place != lost);
        let wall =
            |place| (&*format!("{name}.{}.csv", place * 100).leak(), "first,wall,fx,fy,fz,px,py,pz\n".to_string());
        kept.map(wall).collect()
    };
    let pairs = |place: usize| (&*format!("pairs.{}.csv", place * 100).leak(), "first,second,fx,fy,fz\n".to_string());
    let pairs: Vec<_> = (0..=last).map(pairs).collect();
    let both = |lost| assembled(&scene, &tables(&grains, &[pairs.clone(), files("walls", lost)].concat()).unwrap());
    assert!(both(1).is_ok());
    let error = both(last).unwrap_err().to_string();
    assert!(error.contains("walls.0.csv: line 2: no contacts are given for the frame at 0.3"), "{error}");
}
