//! Where samplers are tried: uniforms up to the last bit before an end, parameters over their domain.

use aether_core::Scalar;
use aether_core::legal::{Domain, ParameterKind};

use crate::registry::Item;

/// Uniforms of one dimension: zero, the neighbourhood of both ends, and the middle; `few` of them
/// where they are multiplied with something else.
fn along<R: Scalar>(few: usize) -> Vec<f64> {
    let bit = 0.5 * R::EPSILON.to_f64();
    let tiny = if bit < 1e-10 { 1e-300 } else { 1e-37 };
    let least = (R::MIN_POSITIVE * R::EPSILON).to_f64();
    let small = if bit < 1e-10 { 1e-9 } else { 1e-5 };
    let all = [
        0.3,
        1.0 - bit,
        tiny,
        1.0 - small,
        small,
        0.0,
        least,
        bit,
        0.5,
        0.75,
        1.0 - 2.0 * bit,
        1e-3,
        0.97,
        bit * bit,
        0.6,
    ];
    let all = all.iter().map(|u| R::of(*u).to_f64());
    all.take(few).collect()
}

/// All combinations of such uniforms in some dimensions; `dense` ones or few.
pub fn next_to_ends<R: Scalar>(dimensions: usize, dense: bool) -> Vec<Vec<f64>> {
    let few = match (dimensions, dense) {
        (1, _) => 15,
        (2, true) => 15,
        (2, false) => 7,
        (3, true) => 8,
        (4, true) => 5,
        _ => 4,
    };
    let line = along::<R>(few);
    let mut all = vec![vec![]];
    for _ in 0..dimensions {
        all = all
            .iter()
            .flat_map(|u: &Vec<f64>| line.iter().map(move |last| [&u[..], &[*last]].concat()))
            .collect();
    }
    all
}

/// A domain without an end is swept up to this power of ten.
const DECADES: i32 = 6;

/// Values of a parameter over its domain: powers of ten, and the ends approached by powers of ten.
pub fn over(domain: &Domain) -> Vec<f64> {
    let width = domain.high - domain.low;
    let mut values = vec![domain.low, domain.high, 0.0];
    for k in 0..=DECADES {
        let step = 10f64.powi(-k);
        values.extend([step, -step, 10f64.powi(k), -(10f64.powi(k))]);
        if width.is_finite() {
            values.extend([domain.low + 0.5 * width * step, domain.high - 0.5 * width * step]);
        } else if domain.low > 0.0 {
            values.push(domain.low / step);
        }
    }
    values.retain(|v| domain.contains(*v) && v.abs() <= 10f64.powi(DECADES));
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

/// Sets of parameters in which one at a time goes over its declared domain. Parameters without a domain
/// keep what the item is tried with.
pub fn swept(item: &Item) -> Vec<Vec<f64>> {
    let mut all = Vec::new();
    for set in item.sets.iter().take(3) {
        let mut first = 0;
        for parameter in item.parameters {
            let whole = parameter.kind == ParameterKind::Whole;
            let number = whole || parameter.kind == ParameterKind::Number;
            if let (true, Some(domain)) = (number, &parameter.domain) {
                for value in over(domain).into_iter().filter(|v| !whole || v.fract() == 0.0) {
                    let mut numbers = set.clone();
                    numbers[first] = value;
                    if !all.contains(&numbers) {
                        all.push(numbers);
                    }
                }
            }
            first += parameter.kind.numbers();
        }
    }
    all
}
