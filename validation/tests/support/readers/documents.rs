//! Small sound documents of every kind.

use makadam::Simulation;
use makadam::snapshot::{Contact, DrivenWall, Particle, Partner, Snapshot};
use makadam_compare::compare::MeasuredRun;
use makadam_compare::study::{Key, sealed};
use makadam_frames::plan::MeasuredScene;
use makadam_frames::recording::Recording;
use makadam_measure::observables::Measurement;
use std::collections::HashMap;
use std::path::Path;
use std::sync::OnceLock;

/// Beginning of the line in front of a part of a document; the part's name follows.
pub const PART: &str = "==> ";

const MATERIALS: &str = "
[material.grain]
density = 2500.0
youngs_modulus = 1e7
poisson_ratio = 0.3
friction = 0.5
restitution = 0.3

[material.wall]
density = 2500.0
youngs_modulus = 1e7
poisson_ratio = 0.3
friction = 0.3
restitution = 0.5
";

/// Grains that are listed, and touch.
pub const SMALL_SCENE: &str = r#"
[[pair]]
between = ["grain", "wall"]
friction = 0.4

[[wall]]
name = "floor"
material = "wall"
shape = { kind = "plane", point = [0.0, 0.0, 0.0], normal = [0.0, 0.1, 1.0] }

[[wall]]
name = "lid"
material = "wall"
shape = { kind = "plane", point = [0.0, 0.0, 0.02], normal = [0.0, 0.0, -1.0] }
motion = { kind = "force-driven", axis = [0.0, 0.0, 1.0], force = -0.01, mass = 0.002 }

[[grain]]
material = "grain"
radius = 0.005
position = [0.0, 0.0, 0.0051]
velocity = [0.1, 0.0, -0.2]
spin = [0.0, 3.0, 0.0]

[[grain]]
material = "grain"
radius = 0.004
position = [0.0, 0.0, 0.01408]

[solver]
step = 5e-4
normal_law = { kind = "hertz" }
stop = { kind = "sweeps", sweeps = 5 }
over_relaxation = 1.3
damping_steps = 1.0
skin = 0.6
warm_start = 1.0
"#;

/// A rough bed without end.
pub const PERIODIC_SCENE: &str = r#"
[[wall]]
name = "bed"
material = "wall"
shape = { kind = "spheres", centres = [[0.0, 0.0, 0.0], [0.01, 0.0, 0.001], [0.098, 0.05, 0.0]], radius = 0.005 }

[[grain]]
material = "grain"
radius = 0.005
position = [0.005, 0.0, 0.012]
velocity = [30.0, 0.0, 0.0]
"#;

/// A turning drum with an end cap and a box.
pub const WALLED_SCENE: &str = r#"
[[wall]]
name = "drum"
material = "wall"
shape = { kind = "cylinder", base = [0.0, -0.03, 0.0], axis = [0.0, 1.0, 0.0], radius = 0.05, length = 0.06 }
motion = { kind = "rotating", point = [0.0, 0.0, 0.0], axis = [0.0, 1.0, 0.0], rate = 3.0, start = 0.1, stop = 0.9 }

[[wall]]
name = "cap"
material = "wall"
shape = { kind = "disc", centre = [0.0, -0.03, 0.0], normal = [0.0, 1.0, 0.0], radius = 0.05 }
motion = { kind = "translating", velocity = [0.0, 0.001, 0.0], start = 0.2 }

[[wall]]
name = "box"
material = "wall"
shape = { kind = "box", min = [-0.06, -0.06, -0.06], max = [0.06, 0.06, 0.06], open = ["+z"] }

[[population]]
count = 8
material = "grain"
radius = { kind = "normal", mean = 0.005, deviation = 0.0005, min = 0.004, max = 0.006 }
region = { kind = "cylinder", base = [0.0, -0.03, 0.0], axis = [0.0, 1.0, 0.0], radius = 0.05, length = 0.06 }
spacing = 1.2
agitation = 0.1

[measure]
interval = 0.05
from = 0.1
observables = ["dynamic-angle-of-repose", "packing-fraction", "coordination-number", "contact-forces", "balances", "drum-flow"]

[[compare]]
observable = "packing_fraction"
margin = 0.006
"#;

/// A heap on a floor, of two sizes of grains.
pub const HEAP_SCENE: &str = r#"
[[wall]]
name = "floor"
material = "wall"
shape = { kind = "plane", point = [0.0, 0.0, -0.03], normal = [0.0, 0.0, 1.0] }

