//! The real reference codes against closed forms of one contact, where they are installed.

use makadam::scene::Cohesion;
use makadam::snapshot::{Contact, Partner, Snapshot};
use makadam_compare::codes::{Code, Job, Lammps, Liggghts, Purpose, Yade};
use makadam_frames::plan::MeasuredScene;
use makadam_frames::recording::Recording;
use nalgebra::Vector3;
use std::path::Path;
use std::time::Duration;

const RADIUS: f64 = 0.005;
const DENSITY: f64 = 2500.0;
const GRAVITY: f64 = 9.81;

fn mass() -> f64 {
    DENSITY * 4.0 / 3.0 * std::f64::consts::PI * RADIUS.powi(3)
}

/// Runs a scene in every code that is installed and hands each recording over.
fn in_each(scene: &MeasuredScene, fraction: f64, check: impl Fn(&str, &Recording)) {
    in_these(&[&Yade::default(), &Liggghts::default(), &Lammps::default()], scene, fraction, check);
}

/// Runs a check in some codes.
fn in_these(codes: &[&dyn Code], scene: &MeasuredScene, fraction: f64, check: impl Fn(&str, &Recording)) {
    for code in codes {
        if code.version().is_none() {
            eprintln!("skipped: {} is not installed", code.name());
            continue;
        }
        let folder = tempfile::tempdir().unwrap();
        let recording = code
            .simulate(&Job {
                scene,
                scene_file: Path::new("live.toml"),
                purpose: Purpose::Measuring,
                seed: 1,
                stiffness_factor: 1.0,
                rayleigh_fraction: fraction,
                work_folder: folder.path(),
                time_limit: Duration::from_secs(300),
                progress: &|_| {},
            })
            .unwrap_or_else(|error| panic!("{error}"));
        let last = recording.frames.last().unwrap();
        assert!((last.time - scene.duration).abs() <= recording.time_step, "{}: ends at {}", code.name(), last.time);
        assert!(recording.wall_seconds > 0.0);
        check(code.name(), &recording);
    }
}

fn scene(gravity: f64, duration: f64, interval: f64, body: &str) -> MeasuredScene {
    let mut text = format!(
        "name = 'live'\ndescription = 'x'\nduration = {duration}\ngravity = [0.0, 0.0, {}]\n\
         domain = {{ min = [-0.3, -0.3, -0.3], max = [0.3, 0.3, 0.3] }}\n\
         [measure]\ninterval = {interval}\nfrom = 0.0\n",
        -gravity
    );
    for (name, friction) in [("grain", 0.5), ("rough", 0.8), ("slick", 0.05)] {
        text += &format!(
            "[material.{name}]\ndensity = {DENSITY}\nyoungs_modulus = 1e7\npoisson_ratio = 0.3\n\
             friction = {friction}\nrestitution = 0.3\n"
        );
    }
    for (number, part) in body.split(WALL_NAME).enumerate() {
        if number > 0 {
            text += &format!("name = 'wall-{number}'");
        }
        text += part;
    }
    MeasuredScene::parse(&text).unwrap_or_else(|error| panic!("{error}"))
}

fn grain(position: [f64; 3], velocity: [f64; 3]) -> String {
    format!("[[grain]]\nmaterial = 'grain'\nradius = {RADIUS}\nposition = {position:?}\nvelocity = {velocity:?}\n")
}

/// Stands for the names of walls, which a scene numbers.
const WALL_NAME: &str = "name = ?";

fn wall(material: &str, shape: &str, motion: &str) -> String {
    format!("[[wall]]\n{WALL_NAME}\nmaterial = '{material}'\nshape = {{ {shape} }}\nmotion = {{ {motion} }}\n")
}

const FIXED: &str = "kind = 'fixed'";

fn velocity(frame: &Snapshot, id: usize) -> Vector3<f64> {
    frame.particles[id].velocity.into()
}

fn contact(frame: &Snapshot, id: u32, wall: u32) -> &Contact {
    let mut found = frame.contacts.iter().filter(|c| c.first == id && c.second == Partner::Wall(wall));
    let contact = found.next().unwrap_or_else(|| panic!("grain {id} does not touch wall {wall}"));
    assert!(found.next().is_none(), "one contact of grain {id} with wall {wall}, not two");
    contact
}

