//! Contact problems in files: round trips to the bit, solvers against each other, damaged files.

use makadam::Simulation;
use makadam::scene::{Scene, Stop};
use makadam_studies::problem::{
    AGREEMENT, BodyVelocities, Check, FromSiconos, Method, ProblemFile, RECORDED, Settings, bytes, check, parse, pose,
    read,
};
use std::path::PathBuf;

const SETTINGS: Settings = Settings { tolerance: 1e-11, most_sweeps: 100_000 };

const NAMES: [&str; 3] = ["packing", "drum", "oedometer"];

fn recorded(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("studies/src/problem/recorded").join(name)
}

fn bytes_of(name: &str) -> Vec<u8> {
    std::fs::read(recorded(&format!("{name}.hdf5"))).unwrap()
}

/// The problem of a scene after some steps, with the answer of the lanes.
fn posed(name: &str, change: impl Fn(&mut Scene), steps: u32) -> ProblemFile {
    let path = recorded(&format!("{name}.toml"));
    let mut scene = Scene::load(&path).unwrap();
    change(&mut scene);
    let mut simulation = Simulation::new(&scene, 1).unwrap();
    for _ in 0..steps {
        simulation.step();
    }
    let stop = Stop::Residual { tolerance: 1e-11, max_sweeps: 200_000 };
    let (state, _) = simulation.solution_in_lanes(stop);
    let lanes = BodyVelocities { velocities: state.velocities, spins: state.spins };
    ProblemFile::new(name, simulation.contact_problem(), Some(lanes))
}

fn assert_agree(check: &Check) {
    // The reference stops at changes of 1e-11 g h; some 1e4 sweeps at most are between these and the solution.
    assert!(check.agrees(1e-6), "{check:#?}");
}

#[test]
fn a_problem_reads_back_to_the_bit() {
    for name in NAMES {
        let file = posed(name, |_| (), 300);
        assert!(file.contacts() > 20, "{name}: {}", file.contacts());
        let read = parse(bytes(&file, None).unwrap()).unwrap();
        // Debug tells numbers apart as bits do, but for NaN, of which there is none.
        assert_eq!(read, file, "{name}");
        assert_eq!(format!("{read:?}"), format!("{file:?}"), "{name}");
    }
    let torques = posed("packing", |scene| scene.material.values_mut().for_each(|one| one.rolling_friction = 0.1), 300);
    assert!(torques.local.is_none());
    assert_eq!(parse(bytes(&torques, None).unwrap()).unwrap(), torques);
    let checked = check(&torques, &SETTINGS, &FromSiconos::Nothing).unwrap();
    assert_eq!(checked.answers.len(), 2, "{checked:?}");
    assert_agree(&checked);
}

#[test]
fn recorded_problems_have_one_solution_by_all_solvers() {
    for name in NAMES {
        let file = read(&recorded(&format!("{name}.hdf5"))).unwrap();
        assert!(file.contacts() > 80, "{name}: {}", file.contacts());
        let checked = check(&file, &SETTINGS, &FromSiconos::Nothing).unwrap();
        let methods: Vec<Method> = checked.answers.iter().map(|answer| answer.method).collect();
        assert_eq!(methods, [Method::Reference, Method::Direct, Method::Lanes], "{:?}", checked.left_out);
        assert_agree(&checked);
    }
}

#[test]
fn a_solution_is_written_where_fclib_has_it() {
    let file = read(&recorded("packing.hdf5")).unwrap();
    let answer = makadam_studies::problem::solve(&file, Method::Direct, &SETTINGS).unwrap();
    let written = bytes(&file, Some(&answer.impulses)).unwrap();
    let hdf5 = hdf5_pure::File::from_bytes(written.clone()).unwrap();
    let flat = |vectors: &[nalgebra::Vector3<f64>]| vectors.iter().flatten().copied().collect::<Vec<f64>>();
    assert_eq!(hdf5.dataset("solution/r").unwrap().read_f64().unwrap(), flat(&answer.impulses));
    assert_eq!(hdf5.dataset("solution/u").unwrap().read_f64().unwrap(), flat(&answer.contact_velocities));
    assert_eq!(parse(written).unwrap(), file, "a solution is no part of the problem");
}

#[test]
fn a_cut_file_is_an_error() {
    for name in NAMES {
        let bytes = bytes_of(name);
        for share in 0..200 {
            let cut = bytes[..bytes.len() * share / 200].to_vec();
            parse(cut).unwrap_err();
        }
        parse(bytes[..bytes.len() - 1].to_vec()).unwrap_err();
    }
}

