//! Any bit pattern as uniforms, parameters and query points: no density is NaN or negative, no preimage
//! leaves the unit cube, nothing panics; and no sample is NaN where parameters are those of the reference data, or
//! anywhere in their declared domains.

use core::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};

use aether_core::legal::{Parameter, ParameterKind};
use aether_core::uniform::clamped;
use aether_core::{Pcg32, Point, Sampler, Scalar, Uniforms};

use crate::points::FromCoordinates;
use crate::registry::{Item, Visitor};
use crate::stability::over;

/// A number from any bit pattern.
pub trait Bits: Scalar {
    /// The number with the low bits of these.
    fn of_bits(bits: u64) -> Self;
}
impl Bits for f32 {
    fn of_bits(bits: u64) -> f32 {
        f32::from_bits(bits as u32)
    }
}
impl Bits for f64 {
    fn of_bits(bits: u64) -> f64 {
        f64::from_bits(bits)
    }
}

/// What fuzzing found.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// How many samples, densities, logarithms of densities and inverses were computed.
    pub evaluations: u64,
    /// How often something went wrong.
    pub failures: u64,
    /// The first failure of each kind and item.
    pub examples: Vec<String>,
}

impl Outcome {
    fn fail(&mut self, kind: &str, at: impl FnOnce() -> String) {
        self.failures += 1;
        if !self.examples.iter().any(|e| e.starts_with(kind)) {
            self.examples.push(format!("{kind}: {}", at()));
        }
    }

    /// Adds what another run found.
    pub fn merge(&mut self, other: Outcome) {
        self.evaluations += other.evaluations;
        self.failures += other.failures;
        self.examples.extend(other.examples);
    }
}

/// A source of numbers that nobody expects.
struct Wild(Pcg32);

impl Wild {
    fn bits(&mut self) -> u64 {
        u64::from(self.0.next_u32()) << 32 | u64::from(self.0.next_u32())
    }

    fn below(&mut self, n: usize) -> usize {
        self.0.next_u32() as usize % n
    }

    /// Any bit pattern, a special value, a fraction, or a number of any size.
    fn number<R: Bits>(&mut self) -> R {
        let tiny = R::MIN_POSITIVE;
        let special = [
            R::ZERO,
            -R::ZERO,
            R::ONE,
            R::ONE.next_below(),
            R::INFINITY,
            -R::INFINITY,
            R::of(f64::NAN),
            tiny,
            tiny * R::EPSILON,
            tiny.recip(),
            R::of(0.5),
            -R::ONE,
        ];
        let fraction = (self.bits() >> 11) as f64 / (1u64 << 53) as f64;
        match self.below(4) {
            0 => R::of_bits(self.bits()),
            1 => special[self.below(special.len())],
            2 => R::of(fraction),
            _ => {
                let size = R::of((80.0 * fraction - 40.0).exp2());
                if self.below(2) == 0 { size } else { -size }
            }
        }
    }
}

/// Rounds that one sampler is tried before its parameters change.
const ROUNDS: u64 = 16;

