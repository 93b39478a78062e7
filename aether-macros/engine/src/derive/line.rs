//! Two points of one line, a + s h and a + t h, as the ends of a segment through an opening are: a depends on two
//! unknowns, the direction h on two others, and s and t on all, by the surfaces on which the points lie.
//!
//! *The inverse* needs to know nothing of the surfaces. The difference of both points is (s - t) h, and a lies on the line
//! through them. That they are on their surfaces is seen by mapping forward.
//!
//! *The change of measure.* The tangents of the surfaces are those of a and h, and multiples of h. Next to h itself, which
//! takes the place of the surfaces' normals m and n, such multiples say nothing, and the determinant of all six coordinates
//! falls apart into that of a and h, (s - t)², and that of h:
//!
//! |∂a × ∂a · h| (s - t)² |∂h × ∂h · h| / (|m · h| |n · h|).
//!
//! Gram's determinant of the four tangents is the same, but a difference of long sums.

use super::through::Named;
use super::{Problem, Target};
use crate::derivative::derivative;
use crate::expr::{Fun, Graph, Id, Leaf, leaf_bit};
use crate::interval::Interval;
use crate::jacobian::{self, Source, distinct, factor_out, moved, simplify, simplify_with, sphere};
use crate::matrix::{cross, dot};
use crate::rational::Q;
use crate::solve::{FIRST_OWN, System};
use crate::sorted;

/// Two points of one line, whose direction has unit length.
pub(super) struct Line {
    /// The direction.
    direction: [Id; 3],
    /// The same, or what a frame turns into it.
    unit: [Id; 3],
    /// The unknowns that the direction depends on, and the others.
    turning: Vec<Leaf>,
    moving: Vec<Leaf>,
    /// Where the line starts.
    start: [Id; 3],
    /// Names for the coordinates of the direction.
    names: [Id; 3],
    inputs: [Leaf; 3],
    /// How far from the start the points are, in terms of these names.
    places: [Id; 2],
}

/// The line of a sampler of two points of surfaces.
pub(super) fn line(problem: &mut Problem) -> Option<Line> {
    let is_surface = |(coordinates, dimension, target)| {
        (coordinates, dimension) == (3, 2) && target != Target::Direction
    };
    let mut parts = problem.parts.iter().map(|p| (p.coordinates, p.dimension, p.target));
    let both = problem.parts.len() == 2 && parts.all(is_surface);
    if problem.argument.is_some() || !both || problem.unknowns.len() != 4 {
        return None;
    }
    let (outputs, unknowns) = (problem.outputs.clone(), problem.unknowns.clone());
    let (g, frames) = (&mut problem.graph, &problem.frames);
    g.vectors().to_vec().into_iter().find_map(|h| {
        let in_h = |u: &&Leaf| h.iter().any(|&c| g.has(c, leaf_bit(**u)));
        let (turning, moving): (Vec<Leaf>, Vec<Leaf>) = unknowns.iter().partition(in_h);
        if turning.len() != 2 {
            return None;
        }
        let unit = unit_vector(g, h, frames)?;
        // Points may have their coordinates in another order.
        ORDERS.iter().find_map(|order| {
            let direction = order.map(|i| h[i]);
            with_direction(g, &outputs, (direction, unit), (&turning, &moving))
        })
    })
}

const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];

/// The line of both points, if it has this direction.
fn with_direction(
    g: &mut Graph,
    outputs: &[Id],
    (direction, unit): ([Id; 3], [Id; 3]),
    (turning, moving): (&[Leaf], &[Leaf]),
) -> Option<Line> {
    let own = turning.iter().fold(0, |bits, &u| bits | leaf_bit(u));
    let mut named = Named::new(g, direction, 4, own);
    let map: Vec<Id> = outputs.iter().map(|&x| named.of(g, x)).collect::<Option<_>>()?;
    let (names, inputs) = (named.leaves, named.inputs());
    let (first, start) = moved::along(g, &map[..3], names, inputs)?;
    let (second, same) = moved::along(g, &map[3..], names, inputs)?;
    let (turning, moving, places) = (turning.to_vec(), moving.to_vec(), [first, second]);
    let line = Line { direction, unit, turning, moving, start, names, inputs, places };
    (start == same).then_some(line)
}

/// The vector of unit length that this one is, or that a frame turns into it: both cover the same area.
fn unit_vector(g: &mut Graph, h: [Id; 3], frames: &[[[Id; 3]; 3]]) -> Option<[Id; 3]> {
    if sphere::is_unit(g, &h) {
        return Some(h);
    }
    let vectors = g.vectors().to_vec();
    vectors.into_iter().find(|v| {
        let mut turned = |f: &[[Id; 3]; 3]| {
            let into = [0, 1, 2].map(|i| dot(g, &[f[0][i], f[1][i], f[2][i]], v));
            let back = f.map(|column| dot(g, &column, v));
            [into, back].contains(&h)
        };
        frames.iter().any(&mut turned) && sphere::is_unit(g, v)
    })
}

