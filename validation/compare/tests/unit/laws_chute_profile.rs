//! Unit tests of `src/laws/chute/profile.rs`.

use super::*;
use approx::assert_relative_eq;

#[test]
fn a_profile_of_known_exponent_is_found() {
    for exponent in [1.0, 1.5, 2.2] {
        // Layers of grains a tenth of a diameter apart, 20 diameters deep.
        let layer = |number: usize| {
            let height = (number as f64 + 0.5) * 0.1 * DIAMETER;
            let depth = 20.0 * DIAMETER - height;
            let speed = 2.0 - 3.0 * depth.powf(exponent);
            Particle {
                id: number as u32,
                position: [0.0, 0.0, height],
                radius: 0.02,
                velocity: [speed, 0.0, 0.0],
                spin: [0.0; 3],
            }
        };
        let frame = Snapshot { particles: (0..200).map(layer).collect(), ..Snapshot::default() };
        let mut profile = Profile::default();
        profile.add(&frame);
        let fit = profile.fit();
        assert_relative_eq!(fit.exponent, exponent, max_relative = 5e-3);
        assert_relative_eq!(fit.depth, 20.0 * DIAMETER, max_relative = 1e-9);
        if exponent == 1.5 {
            assert_relative_eq!(fit.bagnold, 3.0, max_relative = 1e-2);
            assert_relative_eq!(fit.surface_speed, 2.0, max_relative = 1e-3);
        }
    }
}

#[test]
fn the_stress_of_one_contact_and_of_moving_grains_is_known() {
    let grain = |id, height: f64, velocity| Particle {
        id,
        position: [0.0, 0.0, height * DIAMETER],
        radius: 0.5 * DIAMETER,
        velocity,
        spin: [0.0; 3],
    };
    // The upper grain presses on the lower one with 3 N and drags it along with 1 N.
    let contact = Contact {
        first: 0,
        second: Partner::Grain(1),
        point: [0.0, 0.0, 8.2 * DIAMETER],
        normal: [0.0, 0.0, -1.0],
        normal_force: 3.0,
        tangential_force: [1.0, 0.0, 0.0],
    };
    let particles = vec![grain(0, 8.4, [1.0, 0.0, 0.0]), grain(1, 8.1, [1.0, 0.0, 0.0])];
    let mut profile = Profile::default();
    profile.add(&Snapshot { particles, contacts: vec![contact], ..Snapshot::default() });
    let found = stress([&profile.bins[16]].into_iter(), 2.0);
    assert_relative_eq!(found.normal, 3.0 * DIAMETER / 2.0, max_relative = 1e-12);
    assert_relative_eq!(found.shear, DIAMETER / 2.0, max_relative = 1e-12);
    assert_relative_eq!(found.along, 0.0, epsilon = 1e-12);
    assert_eq!(found.across, 0.0);
    assert_relative_eq!(found.pressure(), DIAMETER / 2.0, max_relative = 1e-12);
    // Two grains of a bin that part across the chute; that both move along it is no stress.
    let particles = vec![grain(0, 8.2, [5.0, 2.0, 0.0]), grain(1, 8.3, [5.0, -2.0, 0.0])];
    let mut profile = Profile::default();
    profile.add(&Snapshot { particles, ..Snapshot::default() });
    let found = stress([&profile.bins[16]].into_iter(), 1.0);
    let mass = DENSITY * PI / 6.0 * DIAMETER.powi(3);
    assert_relative_eq!(found.across, 8.0 * mass, max_relative = 1e-12);
    assert_relative_eq!(found.along, 0.0, epsilon = 1e-12);
}
