//! Condition numbers as far as they matter: mostly it is enough that one is larger than something.

use super::conditions::{Conditions, Differences, STEPS, Source, Spot};

/// The condition numbers at a point, computed when they are asked for.
pub struct Lazy<'a> {
    spot: Spot<'a>,
    /// In which order parameters are asked: those that mattered lately first.
    order: Vec<usize>,
    /// Whether differences in `f64` may tell enough.
    estimated: bool,
    estimates: Option<Grown<'a, 2>>,
    /// Estimates in steps that are wider still, for where the others do not agree.
    wide: Option<Grown<'a, 1>>,
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
        Lazy { spot, order, estimated, estimates: None, wide: None, exact: None }
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
        if let Some(estimate) = self.estimate(limit, &which) {
            return estimate;
        }
        let spot = self.spot;
        let grown =
            self.exact.get_or_insert_with(|| Grown::new(spot, [Source::Exact], &self.order));
        let beyond = |[c]: &[Conditions; 1]| Some(which(c)).filter(|c| *c > limit);
        let found = grown.until(beyond, &mut self.order);
        found.unwrap_or_else(|| which(&grown.conditions[0]))
    }

    /// A number above `limit`, if differences in `f64` tell that one of the condition numbers is no less.
    fn estimate(&mut self, limit: f64, which: impl Fn(&Conditions) -> f64) -> Option<f64> {
        if !self.estimated {
            return None;
        }
        let spot = self.spot;
        let [fine, medium, coarse] = STEPS.map(Source::Double);
        // Where moved uniforms have no sample there is no estimate.
        let near = |x: f64, y: f64, by: f64| x.is_finite() && (x - y).abs() <= by * x;
        let least = |x: &Conditions, y: &Conditions| {
            let (x, y) = (which(x), which(y));
            let roughly = near(x, y, ROUGHLY) && near(y, x, ROUGHLY);
            let least = if near(x, y, AGREEMENT) {
                Some(x * (1.0 - 2.0 * AGREEMENT))
            } else {
                roughly.then(|| 0.5 * x.min(y))
            };
            least.filter(|least| *least > limit)
        };
        let made = || Grown::new(spot, [fine, medium], &self.order);
        let estimates = self.estimates.get_or_insert_with(made);
        let found = estimates.until(|[a, b]| least(a, b), &mut self.order);
        found.or_else(|| {
            let made = || Grown::new(spot, [coarse], &self.order);
            // Rarely asked, so that all parameters are, in any order.
            let wide = self.wide.get_or_insert_with(made);
            wide.upto(wide.order.len());
            least(&estimates.conditions[1], &wide.conditions[0])
        })
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