impl Line {
    /// An expression with the direction in place of its names.
    fn spelled_out(&self, g: &mut Graph, id: Id) -> Id {
        let names = sorted::map(self.names.into_iter().zip(self.direction));
        g.substitute(id, &names)
    }

    /// The equations that do not mention the surfaces: with the points X and Y, X - Y = λ h and X = a + ρ (X - Y).
    pub(super) fn system(&self, g: &mut Graph, points: &[Id], positive: &[Id]) -> System {
        let [s, t] = self.places.map(|place| self.spelled_out(g, place));
        let apart = g.sub(s, t);
        let behind = g.neg(t);
        let known_positive = |id: Id| g.range(id).nonnegative() || positive.contains(&id);
        let forward = known_positive(apart) || known_positive(s) && known_positive(behind);
        let range = if forward { Interval::POSITIVE } else { Interval::ALL };
        let lambda = g.leaf(Leaf::Unknown(FIRST_OWN), "λ", range);
        let rho = g.leaf(Leaf::Unknown(FIRST_OWN + 1), "ρ", Interval::ALL);
        let minus = g.int(-1);
        let less = g.add(rho, minus);
        let places = [rho, less].map(|part| g.mul(part, lambda));
        let mut system = System { own: 2, ..System::default() };
        for (known, value) in [(apart, lambda), (s, places[0]), (t, places[1])] {
            // The distance of a point behind the start is -t.
            let (coefficient, size) = g.split(known);
            let coefficient = g.number(coefficient);
            system.told.push((size, g.div(value, coefficient)));
        }
        for i in 0..3 {
            let (first, h) = (points[i], self.direction[i]);
            let edge = g.sub(first, points[i + 3]);
            let turned = g.mul(lambda, h);
            let along = g.mul(rho, edge);
            let moved = g.add(self.start[i], along);
            system.equations.extend([(edge, turned), (first, moved)]);
            system.told.push((h, g.div(edge, lambda)));
        }
        system
    }

    /// Equal expressions for the volume that the unknowns span.
    pub(super) fn volume(&self, g: &mut Graph) -> Result<Vec<Id>, String> {
        let spread = match sphere::area(g, &self.unit, &self.turning) {
            Some(forms) => forms,
            None => {
                let source = (Source::Free, true);
                jacobian::volume(g, &self.unit, &self.turning, source, &[])?
            }
        };
        let [along, across] =
            [0, 1].map(|i| self.start.map(|c| derivative(g, c, self.moving[i])).to_vec());
        let normal: Vec<Id> =
            cross(g, &along, &across).into_iter().map(|c| simplify(g, c, None)).collect();
        let seen = dot(g, &normal, &self.names);
        let seen = factor_out(g, seen);
        let seen = g.call(Fun::Abs, &[seen]);
        let [s, t] = self.places;
        let apart = g.sub(s, t);
        let squared = g.powi(apart, 2);
        let [m, n] = self.places.map(|place| self.one_over_cosine(g, place));
        let others = [squared, m, n].into_iter().fold(seen, |product, f| g.mul(product, f));
        let others = self.spelled_out(g, others);
        Ok(distinct(spread.iter().map(|&s| g.mul(s, others)).collect()))
    }

    /// One over the cosine between the line and the normal of the surface that it meets at this distance s. The tangents are
    /// s δh + (∇s · δh) h, so that the normal has the direction of ∇s - s h, ∇s being the gradient on the sphere. As a rule s
    /// is a length over that of h, and ∇s without the sphere is all of that.
    fn one_over_cosine(&self, g: &mut Graph, place: Id) -> Id {
        let slope: Vec<Id> = self
            .inputs
            .iter()
            .map(|&l| {
                let slope = derivative(g, place, l);
                factor_out(g, slope)
            })
            .collect();
        let outwards = dot(g, &slope, &self.names);
        let sum = g.add(outwards, place);
        let rest = simplify(g, sum, None);
        let (slope, place) = (dot(g, &slope, &slope), g.powi(place, 2));
        let normal = if g.as_number(rest).is_some_and(Q::is_zero) {
            factor_out(g, slope)
        } else {
            let outwards = g.powi(outwards, 2);
            let terms = [(Q::ONE, slope), (Q::int(-1), outwards), (Q::ONE, place)];
            let squared = g.sum(Q::ZERO, &terms);
            simplify_with(g, squared, &[self.names])
        };
        let squared = g.div(normal, place);
        g.sqrt(squared)
    }
}

#[cfg(test)]
mod tests {
    use crate::interpret::Item;

    type Vector = [f64; 3];

