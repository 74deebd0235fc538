//! VTK XML files of polygonal data, with arrays inline as base64: what ParaView opens without a plug-in.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use makadam::snapshot::{Partner, Snapshot};
use std::fmt::Write;

/// The grains of a frame: points with radius, velocity, spin and id.
pub(super) fn grains(frame: &Snapshot) -> String {
    let particles = &frame.particles;
    let mut file = PolyData::open(frame.time, particles.len(), Cells::Points);
    file.section("PointData", "Scalars=\"radius\" Vectors=\"velocity\"", |data| {
        data.floats("radius", 1, particles.iter().map(|p| p.radius));
        data.floats("velocity", 3, particles.iter().flat_map(|p| p.velocity));
        data.floats("spin", 3, particles.iter().flat_map(|p| p.spin));
        data.integers("id", particles.iter().map(|p| p.id as i32));
    });
    file.points(particles.iter().flat_map(|p| p.position), smallest_radius(frame));
    file.close()
}

/// The contacts of a frame: lines from centre to centre, or from the centre to the contact point on a wall, with forces.
pub(super) fn contacts(frame: &Snapshot) -> String {
    let contacts = &frame.contacts;
    let mut file = PolyData::open(frame.time, contacts.len(), Cells::Lines);
    file.section("CellData", "Scalars=\"normal_force\"", |data| {
        data.floats("normal_force", 1, contacts.iter().map(|c| c.normal_force));
        data.floats("tangential_force", 3, contacts.iter().flat_map(|c| c.tangential_force));
        data.floats("normal", 3, contacts.iter().flat_map(|c| c.normal));
        data.coordinates("point", contacts.iter().flat_map(|c| c.point), smallest_radius(frame));
        data.integers("first", contacts.iter().map(|c| c.first as i32));
        let grain = |partner| {
            if let Partner::Grain(id) = partner { id as i32 } else { -1 }
        };
        let wall = |partner| {
            if let Partner::Wall(place) = partner { place as i32 } else { -1 }
        };
        data.integers("second_grain", contacts.iter().map(|c| grain(c.second)));
        data.integers("second_wall", contacts.iter().map(|c| wall(c.second)));
    });
    let centre = |id: u32| frame.particles[id as usize].position;
    let ends = contacts.iter().flat_map(|contact| {
        let end = match contact.second {
            Partner::Grain(id) => centre(id),
            Partner::Wall(_) => contact.point,
        };
        centre(contact.first).into_iter().chain(end)
    });
    file.points(ends, smallest_radius(frame));
    file.close()
}

/// m.
fn smallest_radius(frame: &Snapshot) -> f64 {
    frame.particles.iter().map(|particle| particle.radius).fold(f64::INFINITY, f64::min)
}

/// What connects the points of a file.
#[derive(Clone, Copy, PartialEq)]
enum Cells {
    /// One vertex a point.
    Points,
    /// One line a pair of points.
    Lines,
}

/// A file that is being put together.
struct PolyData {
    text: String,
    cells: Cells,
    count: usize,
}

impl PolyData {
    fn open(time: f64, count: usize, cells: Cells) -> PolyData {
        let mut file = PolyData { text: String::new(), cells, count };
        let (points, vertices, lines) = match cells {
            Cells::Points => (count, count, 0),
            Cells::Lines => (2 * count, 0, count),
        };
        file.text += "<?xml version=\"1.0\"?>\n\
            <VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<PolyData>\n";
        file.section("FieldData", "", |data| {
            data.array("Float64", "TimeValue", "NumberOfTuples=\"1\"", &time.to_le_bytes());
        });
        let _ = writeln!(
            file.text,
            "<Piece NumberOfPoints=\"{points}\" NumberOfVerts=\"{vertices}\" NumberOfLines=\"{lines}\" \
             NumberOfStrips=\"0\" NumberOfPolys=\"0\">"
        );
        file
    }

