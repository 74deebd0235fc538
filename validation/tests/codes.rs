//! The reference codes: meshes and parsers always; misbehaving programs through fakes; the real codes where they are installed.

use makadam::scene::{Domain, Shape};
use makadam::snapshot::{Contact, Partner};
use makadam_compare::codes::driver::read_frames;
use makadam_compare::codes::liggghts::loop_seconds;
use makadam_compare::codes::{Code, CodeError, Job, Lammps, Liggghts, Purpose, Yade, lammps};
use makadam_frames::import::{StatedColumns, merge_wall_contacts, parse};
use makadam_frames::output::mesh::{FINE, Mesh, wall_mesh};
use makadam_frames::plan::MeasuredScene;
use makadam_frames::recording::Recording;
use nalgebra::Vector3;
use proptest::prelude::*;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

const DOMAIN: Domain = Domain { min: [-1.0; 3], max: [1.0; 3], periodic: Vec::new() };

/// Sum of the triangles' area vectors, and the sum of their areas.
fn areas(mesh: &Mesh) -> (Vector3<f64>, f64) {
    mesh.triangles.iter().fold((Vector3::zeros(), 0.0), |(vector, area), [a, b, c]| {
        let (a, b, c) = (Vector3::from(*a), Vector3::from(*b), Vector3::from(*c));
        let own = (b - a).cross(&(c - a)) * 0.5;
        (vector + own, area + own.norm())
    })
}

#[test]
fn a_closed_box_encloses_its_volume_and_looks_inwards() {
    let shape = Shape::Box { min: [-0.1, -0.2, 0.0], max: [0.3, 0.2, 0.5], open: vec![] };
    let mesh = wall_mesh(&shape, &DOMAIN, 0.005, FINE);
    let (vector, area) = areas(&mesh);
    assert!(vector.norm() < 1e-12 && (area - 2.0 * (0.16 + 0.2 + 0.2)).abs() < 1e-12, "{vector} {area}");
    // The divergence theorem: with normals inwards the volume comes out negative.
    let volume: f64 = mesh
        .triangles
        .iter()
        .map(|[a, b, c]| Vector3::from(*a).dot(&Vector3::from(*b).cross(&Vector3::from(*c))) / 6.0)
        .sum();
    assert!((volume + 0.4 * 0.4 * 0.5).abs() < 1e-12, "{volume}");
}

#[test]
fn an_open_face_is_left_out_and_its_neighbours_go_on() {
    let shape = Shape::Box { min: [-0.1; 3], max: [0.1; 3], open: vec!["+z".into()] };
    let mesh = wall_mesh(&shape, &DOMAIN, 0.005, FINE);
    assert_eq!(mesh.triangles.len(), 10);
    let top = mesh.triangles.iter().flatten().map(|corner| corner[2]).fold(0.0, f64::max);
    assert!(top > 0.9, "{top}");
}

#[test]
fn planes_are_cut_beyond_the_domain_and_face_the_grains() {
    let normal = Vector3::new(0.3, -0.2, 1.0);
    let shape = Shape::Plane { point: [0.0, 0.0, 0.1], normal: normal.into() };
    let mesh = wall_mesh(&shape, &DOMAIN, 0.005, FINE);
    let (vector, area) = areas(&mesh);
    assert!((vector.norm() - area).abs() < 1e-12 && vector.dot(&normal) > 0.0);
    for corner in mesh.triangles.iter().flatten() {
        assert!((Vector3::from(*corner) - Vector3::new(0.0, 0.0, 0.1)).dot(&normal).abs() < 1e-12);
        assert!(corner.iter().all(|x| x.abs() < 2.0 + 1e-6), "{corner:?}");
    }
    let beyond = Shape::Plane { point: [0.0, 0.0, 5.0], normal: [0.0, 0.0, 1.0] };
    assert!(wall_mesh(&beyond, &DOMAIN, 0.005, FINE).triangles.is_empty());
}

