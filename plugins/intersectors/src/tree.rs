//! A plain bounding volume hierarchy in double precision over numbered boxes.

use bhs_core::geometry::{Aabb, Segment};
use glam::DVec3;

/// A leaf is split while it has more boxes.
const LEAF: usize = 4;

/// Relative growth of boxes and slack of their parameters: some rounding errors, so that no box is missed whose content is hit.
const SLACK: f64 = 16.0 * f64::EPSILON;

/// Levels that the hierarchy can have: median splits halve `u32::MAX` boxes at most 32 times.
const DEPTH: usize = 48;

/// The first child of an inner node comes next in the list.
struct Node {
    bounds: Aabb,
    /// Of a leaf, its first box; of an inner node, its second child.
    link: u32,
    /// How many boxes; 0 in an inner node.
    count: u32,
    /// Along which an inner node is split.
    axis: usize,
}

/// The hierarchy.
pub(crate) struct Tree {
    nodes: Vec<Node>,
    /// The numbers of the boxes, in the order of the leaves.
    numbers: Vec<u32>,
}

impl Tree {
    /// Over `boxes`, of which there are at most `u32::MAX`. Empty ones are left out.
    pub(crate) fn new(boxes: &[Aabb]) -> Self {
        let mut numbers: Vec<u32> = (0u32..).zip(boxes).filter(|(_, b)| !b.is_empty()).map(|(i, _)| i).collect();
        let mut nodes = Vec::new();
        if !numbers.is_empty() {
            split(&mut nodes, boxes, &mut numbers, 0);
        }
        Self { nodes, numbers }
    }

    /// Calls `visit` with the number of each box that `segment` may pass, near ones mostly first, until that says that it is done. It may
    /// shorten the segment by its second argument, the parameter of its end.
    pub(crate) fn along(&self, segment: &Segment, mut visit: impl FnMut(u32, &mut f64) -> bool) {
        let inverse = segment.direction.recip();
        let mut t_max = segment.t_max;
        let mut stack = [0u32; DEPTH];
        let mut height = usize::from(!self.nodes.is_empty());
        while height > 0 {
            height -= 1;
            let index = stack[height];
            let node = &self.nodes[index as usize];
            if !meets(&node.bounds, segment, t_max, inverse) {
                continue;
            }
            if node.count == 0 {
                let (near, far) =
                    if segment.direction[node.axis] < 0.0 { (node.link, index + 1) } else { (index + 1, node.link) };
                stack[height] = far;
                stack[height + 1] = near;
                height += 2;
                continue;
            }
            for number in &self.numbers[node.link as usize..(node.link + node.count) as usize] {
                if visit(*number, &mut t_max) {
                    return;
                }
            }
        }
    }
}

/// Appends the hierarchy over the boxes `numbers`, the first of which stands at the place `first` of the leaves.
fn split(nodes: &mut Vec<Node>, boxes: &[Aabb], numbers: &mut [u32], first: usize) {
    let bounds = numbers.iter().fold(Aabb::EMPTY, |b, n| b.union(boxes[*n as usize]));
    let bounds = bounds.grown(SLACK * bounds.min.abs().max(bounds.max.abs()).max_element());
    let here = nodes.len();
    if numbers.len() <= LEAF {
        nodes.push(Node { bounds, link: first as u32, count: numbers.len() as u32, axis: 0 });
        return;
    }
    let center = |n: &u32| boxes[*n as usize].center();
    let centers = numbers.iter().fold(Aabb::EMPTY, |b, n| b.with_point(center(n)));
    let axis = (centers.max - centers.min).max_position();
    let half = numbers.len() / 2;
    numbers.select_nth_unstable_by(half, |a, b| center(a)[axis].total_cmp(&center(b)[axis]));
    nodes.push(Node { bounds, link: 0, count: 0, axis });
    let (left, right) = numbers.split_at_mut(half);
    split(nodes, boxes, left, first);
    nodes[here].link = nodes.len() as u32;
    split(nodes, boxes, right, first + half);
}

/// Whether the segment, cut at `t_max`, may pass the box. A product that is not a number (a segment within a box's face) rules nothing out.
fn meets(bounds: &Aabb, segment: &Segment, t_max: f64, inverse: DVec3) -> bool {
    let (mut enter, mut leave) = (segment.t_min, t_max);
    for axis in 0..3 {
        let a = (bounds.min[axis] - segment.origin[axis]) * inverse[axis];
        let b = (bounds.max[axis] - segment.origin[axis]) * inverse[axis];
        // f64::min and f64::max ignore what is not a number.
        if !a.is_nan() && !b.is_nan() {
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
    }
    enter - SLACK * enter.abs() <= leave + SLACK * leave.abs()
}
