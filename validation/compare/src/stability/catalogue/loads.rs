//! Loads that a solver has to carry: mass ratios, stacks, deep columns, hyperstatic jams, size and stiffness ratios.

use crate::sketch::{DENSITY, GRAVITY, RADIUS, Sketch, hertz_overlap, mass};
use crate::stability::{Case, Evidence};
use crate::study::Finding;
use makadam::scene::{NormalLaw, Region, SolverMethod, Stop};
use makadam::snapshot::Particle;
use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

const BALANCE: &str = "balance of forces and Hertz's law (Johnson, Contact Mechanics, 1985, 4.2)";

/// Tolerated deviation of the force on walls at rest, as a fraction of the weight.
const WEIGHT: f64 = 0.01;

/// Speed of grains at rest, m/s: the speed gained in free fall during a step of 0.1 ms.
const AT_REST: f64 = 1e-3;

pub(super) fn cases() -> Vec<Case> {
    let mut cases: Vec<Case> = (1..=6).map(mass_ratio).collect();
    cases.extend([(10, 1e7), (100, 1e8)].map(|(count, modulus)| stack(count, modulus)));
    cases.push(stack(1000, 1e9).long());
    cases.push(deep_column().long());
    cases.extend([0.2, 0.5].map(lattice));
    cases.extend([groove(0.0), groove(0.5), jam()]);
    cases.extend([10.0, 30.0, 100.0].map(size_ratio));
    cases.push(stiffness_contrast());
    cases
}

/// Figures of a case, then those of rest: the walls carry the weight, all speeds are small.
fn resting(evidence: &Evidence<'_>, own: Vec<Finding>) -> Vec<Finding> {
    let at_rest = [
        Finding::near("force on walls over weight", evidence.carried(0.1), 1.0, WEIGHT),
        Finding::at_most("largest speed at the end", evidence.fastest(), AT_REST).in_unit("m/s"),
    ];
    own.into_iter().chain(at_rest).collect()
}

fn mass_ratio(exponent: i32) -> Case {
    const MODULUS: f64 = 1e10;
    const LIGHT: f64 = 100.0;
    let ratio = 10_f64.powi(exponent);
    // Densities stay below 30,000 kg/m3, so that the larger ratios need larger grains.
    let times = [1.0, 1.0, 10.0, 10.0, 10.0, 20.0][exponent as usize - 1];
    let radius = RADIUS * times;
    let (light, heavy) = (mass(RADIUS) / 25.0, mass(RADIUS) / 25.0 * ratio);
    let floor = hertz_overlap((light + heavy) * GRAVITY, [MODULUS; 2], RADIUS);
    let pair = hertz_overlap(heavy * GRAVITY, [MODULUS; 2], RADIUS * radius / (RADIUS + radius));
    let height = 2.0 * RADIUS + radius - floor - pair;
    let scene = Sketch::new(format!("mass-ratio-1e{exponent}"), 0.5)
        .modulus(MODULUS)
        .material("light", |material| material.density = LIGHT)
        .material("heavy", |material| material.density = LIGHT * ratio / times.powi(3))
        .with(|scene| scene.solver.method = SolverMethod::Anderson { memory: 3 })
        .with(|scene| scene.largest_start_overlap = 0.1)
        .floor()
        .grain(RADIUS, [0.0, 0.0, RADIUS - floor])
        .made_of("light")
        .grain(radius, [0.0, 0.0, height])
        .made_of("heavy")
        .scene();
    let right =
        format!("a grain {ratio:.0} times as heavy as the one under it, placed in equilibrium, stays where it is");
    Case::new("mass ratios", scene, right, BALANCE, move |evidence| {
        let sunk = (height - evidence.grain(1).position[2]) / RADIUS;
        let own = Finding::near("heavy grain below its place, over the light one's radius", sunk, 0.0, 0.01);
        resting(evidence, vec![own])
    })
}

