//! Starting states: grading curves, and grains at random free places.

use makadam::scene::{Scene, populate};

/// A cube of 0.1 m with a population of the given keys.
fn scene(population: &str) -> String {
    format!(
        "name = \"placement\"
        description = \"grains in a cube\"
        duration = 0.1
        domain = {{ min = [0.0, 0.0, 0.0], max = [0.1, 0.1, 0.1] }}
        [material.glass]
        density = 2500.0
        youngs_modulus = 1e7
        poisson_ratio = 0.3
        friction = 0.5
        restitution = 0.5
        [[wall]]
        name = \"pole\"
        material = \"glass\"
        shape = {{ kind = \"cylinder\", base = [0.05, 0.05, 0.0], axis = [0.0, 0.0, 1.0], radius = 0.02, length = 0.1 }}
        [[population]]
        material = \"glass\"
        region = {{ kind = \"box\", min = [0.0, 0.0, 0.0], max = [0.1, 0.1, 0.1] }}
        {population}"
    )
}

const GRADING: &str =
    "radius = { kind = \"sieve\", diameters = [0.001, 0.002, 0.005, 0.02], passing = [0.0, 0.1, 0.3, 1.0] }";

#[test]
fn masses_follow_the_grading_curve() {
    // Few grains are large, and the mass is theirs: many seeds.
    let scene = Scene::parse(&scene(&format!("count = 3000\nplacement = \"random\"\n{GRADING}"))).unwrap();
    let [mut below_2, mut below_5, mut all, mut log] = [0.0; 4];
    for seed in 0..40 {
        for grain in populate(&scene, seed).unwrap() {
            let (diameter, mass) = (2.0 * grain.radius, grain.radius.powi(3));
            assert!((0.001..=0.02).contains(&diameter));
            all += mass;
            below_2 += if diameter <= 0.002 { mass } else { 0.0 };
            below_5 += if diameter <= 0.005 { mass } else { 0.0 };
            log += if diameter <= 0.002 { mass * (diameter / 0.001).ln() } else { 0.0 };
        }
    }
    assert!(
        (below_2 / all - 0.1).abs() < 0.01 && (below_5 / all - 0.3).abs() < 0.02,
        "{}, {}",
        below_2 / all,
        below_5 / all
    );
    // Mass is uniform in the logarithm of the diameter between two sieves.
    assert!((log / below_2 / 2.0_f64.ln() - 0.5).abs() < 0.01, "{}", log / below_2);
}

#[test]
fn each_draw_meets_the_grading_curve() {
    for placement in ["random", "lattice"] {
        let cube = "region = { kind = \"box\", min = [0.0, 0.0, 0.0], max = [0.1, 0.1, 0.1] }";
        let roomy = "region = { kind = \"box\", min = [0.0, 0.0, 0.0], max = [0.5, 0.5, 0.5] }";
        let text = scene(&format!("count = 3000\nplacement = \"{placement}\"\n{GRADING}")).replace(cube, roomy);
        let text = text
            .replace("max = [0.1, 0.1, 0.1] }", "max = [0.5, 0.5, 0.5] }")
            .replace("[0.05, 0.05, 0.0]", "[9.0, 9.0, 0.0]");
        let scene = Scene::parse(&text).unwrap();
        for seed in 0..20 {
            let grains = populate(&scene, seed).unwrap();
            let mass = |most: f64| -> f64 {
                grains.iter().map(|grain| grain.radius).filter(|r| 2.0 * r <= most).map(|r| r.powi(3)).sum()
            };
            let [fine, middle] = [0.002, 0.005].map(|sieve| mass(sieve) / mass(1.0));
            assert!((fine - 0.1).abs() < 0.004 && (middle - 0.3).abs() < 0.012, "{placement} {seed}: {fine} {middle}");
            // Sizes do not follow the order of the grains.
            let half = |range: std::ops::Range<usize>| grains[range].iter().map(|grain| grain.radius).sum::<f64>();
            assert!((half(0..1500) / half(1500..3000) - 1.0).abs() < 0.1);
        }
    }
}

#[test]
fn numbers_between_two_sieves_pass_a_chi_squared_test() {
    let text = scene(
        "count = 20000\nplacement = \"random\"\nradius = { kind = \"sieve\", diameters = [0.0005, 0.001], passing = [0.0, 1.0] }",
    );
    let grains = populate(&Scene::parse(&text).unwrap(), 1).unwrap();
    // Twenty classes of equal numbers by the inverse of the distribution.
    let mut counts = [0.0; 20];
    for grain in &grains {
        let (a, b) = (0.0005_f64.powi(-3), 0.001_f64.powi(-3));
        let share = (a - (2.0 * grain.radius).powi(-3)) / (a - b);
        counts[((20.0 * share) as usize).min(19)] += 1.0;
    }
    let chi: f64 = counts.iter().map(|count| (count - 1000.0_f64).powi(2) / 1000.0).sum();
    // 99.9% of a chi-squared distribution with 19 degrees of freedom.
    assert!(chi < 43.8, "{chi}");
}

#[test]
fn random_places_are_free() {
    let text = scene(&format!("count = 3000\nplacement = \"random\"\nagitation = 0.1\n{GRADING}"));
    let scene = Scene::parse(&text).unwrap();
    let grains = populate(&scene, 3).unwrap();
    assert_eq!(grains.len(), 3000);
    assert_eq!(populate(&scene, 3).unwrap(), grains);
    for (index, one) in grains.iter().enumerate() {
        let from_axis = (one.position[0] - 0.05).hypot(one.position[1] - 0.05);
        assert!((from_axis - 0.02).abs() >= one.radius * (1.0 - 1e-12), "inside the pole: {one:?}");
        assert!(one.position.iter().all(|x| (one.radius..=0.1 - one.radius).contains(x)));
        for other in &grains[..index] {
            let square: f64 = (0..3).map(|axis| (one.position[axis] - other.position[axis]).powi(2)).sum();
            assert!(square >= (one.radius + other.radius).powi(2) * (1.0 - 1e-12));
        }
    }
}

#[test]
fn bad_placements_are_refused() {
    let refused = |population: &str, words: &[&str]| {
        let error = match Scene::parse(&scene(population)) {
            Ok(scene) => populate(&scene, 1).unwrap_err().to_string(),
            Err(error) => error.to_string(),
        };
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    };
    let fixed = "placement = \"random\"\nradius = { kind = \"fixed\", value = 0.01 }";
    refused(&format!("count = 300\n{fixed}"), &["population[0].count", "no free place", "enlarge the region"]);
    refused(&format!("count = 3\nspacing = 1.3\n{fixed}"), &["population[0].spacing", "random", "leave it out"]);
    let large = "count = 1\nplacement = \"random\"\nradius = { kind = \"fixed\", value = 0.06 }";
    refused(large, &["population[0].region", "0.1 m wide", "0.12 m"]);
    let sieve = |values: &str| format!("count = 3\nradius = {{ kind = \"sieve\", {values} }}");
    refused(&sieve("diameters = [0.001, 0.002], passing = [0.0, 100.0]"), &["passing", "100"]);
    refused(&sieve("diameters = [0.001, 0.002], passing = [0.2, 1.0]"), &["passing", "begin with 0"]);
    refused(&sieve("diameters = [0.002, 0.001], passing = [0.0, 1.0]"), &["radius", "ascending"]);
}
