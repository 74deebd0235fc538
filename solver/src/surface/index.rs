//! Spatial index of a wall: finds the faces near a point without a loop over all faces.
//!
//! The index is a tree of boxes (bounding-volume hierarchy) over the faces at their positions in the scene, built once: the tree moves with
//! its wall, and points are transformed into the frame of the wall. A node divides its faces into halves by their centres along the longest
//! side of its box. With periodic axes, every image of the point within range of the whole tree is searched.

use super::face::Face;
use super::triangle::Triangle;
use crate::laws::period::Period;
use nalgebra::Vector3;

type Vector = Vector3<f64>;

/// Largest number of faces of a leaf.
const LEAF: usize = 4;

/// Smallest number of faces for which an index pays.
const FEWEST: usize = 16;

/// Largest stack of the traversal: halves of 2^32 faces, and the pending siblings.
const DEEPEST: usize = 64;

/// Largest rounding error of a distance, over the largest input length.
const SLACK: f64 = 1e-9;

/// Number of images of a point along one axis above which all faces are visited.
const MOST_IMAGES: f64 = 16.0;

/// Tree of boxes over the faces of a wall.
#[derive(Clone, Debug)]
pub(crate) struct FaceIndex {
    /// Nodes, the root first; the first child of a node directly follows the node.
    nodes: Vec<Node>,
    /// Layer around the triangles of each node, across their mean normal; empty for other faces.
    layers: Vec<Layer>,
    /// Indices of the faces, leaf after leaf.
    faces: Vec<u32>,
    period: Period,
}

/// Points between two planes. A box around a tilted patch of a surface is thick, a layer is not.
#[derive(Clone, Copy, Debug)]
struct Layer {
    /// Unit normal, or zero for a layer that contains all points.
    normal: Vector,
    low: f64,
    high: f64,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    low: Vector,
    high: Vector,
    /// Position of the first face of a leaf; index of the second child of any other node.
    next: u32,
    /// Number of faces of a leaf; zero for other nodes.
    faces: u32,
}

impl FaceIndex {
    /// Builds an index of faces, numbered from `first` on; absent for few faces, unless they are
    /// triangles, or if a face is infinite.
    pub fn new(faces: &[Face], first: u32, period: Period) -> Option<FaceIndex> {
        if faces.len() < FEWEST && !matches!(faces.first(), Some(Face::Triangle(_))) {
            return None;
        }
        let bounds = faces.iter().map(Face::bounds).collect::<Option<Vec<[Vector; 2]>>>()?;
        let mut order: Vec<u32> = (0..faces.len() as u32).collect();
        let mut nodes = Vec::with_capacity(2 * faces.len().div_ceil(LEAF));
        divide(&mut nodes, &mut order, 0, &bounds);
        let layers = layers(&nodes, &order, faces);
        order.iter_mut().for_each(|face| *face += first);
        Some(FaceIndex { nodes, layers, faces: order, period })
    }

    /// Visits every face that may be nearer than `radius` (m) to a point in the frame of the wall (m), and some others,
    /// in arbitrary order; with periodic axes, possibly more than once.
    pub fn for_each_near(&self, point: &Vector, radius: f64, mut visit: impl FnMut(u32)) {
        let Node { low, high, .. } = self.nodes[0];
        let radius = radius + SLACK * (radius + point.amax() + low.amax().max(high.amax()));
        if !self.period.any() {
            return self.visit_near(point, radius, &mut visit);
        }
        let (mut first, mut last) = ([0_i32; 3], [0_i32; 3]);
        for axis in (0..3).filter(|&axis| self.period.is_periodic(axis)) {
            let length = self.period.length(axis);
            let from = ((low[axis] - radius - point[axis]) / length).ceil();
            let to = ((high[axis] + radius - point[axis]) / length).floor();
            if to - from > MOST_IMAGES {
                return self.faces.iter().copied().for_each(visit);
            }
            (first[axis], last[axis]) = (from as i32, to as i32);
        }
        let laps = |axis: usize| first[axis]..=last[axis];
        for (x, y, z) in laps(0).flat_map(|x| laps(1).flat_map(move |y| laps(2).map(move |z| (x, y, z)))) {
            let lap = Vector::new(f64::from(x), f64::from(y), f64::from(z));
            let image = Vector::from_fn(|axis, _| point[axis] + lap[axis] * self.period.length(axis));
            self.visit_near(&image, radius, &mut visit);
        }
    }

    /// Returns true if a test holds for any of the faces that may be nearer than `radius` (m) to a point in the frame of the wall (m).
    /// Periodic axes are ignored.
    pub fn any_near(&self, point: &Vector, radius: f64, mut test: impl FnMut(u32) -> bool) -> bool {
        let Node { low, high, .. } = self.nodes[0];
        let radius = radius + SLACK * (radius + point.amax() + low.amax().max(high.amax()));
        self.search(point, radius, &mut test)
    }

    /// Searches for one image of the point.
    fn visit_near(&self, point: &Vector, radius: f64, visit: &mut impl FnMut(u32)) {
        self.search(point, radius, &mut |face| {
            visit(face);
            false
        });
    }

