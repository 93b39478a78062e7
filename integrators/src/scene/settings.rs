//! How the scene wants to be rendered: film, filter, sampler and integrator.

use std::str::FromStr;

use aether_core::prelude::Vec2;

use super::error::Place;
use crate::render::shares::Reached;
use crate::strategies::Pixel;

/// A reconstruction filter, as in Mitsuba 3.9.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    /// 1 within half a pixel.
    Box,
    /// Falls linearly to 0 at `radius` pixels.
    Tent {
        /// Where it becomes 0, in pixels.
        radius: f32,
    },
    /// `max(0, exp(-x²/2σ²) - exp(-r²/2σ²))` with the radius `r = 4σ`.
    Gaussian {
        /// The standard deviation σ in pixels.
        stddev: f32,
    },
    /// The piecewise cubic filters of Mitchell and Netravali (1988), which reach two pixels far. With B = 0 and
    /// C = 1/2 it is that of Catmull and Rom.
    Cubic {
        /// The parameter B, which blurs.
        b: f32,
        /// The parameter C, which rings.
        c: f32,
    },
    /// `sinc(x) sinc(x / lobes)` with `sinc(x) = sin(πx) / πx`, as far as there are lobes.
    Lanczos {
        /// How many pixels it reaches.
        lobes: u32,
    },
}

impl Filter {
    /// Whether it has negative lobes, so that it is no density up to a factor.
    pub fn is_signed(self) -> bool {
        matches!(self, Self::Cubic { .. } | Self::Lanczos { .. })
    }

    /// Whether samples are shared among the pixels that it reaches ([`shares`](crate::render::shares)).
    ///
    /// With negative lobes the weights of a lattice would not add up to one, and all pixels would be too bright or too
    /// dark at once.
    pub fn is_shared(self) -> bool {
        self.radius() > 0.5 && !self.is_signed()
    }

    /// Where the filter becomes 0, in pixels along each axis.
    pub fn radius(self) -> f32 {
        match self {
            Self::Box => 0.5,
            Self::Tent { radius } => radius,
            Self::Gaussian { stddev } => 4.0 * stddev,
            Self::Cubic { .. } => 2.0,
            Self::Lanczos { lobes } => lobes as f32,
        }
    }

    /// The profile along one axis at a distance of `x` pixels from the centre, not normalised. The
    /// filter is the product of the profiles along both axes.
    pub fn profile(self, x: f32) -> f32 {
        let x = x.abs();
        if x > self.radius() {
            return 0.0;
        }
        match self {
            Self::Box => 1.0,
            Self::Tent { radius } => 1.0 - x / radius,
            Self::Gaussian { stddev } => {
                let bell = |deviations: f32| (-0.5 * deviations * deviations).exp();
                (bell(x / stddev) - bell(4.0)).max(0.0)
            }
            // Mitchell and Netravali 1988, Eq. 8.
            Self::Cubic { b, c } if x < 1.0 => {
                let [cubic, square] = [12.0 - 9.0 * b - 6.0 * c, -18.0 + 12.0 * b + 6.0 * c];
                ((cubic * x + square) * x * x + 6.0 - 2.0 * b) / 6.0
            }
            Self::Cubic { b, c } => {
                let [cubic, square] = [-b - 6.0 * c, 6.0 * b + 30.0 * c];
                let [linear, constant] = [-12.0 * b - 48.0 * c, 8.0 * b + 24.0 * c];
                (((cubic * x + square) * x + linear) * x + constant) / 6.0
            }
            Self::Lanczos { lobes } => sinc(x) * sinc(x / lobes as f32),
        }
    }

    /// The plugin type.
    pub fn name(self) -> &'static str {
        match self {
            Self::Box => "box",
            Self::Tent { .. } => "tent",
            Self::Gaussian { .. } => "gaussian",
            Self::Cubic { b: 0.0, c: 0.5 } => "catmullrom",
            Self::Cubic { .. } => "mitchell",
            Self::Lanczos { .. } => "lanczos",
        }
    }
}

