//! Gauges: surfaces in space that count the grains that pass.

use super::Scene;
use super::document::{Checked, DocumentPath};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Surface in space that counts the grains that pass, without touching them.
///
/// A grain passes in a step if its centre moves from one side of the surface to the other, on a straight line through the surface:
/// forward towards the side of the normal, otherwise backward. A centre on the surface is on the side of the normal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Gauge {
    /// Name, used in tables and errors.
    pub name: String,
    /// Surface.
    pub shape: GaugeShape,
}

/// Surface of a gauge.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum GaugeShape {
    /// Rectangle or parallelogram; the normal is the vector product of the edges.
    Rectangle {
        /// Corner, metres.
        corner: [f64; 3],
        /// The two edges from the corner, metres.
        edges: [[f64; 3]; 2],
    },
    /// Disc.
    Disc {
        /// Centre, metres.
        centre: [f64; 3],
        /// Normal; need not be of unit length.
        normal: [f64; 3],
        /// Radius, metres.
        radius: f64,
    },
}

impl GaugeShape {
    /// Returns the centre (m), the unit normal (not a number without a direction), and half the extent along each axis, m.
    pub(crate) fn place(&self) -> [Vector3<f64>; 3] {
        match self {
            GaugeShape::Rectangle { corner, edges } => {
                let [first, second] = edges.map(Vector3::from);
                let centre = Vector3::from(*corner) + (first + second) * 0.5;
                [centre, first.cross(&second).normalize(), (first.abs() + second.abs()) * 0.5]
            }
            GaugeShape::Disc { centre, normal, radius } => {
                let normal = Vector3::from(*normal).normalize();
                [(*centre).into(), normal, normal.map(|along| radius * (1.0 - along * along).max(0.0).sqrt())]
            }
        }
    }
}

/// Checks the gauges.
pub(super) fn check(scene: &Scene) -> Checked {
    for (index, Gauge { name, shape }) in scene.gauge.iter().enumerate() {
        let root = DocumentPath::default().key("gauge").index(index);
        super::check::fit(&root.key("name"), "a gauge's name", name)?;
        if let Some(before) = scene.gauge[..index].iter().position(|gauge| gauge.name == *name) {
            let problem = format!("'{name}' is the name of gauge[{before}] too");
            return Err(root.key("name").fault(problem, "give each gauge a name of its own"));
        }
        let at = root.key("shape");
        match shape {
            GaugeShape::Rectangle { corner, edges } => {
                at.key("corner").finite(corner)?;
                edges.iter().try_for_each(|edge| at.key("edges").finite(edge))?;
                let [first, second] = edges.map(Vector3::from);
                if first.cross(&second).norm() <= 1e-9 * first.norm() * second.norm() {
                    let problem = format!("{edges:?} span no surface");
                    return Err(at.key("edges").fault(problem, "give two edges of different directions, in metres"));
                }
            }
            GaugeShape::Disc { centre, normal, radius } => {
                at.key("centre").finite(centre)?;
                at.key("normal").direction(normal)?;
                at.key("radius").range(*radius, 1e-9, 1e4, "m")?;
            }
        }
        let ([centre, _, half], domain) = (shape.place(), &scene.domain);
        let (low, high, period) = (centre - half, centre + half, domain.period());
        if (0..3).any(|axis| low[axis] > domain.max[axis] || high[axis] < domain.min[axis]) {
            let problem = format!("from {:?} to {:?} m, outside the domain", low.as_slice(), high.as_slice());
            return Err(at.fault(problem, "move it into [domain], or enlarge [domain]"));
        }
        let wide = |axis: &usize| period.is_periodic(*axis) && 2.0 * half[*axis] > period.length(*axis) * (1.0 + 1e-9);
        if let Some(axis) = (0..3).find(wide) {
            let problem = format!("{} m wide along a periodic axis of {} m", 2.0 * half[axis], period.length(axis));
            return Err(at.fault(problem, "end it within one period, or a grain would pass it twice at once"));
        }
    }
    Ok(())
}
