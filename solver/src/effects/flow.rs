//! Flow: grains that come from sources and go into sinks during a run.
//!
//! A source has let in `n(t) = r s` grains by the time t, with its rate r (1/s, or kg/s for their mass) and the time s since its
//! start, unless they wait for free places. A grain goes when its centre is in a sink. See `simulation/flow.rs`.

use super::catalogue::{Call, Effect};
use crate::scene::DocumentPath;

/// Grains that come from sources.
pub static INFLOW: Effect = Effect::of_scene("inflow", |scene| match scene.insert.first() {
    None => Err("no grains come during the run"),
    Some(source) => {
        let why = format!("grains of material '{}' come from insert[0]", source.material);
        Ok(Call { why, place: DocumentPath::default().key("insert").index(0) })
    }
});

/// Grains that go into sinks.
pub static OUTFLOW: Effect = Effect::of_scene("outflow", |scene| match scene.remove.first() {
    None => Err("no grains go during the run"),
    Some(_) => {
        let place = DocumentPath::default().key("remove").index(0);
        Ok(Call { why: "grains go in the region of remove[0]".into(), place })
    }
});