/// sin(πx) / πx.
fn sinc(x: f32) -> f32 {
    let angle = std::f32::consts::PI * x;
    if angle == 0.0 { 1.0 } else { angle.sin() / angle }
}

/// The image to render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Film {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// The reconstruction filter.
    pub filter: Filter,
}

impl Film {
    /// The pixels whose filters reach a film point, in pixels.
    pub fn reached(&self, point: Vec2<f32>) -> Reached {
        Reached::by(self.filter, (self.width, self.height), [point.x, point.y])
    }

    /// Whether a film point lies so near to the image that the filter of a pixel may reach it.
    #[inline]
    pub fn is_near(&self, point: Vec2<f32>) -> bool {
        let beyond = self.filter.radius() - 0.5;
        let along = |x: f32, size: u32| -beyond <= x && x <= size as f32 + beyond;
        along(point.x, self.width) && along(point.y, self.height)
    }

    /// The value of a pixel's filter at a film point.
    pub fn response(&self, pixel: Pixel, point: Vec2<f32>) -> f32 {
        let along = |x: f32, pixel: u32| self.filter.profile(x - (pixel as f32 + 0.5));
        along(point.x, pixel.0) * along(point.y, pixel.1)
    }

    /// The pixel that a film point lies in, if the filter is a box, which has the value one there, and reaches no other
    /// pixel: it does not lie between two of them.
    #[inline]
    pub fn only_receiver(&self, point: Vec2<f32>) -> Option<Pixel> {
        if self.filter != Filter::Box {
            return None;
        }
        // Only of numbers inside of the image a whole number below is found so.
        let along = |x: f32, size: u32| {
            let pixel = x as u32;
            let is_inside = x > 0.0 && pixel < size && pixel as f32 != x;
            is_inside.then_some(pixel)
        };
        Some((along(point.x, self.width)?, along(point.y, self.height)?))
    }

    /// The pixels whose filters reach a film point, each with the value of its filter there.
    pub fn receivers(&self, point: Vec2<f32>) -> impl Iterator<Item = (Pixel, f32)> {
        let film = *self;
        self.reached(point).pixels().map(move |pixel| (pixel, film.response(pixel, point)))
    }
}

/// Where the uniforms come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SamplerKind {
    /// Independent uniforms.
    Independent,
    /// Stratified in each pair of dimensions.
    Stratified,
    /// Correlated multi-jittered.
    Multijitter,
    /// Orthogonal arrays.
    Orthogonal,
    /// Low discrepancy.
    LowDiscrepancy,
}

impl SamplerKind {
    /// The plugin type.
    pub fn name(self) -> &'static str {
        match self {
            Self::Independent => "independent",
            Self::Stratified => "stratified",
            Self::Multijitter => "multijitter",
            Self::Orthogonal => "orthogonal",
            Self::LowDiscrepancy => "ldsampler",
        }
    }
}

impl FromStr for SamplerKind {
    type Err = String;

    /// From the plugin type; the error lists those that there are.
    fn from_str(name: &str) -> Result<Self, String> {
        let kinds = [
            Self::Independent,
            Self::Stratified,
            Self::Multijitter,
            Self::Orthogonal,
            Self::LowDiscrepancy,
        ];
        let found = kinds.into_iter().find(|kind| kind.name() == name);
        found.ok_or_else(|| kinds.map(Self::name).join(", "))
    }
}

/// The sampler of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampler {
    /// Where the uniforms come from.
    pub kind: SamplerKind,
    /// Samples per pixel.
    pub sample_count: u32,
    /// The seed.
    pub seed: u64,
}

impl Sampler {
    /// The same with another seed.
    pub fn seeded(self, seed: u64) -> Self {
        Sampler { seed, ..self }
    }
}

