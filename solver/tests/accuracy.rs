//! Settings that follow from an accuracy: closed forms of the rule, and that whatever makes a scene harder never lengthens the step.

use approx::assert_relative_eq;
use makadam::scene::{Scene, Stop};
use std::path::Path;

const GRAVITY: f64 = 9.81;

/// Step (s) and tolerance (g h) of `packing` with an accuracy and other values, each as from and to.
fn packing(accuracy: &str, changes: &[(&str, &str)]) -> (f64, f64) {
    chosen("packing", accuracy, changes)
}

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

#[test]
fn packing_fraction_follows_friction_and_smallest_radius() {
    let rule = |friction: f64, smallest: f64| 0.002 / (0.21 * (1.0 + friction)) * (smallest / GRAVITY).sqrt();
    let of = |friction: &str, spread: &str| {
        let friction = format!("friction = {friction}");
        packing("packing_fraction = 0.002", &[("friction = 0.5", &friction), ("spread = 0.05", spread)]).0
    };
    let (narrow, wide) = ("spread = 0.05", "spread = 0.5");
    assert_relative_eq!(of("0.5", narrow), rule(0.5, 4.75e-3), max_relative = 1e-12);
    assert_relative_eq!(of("0.1", narrow), rule(0.1, 4.75e-3), max_relative = 1e-12);
    assert_relative_eq!(of("0.8", narrow), rule(0.8, 4.75e-3), max_relative = 1e-12);
    assert_relative_eq!(of("3.0", narrow), rule(1.0, 4.75e-3), max_relative = 1e-12);
    assert_relative_eq!(of("1.0", wide), rule(1.0, 2.5e-3), max_relative = 1e-12);
}

#[test]
fn friction_mobilisation_follows_the_contact_time() {
    let at = |modulus: &str, target: &str| {
        let modulus = format!("youngs_modulus = {modulus}");
        packing(&format!("friction_mobilisation = {target}"), &[("youngs_modulus = 1e7", &modulus)]).0
    };
    // Measured: 0.010 ± 0.003 at 0.2 ms with 100 MPa.
    assert!((1.1e-4..1.3e-4).contains(&at("1e8", "0.01")), "{}", at("1e8", "0.01"));
    assert_relative_eq!(at("1e8", "0.01"), 2.0 * at("1e8", "0.005"), max_relative = 1e-12);
    assert_relative_eq!(at("1e7", "0.005"), at("1e10", "0.005") * 10.0, max_relative = 1e-12);
}

#[test]
fn angles_follow_the_froude_number() {
    let at = |rate: &str| chosen("drum", "angle = 0.3", &[("rate = 1.0", &format!("rate = {rate}"))]).0;
    let froude = |rate: f64| rate * rate * 0.1 / GRAVITY;
    // Faster drums take steps that are shorter by the formula alone.
    let ratio = (1.0 + 5.6 * froude(7.0)) / (1.0 + 5.6 * froude(1.0));
    assert_relative_eq!(at("1.0"), ratio * at("7.0"), max_relative = 1e-9);
    assert_relative_eq!(at("-7.0"), at("7.0"), max_relative = 1e-12);
}

#[test]
fn harder_scenes_never_get_longer_steps() {
    let targets = "packing_fraction = 0.002, angle = 0.3, friction_mobilisation = 0.01";
    let easy = packing(targets, &[]).0;
    for harder in [
        ("friction = 0.5", "friction = 0.9"),
        ("spread = 0.05", "spread = 0.4"),
        ("youngs_modulus = 1e7", "youngs_modulus = 1e9"),
        ("gravity = [0.0, 0.0, -9.81]", "gravity = [0.0, 0.0, -30.0]"),
        ("mean = 0.005", "mean = 0.0045"),
    ] {
        let hard = packing(targets, &[harder]).0;
        assert!(hard <= easy, "{harder:?}: {hard} {easy}");
    }
    for target in ["packing_fraction", "angle", "friction_mobilisation"] {
        let steps = [1e-3, 1e-2, 1e-1, 1.0].map(|value| packing(&format!("{target} = {value}"), &[]).0);
        assert!(steps.is_sorted(), "{target}: {steps:?}");
    }
}

#[test]
fn a_share_asks_for_no_overlap() {
    // An overlap of a ten thousandth of the radius would take hundreds of sweeps in a deep bed.
    let (_, tolerance) = chosen("packing-deep", "relative = 0.01", &[("step = 2.5e-4", "")]);
    assert_relative_eq!(tolerance, 0.06, max_relative = 1e-12);
}
