use super::{cylinder, moving};
use crate::common::Setup;
use makadam::Simulation;
use makadam::scene::{Motion, Shape, Wall};

#[test]
#[ignore = "timing"]
fn timing() {
    let (radius, length, grain) = (0.1, 0.12, 0.0025);
    let motion =
        Motion::Rotating { point: [0.0; 3], axis: [0.0, 1.0, 0.0], rate: 1.5, start: 0.0, stop: None, reverse: None };
    let body = format!(
        "[[population]]\ncount = 12000\nmaterial = 'grain'\nradius = {{ kind = 'uniform', mean = {grain}, spread = 0.1 }}\nspacing = 1.02\n\
         region = {{ kind = 'cylinder', base = [0,0.0001,0], axis = [0,1,0], radius = 0.097, length = 0.1198 }}\n"
    );
    let solver = "step = 2e-4\nnormal_law = { kind = 'hertz' }\nstop = { kind = 'sweeps', sweeps = 10 }";
    let shell = Wall::new("drum", "wall", Shape::Cylinder { base: [0.0; 3], axis: [0.0, 1.0, 0.0], radius, length })
        .moving(motion.clone());
    let cap = |y: f64, n: f64| {
        Wall::new(
            format!("cap{n}"),
            "wall",
            Shape::Disc { centre: [0.0, y, 0.0], normal: [0.0, n, 0.0], radius, hole: 0.0 },
        )
        .moving(motion.clone())
    };
    let walls = [
        ("analytic", shell),
        ("580", moving("drum", &cylinder(radius, length, 58, 5), motion.clone())),
        ("100000", moving("drum", &cylinder(radius, length, 1000, 50), motion.clone())),
    ];
    let mut runs: Vec<_> = walls
        .iter()
        .map(|(name, wall)| {
            let setup = Setup { youngs_modulus: 1e7, solver: solver.into(), body: body.clone(), ..Setup::default() };
            let mut scene = setup.scene();
            scene.domain = makadam::Domain { min: [-0.11, -0.01, -0.11], max: [0.11, 0.13, 0.11], periodic: vec![] };
            scene.wall.extend([wall.clone(), cap(0.0, 1.0), cap(length, -1.0)]);
            let mut simulation = Simulation::new(&scene, 1).unwrap();
            for _ in 0..1500 {
                simulation.step();
            }
            println!("{name}: settled, {} wall contacts", super::wall_contacts(&simulation).len());
            (name, simulation, Vec::new())
        })
        .collect();
    for _ in 0..40 {
        for (_, simulation, times) in &mut runs {
            let begin = std::time::Instant::now();
            for _ in 0..50 {
                simulation.step();
            }
            times.push(begin.elapsed().as_secs_f64() / 15.0);
        }
    }
    let median = |times: &[f64]| {
        let mut all = times.to_vec();
        all.sort_by(f64::total_cmp);
        all[all.len() / 4]
    };
    let base = median(&runs[0].2);
    for (name, simulation, times) in &runs {
        let seconds = simulation.phase_seconds();
        println!(
            "{name}: {:.3} ms a step, {:.3}; {seconds:?} contacts {}",
            median(times) * 1e3,
            median(times) / base,
            super::wall_contacts(simulation).len()
        );
    }
}