#[track_caller]
fn close(code: &str, what: &str, value: f64, expected: f64, tolerance: f64) {
    assert!((value - expected).abs() <= tolerance, "{code}: {what} is {value}, not {expected} within {tolerance}");
}

#[test]
fn a_grain_that_may_escape_is_followed_beyond_the_domain() {
    let body = String::from("[watch]\non_escape = 'ignore'\n")
        + &wall("slick", "kind = 'plane', point = [0, 0, -0.15], normal = [0, 0, 1]", FIXED)
        + &grain([0.25, 0.0, 0.0], [1.0, 0.0, 0.0])
        + &grain([0.0, 0.0, 0.0], [0.0, 0.1, 0.0]);
    in_each(&scene(0.0, 0.2, 0.1, &body), 0.2, |code, recording| {
        let places: Vec<[f64; 3]> =
            recording.frames.last().unwrap().particles.iter().map(|grain| grain.position).collect();
        close(code, "the way of the first grain", places[0][0], 0.45, 1e-3);
        close(code, "that of the other", places[1][1], 0.02, 1e-3);
    });
}

#[test]
fn restitution_of_a_pair_and_on_every_kind_of_wall() {
    let speed = 0.5;
    let angle = 0.3f64;
    let towards = [speed * angle.cos(), 0.0, speed * angle.sin()];
    let body = wall("slick", "kind = 'box', min = [-0.2, -0.2, -0.2], max = [0.2, 0.2, 0.2]", FIXED)
        + &wall("slick", "kind = 'plane', point = [0, 0, -0.15], normal = [0, 0, 1]", FIXED)
        + &wall("slick", "kind = 'disc', centre = [0.1, 0.1, -0.1], normal = [0, 0, 2], radius = 0.03", FIXED)
        + &wall(
            "slick",
            "kind = 'cylinder', base = [-0.1, -0.05, 0], axis = [0, 1, 0], radius = 0.04, length = 0.1",
            FIXED,
        )
        + &grain([-0.007, -0.1, 0.1], [speed, 0.0, 0.0])
        + &grain([0.007, -0.1, 0.1], [-speed, 0.0, 0.0])
        + &grain([0.19, 0.013, 0.027], [speed, 0.0, 0.0])
        + &grain([0.017, -0.031, -0.14], [0.0, 0.0, -speed])
        + &grain([0.107, 0.103, -0.09], [0.0, 0.0, -speed])
        + &grain([-0.1 + 0.03 * angle.cos(), 0.007, 0.03 * angle.sin()], towards);
    in_each(&scene(0.0, 0.03, 0.03, &body), 0.02, |code, recording| {
        let last = recording.frames.last().unwrap();
        for (id, what) in ["first of a pair", "second of a pair", "box", "plane", "disc", "cylinder"].iter().enumerate()
        {
            let before = velocity(&recording.frames[0], id);
            let after = -velocity(last, id).dot(&before) / before.norm_squared();
            if code == "YADE" && *what == "cylinder" {
                // YADE counts every facet within reach: their dampings add up wherever facets are narrow.
                assert!((0.1..0.303).contains(&after), "YADE: restitution on a cylinder is {after}");
                continue;
            }
            close(code, &format!("restitution, {what},"), after, 0.3, 0.003);
        }
    });
}

#[test]
fn grains_on_slopes_belts_lifts_and_in_drums() {
    grains_on_slopes(std::f64::consts::FRAC_PI_6, &[&Yade::default(), &Liggghts::default()]);
    // The discs of LAMMPS lie along the axes.
    grains_on_slopes(0.0, &[&Lammps::default()]);
}

