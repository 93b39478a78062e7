//! One sampler in one precision: all errors, and what must not occur.

use aether_core::{Pcg32, Point, Real, Sampler, Scalar, UniformSource, Uniforms};

use super::oracle::{Conditions, Exact, Format, conditions, exact};
use super::peers::{PeerPoint, peer_points};
use super::places::{next_to_ends, swept};
use super::tally::Tally;
use crate::errors::errors;
use crate::points::FromCoordinates;
use crate::precise::Precise;
use crate::reference::PointEntry;
use crate::registry::{Item, Visitor};
use crate::textbook::textbook;

/// How much is tried.
#[derive(Clone, Copy, Debug)]
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
    /// Points tried.
    pub samples: u64,
    /// Points left out, because the parameters rounded to the precision leave their domain.
    pub dropped: Vec<String>,
    /// The first false zero, NaN and infinity.
    pub examples: Vec<String>,
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

    fn example(&mut self, what: &str, at: &dyn Fn() -> String) {
        if !self.examples.iter().any(|e| e.starts_with(what)) {
            self.examples.push(format!("{what} at {}", at()));
        }
    }
}

/// What a sampler says of uniforms `u` and of a point `x`.
struct Probe<'a> {
    u: &'a [f64],
    x: &'a [f64],
}

struct Found {
    sample: Vec<f64>,
    valid: bool,
    own: f64,
    at_own: f64,
    pdf: Option<f64>,
    back: Vec<Vec<f64>>,
}

fn plain<R: Scalar>(x: &[R]) -> Vec<f64> {
    x.iter().map(|x| x.to_f64()).collect()
}

impl<R: Scalar> Visitor<R> for Probe<'_> {
    type Output = Found;

    fn visit<S: Sampler<R>>(self, sampler: S) -> Found
    where
        S::Point: FromCoordinates<R>,
    {
        let sample = sampler.sample(S::Uniforms::from_fn(|i| R::of(self.u[i])));
        let mut found = Found {
            sample: plain(sample.coordinates().as_ref()),
            valid: sample.is_valid(),
            own: sample.pdf().value().to_f64(),
            at_own: sampler.pdf(&sample).value().to_f64(),
            pdf: None,
            back: vec![],
        };
        let x: Vec<R> = self.x.iter().map(|x| R::of(*x)).collect();
        if let Some(x) = (!x.is_empty()).then(|| S::Point::from_coordinates(&x)).flatten() {
            found.pdf = Some(sampler.pdf(&x).value().to_f64());
            sampler.preimages(&x, |u, exists| {
                if exists {
                    found.back.push(plain(u.as_ref()));
                }
            });
        }
        found
    }
}

impl Format {
    fn of<R: Scalar>() -> Self {
        let floor = R::MIN_POSITIVE.to_f64();
        let double = floor < 1e-300;
        let ceiling = if double { f64::MAX } else { f64::from(f32::MAX) };
        Format { spacing: R::EPSILON.to_f64(), floor, ceiling }
    }

    /// A relative error in units; one that is as large as the value counts as that.
    fn units(&self, relative: f64) -> f64 {
        if relative.is_nan() { 1.0 / self.spacing } else { relative.min(1.0) / self.spacing }
    }

    /// The error of a density.
    fn density(&self, found: f64, exact: Precise) -> f64 {
        let expected = exact.to_f64();
        if found == f64::INFINITY && expected >= self.ceiling || found == expected {
            return 0.0;
        }
        let gap = (Precise::f64(found) - exact).abs().to_f64();
        self.units(gap / expected.max(self.floor))
    }

    /// The error of a vector.
    fn vector(&self, found: &[f64], exact: &[Precise]) -> f64 {
        let gaps = found.iter().zip(exact).map(|(a, b)| (Precise::f64(*a) - *b).to_f64());
        let size = exact.iter().fold(0.0, |s: f64, x| s.hypot(x.to_f64()));
        let gap = gaps.fold(0.0, |s: f64, g| s.hypot(g));
        if gap == 0.0 { 0.0 } else { self.units(gap / size.max(self.floor)) }
    }
}

