//! Unit tests of `src/forecast/mod.rs`.

use super::*;

fn forecast(name: &str) -> Forecast {
    let text = makadam_compare::scenes::text(&makadam_compare::scenes::find(name, &[]).unwrap()).unwrap();
    Forecast::of(&MeasuredScene::parse(&text).unwrap(), &text).unwrap()
}

#[test]
fn a_drum_is_told_with_its_scales() {
    let forecast = forecast("drum");
    let scale = |name: &str| forecast.scales.iter().find(|scale| scale.name == name).unwrap().value;
    assert_eq!((forecast.grains, forecast.steps, forecast.walls), (1600, 16_000, 3));
    approx::assert_relative_eq!(scale("Froude number"), 0.1 / 9.81, max_relative = 1e-12);
    // pi r sqrt(rho/G)/(0.1631 nu + 0.8766), of grains of 4.75 mm and G of 3.85 MPa.
    assert!((scale("Rayleigh step") - 4.1e-4).abs() < 0.2e-4, "{}", scale("Rayleigh step"));
    assert!((1e-3..5e-2).contains(&scale("expected overlap")), "{}", scale("expected overlap"));
    assert!((0.5..60.0).contains(&forecast.wall_seconds));
    assert!(forecast.solver.starts_with("a step of 5e-4 s"), "{}", forecast.solver);
    assert!(forecast.moving_walls[0].contains("shell") && forecast.effects.contains(&"Coulomb friction"));
}

#[test]
fn a_bed_at_rest_has_no_numbers_of_moving_walls() {
    let text = crate::templates::template("box").unwrap().text;
    let forecast = Forecast::of(&MeasuredScene::parse(text).unwrap(), text).unwrap();
    assert!(forecast.scales.iter().all(|scale| scale.name != "Froude number"), "nothing turns");
    assert!(forecast.text().contains("residual below"), "{}", forecast.text());
}