fn grains_on_slopes(tilt: f64, codes: &[&dyn Code]) {
    let (sine, cosine) = tilt.sin_cos();
    let (up, down) = (Vector3::new(sine, 0.0, cosine), Vector3::new(cosine, 0.0, -sine));
    let centres = [Vector3::new(-0.1, -0.1, 0.0), Vector3::new(-0.1, 0.1, 0.0)];
    let on = |centre: Vector3<f64>, normal: Vector3<f64>| grain((centre + normal * RADIUS).into(), [0.0; 3]);
    let disc = |x: f64, y: f64, normal: [f64; 3]| {
        format!("kind = 'disc', centre = [{x}, {y}, 0.0], normal = {normal:?}, radius = 0.05")
    };
    let flat = Vector3::z();
    let body = wall("rough", &disc(-0.1, -0.1, up.into()), FIXED)
        + &wall("slick", &disc(-0.1, 0.1, up.into()), FIXED)
        + &wall("grain", &disc(0.1, -0.1, flat.into()), "kind = 'translating', velocity = [0, 0.1, 0]")
        + &wall(
            "grain",
            &disc(0.1, 0.1, flat.into()),
            "kind = 'translating', velocity = [0, 0, 0.05], start = 0.02, stop = 0.05",
        )
        + &wall(
            "grain",
            "kind = 'cylinder', base = [0, -0.05, 0.2], axis = [0, 1, 0], radius = 0.05, length = 0.1",
            "kind = 'rotating', point = [0, 0, 0.2], axis = [0, 2, 0], rate = 5.0",
        )
        + &on(centres[0], up)
        + &on(centres[1], up)
        + &on(Vector3::new(0.1, -0.1, 0.0), flat)
        + &on(Vector3::new(0.107, 0.103, 0.0), flat)
        + &on(Vector3::new(0.0, 0.007, 0.15), flat);
    let time = 0.1;
    in_these(codes, &scene(GRAVITY, time, 0.001, &body), 0.05, |code, recording| {
        let last = recording.frames.last().unwrap();
        let weight = mass() * GRAVITY;
        // Rolling down a rough slope: 5/7 of the gravity along it; two sevenths of the pull go through friction.
        close(code, "speed on the rough slope", velocity(last, 0).dot(&down), 5.0 / 7.0 * GRAVITY * sine * time, 0.005);
        let touch = contact(last, 0, 0);
        // The tangential spring is damped, yet friction swings about its mean for some frames.
        let frames = &recording.frames[20..];
        let pull = |frame: &Snapshot| Vector3::from(contact(frame, 0, 0).tangential_force).dot(&down) / weight;
        let mean = frames.iter().map(pull).sum::<f64>() / frames.len() as f64;
        close(code, "friction on the rough slope", mean, 2.0 / 7.0 * sine, 0.02);
        close(code, "normal on the rough slope", Vector3::from(touch.normal).dot(&up), -1.0, 1e-6);
        if tilt > 0.0 {
            // Sliding down a slick one, where friction below 2/7 tan(tilt) cannot hold the surfaces together.
            let sliding = GRAVITY * (sine - 0.05 * cosine) * time;
            close(code, "speed on the slick slope", velocity(last, 1).dot(&down), sliding, 0.01 * sliding);
            let touch = contact(last, 1, 1);
            close(
                code,
                "friction on the slick slope",
                Vector3::from(touch.tangential_force).dot(&down) / weight,
                0.05 * cosine,
                0.002,
            );
            close(
                code,
                "spin on the slick slope",
                last.particles[1].spin[1] * RADIUS,
                2.5 * 0.05 * GRAVITY * cosine * time,
                0.003,
            );
        }
        // On a belt that starts at once, 2/7 of its speed when slipping ends, give or take the spring that winds up meanwhile.
        close(code, "speed on the belt", last.particles[2].velocity[1], 0.1 * 2.0 / 7.0, 0.002);
        close(code, "spin on the belt", last.particles[2].spin[0] * RADIUS, 0.1 * 5.0 / 7.0, 0.004);
        // A lift that goes 1.5 mm up and stops; the overlap is Hertz's.
        let stiffness = 4.0 / 3.0 * 1e7 / (2.0 * (1.0 - 0.09)) * RADIUS.sqrt();
        let overlap = (weight / stiffness).powf(2.0 / 3.0);
        close(
            code,
            "overlap on the lift",
            RADIUS + 0.05 * 0.03 - last.particles[3].position[2],
            overlap,
            0.02 * overlap,
        );
        let touch = contact(last, 3, 3);
        close(code, "weight on the lift", touch.normal_force / weight, 1.0, 0.01);
        close(code, "height of the lift", touch.point[2], 0.0015, overlap);
        // At the bottom of a drum whose floor moves towards -x, slipping still after 10 ms.
        let early = &recording.frames[10];
        close(code, "time of the eleventh frame", early.time, 0.01, 1e-9);
        let slipping = 0.5 * GRAVITY * 0.01;
        close(code, "speed in the drum", early.particles[4].velocity[0], -slipping, 0.04 * slipping);
        close(code, "spin in the drum", early.particles[4].spin[1] * RADIUS, 2.5 * slipping, 0.06 * slipping);
        assert!(contact(early, 4, 4).tangential_force[0] > 0.0, "{code}: the drum drags the grain, not the other way");
    });
}