#[test]
fn cylinders_and_discs_have_their_areas_and_fine_facets() {
    let shape = Shape::Cylinder { base: [0.0, -0.1, 0.0], axis: [0.0, 2.0, 0.0], radius: 0.1, length: 0.2 };
    let mesh = wall_mesh(&shape, &DOMAIN, 0.005, FINE);
    let (vector, area) = areas(&mesh);
    let exact = std::f64::consts::TAU * 0.1 * 0.2;
    assert!(vector.norm() < 1e-12 && (area / exact - 1.0).abs() < 1e-3, "{area} {exact}");
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(Vector3::from);
        let middle = (a + b + c) / 3.0;
        let inwards = -Vector3::new(middle.x, 0.0, middle.z);
        assert!((b - a).cross(&(c - a)).dot(&inwards) > 0.0);
        // The deepest point of a facet lies on a line along the axis, half-way between its corners.
        assert!(triangle.iter().all(|[x, _, z]| (x.hypot(*z) - 0.1).abs() < 0.01 * 0.005));
    }
    assert!(mesh.bend < 360.0 / 100.0 + 1e-9);

    let disc = Shape::Disc { centre: [0.1, 0.0, 0.0], normal: [0.0, 1.0, 1.0], radius: 0.1, hole: 0.0 };
    let (vector, area) = areas(&wall_mesh(&disc, &DOMAIN, 0.005, FINE));
    assert!((area / (std::f64::consts::PI * 0.01) - 1.0).abs() < 0.01, "{area}");
    assert!((vector.normalize() - Vector3::new(0.0, 1.0, 1.0).normalize()).norm() < 1e-9);

    let ring = Shape::Disc { centre: [0.1, 0.0, 0.0], normal: [0.0, 1.0, 1.0], radius: 0.1, hole: 0.04 };
    let (vector, area) = areas(&wall_mesh(&ring, &DOMAIN, 0.005, FINE));
    assert!((area / (std::f64::consts::PI * (0.01 - 0.0016)) - 1.0).abs() < 0.01, "{area}");
    // All triangles face the same way.
    assert!((vector.norm() / area - 1.0).abs() < 1e-9);
    assert!((vector.normalize() - Vector3::new(0.0, 1.0, 1.0).normalize()).norm() < 1e-9);
}

/// Smallest angle of any triangle of a mesh, degrees.
fn sharpest_angle(mesh: &Mesh) -> f64 {
    let angles = mesh.triangles.iter().flat_map(|triangle| {
        let corners = triangle.map(Vector3::from);
        [0, 1, 2].map(|at| {
            let [here, one, other] = [0, 1, 2].map(|step| corners[(at + step) % 3]);
            (one - here).angle(&(other - here)).to_degrees()
        })
    });
    angles.fold(f64::INFINITY, f64::min)
}

#[test]
fn a_frustum_and_a_rectangle_have_their_areas_as_meshes() {
    let cone = Shape::Frustum { base: [0.0; 3], axis: [0.0, 0.0, 1.0], radii: [0.1, 0.04], length: 0.08 };
    let mesh = wall_mesh(&cone, &DOMAIN, 0.005, FINE);
    let (_, area) = areas(&mesh);
    let expected = std::f64::consts::PI * 0.14 * 0.1;
    assert!((area / expected - 1.0).abs() < 1e-3, "{area} m2, not {expected}");
    assert!(mesh.bend > 0.0);
    let sheet = Shape::Rectangle { corner: [0.1, 0.0, 0.0], edges: [[0.2, 0.0, 0.0], [0.0, 0.1, 0.1]] };
    let mesh = wall_mesh(&sheet, &DOMAIN, 0.005, FINE);
    assert_eq!(mesh.triangles.len(), 2);
    assert!((areas(&mesh).1 - 0.02 * 2.0_f64.sqrt()).abs() < 1e-15);
}

