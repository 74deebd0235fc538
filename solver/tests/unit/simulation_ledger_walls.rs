//! Unit tests of `src/simulation/ledger/walls.rs`.

use super::*;
use crate::scene::Scene;

#[test]
fn an_impulse_outside_of_the_solve_is_accounted_for() {
    let text = "name = 'a'\ndescription = 'a'\nduration = 1.0\ngravity = [1.0, 0.0, -9.0]\n\
                domain = { min = [-1, -1, -1], max = [1, 1, 1] }\n\
                [material.grain]\ndensity = 2500.0\nyoungs_modulus = 1e7\npoisson_ratio = 0.3\nfriction = 0.5\n\
                restitution = 0.5\n[[grain]]\nmaterial = 'grain'\nradius = 0.01\nposition = [0, 0, 0]\n\
                velocity = [0.5, 0.0, -1.0]\nspin = [3.0, 2.0, 1.0]\n";
    let mut simulation = Simulation::new(&Scene::parse(text).unwrap(), 1).unwrap();
    simulation.open_ledger();
    simulation.step();
    // A wall that comes up at 2 m/s hits the grain from below, and turns it.
    let (normal, wall, impulse) = ([0.0, 0.0, -1.0], [0.0, 0.3, 2.0], [-0.002, 0.001, 0.04]);
    let (h, body) = (simulation.settings.step, &mut simulation.world.bodies[0]);
    let (old, mass) = (*body, 1.0 / body.inverse_mass);
    body.velocity = plus(body.velocity, times(impulse, body.inverse_mass));
    let turned = times(cross(normal, impulse), crate::world::INVERSE_INERTIA * body.inverse_mass);
    body.scaled_spin = plus(body.scaled_spin, turned);
    let relative = |body: &crate::world::Body| minus(wall, plus(body.velocity, cross(body.scaled_spin, normal)));
    let booked = WallImpulse {
        mass,
        normal,
        before: relative(&old),
        after: relative(body),
        impulse,
        wall_velocity: wall,
        centre: simulation.world.spheres[0].centre.into(),
        arm: times(normal, simulation.world.spheres[0].radius),
        shift: times(minus(old.velocity, body.velocity), h),
    };
    simulation.book_wall_impulse(&booked);
    let balance = simulation.balance().unwrap();
    assert!((balance.walls - dot(impulse, wall)).abs() < 1e-15 && balance.restitution > 0.0, "{balance:#?}");
    assert!(balance.closure.abs() < 1e-12 * balance.exchanged(), "{balance:#?}");
    assert!(balance.momentum_closure.iter().all(|open| open.abs() < 1e-15), "{balance:#?}");
    assert!(balance.angular_momentum_closure.iter().all(|open| open.abs() < 1e-15), "{balance:#?}");
    assert_eq!(simulation.work_of_walls(), balance.walls);
    simulation.step();
    assert!(simulation.balance().unwrap().closure.abs() < 1e-12 * balance.exchanged());
    assert_eq!(simulation.work_of_walls(), 0.0);
}
