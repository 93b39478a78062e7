//! What is found at one point against the exact values there.

use aether_core::{Real, Scalar};

use super::conditions::{Conditions, Spot};
use super::few::Few;
use super::lazy::Lazy;
use super::measure::Row;
use super::oracle::{Exact, Format, exact};
use super::probe::{Answer, Question};
use crate::precise::Precise;
use crate::registry::{Item, rounded};
use crate::textbook::textbook;

/// A condition number that loses all digits but two bits, times the spacing of numbers.
const ALL_LOST: f64 = 0.25;

/// Where a point comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// The reference data: it counts among the extreme points.
    Extreme,
    /// The ends of uniforms, or of the domains of parameters.
    Swept,
    /// Chance: mostly far enough from all ends for differences in `f64`.
    Random,
}

/// A point with its exact values.
pub struct Judge<'a> {
    /// The sampler.
    pub item: &'a Item,
    /// Its parameters.
    pub numbers: &'a [f64],
    /// The uniforms.
    pub u: &'a [f64],
    /// The exact values; none where there is no sample.
    pub exact: Option<Exact>,
    /// The precision.
    pub format: Format,
    /// Where the point comes from.
    pub origin: Origin,
    /// Whether the textbook form is looked at too.
    pub by_hand: bool,
}

impl<'a> Judge<'a> {
    /// At uniforms, with the exact values there.
    pub fn at<R: Scalar>(
        item: &'a Item,
        numbers: &'a [f64],
        u: &'a [f64],
        origin: Origin,
        by_hand: bool,
    ) -> Self {
        let precise: Vec<Precise> = u.iter().map(|u| Precise::f64(*u)).collect();
        let (exact, format) = (exact(item, numbers, &precise), Format::of::<R>());
        Judge { item, numbers, u, exact, format, origin, by_hand }
    }

    /// What is asked there, of the uniforms and of the exact sample, rounded.
    pub fn question<R: Scalar>(&self) -> Question {
        Question { u: Few::new(self.u), x: Some(Self::rounded::<R>(&self.exact)) }
    }

    /// The exact sample, rounded: a point to ask about.
    pub fn rounded<R: Scalar>(exact: &Option<Exact>) -> Few<f64> {
        let Some(exact) = exact else { return Few::default() };
        exact.x.iter().map(|x| R::of(x.to_f64()).to_f64()).collect()
    }

    /// Adds to a row what was found at the uniforms and at the exact sample, `x`, rounded.
    pub fn enter<R: Scalar>(&self, row: &mut Row, found: &Answer, x: &[f64]) {
        let Judge { item, numbers, u, format, .. } = self;
        row.samples += 1;
        let at = || format!("{numbers:?} {u:?}");
        let densities = [Some(found.own), found.at_own, found.pdf].into_iter().flatten();
        // Where parameters leave no distribution, such as one of width zero, there is no sample either.
        let exists = self.exact.as_ref().is_some_and(|e| e.x.iter().all(|x| x.finite()));
        let unknown = exists && found.sample.iter().any(|x| x.is_nan());
        let nan = unknown && found.valid;
        if nan || found.nan || densities.clone().any(f64::is_nan) {
            row.nan += 1;
            row.example("NaN", &at);
        }
        let Some(exact) = self.exact else {
            row.unjudged += 1;
            return;
        };
        let density = exact.density.to_f64();
        // Where the map is 0/0, at a uniform of zero, there is only a limit, which the oracle does not know.
        let known = density.is_finite() && density > 0.0 && exists;
        if !known {
            row.unjudged += 1;
            return;
        }
        let spot = Spot { item, numbers, u, exact: &exact, format: *format };
        let order = core::mem::take(&mut row.order);
        let mut lazy = Lazy::new(spot, self.origin == Origin::Random, order);
        if found.valid {
            self.errors::<R>(row, found, x, &exact, &mut lazy);
        } else if unknown && !lazy.exceeds(ALL_LOST / format.spacing, |c| c.sample) {
            // What has no value is called no sample: it must not be a sample that was lost.
            row.nan += 1;
            row.example("lost sample", &at);
        } else {
            row.excused += 1;
        }
        row.order = lazy.order();
    }

