//! A partition of a cube that follows a cloud of points.

use super::cubature::{Bounds, MOST, Part, Place};

/// A partition of the cube [-1, 1]^dimension into boxes that hold about as many of the given points
/// each: a k-d tree with its leaves numbered.
pub(super) enum Tree {
    /// A box and its number.
    Leaf(usize),
    /// Axis, where it is cut, and the parts below and above.
    Cut(usize, f64, Box<[Tree; 2]>),
}

impl Tree {
    /// Cuts the box at the median of the points along their widest spread, `levels` times over;
    /// appends the leaves to `leaves`, cut into parts as [`surround`] does.
    pub(super) fn grow(
        points: &mut [Place],
        bounds: Bounds,
        dimension: usize,
        levels: usize,
        leaves: &mut Vec<Part>,
    ) -> Tree {
        let hull = hull(points);
        let spread = |axis: usize| hull[axis].1 - hull[axis].0;
        let axis = (0..dimension).max_by(|a, b| spread(*a).total_cmp(&spread(*b))).unwrap_or(0);
        if levels == 0 || points.len() < 2 || spread(axis) <= 0.0 {
            let number = leaves.last().map_or(0, |(owner, _)| owner + 1);
            clusters(points, bounds, dimension, CLUSTERS, &mut |part| leaves.push((number, part)));
            return Tree::Leaf(number);
        }
        let middle = points.len() / 2;
        points.select_nth_unstable_by(middle, |a, b| a[axis].total_cmp(&b[axis]));
        let upper = points[middle][axis];
        let (below, above) = points.split_at_mut(middle);
        let lower = below.iter().fold(f64::NEG_INFINITY, |most, p| most.max(p[axis]));
        // In the middle between both: where they are apart, neither reaches a sliver into the other's box.
        let between = 0.5 * (lower + upper);
        let at = if between > lower { between } else { upper };
        let (mut low, mut high) = (bounds, bounds);
        (low[axis].1, high[axis].0) = (at, at);
        let low = Tree::grow(below, low, dimension, levels - 1, leaves);
        let high = Tree::grow(above, high, dimension, levels - 1, leaves);
        Tree::Cut(axis, at, Box::new([low, high]))
    }

    /// The number of the leaf that a point lies in.
    pub(super) fn leaf(&self, point: &Place) -> usize {
        match self {
            Tree::Leaf(number) => *number,
            Tree::Cut(axis, at, parts) => parts[usize::from(point[*axis] >= *at)].leaf(point),
        }
    }
}

/// A partition of the unit cube into equal cells.
pub(super) struct Grid {
    dimension: usize,
    /// How many cells there are along an axis.
    cells: usize,
}

impl Grid {
    /// About 64 cells.
    pub(super) fn new(dimension: usize) -> Grid {
        Grid { dimension, cells: 64_f64.powf(1.0 / dimension as f64).round() as usize }
    }

    /// Each cell with its number.
    pub(super) fn parts(&self) -> Vec<Part> {
        let width = 1.0 / self.cells as f64;
        let part = |number: usize| {
            let mut bounds = [(0.0, 1.0); MOST];
            for (axis, bounds) in bounds.iter_mut().enumerate().take(self.dimension) {
                let along = number / self.cells.pow(axis as u32) % self.cells;
                *bounds = (along as f64 * width, (along + 1) as f64 * width);
            }
            (number, bounds)
        };
        (0..self.cells.pow(self.dimension as u32)).map(part).collect()
    }

    /// The number of the cell that a place lies in; `None` outside of the cube.
    pub(super) fn cell(&self, place: &[f64]) -> Option<usize> {
        let along = |t: &f64| {
            let inside = (-ROUNDING..=1.0 + ROUNDING).contains(t);
            inside.then(|| ((t * self.cells as f64).max(0.0) as usize).min(self.cells - 1))
        };
        place.iter().rev().try_fold(0, |number, t| Some(number * self.cells + along(t)?))
    }
}

/// What the place of a sample may be off by.
const ROUNDING: f64 = 1e-6;

/// Cuts all parts that reach beyond both sides of a plane across `axis` in two.
pub(super) fn cut(parts: &mut Vec<Part>, axis: usize, at: f64) {
    for k in 0..parts.len() {
        let (owner, bounds) = parts[k];
        if bounds[axis].0 < at && at < bounds[axis].1 {
            let mut above = bounds;
            above[axis].0 = at;
            parts[k].1[axis].1 = at;
            parts.push((owner, above));
        }
    }
}

/// A box is taken apart so often where its points are in heaps, if they are so many; and how much of it a gap between these
/// takes at least.
const CLUSTERS: usize = 6;
const FEWEST: usize = 8;
const GAP: f64 = 0.25;

