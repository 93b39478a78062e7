//! The uniforms that integrators draw from.

use aether_core::sequence::first_block;
use aether_core::{Pcg32, Sobol, UniformSource};

use crate::scene::{Film, SamplerKind};
use crate::strategies::Pixel;

/// Uniforms of any kind that a scene may ask for, as one type: integrators and strategies are compiled once for all.
#[derive(Clone, Debug)]
pub struct Uniforms {
    source: Source,
    /// What the film point is drawn from, if that is something else; while it is drawn from, what all else is.
    other: Option<Source>,
    is_on_film: bool,
}

#[derive(Clone, Debug)]
enum Source {
    /// Independent of each other.
    Independent(Pcg32),
    /// Stratified over the samples of a pixel.
    Stratified(Sobol),
}

/// The number of the stream that all pixels have in common.
const IMAGE: u64 = 1 << 63;

/// The block from which the second vertex of the first path is drawn: what a camera sees.
const FILM: u32 = first_block(1);

impl Source {
    #[inline]
    fn new(kind: SamplerKind, seed: u64, stream: u64, sample: u32) -> Self {
        match kind {
            SamplerKind::Independent => Self::Independent(Pcg32::new(seed, stream, sample.into())),
            _ => Self::Stratified(Sobol::new(seed, stream, sample)),
        }
    }
}

impl Uniforms {
    #[inline]
    fn of(source: Source) -> Self {
        Uniforms { source, other: None, is_on_film: false }
    }

    /// Those of one sample of a pixel, whose number is `stream`.
    #[inline]
    pub fn new(kind: SamplerKind, seed: u64, stream: u64, sample: u32) -> Self {
        Self::of(Source::new(kind, seed, stream, sample))
    }

    /// Independent ones.
    #[inline]
    pub fn independent(seed: u64, stream: u64, sample: u64) -> Self {
        Self::of(Source::Independent(Pcg32::new(seed, stream, sample)))
    }

    /// Those of a sample of a pixel of an image. Where samples are shared by a filter
    /// ([`shares`](crate::render::shares)), all pixels draw the film points of those with the same number by the same numbers,
    /// so that they lie at the same place of their pixels. These places are stratified, whatever the kind: what edges
    /// along the axes of the image would make of others, all pixels at an edge would have in common.
    #[inline]
    pub fn of_pixel(kind: SamplerKind, seed: u64, pixel: Pixel, film: &Film, sample: u32) -> Self {
        let stream = u64::from(pixel.1) * u64::from(film.width) + u64::from(pixel.0);
        let places = || Source::new(SamplerKind::LowDiscrepancy, seed, IMAGE, sample);
        let other = film.filter.is_shared().then(places);
        Uniforms { other, ..Self::new(kind, seed, stream, sample) }
    }
}

impl UniformSource<f32> for Uniforms {
    #[inline]
    fn next(&mut self) -> f32 {
        match &mut self.source {
            Source::Independent(source) => source.next(),
            Source::Stratified(source) => source.next(),
        }
    }

    #[inline]
    fn choice(&mut self) -> f32 {
        match &mut self.source {
            Source::Independent(source) => source.choice(),
            Source::Stratified(source) => source.choice(),
        }
    }

    #[inline]
    fn start(&mut self, block: u32) {
        if let Some(other) = &mut self.other
            && (block == FILM) != self.is_on_film
        {
            std::mem::swap(&mut self.source, other);
            self.is_on_film = !self.is_on_film;
        }
        match &mut self.source {
            Source::Independent(source) => UniformSource::<f32>::start(source, block),
            Source::Stratified(source) => UniformSource::<f32>::start(source, block),
        }
    }

    #[inline]
    fn piece(&mut self, number: u32) {
        for source in std::iter::once(&mut self.source).chain(&mut self.other) {
            match source {
                Source::Independent(source) => UniformSource::<f32>::piece(source, number),
                Source::Stratified(source) => UniformSource::<f32>::piece(source, number),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Filter;

    #[test]
    fn at_one_place_only_film_points_are_drawn_by_the_same_numbers() {
        for kind in [SamplerKind::Independent, SamplerKind::LowDiscrepancy] {
            let numbers = |mut uniforms: Uniforms| {
                [0, FILM, 7, FILM].map(|block| {
                    uniforms.start(block);
                    [(); 3].map(|()| uniforms.next())
                })
            };
            let filter = Filter::Gaussian { stddev: 0.5 };
            let film = Film { width: 16, height: 16, filter };
            let of = |x, sample| numbers(Uniforms::of_pixel(kind, 5, (x, 0), &film, sample));
            let (a, b) = (of(1, 9), of(2, 9));
            assert_eq!((a[1], a[3]), (b[1], b[3]));
            assert_eq!(a[1], a[3]);
            assert!(a[1] != of(1, 8)[1] && a[0] != b[0] && a[2] != b[2]);
            let plain = numbers(Uniforms::new(kind, 5, 1, 9));
            assert_eq!((a[0], a[2]), (plain[0], plain[2]));
            assert_ne!(a[1], plain[1]);
        }
    }
}
