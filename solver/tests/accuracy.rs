//! Settings that follow from an accuracy: closed forms of the rule, and that whatever makes a scene harder never lengthens the step.

use approx::assert_relative_eq;
use makadam::scene::{Scene, Stop};
use std::path::Path;

const GRAVITY: f64 = 9.81;

/// Step (s) and tolerance (g h) of a reference scene with an accuracy and other values, each as from and to.
fn chosen(name: &str, accuracy: &str, changes: &[(&str, &str)]) -> (f64, f64) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let mut text = std::fs::read_to_string(root.join(format!("reference-scenes/{name}/scene.toml"))).unwrap();
    for (from, to) in changes {
        assert!(text.contains(from), "{name} no longer has {from}");
        text = text.replace(from, to);
    }
    let text = text.replacen("[material.grain]", &format!("accuracy = {{ {accuracy} }}\n[material.grain]"), 1);
    let scene = Scene::parse(&text).unwrap();
    match scene.solver.stop {
        Stop::Residual { tolerance, .. } => (scene.solver.step, tolerance),
        other => panic!("{other:?}"),
    }
}

fn packing(accuracy: &str, changes: &[(&str, &str)]) -> f64 {
    chosen("packing", accuracy, changes).0
}

#[test]
fn a_packing_of_soft_grains_follows_the_contact_time_and_one_of_stiff_grains_the_fall() {
    let at = |modulus: &str, target: &str, friction: &str, spread: &str| {
        packing(
            &format!("packing_fraction = {target}"),
            &[
                ("youngs_modulus = 1e7", &format!("youngs_modulus = {modulus}")),
                ("friction = 0.5", &format!("friction = {friction}")),
                ("spread = 0.05", &format!("spread = {spread}")),
            ],
        )
    };
    // Time of a contact of grains of 4.75 mm under half of a bed 54 mm deep: 0.53 ms.
    let soft = at("1e7", "0.002", "0.5", "0.05");
    assert!((0.29e-3..0.32e-3).contains(&soft), "{soft}");
    assert_eq!(soft, at("1e7", "0.002", "0.1", "0.05"));
    assert_relative_eq!(soft, 2.0 * at("1e7", "0.001", "0.5", "0.05"), max_relative = 1e-12);
    assert_relative_eq!(soft, at("8e6", "0.002", "0.5", "0.05") * 0.8_f64.cbrt(), max_relative = 1e-12);
    let fall = |friction: f64, smallest: f64| 0.002 / 0.14 / (1.0 + friction) * (smallest / GRAVITY).sqrt();
    assert_relative_eq!(at("1e10", "0.002", "0.5", "0.05"), fall(0.5, 4.75e-3), max_relative = 1e-12);
    assert_relative_eq!(at("1e10", "0.002", "0.1", "0.05"), fall(0.1, 4.75e-3), max_relative = 1e-12);
    assert_relative_eq!(at("1e10", "0.002", "3.0", "0.5"), fall(1.0, 2.5e-3), max_relative = 1e-12);
}

#[test]
fn friction_mobilisation_and_angles_follow_the_contact_time() {
    let at = |target: &str, modulus: &str| {
        packing(target, &[("youngs_modulus = 1e7", &format!("youngs_modulus = {modulus}"))])
    };
    for (name, target, half) in [("friction_mobilisation", "0.01", "0.005"), ("angle", "0.5", "0.25")] {
        let [whole, half] = [target, half].map(|target| at(&format!("{name} = {target}"), "1e8"));
        assert_relative_eq!(whole, 2.0 * half, max_relative = 1e-12);
        let [soft, stiff] = ["1e7", "1e10"].map(|modulus| at(&format!("{name} = {target}"), modulus));
        assert_relative_eq!(soft, 10.0 * stiff, max_relative = 1e-12);
    }
    let (step, tolerance) = chosen("packing", "friction_mobilisation = 0.01", &[]);
    assert!((0.31e-3..0.335e-3).contains(&step), "{step}");
    assert_relative_eq!(tolerance, 0.02, max_relative = 1e-12);
}

#[test]
fn harder_scenes_never_get_longer_steps() {
    let targets = "packing_fraction = 0.002, angle = 0.3, friction_mobilisation = 0.01";
    let easy = packing(targets, &[]);
    for harder in [
        ("friction = 0.5", "friction = 0.9"),
        ("spread = 0.05", "spread = 0.4"),
        ("youngs_modulus = 1e7", "youngs_modulus = 1e9"),
        ("gravity = [0.0, 0.0, -9.81]", "gravity = [0.0, 0.0, -30.0]"),
        ("mean = 0.005", "mean = 0.0045"),
    ] {
        let hard = packing(targets, &[harder]);
        assert!(hard <= easy, "{harder:?}: {hard} {easy}");
    }
    for target in ["packing_fraction", "angle", "friction_mobilisation"] {
        let steps = [1e-3, 1e-2, 1e-1, 1.0].map(|value| packing(&format!("{target} = {value}"), &[]));
        assert!(steps.is_sorted(), "{target}: {steps:?}");
    }
}

#[test]
fn a_share_asks_for_no_overlap() {
    // An overlap of a ten thousandth of the radius would take hundreds of sweeps in a deep bed.
    let (_, tolerance) = chosen("packing-deep", "relative = 0.01", &[("step = 2.5e-4", "")]);
    assert_relative_eq!(tolerance, 0.06, max_relative = 1e-12);
}
