//! One sampler in one precision: all errors, and what must not occur.

use aether_core::support::rounded_end;
use aether_core::{Pcg32, Real, Scalar};

use super::conditions::Spot;
use super::few::Few;
use super::judge::{Judge, Origin};
use super::lazy::Lazy;
use super::oracle::{Format, exact};
use super::peers::{PeerPoint, peer_points};
use super::places::{next_to_ends, swept};
use super::probe::{Question, ask, dimensions, legal};
use super::random::{BY_HAND, against_double, below_one, draw};
use super::tally::Tally;
use crate::errors::errors;
use crate::precise::Precise;
use crate::reference::PointEntry;
use crate::registry::Item;

/// How much is tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Random samples in `f32`, against `f64`.
    pub single: u64,
    /// Random samples in `f64`, against 31 digits.
    pub double: u64,
    /// Whether parameters are swept over their domains.
    pub sweep: bool,
}

/// What was found.
#[derive(Clone, Debug, Default)]
pub struct Row {
    /// Name of the sampler.
    pub name: String,
    /// `f32` or `f64`.
    pub precision: &'static str,
    /// Errors of samples.
    pub sample: Tally,
    /// Errors of the inverse, of the worst uniform.
    pub inverse: Tally,
    /// Errors of `sampler.pdf(x)` at the exact sample, rounded.
    pub pdf: Tally,
    /// Errors of `sample.pdf()`.
    pub own: Tally,
    /// Errors of samples and densities at the extreme points of the reference data alone.
    pub extremes: Tally,
    /// Errors of the density as textbooks write it, at the same points.
    pub textbook: Tally,
    /// Errors of the density that Mitsuba 3 has, at the points of `mitsuba-warp.csv`.
    pub mitsuba: Tally,
    /// Errors of `sampler.pdf(x)` at the points of `mitsuba-warp.csv`.
    pub beside_mitsuba: Tally,
    /// Distance of the oracle from the reference data, at its extreme points.
    pub oracle: Tally,
    /// Own samples whose density came out as zero though rounding the point does not explain it.
    pub false_zeros: u64,
    /// Results that were NaN.
    pub nan: u64,
    /// Densities that came out infinite though they are not.
    pub infinite: u64,
    /// Own samples that were lost, or whose density came out as zero or infinity, where rounding a point that is so
    /// ill-conditioned explains it.
    pub excused: u64,
    /// Points at which errors are not known: the oracle has no sample there, or its digits do not tell the density, or the
    /// sample leaves the range of numbers.
    pub unjudged: u64,
    /// Points tried.
    pub samples: u64,
    /// Points left out, because the parameters rounded to the precision leave their domain.
    pub dropped: Vec<String>,
    /// The first false zero, NaN and infinity.
    pub examples: Vec<String>,
    /// In which order parameters are asked for condition numbers.
    pub(super) order: Vec<usize>,
}

impl Row {
    /// The worst error of samples and densities.
    pub fn worst(&self) -> f64 {
        [&self.sample, &self.pdf, &self.own].iter().fold(0.0, |m, t| m.max(t.worst))
    }

    /// The worst error of samples and densities over their condition numbers.
    pub fn worst_over(&self) -> f64 {
        [&self.sample, &self.pdf, &self.own].iter().fold(0.0, |m, t| m.max(t.worst_over))
    }

    /// Where [`Row::worst_over`] was.
    pub fn at(&self) -> String {
        let all = [("sample", &self.sample), ("pdf(x)", &self.pdf), ("sample.pdf()", &self.own)];
        let worst = all.iter().max_by(|a, b| a.1.worst_over.total_cmp(&b.1.worst_over));
        worst.map_or_else(String::new, |(name, t)| format!("{name} at {}", t.at))
    }

    pub(super) fn tallies(&self) -> [&Tally; 9] {
        let Row { sample, inverse, pdf, own, extremes, textbook, mitsuba, .. } = self;
        [sample, inverse, pdf, own, extremes, textbook, mitsuba, &self.beside_mitsuba, &self.oracle]
    }

    pub(super) fn tallies_mut(&mut self) -> [&mut Tally; 9] {
        let Row { sample, inverse, pdf, own, extremes, textbook, mitsuba, beside_mitsuba, .. } =
            self;
        let oracle = &mut self.oracle;
        [sample, inverse, pdf, own, extremes, textbook, mitsuba, beside_mitsuba, oracle]
    }

