//! The checks of a strategy, whose vertices need not lie in a space that could be integrated over: against another strategy.

use std::collections::BTreeMap;

use super::Settings;
use super::cubature::{Bounds, Integral, MOST, Place};
use super::mass::chi_square;
use super::partition::Tree;
use super::pearson::Pearson;
use super::report::{Report, Verdict};
use crate::real::Real;
use crate::sequence::PathView;
use crate::strategy::{Dirac, Drawn, Strategy, Vertex};
use crate::uniform::Pcg32;

/// Levels of the partition: 2^5 cells, each with as many samples of the strategy.
const LEVELS: usize = 5;
/// How many samples the partition is made by.
const PILOT: u64 = 4096;
/// A standard error of the mass that is larger decides nothing.
const COARSE: f64 = 0.02;
/// The share of samples that rounding may put beyond an edge, where densities jump.
const AT_EDGES: f64 = 1e-2;

/// The battery for a strategy after some path.
///
/// A strategy may cast rays, so that its density is known only of vertices that were found. Another strategy finds them: the
/// reference, which has to reach all that the strategy reaches, with a density that is known to be right, and may be
/// as plain as uniform directions. Its samples y tell the mass of the density p in any cell, as means of p(y) / q(y).
///
/// - *own density*: what sampling tells of its density is what the strategy says of the vertex;
/// - *support*: a sample has a density;
/// - *mass*: the density integrates to the share of uniforms that give a vertex with a density;
/// - *chi-square*: samples follow the density in cells of the coordinates that are given;
/// - *atoms*: vertices that can be nowhere else ([`Dirac::Position`]) come as often as they are probable. Atoms with a
///   direction may be stated in any measure, of which their samples say nothing.
///
/// ```
/// use aether_core::prelude::*;
/// use aether_core::strategy::Vertex;
/// use aether_core::{PathView, battery::StrategyBattery, coin};
///
/// #[derive(Clone, Copy, Debug)]
/// struct Spot(f64);
/// impl Vertex for Spot {
///     type Real = f64;
///     type Point = f64;
///     fn point(&self) -> f64 {
///         self.0
///     }
/// }
///
/// /// Uniform on [a, a + length).
/// #[sampler(length in 1e-3..=1e3)]
/// fn interval(u: [Uniform; 1], a: f64, length: f64) -> f64 {
///     a + length * u[0]
/// }
///
/// /// About the vertex before, or anywhere ahead of it.
/// #[strategy]
/// fn hop(path: &PathView<Spot>) -> Spot {
///     let here = given(path.last());
///     let (start, length) = if choose(coin(0.25)) { (here.0 - 0.5, 1.0) } else { (here.0, 2.0) };
///     let x = draw(interval(start, length).expect("a length"));
///     Spot(x)
/// }
///
/// /// Anywhere that it may lead.
/// #[strategy]
/// fn anywhere(path: &PathView<Spot>) -> Spot {
///     let x = draw(interval(-5.0, 10.0).expect("a length"));
///     Spot(x)
/// }
///
/// let start = [Spot(1.0)];
/// let battery = StrategyBattery::new(hop(), anywhere(), PathView::from_slice(&start));
/// battery.run(|vertex| [vertex.0]).assert_ok();
/// ```
pub struct StrategyBattery<'p, V: Vertex, S, Q> {
    strategy: S,
    reference: Q,
    path: PathView<'p, V>,
    settings: Settings,
}

/// What kind of atom, and the bits of its coordinates.
type AtomKey = (bool, Vec<u64>);

impl<'p, V: Vertex, S: Strategy<V>, Q: Strategy<V>> StrategyBattery<'p, V, S, Q> {
    /// The default settings: seed 1, 100,000 samples of either strategy, one false alarm of a chi-square test in 10^6 seeds.
    pub fn new(strategy: S, reference: Q, path: PathView<'p, V>) -> Self {
        const {
            assert!(S::VERTICES == 1 && Q::VERTICES == 1, "strategies of one vertex are checked");
        }
        let settings = Settings { samples: 100_000, ..Settings::default() };
        StrategyBattery { strategy, reference, path, settings }
    }

