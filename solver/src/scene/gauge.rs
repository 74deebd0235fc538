//! Gauges: surfaces in space that count the grains that pass.

use super::document::{Checked, DocumentPath};
use super::{Scene, Shape, check};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Surface in space that counts the grains that pass, without touching them.
///
/// A grain passes in a step if its centre moves from one side of the surface to the other, on a straight line through the surface:
/// forward towards the side of the normal, otherwise backward. A centre on the surface is on the side of the normal. On a
/// common edge of two gauges, one of them counts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Gauge {
    /// Name, used in tables and errors.
    pub name: String,
    /// Rectangle, with the vector product of its edges as normal, or disc without a hole.
    pub shape: Shape,
}

impl Gauge {
    /// Returns the centre (m) and the unit normal; `None` for shapes other than a rectangle or a disc without a hole.
    pub(crate) fn place(&self) -> Option<[Vector3<f64>; 2]> {
        match &self.shape {
            Shape::Rectangle { corner, edges } => {
                let [first, second] = edges.map(Vector3::from);
                Some([Vector3::from(*corner) + (first + second) * 0.5, first.cross(&second).normalize()])
            }
            Shape::Disc { centre, normal, hole: 0.0, .. } => {
                Some([(*centre).into(), Vector3::from(*normal).normalize()])
            }
            _ => None,
        }
    }
}

/// Checks the gauges.
pub(super) fn check(scene: &Scene) -> Checked {
    let list = DocumentPath::default().key("gauge");
    check::own_names(&list, "gauge", scene.gauge.iter().map(|gauge| &*gauge.name))?;
    for (index, gauge) in scene.gauge.iter().enumerate() {
        let shape = &gauge.shape;
        let at = list.index(index).key("shape");
        let problem = || format!("a {} that is no gauge", shape.kind());
        at.require(gauge.place().is_some(), problem, "give a rectangle, or a disc without a hole")?;
        check::shape(&at, shape)?;
        let ((low, high), period) = (shape.bounds()[0], scene.domain.period());
        check::in_domain(scene, &at, (low, high), false)?;
        let width = |axis: usize| high[axis] - low[axis];
        let wide = |&axis: &usize| period.is_periodic(axis) && width(axis) > period.length(axis) * (1.0 + 1e-9);
        let words = |axis| format!("{} m wide along a periodic axis of {} m", width(axis), period.length(axis));
        let remedy = "end it within one period, or a grain would pass it twice at once";
        at.refuse((0..3).find(wide).map(words), remedy)?;
    }
    Ok(())
}
