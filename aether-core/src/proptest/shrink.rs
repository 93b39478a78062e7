//! From parameters for which a test fails to simpler ones.

use core::fmt;
use core::marker::PhantomData;

use ::proptest::strategy::ValueTree;

use super::draw::inside;
use crate::legal::{Domain, Legal, Parameter, ParameterKind};
use crate::real::Scalar;

/// Parameters of `S`, with simpler ones to try if a test fails.
///
/// One parameter after the other is replaced, the simplest candidate first, until one is found for
/// which the test still fails. Only legal parameters are tried.
pub struct Case<S: Legal> {
    /// The numbers of each parameter.
    groups: Vec<Vec<S::Real>>,
    /// Which parameter is being simplified.
    group: usize,
    /// What is left to try for it, the simplest at the end; at the front what it was. `None` before
    /// its turn.
    candidates: Option<Vec<Vec<S::Real>>>,
    item: PhantomData<fn() -> S>,
}

impl<S: Legal> Case<S> {
    pub(super) fn new(groups: Vec<Vec<S::Real>>) -> Self {
        Case { groups, group: 0, candidates: None, item: PhantomData }
    }

    /// The next candidate that is legal together with the other parameters.
    fn advance(&mut self) -> bool {
        while let Some(candidate) = self.candidates.as_mut().and_then(Vec::pop) {
            let before = core::mem::replace(&mut self.groups[self.group], candidate);
            if S::from_parameters(&self.current()).is_ok() {
                return true;
            }
            self.groups[self.group] = before;
        }
        false
    }
}

impl<S: Legal> fmt::Debug for Case<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let named = S::PARAMETERS.iter().map(|p| p.name).zip(&self.groups);
        f.debug_map().entries(named).finish()
    }
}

impl<S: Legal> ValueTree for Case<S> {
    type Value = Vec<S::Real>;

    fn current(&self) -> Vec<S::Real> {
        self.groups.concat()
    }

    /// The test failed: the parameter stays as it is, and the next one has its turn.
    fn simplify(&mut self) -> bool {
        if self.candidates.take().is_some() {
            self.group += 1;
        }
        while let Some(parameter) = S::PARAMETERS.get(self.group) {
            self.candidates = Some(simpler(parameter, &self.groups[self.group]));
            if self.advance() {
                return true;
            }
            self.group += 1;
        }
        self.candidates = None;
        false
    }

    /// The test passed: what was tried is too simple.
    fn complicate(&mut self) -> bool {
        self.advance()
    }
}

/// What to try instead of a parameter's numbers: the simplest last, the numbers themselves first.
/// Empty if nothing is simpler.
fn simpler<R: Scalar>(p: &Parameter, numbers: &[R]) -> Vec<Vec<R>> {
    let mut found: Vec<Vec<R>> = match p.kind {
        ParameterKind::Direction => {
            let (o, l) = (R::ZERO, R::ONE);
            vec![vec![o, o, l], vec![l, o, o], vec![o, l, o]]
        }
        ParameterKind::Frame => {
            let one_at = |i: usize| if i.is_multiple_of(4) { R::ONE } else { R::ZERO };
            vec![(0..9).map(one_at).collect()]
        }
        ParameterKind::SurfaceId => vec![vec![R::ZERO]],
        _ => {
            let whole = Domain { low: f64::NEG_INFINITY, high: f64::INFINITY, closed: false };
            let domain = p.domain.unwrap_or(whole);
            let rounded = |digits: i32| {
                numbers.iter().map(|x| inside(&domain, R::of(round(x.to_f64(), digits)))).collect()
            };
            let simplest = |x: &R| inside(&domain, R::of(simplest(&domain, x.to_f64())));
            let first: Vec<R> = numbers.iter().map(simplest).collect();
            vec![first, rounded(1), rounded(2), rounded(4)]
        }
    };
    // What comes before the numbers themselves is simpler than they are.
    let end = found.iter().position(|f| f[..] == *numbers).unwrap_or(found.len());
    found.truncate(end);
    if !found.is_empty() {
        found.push(numbers.to_vec());
        found.dedup();
        found.reverse();
    }
    found
}

/// One with the sign of `x`, one, zero, or the end of the domain that is next to zero.
fn simplest(domain: &Domain, x: f64) -> f64 {
    let candidates = [1f64.copysign(x), 1.0, 0.0, -1.0];
    let nearest = if domain.low > 0.0 { domain.low } else { domain.high };
    candidates.into_iter().find(|c| domain.contains(*c)).unwrap_or(nearest)
}

/// `x` rounded to some decimal digits.
fn round(x: f64, digits: i32) -> f64 {
    format!("{:.*e}", digits.unsigned_abs() as usize - 1, x).parse().unwrap_or(x)
}