/// A flipped bit in numbers or their description is told; one that no reader looks at leaves the problem as it is.
#[test]
fn a_flipped_bit_is_an_error_or_changes_nothing() {
    let bytes = bytes_of("drum");
    let sound = parse(bytes.clone()).unwrap();
    let mut errors = 0;
    let places: Vec<usize> = (0..4096).chain((4096..bytes.len()).step_by(97)).collect();
    for &place in &places {
        let mut flipped = bytes.clone();
        flipped[place] ^= 1 << (place % 8);
        match parse(flipped) {
            Err(_) => errors += 1,
            Ok(read) => assert_eq!((&read.contact, &read.local), (&sound.contact, &sound.local), "byte {place}"),
        }
    }
    assert!(errors * 2 > places.len(), "{errors} of {}", places.len());
}

#[test]
fn what_is_wrong_is_told() {
    let told = |change: &dyn Fn(&mut ProblemFile)| {
        let mut file = posed("drum", |_| (), 300);
        change(&mut file);
        parse(bytes(&file, None).unwrap()).unwrap_err()
    };
    let not_finite = told(&|file| file.contact.as_mut().unwrap().contacts[3].bias = f64::NAN);
    assert!(not_finite.contains("contact 3") && not_finite.contains("not finite"), "{not_finite}");
    let no_body = told(&|file| file.contact.as_mut().unwrap().contacts[2].first = 10_000);
    assert!(no_body.contains("contact 2 names body 10000"), "{no_body}");
    let lengths = told(&|file| file.local.as_mut().unwrap().friction.truncate(1));
    assert!(lengths.contains("mu"), "{lengths}");
    let rows = told(&|file| file.lanes.as_mut().unwrap().spins.truncate(1));
    assert!(rows.contains("makadam/lanes"), "{rows}");
    let other = hdf5_pure::FileBuilder::new().finish().unwrap();
    assert!(parse(other).unwrap_err().contains("neither of the groups"));
    assert!(parse(b"no HDF5 at all".to_vec()).unwrap_err().contains("no HDF5 file"));
}

/// A file of FCLIB has no bodies: it is solved as W and q say.
#[test]
fn a_local_problem_alone_is_solved_directly() {
    let mut file = read(&recorded("drum.hdf5")).unwrap();
    let own = makadam_studies::problem::solve(&file, Method::Direct, &SETTINGS).unwrap();
    file.contact = None;
    file.lanes = None;
    let alone = parse(bytes(&file, None).unwrap()).unwrap();
    let answer = makadam_studies::problem::solve(&alone, Method::Direct, &SETTINGS).unwrap();
    for (one, other) in answer.contact_velocities.iter().zip(&own.contact_velocities) {
        assert!((one - other).amax() < 1e-9, "{one}, {other}");
    }
    makadam_studies::problem::solve(&alone, Method::Reference, &SETTINGS).unwrap_err();
}

/// Recorded results of Siconos stand with the problem that they were found for.
#[test]
fn answers_of_siconos_on_record_are_those_of_the_reference() {
    for recorded in &RECORDED {
        let impulses = recorded.siconos().unwrap();
        let file = recorded.problem().unwrap();
        let checked = check(&file, &Settings::DEFAULT, &FromSiconos::Recorded(impulses.clone())).unwrap();
        let found = checked.answers.iter().find(|answer| answer.method == Method::Siconos).unwrap();
        assert!(found.residual.unwrap() < 1e-8 * checked.unit, "{}: {found:?}", recorded.name);
        assert!(checked.agrees(1e-6), "{}: {checked:?}", recorded.name);
        // One impulse that is off by a thousandth is seen.
        let mut wrong = impulses;
        let largest = (0..wrong.len()).max_by(|&a, &b| wrong[a].norm().total_cmp(&wrong[b].norm())).unwrap();
        wrong[largest] *= 1.001;
        let checked = check(&file, &Settings::DEFAULT, &FromSiconos::Recorded(wrong)).unwrap();
        assert!(!checked.agrees(AGREEMENT), "{}: {checked:?}", recorded.name);
    }
}

#[test]
fn problems_on_record_are_those_that_their_scenes_pose() {
    for recorded in &RECORDED {
        let mut simulation = Simulation::new(&recorded.scene().unwrap(), 1).unwrap();
        while simulation.time() < recorded.time - 1e-9 {
            simulation.step();
        }
        let posed = pose(&simulation, recorded.name);
        assert!(posed.lanes.is_some(), "{}", recorded.name);
        let file = recorded.problem().unwrap();
        assert_eq!(posed.contacts(), file.contacts(), "{}", recorded.name);
    }
}
