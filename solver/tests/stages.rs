//! Stages of a process: ends, settings, motions; same bits on any threads and after a checkpoint.

use crate::common::bits::{same_bits_everywhere, start, steps};
use approx::assert_relative_eq;
use makadam::scene::{Motion, Scene, StageEnd};
use makadam::watch::{Trouble, Watchdog};
use makadam::{Simulation, Stage};

/// A box of glass grains under a lid, with `top` at the start of the text and `body` at its end.
fn text(top: &str, body: &str) -> String {
    format!(
        "name = 'press'\ndescription = 'stages'\n{top}\n\
         domain = {{ min = [-0.1, -0.1, -0.05], max = [0.2, 0.2, 0.3] }}\n\
         [material.glass]\ndensity = 2500.0\nyoungs_modulus = 1e7\npoisson_ratio = 0.3\nfriction = 0.5\nrestitution = 0.3\n\
         [[wall]]\nname = 'box'\nmaterial = 'glass'\n\
         shape = {{ kind = 'box', min = [0, 0, 0], max = [0.05, 0.05, 0.2], open = ['+z'] }}\n\
         [[wall]]\nname = 'lid'\nmaterial = 'glass'\nshape = {{ kind = 'plane', point = [0, 0, 0.15], normal = [0, 0, -1] }}\n\
         [[population]]\ncount = 150\nmaterial = 'glass'\nradius = {{ kind = 'uniform', mean = 0.004, spread = 0.2 }}\n\
         region = {{ kind = 'box', min = [0, 0, 0], max = [0.05, 0.05, 0.15] }}\n\
         [solver]\nstep = 4e-4\n{body}"
    )
}