/// Evaluates the items by turns until there are this many evaluations.
pub fn fuzz<R: Bits + fmt::Display>(items: &[Item], evaluations: u64, seed: u64) -> Outcome {
    let mut outcome = Outcome::default();
    let mut wild = Wild(Pcg32::new(seed, 0, 0));
    let declared: Vec<Vec<Vec<f64>>> = items.iter().map(domains).collect();
    while outcome.evaluations < evaluations {
        for (item, declared) in items.iter().zip(&declared) {
            let mut set = item.sets[wild.below(item.sets.len())].clone();
            if wild.below(2) == 0 {
                for (number, values) in set.iter_mut().zip(declared) {
                    if !values.is_empty() && wild.below(2) == 0 {
                        *number = values[wild.below(values.len())];
                    }
                }
            }
            let mut numbers = set.clone();
            match wild.below(4) {
                0 => numbers.iter_mut().for_each(|n| *n = wild.number::<R>().to_f64()),
                1 if !numbers.is_empty() => {
                    let i = wild.below(numbers.len());
                    numbers[i] = wild.number::<R>().to_f64();
                }
                _ => {}
            }
            // In `f32` some of them overflow or vanish.
            let held = |n: &f64| R::of(*n).finite() && (*n == 0.0 || R::of(*n) != R::ZERO);
            let ordinary = numbers == set && numbers.iter().all(held);
            let one =
                Try { outcome: &mut outcome, wild: &mut wild, item, numbers: &numbers, ordinary };
            // Parameters outside their domain are refused, which is right.
            let run = catch_unwind(AssertUnwindSafe(|| {
                let _ = item.visit::<R, _>(&numbers, one);
            }));
            if run.is_err() {
                outcome.fail(&format!("{}, panic", item.name), || format!("{numbers:?}"));
            }
        }
    }
    outcome
}

/// Samplers for which more has to hold of the parameters than can be declared, and nothing is sampled where it does not:
/// the cone that a sphere light is seen in must not be wider than the sphere.
const NARROWER: [&str; 1] = ["sphere_light"];

/// For each number among the parameters, values all over its declared domain, if there is one that tells all.
fn domains(item: &Item) -> Vec<Vec<f64>> {
    if NARROWER.contains(&item.name) {
        return vec![];
    }
    let values = |p: &Parameter| match (p.kind, &p.domain) {
        // A fraction is refused where whole numbers are meant.
        (ParameterKind::Number | ParameterKind::Whole, Some(domain)) => vec![over(domain)],
        _ => vec![vec![]; p.kind.numbers()],
    };
    item.parameters.iter().flat_map(values).collect()
}

struct Try<'a> {
    outcome: &'a mut Outcome,
    wild: &'a mut Wild,
    item: &'a Item,
    numbers: &'a [f64],
    /// Parameters of the reference data, or of their declared domains, for which there is a sample.
    ordinary: bool,
}

impl<R: Bits + fmt::Display> Visitor<R> for Try<'_> {
    type Output = ();

    fn visit<S: Sampler<R>>(self, sampler: S)
    where
        S::Point: FromCoordinates<R>,
    {
        for _ in 0..ROUNDS {
            let u = S::Uniforms::from_fn(|_| clamped(self.wild.number::<R>()));
            let sample = sampler.sample(u);
            let value = sample.value();
            let coordinates = value.coordinates();
            // Now and then a point next to a sample, else any.
            let near = self.wild.below(2) == 0;
            let moved: Vec<R> = coordinates
                .as_ref()
                .iter()
                .map(|c| if near && self.wild.below(3) > 0 { *c } else { self.wild.number::<R>() })
                .collect();
            let x = S::Point::made_of(&moved);
            let at = || format!("parameters {:?}, uniforms {u:?}, point {x:?}", self.numbers);
            let mut check = |kind: &str, fine: bool| {
                self.outcome.evaluations += 1;
                if !fine {
                    self.outcome.fail(&format!("{}, {kind}", self.item.name), at);
                }
            };
            let all = coordinates.as_ref().iter().all(|c| !c.to_f64().is_nan());
            check("sample", all || !sample.is_valid() || !self.ordinary);
            check("sample.pdf()", sample.pdf().value() >= R::ZERO);
            check("pdf(sample)", sampler.pdf(&sample).value() >= R::ZERO);
            check("pdf(x)", sampler.pdf(&x).value() >= R::ZERO);
            check("log_pdf(x)", sampler.log_pdf(&x) >= -R::INFINITY);
            let mut inside = true;
            sampler.preimages(&x, |u, exists| {
                let unit = |u: &R| (R::ZERO..R::ONE).contains(u);
                inside &= !exists || u.as_ref().iter().all(unit);
            });
            check("invert(x)", inside);
        }
    }
}
