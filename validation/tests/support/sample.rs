//! An invented qualification that looks like a real one: three codes, three scenes, every kind of outcome.

use makadam::snapshot::Particle;
use makadam_compare::compare::{CodeSummary, Comparison, FinalState, Row, Source, Timing};
use makadam_frames::plan::MeasuredScene;
use makadam_measure::observables::{ForceDistribution, Series};
use makadam_measure::statistics::Outcome;
use makadam_qualification::report::{Qualification, StudyOutcome, StudySection, StudyTest};
use std::path::Path;

pub const CODES: [&str; 3] = ["Makadam", "LIGGGHTS", "YADE"];

/// A number between -1 and 1 that depends on its arguments alone.
pub fn noise(a: u64, b: u64) -> f64 {
    let mut x = a.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ b.wrapping_mul(0xd1b5_4a32_d192_ed03);
    x ^= x >> 29;
    x = x.wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x ^= x >> 32;
    (x >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

pub fn scene(name: &str) -> MeasuredScene {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-scenes").join(name).join("scene.toml");
    let mut scene = MeasuredScene::load(&file).expect("a reference scene");
    // Margins of the sample's own: those of the scenes follow their records.
    for expectation in scene.compare.iter_mut().filter(|expectation| expectation.margin.is_some()) {
        expectation.margin = Some(match expectation.observable.as_str() {
            "packing_fraction" => 0.006,
            "coordination_number" => 0.15,
            "friction_mobilisation" => 0.03,
            "share_below_mean" | "gini" => 0.02,
            _ => 1.5,
        });
    }
    scene
}

/// Rows of one observable from the means of the three codes, as a comparison orders them.
fn rows(
    scene: &MeasuredScene,
    observable: &str,
    unit: &str,
    means: [f64; 3],
    deviation: f64,
    seeds: usize,
) -> Vec<Row> {
    let margin = scene.compare.iter().find(|e| e.observable == observable).and_then(|e| e.margin);
    [(0, 1), (0, 2), (1, 2)]
        .map(|(code, reference)| {
            let difference = means[code] - means[reference];
            let error = deviation * (2.0 / seeds as f64).sqrt();
            let verdict = [difference - 2.3 * error, difference + 2.3 * error];
            let outcome = margin.map(|margin| match () {
                () if verdict[0] > -margin && verdict[1] < margin => Outcome::Agree,
                () if verdict[0] > margin || verdict[1] < -margin => Outcome::Disagree,
                () => Outcome::Undecided,
            });
            Row {
                scene: scene.name.clone(),
                observable: observable.into(),
                unit: unit.into(),
                code: CODES[code].into(),
                mean: Some(means[code]),
                standard_deviation: Some(deviation),
                seeds,
                reference_code: Some(CODES[reference].into()),
                difference: Some(difference),
                interval90: Some([difference - 1.86 * error, difference + 1.86 * error]),
                interval_of_verdict: Some(verdict),
                margin,
                outcome,
                missing: None,
                seeds_needed: (outcome == Some(Outcome::Undecided)).then_some(9),
            }
        })
        .into()
}

fn code(place: usize, source: Source, wall: f64) -> CodeSummary {
    CodeSummary {
        code: CODES[place].into(),
        version: ["0.1.0", "3.8.0", "2023.02a"][place].into(),
        source,
        seeds: vec![1, 2, 3, 4, 5],
        time_step: Some([5e-4, 1.62e-5, 1.62e-5][place]),
        rayleigh_fraction: [None, Some(0.2), Some(0.2)][place],
        wall_seconds_per_simulated_second: wall,
        timing: match source {
            Source::Live => Timing::Alone,
            Source::Recorded => Timing::Recorded,
            Source::Published => Timing::Published,
        },
        processor: match source {
            Source::Live => "Intel Xeon Platinum 8488C".into(),
            Source::Recorded => "AMD EPYC 7763".into(),
            Source::Published => String::new(),
        },
        provenance: match source {
            Source::Live => "run for this report, one core".into(),
            Source::Recorded => "reference-scenes/drum/reference, recorded 2026-02-11".into(),
            Source::Published => "Author (2024)".into(),
        },
    }
}

fn forces() -> Vec<ForceDistribution> {
    (0..3u64)
        .map(|place| {
            let force: Vec<f64> = (0..28).map(|k| 0.125 + 0.25 * k as f64).collect();
            let samples = 9000;
            let density = force
                .iter()
                .map(|&f| {
                    let exact = 3.0 * (1.0 - 0.75 * (-f * f).exp()) * (-1.5 * f).exp();
                    let count = exact * 0.25 * samples as f64;
                    (count + count.sqrt() * noise(place, (f * 8.0) as u64)).max(0.0).round() / (0.25 * samples as f64)
                })
                .collect();
            ForceDistribution { code: CODES[place as usize].into(), force, density, samples }
        })
        .collect()
}

/// Grains on a hexagonal lattice below a plane that slopes by `angle` degrees, inside a drum of radius 0.1 m.
pub fn bed(seed: u64, angle: f64) -> Vec<Particle> {
    let (sine, cosine) = angle.to_radians().sin_cos();
    let (mut particles, d) = (Vec::new(), 0.0104);
    for layer in 0..11 {
        for row in -10i32..1 {
            for column in -10i32..10 {
                let u = (f64::from(column) + 0.5 * f64::from(row.rem_euclid(2))) * d;
                let v = f64::from(row) * d * 0.87 - 0.018;
                let id = particles.len() as u64;
                let jitter = |k| 0.0008 * noise(seed * 8 + k, id);
                let position = [
                    u * cosine + v * sine + jitter(0),
                    -0.054 + f64::from(layer) * d + jitter(1),
                    -u * sine + v * cosine + jitter(2),
                ];
                if position[0].hypot(position[2]) > 0.0945 {
                    continue;
                }
                // A flowing layer on top of a bed that turns with the drum.
                let flow = 0.35 * (f64::from(row) / 2.0).exp();
                particles.push(Particle {
                    id: id as u32,
                    position,
                    radius: 0.005 * (1.0 + 0.05 * noise(seed + 77, id)),
                    velocity: [flow * cosine + position[2], 0.0, -flow * sine - position[0]],
                    spin: [0.0; 3],
                });
            }
        }
    }
    particles
}

pub fn drum(recorded_yade: bool) -> Comparison {
    let scene = scene("drum");
    let yade = if recorded_yade { Source::Recorded } else { Source::Live };
    let series = (0..3u64)
        .map(|place| {
            let time: Vec<f64> = (0..=160).map(|k| 0.05 * k as f64).collect();
            let mut wander = 0.0;
            let value = time
                .iter()
                .enumerate()
                .map(|(k, t)| {
                    wander = 0.85 * wander + 0.5 * noise(place + 5, k as u64);
                    27.1 + 0.2 * place as f64 + wander - 27.0 * (-4.0 * t).exp()
                })
                .collect();
            Series {
                code: CODES[place as usize].into(),
                seed: 1,
                observable: "dynamic_angle_of_repose".into(),
                time,
                value,
            }
        })
        .collect();
    let final_states = (0..3)
        .map(|place| FinalState { code: CODES[place].into(), seed: 1, time: 8.0, particles: bed(place as u64, 27.0) })
        .collect();
    let mut all = rows(&scene, "dynamic_angle_of_repose", "degree", [27.13, 27.34, 27.48], 0.31, 5);
    all.extend(rows(&scene, "coordination_number", "", [4.093, 4.121, 4.131], 0.021, 5));
    all.extend(rows(&scene, "share_below_mean", "", [0.6012, 0.6031, 0.5990], 0.0049, 5));
    all.extend(rows(&scene, "gini", "", [0.4461, 0.4412, 0.4390], 0.0033, 5));
    all.extend(rows(&scene, "shell_layer_speed_ratio", "", [0.841, 0.846, 0.838], 0.006, 5));
    all.extend(rows(&scene, "wall_torque", "N m", [2.31e-4, 2.35e-4, 2.29e-4], 4e-6, 5));
    Comparison {
        judged: "Makadam".into(),
        rows: all,
        codes: vec![code(0, Source::Live, 0.917), code(1, Source::Live, 3.13), code(2, yade, 14.2)],
        series,
        forces: forces(),
        final_states,
        notes: if recorded_yade {
            vec!["YADE's numbers are recorded ones: it is not installed here.".into()]
        } else {
            Vec::new()
        },
        scene,
    }
}

/// A comparison with a disagreement, an undecided test, and references that differ by more than a margin.
pub fn packing() -> Comparison {
    let scene = scene("packing");
    let mut all = rows(&scene, "packing_fraction", "", [0.5846, 0.5862, 0.5871], 0.0011, 5);
    all.extend(rows(&scene, "coordination_number", "", [4.81, 5.06, 5.09], 0.02, 5));
    all.extend(rows(&scene, "share_below_mean", "", [0.594, 0.604, 0.577], 0.004, 5));
    all.extend(rows(&scene, "gini", "", [0.431, 0.445, 0.437], 0.011, 5));
    all.extend(rows(&scene, "wall_force_over_weight", "", [1.0002, 0.9998, 1.0001], 0.0002, 5));
    let particles = |seed: u64| -> Vec<Particle> {
        (0..1760u64)
            .map(|id| {
                let (k, layer) = (id % 220, id / 220);
                let jitter = |axis| 0.001 * noise(seed * 3 + axis, id);
                Particle {
                    id: id as u32,
                    position: [
                        -0.074 + 0.0105 * (k % 15) as f64 + jitter(0) + 0.003 * (layer % 2) as f64,
                        -0.074 + 0.0105 * (k / 15) as f64 + jitter(1),
                        0.005 + 0.0088 * layer as f64 + jitter(2),
                    ],
                    radius: 0.005,
                    velocity: [1e-6; 3],
                    spin: [0.0; 3],
                }
            })
            .collect()
    };
    Comparison {
        judged: "Makadam".into(),
        rows: all,
        codes: vec![code(0, Source::Live, 0.31), code(1, Source::Live, 4.5), code(2, Source::Live, 23.0)],
        series: Vec::new(),
        forces: forces(),
        final_states: (0..3)
            .map(|place| FinalState {
                code: CODES[place].into(),
                seed: 1,
                time: 1.5,
                particles: particles(place as u64),
            })
            .collect(),
        notes: Vec::new(),
        scene,
    }
}

/// A comparison in which only Makadam took part.
pub fn alone() -> Comparison {
    let scene = scene("heap");
    let row = Row {
        scene: scene.name.clone(),
        observable: "static_angle_of_repose".into(),
        unit: "degree".into(),
        code: CODES[0].into(),
        mean: Some(23.4),
        standard_deviation: Some(0.0),
        seeds: 1,
        reference_code: None,
        difference: None,
        interval90: None,
        interval_of_verdict: None,
        margin: Some(1.5),
        outcome: None,
        missing: None,
        seeds_needed: None,
    };
    let only = CodeSummary { seeds: vec![1], ..code(0, Source::Live, 0.42) };
    Comparison {
        judged: "Makadam".into(),
        rows: vec![row],
        codes: vec![only],
        series: Vec::new(),
        forces: Vec::new(),
        final_states: Vec::new(),
        notes: vec!["LIGGGHTS and YADE are not installed, and no recorded reference exists.".into()],
        scene,
    }
}

/// A study of one test.
pub fn study(outcome: StudyOutcome) -> StudySection {
    StudySection {
        name: "stability".into(),
        title: "Hard cases".into(),
        scope: "Scenes that break simulators.".into(),
        runs: 1,
        wall_seconds: 2.0,
        tests: vec![StudyTest {
            name: "stack-10".into(),
            measured: "top grain below its place 0.1".into(),
            right: "10 grains stay where they are".into(),
            outcome,
            remark: None,
        }],
        files: vec![("stability.csv".into(), b"case\n".to_vec())],
        ..StudySection::default()
    }
}

pub fn qualification(comparisons: Vec<Comparison>) -> Qualification {
    Qualification {
        title: "Qualification of Makadam 0.1.0".into(),
        tier: "full".into(),
        wall_seconds: 1263.0,
        comparisons,
        provenance: [
            ("version", "0.1.0"),
            ("commit", "8485eb7 (dirty)"),
            ("compiler", "rustc 1.95.0"),
            ("instruction_set", "AVX-512F"),
            ("threads", "1"),
            ("processor", "Intel Xeon Platinum 8488C"),
            ("date", "2026-03-02"),
            ("scene_hash_drum", "9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08"),
        ]
        .map(|(key, value)| (key.to_string(), value.to_string()))
        .into(),
        ..Qualification::default()
    }
}