fn stack(count: usize, modulus: f64) -> Case {
    let weight = mass(RADIUS) * GRAVITY;
    let overlap = |index: usize| {
        let effective_radius = if index == 0 { RADIUS } else { 0.5 * RADIUS };
        hertz_overlap((count - index) as f64 * weight, [modulus; 2], effective_radius)
    };
    let top = 2.0 * RADIUS * count as f64;
    let mut sketch = Sketch::new(format!("stack-{count}"), 1.0)
        .modulus(modulus)
        .domain([-0.2, -0.2, -0.1], [0.2, 0.2, top + 0.1])
        .with(|scene| scene.largest_start_overlap = 0.2)
        .floor();
    let (mut height, mut touch) = (0.0, RADIUS);
    for index in 0..count {
        height += touch - overlap(index);
        touch = 2.0 * RADIUS;
        sketch = sketch.grain(RADIUS, [0.0, 0.0, height]);
    }
    let largest = overlap(0).max(overlap(1)) / RADIUS;
    let right = format!("{count} grains one on the other, placed in equilibrium, stay where they are");
    Case::new("stacks", sketch.scene(), right, BALANCE, move |evidence| {
        let sunk = (height - evidence.grain(count - 1).position[2]) / height;
        let own = vec![
            Finding::near("top grain below its place, over its height", sunk, 0.0, 1e-3),
            Finding::at_most("largest overlap over the static one", evidence.largest_overlap(1.0) / largest, 1.5),
        ];
        resting(evidence, own)
    })
}

fn deep_column() -> Case {
    const WIDTH: f64 = 9.0 * RADIUS;
    const COUNT: usize = 4500;
    let half = 0.5 * WIDTH;
    let height = 3.4;
    let scene = Sketch::new("column-200-deep", 2.0)
        .domain([-0.05, -0.05, -0.05], [0.05, 0.05, height])
        .open_box([-half, -half, 0.0], [half, half, height])
        .population(COUNT, RADIUS, Region::Box { min: [-half, -half, 0.0], max: [half, half, height] })
        .sweeps(50)
        .scene();
    let pressure = mass(RADIUS) * GRAVITY * COUNT as f64 / (WIDTH * WIDTH);
    // Grains rain down by up to this height; between rough walls the bed retains stress of their impact. Their momentum
    // is at most that of a stream as dense as the bed.
    let drop = height - 200.0 * 2.0 * RADIUS;
    let impact = 0.6 * DENSITY * 2.0 * GRAVITY * drop;
    let bearable = (pressure + impact) * 4.0 * RADIUS * RADIUS;
    let source = "Janssen (1895): beyond a few widths the walls bear the weight; friction locks in what impacts brought, so contacts bear \
                  in the mean up to the pressure of weight and impact on a square of a diameter; of forces with an exponential tail \
                  (Mueth 1998) the largest of ten thousand is six to ten times the mean";
    let right = "a bed 200 diameters deep comes to rest, its floor bears less than a quarter of the weight, no contact bears more than \
                 its share";
    Case::new("stacks", scene, right, source, move |evidence| {
        // The floor's forces are those along the box's lower face.
        let frame = evidence.last();
        let on_floor = frame.contacts.iter().filter(|contact| contact.normal[2] < -0.9 && contact.point[2] < RADIUS);
        let floor: f64 = on_floor
            .filter(|contact| matches!(contact.second, makadam::snapshot::Partner::Wall(_)))
            .map(|contact| contact.normal_force)
            .sum();
        let forces = || frame.contacts.iter().map(|contact| contact.normal_force);
        let mean_force = forces().sum::<f64>() / frame.contacts.len().max(1) as f64;
        let largest_force = forces().fold(0.0, f64::max);
        vec![
            Finding::between("force on the floor over weight", floor / evidence.weight(), 1e-3, 0.25),
            Finding::near("force on walls over weight", evidence.carried(0.1), 1.0, 0.02),
            Finding::at_most("mean force over that of weight and impact", mean_force / bearable, 1.0),
            Finding::at_most("largest force over the mean", largest_force / mean_force, 12.0),
            Finding::at_most("grains lost", evidence.lost(), 0.0),
            Finding::at_most("largest speed at the end", evidence.fastest(), 0.01).in_unit("m/s"),
        ]
    })
}