    /// Seed of all random choices; a battery with the same seed makes the same report.
    pub fn seed(mut self, seed: u64) -> Self {
        self.settings.seed = seed;
        self
    }

    /// How many samples of either strategy are drawn (at least 1000).
    pub fn samples(mut self, samples: usize) -> Self {
        self.settings.samples = samples.max(1000);
        self
    }

    /// Probability that a chi-square test of a right strategy fails, over the choice of seed.
    pub fn false_alarm_rate(mut self, rate: f64) -> Self {
        self.settings.false_alarm_rate = rate;
        self
    }

    /// Runs all checks. `place` gives coordinates of a vertex, at most four, by which samples are sorted into cells: its
    /// position, say. Vertices with the same coordinates are the same if they are atoms.
    pub fn run<const N: usize>(&self, place: impl Fn(&V) -> [f64; N]) -> Report {
        const { assert!(0 < N && N <= MOST, "a vertex has one to four coordinates here") };
        let mut report = Report::new(core::any::type_name::<S>());
        let drawn =
            |stream, count| (0..count).filter_map(move |k| self.draw(&self.strategy, (stream, k)));
        let count = self.settings.samples as u64;
        let samples: Vec<_> = drawn(5, count).collect();
        self.check_own(&samples, &mut report);

        let has_density = |drawn: &Drawn<V>| drawn.dirac.is_none();
        let mut pilot: Vec<_> = drawn(4, PILOT)
            .filter(has_density)
            .map(|drawn| squeezed(&place(&drawn.vertex)))
            .collect();
        if pilot.is_empty() {
            report.add("mass", Verdict::NotApplicable, "no sample has a density".to_owned());
        } else {
            const CUBE: Bounds = [(-1.0, 1.0); MOST];
            let mut leaves = Vec::new();
            let tree = Tree::grow(&mut pilot, CUBE, N, LEVELS, &mut leaves);
            let cell = |vertex: &V| tree.leaf(&squeezed(&place(vertex)));
            let cells = leaves.last().map_or(0, |(owner, _)| owner + 1);
            let mut counts = vec![0.0; cells];
            for drawn in samples.iter().filter(|drawn| has_density(drawn)) {
                counts[cell(&drawn.vertex)] += 1.0;
            }
            let integral = self.integrate(cells, cell);
            self.check_cells(&counts, &integral, &mut report);
        }
        self.check_atoms(&samples, place, &mut report);
        report
    }

    /// A vertex by a strategy, from the uniforms with this number.
    fn draw<T: Strategy<V>>(&self, strategy: &T, (stream, number): (u64, u64)) -> Option<Drawn<V>> {
        let mut uniforms = Pcg32::new(self.settings.seed, stream, number);
        strategy.sample_limited(self.path, &mut uniforms)
    }

    /// The density of a vertex by a strategy, or its probability.
    fn density<T: Strategy<V>>(&self, strategy: &T, vertex: &V, dirac: Option<Dirac>) -> f64 {
        strategy.pdf_limited(self.path.asking(dirac), vertex).of_kind(dirac).to_f64()
    }

    /// Checks what samples tell of their density.
    fn check_own(&self, samples: &[Drawn<V>], report: &mut Report) {
        let tolerance = V::Real::EPSILON.to_f64().sqrt();
        let (mut told, mut off, mut lost, mut worst) = (0, 0, 0, None::<(f64, Drawn<V>)>);
        for drawn in samples {
            let density = self.density(&self.strategy, &drawn.vertex, drawn.dirac);
            if density.is_nan() || density <= 0.0 {
                lost += 1;
            } else if let Some(own) = drawn.value {
                told += 1;
                let error = (own.to_f64() / density - 1.0).abs();
                if error.is_nan() || error > tolerance {
                    off += 1;
                    if worst.is_none_or(|(most, _)| error > most) {
                        worst = Some((error, *drawn));
                    }
                }
            }
        }
        let figures = format!("{told} samples tell it, {off} are off by more than {tolerance:.0e}");
        let failure = (f64::from(off) > AT_EDGES * f64::from(told))
            .then(|| format!("{figures}, the worst by {worst:?}"));
        report.conclude("own density", failure, figures);
        let figures = format!("{lost} of {} samples have no density", samples.len());
        let is_wrong = f64::from(lost) > AT_EDGES * samples.len() as f64;
        report.conclude("support", is_wrong.then(|| figures.clone()), figures);
    }

