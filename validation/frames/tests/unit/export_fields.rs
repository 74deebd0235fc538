use super::*;
use crate::plan::MeasuredScene;
use makadam::Simulation;
use makadam::snapshot::{Contact, Partner};
use std::sync::Arc;

/// Two grains of 10 mm in a periodic domain; the second one is the first one's neighbour across the end of the x axis.
const PAIR: &str = r#"
    name = "pair"
    description = "two grains"
    duration = 1.0
    gravity = [0.0, 0.0, 0.0]
    largest_start_overlap = 0.5
    domain = { min = [0.0, 0.0, 0.0], max = [0.2, 0.2, 0.2], periodic = ["x", "y", "z"] }
    [material.glass]
    density = 2500.0
    youngs_modulus = 1e7
    poisson_ratio = 0.3
    friction = 0.5
    restitution = 0.5
    [[grain]]
    material = "glass"
    radius = 0.005
    position = [0.004, 0.1, 0.1]
    velocity = [1.0, 2.0, 3.0]
    [[grain]]
    material = "glass"
    radius = 0.005
    position = [0.195, 0.1, 0.1]
    velocity = [1.0, 2.0, 3.0]
"#;

fn fields_of(scene: &MeasuredScene, change: impl Fn(&mut makadam::snapshot::Snapshot)) -> Fields {
    let mut snapshot = Simulation::new(scene, 1).unwrap().snapshot();
    change(&mut snapshot);
    let run = RunFrames::in_memory(scene, vec![Arc::new(snapshot)]);
    let mut fields = Fields::new(Grid::of(&run).unwrap());
    fields.add(&run.read(0).unwrap());
    fields
}

/// Sum over the nodes, each with the volume of a cell.
fn integral(fields: &Fields) -> Node {
    let mut sum = Node::default();
    fields.nodes.iter().for_each(|node| sum.merge(node));
    let cell = fields.grid.spacing.product();
    Node {
        volume: sum.volume * cell,
        mass: sum.mass * cell,
        momentum: sum.momentum * cell,
        flux: sum.flux * cell,
        contact_stress: sum.contact_stress * cell,
    }
}

#[test]
fn sums_over_space_are_those_of_the_grains() {
    let scene = MeasuredScene::parse(PAIR).unwrap();
    let push = |snapshot: &mut makadam::snapshot::Snapshot| {
        snapshot.contacts = vec![Contact {
            first: 0,
            second: Partner::Grain(1),
            point: [0.2, 0.1, 0.1],
            normal: [-1.0, 0.0, 0.0],
            normal_force: 3.0,
            tangential_force: [0.0, 0.6, 0.0],
        }];
    };
    let fields = fields_of(&scene, push);
    assert_eq!(fields.grid.counts, [20; 3]);
    let (sum, volume) = (integral(&fields), 2.0 * 4.0 / 3.0 * PI * 0.005_f64.powi(3));
    // The sum over nodes half a support apart is an integral to some percent.
    let near = |value: f64, expected: f64| (value / expected - 1.0).abs() < 0.03;
    assert!(near(sum.volume, volume) && near(sum.mass, 2500.0 * volume), "{sum:?}");
    assert!(near(sum.momentum.z, 3.0 * 2500.0 * volume), "{sum:?}");
    // The branch of 9 mm leads across the end of the axis; compression is positive.
    assert!(near(sum.contact_stress[(0, 0)], 3.0 * 0.009), "{sum:?}");
    assert!(near(sum.contact_stress[(1, 0)], -0.6 * 0.009) && sum.contact_stress[(0, 1)].abs() < 1e-12, "{sum:?}");
}

#[test]
fn a_common_velocity_has_no_kinetic_stress() {
    let fields = fields_of(&MeasuredScene::parse(PAIR).unwrap(), |_| {});
    for node in fields.nodes.iter().filter(|node| node.mass > 0.0) {
        let velocity = node.momentum / node.mass;
        assert!((velocity - Vector3::new(1.0, 2.0, 3.0)).norm() < 1e-12);
        assert!((node.flux - node.momentum * velocity.transpose()).norm() < 1e-12 * node.flux.norm());
    }
}

#[test]
fn the_stress_below_a_bed_is_its_weight_per_area() {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/scenes/smoke.toml")).unwrap();
    // Walls without friction bear no weight.
    let (grains, walls) = text.split_once("[material.wall]").unwrap();
    let text = [grains, &walls.replacen("friction = 0.5", "friction = 0.0", 1)].join("[material.wall]");
    let scene = MeasuredScene::parse(&text).unwrap();
    let mut simulation = Simulation::builder(&scene).time_step(1e-3).build().unwrap();
    (0..1500).for_each(|_| {
        simulation.step();
    });
    let snapshot = simulation.snapshot();
    let run = RunFrames::in_memory(&scene, vec![Arc::new(snapshot)]);
    let frame = run.read(0).unwrap();
    let mut fields = Fields::new(Grid::of(&run).unwrap());
    fields.add(&frame);
    // Balance of momentum over the layers of nodes: the vertical force through a layer is the weight above it.
    let Grid { spacing, counts, .. } = fields.grid;
    let layer = |k: usize| &fields.nodes[k * counts[0] * counts[1]..(k + 1) * counts[0] * counts[1]];
    let area = spacing.x * spacing.y;
    let weight: f64 = frame.column("mass").unwrap().values.iter().sum::<f64>() * 9.81;
    let force = |k: usize| layer(k).iter().map(|node| node.contact_stress[(2, 2)]).sum::<f64>() * area;
    let above = |k: usize| {
        let mass = |k: usize| layer(k).iter().map(|node| node.mass).sum::<f64>();
        (0.5 * mass(k) + (k + 1..counts[2]).map(mass).sum::<f64>()) * area * spacing.z * 9.81
    };
    // The lower half of the bed, above the reach of the floor.
    let middle = (0..counts[2]).find(|&k| above(k) < 0.7 * weight).unwrap();
    assert!((force(middle) / above(middle) - 1.0).abs() < 0.05, "{} N, {} N", force(middle), above(middle));
}
