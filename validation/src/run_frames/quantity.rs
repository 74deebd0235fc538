//! One number per grain, to colour by.

use super::RunFrame;

/// A number of every grain, with its unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantity {
    /// Its name in words, such as "angular velocity".
    pub title: String,
    /// Its unit; empty for plain numbers.
    pub unit: &'static str,
    /// One value per grain.
    pub values: Vec<f64>,
    /// Names of the values where they are numbers of something that has names.
    pub names: Vec<String>,
}

/// What follows from another array where a frame does not hold it: the name of the one, and of the other.
const DERIVED: [(&str, &str); 4] =
    [("speed", "velocity"), ("pressure", "stress"), ("angular_velocity", "spin"), ("diameter", "radius")];

/// Unit of a field, by its name; empty for numbers and what is not known.
pub fn unit_of(name: &str) -> &'static str {
    match name {
        "diameter" | "radius" => "m",
        "mass" => "kg",
        "speed" | "velocity" => "m/s",
        "angular_velocity" | "spin" => "rad/s",
        "force" => "N",
        "stress" | "pressure" => "Pa",
        _ => "",
    }
}

impl RunFrame {
    /// Names of the fields that grains have a number of, in order.
    pub fn quantities(&self) -> Vec<String> {
        let mut names: Vec<String> = self.grains.fields.iter().map(|array| array.name.clone()).collect();
        let derived = DERIVED.iter().filter(|(_, from)| self.grains.fields.iter().any(|array| array.name == *from));
        names.extend(derived.map(|(name, _)| (*name).to_string()));
        names.retain(|name| name != "stress" && name != "radius" && name != "spin");
        names.sort();
        names.dedup();
        names
    }

    /// A field as one number per grain: of vectors the length.
    pub fn quantity(&self, name: &str) -> Option<Quantity> {
        let array = |name: &str| self.grains.fields.iter().find(|array| array.name == name);
        let length = |vector: &[f64]| vector.iter().map(|component| component * component).sum::<f64>().sqrt();
        let values: Vec<f64> = match (array(name), name) {
            (Some(found), _) if found.components == 1 => found.values(),
            (Some(found), _) if found.components == 3 => found.values().chunks_exact(3).map(length).collect(),
            (_, "diameter") => self.grains.radii.iter().map(|radius| 2.0 * radius).collect(),
            (_, "pressure") => {
                let stress = array("stress").filter(|stress| stress.components == 6)?.values();
                stress.chunks_exact(6).map(|stress| stress[..3].iter().sum::<f64>() / 3.0).collect()
            }
            (_, name) => {
                let (_, from) = DERIVED.iter().find(|(of, _)| *of == name)?;
                array(from).filter(|array| array.components == 3)?.values().chunks_exact(3).map(length).collect()
            }
        };
        let names = if name == "material" { self.grains.materials.clone() } else { Vec::new() };
        Some(Quantity { title: name.replace('_', " "), unit: unit_of(name), values, names })
    }
}