    /// The mass of the density in each cell, by samples of the reference.
    fn integrate(&self, cells: usize, cell: impl Fn(&V) -> usize) -> Integral {
        let count = self.settings.samples;
        let (mut sums, mut squares) = (vec![0.0; cells], vec![0.0; cells]);
        for number in 0..count as u64 {
            let drawn = self.draw(&self.reference, (6, number));
            let Some(Drawn { vertex, dirac: None, .. }) = drawn else { continue };
            let density = self.density(&self.strategy, &vertex, None);
            if density > 0.0 {
                let ratio = density / self.density(&self.reference, &vertex, None);
                let cell = cell(&vertex);
                sums[cell] += ratio;
                squares[cell] += ratio * ratio;
            }
        }
        let n = count as f64;
        let bins: Vec<_> = sums.iter().map(|sum| sum / n).collect();
        let variance = |(square, mean): (&f64, &f64)| (square / n - mean * mean) / (n - 1.0);
        let variances = squares.iter().zip(&bins).map(variance).collect();
        Integral { bins, variances }
    }

    /// Compares samples with the mass of the density in each cell.
    fn check_cells(&self, counts: &[f64], integral: &Integral, report: &mut Report) {
        let n = self.settings.samples as f64;
        let (found, total, error) =
            (counts.iter().sum::<f64>() / n, integral.total(), integral.error());
        let figures = format!(
            "the density integrates to {total:.4} (standard error {error:.0e}), and {found:.4} of \
             the uniforms give a vertex with a density"
        );
        let noise = (error * error + found * (1.0 - found) / n).sqrt();
        let failure = if error.is_nan() || error >= COARSE {
            Some(format!("{figures}: not resolved, take a reference that is more like it"))
        } else {
            ((total - found).abs() > 5.0 * noise + f64::EPSILON.sqrt()).then(|| figures.clone())
        };
        report.conclude("mass", failure, figures);
        let missing = n - counts.iter().sum::<f64>();
        chi_square((n, missing), counts, integral, self.settings.false_alarm_rate, report);
    }

    /// Compares how often each atom comes with its probability.
    fn check_atoms<const N: usize>(
        &self,
        samples: &[Drawn<V>],
        place: impl Fn(&V) -> [f64; N],
        report: &mut Report,
    ) {
        let mut atoms = BTreeMap::<AtomKey, (f64, V)>::new();
        for Drawn { vertex, dirac, .. } in samples.iter().filter(|drawn| drawn.dirac.is_some()) {
            let bits = place(vertex).iter().map(|x| x.to_bits()).collect();
            atoms.entry((*dirac == Some(Dirac::Position), bits)).or_insert((0.0, *vertex)).0 += 1.0;
        }
        atoms.retain(|(is_fixed, _), _| *is_fixed);
        if atoms.is_empty() {
            let detail = "no sample is an atom at a position".to_owned();
            return report.add("atoms", Verdict::NotApplicable, detail);
        }
        let n = self.settings.samples as f64;
        let (mut pearson, mut count, mut mass) = (Pearson::default(), n, 1.0);
        for (found, vertex) in atoms.values() {
            let probability = self.density(&self.strategy, vertex, Some(Dirac::Position));
            (count, mass) = (count - found, mass - probability);
            pearson.add(&format!("{vertex:?}"), *found, (n * probability, 0.0));
        }
        pearson.add("anything else", count, (n * mass, 0.0));
        let subject = format!("{} atoms", atoms.len());
        pearson.conclude(("atoms", &subject), self.settings.false_alarm_rate, report);
    }
}

/// Coordinates of any size, in (-1, 1).
fn squeezed<const N: usize>(coordinates: &[f64; N]) -> Place {
    let mut place = [0.0; MOST];
    for (to, x) in place.iter_mut().zip(coordinates) {
        *to = x / (1.0 + x.abs());
    }
    place
}