/// Everything about a sampler in the precision `R`. `reference` are its entries in the reference data
/// that are meant for that precision.
pub fn measure<R: Scalar>(item: &Item, reference: &[PointEntry], settings: Settings) -> Row {
    let units = Format::of::<R>();
    let double = units.spacing < 1e-10;
    let precision = if double { "f64" } else { "f32" };
    let mut row = Row { name: item.name.to_owned(), precision, ..Row::default() };
    let round = |x: &[f64]| -> Vec<f64> { x.iter().map(|x| R::of(*x).to_f64()).collect() };
    for entry in reference {
        if double {
            extreme(&mut row, entry, &units);
            verify(&mut row, item, entry, &units);
        }
        let below_one = R::ONE - R::EPSILON * R::of(0.5);
        let u: Vec<f64> = entry.u.iter().map(|u| R::of(*u).min(below_one).to_f64()).collect();
        one::<R>(&mut row, item, &round(&entry.inputs.numbers()), &u, &units, !double);
    }
    if !double {
        for point in peer_points(item.name) {
            peer::<R>(&mut row, item, &point, &units);
        }
    }
    let mut sets: Vec<Vec<f64>> = item.sets.iter().map(|s| round(s)).collect();
    sets.retain(|s| legal::<R>(item, s, &mut row.dropped));
    let Some(dimensions) = sets.first().and_then(|s| dimensions::<R>(item, s)) else { return row };
    for set in &sets {
        for u in next_to_ends::<R>(dimensions, true) {
            one::<R>(&mut row, item, set, &u, &units, false);
        }
    }
    if settings.sweep {
        let swept: Vec<Vec<f64>> = swept(item).iter().map(|s| round(s)).collect();
        for set in swept.iter().filter(|s| legal::<R>(item, s, &mut vec![])) {
            for u in next_to_ends::<R>(dimensions, false) {
                one::<R>(&mut row, item, set, &u, &units, false);
            }
        }
    }
    let mut source = Pcg32::new(11, 0, 0);
    let count = if double { settings.double } else { settings.single };
    for i in 0..count {
        let set = &sets[i as usize % sets.len()];
        let u: Vec<f64> = (0..dimensions)
            .map(|_| {
                let u: f64 = source.next();
                let u = R::of(u);
                u.min(R::ONE - R::EPSILON * R::of(0.5)).to_f64()
            })
            .collect();
        if double {
            one::<R>(&mut row, item, set, &u, &units, false);
        } else {
            against_double::<R>(&mut row, item, set, &u, &units);
        }
    }
    row
}

struct Dimensions;
impl<R: Scalar> Visitor<R> for Dimensions {
    type Output = usize;
    fn visit<S: Sampler<R>>(self, _: S) -> usize
    where
        S::Point: FromCoordinates<R>,
    {
        S::Uniforms::COUNT
    }
}

fn dimensions<R: Scalar>(item: &Item, set: &[f64]) -> Option<usize> {
    item.visit::<R, _>(set, Dimensions).ok()
}

/// Whether the parameters are in their domain; if not, says so.
fn legal<R: Scalar>(item: &Item, set: &[f64], dropped: &mut Vec<String>) -> bool {
    if set.iter().any(|x| !x.is_finite()) {
        dropped.push(format!("{set:?} overflows"));
        return false;
    }
    let made = item.visit::<R, _>(set, Dimensions);
    if let Err(error) = &made {
        dropped.push(error.to_string());
    }
    made.is_ok()
}

/// An extreme point of the reference data, against its values and condition numbers.
fn extreme(row: &mut Row, entry: &PointEntry, units: &Format) {
    let e = errors::<f64>(entry);
    let at = |what: &'static str| {
        move || format!("{what} at {:?} {:?}", entry.inputs.numbers(), entry.u)
    };
    row.extremes.add(units.units(e.sample), || entry.condition_sample, at("sample"));
    row.extremes.add(units.units(e.pdf), || entry.condition_pdf, at("pdf(x)"));
    row.extremes.add(units.units(e.own), || entry.condition_pdf, at("sample.pdf()"));
}

/// The oracle at an extreme point of the reference data, where that has a number.
fn verify(row: &mut Row, item: &Item, entry: &PointEntry, format: &Format) {
    let u: Vec<Precise> = entry.u.iter().map(|u| Precise::f64(*u)).collect();
    let Some(exact) = exact(item, &entry.inputs.numbers(), &u) else { return };
    let at = |what: &'static str| {
        move || format!("{what} at {:?} {:?}", entry.inputs.numbers(), entry.u)
    };
    if entry.condition_sample.is_finite() {
        row.oracle.add(format.vector(&entry.x, &exact.x), || 1.0, at("sample"));
    }
    if entry.condition_pdf.is_finite() && exact.density.finite() {
        row.oracle.add(format.density(entry.pdf, exact.density), || 1.0, at("density"));
    }
}

/// A point at which another renderer's density is known.
fn peer<R: Scalar>(row: &mut Row, item: &Item, point: &PeerPoint, format: &Format) {
    let u: Vec<Precise> = point.u.iter().map(|u| Precise::f64(*u)).collect();
    let Some(exact) = exact(item, &point.numbers, &u) else { return };
    let probe = Probe { u: &point.u, x: &point.x };
    let Ok(found) = item.visit::<R, _>(&point.numbers, probe) else { return };
    let condition = || conditions(item, &point.numbers, &u, &exact, *format).density;
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
    units: &Format,
    extreme: bool,
) {
    let precise: Vec<Precise> = u.iter().map(|u| Precise::f64(*u)).collect();
    if !legal::<R>(item, numbers, &mut row.dropped) {
        return;
    }
    let exact = exact(item, numbers, &precise);
    against::<R>(row, item, numbers, u, exact, units, extreme);
}

