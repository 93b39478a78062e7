//! The battery of strategies: right ones pass, and whatever is wrong with one is found.

use aether_core::battery::{StrategyBattery, Verdict};
use aether_core::prelude::*;
use aether_core::strategy::{Conditional, Dirac, Drawn, Recall, Strategy, Vertex};
use aether_core::{PathView, UniformSource, shares};

/// A point of the line, or a lamp with a number.
#[derive(Clone, Copy, Debug)]
struct Spot {
    x: f64,
    lamp: Option<u32>,
}

impl Spot {
    fn at(x: f64) -> Spot {
        Spot { x, lamp: None }
    }
    fn lamp(number: u32) -> Spot {
        Spot { x: f64::from(number), lamp: Some(number) }
    }
}

impl Vertex for Spot {
    type Real = f64;
    type Point = f64;
    fn point(&self) -> f64 {
        self.x
    }
}

impl Recall<u32> for Spot {
    fn recall(&self) -> Option<u32> {
        self.lamp
    }
}

/// Uniform on [a, a + length).
#[sampler(length in 1e-3..=1e3)]
fn interval(u: [Uniform; 1], a: f64, length: f64) -> f64 {
    a + length * u[0]
}

/// Density 2 (x - a) on [a, a + 1).
#[sampler]
fn ramp(u: [Uniform; 1], a: f64) -> f64 {
    a + u[0].sqrt()
}

#[strategy]
fn anywhere(path: &PathView<Spot>) -> Spot {
    let x = draw(interval(-2.0, 6.0).expect("a length"));
    Spot::at(x)
}

/// Lamps 1 and 2, a ramp, something else near it, or nothing.
#[strategy]
fn mixed(path: &PathView<Spot>, weights: [f64; 5]) -> Spot {
    let here = given(path.last());
    let way = choose(shares(weights)).identified_by(|v: &Spot| match v.lamp {
        Some(number) => vec![number as usize],
        None => vec![0, 3],
    });
    match way {
        0 => {
            let x = draw(ramp(here.x));
            Spot::at(x)
        }
        1 => {
            let lamp = constant(Some(1));
            Spot::lamp(lamp)
        }
        2 => {
            let lamp = constant(Some(2));
            Spot::lamp(lamp)
        }
        3 => {
            let x = draw(interval(here.x - 0.5, 1.0).expect("a length"));
            Spot::at(x)
        }
        _ => stop(),
    }
}

/// What is wrong with a strategy.
#[derive(Clone, Copy)]
enum Wrong {
    Nothing,
    /// Its vertices are not where its density has them.
    Moved(f64),
    /// Densities are too large by this factor, and what is told of them too, so that only samples show it.
    Scaled(f64),
    /// What is told alone.
    Told(f64),
    /// The probability of a lamp.
    Lamp(f64),
    /// There is no density beyond this.
    Cut(f64),
}

#[derive(Clone)]
struct Off<S>(S, Wrong);

impl<S: Strategy<Spot>> Strategy<Spot> for Off<S> {
    fn sample<U: UniformSource<f64> + ?Sized>(
        &self,
        path: PathView<'_, Spot>,
        uniforms: &mut U,
    ) -> Option<Drawn<Spot>> {
        let mut drawn = self.0.sample(path, uniforms)?;
        match self.1 {
            Wrong::Moved(by) if drawn.dirac.is_none() => drawn.vertex.x += by,
            Wrong::Scaled(by) | Wrong::Told(by) => drawn.value = drawn.value.map(|p| p * by),
            _ => {}
        }
        if !matches!(self.1, Wrong::Nothing | Wrong::Scaled(_) | Wrong::Told(_)) {
            drawn.value = None;
        }
        Some(drawn)
    }
    fn pdf(&self, path: PathView<'_, Spot>, target: &Spot) -> Conditional<f64> {
        let pdf = self.0.pdf(path, target);
        let factor = match (self.1, pdf.dirac) {
            (Wrong::Scaled(by), _) => by,
            (Wrong::Lamp(by), Some(Dirac::Position)) => by,
            (Wrong::Cut(at), None) if target.x > at => 0.0,
            _ => 1.0,
        };
        Conditional { value: pdf.value * factor, ..pdf }
    }
}

/// The checks that fail.
fn failing(weights: [f64; 5], wrong: Wrong) -> Vec<&'static str> {
    let start = [Spot::at(0.25)];
    let strategy = Off(mixed(weights), wrong);
    let report = StrategyBattery::new(strategy, anywhere(), PathView::from_slice(&start))
        .run(|vertex| [vertex.x]);
    report.failures().map(|finding| finding.check).collect()
}

const WEIGHTS: [f64; 5] = [4.0, 1.0, 2.0, 3.0, 2.0];

#[test]
fn right_strategies_pass() {
    assert_eq!(failing(WEIGHTS, Wrong::Nothing), [""; 0]);
    // Without a lamp, without anything else, and without what ends.
    for weights in [[1.0, 0.0, 0.0, 1.0, 0.0], [0.0, 1.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0, 0.0]]
    {
        assert_eq!(failing(weights, Wrong::Nothing), [""; 0], "{weights:?}");
    }
}

#[test]
fn whatever_is_wrong_is_found() {
    // Six percent of the mass are eight standard errors here, mostly of the reference, which reaches four times as far.
    assert_eq!(failing(WEIGHTS, Wrong::Scaled(1.06)), ["mass", "chi-square", "atoms"]);
    // Two samples in a hundred come to lie beyond the end of the support.
    assert_eq!(failing(WEIGHTS, Wrong::Moved(0.02)), ["support", "chi-square"]);
    assert_eq!(failing(WEIGHTS, Wrong::Told(1.001)), ["own density"]);
    assert_eq!(failing(WEIGHTS, Wrong::Lamp(1.05)), ["atoms"]);
    assert_eq!(failing(WEIGHTS, Wrong::Cut(1.0)), ["support", "mass", "chi-square"]);
}

#[test]
fn a_point_that_a_function_has_moved_is_found() {
    fn twice(x: f64) -> f64 {
        2.0 * x
    }
    #[strategy]
    fn moved(path: &PathView<Spot>) -> Spot {
        let x = draw(ramp(0.0));
        Spot::at(twice(x))
    }
    let report = StrategyBattery::new(moved(), anywhere(), PathView::from_slice(&[]))
        .run(|vertex| [vertex.x]);
    assert!(report.failures().any(|finding| finding.check == "chi-square"), "{report}");
}

#[test]
fn a_reference_that_does_not_reach_everything_decides_nothing() {
    #[strategy]
    fn nearby(path: &PathView<Spot>) -> Spot {
        let x = draw(interval(0.5, 0.1).expect("a length"));
        Spot::at(x)
    }
    let battery = StrategyBattery::new(anywhere(), nearby(), PathView::from_slice(&[]));
    assert!(!battery.samples(2000).run(|vertex| [vertex.x]).is_ok());
    let battery = StrategyBattery::new(anywhere(), anywhere(), PathView::from_slice(&[]));
    let report = battery.seed(7).samples(5000).false_alarm_rate(1e-9).run(|vertex| [vertex.x]);
    let last = report.findings().last().map(|finding| finding.verdict);
    assert!(report.is_ok() && last == Some(Verdict::NotApplicable), "{report}");
}
