//! Condition numbers as far as they matter: mostly it is enough that one is larger than something.

use super::conditions::{Conditions, Differences, STEPS, Source, Spot};

/// The condition numbers at a point, computed when they are asked for.
pub struct Lazy<'a> {
    spot: Spot<'a>,
    /// In which order parameters are asked: those that mattered lately first.
    order: Vec<usize>,
    /// Whether differences in `f64` may tell enough.
    estimated: bool,
    estimates: Option<Grown<'a, 3>>,
    exact: Option<Grown<'a, 1>>,
}

/// How far estimates of a condition number may be apart, relative to them, to be believed within twice as much.
const AGREEMENT: f64 = 0.01;

/// How far they may be apart to be believed up to a factor of two: mostly much less is asked.
const ROUGHLY: f64 = 0.5;

impl<'a> Lazy<'a> {
    /// At a point; `estimated` if it is far enough from the ends of uniforms for differences in `f64`. `order` is
    /// what [`Lazy::order`] said last.
    pub fn new(spot: Spot<'a>, estimated: bool, mut order: Vec<usize>) -> Self {
        if order.len() != spot.numbers.len() {
            order = (0..spot.numbers.len()).collect();
        }
        Lazy { spot, order, estimated, estimates: None, exact: None }
    }

    /// The order in which to ask at the next point.
    pub fn order(self) -> Vec<usize> {
        self.order
    }

    /// All of them.
    pub fn all(&mut self) -> &Conditions {
        let spot = self.spot;
        let grown =
            self.exact.get_or_insert_with(|| Grown::new(spot, [Source::Exact], &self.order));
        grown.upto(grown.order.len());
        &grown.conditions[0]
    }

    /// Whether one of the condition numbers is no less than `limit`.
    pub fn exceeds(&mut self, limit: f64, which: impl Fn(&Conditions) -> f64) -> bool {
        self.beyond(limit, which) >= limit
    }

    /// One of the condition numbers; where it is plainly larger than `limit`, some number above that.
    pub fn beyond(&mut self, limit: f64, which: impl Fn(&Conditions) -> f64) -> f64 {
        let spot = self.spot;
        if self.estimated {
            let least = |conditions: &[Conditions; 3]| {
                let [a, b, c] = conditions.each_ref().map(&which);
                // Where moved uniforms have no sample there is no estimate.
                let near = |x: f64, y: f64, by: f64| x.is_finite() && (x - y).abs() <= by * x;
                let beyond = |x: f64, y: f64| {
                    let roughly = near(x, y, ROUGHLY) && near(y, x, ROUGHLY);
                    let least = if near(x, y, AGREEMENT) {
                        Some(x * (1.0 - 2.0 * AGREEMENT))
                    } else {
                        roughly.then(|| 0.5 * x.min(y))
                    };
                    least.filter(|least| *least > limit)
                };
                beyond(a, b).or_else(|| beyond(b, c))
            };
            let grown = self
                .estimates
                .get_or_insert_with(|| Grown::new(spot, STEPS.map(Source::Double), &self.order));
            if let Some(found) = grown.until(least, &mut self.order) {
                return found;
            }
        }
        let grown =
            self.exact.get_or_insert_with(|| Grown::new(spot, [Source::Exact], &self.order));
        let beyond = |[c]: &[Conditions; 1]| Some(which(c)).filter(|c| *c > limit);
        let found = grown.until(beyond, &mut self.order);
        found.unwrap_or_else(|| which(&grown.conditions[0]))
    }
}

/// Differences from several sources, and the condition numbers by the parameters asked so far.
struct Grown<'a, const N: usize> {
    differences: [Differences<'a>; N],
    conditions: [Conditions; N],
    order: Vec<usize>,
    asked: usize,
}

impl<'a, const N: usize> Grown<'a, N> {
    fn new(spot: Spot<'a>, sources: [Source; N], order: &[usize]) -> Self {
        let differences = sources.map(|source| Differences::new(spot, source));
        let conditions = differences.each_ref().map(Differences::conditions);
        Grown { differences, conditions, order: order.to_vec(), asked: 0 }
    }

    /// Asks so many of the parameters.
    fn upto(&mut self, asked: usize) {
        if asked > self.asked {
            for differences in &mut self.differences {
                self.order[self.asked..asked].iter().for_each(|j| differences.add(*j));
            }
            self.conditions = self.differences.each_ref().map(Differences::conditions);
            self.asked = asked;
        }
    }

    /// Asks twice as many parameters each time, until something is found; those asked last go to the front of `order`.
    fn until<T>(
        &mut self,
        found: impl Fn(&[Conditions; N]) -> Option<T>,
        order: &mut Vec<usize>,
    ) -> Option<T> {
        let mut before = self.asked;
        loop {
            if let Some(enough) = found(&self.conditions) {
                let leading = &self.order[before..self.asked];
                order.retain(|j| !leading.contains(j));
                order.splice(0..0, leading.iter().copied());
                return Some(enough);
            }
            before = self.asked;
            if before == self.order.len() {
                return None;
            }
            self.upto((2 * before).clamp(1, self.order.len()));
        }
    }
}
