//! Whether the vertices that a strategy draws are distributed as its density says: Pearson's test over bins of
//! directions from the last vertex of a path. For tests.

use std::f32::consts::{PI, TAU};

use aether_core::prelude::Direction;
use aether_core::{PathView, Pcg32, Strategy};
use glam::Vec3;

use crate::vertex::{Place, SceneVertex, Seen};
use crate::world::World;

/// Rows and columns of bins on the sphere of directions.
const BINS: [usize; 2] = [10, 16];
/// Points in each bin along both sides.
pub const FINE: usize = 10;
/// The same where densities end abruptly.
pub const SHARP: usize = 40;
/// The same where lobes are narrow.
pub const FINER: usize = 60;
/// Samples of each distribution.
const DRAWS: usize = 20_000;

/// A strategy at the end of a path.
pub struct Sampled<'w, S> {
    /// The scene.
    pub world: &'w World<'w>,
    /// The strategy.
    pub strategy: S,
    /// The path.
    pub path: Vec<SceneVertex>,
}

impl<S: Strategy<SceneVertex>> Sampled<'_, S> {
    fn here(&self) -> &SceneVertex {
        self.path.last().expect("a path has vertices")
    }

    /// How many samples fall into each bin, and how many into none: atoms, what is hidden, and draws that fail.
    pub fn counts(&self, seed: u64) -> Vec<f64> {
        let mut counts = vec![0.0; BINS[0] * BINS[1] + 1];
        for k in 0..DRAWS {
            let mut uniforms = Pcg32::new(seed, 0, k as u64);
            let drawn = self.strategy.sample(PathView::from_slice(&self.path), &mut uniforms);
            let bin = match drawn {
                Some(drawn)
                    if drawn.dirac.is_none() && self.world.visible(self.here(), &drawn.vertex) =>
                {
                    bin_of(drawn.vertex.direction_from(self.here().position))
                }
                _ => BINS[0] * BINS[1],
            };
            counts[bin] += 1.0;
        }
        counts
    }

    /// How many are expected to, by `fine` points along both sides of each bin.
    pub fn expected(&self, fine: usize) -> Vec<f64> {
        let [rows, columns] = BINS.map(|n| n * fine);
        let mut expected = vec![0.0; BINS[0] * BINS[1] + 1];
        for k in 0..rows * columns {
            // Each column starts elsewhere, so that no row of points follows the rim of a distribution.
            let shift = ((k % columns) as f32 * 0.618_034).fract();
            let theta = PI * ((k / columns) as f32 + shift) / rows as f32;
            let phi = TAU * ((k % columns) as f32 + 0.5) / columns as f32;
            let w = Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
            let solid_angle = theta.sin() * PI * TAU / (rows * columns) as f32;
            expected[bin_of(w)] += f64::from(self.density(w) * solid_angle) * DRAWS as f64;
        }
        let inside: f64 = expected.iter().sum();
        expected[BINS[0] * BINS[1]] = (DRAWS as f64 - inside).max(0.0);
        expected
    }

    /// The density, per solid angle, of what is seen first in a direction.
    fn density(&self, w: Vec3) -> f32 {
        let here = self.here();
        let of = |vertex| self.strategy.pdf(PathView::from_slice(&self.path), &vertex).value;
        let direction = Direction::from_unit(w.into());
        match self.world.cast(here, &direction) {
            Some(Seen::Surface(met)) => {
                let squared = here.position.distance_squared(met.position);
                let cosine = met.normal.dot(w).abs();
                if cosine > 0.0 { of(SceneVertex::on(met)) * squared / cosine } else { 0.0 }
            }
            Some(Seen::Sky(sky)) => of(SceneVertex { position: w, place: Place::Sky(sky) }),
            None => 0.0,
        }
    }

    /// By how many standard deviations the samples are off.
    pub fn deviation(&self, seed: u64, fine: usize) -> f64 {
        deviation(&self.counts(seed), &self.expected(fine))
    }
}

fn bin_of(w: Vec3) -> usize {
    let row = (w.x.hypot(w.y).atan2(w.z) / PI * BINS[0] as f32) as usize;
    let column = ((w.y.atan2(w.x) / TAU).rem_euclid(1.0) * BINS[1] as f32) as usize;
    row.min(BINS[0] - 1) * BINS[1] + column.min(BINS[1] - 1)
}

/// Pearson's statistic as standard deviations of a normal variable (Wilson and Hilferty 1931). Bins in which
/// fewer than ten are expected are taken together; the quadrature is allowed one percent of each bin.
pub fn deviation(counts: &[f64], expected: &[f64]) -> f64 {
    let (mut statistic, mut bins, mut rest) = (0.0, 0.0, (0.0, 0.0));
    let mut add = |count: f64, expected: f64| {
        let off = ((count - expected).abs() - 0.01 * expected).max(0.0);
        statistic += off * off / expected;
        bins += 1.0;
    };
    for (count, expected) in counts.iter().zip(expected) {
        if *expected >= 10.0 {
            add(*count, *expected);
        } else {
            rest = (rest.0 + count, rest.1 + expected);
        }
    }
    if rest.1 >= 10.0 {
        add(rest.0, rest.1);
    }
    if bins < 2.0 {
        // One bin has all that there is, whatever the density.
        return 0.0;
    }
    let (n, spread) = (bins - 1.0f64, 2.0 / (9.0 * (bins - 1.0)));
    ((statistic / n).cbrt() - (1.0 - spread)) / spread.sqrt()
}