    /// A row without points for the same sampler, which looks only at what is worse than all in this one.
    fn onward(&self) -> Row {
        let mut row = Row { name: self.name.clone(), precision: self.precision, ..Row::default() };
        for (new, old) in row.tallies_mut().into_iter().zip(self.tallies()) {
            *new = old.onward();
        }
        row
    }

    /// Adds the points of another row of the same sampler.
    pub fn merge(&mut self, other: &Row) {
        for (all, new) in self.tallies_mut().into_iter().zip(other.tallies()) {
            all.merge(new);
        }
        self.false_zeros += other.false_zeros;
        self.nan += other.nan;
        self.infinite += other.infinite;
        self.excused += other.excused;
        self.unjudged += other.unjudged;
        self.samples += other.samples;
        for example in &other.examples {
            let what = example.split(" at ").next().unwrap_or_default();
            self.example(what, &|| example[what.len() + 4..].to_owned());
        }
    }

    /// Keeps the first of each.
    pub(super) fn example(&mut self, what: &str, at: &dyn Fn() -> String) {
        if !self.examples.iter().any(|e| e.starts_with(what)) {
            self.examples.push(format!("{what} at {}", at()));
        }
    }
}

/// A sampler in the precision `R` at all points that chance does not choose. `reference` are its entries in the
/// reference data that are meant for that precision.
pub fn chosen<R: Scalar>(item: &Item, reference: &[PointEntry], sweep: bool) -> Row {
    let format = Format::of::<R>();
    let double = is_double::<R>();
    let precision = if double { "f64" } else { "f32" };
    let mut row = Row { name: item.name.to_owned(), precision, ..Row::default() };
    for entry in reference {
        if double {
            extreme(&mut row, entry, &format);
            verify(&mut row, item, entry, &format);
        }
        let numbers = rounded::<R>(item, &entry.inputs.numbers());
        if !legal::<R>(item, &numbers, &mut row.dropped) {
            continue;
        }
        let u: Vec<f64> = entry.u.iter().map(|u| below_one::<R>(*u)).collect();
        // The reference data are for `f64`; in `f32` these points count as extreme by the oracle alone.
        let origin = if double { Origin::Swept } else { Origin::Extreme };
        one::<R>(&mut row, item, &numbers, &u, origin, true);
    }
    if !double {
        for point in peer_points(item.name) {
            peer::<R>(&mut row, item, &point, &format);
        }
    }
    let mut dropped = core::mem::take(&mut row.dropped);
    next_to_all_ends::<R>(item, sweep, &mut dropped, |numbers, u| {
        one::<R>(&mut row, item, numbers, u, Origin::Swept, true);
    });
    row.dropped = dropped;
    row
}

/// Calls `visit` with parameters and uniforms next to all ends: with the parameters that the item is tried with, and, if
/// they are to be swept, with others over their domains.
pub(super) fn next_to_all_ends<R: Scalar>(
    item: &Item,
    sweep: bool,
    dropped: &mut Vec<String>,
    mut visit: impl FnMut(&[f64], &[f64]),
) {
    let sets = sets::<R>(item, dropped);
    let Some(dimensions) = sets.first().and_then(|s| dimensions::<R>(item, s)) else { return };
    let mut each = |set: &[f64], dense: bool| {
        next_to_ends::<R>(dimensions, dense).iter().for_each(|u| visit(set, u));
    };
    sets.iter().for_each(|set| each(set, true));
    if sweep {
        let swept = swept(item).into_iter().map(|set| rounded::<R>(item, &set));
        let legal = swept.filter(|set| legal::<R>(item, set, &mut vec![]));
        legal.for_each(|set| each(&set, false));
    }
}

/// Some of its random points, to be merged with what was found at the chosen ones: those of the stream `part`, the
/// first of which has the number `first`.
pub fn random<R: Scalar>(item: &Item, chosen: &Row, part: u64, first: u64, count: u64) -> Row {
    let mut row = chosen.onward();
    let sets = sets::<R>(item, &mut vec![]);
    let Some(dimensions) = sets.first().and_then(|s| dimensions::<R>(item, s)) else { return row };
    let mut source = Pcg32::new(11, part, 0);
    if is_double::<R>() {
        for i in first..first + count {
            let u = draw::<R>(&mut source, dimensions);
            let by_hand = i < BY_HAND / 20;
            one::<R>(&mut row, item, &sets[i as usize % sets.len()], &u, Origin::Random, by_hand);
        }
    } else {
        against_double::<R>(&mut row, item, &sets, &mut source, dimensions, first..first + count);
    }
    row
}

