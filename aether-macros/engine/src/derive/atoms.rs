//! The probabilities of atoms: the measure of the uniforms that lead to one.
//!
//! A way through a body that ends in an atom is taken where its tests hold. Each may look at one uniform, and is monotone in
//! it, so that it bounds it on one side: the bound is where the test is zero, solved for the uniform. What is left of every
//! uniform between its bounds multiplies up.

use proc_macro2::TokenStream;
use quote::ToTokens;

use super::Target;
use super::atom_bounds::{bounds, width};
use super::limits::parameters_with_limits;
use super::shares::Tried;
use crate::display::show;
use crate::eval::Evaluator;
use crate::expr::{Graph, Id, Leaf, UNKNOWNS, leaf_bit};
use crate::measure::{Inputs, Measure};
use crate::number::{Dd, Number};
use crate::parse::{AtomWay, Test, assume_nonnegative};
use crate::points::{Kind, Point, placed, sampler_points};
use crate::stabilise::stabilise;

/// Sets of parameters that a probability is compared with a count at.
const COUNTED: usize = 40;
/// Of some of them, those with parameters so much closer to their least values are added.
const SCALED: usize = 4;
const SCALES: [f64; 5] = [1e-1, 3e-2, 1e-2, 1e-3, 1e-4];
/// How far from a count, relative to it, a probability may be; the count itself leaves out what is nearer to an end than this.
const TOLERANCE: f64 = 1e-9;
const UNCOUNTED: f64 = 1e-17;

/// A way to an atom with its probability.
pub struct Atom {
    /// The way.
    pub way: AtomWay,
    /// The tests of the way that parameters alone decide: where one fails, the way is closed.
    pub open: Vec<Test>,
    /// The expressions of the probability.
    pub graph: Graph,
    /// The probability where the way is open.
    pub probability: Id,
    /// The scalar parameters that must not be exactly zero, because there is only a limit there.
    pub limits: Vec<u8>,
}

/// The probabilities of ways. The error is a text for the user, and what it is about.
pub fn atoms(ways: Vec<AtomWay>) -> Result<Vec<Atom>, (TokenStream, String)> {
    let mut atoms: Vec<Atom> = Vec::new();
    for way in ways {
        let tokens = way.tokens.to_token_stream();
        let atom = atom(way, &atoms).map_err(|message| (tokens, message))?;
        atoms.push(atom);
    }
    Ok(atoms)
}

fn atom(way: AtomWay, others: &[Atom]) -> Result<Atom, String> {
    let closed = |t: &&Test| way.graph.has(t.difference, UNKNOWNS);
    let open: Vec<Test> = way.tests.iter().filter(|t| !closed(t)).copied().collect();
    let points = points(&way, &open);
    if points.is_empty() {
        return Err("no parameters that were tried lead to this atom; declare their domains, as in `#[sampler(wall in 0.0..=10.0)]`, or leave the branch out if it is never taken".into());
    }
    on_the_sphere(&way, &points)?;
    for other in others.iter().filter(|other| other.way.number == way.number) {
        same_place(&way, &other.way, &other.open, &points)?;
    }
    let mut graph = afresh(&way, &open);
    let g = &mut graph;
    let mut measure = measured(&way, &points);
    let mut probability = g.int(1);
    let mut tested = open.len();
    for &u in &way.unknowns {
        let tests = of_uniform(&way, u);
        tested += tests.len();
        let bounds = bounds(g, (&way, &tests), u, &points)?;
        let width = width(g, &bounds, &mut measure);
        probability = g.mul(probability, width);
    }
    if tested < way.tests.len() {
        return Err(several_uniforms(&way));
    }
    probability = stabilise(g, probability, &mut measure);
    compare(&way, g, probability, &points)?;
    let limits = parameters_with_limits(g, &[probability], &measure);
    Ok(Atom { way, open, graph, probability, limits })
}

/// What must not be negative for a uniform to take the way.
fn of_uniform(way: &AtomWay, u: Leaf) -> Vec<Id> {
    let tests = way.tests.iter().map(|t| t.difference);
    tests.filter(|d| way.graph.deps(*d) & UNKNOWNS == leaf_bit(u)).collect()
}

/// The expressions of the parameters and uniforms, without what follows from the tests of the way: where a test holds is
/// what is asked.
fn afresh(way: &AtomWay, open: &[Test]) -> Graph {
    let from = &way.graph;
    let mut g = Graph::new();
    let parameters = way.kinds.iter().map(Kind::scalars).sum::<usize>();
    let parameters = (0..parameters).map(|i| Leaf::Param(i as u8));
    for leaf in way.unknowns.iter().copied().chain(parameters) {
        g.leaf(leaf, from.name(leaf), from.leaf_range(leaf));
    }
    for unit in from.units() {
        let unit = unit.map(|c| g.import(from, c));
        g.declare_unit(unit);
    }
    for test in way.relations.iter().chain(open) {
        let difference = g.import(from, test.difference);
        assume_nonnegative(&mut g, difference);
    }
    g
}

