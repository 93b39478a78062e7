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
//! On a manifold that only the sampler knows ([`Embedded`](crate::Embedded) points and
//! [`SurfacePoint`](crate::SurfacePoint)s) there is nothing to integrate over: *mass* needs
//! [`Battery::parametrised`] there, and *chi-square* is left out; *jacobian* then vouches for the
//! density on the manifold.

mod cubature;
mod derivative;
mod gamma;
mod mass;
mod outside;
mod partition;
mod pointwise;
mod probe;
mod report;
mod space;
#[cfg(test)]
mod tests;

pub use report::{Finding, Report, Verdict};
pub use space::{Kind, Space};

use crate::map::Map;
use crate::real::Scalar;
use crate::sampler::Sampler;
use probe::Probe;

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

/// The battery for one sampler, with its settings.
pub struct Battery<'a, S: Sampler<R>, R: Scalar> {
    sampler: &'a S,
    seed: u64,
    samples: usize,
    evaluations: usize,
    false_alarm_rate: f64,
    parametrisation: Option<Parametrisation<'a, S::Point>>,
    jumps: Vec<(usize, f64)>,
}

impl<'a, S: Sampler<R>, R: Scalar> Battery<'a, S, R>
where
    S::Point: Space<R>,
{
    /// The default settings: seed 1, 200,000 samples, 600,000 evaluations of the density, one false
    /// alarm in 10^6 seeds.
    pub fn new(sampler: &'a S) -> Self {
        Battery {
            sampler,
            seed: 1,
            samples: 200_000,
            evaluations: 600_000,
            false_alarm_rate: 1e-6,
            parametrisation: None,
            jumps: Vec::new(),
        }
    }

    /// Seed of all random choices; a battery with the same seed makes the same report.
    pub fn seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    /// How many samples the chi-square test draws (at least 1000).
    pub fn samples(mut self, samples: usize) -> Self {
        self.samples = samples.max(1000);
        self
    }

    /// How often the cubature may evaluate the density.
    pub fn evaluations(mut self, evaluations: usize) -> Self {
        self.evaluations = evaluations;
        self
    }

    /// Probability that the chi-square test of a right sampler fails, over the choice of seed.
    pub fn false_alarm_rate(mut self, rate: f64) -> Self {
        self.false_alarm_rate = rate;
        self
    }

    /// A map from the unit cube, of the manifold's dimension, that covers the manifold once up to a
    /// null set; it need not preserve measure. The battery integrates the density over it.
    pub fn parametrised(mut self, cover: impl Fn(&[f64]) -> S::Point + 'a) -> Self {
        self.parametrisation = Some(Box::new(cover));
        self
    }

    /// Where the density jumps: at these values of coordinate `axis`, so that the cubature cuts its
    /// cells there. On the sphere the coordinates are z and the azimuth in (-π, π].
    pub fn jumps(mut self, axis: usize, values: impl IntoIterator<Item = f64>) -> Self {
        self.jumps.extend(values.into_iter().map(|value| (axis, value)));
        self
    }

    /// Runs all checks.
    pub fn run(&self) -> Report {
        let mut report = Report::new(core::any::type_name::<S>());
        let Some(probe) = Probe::<S, R>::new(self.sampler, self.seed) else {
            let detail = "no uniforms of 16384 give a finite sample".to_owned();
            report.add("samples", Verdict::Failed, detail);
            return report;
        };
        pointwise::check(&probe, self.seed, &mut report);
        let draws = mass::Draws::new(&probe, self.seed, self.samples);
        match &self.parametrisation {
            None => {
                let effort = mass::Effort {
                    evaluations: self.evaluations,
                    false_alarm_rate: self.false_alarm_rate,
                    jumps: &self.jumps,
                };
                mass::check(&probe, &draws, &effort, &mut report)
            }
            Some(cover) => {
                mass::check_over(&probe, &draws, self.evaluations, cover.as_ref(), &mut report);
            }
        }
        outside::check(&probe, self.seed, &mut report);
        report
    }
}
