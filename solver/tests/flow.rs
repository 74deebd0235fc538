//! Grains that come from sources and go into sinks: none is lost, and rates, sizes, ledger and bits are right.

use crate::common::bits::{same_bits_everywhere, start, steps};
use crate::common::{DENSITY, Setup, grain, parse};
use approx::assert_relative_eq;
use makadam::scene::{Scene, SolverMethod};
use makadam::{FlowReport, Partner, Simulation};
use std::collections::BTreeSet;
use std::f64::consts::PI;

const SHAFT: &str = "[[wall]]\nname = 'shaft'\nmaterial = 'wall'\n\
                     shape = { kind = 'box', min = [0, 0, 0], max = [0.06, 0.06, 0.4], open = ['+z', '-z'] }\n";
const FLOOR: &str = "[[wall]]\nname = 'floor'\nmaterial = 'wall'\nshape = { kind = 'plane', point = [0, 0, 0.2], normal = [0, 0, 1] }\n";
const SINK: &str = "[[remove]]\nregion = { kind = 'box', min = [-1, -1, -0.9], max = [1, 1, 0.0] }\n";
const SOLVER: &str = "step = 5e-4\nnormal_law = { kind = 'hertz' }\nstop = { kind = 'sweeps', sweeps = 20 }";
const SIZES: &str = "radius = { kind = 'uniform', mean = 0.004, spread = 0.2 }";

/// A source in the upper part of the shaft.
fn source(amount: &str) -> String {
    format!(
        "[[insert]]\nmaterial = 'grain'\n{SIZES}\n{amount}\nvelocity = [0, 0, -0.5]\n\
         region = {{ kind = 'box', min = [0, 0, 0.3], max = [0.06, 0.06, 0.36] }}\n"
    )
}

fn scene(body: String) -> Scene {
    Setup { restitution: 0.2, solver: SOLVER.into(), body, ..Setup::default() }.scene()
}

/// A stream that falls through the shaft.
fn stream() -> Scene {
    scene(format!("{SHAFT}{}{SINK}", source("rate = 500")))
}

/// Grains that came, went and are inside.
fn counts(simulation: &Simulation) -> [u64; 3] {
    let [came, went] = simulation.passed();
    [came.grains, went.grains, simulation.grains() as u64]
}

fn report(simulation: &Simulation) -> FlowReport {
    simulation.flow().expect("grains come or go")
}

fn mass(radius: f64) -> f64 {
    DENSITY * 4.0 / 3.0 * PI * radius.powi(3)
}

#[test]
fn a_stream_comes_at_its_rate_goes_into_the_sink_and_the_ledger_closes() {
    let mut simulation = start(&stream());
    simulation.open_ledger();
    let (mut most, mut seen) = (0, BTreeSet::new());
    for step in 1..=3000 {
        simulation.step();
        most = most.max(simulation.grains());
        let ([came, went, inside], lag) = (counts(&simulation), report(&simulation).lags[0]);
        assert_eq!(came, went + inside, "step {step}");
        assert!(lag <= report(&simulation).usual_lag + 1e-9, "step {step}: {lag} s late");
        let frame = simulation.snapshot();
        let numbers: Vec<u64> = frame.origins.iter().map(|origin| origin.number).collect();
        assert!(numbers.is_sorted_by(|a, b| a < b) && frame.origins.iter().all(|origin| origin.source == Some(0)));
        seen.extend(numbers);
        let balance = simulation.balance().unwrap();
        assert!(balance.closure.abs() <= 1e-9 * balance.exchanged(), "step {step}: {balance:#?}");
    }
    let [came, went, inside] = counts(&simulation);
    // Each grain that came had a number of its own.
    assert_eq!((seen.len() as u64, seen.last().copied()), (came, Some(came - 1)));
    let due = 500.0 * simulation.time();
    let late = 500.0 * report(&simulation).usual_lag;
    assert!(came as f64 <= due && came as f64 >= due - late - 1.0, "{came} of {due}");
    // A grain falls for about 0.2 s.
    assert!(went > 500 && (60..200).contains(&inside) && most < 250, "{went} went, {inside} of at most {most}");
    let balance = simulation.balance().unwrap();
    assert!(balance.inflow > 0.0 && balance.outflow != 0.0);
    for axis in 0..3 {
        let scale = balance.gravity_impulse[2].abs();
        assert_relative_eq!(balance.momentum_closure[axis], 0.0, epsilon = 1e-11 * scale);
        assert_relative_eq!(balance.angular_momentum_closure[axis], 0.0, epsilon = 1e-11 * scale);
    }
}