#[test]
fn a_surface_velocity_carries_grains() {
    let belt = wall("grain", "kind = 'disc', centre = [0, 0, 0], normal = [0, 0, 1], radius = 0.05", FIXED);
    let body = belt + "surface_velocity = [0, 0.1, 0]\n" + &grain([0.0, 0.0, RADIUS], [0.0; 3]);
    in_these(&[&Yade::default(), &Liggghts::default()], &scene(GRAVITY, 0.1, 0.01, &body), 0.05, |code, recording| {
        let last = recording.frames.last().unwrap();
        close(code, "speed on the belt", last.particles[0].velocity[1], 0.1 * 2.0 / 7.0, 0.002);
        close(code, "spin on the belt", last.particles[0].spin[0] * RADIUS, 0.1 * 5.0 / 7.0, 0.004);
    });
}

#[test]
fn every_grain_of_a_small_packing_is_in_balance() {
    let mut body = wall("rough", "kind = 'box', min = [0, 0, 0], max = [0.031, 0.029, 0.2], open = ['+z']", FIXED);
    for index in 0..12 {
        let (layer, place) = (index / 4, index % 4);
        let shift = 0.001 * f64::from(layer);
        let (x, y) = (f64::from(place % 2), f64::from(place / 2));
        body += &grain(
            [0.007 + 0.012 * x + shift, 0.008 + 0.011 * y + 0.5 * shift, 0.007 + 0.011 * f64::from(layer)],
            [0.0; 3],
        );
    }
    in_each(&scene(GRAVITY, 1.5, 0.5, &body), 0.2, |code, recording| {
        let last = recording.frames.last().unwrap();
        let weight = mass() * GRAVITY;
        let mut force = vec![Vector3::new(0.0, 0.0, -weight); last.particles.len()];
        let mut torque = vec![Vector3::zeros(); last.particles.len()];
        let mut on_walls = 0.0;
        let mut pairs = 0;
        for contact in &last.contacts {
            let on_partner =
                Vector3::from(contact.normal) * contact.normal_force + Vector3::from(contact.tangential_force);
            let arm = |id: usize| Vector3::from(contact.point) - Vector3::from(last.particles[id].position);
            let first = contact.first as usize;
            force[first] -= on_partner;
            torque[first] -= arm(first).cross(&on_partner);
            match contact.second {
                Partner::Grain(second) => {
                    pairs += 1;
                    force[second as usize] += on_partner;
                    torque[second as usize] += arm(second as usize).cross(&on_partner);
                }
                Partner::Wall(_) => on_walls -= on_partner.z,
            }
        }
        assert!(pairs > 8, "{code}: only {pairs} contacts between grains");
        close(code, "wall force over weight", on_walls / (12.0 * weight), 1.0, 0.01);
        for id in 0..last.particles.len() {
            close(code, &format!("force on grain {id} over weight"), force[id].norm() / weight, 0.0, 0.05);
            close(code, &format!("torque on grain {id}"), torque[id].norm() / (weight * RADIUS), 0.0, 0.05);
        }
    });
}

