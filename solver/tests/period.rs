//! Minimum images and wrapped points of a periodic domain.

use makadam::effects::period::Period;
use nalgebra::Vector3;

fn period() -> Period {
    Period::new([3.0, 1.0, 5.0], [true, false, true])
}

#[test]
fn the_nearest_image_is_never_further_than_half_a_period() {
    let arm = period().arm(&Vector3::new(1.9, 0.1, 4.9), &Vector3::new(-0.9, 0.9, 20.2));
    assert!((arm - Vector3::new(0.2, 0.8, 0.3)).norm() < 1e-12, "{arm}");
    for lap in -20..20 {
        let [x, _, z] = period().shortest([1.4 + 3.0 * f64::from(lap), 0.7, 2.4 - 5.0 * f64::from(lap)]);
        assert!((x - 1.4).abs() < 1e-12 && (z - 2.4).abs() < 1e-12, "{x} {z}");
    }
}

#[test]
fn without_periodic_axes_an_arm_is_a_difference() {
    let (a, b) = (Vector3::new(0.1, 0.2, 0.3), Vector3::new(1e3, -2e3, 0.7));
    assert_eq!(Period::default().arm(&a, &b), b - a);
    assert_eq!(Period::default().wrapped(&b, &a), b);
}

#[test]
fn wrapped_points_lie_in_the_domain() {
    let low = Vector3::new(-1.0, 0.0, 0.0);
    for x in [-1.0, 2.0, 1.999, 302.0, -1.0 - 1e-17, -301.5] {
        let image = period().wrapped(&Vector3::new(x, 7.0, -0.1), &low);
        assert!((-1.0..2.0).contains(&image.x), "{x} went to {}", image.x);
        assert_eq!(image.y, 7.0);
        assert!((image.z - 4.9).abs() < 1e-12);
    }
}
