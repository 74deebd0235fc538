//! Unit tests of `src/commands/beforehand.rs`.

use super::*;

#[test]
fn available_memory_includes_free_swap() {
    let text = "MemTotal:  100 kB\nMemFree:  10 kB\nMemAvailable:   40 kB\nSwapFree:  2 kB\n";
    assert_eq!(of_meminfo(text), Some(42 * 1024));
    assert_eq!(of_meminfo("MemTotal: 100 kB\n"), None);
}

#[test]
fn a_picture_beyond_memory_is_refused_with_a_size_that_fits() {
    assert!(refuse_picture_beyond_memory([64, 64], 1 << 20).is_ok());
    assert!(matches!(refuse_picture_beyond_memory([16_384, 16_384], u64::MAX), Err(Failure::Running(_))));
    let message = picture_beyond([16_384, 16_384], 40_000_000_000, 4_000_000_000);
    for word in ["16384x16384 pixels takes some 40.0 GB", "4.0 GB are available", "such as 4915x4915"] {
        assert!(message.contains(word), "no '{word}' in: {message}");
    }
}

#[test]
fn more_than_there_is_is_refused_with_figures() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-scenes/packing/scene.toml");
    let mut scene = MeasuredScene::load(&file).unwrap();
    assert!(refuse_beyond_memory(&scene, &file).is_ok());
    scene.population[0].count = 1_000_000_000_000;
    assert!(matches!(refuse_beyond_memory(&scene, &file), Err(Failure::Running(_))));
    scene.population[0].count = 10_000_000;
    let message = beyond(&scene, &file, 1_500_000_000);
    for word in ["10000000 grains take some 15.", "1.5 GB are available", "lower population.count to some"] {
        assert!(message.contains(word), "no '{word}' in: {message}");
    }
}
