//! What an ablation changes: the scene with one effect off, or on.

use crate::plan::Scene;
use makadam::effects::CATALOGUE;

/// A scene with one effect changed.
#[derive(Clone, Debug)]
pub struct Variation {
    /// The effect.
    pub effect: &'static str,
    /// What was changed, in words.
    pub change: String,
    /// The scene.
    pub scene: Scene,
}

/// Every effect of the scene turned off, and those turned on that are tried where there is none.
pub fn variations(scene: &Scene) -> Vec<Variation> {
    let mut base = scene.clone();
    // An accuracy would choose another step for another scene; here only the effect may differ.
    base.accuracy = None;
    let of_effects = CATALOGUE.iter().filter_map(|effect| {
        let tried = effect.tried.as_ref().filter(|_| effect.called_by(scene).is_err());
        let change = tried.or(effect.off.as_ref())?;
        let mut changed = base.clone();
        (change.apply)(&mut changed.simulated);
        let variation = || Variation { effect: effect.name, change: change.words.into(), scene: changed.clone() };
        (changed != base).then(variation)
    });
    of_effects.collect()
}