    fn section(&mut self, name: &str, attributes: &str, fill: impl FnOnce(&mut PolyData)) {
        let gap = if attributes.is_empty() { "" } else { " " };
        let _ = writeln!(self.text, "<{name}{gap}{attributes}>");
        fill(self);
        let _ = writeln!(self.text, "</{name}>");
    }

    fn points(&mut self, coordinates: impl Iterator<Item = f64> + Clone, told_apart: f64) {
        self.section("Points", "", |data| data.coordinates("Points", coordinates, told_apart));
        let (name, size) = match self.cells {
            Cells::Points => ("Verts", 1),
            Cells::Lines => ("Lines", 2),
        };
        let count = self.count as i32;
        self.section(name, "", |data| {
            data.integers("connectivity", 0..count * size);
            data.integers("offsets", (1..=count).map(|cell| cell * size));
        });
    }

    /// Single precision is far finer than a pixel and halves the files.
    fn floats(&mut self, name: &str, components: usize, values: impl Iterator<Item = f64>) {
        let bytes: Vec<u8> = values.flat_map(|value| (value as f32).to_le_bytes()).collect();
        self.array("Float32", name, &format!("NumberOfComponents=\"{components}\""), &bytes);
    }

    /// Coordinates, in single precision as everything else, unless that would shift points by more than a thousandth of what has to be
    /// told apart (m).
    fn coordinates(&mut self, name: &str, values: impl Iterator<Item = f64> + Clone, told_apart: f64) {
        let farthest = values.clone().fold(0.0, |farthest: f64, coordinate| farthest.max(coordinate.abs()));
        if farthest * f64::from(f32::EPSILON) <= 1e-3 * told_apart {
            return self.floats(name, 3, values);
        }
        let bytes: Vec<u8> = values.flat_map(f64::to_le_bytes).collect();
        self.array("Float64", name, "NumberOfComponents=\"3\"", &bytes);
    }

    fn integers(&mut self, name: &str, values: impl Iterator<Item = i32>) {
        let bytes: Vec<u8> = values.flat_map(i32::to_le_bytes).collect();
        self.array("Int32", name, "NumberOfComponents=\"1\"", &bytes);
    }

    /// An array as base64: the number of bytes as an eight-byte integer, then the bytes.
    fn array(&mut self, kind: &str, name: &str, size: &str, bytes: &[u8]) {
        let _ = write!(self.text, "<DataArray type=\"{kind}\" Name=\"{name}\" {size} format=\"binary\">");
        let mut block = Vec::with_capacity(8 + bytes.len());
        block.extend((bytes.len() as u64).to_le_bytes());
        block.extend(bytes);
        STANDARD.encode_string(block, &mut self.text);
        self.text += "</DataArray>\n";
    }

    fn close(mut self) -> String {
        self.text += "</Piece>\n</PolyData>\n</VTKFile>\n";
        self.text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use makadam::snapshot::Particle;

    #[test]
    fn grains_far_from_the_origin_keep_their_places() {
        let at = |x: f64| {
            let particles = (0..2).map(|id| Particle {
                id,
                position: [x + 0.01 * f64::from(id), 0.0, 0.0],
                radius: 0.005,
                velocity: [0.0; 3],
                spin: [0.0; 3],
            });
            grains(&Snapshot { particles: particles.collect(), ..Snapshot::default() })
        };
        let points = |text: &str| {
            let (before, array) = text.split_once(" Name=\"Points\"").unwrap();
            let (double, data) = (before.ends_with("type=\"Float64\""), array.split(['>', '<']).nth(1).unwrap());
            (double, STANDARD.decode(data).unwrap()[8..].to_vec())
        };
        let (double, bytes) = points(&at(9e5));
        assert!(double);
        let x = |place: usize| f64::from_le_bytes(bytes[24 * place..24 * place + 8].try_into().unwrap());
        assert_eq!((x(0), x(1)), (9e5, 9e5 + 0.01));
        let (double, bytes) = points(&at(0.2));
        assert!(!double && bytes.len() == 24, "near the origin single precision tells them apart");
    }
}
