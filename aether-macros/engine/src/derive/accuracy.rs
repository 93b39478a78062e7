//! By how much what was derived is off in double precision inside of the domain, beyond what rounding its inputs costs.

use super::Problem;
use super::cases::{Case, inputs};
use super::occurring::recovers;
use crate::eval::{Evaluator, evaluate};
use crate::expr::{Graph, Id, Leaf, OUTS, leaf_bit};
use crate::measure::Inputs;
use crate::number::{Dd, Number};
use crate::solve::Solution;
use crate::sorted;

/// Errors below this are those of a few operations.
const GOOD: f64 = 64.0 * f64::EPSILON;
/// An error above this is half of the digits of a `f64`.
const HALF: f64 = 1.0 / (1 << 26) as f64;
/// How many times more than the rounding of its inputs an error is if it is one of the formula.
const EXCUSED: f64 = 4.0;

/// The largest error of something, and where it is.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Worst {
    /// The error; infinite where there is no number.
    pub error: f64,
    /// The inputs there, as text.
    pub at: String,
}

impl Worst {
    /// The larger of two.
    pub fn or(self, other: Worst) -> Worst {
        if other.error > self.error { other } else { self }
    }
}

/// As a number, and where it is unless it is small.
impl std::fmt::Display for Worst {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.error {
            error if error <= GOOD => write!(f, "{error:.1e}"),
            error if error.is_finite() => write!(f, "{error:.1e} at {}", self.at),
            _ => write!(f, "no number at {}", self.at),
        }
    }
}

/// The largest errors of what was derived.
#[derive(Clone, Debug, Default)]
pub struct Accuracy {
    /// Of the density of a point, relatively.
    pub density: Worst,
    /// Of the density of a sample by its uniforms, relatively.
    pub own: Worst,
    /// Of an unknown of a preimage.
    pub inverse: Worst,
}

impl Accuracy {
    /// The larger errors of two.
    pub fn or(self, other: &Accuracy) -> Accuracy {
        Accuracy {
            density: self.density.or(other.density.clone()),
            own: self.own.or(other.own.clone()),
            inverse: self.inverse.or(other.inverse.clone()),
        }
    }

    /// What to tell the user if more than half of the digits are lost somewhere inside of the domain.
    pub fn complaint(&self, name: &str, sampler: bool) -> Option<String> {
        let (density, own) = match sampler {
            true => ("the density of a point", "the density of a sample by its uniforms"),
            false => ("the change of measure in terms of the result", "the change of measure"),
        };
        let all = [(density, &self.density), (own, &self.own), ("the inverse", &self.inverse)];
        let bad = all.iter().filter(|(_, worst)| worst.error > HALF);
        let said: Vec<String> = bad.map(|(what, worst)| format!("{what}: {worst}")).collect();
        (!said.is_empty()).then(|| format!("what was derived from `{name}` loses more than half of its digits in places, and rounding what it is given is not the reason. Errors in `f64`: {}. Narrow the domains of the parameters, write differences of nearly equal numbers in another way, or compose it of samplers and maps that are accurate; `#[allow(deprecated)]` on the function silences this warning", said.join("; ")))
    }

    /// Takes a preimage into account: its density and its unknowns.
    pub(super) fn add(
        &mut self,
        problem: &Problem,
        s: &Solution,
        (density, unknowns): (Id, &[Id]),
        cases: &[Case],
    ) {
        let g = &problem.graph;
        let own: Vec<&Case> =
            cases.iter().filter(|c| c.is_plain() && recovers(problem, s, c)).collect();
        let at = |c: &Case| inputs(problem, c, false);
        let of_density = own.iter().filter(|c| c.volume > 0.0).map(|c| (at(c), 1.0 / c.volume));
        let found = worst(g, density, of_density.collect(), true);
        self.density = std::mem::take(&mut self.density).or(found);
        for (i, &unknown) in unknowns.iter().enumerate().filter(|(_, u)| g.has(**u, OUTS)) {
            let places = own.iter().map(|c| (at(c), c.point.unknowns[i].to_f64()));
            let found = worst(g, unknown, places.collect(), false);
            self.inverse = std::mem::take(&mut self.inverse).or(found);
        }
    }

    /// Takes the volume in terms of the unknowns into account.
    pub(super) fn add_own(&mut self, problem: &Problem, volume: Id, cases: &[Case]) {
        let plain = cases.iter().filter(|c| c.is_plain() && c.volume > 0.0);
        let places = plain.map(|c| (inputs(problem, c, true), c.volume)).collect();
        self.own = worst(&problem.graph, volume, places, true);
    }
}

/// The largest error of an expression among places with its true values there.
fn worst(g: &Graph, id: Id, places: Vec<(Inputs, f64)>, relative: bool) -> Worst {
    let error = |(inputs, truth): &(Inputs, f64)| {
        let value = evaluate::<f64>(g, id, &|leaf| input(inputs, leaf));
        let size = if relative { truth.abs() } else { 1.0 };
        let error = (value - truth).abs() / size;
        if error.is_nan() { f64::INFINITY } else { error }
    };
    let mut found: Vec<(f64, &Inputs)> = places.iter().map(|p| (error(p), &p.0)).collect();
    sorted::sort_by(&mut found, |a, b| b.0.total_cmp(&a.0));
    let own = |&&(error, inputs): &&(f64, &Inputs)| {
        error <= GOOD || error > EXCUSED * rounding(g, id, inputs, relative)
    };
    let Some(&(error, inputs)) = found.iter().find(own) else { return Worst::default() };
    let shown = depended(g, id, inputs).map(|l| format!("{} = {:.6e}", g.name(l), inputs[&l]));
    Worst { error, at: shown.collect::<Vec<_>>().join(", ") }
}

/// The inputs that an expression depends on, in order.
fn depended(g: &Graph, id: Id, inputs: &Inputs) -> impl Iterator<Item = Leaf> + use<> {
    let depends = |leaf: &Leaf| g.has(id, leaf_bit(*leaf));
    let mut leaves: Vec<Leaf> = inputs.keys().copied().filter(depends).collect();
    sorted::sort(&mut leaves);
    leaves.into_iter()
}

fn input(inputs: &Inputs, leaf: Leaf) -> f64 {
    inputs.get(&leaf).copied().unwrap_or(f64::NAN)
}

/// By how much an expression changes where its inputs are rounded, each by a unit in the last place; infinite where
/// that leads to no number.
fn rounding(g: &Graph, id: Id, inputs: &Inputs, relative: bool) -> f64 {
    let value = |moved: Option<(Leaf, f64)>| {
        let at = |leaf: Leaf| match moved {
            Some((l, x)) if l == leaf => Dd::from_f64(x),
            _ => Dd::from_f64(input(inputs, leaf)),
        };
        Evaluator::<Dd>::new(g, &at).value(id).to_f64()
    };
    let here = value(None);
    let changes = depended(g, id, inputs).map(|leaf| {
        let x = inputs[&leaf];
        let sides = [x.next_down(), x.next_up()].map(|x| (value(Some((leaf, x))) - here).abs());
        if sides.iter().any(|side| side.is_nan()) { f64::INFINITY } else { sides[0].max(sides[1]) }
    });
    let change: f64 = changes.sum();
    let size = if relative { here.abs() } else { 1.0 };
    if here.is_finite() { change / size } else { f64::INFINITY }
}
