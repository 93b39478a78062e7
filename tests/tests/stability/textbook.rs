//! Each form beside the density that the forward map has, with 31 digits, so that cancellation costs nothing that
//! matters here, and beside the derived one.

use aether_core::{Pcg32, Real, Sampler, UniformSource, Uniforms};

use tests::points::FromCoordinates;
use tests::precise::Precise;
use tests::registry::{Item, Visitor, Which, items, rounded};
use tests::stability::exact;
use tests::textbook::textbook;

/// How many uniforms are drawn for each set of parameters.
const POINTS: usize = 100;
/// The largest relative error: some constants are printed with few digits.
const TOLERANCE: f64 = 1e-6;

/// Where a form has no value, with 31 digits either: it divides zero by zero, or infinity by infinity,
/// or by a probability below all numbers.
const UNDEFINED: [(Which, &[f64]); 4] = [
    (Which::LowerNormal, &[-40.0, -39.0]),
    (Which::TruncatedExponential, &[0.0, 2.0]),
    (Which::TruncatedExponential, &[1e-300, 1.0]),
    (Which::TruncatedExponential, &[-800.0, 1.0]),
];

/// Random uniforms, and the derived densities of their samples.
struct Derived(Pcg32);

impl Visitor<f64> for Derived {
    type Output = Vec<(Vec<Precise>, f64)>;

    fn visit<S: Sampler<f64>>(mut self, sampler: S) -> Self::Output
    where
        S::Point: FromCoordinates<f64>,
    {
        let mut point = || {
            let u = S::Uniforms::from_fn(|_| self.0.next());
            let precise = u.as_ref().iter().map(|u| Precise::f64(*u)).collect();
            (precise, sampler.sample(u).pdf().value())
        };
        (0..POINTS).map(|_| point()).collect()
    }
}

fn near(found: f64, expected: f64) -> bool {
    (found - expected).abs() <= TOLERANCE * expected
}

/// Compares the form of an item, if there is one, with its densities for these parameters, and adds where it differs.
fn compare(item: &Item, set: &[f64], wrong: &mut Vec<String>) -> Option<()> {
    let source = Pcg32::new(5, item.which as u64, 0);
    let points = item.visit::<f64, _>(set, Derived(source)).expect("legal parameters");
    let parameters: Vec<Precise> = rounded(item.parameters, set);
    let mut compared = 0;
    for (u, derived) in points {
        let Some(exact) = exact(item, set, &u) else { continue };
        let form = textbook(item.which, &parameters, &exact.x)?.to_f64();
        let known = exact.density.finite();
        let forward = exact.density.to_f64();
        if !near(form, derived) || known && !near(form, forward) {
            let x: Vec<f64> = exact.x.iter().map(|x| x.to_f64()).collect();
            wrong.push(format!("{} {set:?} at {x:?}: {form}, not {forward}, {derived}", item.name));
        }
        compared += usize::from(known);
    }
    assert!(compared >= POINTS / 4, "{} {set:?}: {compared} points", item.name);
    Some(())
}

#[test]
fn forms_are_the_densities_of_the_samplers() {
    let (mut wrong, mut none) = (Vec::new(), Vec::new());
    let items = items();
    for item in &items {
        let mut sets = item.sets.iter().filter(|set| !UNDEFINED.contains(&(item.which, set)));
        let first = sets.next().and_then(|set| compare(item, set, &mut wrong));
        if first.is_none() {
            none.push(item.name);
        }
        sets.for_each(|set| _ = compare(item, set, &mut wrong));
    }
    println!("{} of {} samplers have a textbook form", items.len() - none.len(), items.len());
    assert!(wrong.is_empty(), "{} points:\n{}", wrong.len(), wrong.join("\n"));
    let tables = ["film, Mitchell's filter", "film, Lanczos' filter", "environment map"];
    let tables = tables.map(|name| format!("renderer: {name}"));
    assert_eq!(none[..2], ["quintic", "planar_flow"]);
    assert_eq!(none[2..], tables);
}
