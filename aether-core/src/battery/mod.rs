//! A battery of checks for any sampler, in one line of a test.
//!
//! ```
//! use aether_core::{battery, prelude::*};
//!
//! /// Directions about +z, distributed as cos(theta) / pi.
//! #[sampler]
//! fn cosine_hemisphere(u: [Uniform; 2]) -> Direction {
//!     let r = u[0].sqrt();
//!     let phi = TAU * u[1];
//!     Direction::new(r * phi.cos(), r * phi.sin(), (1.0 - u[0]).sqrt())
//! }
//!
//! battery::check(&cosine_hemisphere()).assert_ok();
//! ```
//!
//! The battery trusts nothing but the sampler's forward map. Six checks, of which those that do not
//! apply say so in the report:
//!
//! - *round trip*: `invert(forward(u))` contains u, and every preimage maps forward to the sample;
//! - *own density*: `sample.pdf()` equals `sampler.pdf(&sample)`;
//! - *jacobian*: both equal the sum over all preimages of 1/√det(JᵀJ), J by differences;
//! - *mass*: the density integrates to one, by adaptive cubature over the whole space;
//! - *chi-square*: samples follow the density, whose mass in each bin comes from that cubature;
//! - *outside*: a point that has a density has a preimage that maps forward to it.
//!
//! A sampler with atoms ([`Mixed`](crate::Mixed)) has its continuous part checked so, and its atoms by three more:
//!
//! - *atoms*: a sample on an atom has the probability that `pdf` tells of it, wherever its place is said to be, and no
//!   preimages; an atom that is none has probability zero;
//! - *atom shares*: as many samples are on each atom as it is probable, by a chi-square test;
//! - *atom mass*: the probability of each is the measure of the uniforms that lead there, to nine digits, where those are
//!   boxes (each border belongs to one uniform). The continuous part then has to have the mass that atoms and uniforms
//!   without a sample leave of one.
//!
//! On a manifold that only the sampler knows ([`Embedded`](crate::Embedded) points and
//! [`SurfacePoint`](crate::SurfacePoint)s), and for several points at once, there is nothing to integrate over: *mass* needs
//! [`Battery::parametrised`] there, and *chi-square* [`Battery::located`] too; without them *jacobian* vouches for the
//! density on the manifold.
//!
//! [`StrategyBattery`] checks a strategy.

mod atoms;
mod cubature;
mod derivative;
mod gamma;
mod mass;
mod outside;
mod partition;
mod pearson;
mod pointwise;
mod probe;
mod regions;
mod report;
mod space;
mod strategies;
mod subject;
#[cfg(test)]
mod tests;

pub use report::{Finding, Report, Verdict};
pub use space::{Kind, Space};
pub use strategies::StrategyBattery;

use crate::map::Map;
use crate::real::Scalar;
use crate::sampler::Sampler;
use probe::Probe;
use subject::{AnySpot, Subject, Typed};

/// Checks a sampler in `f64` with the default settings.
pub fn check<S: Sampler<f64>>(sampler: &S) -> Report
where
    S::Point: Space<f64>,
{
    Battery::<S, f64>::new(sampler).run()
}

/// Checks a sampler in `f32`, with tolerances to match.
pub fn check_f32<S: Sampler<f32>>(sampler: &S) -> Report
where
    S::Point: Space<f32>,
{
    Battery::<S, f32>::new(sampler).run()
}

/// Checks a map in `f64`: the random variable that it makes of a sampler of its source space. The
/// sampler must pass on its own.
pub fn check_map<S: Sampler<f64>, M: Map<f64, Source = S::Point>>(map: &M, source: &S) -> Report
where
    M::Target: Space<f64>,
{
    Battery::<_, f64>::new(&source.then(*map)).run()
}

type Parametrisation<'a, P> = Box<dyn Fn(&[f64]) -> P + 'a>;

/// Where in the unit cube of a parametrisation the point with these coordinates lies.
type Place<'a> = dyn Fn(&[f64]) -> Vec<f64> + 'a;

/// A parametrised manifold, with points whose type is forgotten.
struct Manifold<'c, 'a> {
    cover: &'c dyn Fn(&[f64]) -> AnySpot<'a>,
    place: Option<&'c Place<'c>>,
}

/// The battery for one sampler, with its settings.
pub struct Battery<'a, S: Sampler<R>, R: Scalar> {
    sampler: &'a S,
    settings: Settings,
    parametrisation: Option<Parametrisation<'a, S::Point>>,
    place: Option<Box<Place<'a>>>,
}

/// Settings of the checks.
struct Settings {
    seed: u64,
    /// How many samples the chi-square test draws.
    samples: usize,
    /// How often the cubature may evaluate the density.
    evaluations: usize,
    /// Of each chi-square test.
    false_alarm_rate: f64,
    /// The smallest uniform that is tried, besides zero.
    least: f64,
    /// Coordinate and value at which the density jumps.
    jumps: Vec<(usize, f64)>,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            seed: 1,
            samples: 200_000,
            evaluations: 600_000,
            false_alarm_rate: 1e-6,
            least: 1e-300,
            jumps: Vec::new(),
        }
    }
}