#[test]
fn the_mass_that_comes_follows_its_rate_to_a_grain() {
    let (rate, until) = (0.4, 1.0);
    let mut simulation = start(&scene(format!("{SHAFT}{}{SINK}", source("mass_rate = 0.4\nfrom = 0.2\nuntil = 1.0"))));
    for _ in 0..2600 {
        simulation.step();
        let came = simulation.passed()[0].mass;
        let due = rate * (simulation.time().min(until) - 0.2).max(0.0);
        let late = rate * report(&simulation).usual_lag;
        assert!(came <= due * (1.0 + 1e-9), "{came} kg of {due}");
        assert!(came > due - late - mass(0.0048), "{came} kg of {due} at {} s", simulation.time());
    }
    let [came, went] = simulation.passed();
    assert!(came.mass > rate * 0.8 - mass(0.0048), "{} kg", came.mass);
    // All have fallen out, and their masses are what came.
    assert_eq!((came.grains, simulation.grains()), (went.grains, 0));
    assert_relative_eq!(came.mass, went.mass, max_relative = 1e-12);
}

#[test]
fn a_full_region_makes_grains_wait_and_the_lag_is_known() {
    let body = format!("{SHAFT}{FLOOR}{}", source("rate = 4000\ntotal = 5000"));
    let mut simulation = start(&scene(body));
    steps(&mut simulation, 2000);
    let ([came, ..], flow) = (counts(&simulation), report(&simulation));
    assert!((200..3000).contains(&came), "{came} grains in a shaft that holds a few hundred");
    assert!(flow.lags[0] > 0.2 && flow.lags[0] > 5.0 * flow.usual_lag, "{flow:?}");
    assert!(simulation.largest_overlap() < 0.3, "{}", simulation.largest_overlap());
    // Once the floor is gone, the rest comes, and no more.
    let mut open = start(&scene(format!("{SHAFT}{}{SINK}", source("rate = 1200\ntotal = 500"))));
    steps(&mut open, 2500);
    assert_eq!((counts(&open), report(&open).lags[0]), ([500, 500, 0], 0.0));
}

/// Largest chi-squared with nine degrees of freedom in all but one of a thousand draws.
const LARGEST_CHI_SQUARED: f64 = 27.88;

/// Asserts that values in [0, 1) are uniform, over ten classes of equal probability.
fn assert_uniform(values: &[f64], what: &str) {
    let mut classes = [0.0; 10];
    values.iter().for_each(|value| classes[((10.0 * value) as usize).min(9)] += 1.0);
    let expected = values.len() as f64 / 10.0;
    let chi_squared: f64 = classes.iter().map(|count| (count - expected).powi(2) / expected).sum();
    assert!(chi_squared < LARGEST_CHI_SQUARED, "{what}: chi-squared {chi_squared}, {classes:?}");
}

