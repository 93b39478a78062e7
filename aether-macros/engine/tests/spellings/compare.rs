//! Whether an item and another spelling of it are the same up to what the spelling changed.

use aether_engine::derive::{Problem, Target};
use aether_engine::eval::evaluate;
use aether_engine::expr::Leaf;
use aether_engine::interpret::Item;
use aether_engine::points::{Kind, Rng};

use crate::samplers::Spelling;

/// Points that are compared, each with parameters of its own.
const POINTS: usize = 20;
/// How many are drawn for them, where parameters have to have some relation.
const MOST: usize = 400;
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
    let found = (0..MOST).find_map(|_| {
        let p = parameters(&mut rng, problem);
        let u: Vec<f64> = problem
            .unknowns
            .iter()
            .map(|_| BORDER + (1.0 - 2.0 * BORDER) * rng.uniform())
            .collect();
        if compared == POINTS || !legal(plain, &p) {
            return None;
        }
        compared += usize::from(image(plain, &p, &u).is_some());
        at(plain, other, spelling, &p, &u).map(|what| format!("parameters {p:?}, u {u:?}: {what}"))
    });
    let few =
        || (compared < ENOUGH).then(|| format!("there are points at {compared} uniforms only"));
    found.or_else(few)
}

/// Whether parameters have the relations that are declared.
fn legal(item: &Item, p: &[f64]) -> bool {
    let problem = &item.parsed.pieces[0].problem;
    let at = |l: Leaf| if let Leaf::Param(i) = l { p[usize::from(i)] } else { f64::NAN };
    problem.relations.iter().all(|t| evaluate(&problem.graph, t.difference, &at) > 0.0)
}

/// A point with a preimage that does not lead back to it, if there is any: among images, images with other signs,
/// and points that other parameters have for images.
pub fn stray(item: &Item) -> Option<String> {
    let problem = &item.parsed.pieces[0].problem;
    let mut rng = Rng::new(0x0dd);
    let mut other: Option<Vec<f64>> = None;
    // Off a surface that only its identity tells there are no points.
    if problem.parts.iter().any(|p| p.target == Target::Identified) {
        return None;
    }
    for _ in 0..MOST {
        let p = parameters(&mut rng, problem);
        let u: Vec<f64> = problem.unknowns.iter().map(|_| rng.uniform()).collect();
        let Some(x) = image(item, &p, &u).filter(|_| legal(item, &p)) else { continue };
        let signs = |k: usize| move |i: usize| if k >> i & 1 == 1 { -1.0 } else { 1.0 };
        let reflected = (0..1 << x.len().min(3)).map(|k| {
            let sign = signs(k);
            x.iter().enumerate().map(|(i, x)| sign(i) * x).collect::<Vec<f64>>()
        });
        for y in reflected.chain(other.take()) {
            let size = y.iter().fold(1.0f64, |s, x| s.max(x.abs()));
            let leads_back = |v: &Vec<f64>| {
                // On a border rounding puts uniforms beyond their ends.
                let inside = v.iter().all(|v| (1e-6..1.0 - 1e-6).contains(v));
                !inside || image(item, &p, v).is_some_and(|z| near(&z, &y, 1e-6 * size))
            };
            if let Some(v) = item.preimages(&p, &y).into_iter().find(|v| !leads_back(v)) {
                return Some(format!("parameters {p:?}: {v:?} is no preimage of {y:?}"));
            }
        }
        other = Some(x);
    }
    None
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

/// The vector, as long as one.
fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    v.map(|x| x / length)
}

fn direction(rng: &mut Rng) -> [f64; 3] {
    unit(core::array::from_fn(|_| 2.0 * rng.uniform() - 1.0))
}

/// Moderate parameters. Numbers of the same domain ascend where no relations are declared: what is between them
/// should have a width.
fn parameters(rng: &mut Rng, problem: &Problem) -> Vec<f64> {
    let kinds = &problem.kinds;
    let mut drawn: Vec<Vec<f64>> = kinds
        .iter()
        .map(|kind| match kind {
            Kind::Whole(domain) => {
                vec![domain.lo + (rng.uniform() * (1.0 + domain.width().min(9.0))).floor()]
            }
            Kind::Scalar(domain) => {
                let (lo, hi) = domain.map_or((0.3, 3.3), |d| (d.lo.max(-3.0), d.hi.min(3.0)));
                vec![lo + (hi - lo) * (0.1 + 0.8 * rng.uniform())]
            }
            Kind::Vector(n) => (0..*n).map(|_| 4.0 * rng.uniform() - 2.0).collect(),
            Kind::Matrix => {
                let diagonal = |i: usize| if i.is_multiple_of(4) { 1.6 } else { 0.0 };
                (0..9).map(|i| rng.uniform() - 0.5 + diagonal(i)).collect()
            }
            Kind::Direction => direction(rng).to_vec(),
            Kind::Frame => {
                let ([a, b, c], [x, y, z]) = (direction(rng), direction(rng));
                let across = unit([b * z - c * y, c * x - a * z, a * y - b * x]);
                let [d, e, f] = across;
                let third = [b * f - c * e, c * d - a * f, a * e - b * d];
                [[a, b, c], across, third].concat()
            }
        })
        .collect();
    for (i, kind) in kinds.iter().enumerate().filter(|_| problem.relations.is_empty()) {
        for j in i + 1..kinds.len() {
            if matches!(kind, Kind::Scalar(_)) && kinds[j] == *kind && drawn[j] < drawn[i] {
                drawn.swap(i, j);
            }
        }
    }
    drawn.concat()
}
