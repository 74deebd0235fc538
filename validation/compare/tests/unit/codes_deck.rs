//! Unit tests of `src/codes/deck.rs`.

use super::*;

#[test]
fn a_grain_has_the_diameter_density_and_place_of_the_scene() {
    let scene = "name = 'one'\nduration = 1.0\ngravity = [0, 0, -9.81]\n\
             domain = { min = [-0.1, -0.1, -0.2], max = [0.1, 0.1, 0.2] }\n[material.glass]\ndensity = 2500.0\n\
             youngs_modulus = 1e7\npoisson_ratio = 0.3\nfriction = 0.5\nrestitution = 0.3\n[[grain]]\nmaterial = 'glass'\n\
             radius = 0.005\nposition = [0.01, -0.02, 0.03]\nvelocity = [1.0, 2.0, 3.0]\nspin = [4.0, 5.0, 6.0]\n";
    let scene = MeasuredScene::parse(scene).unwrap();
    let grains = makadam::scene::populate(&scene, 1).unwrap();
    let text = data(&scene, &grains, &Palette::new(&scene, &grains), 1);
    let row = |heading: &str| -> Vec<f64> {
        let rows = text.split(&format!("\n{heading}\n\n")).nth(1).unwrap();
        rows.lines().next().unwrap().split(' ').map(|word| word.parse().unwrap()).collect()
    };
    assert_eq!(row("Atoms"), [1.0, 1.0, 0.01, 2500.0, 0.01, -0.02, 0.03]);
    assert_eq!(row("Velocities"), [1.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
}