/// Columns of 60 grains with gaps of a twentieth of a diameter, which close from below as the columns fall.
fn lattice(restitution: f64) -> Case {
    const WIDTH: usize = 4;
    const LARGE: f64 = 0.5;
    const DEEP: usize = 60;
    const PITCH: f64 = 1.05 * 2.0 * LARGE;
    let (half, top) = (0.5 * PITCH * WIDTH as f64, PITCH * (DEEP + 1) as f64);
    let mut sketch = Sketch::new(format!("lattice-{restitution}"), 2.0)
        .gravity([0.0, 0.0, -10.0])
        .friction(0.3)
        .restitution(restitution)
        .with(|scene| scene.solver.normal_law = NormalLaw::Rigid)
        .with(|scene| scene.solver.stop = Stop::Residual { tolerance: 1e-6, max_sweeps: 3000 })
        .domain([-half - 1.0, -half - 1.0, -1.0], [half + 1.0, half + 1.0, top])
        .open_box([-half, -half, 0.0], [half, half, top]);
    let at = |place: usize| (place as f64 + 0.5) * PITCH;
    for place in 0..WIDTH * WIDTH * DEEP {
        let (column, layer) = (place % (WIDTH * WIDTH), place / (WIDTH * WIDTH));
        let [x, y] = [column % WIDTH, column / WIDTH].map(|place| at(place) - half);
        sketch = sketch.grain(LARGE, [x, y, at(layer)]);
    }
    let source = "rigid grains in a column without a sideways force stand at r + k d; the bound is that of a published test of \
                  statics, a hundredth of the radius";
    let right = "16 columns of 60 rigid grains close their gaps, and no layer sinks below its place";
    Case::new("stacks", sketch.scene(), right, source, move |evidence| {
        let (start, end) = (&evidence.frames()[0].particles, &evidence.last().particles);
        let place = |start: &Particle| LARGE + 2.0 * LARGE * (start.position[2] / PITCH).floor();
        let sunk = start.iter().zip(end).map(|(start, end)| (place(start) - end.position[2]) / LARGE);
        vec![
            Finding::at_most("deepest layer below its place, over the radius", sunk.fold(f64::MIN, f64::max), 0.01),
            Finding::near("force on walls over weight", evidence.carried(0.1), 1.0, WEIGHT),
        ]
    })
}

fn groove(friction: f64) -> Case {
    let s = FRAC_1_SQRT_2;
    let height = RADIUS * SQRT_2;
    let (name, right) = match friction > 0.0 {
        true => ("groove-friction", "forces are not unique, but they balance the weight and the grain stays"),
        false => ("groove-smooth", "each side bears the weight over the square root of 2, and the grain stays"),
    };
    let scene = Sketch::new(name, 0.5)
        .friction(friction)
        .plane([0.0; 3], [s, 0.0, s])
        .plane([0.0; 3], [-s, 0.0, s])
        .grain(RADIUS, [0.0, 0.0, height])
        .scene();
    Case::new("hyperstatic", scene, right, "balance of forces", move |evidence| {
        let aside = evidence.grain(0).position[0].abs() / RADIUS;
        let force = evidence.force_on_wall(0, 0.1).norm() / evidence.weight();
        let unique = (friction == 0.0).then(|| Finding::near("force on one side over weight", force, s, WEIGHT * s));
        let beside = Finding::at_most("grain beside the groove's middle, over its radius", aside, 1e-3);
        resting(evidence, unique.into_iter().chain([beside]).collect())
    })
}