[[population]]
count = 8
material = "grain"
radius = { kind = "discrete", radii = [0.004, 0.005], shares = [1.0, 2.0] }
region = { kind = "box", min = [-0.03, -0.03, -0.03], max = [0.03, 0.03, 0.1] }

[measure]
interval = 0.05
from = 0.1
observables = ["static-angle-of-repose", "packing-fraction", "coordination-number", "contact-forces", "balances"]
"#;

/// A bed in a box.
pub const BED_SCENE: &str = r#"
[[wall]]
name = "box"
material = "wall"
shape = { kind = "box", min = [-0.06, -0.06, -0.06], max = [0.06, 0.06, 0.06], open = ["+z"] }

[[population]]
count = 8
material = "grain"
radius = { kind = "fixed", value = 0.005 }
region = { kind = "box", min = [-0.03, -0.03, -0.03], max = [0.03, 0.03, 0.06] }

[measure]
interval = 0.05
from = 0.1
observables = ["packing-fraction", "coordination-number", "contact-forces", "balances"]
"#;

/// For an accuracy, which decides on step and stop.
const ASKED_SCENE: &str = r#"
[[population]]
count = 6
material = "grain"
radius = { kind = "discrete", radii = [0.004, 0.005], shares = [1.0, 2.0] }
region = { kind = "box", min = [-0.02, -0.02, 0.0], max = [0.02, 0.02, 0.1] }

[solver]
normal_law = { kind = "linear", stiffness = 1e4 }
method = { kind = "anderson", memory = 3 }
"#;

/// Effects that change in time or with speed.
const CHANGING_SCENE: &str = r#"
[[pair]]
between = ["grain", "wall"]
kinetic_friction = 0.2
restitution_speed = 0.5

[[wall]]
name = "plate"
material = "wall"
shape = { kind = "plane", point = [0.0, 0.0, 0.0], normal = [0.0, 0.0, 1.0] }
motion = { kind = "vibrating", amplitude = [0.0, 1e-4, 1e-3], frequency = 20.0, start = 0.05, stop = 0.15 }

[[wall]]
name = "door"
material = "wall"
shape = { kind = "disc", centre = [0.01, 0.0, 0.0], normal = [-1.0, 0.0, 0.0], radius = 0.02 }
motion = { kind = "torque-driven", point = [0.01, 0.02, 0.0], axis = [0.0, 0.0, 1.0], torque = 1e-5, moment_of_inertia = 1e-6, start = 0.0005 }

[[grain]]
material = "grain"
radius = 0.005
position = [0.0, 0.0, 0.0051]

[solver]
normal_law = { kind = "rigid" }
"#;

/// The key in front of the first table that goes with it.
const CHANGES: &str =
    "gravity_changes = [{ time = 0.1, gravity = [0.0, 0.0, -12.0] }, { time = 0.15, gravity = [3.0, 0.0, -9.0] }]\n";

fn text(head: &str, rest: &str) -> String {
    format!(
        "name = \"small\"\ndescription = \"small\"\nduration = 0.2\ngravity = [0.0, 0.0, -9.81]\nseed = 3\n{head}\
         domain = {{ min = [-0.1, -0.1, -0.1], max = [0.1, 0.1, 0.2] }}\n{MATERIALS}{rest}"
    )
}