#[test]
fn drawn_sizes_and_places_follow_their_distributions_even_where_grains_wait() {
    // In a crowded region large grains find fewer places; their share must not suffer.
    let body = format!("{SHAFT}{FLOOR}{}", source("rate = 8000"));
    let mut crowded = start(&scene(body));
    steps(&mut crowded, 1500);
    let radii: Vec<f64> = crowded.frame().radii().iter().map(|radius| (radius / 0.004 - 0.8) / 0.4).collect();
    assert!(radii.len() > 300 && report(&crowded).lags[0] > 0.5, "{}", radii.len());
    assert_uniform(&radii, "radii");
    let wide = "[[insert]]\nmaterial = 'grain'\nradius = { kind = 'fixed', value = 0.004 }\ntotal = 3000\n\
                region = { kind = 'cylinder', base = [0, 0, 2], axis = [0, 0, 1], radius = 1.004, length = 2.008 }\n";
    let mut dilute = start(&scene(wide.into()));
    dilute.step();
    let places = dilute.frame().positions().to_vec();
    assert_eq!(places.len(), 3000);
    // The first step moves them down by 2.5 um.
    let height: Vec<f64> = places.iter().map(|place| (place[2] - 2.004 + 2.5e-6) / 2.0).collect();
    let area: Vec<f64> = places.iter().map(|place| place[0] * place[0] + place[1] * place[1]).collect();
    let angle: Vec<f64> = places.iter().map(|place| (place[1].atan2(place[0]) + PI) / (2.0 * PI)).collect();
    for (values, what) in [(height, "heights"), (area, "areas"), (angle, "angles")] {
        assert_uniform(&values, what);
    }
}

#[test]
fn bits_are_the_same_on_threads_and_instruction_sets_and_after_checkpoints() {
    let hash = same_bits_everywhere(&stream(), 1200);
    let mut other = Simulation::new(&stream(), 2).unwrap();
    steps(&mut other, 1200);
    assert_ne!(other.state_hash(), hash, "the seed tells");
    // A bed that grows over periodic axes.
    let mut periodic = scene(format!("{FLOOR}{}{SINK}", source("rate = 1500")));
    (periodic.domain.min, periodic.domain.max) = ([0.0, 0.0, -0.9], [0.06, 0.06, 0.5]);
    periodic.domain.periodic = vec![makadam::Axis::X, makadam::Axis::Y];
    same_bits_everywhere(&periodic, 900);
}

#[test]
fn a_checkpoint_at_any_step_goes_on_to_the_same_bits() {
    let scene = stream();
    let mut simulation = start(&scene);
    steps(&mut simulation, 460);
    simulation.open_ledger();
    for step in 0..60 {
        let bytes = simulation.checkpoint();
        let mut resumed = Simulation::resume(&scene, &bytes).unwrap();
        assert_eq!(resumed.snapshot().origins, simulation.snapshot().origins, "step {step}");
        let mut straight = simulation.clone();
        for _ in 0..70 {
            straight.step();
            resumed.step();
        }
        assert_eq!(resumed.state_hash(), straight.state_hash(), "step {step}");
        assert_eq!((resumed.flow(), resumed.balance()), (straight.flow(), straight.balance()), "step {step}");
        assert_eq!(resumed.checkpoint(), straight.checkpoint(), "step {step}");
        simulation.step();
    }
    let bytes = simulation.checkpoint();
    let other = Simulation::start_from(&self::scene(SHAFT.into()), &bytes).unwrap();
    assert_eq!((other.flow(), other.grains()), (None, simulation.grains()), "a start with the grains that are there");
    let two = self::scene(format!("{SHAFT}{}{}{SINK}", source("rate = 500"), source("rate = 1")));
    let error = Simulation::resume(&two, &bytes).unwrap_err().to_string();
    assert!(error.contains("other sources"), "{error}");
}

