//! Whether this build has the effects that a scene calls for.

use super::place::{Checked, Place};
use super::{Cohesion, Motion, Scene};

/// Refuses a scene that calls for an effect which was left out of this build.
pub(super) fn check(scene: &Scene) -> Checked {
    let root = Place::default();
    for (name, material) in &scene.material {
        let coefficients = Coefficients {
            friction: Some(material.friction),
            rolling_friction: Some(material.rolling_friction),
            twisting_friction: Some(material.twisting_friction),
            kinetic_friction: material.kinetic_friction,
            restitution_speed: material.restitution_speed,
            cohesion: material.cohesion,
        };
        coefficients.check(&root.key("material").name(name))?;
    }
    for (index, pair) in scene.pair.iter().enumerate() {
        let coefficients = Coefficients {
            friction: pair.friction,
            rolling_friction: pair.rolling_friction,
            twisting_friction: pair.twisting_friction,
            kinetic_friction: pair.kinetic_friction,
            restitution_speed: pair.restitution_speed,
            cohesion: pair.cohesion,
        };
        coefficients.check(&root.key("pair").index(index))?;
    }
    for (index, wall) in scene.wall.iter().enumerate() {
        let vibrates = matches!(wall.motion, Motion::Vibrating { .. });
        let (motion, driven) = (root.key("wall").index(index).key("motion"), wall.motion.is_driven());
        needs(cfg!(feature = "vibration"), vibrates, &motion, "vibration")?;
        needs(cfg!(feature = "driven-walls"), driven, &motion, "driven-walls")?;
    }
    let (changes, periodic) = (!scene.gravity_changes.is_empty(), !scene.domain.periodic.is_empty());
    needs(cfg!(feature = "changing-gravity"), changes, &root.key("gravity_changes"), "changing-gravity")?;
    needs(cfg!(feature = "periodic-axes"), periodic, &root.key("domain").key("periodic"), "periodic-axes")
}

/// What a material or a pair may say.
struct Coefficients {
    friction: Option<f64>,
    rolling_friction: Option<f64>,
    twisting_friction: Option<f64>,
    kinetic_friction: Option<f64>,
    restitution_speed: Option<f64>,
    cohesion: Option<Cohesion>,
}

impl Coefficients {
    fn check(&self, at: &Place) -> Checked {
        let some = |value: Option<f64>| value.is_some_and(|value| value != 0.0);
        let (rolling, twisting) = (some(self.rolling_friction), some(self.twisting_friction));
        let (kinetic, falling) = (self.kinetic_friction.is_some(), self.restitution_speed.is_some());
        needs(cfg!(feature = "friction"), some(self.friction), &at.key("friction"), "friction")?;
        needs(cfg!(feature = "rolling-resistance"), rolling, &at.key("rolling_friction"), "rolling-resistance")?;
        needs(cfg!(feature = "twisting-resistance"), twisting, &at.key("twisting_friction"), "twisting-resistance")?;
        needs(cfg!(feature = "kinetic-friction"), kinetic, &at.key("kinetic_friction"), "kinetic-friction")?;
        needs(cfg!(feature = "falling-restitution"), falling, &at.key("restitution_speed"), "falling-restitution")?;
        needs(cfg!(feature = "cohesion"), self.cohesion.is_some(), &at.key("cohesion"), "cohesion")
    }
}

fn needs(built: bool, called_for: bool, at: &Place, feature: &str) -> Checked {
    match called_for && !built {
        true => Err(at.fault("this build has no such effect".into(), &format!("build with --features {feature}"))),
        false => Ok(()),
    }
}
