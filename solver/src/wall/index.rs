//! The index of a wall: which of its faces may be near a point, without asking all of them.
//!
//! A tree of boxes (bounding-volume hierarchy) over the faces as the scene places them, built once: a moving wall carries its
//! index with it, and the point is taken into the wall's frame. A node halves its faces by their middles along the longest side of
//! its box. Where space repeats itself, every image of the point that the whole tree may see is asked for.

use super::shape::Face;
use crate::laws::period::Period;
use nalgebra::Vector3;

type Vector = Vector3<f64>;

/// Faces of a node that is not divided.
const LEAF: usize = 4;

/// Faces of a wall from which on an index pays.
const FEWEST: usize = 16;

/// Depth of the deepest tree: halves of 2^32 faces, and what waits beside them.
const DEEPEST: usize = 64;

/// Largest rounding error of a distance, over the largest length that it comes from.
const SLACK: f64 = 1e-9;

/// Images of a point along one axis beyond which all faces count as near.
const MOST_IMAGES: f64 = 16.0;

/// A tree of boxes over the faces of a wall.
#[derive(Clone, Debug)]
pub(super) struct FaceIndex {
    /// The root first; the first half of a node behind it.
    nodes: Vec<Node>,
    /// Numbers of the faces, leaf after leaf.
    faces: Vec<u32>,
    period: Period,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    low: Vector,
    high: Vector,
    /// Of a leaf the place of its first face; of another node that of its second half.
    next: u32,
    /// Number of faces of a leaf; zero in other nodes.
    faces: u32,
}

impl FaceIndex {
    /// An index over faces, numbered from `first` on; absent where they are few, or one has no end.
    pub fn new(faces: &[Face], first: u32, period: Period) -> Option<FaceIndex> {
        if faces.len() < FEWEST {
            return None;
        }
        let bounds = faces.iter().map(Face::bounds).collect::<Option<Vec<[Vector; 2]>>>()?;
        let mut order: Vec<u32> = (0..faces.len() as u32).collect();
        let mut nodes = Vec::with_capacity(2 * faces.len().div_ceil(LEAF));
        divide(&mut nodes, &mut order, 0, &bounds);
        order.iter_mut().for_each(|face| *face += first);
        Some(FaceIndex { nodes, faces: order, period })
    }

    /// Visits every face that may be nearer than `radius` (m) to a point of the wall's frame (m), and some that are not, in no order that
    /// means anything; with periodic axes perhaps more than once.
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

    /// Searches for one image of the point.
    fn visit_near(&self, point: &Vector, radius: f64, visit: &mut impl FnMut(u32)) {
        let square = radius * radius;
        let (mut waiting, mut count) = ([0_u32; DEEPEST], 1);
        while count > 0 {
            count -= 1;
            let place = waiting[count] as usize;
            let node = &self.nodes[place];
            let beside = (node.low - point).sup(&(point - node.high)).sup(&Vector::zeros());
            // Written so that no distance, as from a point that is no number, is near.
            if beside.norm_squared() <= square {
                if node.faces > 0 {
                    let faces = node.next as usize..(node.next + node.faces) as usize;
                    self.faces[faces].iter().copied().for_each(&mut *visit);
                } else {
                    (waiting[count], waiting[count + 1]) = (place as u32 + 1, node.next);
                    count += 2;
                }
            }
        }
    }

    pub fn memory_bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<Node>() + self.faces.capacity() * size_of::<u32>()
    }
}

/// Adds the node of these faces, which lie from `start` on in the order of all, and those below it.
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
