//! Frames of a packing and of small tables, read back; helpers of all tests.

use makadam::Simulation;
use makadam::snapshot::{Contact, Partner, Snapshot};
use makadam_compare::scenes;
use makadam_frames::import::{
    Column, FrameTable, ImportError, Manifest, StatedColumns, Tables, assemble, column_of, parse,
};
use makadam_frames::plan::MeasuredScene;
use makadam_frames::recording::{Content, Recording};
use makadam_measure::observables::{Measurement, measure};
use std::fmt::Write;
use std::path::Path;

mod contacts;
mod files;
mod statements;

/// Time between frames, s.
const INTERVAL: f64 = 0.02;

/// A packing of a hundred grains, and frames of it.
fn packing() -> (MeasuredScene, Vec<Snapshot>) {
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

/// Steps between frames.
const STEPS: usize = 20;

/// Statements of frames that are numbered by steps, and whose lists of contacts are complete.
fn stated() -> Manifest {
    Manifest { time_step: Some(INTERVAL / STEPS as f64), contacts_complete: true, ..Manifest::default() }
}

/// Statements of a single frame.
fn at(time: f64) -> Manifest {
    Manifest { time: Some(time), contacts_complete: true, ..Manifest::default() }
}

fn assembled(scene: &MeasuredScene, tables: &Tables) -> Result<Recording, ImportError> {
    assemble(scene, &stated(), tables)
}

/// Text of the error of frames that are refused.
fn refusal(
    scene: &MeasuredScene,
    manifest: &Manifest,
    grains: &[(&str, String)],
    contacts: &[(&str, String)],
) -> String {
    let found = tables(grains, contacts).and_then(|tables| assemble(scene, manifest, &tables));
    found.expect_err("the frames are refused").to_string()
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

/// Tables without normals have them taken from the centres, which have moved on since the contacts were found.
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
fn tables_measure_as_their_frames() {
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
    assert_eq!(imported.lacks, [Content::DrivenWalls]);
    same(&measure(&scene, &imported), &wanted, 1e-9);
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
                place * STEPS
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
    same(&measure(&scene, &imported), &wanted, MOVED_ON);
    // Without contacts, what needs none is the same, and the rest is left out.
    let imported = assembled(&scene, &tables(&[("grains.dump", grains)], &[]).unwrap()).unwrap();
    let lacks = [Content::DrivenWalls, Content::Contacts, Content::WallContacts];
    assert_eq!(imported.lacks, lacks);
    let rest = measure(&scene, &recording(frames.clone(), lacks.to_vec()));
    assert!(rest.len() > 5 && rest.len() < wanted.len());
    same(&measure(&scene, &imported), &rest, 1e-9);
}

/// An observable keeps its value without contents that it does not need.
#[test]
fn observables_state_their_needs() {
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
        // Observables that depend on it change.
        let changed = measure(&scene, &recording(poor, vec![]));
        let rest = measure(&scene, &recording(frames.clone(), vec![lost]));
        for one in &whole {
            let find = |all: &[Measurement]| {
                all.iter().find(|other| other.observable == one.observable).map(|other| other.value)
            };
            let is_kept = find(&rest).is_some();
            if find(&changed) != Some(one.value) {
                assert!(!is_kept, "{} changes without {lost:?}", one.observable);
            }
        }
        assert!(rest.len() < whole.len(), "{lost:?}");
    }
}

/// Files of YADE 2023.02a of one state of sixty grains.
#[test]
fn yade_formats_agree() {
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
    assert_eq!(vtu.rows().count(), 60);
    for name in ["plain.txt", "attributes.txt", "spheres.vtk"] {
        let other = read(name);
        for wanted in [Column::Position(0), Column::Position(2), Column::Radius, Column::Velocity(2)] {
            let is_absent =
                matches!((name, wanted), ("plain.txt", Column::Velocity(_)) | ("spheres.vtk", Column::Radius));
            if !is_absent {
                let (a, b) = (column(&vtu, wanted), column(&other, wanted));
                let off = a.iter().zip(&b).map(|(a, b)| (a - b).abs() / (1e-3 + a.abs())).fold(0.0, f64::max);
                assert!(a.len() == b.len() && off < 2e-3, "{name} {wanted:?}: {off}");
            }
        }
    }
}

/// A dump of one frame.
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