#[test]
fn a_grain_of_a_force_chain_goes_and_the_rest_falls() {
    let radius = 0.01;
    let mut body = String::from(
        "[[wall]]\nname = 'floor'\nmaterial = 'wall'\nshape = { kind = 'plane', point = [0, 0, 0], normal = [0, 0, 1] }\n",
    );
    for number in 0..6 {
        body += &grain(radius, [0.0, 0.0, radius * (1.0 + 2.0 * f64::from(number))], [0.0; 3]);
    }
    // The third grain goes at 0.1 s.
    body += "[[remove]]\nregion = { kind = 'box', min = [-0.1, -0.1, 0.045], max = [0.1, 0.1, 0.055] }\nfrom = 0.1\nuntil = 0.1001\n";
    let solver = "step = 1e-4\nnormal_law = { kind = 'hertz' }\nstop = { kind = 'sweeps', sweeps = 100 }";
    let mut simulation = Setup { solver: solver.into(), body, restitution: 0.0, ..Setup::default() }.start();
    simulation.open_ledger();
    let force_on_floor = |simulation: &Simulation| {
        let contacts = simulation.snapshot().contacts;
        contacts
            .iter()
            .filter(|contact| contact.second == Partner::Wall(0))
            .map(|contact| contact.normal_force)
            .sum::<f64>()
    };
    steps(&mut simulation, 1000);
    let weight = 9.81 * mass(radius);
    assert_relative_eq!(force_on_floor(&simulation), 6.0 * weight, max_relative = 1e-2);
    let elastic = simulation.energy().elastic;
    steps(&mut simulation, 30);
    assert_eq!(counts(&simulation), [0, 1, 5]);
    let balance = simulation.balance().unwrap();
    assert!(balance.closure.abs() <= 1e-9 * balance.exchanged() && balance.outflow > 0.0, "{balance:#?}");
    // The upper three are in free fall, and the lower two bear themselves alone.
    let [.., speed] = simulation.frame().velocities()[4];
    assert!((-0.04..-0.02).contains(&speed), "{speed} m/s");
    steps(&mut simulation, 170);
    assert!(simulation.energy().elastic < 0.2 * elastic, "{} of {elastic} J", simulation.energy().elastic);
    let numbers: Vec<u64> = simulation.snapshot().origins.iter().map(|origin| origin.number).collect();
    assert_eq!(numbers, [0, 1, 3, 4, 5]);
    steps(&mut simulation, 4000);
    assert_relative_eq!(force_on_floor(&simulation), 5.0 * weight, max_relative = 1e-2);
    assert!(simulation.balance().unwrap().closure.abs() <= 1e-9 * simulation.balance().unwrap().exchanged());
}

#[test]
fn what_begins_empty_grows_to_a_hundred_thousand_in_boxes_that_fit() {
    let body = "[[insert]]\nmaterial = 'grain'\nradius = { kind = 'uniform', mean = 0.004, spread = 0.1 }\nrate = 2e6\ntotal = 100000\n\
                velocity = [0, 0, -1]\nregion = { kind = 'box', min = [-0.5, -0.5, 0], max = [0.5, 0.5, 1] }\n";
    let mut scene = scene(body.into());
    (scene.domain.min, scene.domain.max) = ([-0.5, -0.5, -1.0], [0.5, 0.5, 1.0]);
    let mut simulation = start(&scene);
    assert_eq!(simulation.grains(), 0);
    let mut tasks = Vec::new();
    while simulation.grains() < 100_000 {
        simulation.step();
        tasks.push(simulation.layout().plan.tasks().len());
        assert!(tasks.len() < 200, "{} grains in {} steps", simulation.grains(), tasks.len());
    }
    steps(&mut simulation, 1);
    // From a checkpoint as a start, boxes are chosen for the grains that are there.
    let bytes = simulation.checkpoint();
    let mut resumed = Simulation::resume(&scene, &bytes).unwrap();
    steps(&mut resumed, 2);
    steps(&mut simulation, 2);
    assert_eq!(resumed.state_hash(), simulation.state_hash());
    let mut anew = Simulation::start_from(&self::scene(String::new()), &bytes).unwrap();
    anew.step();
    let (grown, chosen) = (simulation.layout().plan.tasks().len(), anew.layout().plan.tasks().len());
    assert!(grown > 1000 && 2 * grown > chosen && grown < 2 * chosen, "{grown} tasks, {chosen} chosen for the grains");
}

/// Draws of a test.
struct Draws(u64);