    /// Visits faces near a point until a visit returns true.
    #[inline]
    fn search(&self, point: &Vector, radius: f64, test: &mut impl FnMut(u32) -> bool) -> bool {
        let square = radius * radius;
        let (mut waiting, mut count) = ([0_u32; DEEPEST], 1);
        while count > 0 {
            count -= 1;
            let place = waiting[count] as usize;
            let node = &self.nodes[place];
            let beside = (node.low - point).sup(&(point - node.high)).sup(&Vector::zeros());
            // In this form, a comparison with NaN, as from an invalid point, is false.
            if beside.norm_squared() <= square
                && self.layers.get(place).is_none_or(|layer| layer.reaches(point, radius))
            {
                if node.faces > 0 {
                    let faces = node.next as usize..(node.next + node.faces) as usize;
                    for &face in &self.faces[faces] {
                        if test(face) {
                            return true;
                        }
                    }
                } else {
                    (waiting[count], waiting[count + 1]) = (place as u32 + 1, node.next);
                    count += 2;
                }
            }
        }
        false
    }

    /// Returns the smallest distance (m) of a point in the frame of the wall (m) from the faces, or a `limit` (m) if it is smaller;
    /// `distance` returns that of one face if it is below a limit. Periodic axes are ignored.
    pub fn nearest(&self, point: &Vector, limit: f64, distance: impl Fn(u32, f64) -> Option<f64>) -> f64 {
        let below = |place: usize| {
            let node = &self.nodes[place];
            let beside = (node.low - point).sup(&(point - node.high)).sup(&Vector::zeros()).norm();
            self.layers.get(place).map_or(beside, |layer| {
                let height = layer.normal.dot(point);
                beside.max(height - layer.high).max(layer.low - height)
            })
        };
        let (mut waiting, mut count, mut least) = ([(0, 0.0); DEEPEST], 1, limit);
        while count > 0 {
            count -= 1;
            let (place, bound) = waiting[count];
            if bound >= least {
                continue;
            }
            let node = &self.nodes[place];
            if node.faces > 0 {
                for &face in &self.faces[node.next as usize..(node.next + node.faces) as usize] {
                    least = distance(face, least).unwrap_or(least);
                }
                continue;
            }
            let mut children = [place + 1, node.next as usize].map(|child| (child, below(child)));
            // The nearer child comes first.
            if children[0].1 < children[1].1 {
                children.swap(0, 1);
            }
            (waiting[count], waiting[count + 1]) = (children[0], children[1]);
            count += 2;
        }
        least
    }

    pub fn memory_bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<Node>()
            + self.layers.capacity() * size_of::<Layer>()
            + self.faces.capacity() * size_of::<u32>()
    }
}

impl Layer {
    /// Returns true if a ball intersects the layer.
    #[inline]
    fn reaches(&self, point: &Vector, radius: f64) -> bool {
        let height = self.normal.dot(point);
        height - self.high <= radius && self.low - height <= radius
    }
}

/// Returns the layers of all nodes of a tree over triangles; none for other faces.
fn layers(nodes: &[Node], order: &[u32], faces: &[Face]) -> Vec<Layer> {
    let triangle = |face: &u32| match &faces[*face as usize] {
        Face::Triangle(triangle) => Some(triangle),
        _ => None,
    };
    if !order.iter().all(|face| triangle(face).is_some()) {
        return Vec::new();
    }
    let mut ends = vec![0; nodes.len()];
    let mut layers = vec![Layer { normal: Vector::zeros(), low: 0.0, high: 0.0 }; nodes.len()];
    // Children follow their parents, and the faces of a node are consecutive.
    for place in (0..nodes.len()).rev() {
        let node = &nodes[place];
        let (mut first, mut inner) = (place, node);
        while inner.faces == 0 {
            first += 1;
            inner = &nodes[first];
        }
        ends[place] = if node.faces > 0 { (node.next + node.faces) as usize } else { ends[node.next as usize] };
        let own = || order[inner.next as usize..ends[place]].iter().filter_map(triangle);
        let normal = own().map(Triangle::area_vector).sum::<Vector>().try_normalize(0.0).unwrap_or_else(Vector::zeros);
        let heights = || own().flat_map(|triangle| triangle.corners).map(|corner| normal.dot(&corner));
        let (low, high) = (heights().fold(f64::INFINITY, f64::min), heights().fold(f64::NEG_INFINITY, f64::max));
        layers[place] = Layer { normal, low, high };
    }
    layers
}

/// Adds the node of these faces, which begin at `start` in the order of all faces, and its descendants.
fn divide(nodes: &mut Vec<Node>, order: &mut [u32], start: u32, bounds: &[[Vector; 2]]) {
    let boxes = order.iter().map(|&face| bounds[face as usize]);
    let [low, high] = boxes.fold([Vector::repeat(f64::INFINITY), Vector::repeat(f64::NEG_INFINITY)], |all, own| {
        [all[0].inf(&own[0]), all[1].sup(&own[1])]
    });
    let (place, count) = (nodes.len(), order.len());
    nodes.push(Node { low, high, next: start, faces: count as u32 });
    if count <= LEAF {
        return;
    }
    let axis = (high - low).imax();
    let middle = |face: &u32| bounds[*face as usize][0][axis] + bounds[*face as usize][1][axis];
    let half = count / 2;
    order.select_nth_unstable_by(half, |a, b| middle(a).total_cmp(&middle(b)).then(a.cmp(b)));
    let (one, other) = order.split_at_mut(half);
    divide(nodes, one, start, bounds);
    (nodes[place].next, nodes[place].faces) = (nodes.len() as u32, 0);
    divide(nodes, other, start + half as u32, bounds);
}