fn read(text: &str) -> Scene {
    Scene::parse(text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// Fill, settle, compress, shear.
const PROCESS: &str = "
[[stage]]
name = 'fill'
duration = 0.12
[stage.material.glass]
friction = 0.1
[[stage]]
name = 'settle'
until = { kinetic_energy = 2e-8 }
at_most = 1.0
[[stage]]
name = 'compress'
until = { wall_force = { wall = 'lid', force = 3.0 } }
at_most = 2.0
motion = { lid = { kind = 'translating', velocity = [0, 0, -0.2] } }
solver = { step = 2e-4 }
[[stage]]
name = 'shear'
duration = 0.05
gravity = [0.0, 0.0, 0.0]
motion = { lid = { kind = 'translating', velocity = [0.1, 0, 0], start = 0.01 } }
solver = { step = 1e-4, stop = { kind = 'sweeps', sweeps = 20 } }
[stage.material.glass]
friction = 0.3
rolling_friction = 0.1
";

fn process() -> Scene {
    read(&text("", PROCESS))
}

/// Steps to the end of the last stage.
fn finish(simulation: &mut Simulation) {
    while !simulation.has_ended() {
        simulation.step();
        assert_eq!(simulation.overdue(), None);
    }
}

fn lid_force(simulation: &Simulation) -> f64 {
    let on_lid = |contact: &&makadam::Contact| contact.second == makadam::Partner::Wall(1);
    let frame = simulation.frame();
    frame
        .contacts()
        .iter()
        .filter(on_lid)
        .map(|contact| contact.force_on_partner())
        .sum::<nalgebra::Vector3<f64>>()
        .norm()
}

#[test]
fn a_process_goes_through_its_stages() {
    let scene = process();
    assert_relative_eq!(scene.duration, 0.12 + 1.0 + 2.0 + 0.05, epsilon = 1e-12);
    let mut simulation = start(&scene);
    simulation.open_ledger();
    let (mut number, mut force) = (0, 0.0);
    while !simulation.has_ended() {
        let before = simulation.stage().unwrap();
        simulation.step();
        let stage = simulation.stage().unwrap();
        if stage.number != number {
            // The next stage begins with the step after the one at whose end the condition holds.
            assert!(before.ended && stage.steps == 1, "{stage:?}");
            number = stage.number;
        }
        let grains = simulation.grains() as f64;
        match stage.number {
            1 => assert_eq!(stage.ended, simulation.energy().kinetic / grains <= 2e-8, "{stage:?}"),
            2 => {
                assert_eq!(stage.ended, lid_force(&simulation) >= 3.0, "{stage:?}");
                force = lid_force(&simulation);
            }
            _ => {}
        }
        let balance = simulation.balance().unwrap();
        assert!(
            balance.closure.abs() <= 1e-9 * balance.exchanged() + 1e-14 * balance.start.potential,
            "{stage:?}: {balance:#?}"
        );
        let scale = 1e-10 * balance.gravity_impulse[2].abs();
        assert!(balance.momentum_closure.iter().all(|error| error.abs() <= scale), "{stage:?}: {balance:#?}");
    }
    assert!((3.0..30.0).contains(&force), "{force} N");
    let stages = simulation.stages();
    let names: Vec<&str> = stages.iter().map(|stage| stage.name.as_str()).collect();
    assert_eq!(names, ["fill", "settle", "compress", "shear"]);
    assert_eq!((stages[0].steps, stages[3].steps), (300, 500));
    assert!(stages.windows(2).all(|pair| pair[0].end == pair[1].start) && stages.iter().all(|stage| stage.ended));
    for (stage, h) in stages.iter().zip([4e-4, 4e-4, 2e-4, 1e-4]) {
        assert_relative_eq!(stage.end - stage.start, stage.steps as f64 * h, epsilon = 1e-12);
    }
    assert_eq!(simulation.time_step(), 1e-4);
    assert!(simulation.effects().torques());
    // The lid went down at 0.2 m/s, then along x from 0.01 s of the last stage on.
    let ([x, _, z], _) = simulation.wall_displacement(1).unwrap();
    let down = 0.2 * (stages[2].end - stages[2].start);
    assert_relative_eq!(x, 0.1 * 0.04, epsilon = 1e-9);
    assert_relative_eq!(z, -down, epsilon = 1e-9);
    assert_eq!(simulation.snapshot().stage.unwrap().number, 3);
}

#[test]
fn a_process_has_the_same_bits_everywhere() {
    // Past the end of the last stage.
    let scene = process();
    let mut whole = start(&scene);
    finish(&mut whole);
    let count = whole.steps_taken() as usize;
    same_bits_everywhere(&scene, count + 20);
    // Right before, in and right after each change.
    let expected = whole.state_hash();
    let changes: Vec<u64> = whole.stages().iter().map(|stage| stage.steps).collect();
    let mut stopped = start(&scene);
    for stage in changes {
        for leg in [stage / 2, stage - stage / 2, 0, 1, 1] {
            let most = leg.min(count as u64 - stopped.steps_taken());
            steps(&mut stopped, most as usize);
            stopped = Simulation::resume(&scene, &stopped.checkpoint()).unwrap();
        }
        let reached = stopped.stages();
        let done: u64 = reached.iter().take(reached.len() - 1).map(|stage| stage.steps).sum();
        // The next leg begins at the start of the next stage but two steps.
        assert!(stopped.steps_taken() >= done);
    }
    finish(&mut stopped);
    assert_eq!(stopped.state_hash(), expected);
    assert_eq!(stopped.stages(), whole.stages());
}

#[test]
fn stages_without_changes_are_one_run() {
    let whole = read(&text("duration = 0.2", ""));
    let parted =
        read(&text("", "[[stage]]\nname = 'one'\nduration = 0.08\n[[stage]]\nname = 'two'\nduration = 0.12\n"));
    let (mut one, mut other) = (start(&whole), start(&parted));
    steps(&mut one, 500);
    finish(&mut other);
    assert_eq!((other.steps_taken(), other.state_hash()), (500, one.state_hash()));
    assert_eq!(other.time().to_bits(), one.time().to_bits());
}

#[test]
fn a_turned_wall_goes_on_from_its_pose() {
    let drum = "[[wall]]\nname = 'paddle'\nmaterial = 'glass'\nshape = { kind = 'disc', centre = [0.02, 0.0, 0.25], normal = [0, 0, 1], radius = 0.01 }\n\
                [[stage]]\nname = 'turn'\nduration = 0.1\n\
                motion = { paddle = { kind = 'rotating', point = [0, 0, 0.25], axis = [0, 1, 0], rate = 2.0 } }\n\
                [[stage]]\nname = 'on'\nduration = 0.1\n\
                motion = { paddle = { kind = 'rotating', point = [0, 0, 0.25], axis = [0, 1, 0], rate = 5.0 } }\n\
                [[stage]]\nname = 'rest'\nduration = 0.1\nmotion = { paddle = { kind = 'fixed' } }\n";
    let scene = read(&text("", drum));
    let mut simulation = start(&scene);
    finish(&mut simulation);
    let frame = simulation.snapshot();
    let own = scene.in_stage(2, &[]);
    let walls = makadam::wall::PlacedWalls::at(&own.wall, &own.domain, frame.time, &[], &frame.beginnings);
    let centre = walls.point_of(2, &[0.02, 0.0, 0.25].into());
    let angle: f64 = 0.1 * 2.0 + 0.1 * 5.0;
    assert_relative_eq!(centre.x, 0.02 * angle.cos(), epsilon = 1e-12);
    assert_relative_eq!(centre.z, 0.25 - 0.02 * angle.sin(), epsilon = 1e-12);
}

#[test]
fn sources_and_sinks_act_in_their_stage() {
    let flow = "[[insert]]\nmaterial = 'glass'\nstage = 'empty'\nfrom = 0.02\ntotal = 5\nradius = { kind = 'uniform', mean = 0.004, spread = 0.0 }\n\
                region = { kind = 'box', min = [0, 0, 0.16], max = [0.05, 0.05, 0.2] }\nvelocity = [0, 0, 0]\n\
                [[remove]]\nstage = 'empty'\nregion = { kind = 'box', min = [-0.1, -0.1, -0.04], max = [0.2, 0.2, 0.02] }\n\
                [[stage]]\nname = 'fill'\nduration = 0.2\n\
                [[stage]]\nname = 'empty'\nuntil = { removed_mass = 0.01 }\nat_most = 2.0\n\
                [[stage]]\nname = 'rest'\nduration = 0.1\n";
    let scene = read(&text("", &flow.replace("velocity = [0, 0, 0]", "")));
    let mut simulation = start(&scene);
    steps(&mut simulation, 500);
    assert_eq!(simulation.passed().map(|passed| passed.grains), [0, 0]);
    let (mut last, mut inserted_at) = (0.0, None);
    while !simulation.has_ended() {
        simulation.step();
        let [came, went] = simulation.passed();
        if came.grains > 0 && inserted_at.is_none() {
            inserted_at = Some(simulation.time());
        }
        match simulation.stage().unwrap() {
            stage if stage.number == 1 => {
                assert_eq!(stage.ended, went.mass >= 0.01);
                last = went.mass;
            }
            _ => assert_eq!(went.mass, last),
        }
    }
    assert!(last >= 0.01);
    assert!(inserted_at.is_none_or(|time| time > 0.22), "{inserted_at:?}");
    same_bits_everywhere(&scene, simulation.steps_taken() as usize);
}

#[test]
fn an_end_that_does_not_come_is_an_alarm() {
    let body = "[[stage]]\nname = 'press'\nuntil = { wall_force = { wall = 'lid', force = 1e3 } }\nat_most = 0.1\n";
    let scene = read(&text("", body));
    let mut simulation = start(&scene);
    let mut watchdog = Watchdog::new(&scene.watch, &simulation);
    for step in 1..=250 {
        let report = simulation.step();
        let alarms = watchdog.observe(&simulation, &report);
        assert_eq!(alarms.is_empty(), step < 250, "step {step}: {alarms:?}");
        if let Some(alarm) = alarms.first() {
            assert_eq!(alarm.trouble, Trouble::Overdue { stage: 0, condition: [0.0, 1e3] });
            let message = alarm.to_string();
            assert!(message.contains("stage[0] has not ended within at_most: its until is at 0"), "{message}");
        }
    }
    // A longer limit lets the same state go on.
    let longer = read(&text("", &body.replace("at_most = 0.1", "at_most = 0.5")));
    let mut resumed = Simulation::resume(&longer, &simulation.checkpoint()).unwrap();
    resumed.step();
    assert_eq!(resumed.overdue(), None);
}

#[test]
fn errors_name_the_key_in_the_stage() {
    let cases = [
        (
            "duration = 0.1\nmotion = { roof = { kind = 'fixed' } }",
            "stage[0].motion.roof: there is no wall 'roof'; name one of: box, lid",
        ),
        (
            "duration = 0.1\nmotion = { lid = { kind = 'rotating', point = [0, 0, 0], axis = [0, 0, 0], rate = 1.0 } }",
            "stage[0].motion.lid.axis: has no direction",
        ),
        (
            "duration = 0.1\nmotion = { lid = { kind = 'vibrating', amplitude = [0, 0, 1e-3], frequency = 1000.0 } }",
            "stage[0].motion.lid: a period of wall 'lid' lasts",
        ),
        ("until = { kinetic_energy = 1e-9 }", "stage[0].at_most: missing"),
        ("until = { kinetic_energy = 1e-9 }\nat_most = 1.0", "stage[0].until.kinetic_energy: holds at the start"),
        ("until = { removed_mass = 1.0 }\nat_most = 1.0", "stage[0].until.removed_mass: no sink"),
        (
            "until = { wall_force = { wall = 'roof', force = 1.0 } }\nat_most = 1.0",
            "stage[0].until.wall_force.wall: there is no wall",
        ),
        (
            "until = { wall_force = { wall = 'lid', force = -1.0 } }\nat_most = 1.0",
            "stage[0].until.wall_force.force: -1 is out of range",
        ),
        ("duration = 0.1\nuntil = { kinetic_energy = 1e-9 }", "stage[0].until: given in addition to duration"),
        (
            "until = { kinetic_energy = 1e-9, removed_mass = 1.0 }\nat_most = 1.0",
            "exactly 1 element, more than 1 element; give one of the keys of this table, and no other",
        ),
        ("until = {}\nat_most = 1.0", "exactly 1 element, found 0 elements; give one of the keys"),
        ("", "stage[0]: has no end"),
        ("duration = 0.1\nat_least = 0.1", "stage[0].duration: given with limits"),
        ("duration = 1e-4", "solver.step: no step of 0.0004 s is taken in 0.0001 s"),
        ("duration = 0.1\nsolver = { step = 1.0 }", "stage[0].solver.step: 1 is out of range"),
        ("duration = 0.1\ngravity = [0, 0, nan]", "stage[0].gravity: "),
        ("duration = 0.1\n[stage.material.steel]\nfriction = 0.1", "stage[0].material.steel: there is no material"),
        (
            "duration = 0.1\n[stage.material.glass]\nfriction = -0.1",
            "stage[0].material.glass.friction: -0.1 is out of range",
        ),
        ("duration = 0.1\n[[stage]]\nname = 'a'\nduration = 1.0", "stage[1].name: 'a' is the name of stage[0] too"),
        ("duration = 0.1\noutput = { interval = 0.0 }", "stage[0].output.interval: 0 is out of range"),
        (
            "duration = 0.1\n[[remove]]\nstage = 'b'\nregion = { kind = 'box', min = [0, 0, 0], max = [1, 1, 1] }",
            "remove[0].stage: there is no stage 'b'; name one of: a",
        ),
    ];
    for (body, expected) in cases {
        let error = Scene::parse(&text("", &format!("[[stage]]\nname = 'a'\n{body}"))).unwrap_err().to_string();
        assert!(error.contains(expected), "{expected}: {error}");
    }
    let error = Scene::parse(&text("duration = 1.0", "[[stage]]\nname = 'a'\nduration = 0.5")).unwrap_err().to_string();
    assert!(error.contains("duration: 1 s, in addition to the stages, which last 0.5 s at most"), "{error}");
    let error = Scene::parse(&text("", "")).unwrap_err().to_string();
    assert!(error.contains("missing field `duration`"), "{error}");
}

#[test]
fn a_written_scene_is_the_scene() {
    let scene = process();
    let again = read(&toml::to_string(&scene).unwrap());
    assert_eq!(again, scene);
    let built = Scene::builder()
        .material("glass", Default::default())
        .domain([0.0; 3], [1.0; 3])
        .stage(Stage { name: "one".into(), duration: Some(1.0), ..Stage::default() })
        .stage(Stage {
            name: "two".into(),
            until: Some(StageEnd::KineticEnergy(1e-9)),
            at_most: Some(2.0),
            ..Stage::default()
        });
    let built = built.build().unwrap();
    assert_eq!((built.duration, built.in_stage(1, &[]).stage.len()), (3.0, 0));
    assert!(scene.in_stage(3, &[]).wall[1].motion != Motion::Fixed);
}

/// A stage without friction has no friction left from the stage before: a grain on a slope goes on with the whole of gravity.
#[test]
fn a_stage_can_end_friction() {
    let floor = "[[wall]]\nname = 'floor'\nmaterial = 'glass'\nshape = { kind = 'plane', point = [0, 0, 0], normal = [0, 0, 1] }\n\
                 [[grain]]\nmaterial = 'glass'\nradius = 0.005\nposition = [0, 0, 0.005]\n\
                 [[stage]]\nname = 'sticks'\nduration = 0.2\n\
                 [[stage]]\nname = 'slides'\nduration = 0.2\nmaterial = { glass = { friction = 0.0 } }\n";
    let scene = read(&format!(
        "name = 'slope'\ndescription = 'stages'\ngravity = [3.0, 0.0, -9.0]\n\
         domain = {{ min = [-1, -1, -1], max = [20, 1, 1] }}\n\
         [material.glass]\ndensity = 2500.0\nyoungs_modulus = 1e7\npoisson_ratio = 0.3\nfriction = 0.5\nrestitution = 0.3\n\
         [solver]\nstep = 5e-4\n{floor}"
    ));
    let mut simulation = start(&scene);
    simulation.open_ledger();
    steps(&mut simulation, 400);
    let [before, ..] = simulation.snapshot().particles[0].velocity;
    steps(&mut simulation, 400);
    let [after, ..] = simulation.snapshot().particles[0].velocity;
    assert_relative_eq!(after - before, 3.0 * 0.2, max_relative = 1e-9);
    let balance = simulation.balance().unwrap();
    assert!(balance.closure.abs() <= 1e-9 * balance.exchanged(), "{balance:#?}");
}