impl Draws {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        low + (high - low) * (self.0 >> 33) as f64 / (1_u64 << 31) as f64
    }
}

#[test]
fn random_scenes_lose_nobody() {
    for seed in 0..24 {
        let mut draws = Draws(seed);
        let width = draws.between(0.05, 0.15);
        let wall = format!(
            "[[wall]]\nname = 'box'\nmaterial = 'wall'\n\
             shape = {{ kind = 'box', min = [0, 0, 0], max = [{width}, {width}, 0.5], open = ['+z'] }}\n"
        );
        let amount = match seed % 3 {
            0 => format!("rate = {}", draws.between(100.0, 2000.0)),
            1 => format!("mass_rate = {}", draws.between(0.1, 1.0)),
            _ => format!("total = {}", draws.between(50.0, 400.0) as u64),
        };
        let (middle, half) = (0.5 * width, 0.4 * width);
        let source = format!(
            "[[insert]]\nmaterial = 'grain'\n{SIZES}\n{amount}\nfrom = {}\nvelocity = [{}, 0, {}]\n\
             region = {{ kind = 'cylinder', base = [{middle}, {middle}, 0.2], axis = [0, 0, 1], radius = {half}, length = 0.2 }}\n",
            draws.between(0.0, 0.1),
            draws.between(-0.5, 0.5),
            draws.between(-3.0, 0.0),
        );
        // The sink is part of the bed, or a thin sheet that grains fall through.
        let (low, high) = if seed % 2 == 0 { (0.0, 0.03) } else { (0.12, 0.125) };
        let sink = format!(
            "[[remove]]\nfrom = {}\nregion = {{ kind = 'box', min = [0, 0, {low}], max = [{}, {width}, {high}] }}\n",
            draws.between(0.0, 0.02),
            draws.between(0.3, 1.0) * width,
        );
        let bed = format!(
            "[[population]]\ncount = 40\nmaterial = 'grain'\n{SIZES}\nregion = {{ kind = 'box', min = [0, 0, 0], max = [{width}, {width}, 0.19] }}\n"
        );
        let mut scene = scene(wall + &bed + &source + &sink);
        scene.solver.method = [SolverMethod::GaussSeidel, SolverMethod::ALL[1]][usize::from(seed % 5 == 4)];
        let mut simulation = start(&scene);
        simulation.open_ledger();
        for step in 0..800 {
            simulation.step();
            let [came, went, inside] = counts(&simulation);
            assert_eq!(came + 40, went + inside, "seed {seed}, step {step}");
        }
        let frame = simulation.snapshot();
        for grain in &frame.particles {
            let [x, y, z] = grain.position;
            let is_in = |place: f64, most: f64| place > 0.0 && place < most;
            assert!(is_in(x, width) && is_in(y, width) && is_in(z, 0.6), "seed {seed}: {grain:?}");
        }
        let drawn: Vec<u64> = frame.origins.iter().map(|origin| origin.number).collect();
        assert!(drawn.is_sorted_by(|a, b| a < b), "seed {seed}");
        let [came, went, _] = counts(&simulation);
        assert!(came > 20 && went > 0, "seed {seed}: {came} came, {went} went");
        let balance = simulation.balance().unwrap();
        let closes = balance.closure.abs() <= 1e-9 * balance.exchanged();
        assert!(closes || scene.solver.method != SolverMethod::GaussSeidel, "seed {seed}: {balance:#?}");
    }
}