/// Random uniforms of `f32` against `f64`.
fn against_double<R: Scalar>(
    row: &mut Row,
    item: &Item,
    numbers: &[f64],
    u: &[f64],
    units: &Format,
) {
    let Ok(found) = item.visit::<f64, _>(numbers, Probe { u, x: &[] }) else { return };
    let exact = found.valid.then(|| Exact {
        x: found.sample.iter().map(|x| Precise::f64(*x)).collect(),
        density: Precise::f64(found.own),
    });
    against::<R>(row, item, numbers, u, exact, units, false);
}

fn against<R: Scalar>(
    row: &mut Row,
    item: &Item,
    numbers: &[f64],
    u: &[f64],
    exact: Option<Exact>,
    units: &Format,
    extreme: bool,
) {
    let rounded: Vec<f64> =
        exact.iter().flat_map(|e| &e.x).map(|x| R::of(x.to_f64()).to_f64()).collect();
    let Ok(found) = item.visit::<R, _>(numbers, Probe { u, x: &rounded }) else { return };
    row.samples += 1;
    let at = || format!("{numbers:?} {u:?}");
    let densities = [Some(found.own), Some(found.at_own), found.pdf].into_iter().flatten();
    // Where parameters leave no distribution, such as one of width zero, there is no sample either.
    let exists = exact.as_ref().is_some_and(|e| e.x.iter().all(|x| x.finite()));
    let numbers_found = found.sample.iter().filter(|_| found.valid && exists);
    let nan = numbers_found.chain(found.back.iter().flatten()).any(|x| x.is_nan());
    if nan || densities.clone().any(f64::is_nan) {
        row.nan += 1;
        row.example("NaN", &at);
    }
    let Some(exact) = exact else { return };
    let density = exact.density.to_f64();
    // Where the map is 0/0, at a uniform of zero, there is only a limit, which the oracle does not know.
    let known = density.is_finite() && density > 0.0 && exact.x.iter().all(|x| x.finite());
    if !known || !found.valid {
        return;
    }
    let precise: Vec<Precise> = u.iter().map(|u| Precise::f64(*u)).collect();
    let mut cached: Option<Conditions> = None;
    let mut condition = || {
        cached.get_or_insert_with(|| conditions(item, numbers, &precise, &exact, *units)).clone()
    };
    let normal = density > units.floor && density < units.ceiling;
    if normal && (found.own == 0.0 || found.at_own == 0.0) {
        // A point next to the border of the support may be rounded onto it, where the density is zero.
        if found.own == 0.0 || condition().density * units.spacing < 0.25 {
            row.false_zeros += 1;
            row.example("false zero", &at);
        }
    }
    let infinite = densities.into_iter().any(|d| d == f64::INFINITY);
    if normal && infinite && condition().density * units.spacing < 0.25 {
        row.infinite += 1;
        row.example("infinity", &at);
    }
    if exact.x.iter().any(|x| x.abs().to_f64() > units.ceiling) {
        return;
    }
    let sample = units.vector(&found.sample, &exact.x);
    row.sample.add(sample, || condition().sample, at);
    let own = units.density(found.own, exact.density);
    row.own.add(own, || condition().density, at);
    let by_hand: Vec<R> = rounded.iter().map(|x| R::of(*x)).collect();
    let parameters: Vec<R> = numbers.iter().map(|x| R::of(*x)).collect();
    if let Some(pdf) = textbook(item.which, &parameters, &by_hand) {
        row.textbook.add(units.density(pdf.to_f64(), exact.density), || condition().density, at);
    }
    let mut pdf = 0.0;
    if let Some(found) = found.pdf {
        pdf = units.density(found, exact.density);
        row.pdf.add(pdf, || condition().density, at);
    }
    if extreme {
        row.extremes.add(sample, || condition().sample, || format!("sample at {}", at()));
        row.extremes.add(own, || condition().density, || format!("sample.pdf() at {}", at()));
        row.extremes.add(pdf, || condition().density, || format!("pdf(x) at {}", at()));
    }
    inverse(row, &found, u, units, &mut condition, &at);
}

/// The preimage next to the uniforms: its worst uniform.
fn inverse(
    row: &mut Row,
    found: &Found,
    u: &[f64],
    units: &Format,
    condition: &mut dyn FnMut() -> Conditions,
    at: &dyn Fn() -> String,
) {
    let gap = |v: &Vec<f64>| v.iter().zip(u).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let Some(v) = found.back.iter().min_by(|a, b| gap(a).total_cmp(&gap(b))) else { return };
    let errors = v.iter().zip(u).map(|(v, u)| units.units((v - u).abs() / u.max(units.floor)));
    let errors: Vec<f64> = errors.collect();
    let worst = errors.iter().copied().fold(0.0, f64::max);
    // The condition number that goes with the worst error is that of the uniform with the worst quotient.
    let relative = || {
        let c = condition();
        let over = errors.iter().zip(&c.inverse).map(|(e, c)| e / c.max(1.0));
        worst / over.fold(0.0, f64::max)
    };
    row.inverse.add(worst, relative, at);
}