/// A scene from its walls and grains.
pub fn scene(rest: &str) -> MeasuredScene {
    let text = text("", rest);
    MeasuredScene::parse(&text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// Scenes.
pub fn scenes() -> Vec<Vec<u8>> {
    let asked = text("accuracy = { packing_fraction = 0.004 }\n", ASKED_SCENE);
    let changing = text(CHANGES, CHANGING_SCENE);
    let periodic = text("", PERIODIC_SCENE).replace("0.2] }", "0.2], periodic = [\"x\", \"y\"] }");
    [text("", SMALL_SCENE), text("", WALLED_SCENE), asked, changing, periodic].map(String::into_bytes).to_vec()
}

/// Checkpoints of the small scene: before its first step, and after some.
pub fn checkpoints() -> Vec<Vec<u8>> {
    static MADE: OnceLock<Vec<Vec<u8>>> = OnceLock::new();
    let make = || {
        let scene = scene(SMALL_SCENE);
        let mut simulation = Simulation::new(&scene, 1).expect("the scene is sound");
        let start = simulation.checkpoint();
        let touching = (0..1000).find(|_| simulation.step().contacts > 1 && !simulation.snapshot().contacts.is_empty());
        assert!(touching.is_some(), "no checkpoint with impulses");
        vec![start, simulation.checkpoint()]
    };
    MADE.get_or_init(make).clone()
}

fn frame(time: f64) -> Snapshot {
    let particles = (0..8).map(|id| Particle {
        id,
        position: [0.009 * f64::from(id) - 0.03, 0.0, -0.02 + 0.001 * f64::from(id)],
        radius: 0.005,
        velocity: [0.01, 0.0, -0.02],
        spin: [0.0, 1.0, 0.0],
    });
    let contact = |first, second| Contact {
        first,
        second,
        point: [0.0, 0.0, -0.02],
        normal: [1.0, 0.0, 0.0],
        normal_force: 0.5,
        tangential_force: [0.0, 0.1, 0.0],
    };
    let contacts = vec![contact(0, Partner::Grain(1)), contact(1, Partner::Grain(2)), contact(2, Partner::Wall(0))];
    let driven_walls = vec![DrivenWall { wall: 1, displacement: 0.01 * time, rate: 0.01 }];
    Snapshot { time, particles: particles.collect(), contacts, driven_walls, ..Snapshot::default() }
}

/// Recordings of the walled scene.
pub fn recordings() -> Vec<Vec<u8>> {
    let recording = Recording {
        scene: "small".into(),
        code: "YADE".into(),
        version: "1".into(),
        seed: 1,
        time_step: 1e-5,
        rayleigh_fraction: Some(0.1),
        stiffness_factor: 1.0,
        threads: 1,
        wall_seconds: 2.0,
        core_seconds: None,
        simulated_seconds: 0.2,
        frames: vec![frame(0.1), frame(0.15), frame(0.2)],
        lacks: Vec::new(),
        alarms: Vec::new(),
        notes: Vec::new(),
    };
    vec![recording.to_bytes()]
}

/// Radii of the grains of YADE's frames, m.
pub const RADII: [f64; 3] = [0.005, 0.004, 0.003];

/// Frames as YADE's driver writes them.
pub fn yade_frames() -> Vec<Vec<u8>> {
    let mut numbers: Vec<f64> = Vec::new();
    for (time, contacts) in [(0.0, 0_u8), (0.1, 3)] {
        numbers.extend([time, RADII.len() as f64, f64::from(contacts)]);
        for grain in 0..RADII.len() {
            numbers.extend([0.01 * grain as f64, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.0, 2.0]);
        }
        for contact in 0..contacts {
            // Two grains, then a grain and a wall, twice the same.
            let (kind, partner) = if contact == 0 { (0.0, 1.0) } else { (1.0, 1.0) };
            numbers.extend([0.0, kind, partner, 0.005, 0.0, 0.0, 1.0, 0.0, 0.0, -0.5, 0.1, 0.0]);
        }
    }
    vec![numbers.iter().flat_map(|number| number.to_le_bytes()).collect()]
}

/// Two driven walls in two frames of YADE.
pub fn yade_driven_walls() -> Vec<Vec<u8>> {
    let numbers = [0.0, 0.0, 0.1, 0.2, -0.001, -0.05, 0.2, 0.0];
    vec![numbers.iter().flat_map(|number: &f64| number.to_le_bytes()).collect()]
}

/// Report of YADE's driver on a run.
pub fn yade_results() -> Vec<Vec<u8>> {
    vec![b"{\"seconds\": 12.5, \"steps\": 4000}".to_vec()]
}

/// Frames of other codes in every format that is read, by what stands at their beginning.
pub fn foreign_frames() -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/frames/yade");
    let file = |name: &str| std::fs::read(folder.join(name)).unwrap();
    let dump = "ITEM: UNITS\nsi\nITEM: TIME\n0.15\nITEM: TIMESTEP\n3\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\n\
                ITEM: ATOMS id x y z radius vx vy vz\n1 0 0 0 0.005 0 0 0\n2 0.01 0 0 0.005 1 0 0\n";
    vec![
        b"time,id,x,y,z,radius,vx,vy,vz,first,second,wall,fx,fy,fz,px,py,pz\n\
          0.15,0,0,0,0,0.005,0,0,0,0,1,-1,0.5,0,0,0.005,0,0\n0.15,1,0.01,0,0,0.005,0,0,0,1,-1,0,0,0.25,0,0.01,0.005,0\n"
            .to_vec(),
        dump.into(),
        file("plain.txt"),
        file("attributes.txt"),
        file("spheres.vtk"),
        file("spheres.400.vtu"),
    ]
}

/// The end of a log.
pub fn liggghts_logs() -> Vec<Vec<u8>> {
    vec![
        b"Step Atoms KinEng\n 0 8 1e-3\n 4000 8 1e-4\nLoop time of 12.5 on 1 procs for 4000 steps\nOutpt time (%) = 0.5 (4)\n"
            .to_vec(),
    ]
}

/// The end of a log of LAMMPS.
pub fn lammps_logs() -> Vec<Vec<u8>> {
    let text = "   Step          Atoms         KinEng\n      4000   8   1e-4\n\
                Loop time of 12.5 on 1 procs for 4000 steps with 8 atoms\n\
                Section |  min time  |  avg time  |  max time  |%varavg| %total\n\
                Output  | 0.5        | 0.5        | 0.5        |   0.0 |  4.00\n";
    vec![text.as_bytes().to_vec()]
}

/// The files of a folder of references.
pub fn references() -> Vec<Vec<u8>> {
    let made = "YADE,2023.02a,1,1e-5,0.1";
    vec![
        format!(
            "{PART}runs.csv\ncode,version,contact_law,seed,time_step,rayleigh_fraction,wall_seconds,simulated_seconds,\
             processor,date,scene_hash\nYADE,2023.02a,a law,1,1e-5,0.1,12.5,1.5,\"a processor, fast\",2026-01-02T03:04:05Z,0123456789abcdef\n\
             LIGGGHTS,3.8.0,a law,2,1e-5,,12.5,1.5,a processor,2026-01-02T03:04:05Z,0123456789abcdef\n\
             {PART}measurements.csv\ncode,version,seed,time_step,rayleigh_fraction,observable,unit,value,\
             standard_error,frames\n{made},packing_fraction,,0.59,,1\n{made},dynamic_angle,degrees,31.5,0.2,20\n\
             {PART}forces.csv\ncode,force_over_mean,density,samples\nYADE,0.125,0.5,77\nYADE,0.375,0.25,77\n\
             {PART}series.csv\ncode,seed,observable,time,value\nYADE,1,angle,0.0,30.0\nYADE,1,angle,0.5,31.5\n\
             {PART}final-state-yade.csv\nid,radius,x,y,z,vx,vy,vz,wx,wy,wz\n0,0.005,0.1,0.2,0.3,0,0,-0.25,0,0,1e-9\n"
        )
        .into_bytes(),
    ]
}

/// The run that is kept.
pub fn kept() -> MeasuredRun {
    let measurement = Measurement {
        observable: "packing_fraction".into(),
        unit: String::new(),
        value: 0.59,
        standard_error: Some(1e-3),
        frames: 3,
    };
    MeasuredRun {
        code: "Makadam".into(),
        version: "0.2.0".into(),
        contact_law: "a law".into(),
        seed: 1,
        time_step: 5e-4,
        rayleigh_fraction: None,
        wall_seconds: 1.25,
        core_seconds: None,
        simulated_seconds: 1.5,
        processor: "a processor".into(),
        date: "2026-01-02T03:04:05Z".into(),
        scene_hash: "0123456789abcdef".into(),
        measurements: vec![measurement],
    }
}

/// Its key.
pub fn key() -> Key {
    static MADE: OnceLock<Key> = OnceLock::new();
    let make = || Key::of_run("small".into(), &scene(SMALL_SCENE), 1, &["0.2.0", "a processor"]);
    MADE.get_or_init(make).clone()
}

/// Files of kept runs.
pub fn kept_runs() -> Vec<Vec<u8>> {
    vec![sealed(Ok(&kept()), &key())]
}

/// The parts of a document by their names.
pub fn parts(bytes: &[u8]) -> HashMap<String, &[u8]> {
    let mut parts = HashMap::new();
    let starts: Vec<usize> = (0..bytes.len()).filter(|&at| bytes[at..].starts_with(PART.as_bytes())).collect();
    for (number, &start) in starts.iter().enumerate() {
        let part = &bytes[start + PART.len()..starts.get(number + 1).copied().unwrap_or(bytes.len())];
        let line = part.iter().position(|&byte| byte == b'\n').unwrap_or(part.len());
        parts.insert(String::from_utf8_lossy(&part[..line]).into_owned(), &part[(line + 1).min(part.len())..]);
    }
    parts
}

/// Every number of a frame that a reader accepted is one.
pub fn check_contacts(frame: &Snapshot) {
    for contact in &frame.contacts {
        let vectors = [contact.point, contact.normal, contact.tangential_force];
        assert!(vectors.iter().flatten().all(|x| x.is_finite()) && contact.normal_force.is_finite(), "{contact:?}");
    }
    for grain in &frame.particles {
        let vectors = [grain.position, grain.velocity, grain.spin];
        assert!(vectors.iter().flatten().all(|x| x.is_finite()), "{grain:?}");
    }
}