#[test]
fn forces_stay_with_their_grains() {
    // Without gravity, a force along x on the second grain, which has another id once the first is gone.
    let mut body = String::new();
    for number in 0..3 {
        body += &grain(0.004, [0.1 * f64::from(number), 0.0, 0.0], [0.0; 3]);
    }
    body += "[[remove]]\nregion = { kind = 'box', min = [-0.01, -0.01, -0.01], max = [0.01, 0.01, 0.01] }\n";
    let mut simulation = Setup { gravity: [0.0; 3], solver: SOLVER.into(), body, ..Setup::default() }.start();
    simulation.apply_forces(&[[0.0; 3], [1e-3, 0.0, 0.0], [0.0; 3]]).unwrap();
    simulation.step();
    assert_eq!(counts(&simulation), [0, 1, 2]);
    let speeds: Vec<f64> = simulation.frame().velocities().iter().map(|velocity| velocity[0]).collect();
    assert_relative_eq!(speeds[0], 5e-4 * 1e-3 / mass(0.004), max_relative = 1e-12);
    assert_eq!(speeds[1], 0.0);
}

#[test]
fn the_caller_may_insert_what_the_scene_knows_and_remove_what_is_there() {
    let scene = stream();
    let mut simulation = start(&scene);
    steps(&mut simulation, 400);
    let [came, _, inside] = counts(&simulation);
    let mut entry = simulation.grain_entries(&scene)[0].clone();
    entry.position = [0.03, 0.03, 0.39];
    simulation.insert(&scene, std::slice::from_ref(&entry)).unwrap();
    simulation.remove(&[0, 1]).unwrap();
    let frame = simulation.snapshot();
    assert_eq!(frame.particles.len() as u64, inside - 1);
    assert_eq!(frame.origins.last().map(|origin| (origin.number, origin.source)), Some((came, None)));
    steps(&mut simulation, 400);
    assert!(simulation.passed()[0].grains > came);
    entry.radius = 0.006;
    let error = simulation.insert(&scene, &[entry]).unwrap_err().to_string();
    assert!(error.contains("0.006") && error.contains("0.0048"), "{error}");
}

#[test]
fn watchdogs_know_what_comes_and_goes() {
    let scene = stream();
    let mut simulation = start(&scene);
    let mut watchdog = makadam::watch::Watchdog::new(&scene.watch, &simulation);
    for _ in 0..1500 {
        let report = simulation.step();
        assert_eq!(watchdog.observe(&simulation, &report), []);
    }
    assert!(simulation.passed()[1].grains > 100);
}

#[test]
fn ledgers_close_and_bits_hold_with_cohesion_torques_springs_and_periods() {
    let lines = "rolling_friction = 0.1\ntwisting_friction = 0.05\n\
                 cohesion = { kind = 'surface-energy', work = 0.05, range = 0.0001 }\n";
    let sink = "[[remove]]\nregion = { kind = 'cylinder', base = [0.03, 0.03, 0.2], axis = [0, 0, 1], radius = 0.02, length = 0.02 }\n\
                from = 0.2\n";
    let spring = format!("{SOLVER}\ntangential_law = {{ kind = 'spring' }}");
    for (lines, solver, axes) in [(lines, SOLVER, vec![]), ("", &spring, vec![makadam::Axis::X, makadam::Axis::Y])] {
        let walls = if axes.is_empty() { format!("{SHAFT}{FLOOR}") } else { FLOOR.into() };
        let body = format!("{walls}{}{sink}", source("rate = 1500"));
        let mut scene = Setup { solver: solver.into(), body, ..Setup::default() }.scene_with(lines);
        (scene.domain.min, scene.domain.max) = ([0.0, 0.0, -0.9], [0.06, 0.06, 0.5]);
        scene.domain.periodic = axes;
        let mut simulation = start(&scene);
        simulation.open_ledger();
        for step in 0..1000 {
            simulation.step();
            let balance = simulation.balance().unwrap();
            assert!(balance.closure.abs() <= 1e-9 * balance.exchanged(), "step {step}: {balance:#?}");
        }
        let [came, went, inside] = counts(&simulation);
        assert!(went > 50 && came == went + inside, "{came} came, {went} went");
        same_bits_everywhere(&scene, 700);
    }
}