/// Points of different parameters with which the way is open.
fn points(way: &AtomWay, open: &[Test]) -> Vec<Point> {
    let accept = |point: &Point| holds(&way.graph, way.relations.iter().chain(open), point);
    let complete = |point: &mut Point| way.made.complete(&way.graph, point) && accept(point);
    let guarded = !way.relations.is_empty() || !open.is_empty() || !way.made.is_empty();
    let mut points = sampler_points(way.unknowns.len(), &way.kinds, guarded, &complete);
    let shown = |p: &Point| p.params.iter().map(|x| x.to_f64()).collect::<Vec<_>>();
    points.dedup_by(|a, b| shown(a) == shown(b));
    // In a wide domain most parameters leave an atom next to nothing, or all.
    let some = points.iter().filter(|p| !p.stress).take(SCALED).cloned().collect::<Vec<_>>();
    let scaled = SCALES.iter().flat_map(|&scale| some.iter().map(move |p| (p, scale)));
    let mut all: Vec<Point> = scaled.map(|(p, scale)| closer(p, &way.kinds, scale)).collect();
    all.retain_mut(complete);
    all.extend(points);
    all
}

/// The point with parameters closer to the least that they may be, or to zero.
fn closer(point: &Point, kinds: &[Kind], scale: f64) -> Point {
    let mut point = point.clone();
    for (kind, place) in placed(kinds) {
        if let Kind::Scalar(domain) = kind {
            let x = point.params[place.start].to_f64();
            let least = domain.map_or(0.0, |d| d.lo);
            let from = if least.is_finite() { least } else { 0.0 };
            let near = from + (x - from) * scale;
            let legal = domain.is_none_or(|d| d.lo <= near && near <= d.hi);
            point.params[place.start] = Dd::from_f64(if legal { near } else { x });
        }
    }
    point
}

fn holds<'t>(g: &Graph, tests: impl IntoIterator<Item = &'t Test>, point: &Point) -> bool {
    tests.into_iter().all(|t| {
        let difference = value(g, t.difference, point).to_f64();
        difference > 0.0 || !t.strict && difference >= 0.0
    })
}

pub(super) fn value(g: &Graph, id: Id, point: &Point) -> Dd {
    let at = |l: Leaf| point.input(l, &[]);
    Evaluator::<Dd>::new(g, &at).value(id)
}

/// Directions have unit length.
fn on_the_sphere(way: &AtomWay, points: &[Point]) -> Result<(), String> {
    let mut first = 0;
    for part in &way.parts {
        let coordinates = &way.place[first..first + part.coordinates];
        first += part.coordinates;
        for point in points.iter().filter(|p| !p.stress && part.target == Target::Direction) {
            let squares = coordinates.iter().map(|&c| value(&way.graph, c, point).to_f64());
            let length = squares.map(|c| c * c).sum::<f64>().sqrt();
            if (length - 1.0).abs() > 1e-12 {
                return Err(format!(
                    "the coordinates of this `Direction` have length {length:.6}; normalise them"
                ));
            }
        }
    }
    Ok(())
}

/// Two ways to one atom have to lead to one place.
fn same_place(
    way: &AtomWay,
    other: &AtomWay,
    open: &[Test],
    points: &[Point],
) -> Result<(), String> {
    for point in points.iter().filter(|p| !p.stress && holds(&other.graph, open, p)) {
        let place = |way: &AtomWay| {
            let coordinates = way.place.iter().map(|&c| value(&way.graph, c, point).to_f64());
            coordinates.collect::<Vec<f64>>()
        };
        let (here, there) = (place(way), place(other));
        let near = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-12 * (1.0 + a.abs());
        if !here.iter().zip(&there).all(near) {
            return Err(format!(
                "atom {} lies at {here:?} here and at {there:?} on another way: atoms are told apart by their numbers, so give each place a number of its own",
                way.number
            ));
        }
    }
    Ok(())
}

fn several_uniforms(way: &AtomWay) -> String {
    let g = &way.graph;
    let among = |d: Id| {
        let names = way.unknowns.iter().filter(|u| g.has(d, leaf_bit(**u)));
        names.map(|u| g.name(*u).to_owned()).collect::<Vec<_>>()
    };
    let all = way.tests.iter().map(|t| (show(g, t.difference), among(t.difference)));
    let (shown, names) = all.into_iter().find(|(_, names)| names.len() > 1).unwrap_or_default();
    format!(
        "the probability of this atom is the measure of the uniforms that lead here, and whether `{shown}` is positive depends on {} together, so that it is an integral without a formula. Let each comparison on the way to an atom look at one uniform, or let a `#[strategy]` choose between the point and the rest by a choice of its own",
        names.join(" and ")
    )
}