#[test]
fn no_mesh_has_triangles_without_an_area_or_like_needles() {
    // LIGGGHTS refuses meshes with angles of a degree. No grain of 5 mm sees a hole of a micrometre.
    for hole in [1e-300, 1e-9, 1e-6, 4e-4, 6e-4, 0.001, 0.01, 0.05, 0.099] {
        let shape = Shape::Disc { centre: [0.1, 0.0, 0.0], normal: [0.0, 1.0, 1.0], radius: 0.1, hole };
        let mesh = wall_mesh(&shape, &DOMAIN, 0.005, FINE);
        let (vector, area) = areas(&mesh);
        let exact = std::f64::consts::PI * (0.01 - hole * hole);
        assert!((area / exact - 1.0).abs() < 0.01 && (vector.norm() / area - 1.0).abs() < 1e-9, "{hole}: {area}");
        assert!(hole > 0.05 || sharpest_angle(&mesh) > 1.5, "{hole}: {}", sharpest_angle(&mesh));
        assert!(mesh.triangles.iter().flatten().flatten().all(|number| number.is_finite()));
    }
    // A plane through a corner of the domain leaves nothing, or a sliver, of which no triangle is made.
    for shift in [0.0, 1e-16, 1e-13] {
        let shape = Shape::Plane { point: [2.0 - shift; 3], normal: [-1.0; 3] };
        let mesh = wall_mesh(&shape, &DOMAIN, 0.005, FINE);
        assert!(mesh.triangles.is_empty() || sharpest_angle(&mesh) > 0.1, "{mesh:?}");
    }
}

#[test]
fn contacts_with_two_triangles_of_one_face_are_one() {
    let touch = |angle: f64, force: f64| Contact {
        first: 3,
        second: Partner::Wall(1),
        point: [0.0; 3],
        normal: [angle.sin(), 0.0, -angle.cos()],
        normal_force: force,
        tangential_force: [0.0, 0.5, 0.0],
    };
    let merged = merge_wall_contacts(vec![touch(0.05, 1.0), touch(1.57, 2.0), touch(-0.05, 1.0)]);
    assert_eq!(merged.len(), 2);
    assert!((merged[0].normal_force - 2.0 * 0.05f64.cos()).abs() < 1e-12 && merged[0].normal[0].abs() < 1e-12);
    assert_eq!(merged[0].tangential_force[1], 1.0);
    assert_eq!(merged[1], touch(1.57, 2.0));
}

fn dump_text(rows: &str, count: usize) -> String {
    format!(
        "ITEM: TIMESTEP\n40\nITEM: NUMBER OF ENTRIES\n{count}\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\nITEM: ENTRIES c_1[1] c_1[2] c_1[3] \n{rows}"
    )
}

#[test]
fn dumps_are_read_frame_by_frame() {
    let columns = "c_1:fx,fy,fz".parse::<StatedColumns>().unwrap();
    let read = |text: &[u8]| parse(Path::new("a.dump"), text.to_vec(), &columns);
    let text = dump_text("1 2 -3.5e-3\n4 5 6 \n", 2) + &dump_text("", 0);
    let frames = read(text.as_bytes()).unwrap();
    assert_eq!(frames.len(), 2);
    assert_eq!((frames[0].step, frames[0].line), (Some(40), 10));
    assert_eq!(frames[0].rows().collect::<Vec<_>>(), [&[1.0, 2.0, -3.5e-3][..], &[4.0, 5.0, 6.0]]);
    assert_eq!(frames[1].rows().count(), 0);
    // Torn, short and blown-up dumps say where.
    assert_eq!(read(dump_text("1 2 3\n", 2).as_bytes()).unwrap_err().line, 11);
    assert!(read(dump_text("1 2\n", 1).as_bytes()).unwrap_err().problem.contains("3 belong"));
    assert!(read(dump_text("1 nan 3\n", 1).as_bytes()).unwrap_err().problem.contains("diverged"));
    assert!(read(&[0xFF, 0xFE, b'\n']).is_err());
}

#[test]
fn stepping_time_leaves_output_out() {
    let log = "Loop time of 12.5 on 1 procs for 100 steps\nPair  time (%) = 3 (2)\nOutpt time (%) = 0.5 (4)\n\
               Loop time of 2 on 1 procs\n";
    assert!((loop_seconds(log) - 14.0).abs() < 1e-12);
    let log = "Loop time of 12.5 on 1 procs for 100 steps with 8 atoms\nSection |  min time  |  avg time\n\
               Pair    | 3 | 3 | 3 |   0.0 | 24\nOutput  | 0.5 | 0.5 | 0.5 |   0.0 |  4.00\n";
    assert!((lammps::loop_seconds(log) - 12.0).abs() < 1e-12);
}

