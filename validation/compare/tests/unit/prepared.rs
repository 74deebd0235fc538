//! Unit tests of `src/prepared.rs`.

use super::*;

fn smoke() -> MeasuredScene {
    MeasuredScene::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/scenes/smoke.toml")).unwrap()
}

fn bytes(label: &Label) -> Vec<u8> {
    seal(MARK, &postcard::to_stdvec(&(label, b"a state".to_vec())).unwrap())
}

#[test]
fn a_state_says_what_it_is_and_any_other_one_is_refused_in_words() {
    let scene = smoke();
    let label = || Label::of(&scene, 1);
    assert_eq!(labelled_state(&scene, 1, &bytes(&label())).unwrap(), b"a state");
    let refused = |seed: u64, bytes: &[u8], words: &str| {
        let message = labelled_state(&scene, seed, bytes).unwrap_err();
        assert!(message.contains(words), "{message}");
    };
    refused(2, &bytes(&label()), "with seed 1");
    refused(1, &bytes(&Label { scene_hash: 7, ..label() }), "0000000000000007");
    refused(1, &bytes(&Label { build: "0.1.9-abc".into(), ..label() }), "by build 0.1.9-abc, and this is build");
    let mut damaged = bytes(&label());
    *damaged.last_mut().unwrap() ^= 1;
    refused(1, &damaged, "damaged");
}
