//! `makadam roofline`: the JSON contract, what is written.

use crate::support::makadam;
use crate::support::small_scene::smoke;
use serde_json::Value;

#[test]
fn sweeps_lie_below_their_roofs() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["--settle", "0.1", "--json", "--output", "out"];
    let output = makadam(folder.path()).arg("roofline").arg(smoke()).args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let study: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((study["version"].as_u64(), study["command"].as_str()), (Some(1), Some("roofline")));
    let roofs = study["roofs"].as_array().unwrap();
    assert!(roofs.iter().all(|roofs| roofs["peak_flops_per_second"].as_f64().unwrap() > 1e8));
    let points = study["points"].as_array().unwrap();
    assert_eq!(points.len(), 2 * roofs.len(), "two kernels for each number of threads");
    for point in points {
        let share = point["share_of_roof"].as_f64().unwrap();
        assert!(share > 0.0 && share < 1.0, "{point}");
        assert!((86.0..=104.0).contains(&point["flops_per_contact_sweep"].as_f64().unwrap()), "{point}");
    }
    for name in ["roofline.html", "roofline.json", "points.csv", "roofs.csv", "roofline-1.svg"] {
        assert!(folder.path().join("out").join(name).is_file(), "{name}");
    }
}