proptest! {
    #[test]
    fn no_bytes_make_the_parsers_panic(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        let _ = parse(Path::new("a"), bytes.clone(), &StatedColumns::default());
        let _ = read_frames(&bytes, &[0.1, 0.2], 1);
        let _ = loop_seconds(&String::from_utf8_lossy(&bytes));
        let _ = lammps::loop_seconds(&String::from_utf8_lossy(&bytes));
    }

    #[test]
    fn no_rows_make_the_parsers_panic(rows in "[0-9a-z .\\-\n]{0,120}", count in 0usize..6,
                                      numbers in proptest::collection::vec(-3.0f64..6.0, 0..60)) {
        let _ = parse(Path::new("a"), dump_text(&rows, count).into_bytes(), &StatedColumns::default());
        let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.round().to_le_bytes()).collect();
        let _ = read_frames(&bytes, &[0.1, 0.2], 1);
    }
}

/// A scene of materials `m` and walls and grains in TOML.
fn scene(gravity: &str, duration: f64, interval: f64, materials: &str, body: &str) -> MeasuredScene {
    let text = format!(
        "name = 'codes'\ndescription = 'x'\nduration = {duration}\ngravity = {gravity}\n\
         domain = {{ min = [-0.3, -0.3, -0.3], max = [0.3, 0.3, 0.3] }}\n\
         [measure]\ninterval = {interval}\nfrom = 0.0\n{materials}{body}"
    );
    MeasuredScene::parse(&text).unwrap_or_else(|error| panic!("{error}"))
}

fn material(name: &str, friction: f64) -> String {
    format!(
        "[material.{name}]\ndensity = 2500\nyoungs_modulus = 1e7\npoisson_ratio = 0.3\nfriction = {friction}\n\
         restitution = 0.3\n"
    )
}

fn grain(position: [f64; 3], velocity: [f64; 3]) -> String {
    format!("[[grain]]\nmaterial = 'm'\nradius = 0.005\nposition = {position:?}\nvelocity = {velocity:?}\n")
}

fn simulate(
    code: &dyn Code,
    scene: &MeasuredScene,
    fraction: f64,
    folder: &Path,
    seconds: f64,
) -> Result<Recording, CodeError> {
    code.simulate(&Job {
        scene,
        scene_file: Path::new("codes.toml"),
        purpose: Purpose::Measuring,
        seed: 1,
        stiffness_factor: 1.0,
        rayleigh_fraction: fraction,
        work_folder: folder,
        time_limit: Duration::from_secs_f64(seconds),
        progress: &|done| assert!((0.0..=1.0).contains(&done)),
    })
}

fn one_grain() -> MeasuredScene {
    scene("[0, 0, -9.81]", 0.01, 0.01, &material("m", 0.5), &grain([0.0; 3], [0.0; 3]))
}

/// A program that answers for its version and then does what `deed` says.
fn fake(folder: &Path, deed: &str) -> PathBuf {
    let file = folder.join("fake");
    let text = format!(
        "#!/bin/sh\ncase \"$1\" in\n--version) echo 'Yade version: 1.2'; exit;;\n\
         -help) echo 'LIGGGHTS (Version LIGGGHTS-PUBLIC 1.2, compiled'; echo 'Parallel Simulator - 1.2'; exit;;\nesac\n{deed}\n"
    );
    write_program(&file, &text);
    file
}

/// Writes a script through another process. Were it open for writing in this one, children that tests beside this one
/// start at that moment would inherit it open, and the system runs no file that someone may still write (`ETXTBSY`).
fn write_program(file: &Path, text: &str) {
    let draft = file.with_extension("draft");
    std::fs::write(&draft, text).unwrap();
    assert!(Command::new("install").args(["-m", "755"]).args([&draft, file]).status().unwrap().success());
}

