//! Whether an item and another spelling of it are the same up to what the spelling changed.

use aether_engine::derive::Problem;
use aether_engine::eval::evaluate;
use aether_engine::expr::Leaf;
use aether_engine::interpret::Item;
use aether_engine::points::{Kind, Rng};

use crate::samplers::Spelling;

/// Points that are compared, each with parameters of its own.
const POINTS: usize = 20;
/// So many of them have to exist, where the map is not defined everywhere.
const ENOUGH: usize = 5;
/// Allowed difference of images, relative to their size.
const IMAGES: f64 = 1e-12;
/// Allowed relative difference of densities.
const DENSITIES: f64 = 1e-9;
/// Allowed difference of recovered uniforms.
const UNIFORMS: f64 = 1e-8;
/// How far from the ends uniforms are drawn.
const BORDER: f64 = 0.02;

/// The first difference between them, if there is any.
pub fn difference(plain: &Item, other: &Item, spelling: &Spelling) -> Option<String> {
    let problem = &plain.parsed.pieces[0].problem;
    let mut rng = Rng::new(0x5be1);
    let mut compared = 0;
    let found = (0..POINTS).find_map(|_| {
        let p = legal(&mut rng, problem);
        let u: Vec<f64> = problem
            .unknowns
            .iter()
            .map(|_| BORDER + (1.0 - 2.0 * BORDER) * rng.uniform())
            .collect();
        compared += usize::from(image(plain, &p, &u).is_some());
        at(plain, other, spelling, &p, &u).map(|what| format!("parameters {p:?}, u {u:?}: {what}"))
    });
    let few =
        || (compared < ENOUGH).then(|| format!("there are points at {compared} uniforms only"));
    found.or_else(few)
}

/// The image of uniforms: where a formula has no value there is no point.
fn image(item: &Item, p: &[f64], u: &[f64]) -> Option<Vec<f64>> {
    item.forward(p, u).filter(|x| !x.iter().any(|x| x.is_nan()))
}

fn at(plain: &Item, other: &Item, spelling: &Spelling, p: &[f64], u: &[f64]) -> Option<String> {
    let changed = |u: &[f64]| {
        let mut u = u.to_vec();
        (spelling.uniforms)(&mut u);
        u
    };
    let (x, y) = match (image(plain, p, u), image(other, p, &changed(u))) {
        (None, None) => return None,
        (Some(x), Some(y)) => (x, y),
        (x, y) => return Some(format!("the image is {y:?}, that of the original {x:?}")),
    };
    let image = spelling.image.apply(&x);
    let size = image.iter().fold(0.0f64, |s, x| s.max(x.abs()));
    if !near(&y, &image, IMAGES * size) {
        return Some(format!("the image is {y:?}, not {image:?}"));
    }
    let expected = plain.pdf(p, &x) / spelling.image.stretch;
    let found = other.pdf(p, &y);
    let same = (found - expected).abs() <= DENSITIES * expected;
    if expected <= 0.0 || !same {
        return Some(format!("the density at {y:?} is {found:e}, not {expected:e}"));
    }
    let expected: Vec<Vec<f64>> = plain.preimages(p, &x).iter().map(|u| changed(u)).collect();
    let found = other.preimages(p, &y);
    let known = |u: &Vec<f64>| expected.iter().any(|v| near(u, v, UNIFORMS));
    if found.len() != expected.len() || !found.iter().all(known) {
        return Some(format!("the preimages of {y:?} are {found:?}, not {expected:?}"));
    }
    None
}

fn near(a: &[f64], b: &[f64], tolerance: f64) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= tolerance)
}

/// Moderate parameters between which the declared relations hold. Numbers of the same domain ascend, or where
/// that never helps descend.
fn legal(rng: &mut Rng, problem: &Problem) -> Vec<f64> {
    let holds = |p: &[f64]| {
        let at = |leaf: Leaf| match leaf {
            Leaf::Param(i) => p[usize::from(i)],
            _ => f64::NAN,
        };
        problem.relations.iter().all(|t| evaluate(&problem.graph, t.difference, &at) > 0.0)
    };
    for attempt in 0..400 {
        let p = parameters(rng, &problem.kinds, attempt < 200);
        if holds(&p) {
            return p;
        }
    }
    panic!("no parameters between which the declared relations hold")
}

fn parameters(rng: &mut Rng, kinds: &[Kind], ascending: bool) -> Vec<f64> {
    let mut drawn: Vec<Vec<f64>> = kinds
        .iter()
        .map(|kind| match kind {
            Kind::Scalar(domain) => {
                let (lo, hi) = domain.map_or((0.3, 3.3), |d| (d.lo.max(-3.0), d.hi.min(3.0)));
                vec![lo + (hi - lo) * (0.1 + 0.8 * rng.uniform())]
            }
            Kind::Vector(n) => (0..*n).map(|_| 4.0 * rng.uniform() - 2.0).collect(),
            Kind::Matrix => {
                let diagonal = |i: usize| if i.is_multiple_of(4) { 1.6 } else { 0.0 };
                (0..9).map(|i| rng.uniform() - 0.5 + diagonal(i)).collect()
            }
            Kind::Direction => {
                let v: Vec<f64> = (0..3).map(|_| 2.0 * rng.uniform() - 1.0).collect();
                let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
                v.iter().map(|x| x / length).collect()
            }
            other => panic!("no rule to draw {other:?}"),
        })
        .collect();
    for (i, kind) in kinds.iter().enumerate() {
        for j in i + 1..kinds.len() {
            let swapped = matches!(kind, Kind::Scalar(_)) && kinds[j] == *kind;
            if swapped && (drawn[j] < drawn[i]) == ascending {
                drawn.swap(i, j);
            }
        }
    }
    drawn.concat()
}