fn jam() -> Case {
    let half = 3.0 * RADIUS;
    let mut sketch = Sketch::new("jam-27", 0.5).open_box([-half, -half, 0.0], [half, half, 0.1]);
    for place in 0..27 {
        let at = |index: i32| 2.0 * RADIUS * f64::from(index - 1);
        sketch = sketch.grain(RADIUS, [at(place % 3), at(place / 3 % 3), at(place / 9) + half]);
    }
    let weight = mass(RADIUS) * GRAVITY;
    let sink: f64 = [(3.0, 1.0), (2.0, 0.5), (1.0, 0.5)]
        .iter()
        .map(|(above, share)| hertz_overlap(above * weight, [1e7; 2], share * RADIUS))
        .sum();
    let right =
        "27 grains that fill their box exactly stay, bear their weight and sink by no more than smooth columns would";
    Case::new("hyperstatic", sketch.scene(), right, BALANCE, move |evidence| {
        let start = &evidence.frames()[0].particles;
        let grains = || evidence.last().particles.iter().zip(start);
        let sunk = grains().map(|(end, start)| start.position[2] - end.position[2]).fold(f64::NEG_INFINITY, f64::max);
        let aside = grains()
            .flat_map(|(end, start)| [0, 1].map(|axis| (end.position[axis] - start.position[axis]).abs()))
            .fold(0.0, f64::max);
        let own = vec![
            Finding::between("deepest sunk over smooth columns", sunk / sink, 0.0, 1.01),
            Finding::at_most("furthest aside over the radius", aside / RADIUS, 0.01),
        ];
        resting(evidence, own)
    })
}

fn size_ratio(ratio: f64) -> Case {
    const LARGE: f64 = 0.05;
    const MODULUS: f64 = 1e10;
    let small = LARGE / ratio;
    let from_axis = 3.0 * small;
    let touch = LARGE + small;
    let height = small + (touch * touch - from_axis * from_axis).sqrt();
    let mut sketch = Sketch::new(format!("size-ratio-{ratio}"), 0.3)
        .modulus(MODULUS)
        .with(|scene| scene.solver.method = SolverMethod::Anderson { memory: 3 })
        .floor();
    for corner in 0..3 {
        let (sine, cosine) = (f64::from(corner) * std::f64::consts::TAU / 3.0).sin_cos();
        sketch = sketch.grain(small, [from_axis * cosine, from_axis * sine, small]);
    }
    let third = mass(LARGE) * GRAVITY / 3.0;
    let static_overlaps =
        hertz_overlap(third, [MODULUS; 2], small) + hertz_overlap(third, [MODULUS; 2], small * LARGE / touch);
    // Slightly more than the static overlaps, since the small grains may lean apart under load.
    let most = 2.0 * static_overlaps / small + 0.01;
    let right = format!("a grain {ratio} times as large stays on three small ones, whose friction is enough");
    let source = "Coulomb's cone holds: the tangent of half the lean, 3/(ratio + 1), is below the friction of 0.5";
    Case::new("size ratios", sketch.grain(LARGE, [0.0, 0.0, height]).scene(), right, source, move |evidence| {
        let sunk = (height - evidence.grain(3).position[2]) / small;
        resting(evidence, vec![Finding::between("large grain sunk, over the small radius", sunk, 0.0, most)])
    })
}

fn stiffness_contrast() -> Case {
    const SOFT: f64 = 1e5;
    const STIFF: f64 = 1e11;
    let weight = mass(RADIUS) * GRAVITY;
    let sink = hertz_overlap(3.0 * weight, [SOFT, STIFF], RADIUS)
        + hertz_overlap(2.0 * weight, [SOFT, STIFF], 0.5 * RADIUS)
        + hertz_overlap(weight, [STIFF, STIFF], 0.5 * RADIUS);
    let scene = Sketch::new("stiffness-contrast", 1.0)
        .modulus(STIFF)
        .material("soft", |material| material.youngs_modulus = SOFT)
        .floor()
        .grain(RADIUS, [0.0, 0.0, RADIUS])
        .made_of("soft")
        .grain(RADIUS, [0.0, 0.0, 3.0 * RADIUS])
        .grain(RADIUS, [0.0, 0.0, 5.0 * RADIUS])
        .scene();
    let right = "two stiff grains rest on one a million times as soft, at the static overlaps";
    Case::new("stiffness contrast", scene, right, BALANCE, move |evidence| {
        let sunk = (5.0 * RADIUS - evidence.grain(2).position[2]) / sink;
        resting(evidence, vec![Finding::near("top grain's sinking over the static one", sunk, 1.0, 0.02)])
    })
}