fn all(program: &Path) -> [Box<dyn Code>; 3] {
    [Box::new(Yade::new(program)), Box::new(Liggghts::new(program)), Box::new(Lammps::new(program))]
}

#[test]
fn a_code_that_is_not_there_is_missing() {
    let folder = tempfile::tempdir().unwrap();
    for code in all(Path::new("/nowhere/code")) {
        assert_eq!(code.version(), None);
        let error = simulate(&*code, &one_grain(), 0.2, folder.path(), 5.0).unwrap_err();
        assert!(matches!(error, CodeError::Missing { .. }) && error.to_string().contains("install-codes"));
    }
}

#[test]
fn a_code_that_crashes_leaves_its_last_words() {
    let folder = tempfile::tempdir().unwrap();
    for code in all(&fake(folder.path(), "echo 'segmentation of the bed'; kill -SEGV $$")) {
        assert_eq!(code.version().as_deref(), Some("1.2"));
        match simulate(&*code, &one_grain(), 0.2, folder.path(), 5.0).unwrap_err() {
            CodeError::Crashed { log, tail, status, .. } => {
                assert!(tail.contains("segmentation of the bed") && status.contains("signal"), "{tail} {status}");
                assert!(log.is_file());
            }
            other => panic!("{other}"),
        }
    }
}

#[test]
fn a_reason_in_the_own_log_of_a_code_is_told_and_stands_in_the_log_that_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let deed = "printf 'Reading mesh\\nERROR: Mesh wall1: a needle\\nLast input line\\n' > engine.log; echo MPI_ABORT was invoked; exit 1";
    match simulate(&Liggghts::new(fake(folder.path(), deed)), &one_grain(), 0.2, folder.path(), 5.0).unwrap_err() {
        CodeError::Crashed { log, tail, .. } => {
            assert!(tail.starts_with("ERROR: Mesh wall1: a needle") && tail.contains("MPI_ABORT"), "{tail}");
            assert!(std::fs::read_to_string(log).unwrap().contains("ERROR: Mesh wall1: a needle"));
        }
        other => panic!("{other}"),
    }
}

#[test]
fn a_code_that_stops_early_or_writes_nonsense_is_told() {
    let folder = tempfile::tempdir().unwrap();
    for deed in ["exit 0", "for f in grains pairs walls; do echo nonsense > $f.dump; done; echo '{}' > result.json"] {
        for code in all(&fake(folder.path(), deed)) {
            let error = simulate(&*code, &one_grain(), 0.2, folder.path(), 5.0).unwrap_err();
            assert!(matches!(error, CodeError::Output { .. } | CodeError::Io { .. }), "{error}");
        }
    }
}

#[test]
fn a_code_that_hangs_is_stopped_with_its_children() {
    let folder = tempfile::tempdir().unwrap();
    for code in all(&fake(folder.path(), "sleep 600 & echo $! > child; wait")) {
        let start = Instant::now();
        let error = simulate(&*code, &one_grain(), 0.2, folder.path(), 0.5).unwrap_err();
        assert!(matches!(error, CodeError::TimedOut { .. }), "{error}");
        assert!(start.elapsed() < Duration::from_secs(5));
        let child = std::fs::read_to_string(folder.path().join("child")).unwrap();
        let state = || std::fs::read_to_string(format!("/proc/{}/stat", child.trim())).unwrap_or_default();
        // Killed, though whoever inherits it may not have reaped it yet.
        while !(state().is_empty() || state().contains(") Z ")) {
            assert!(start.elapsed() < Duration::from_secs(10), "the child outlived the run: {}", state());
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}

#[test]
fn a_folder_that_cannot_be_written_is_an_io_error() {
    let folder = tempfile::tempdir().unwrap();
    let program = fake(folder.path(), "exit 0");
    for code in all(&program) {
        let error = simulate(&*code, &one_grain(), 0.2, &program.join("run"), 5.0).unwrap_err();
        assert!(matches!(error, CodeError::Io { .. }), "{error}");
    }
}