/// The integrator of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Integrator {
    /// The plugin type, for example `path`. Whether it exists is for the renderer to decide.
    pub name: String,
    /// The longest path in edges, none for any length: 1 shows emitters only, 2 adds direct
    /// illumination, and so on, as in Mitsuba.
    pub max_depth: Option<u32>,
    /// The path length from which Russian roulette may end a path.
    pub rr_depth: u32,
    /// Whether emitters that the camera sees directly are invisible: it sees what is behind shapes that emit
    /// ([`super::Scene::sight_of_eyes`]), and a black sky.
    pub hide_emitters: bool,
    /// The ids of shapes that are openings which light has to pass: those of the file, and of who loads it.
    pub portals: Vec<String>,
    /// Where it is written; none if the file has no integrator.
    pub place: Option<Place>,
}

impl Default for Integrator {
    fn default() -> Self {
        Self {
            name: "path".to_owned(),
            max_depth: None,
            rr_depth: 5,
            hide_emitters: false,
            portals: Vec::new(),
            place: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_inside_of_a_pixel_has_one_receiver() {
        let film = Film { width: 3, height: 2, filter: Filter::Box };
        let next = |x: f32| [x.next_down(), x, x.next_up()];
        let places: Vec<f32> =
            [-1.0, 0.0, 0.5, 1.0, 2.0, 3.0, 1e20].into_iter().flat_map(next).collect();
        for x in &places {
            for y in &places {
                let point = Vec2::new(*x, *y);
                let all: Vec<_> = film.receivers(point).filter(|(_, by)| *by > 0.0).collect();
                if let Some(only) = film.only_receiver(point) {
                    assert_eq!(all, [(only, 1.0)], "{point:?}");
                }
            }
        }
        assert_eq!(film.only_receiver(Vec2::new(2.9, 0.1)), Some((2, 0)));
        assert_eq!(film.only_receiver(Vec2::new(f32::NAN, 0.1)), None);
        let wider = Film { filter: Filter::Tent { radius: 1.0 }, ..film };
        assert_eq!(wider.only_receiver(Vec2::new(2.9, 0.1)), None);
    }

    #[test]
    fn filters_vanish_at_their_radius() {
        for filter in [Filter::Tent { radius: 1.5 }, Filter::Gaussian { stddev: 0.5 }] {
            let r = filter.radius();
            assert!(filter.profile(0.0) > 0.99);
            assert!(filter.profile(0.99 * r) > 0.0);
            assert!(filter.profile(-r) < 1e-7);
            assert_eq!(filter.profile(1.01 * r), 0.0);
        }
        assert_eq!(Filter::Box.profile(0.49), 1.0);
        assert_eq!(Filter::Box.profile(-0.51), 0.0);
        assert_eq!(Filter::Gaussian { stddev: 0.5 }.radius(), 2.0);
        // Those with negative lobes: the values of Mitchell's and of Lanczos's filter, by hand.
        let mitchell = Filter::Cubic { b: 1.0 / 3.0, c: 1.0 / 3.0 };
        for (x, value) in [(0.0, 16.0 / 18.0), (1.0, 1.0 / 18.0), (-1.5, -5.0 / 144.0), (2.0, 0.0)]
        {
            assert!((mitchell.profile(x) - value).abs() < 1e-6, "{x}: {}", mitchell.profile(x));
        }
        let catmull_rom = Filter::Cubic { b: 0.0, c: 0.5 };
        let lanczos = Filter::Lanczos { lobes: 3 };
        for x in 0..=3 {
            let one = f32::from(x == 0);
            assert!((lanczos.profile(x as f32) - one).abs() < 1e-6);
            assert!((catmull_rom.profile(x as f32) - one).abs() < 1e-6);
        }
        assert!((catmull_rom.profile(1.5) + 1.0 / 16.0).abs() < 1e-6);
        // sinc(3/2) sinc(1/2) = -4 / 3π².
        assert!((lanczos.profile(1.5) + 0.135_095).abs() < 1e-6);
        assert_eq!(
            [mitchell, catmull_rom, lanczos].map(Filter::name),
            ["mitchell", "catmullrom", "lanczos"]
        );
        let half = Filter::Gaussian { stddev: 0.5 }.profile(0.5);
        assert!((half - 0.606_195_2).abs() < 1e-6);
    }
}