impl<'a, S: Sampler<R>, R: Scalar> Battery<'a, S, R>
where
    S::Point: Space<R>,
{
    /// The default settings: seed 1, 200,000 samples, 600,000 evaluations of the density, one false
    /// alarm in 10^6 seeds.
    pub fn new(sampler: &'a S) -> Self {
        Battery { sampler, settings: Settings::default(), parametrisation: None, place: None }
    }

    /// Seed of all random choices; a battery with the same seed makes the same report.
    pub fn seed(mut self, seed: u64) -> Self {
        self.settings.seed = seed;
        self
    }

    /// How many samples each chi-square test draws (at least 1000).
    pub fn samples(mut self, samples: usize) -> Self {
        self.settings.samples = samples.max(1000);
        self
    }

    /// The smallest uniform that is tried besides zero; 1e-300 if this is not called.
    ///
    /// Where a uniform is so small that a whole border of the unit cube leads to one rounded point, and that point
    /// is not the origin, rounding puts it inside or outside of the support as it happens: such uniforms say nothing.
    pub fn least(mut self, uniform: f64) -> Self {
        self.settings.least = uniform;
        self
    }

    /// How often the cubature may evaluate the density.
    pub fn evaluations(mut self, evaluations: usize) -> Self {
        self.settings.evaluations = evaluations;
        self
    }

    /// Probability that a chi-square test of a right sampler fails, over the choice of seed: there is one, and another one
    /// of atoms.
    pub fn false_alarm_rate(mut self, rate: f64) -> Self {
        self.settings.false_alarm_rate = rate;
        self
    }

    /// A map from the unit cube, of the manifold's dimension, that covers the manifold once up to a
    /// null set; it need not preserve measure. The battery integrates the density over it.
    pub fn parametrised(mut self, cover: impl Fn(&[f64]) -> S::Point + 'a) -> Self {
        self.parametrisation = Some(Box::new(cover));
        self
    }

    /// Where in the unit cube of [`Battery::parametrised`] the point with these coordinates lies: its inverse, with which
    /// samples can be counted in cells of the cube. All samples must lie in it.
    pub fn located(mut self, place: impl Fn(&[f64]) -> Vec<f64> + 'a) -> Self {
        self.place = Some(Box::new(place));
        self
    }

    /// Where the density jumps: at these values of coordinate `axis`, so that the cubature cuts its
    /// cells there, and no differences are taken across it. On the sphere the coordinates are z and the azimuth in (-π, π].
    pub fn jumps(mut self, axis: usize, values: impl IntoIterator<Item = f64>) -> Self {
        self.settings.jumps.extend(values.into_iter().map(|value| (axis, value)));
        self
    }

    /// Runs all checks.
    pub fn run(&self) -> Report {
        self.run_until(|_| false)
    }

    /// Whether a check fails, as for a density that is wrong on purpose it has to. What is left after the checks of single
    /// points is not run if one of these fails.
    pub fn fails(&self) -> bool {
        !self.run_until(|report| !report.is_ok()).is_ok()
    }

    /// Runs checks until what they have found is enough.
    fn run_until(&self, is_enough: fn(&Report) -> bool) -> Report {
        let typed = Typed::<S, R>::new(self.sampler);
        let mut report = Report::new(core::any::type_name::<S>());
        match &self.parametrisation {
            None => run(&typed, &self.settings, None, &mut report, is_enough),
            Some(cover) => {
                let cover = |t: &[f64]| typed.spot(cover(t));
                let manifold = Manifold { cover: &cover, place: self.place.as_deref() };
                run(&typed, &self.settings, Some(&manifold), &mut report, is_enough);
            }
        }
        report
    }
}

/// Runs checks until what they have found is enough.
fn run(
    sampler: &dyn Subject,
    settings: &Settings,
    manifold: Option<&Manifold<'_, '_>>,
    report: &mut Report,
    is_enough: fn(&Report) -> bool,
) {
    let continuous = atoms::check(sampler, settings, report);
    let Some(probe) = Probe::new(sampler, settings.seed) else {
        if continuous == Some(0.0) {
            let detail = "all samples are on atoms".to_owned();
            return report.add("density", Verdict::NotApplicable, detail);
        }
        let detail = "no uniforms of 16384 give a finite sample".to_owned();
        return report.add("samples", Verdict::Failed, detail);
    };
    pointwise::check(&probe, settings, report);
    if is_enough(report) {
        return;
    }
    let draws = mass::Draws::new(&probe, settings.seed, settings.samples, continuous);
    match manifold {
        None => mass::check(&probe, &draws, settings, report),
        Some(manifold) => mass::check_over(&probe, &draws, settings, manifold, report),
    }
    outside::check(&probe, settings.seed, report);
}