    /// The errors at a point where there is a density.
    fn errors<R: Scalar>(
        &self,
        row: &mut Row,
        found: &Answer,
        x: &[f64],
        exact: &Exact,
        lazy: &mut Lazy,
    ) {
        let Judge { numbers, u, format, .. } = self;
        let at = || format!("{numbers:?} {u:?}");
        let densities = [Some(found.own), found.at_own, found.pdf].into_iter().flatten();
        let density = exact.density.to_f64();
        let normal = density > format.floor && density < format.ceiling;
        // A point next to the border of the support may be rounded onto it, where the density is zero; and one next to a pole
        // of the density onto that.
        let mut explained = || lazy.exceeds(ALL_LOST / format.spacing, |c| c.density);
        let zero = normal && (found.own == 0.0 || found.at_own == Some(0.0));
        if zero && (found.own == 0.0 || !explained()) {
            row.false_zeros += 1;
            row.example("false zero", &at);
        } else if zero {
            row.excused += 1;
        }
        let infinite = normal && densities.into_iter().any(|d| d == f64::INFINITY);
        if infinite && !explained() {
            row.infinite += 1;
            row.example("infinity", &at);
        } else if infinite {
            row.excused += 1;
        }
        if exact.x.iter().any(|x| x.abs().to_f64() > format.ceiling) {
            row.unjudged += 1;
            return;
        }
        let sample = format.vector(&found.sample, &exact.x);
        row.sample.add(sample, |c| lazy.beyond(c, |c| c.sample), at);
        let own = format.density(found.own, exact.density);
        row.own.add(own, |c| lazy.beyond(c, |c| c.own), at);
        if self.by_hand {
            self.textbook::<R>(row, x, exact, lazy);
        }
        let mut pdf = 0.0;
        if let Some(value) = found.pdf {
            pdf = match found.log_pdf.filter(|_| !normal) {
                Some(log) => format.beyond_range(value, log, density),
                None => format.density(value, exact.density),
            };
            row.pdf.add(pdf, |c| lazy.beyond(c, |c| c.density), at);
        }
        if self.origin == Origin::Extreme {
            let t = &mut row.extremes;
            t.add(sample, |_| lazy.all().sample, || format!("sample at {}", at()));
            t.add(own, |_| lazy.all().density, || format!("sample.pdf() at {}", at()));
            t.add(pdf, |_| lazy.all().density, || format!("pdf(x) at {}", at()));
        }
        self.inverse(row, found, lazy, &at);
    }

    /// The density as textbooks write it, at the exact sample, rounded.
    fn textbook<R: Scalar>(&self, row: &mut Row, x: &[f64], exact: &Exact, lazy: &mut Lazy) {
        let Judge { item, numbers, u, format, .. } = self;
        let at = || format!("{numbers:?} {u:?}");
        let by_hand: Few<R> = x.iter().map(|x| R::of(*x)).collect();
        let parameters: Vec<R> = rounded(item.parameters, numbers);
        if let Some(pdf) = textbook(item.which, &parameters, &by_hand) {
            let error = format.density(pdf.to_f64(), exact.density);
            row.textbook.add(error, |c| lazy.beyond(c, |c| c.density), at);
        }
    }

    /// The preimage next to the uniforms: its worst uniform.
    fn inverse(&self, row: &mut Row, found: &Answer, lazy: &mut Lazy, at: &dyn Fn() -> String) {
        let Some(back) = &found.back else { return };
        let Judge { u, format, .. } = self;
        let errors = back.iter().zip(*u);
        let errors: Few<f64> =
            errors.map(|(v, u)| format.units((v - u).abs() / u.max(format.floor))).collect();
        let worst = errors.iter().copied().fold(0.0, f64::max);
        // The condition number that goes with the worst error is that of the uniform with the worst quotient.
        let relative = |c: &Conditions| {
            let over = errors.iter().zip(c.inverse.iter()).map(|(e, c)| e / c.max(1.0));
            worst / over.fold(0.0, f64::max)
        };
        row.inverse.add(worst, |c| lazy.beyond(c, relative), at);
    }
}