#[test]
fn a_stopped_step_lets_nobody_come_or_go_twice() {
    let mut scene = stream();
    scene.solver.stop = makadam::Stop::Sweeps { sweeps: 100 };
    let (mut straight, mut stopped) = (start(&scene), start(&scene));
    for step in 0..700 {
        straight.step();
        if step % 3 == 0 {
            stopped.set_interrupt(makadam::Interrupt::new());
            stopped.interrupt_handle().request();
            stopped.step();
            stopped.interrupt_handle().clear();
        }
        while stopped.steps_taken() < straight.steps_taken() {
            stopped.step();
        }
        assert_eq!((stopped.state_hash(), stopped.passed()), (straight.state_hash(), straight.passed()), "step {step}");
    }
    assert!(straight.passed()[1].grains > 10);
}

#[test]
fn every_method_and_precision_loses_nobody() {
    for method in SolverMethod::ALL {
        let mut simulation = start(&scene(format!("{SHAFT}{FLOOR}{}", source("rate = 1000"))));
        simulation.use_method(method).unwrap();
        steps(&mut simulation, 600);
        let [came, _, inside] = counts(&simulation);
        assert!(came > 250 && came == inside, "{}: {came} came, {inside} inside", method.name());
        assert!(simulation.not_finite().is_none());
    }
    let mut single = stream();
    single.solver.precision = makadam::Precision::Single;
    same_bits_everywhere(&single, 600);
}

#[test]
fn bad_sources_and_sinks_are_refused_with_key_and_remedy() {
    let text = |source: &str, sink: &str| {
        format!(
            "name = 'test'\ndescription = ''\nduration = 1.0\ndomain = {{ min = [0, 0, 0], max = [1, 1, 1] }}\n\
             [material.grain]\ndensity = 2500\nyoungs_modulus = 1e7\npoisson_ratio = 0.3\nfriction = 0.5\nrestitution = 0.5\n\
             [[insert]]\n{source}\n[[remove]]\n{sink}\n"
        )
    };
    let region = "region = { kind = 'box', min = [0.1, 0.1, 0.1], max = [0.2, 0.2, 0.2] }";
    let good =
        |more: &str| format!("material = 'grain'\nradius = {{ kind = 'fixed', value = 0.005 }}\n{region}\n{more}");
    parse(&text(&good("rate = 100"), region)).unwrap();
    let outside = region.replace("max = [0.2", "max = [1.2");
    let apart = region.replace("0.1", "2.1").replace("0.2", "2.2");
    for (source, sink, words) in [
        (
            good(""),
            region,
            ["insert[0]: has neither a rate nor a total", "give rate (grains/s), mass_rate (kg/s) or total"],
        ),
        (good("rate = 1\nmass_rate = 1"), region, ["insert[0].mass_rate: given in addition to rate", "leave one out"]),
        (good("rate = -1"), region, ["insert[0].rate: -1 is out of range", "grains/s"]),
        (good("total = 0"), region, ["insert[0].total: 0 is out of range", "grains"]),
        (good("rate = 1\nfrom = 1\nuntil = 0.5"), region, ["insert[0].until: 0.5 is out of range", "from 1"]),
        (good("rate = 1").replace(region, &outside), region, ["insert[0].region: from", "not inside the domain"]),
        (good("rate = 1").replace("0.005", "0.06"), region, ["insert[0].region: 0.1 m wide", "diameter of 0.12 m"]),
        (
            good("rate = 1").replace("'grain'", "'sand'"),
            region,
            ["insert[0].material: there is no material 'sand'", "grain"],
        ),
        (good("rate = 1e6"), region, ["insert[0].rate: 1000000 cannot be met", "lower it to at most"]),
        (good("mass_rate = 1000"), region, ["insert[0].mass_rate: 1000 cannot be met", "enlarge the region"]),
        (good("rate = 1\nspeed = 1"), region, ["unknown field `speed`", "test.toml:"]),
        (good("rate = 1"), apart.as_str(), ["remove[0].region: from", "outside the domain"]),
        (good("rate = 1"), "from = 1", ["missing field `region`", "add that key"]),
        (good("total = 200000000"), region, ["insert[0].total: 200000000 is out of range", "100000000"]),
    ] {
        let error = parse(&text(&source, sink)).expect_err(&source);
        assert!(words.iter().all(|word| error.contains(word)), "{words:?} in {error}");
    }
}