#[test]
fn a_grain_follows_a_plate_that_vibrates_below_g() {
    let rate = std::f64::consts::TAU * 10.0;
    let amplitude = 0.5 * GRAVITY / (rate * rate);
    let (start, stop) = (0.02, 0.245);
    let shape = "kind = 'disc', centre = [0.0, 0.0, 0.0], normal = [0, 0, 1], radius = 0.05";
    let motion = format!(
        "kind = 'vibrating', amplitude = [0, 0, {amplitude}], frequency = 10.0, start = {start}, stop = {stop}"
    );
    // Off the seams of the plate's facets.
    let body = wall("grain", shape, &motion) + &grain([0.017, 0.011, RADIUS], [0.0; 3]);
    in_each(&scene(GRAVITY, 0.4, 0.005, &body), 0.05, |code, recording| {
        let stiffness = 4.0 / 3.0 * 1e7 / (2.0 * (1.0 - 0.09)) * RADIUS.sqrt();
        let overlap = (mass() * GRAVITY / stiffness).powf(2.0 / 3.0);
        // The start throws it up; by then it has come back. The stop, two and a quarter periods on, is a turning point.
        for frame in recording.frames.iter().filter(|frame| frame.time > 0.15) {
            let plate = amplitude * (rate * (frame.time.min(stop) - start)).sin();
            let depth = RADIUS + plate - frame.particles[0].position[2];
            close(code, &format!("depth at {} s", frame.time), depth, overlap, overlap);
        }
        close(code, "speed at the end", velocity(recording.frames.last().unwrap(), 0).z, 0.0, 1e-4);
    });
}

#[test]
fn a_lid_that_a_force_drives_falls_freely_and_then_presses() {
    let (force, lid_mass, start) = (0.2, 0.1, 0.05);
    let lid = format!("kind = 'force-driven', axis = [0, 0, -1], force = {force}, mass = {lid_mass}, start = {start}");
    let drop = 0.004;
    let top = 2.0 * RADIUS + drop;
    // Off the seams of the planes' facets.
    let body = wall("grain", "kind = 'plane', point = [0, 0, 0], normal = [0, 0, 1]", FIXED)
        + &wall("grain", &format!("kind = 'plane', point = [0, 0, {top}], normal = [0, 0, -1]"), &lid)
        + &grain([0.017, 0.011, RADIUS], [0.0; 3]);
    let acceleration = GRAVITY + force / lid_mass;
    in_these(&[&Yade::default()], &scene(GRAVITY, 0.8, 0.005, &body), 0.1, |code, recording| {
        for frame in recording.frames.iter().filter(|frame| frame.time < start + 0.02) {
            let fall = 0.5 * acceleration * (frame.time - start).max(0.0).powi(2);
            close(code, &format!("fall at {} s", frame.time), frame.driven_walls[0].displacement, fall, 0.01 * drop);
        }
        // At rest the grain bears both, and sinks in on both sides.
        let last = recording.frames.last().unwrap();
        let stiffness = 4.0 / 3.0 * 1e7 / (2.0 * (1.0 - 0.09)) * RADIUS.sqrt();
        let pressed = lid_mass * GRAVITY + force;
        let sunk = |force: f64| (force / stiffness).powf(2.0 / 3.0);
        let displacement = drop + sunk(pressed) + sunk(pressed + mass() * GRAVITY);
        close(code, "displacement", last.driven_walls[0].displacement, displacement, 0.01 * drop);
        let on_lid: f64 = last.contacts.iter().filter(|c| c.second == Partner::Wall(1)).map(|c| c.normal_force).sum();
        close(code, "force on the lid", on_lid, pressed, 0.01 * pressed);
    });
    let refused = Liggghts::default().simulate(&Job {
        scene: &scene(GRAVITY, 0.1, 0.1, &body),
        scene_file: Path::new("live.toml"),
        purpose: Purpose::Measuring,
        seed: 1,
        stiffness_factor: 1.0,
        rayleigh_fraction: 0.1,
        work_folder: tempfile::tempdir().unwrap().path(),
        time_limit: Duration::from_secs(300),
        progress: &|_| {},
    });
    let refused = refused.unwrap_err().to_string();
    assert!(refused.contains("driven") || refused.contains("not installed"), "{refused}");
}