    fn minus(a: Vector, b: Vector) -> Vector {
        [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
    }

    fn dot(a: Vector, b: Vector) -> f64 {
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    }

    /// The geometry term of a segment between points with these normals, over the cosine at the opening.
    fn geometry([y, z]: [Vector; 2], normals: [Vector; 2], opening: Vector) -> f64 {
        let edge = minus(y, z);
        let length = dot(edge, edge).sqrt();
        let cosine = |n: Vector| (dot(n, edge) / length / dot(n, n).sqrt()).abs();
        cosine(normals[0]) * cosine(normals[1]) / cosine(opening) / (length * length)
    }

    fn points(x: &[f64]) -> [Vector; 2] {
        [[x[0], x[1], x[2]], [x[3], x[4], x[5]]]
    }

    /// A triangle with corners (0, 0, 0), (2, 0, 0) and (0, 1, 0), and directions that are uniform about +z.
    const OPENING: &str = "
        let s = u[0].sqrt();
        let x = Vec3::new(2.0 * (1.0 - s), s * u[1], 0.0);
        let r = (1.0 - u[2] * u[2]).sqrt();
        let phi = TAU * u[3];
        let w = Vec3::new(r * phi.cos(), r * phi.sin(), u[2]);";

    fn item(domain: &str, parameters: &str, rest: &str) -> Item {
        let text = format!(
            "fn segment(u: [Uniform; 4], {parameters}) -> (Surface, Surface) {{ {OPENING} {rest}
                require(above > 0.0 && below > 0.0);
                (Surface::from_vec(x + above * w), Surface::from_vec(x - below * w))
            }}"
        );
        Item::new(domain.parse().unwrap(), text.parse().unwrap(), true).unwrap()
    }

    #[test]
    fn segments_between_tilted_planes() {
        let planes = item(
            "",
            "p: Vec3, n: Direction, q: Vec3, m: Direction",
            "let above = n.dot(p - x) / n.dot(w);
             let below = m.dot(x - q) / m.dot(w);",
        );
        let (n, m) = ([0.48, -0.64, 0.6], [0.0, 0.6, 0.8]);
        let parameters = [&[0.5, 0.25, 3.0], &n[..], &[1.0, -0.5, -2.0], &m].concat();
        for u in [[0.3, 0.6, 0.9, 0.2], [0.9, 0.1, 0.7, 0.6], [0.01, 0.99, 0.8, 0.95]] {
            let x = planes.forward(&parameters, &u).unwrap();
            // One over the area of the triangle, and over the solid angle of the hemisphere.
            let shared = geometry(points(&x), [n, m], [0.0, 0.0, 1.0]);
            let expected = shared / std::f64::consts::TAU;
            let found = planes.pdf(&parameters, &x);
            assert!((found / expected - 1.0).abs() < 1e-13, "{u:?}: {found} and {expected}");
        }
        // A line that passes the opening, and one between points that are off their planes.
        let x = planes.forward(&parameters, &[0.3, 0.6, 0.9, 0.2]).unwrap();
        let moved = |by: Vector| -> Vec<f64> { (0..6).map(|i| x[i] + by[i % 3]).collect() };
        assert!(planes.pdf(&parameters, &moved([0.0; 3])) > 0.0);
        assert_eq!(planes.pdf(&parameters, &moved([0.0, 0.0, 0.1])), 0.0);
        let along = [0.64, 0.48, 0.0];
        let beside: Vec<f64> =
            (0..6).map(|i| if i < 3 { x[i] + 9.0 * along[i] } else { x[i] }).collect();
        assert_eq!(planes.pdf(&parameters, &beside), 0.0);
    }

    #[test]
    fn segments_to_a_sphere_whose_distance_is_written_for_unit_vectors() {
        let ball = item(
            "h in 0.0..=1.0, radius in 4.0..=10.0",
            "h: f64, radius: f64",
            "let above = (3.0 - x.z + 0.25 * x.x) / (w.z - 0.25 * w.x);
             let off = x + Vec3::new(0.0, 0.0, h);
             let along = w.dot(off);
             let below = along + (along * along - off.dot(off) + radius * radius).sqrt();",
        );
        let parameters = [0.75, 4.5];
        for u in [[0.3, 0.6, 0.95, 0.2], [0.9, 0.1, 0.5, 0.6], [0.01, 0.99, 0.6, 0.95]] {
            let x = ball.forward(&parameters, &u).unwrap();
            let [y, z] = points(&x);
            let normals = [[-0.25, 0.0, 1.0], minus(z, [0.0, 0.0, -0.75])];
            let shared = geometry([y, z], normals, [0.0, 0.0, 1.0]);
            let expected = shared / std::f64::consts::TAU;
            let found = ball.pdf(&parameters, &x);
            assert!((found / expected - 1.0).abs() < 1e-12, "{u:?}: {found} and {expected}");
        }
    }
}