fn is_double<R: Scalar>() -> bool {
    Format::of::<R>().spacing < 1e-10
}

/// Parameters as the item takes them: rounded to the precision, and an end of a domain that is rounded beyond itself as the
/// next number within.
fn rounded<R: Scalar>(item: &Item, x: &[f64]) -> Vec<f64> {
    let mut numbers: Vec<f64> = x.iter().map(|x| R::of(*x).to_f64()).collect();
    let mut place = 0;
    for parameter in item.parameters {
        let number = &mut numbers[place];
        place += parameter.kind.numbers();
        let Some(domain) = parameter.domain.filter(|domain| !domain.contains(*number)) else {
            continue;
        };
        let high = if domain.closed { domain.high } else { f64::NAN };
        if let Some(within) = rounded_end(R::of(*number), [domain.low, high]) {
            *number = within.to_f64();
        }
    }
    numbers
}

/// The parameters that the item is tried with, rounded to the precision, and without those that leave their domain.
fn sets<R: Scalar>(item: &Item, dropped: &mut Vec<String>) -> Vec<Vec<f64>> {
    let mut sets: Vec<Vec<f64>> = item.sets.iter().map(|s| rounded::<R>(item, s)).collect();
    sets.retain(|s| legal::<R>(item, s, dropped));
    sets
}

/// An extreme point of the reference data, against its values and condition numbers.
fn extreme(row: &mut Row, entry: &PointEntry, units: &Format) {
    let e = errors::<f64>(entry);
    let at = |what: &'static str| {
        move || format!("{what} at {:?} {:?}", entry.inputs.numbers(), entry.u)
    };
    row.extremes.add(units.units(e.sample), |_| entry.condition_sample, at("sample"));
    row.extremes.add(units.units(e.pdf), |_| entry.condition_pdf, at("pdf(x)"));
    row.extremes.add(units.units(e.own), |_| entry.condition_pdf, at("sample.pdf()"));
}

/// The oracle at an extreme point of the reference data, where that has a number.
fn verify(row: &mut Row, item: &Item, entry: &PointEntry, format: &Format) {
    let u: Vec<Precise> = entry.u.iter().map(|u| Precise::f64(*u)).collect();
    let Some(exact) = exact(item, &entry.inputs.numbers(), &u) else { return };
    let at = |what: &'static str| {
        move || format!("{what} at {:?} {:?}", entry.inputs.numbers(), entry.u)
    };
    if entry.condition_sample.is_finite() {
        row.oracle.add(format.vector(&entry.x, &exact.x), |_| 1.0, at("sample"));
    }
    if entry.condition_pdf.is_finite() && exact.density.finite() {
        row.oracle.add(format.density(entry.pdf, exact.density), |_| 1.0, at("density"));
    }
}

/// A point at which another renderer's density is known.
fn peer<R: Scalar>(row: &mut Row, item: &Item, point: &PeerPoint, format: &Format) {
    let u: Vec<Precise> = point.u.iter().map(|u| Precise::f64(*u)).collect();
    let Some(exact) = exact(item, &point.numbers, &u) else { return };
    let question = Question { u: Few::new(&point.u), x: Some(Few::new(&point.x)) };
    let answers = ask::<R>(item, &point.numbers, &[question]);
    let Some(found) = answers.first() else { return };
    let numbers = &point.numbers[..];
    let spot = Spot { item, numbers, u: &point.u, exact: &exact, format: *format };
    let condition = |_: f64| Lazy::new(spot, false, vec![]).all().density;
    let at = || format!("{:?} {:?}", point.numbers, point.u);
    row.mitsuba.add(format.density(point.density, exact.density), condition, at);
    let own = format.density(found.pdf.unwrap_or(f64::NAN), exact.density);
    row.beside_mitsuba.add(own, condition, at);
}

/// Uniforms against the oracle.
fn one<R: Scalar>(
    row: &mut Row,
    item: &Item,
    numbers: &[f64],
    u: &[f64],
    origin: Origin,
    by_hand: bool,
) {
    let judge = Judge::at::<R>(item, numbers, u, origin, by_hand);
    let question = judge.question::<R>();
    let found = ask::<R>(item, numbers, &[question]);
    found.iter().for_each(|found| judge.enter::<R>(row, found, &question.x.unwrap_or_default()));
}