/// The parameters of points in both precisions.
fn measured(way: &AtomWay, points: &[Point]) -> Measure {
    let inputs = |point: &Point| -> Inputs {
        let parameters = point.params.iter().enumerate();
        parameters.map(|(i, x)| (Leaf::Param(i as u8), x.to_f64())).collect()
    };
    let single = |point: &Point| {
        let held = |x: &f64| (*x as f32).is_finite();
        let inputs = inputs(&point.in_single(&way.kinds, None)?);
        inputs.values().all(held).then(|| {
            inputs.into_iter().map(|(leaf, x)| (leaf, f64::from(x as f32))).collect::<Inputs>()
        })
    };
    Measure::new(points.iter().map(inputs).collect(), points.iter().filter_map(single).collect())
}

/// Compares a probability with the share of the uniforms that take the way.
fn compare(way: &AtomWay, g: &Graph, probability: Id, points: &[Point]) -> Result<(), String> {
    for point in points.iter().filter(|p| !p.stress).take(COUNTED) {
        let mut counted = 1.0;
        for &uniform in &way.unknowns {
            let tests = of_uniform(way, uniform);
            if !tests.is_empty() {
                counted *= Tried { graph: &way.graph, tests: &tests, uniform, point }.share();
            }
        }
        let at = |l: Leaf| point.input(l, &[]).to_f64();
        // As emitted code does.
        let derived = Evaluator::<f64>::new(g, &at).value(probability).clamp(0.0, 1.0);
        let agrees = (derived - counted).abs() <= TOLERANCE * counted + UNCOUNTED;
        if !agrees {
            let parameters: Vec<f64> = point.params.iter().map(|x| x.to_f64()).collect();
            return Err(format!(
                "the probability of this atom was derived as `{}`, which is {derived:e} with the parameters {parameters:?}, but {counted:e} of the uniforms lead here: declare the domains of the parameters more closely, or let a `#[strategy]` choose between the point and the rest",
                show(g, probability)
            ));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interpret::Item;
    use proc_macro2::TokenStream;

    /// What is wrong with a probability of the wall of free flight, by an expression of extinction and wall.
    fn judged(
        domains: TokenStream,
        probability: impl Fn(&mut Graph, [Id; 2]) -> Id,
    ) -> Result<(), String> {
        let flight = quote::quote!(
            fn flight(u: [Uniform; 1], extinction: f64, wall: f64) -> Mixed {
                let t = -(-u[0]).ln_1p() / extinction;
                if t < wall { Mixed::Continuous(t) } else { Mixed::Atom(0, wall) }
            }
        );
        let item = Item::new(domains, flight, true).expect("can be derived");
        let way = item.atoms.into_iter().next().expect("one way").way;
        let mut g = afresh(&way, &[]);
        let parameters = [0, 1].map(|i| g.get_leaf(Leaf::Param(i)));
        let probability = probability(&mut g, parameters);
        compare(&way, &g, probability, &points(&way, &[]))
    }

    #[test]
    fn a_wrong_probability_is_noticed() {
        use crate::expr::Fun;
        use crate::rational::Q;
        let depth = |g: &mut Graph, [s, d]: [Id; 2]| g.mul(s, d);
        let tail = |g: &mut Graph, parameters| {
            let depth = depth(g, parameters);
            let minus = g.neg(depth);
            g.call(Fun::Exp, &[minus])
        };
        let twice = |g: &mut Graph, parameters| {
            let tail = tail(g, parameters);
            g.powi(tail, 2)
        };
        let other_side = |g: &mut Graph, parameters| {
            let tail = tail(g, parameters);
            g.sum(Q::ONE, &[(Q::int(-1), tail)])
        };
        let nearly = |g: &mut Graph, parameters| {
            let tail = tail(g, parameters);
            g.sum(Q::ZERO, &[(Q::new(100_000_001, 100_000_000).expect("a fraction"), tail)])
        };
        let narrow = quote::quote!(extinction in 0.0..=3.0, wall in 0.0..=3.0);
        let wide = quote::quote!(extinction in 0.0..=1e4, wall in 0.0..=1e4);
        let open = quote::quote!(extinction in 0.0.., wall in 1e-9..);
        for domains in [narrow, wide, open] {
            assert_eq!(judged(domains.clone(), tail), Ok(()));
            let why = "of the uniforms lead here";
            assert!(judged(domains.clone(), other_side).is_err_and(|e| e.contains(why)));
            assert!(judged(domains.clone(), twice).is_err_and(|e| e.contains(why)));
            assert!(judged(domains, nearly).is_err_and(|e| e.contains(why)));
        }
    }
}
