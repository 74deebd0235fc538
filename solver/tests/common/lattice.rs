//! A block of grains that close in on its middle, in a domain as large as one likes.

use makadam::scene::Scene;

/// Grains along an edge of the block.
pub const EDGE: i32 = 11;

/// Contacts when each grain touches its neighbours along the axes.
pub const CONTACTS: usize = 3 * (EDGE * EDGE * (EDGE - 1)) as usize;

/// Steps after which they do.
pub const CLOSED: usize = 16;

/// A block of 1,331 soft grains 5 mm in radius around each of some middles (m), and lone ones at rest, in a domain between two
/// corners (m); `periodic` is a line of TOML.
pub fn lattice(domain: [[f64; 3]; 2], periodic: &str, middles: &[[f64; 3]], lone: &[[f64; 3]]) -> Scene {
    let [min, max] = domain;
    let mut text = format!(
        "name = 'lattice'\ndescription = ''\nduration = 1\ngravity = [0, 0, 0]\n[domain]\nmin = {min:?}\nmax = {max:?}\n{periodic}\n\
         [material.grain]\ndensity = 2500\nyoungs_modulus = 1e5\npoisson_ratio = 0.3\nfriction = 0.5\nrestitution = 0.5\n\
         [solver]\nstep = 5e-4\nnormal_law = {{ kind = 'hertz' }}\nstop = {{ kind = 'sweeps', sweeps = 5 }}\n"
    );
    let mut grain = |position: [f64; 3], velocity: [f64; 3]| {
        let inside: [f64; 3] = std::array::from_fn(|axis| match periodic.contains(["'x'", "'y'", "'z'"][axis]) {
            true => min[axis] + (position[axis] - min[axis]).rem_euclid(max[axis] - min[axis]),
            false => position[axis],
        });
        text +=
            &format!("[[grain]]\nmaterial = 'grain'\nradius = 0.005\nposition = {inside:?}\nvelocity = {velocity:?}\n");
    };
    for middle in middles {
        for number in 0..EDGE * EDGE * EDGE {
            let at = [number % EDGE, number / EDGE % EDGE, number / (EDGE * EDGE)];
            let away = at.map(|place| 0.01005 * f64::from(place - EDGE / 2));
            grain(std::array::from_fn(|axis| middle[axis] + away[axis]), away.map(|along| -2.0 * along));
        }
    }
    lone.iter().for_each(|&position| grain(position, [0.0; 3]));
    Scene::parse(&text).unwrap_or_else(|error| panic!("{error}"))
}