/// A scene with a coefficient of rolling friction, and three quarters of it on walls: what YADE can express.
fn rolling(scene: &MeasuredScene, coefficient: f64) -> MeasuredScene {
    let mut scene = scene.clone();
    for (name, material) in &mut scene.material {
        material.rolling_friction = if name == "grain" { coefficient } else { 0.75 * coefficient };
    }
    scene
}

#[test]
fn a_rolling_ball_slows_down_by_five_sevenths_of_the_coefficient_times_g() {
    let (speed, coefficient) = (0.2, 0.05);
    let body = wall("rough", "kind = 'plane', point = [0, 0, 0], normal = [0, 0, 1]", FIXED)
        + &grain([-0.1, 0.0, RADIUS * 0.999], [speed, 0.0, 0.0])
        + &format!("spin = [0.0, {}, 0.0]\n", speed / RADIUS);
    let scene = rolling(&scene(GRAVITY, 0.4, 0.05, &body), coefficient);
    in_each(&scene, 0.1, |code, recording| {
        let [first, last] = [1, 7].map(|frame| &recording.frames[frame]);
        let slowing = (velocity(first, 0).x - velocity(last, 0).x) / (last.time - first.time);
        close(code, "slowing", slowing, 5.0 / 7.0 * 0.75 * coefficient * GRAVITY, 0.02 * coefficient * GRAVITY);
    });
}

#[test]
fn two_grains_that_roll_on_each_other_bear_a_torque_of_the_effective_radius() {
    let (speed, spin, coefficient) = (1.0, 50.0, 0.02);
    let cog = |side: f64| {
        grain([side * RADIUS * 1.001, 0.0, 0.0], [-side * speed, 0.0, 0.0])
            + &format!("spin = [0.0, 0.0, {}]\n", -side * spin)
    };
    let mut scene = rolling(&scene(0.0, 0.01, 0.01, &(cog(-1.0) + &cog(1.0))), coefficient);
    // The more an impact is damped the longer the force attracts at its end, and the cap goes with its magnitude.
    scene.material.values_mut().for_each(|material| material.restitution = 0.9);
    // YADE has no cap where its normal force is zero, as it is at the end of a damped impact: there its spring turns on.
    in_these(&[&Liggghts::default(), &Lammps::default()], &scene, 0.02, |code, recording| {
        let last = recording.frames.last().unwrap();
        // Half the mass, 1 + e, twice the speed; half the radius; I = 2/5 m r^2.
        let lost = coefficient * 0.5 * RADIUS * 1.9 * speed / (0.4 * RADIUS * RADIUS);
        close(code, "spin", last.particles[0].spin[2], spin - lost, 0.03 * lost);
        close(code, "spin of the other", last.particles[1].spin[2], lost - spin, 0.03 * lost);
    });
}

#[test]
fn a_grain_hangs_from_a_ceiling_up_to_its_pull_off_force() {
    for (share, hangs) in [(1.1, true), (0.9, false)] {
        let body = wall("rough", "kind = 'plane', point = [0, 0, 0.1], normal = [0, 0, -1]", FIXED)
            // Off the seam of two facets, both of which would pull.
            + &grain([0.03, 0.011, 0.1 - RADIUS * 0.9999], [0.0; 3]);
        let mut scene = scene(GRAVITY, 0.1, 0.1, &body);
        let work = share * mass() * GRAVITY / (1.5 * std::f64::consts::PI * RADIUS);
        scene
            .material
            .values_mut()
            .for_each(|one| one.cohesion = Some(Cohesion::SurfaceEnergy { work, range: Some(0.0) }));
        in_these(&[&Yade::default()], &scene, 0.1, |_, recording| {
            let height = recording.frames.last().unwrap().particles[0].position[2];
            assert_eq!(height > 0.1 - 1.1 * RADIUS, hangs, "pull {share} of the weight: height {height}");
        });
    }
}