/// Cuts `bounds` in the middle of wide gaps between the points, and each part as [`surround`] does: two heaps at the ends of a
/// box might be so narrow that no rule sees them in it.
fn clusters(
    points: &mut [Place],
    mut bounds: Bounds,
    dimension: usize,
    most: usize,
    visit: &mut dyn FnMut(Bounds),
) {
    let may = most > 0 && points.len() >= FEWEST;
    let widest = (0..if may { dimension } else { 0 }).filter_map(|axis| {
        let mut along: Vec<f64> = points.iter().map(|p| p[axis]).collect();
        along.sort_unstable_by(f64::total_cmp);
        let spread = along.last()? - along.first()?;
        let gap = |pair: &[f64]| (pair[1] - pair[0], pair[0], pair[1]);
        let (width, from, to) = along.windows(2).map(gap).max_by(|a, b| a.0.total_cmp(&b.0))?;
        let at = 0.5 * (from + to);
        (width > GAP * spread && at > from).then_some((width / spread, axis, at))
    });
    let widest = widest.max_by(|a, b| a.0.total_cmp(&b.0));
    let Some((_, axis, at)) = widest else {
        return surround(&hull(points), bounds, dimension, visit);
    };
    points.sort_unstable_by(|a, b| a[axis].total_cmp(&b[axis]));
    let (below, above) = points.split_at_mut(points.partition_point(|p| p[axis] < at));
    let end = std::mem::replace(&mut bounds[axis].1, at);
    clusters(below, bounds, dimension, most - 1, visit);
    bounds[axis] = (at, end);
    clusters(above, bounds, dimension, most - 1, visit);
}

/// The smallest box around the points.
fn hull(points: &[Place]) -> Bounds {
    core::array::from_fn(|axis| {
        let all = points.iter().map(|p| p[axis]);
        (all.clone().fold(1.0, f64::min), all.fold(-1.0, f64::max))
    })
}

/// Cuts `bounds` into the hull and slabs around it, which get wider the farther out they are. The
/// density at the edge of its support may fill but a sliver of a wide box, where no rule sees it.
fn surround(hull: &Bounds, mut bounds: Bounds, dimension: usize, mut visit: impl FnMut(Bounds)) {
    for axis in 0..dimension {
        let (low, high) = hull[axis];
        let first = ((high - low) / 8.0).max(1e-9);
        for side in [-1.0, 1.0] {
            let (mut from, end) =
                if side < 0.0 { (low, bounds[axis].0) } else { (high, bounds[axis].1) };
            let mut width = first;
            while side * (end - from) > 0.0 {
                // The rest, if it is not much wider than the next slab.
                let to = if side * (end - from) < 2.0 * width { end } else { from + side * width };
                let mut slab = bounds;
                slab[axis] = (f64::min(from, to), f64::max(from, to));
                visit(slab);
                (from, width) = (to, 4.0 * width);
            }
        }
        bounds[axis] = (low, high);
    }
    visit(bounds);
}

#[cfg(test)]
mod tests {
    use super::*;

    const CUBE: Bounds = [(-1.0, 1.0); MOST];

    #[test]
    fn the_cells_of_a_grid_are_where_their_numbers_say() {
        for dimension in 1..=MOST {
            let grid = Grid::new(dimension);
            let parts = grid.parts();
            assert!((64..=81).contains(&parts.len()), "{} cells", parts.len());
            for (number, bounds) in parts {
                let middle = bounds.map(|(low, high)| 0.5 * (low + high));
                assert_eq!(grid.cell(&middle[..dimension]), Some(number));
            }
            assert_eq!(grid.cell(&[1.0, 0.5, 0.5, -0.1][MOST - dimension..]), None);
        }
    }

    #[test]
    fn leaves_hold_equally_many_points_and_tile_the_cube() {
        let mut points: Vec<Place> = (0..1024)
            .map(|k| {
                [(f64::from(k) * 0.618_034).fract(), (f64::from(k) * 0.414_214).fract(), 0.0, 0.0]
            })
            .collect();
        let mut leaves = Vec::new();
        let tree = Tree::grow(&mut points, CUBE, 2, 5, &mut leaves);
        let mut counts = [0; 32];
        points.iter().for_each(|p| counts[tree.leaf(p)] += 1);
        assert_eq!(counts, [32; 32]);
        let area = |leaves: &[Part]| -> f64 {
            leaves.iter().map(|(_, b)| (b[0].1 - b[0].0) * (b[1].1 - b[1].0)).sum()
        };
        assert!((area(&leaves) - 4.0).abs() < 1e-12);
        let before = leaves.len();
        cut(&mut leaves, 1, 0.25);
        assert!(leaves.len() > before && (area(&leaves) - 4.0).abs() < 1e-12);
        assert!(leaves.iter().all(|(_, b)| b[1].0 >= 0.25 || b[1].1 <= 0.25));
    }
}