#[test]
fn a_source_needs_no_gravity() {
    let mut scene = scene(format!("{SHAFT}{}", source("rate = 100").replace("[0, 0, -0.5]", "[0, 0, 0]")));
    (scene.gravity, scene.duration) = ([0.0; 3], 0.3);
    let mut simulation = start(&scene);
    while simulation.time() < scene.duration {
        simulation.step();
        assert!(report(&simulation).lags[0] <= report(&simulation).usual_lag + 1e-9);
    }
    assert!(counts(&simulation)[0] >= 28, "{:?}", counts(&simulation));
}

#[test]
fn a_grain_that_crosses_a_thin_sink_within_a_step_goes() {
    // 5 mm a step, through sheets of 0.1 mm at many places, straight and oblique; beside the sinks it stays.
    let regions = |at: f64| {
        [
            format!("kind = 'box', min = [-0.05, -0.05, {at}], max = [0.05, 0.05, {}]", at + 1e-4),
            format!("kind = 'cylinder', base = [0, 0, {at}], axis = [0, 0, 1], radius = 0.05, length = 1e-4"),
            format!("kind = 'cylinder', base = [-0.05, 0, {at}], axis = [1, 0, 0], radius = 5e-5, length = 0.1"),
        ]
    };
    for place in 0..20 {
        for region in regions(0.4 + 0.0007 * place as f64) {
            for (x, vx, goes) in [(0.0, 0.0, true), (-0.01, 1.0, true), (0.06, 0.0, false), (-0.06, -1.0, false)] {
                let body =
                    format!("{}[[remove]]\nregion = {{ {region} }}\n", grain(0.002, [x, 0.0, 0.5], [vx, 0.0, -10.0]));
                let setup = Setup { gravity: [0.0; 3], solver: SOLVER.into(), body, ..Setup::default() };
                let mut simulation = start(&setup.scene());
                for _ in 0..40 {
                    simulation.step();
                }
                assert_eq!(simulation.grains(), usize::from(!goes), "{region} from {x} at {vx}");
            }
        }
    }
}

#[test]
fn a_grain_that_starts_behind_a_sink_or_crosses_it_by_a_period_is_told_apart() {
    let sink = |low: f64, high: f64| {
        format!("[[remove]]\nregion = {{ kind = 'box', min = [{low}, -1, -1], max = [{high}, 1, 1] }}\n")
    };
    let after = |place: f64, sink: String, periodic: bool, steps: usize| {
        let body = format!("{}{sink}", grain(0.002, [place, 0.0, 0.0], [10.0, 0.0, 0.0]));
        let mut scene = Setup { gravity: [0.0; 3], solver: SOLVER.into(), body, ..Setup::default() }.scene();
        (scene.domain.min, scene.domain.max) = ([-0.5, -1.0, -1.0], [0.5, 1.0, 1.0]);
        if periodic {
            scene.domain.periodic.push(makadam::Axis::X);
        }
        let mut simulation = start(&scene);
        for _ in 0..steps {
            simulation.step();
        }
        simulation.grains()
    };
    assert_eq!(after(0.001, sink(-1e-4, 0.0), false, 40), 1, "it starts in front");
    for offset in 0..10 {
        let place = 0.45 + 0.0005 * f64::from(offset);
        assert_eq!(after(place, sink(0.4998, 0.4999), true, 20), 0, "before the end of the period, from {place}");
        assert_eq!(after(place, sink(-0.4999, -0.4998), true, 20), 0, "after it, from {place}");
        assert_eq!(after(place, sink(0.1, 0.1001), true, 20), 1, "elsewhere, from {place}");
    }
}
