//! From a function that estimates one pixel to an image: distribution of work, progress,
//! cancellation. Nothing here knows how light is computed.
//!
//! The image is cut into square tiles. A *pass* adds the same number of samples to each pixel; its
//! work units are the tiles, which threads draw from an atomic counter. A pixel's samples are
//! numbered and accumulated in order, whoever computes them, so that the image depends on the
//! kernel alone and not on threads, tiles, passes or time.
//!
//! Contributions to other pixels (of paths from lights) are added up exactly ([`splats`]), so that
//! their order does not matter either. Where the reconstruction filter is wider than a pixel, samples are shared among
//! pixels ([`shares`]).
//!
//! - [`render`]: the engine; [`PixelKernel`]: what it evaluates; [`resume`]: how it goes on.
//! - [`checkpoint`]: files that keep the state of a render.
//! - [`film`]: what is known of each pixel.
//! - [`progress`]: what is reported while it runs.

pub mod checkpoint;
pub mod film;
pub mod layers;
pub mod progress;
pub mod shares;
pub mod splats;
pub mod technique;

mod engine;
mod gathered;
mod passes;
mod windows;

pub use engine::{Rendered, render, resume};
pub use film::Film;
pub use layers::Layers;
pub use progress::{Observer, Progress};
pub use splats::{SplatSums, Splats};
pub use technique::{Layer, Technique};
pub use windows::WINDOW;

use std::io::{self, Read, Write};

use crate::scene::Filter;
use crate::work::Work;

/// An estimator of the pixels of an image.
///
/// The result of [`sample`](Self::sample) may depend on nothing but the kernel, the pixel and the
/// sample number; the scratch object is memory to reuse. Then the same image is rendered whatever
/// the number of threads.
pub trait PixelKernel: Sync {
    /// What one thread reuses from sample to sample: arenas, buffers, random number generators.
    type Scratch;

    /// A new scratch object; called once for each thread and pass.
    fn scratch(&self) -> Self::Scratch;

    /// One estimate of the linear Rec. 709 value of `pixel` (column, row; the origin is the top
    /// left). Samples of a pixel are numbered from 0 and are averaged with equal weights.
    fn sample(&self, scratch: &mut Self::Scratch, pixel: (u32, u32), sample: u32) -> [f32; 3];
}

/// A kernel with the scratch object of one thread: the value for a pixel and a sample number, and what
/// that sample contributes to other pixels.
pub type Worker<'a> = Box<dyn FnMut((u32, u32), u32, &mut Splats) -> [f32; 3] + 'a>;

/// Whether a render has been cancelled, to be asked by what takes long.
pub type Cancelled<'a> = &'a (dyn Fn() -> bool + Sync);

/// A Markov chain.
pub trait MarkovChain: Send {
    /// Takes a step, and splats what it contributes. A step counts like a sample: the steps with the same number,
    /// one for each pixel, add up to the image.
    fn step(&mut self, splats: &mut Splats);

    /// Writes where the chain is.
    ///
    /// # Errors
    /// If the file cannot be written.
    fn save(&self, to: &mut dyn Write) -> io::Result<()>;

    /// Goes to where a chain with the same number was, of a render with the same settings: its steps are then those
    /// of the other.
    ///
    /// # Errors
    /// If the file does not have what [`MarkovChain::save`] has written.
    fn restore(&mut self, from: &mut dyn Read) -> io::Result<()>;
}

/// A Markov chain of some integrator.
pub type Chain<'a> = Box<dyn MarkovChain + 'a>;

/// A [`PixelKernel`] whose scratch type is hidden, so that kernels can be chosen at run time.
/// Implemented for every kernel.
pub trait AnyKernel: Sync {
    /// The kernel with a scratch object of its own, for the use of one thread.
    fn worker(&self) -> Worker<'_>;

    /// The same, which may give a sample up if the render is cancelled while it is computed ([`Splats::give_up`]): for
    /// kernels of which a single sample can take long.
    fn worker_until<'a>(&'a self, cancelled: Cancelled<'a>) -> Worker<'a> {
        let _ = cancelled;
        self.worker()
    }

    /// The Markov chain with this number, if the image is made of them: one for each tile of the image, which
    /// takes a step beside each sample of each of its pixels. What they find adds up.
    fn chain(&self, number: usize) -> Option<Chain<'_>> {
        let _ = number;
        None
    }

    /// What has been counted while rendering, as text of several lines.
    fn statistics(&self) -> Option<String> {
        None
    }

    /// Writes what has been counted while rendering. Samples depend on their numbers alone, so that there is nothing
    /// else to write of a kernel.
    ///
    /// # Errors
    /// If the file cannot be written.
    fn save(&self, to: &mut dyn Write) -> io::Result<()> {
        let _ = to;
        Ok(())
    }

    /// Goes on with what [`AnyKernel::save`] has written.
    ///
    /// # Errors
    /// If the file does not have that.
    fn restore(&self, from: &mut dyn Read) -> io::Result<()> {
        let _ = from;
        Ok(())
    }

    /// The most samples that a pass may add to each pixel.
    fn largest_pass(&self) -> u32 {
        u32::MAX
    }

    /// Called before each pass, with the number of its first sample. Returns false if the render was cancelled before
    /// all that samples need was made; then none is asked for.
    fn begin_pass(&self, first: u32, threads: usize, cancelled: Cancelled<'_>) -> bool {
        let _ = (first, threads, cancelled);
        true
    }

    /// What of a render was computed when the kernel was made.
    fn preparation(&self) -> Preparation {
        Preparation::default()
    }

    /// Whether samples contribute to other pixels.
    fn splats(&self) -> bool {
        false
    }

    /// Roughly how bright the image is, as the power of two. Sums of what samples add to other pixels than their own are in
    /// units that follow from it: a contribution may be 2⁵⁰ times as bright, and of a fainter one than 2⁻⁶⁴ times nothing is kept.
    fn brightness_exponent(&self) -> i32 {
        0
    }

    /// The reconstruction filter, if samples say where on the film they lie ([`Splats::lie`]): where it is wider than a
    /// pixel, they are shared among the pixels that it reaches ([`shares`]). Their values are then those of their film points,
    /// times Σ_j |f_j|; all samples with the same number should lie at the same place of their pixels.
    fn filter(&self) -> Option<Filter> {
        None
    }
}

/// What making a kernel has computed of the image already, such as the start of Markov chains: it counts as
/// rendering, while reading a scene does not.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Preparation {
    /// Seconds that it took.
    pub seconds: f64,
    /// What was computed.
    pub work: Work,
}

impl<K: PixelKernel> AnyKernel for K {
    fn worker(&self) -> Worker<'_> {
        let mut scratch = self.scratch();
        Box::new(move |pixel, sample, _| self.sample(&mut scratch, pixel, sample))
    }
}

/// How long to render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Budget {
    /// So many samples for each pixel.
    Samples(u32),
    /// About so many seconds: as many equal passes as fit, and at least one sample per pixel.
    Seconds(f64),
    /// Until the estimated error is small, or one of the others is used up.
    Error(ErrorBudget),
}

/// Renders until the estimated relative error of each window of the image is below a target; see
/// [`WINDOW`] for what that is. It is looked at from 16 samples per pixel on, at powers of two and then at
/// multiples of 64, so that the image does not depend on the speed unless `seconds` ends it.
///
/// When to stop depends on the samples, so the image is biased a little: a window that has missed what is
/// rare seems to have little error, and ends early, too dark.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorBudget {
    /// The relative error that is small enough.
    pub target: f64,
    /// At most so many samples for each pixel.
    pub samples: u32,
    /// At most about so many seconds.
    pub seconds: f64,
    /// Whether a window that is good enough gets no more samples while others go on, in place of equal
    /// numbers for all. That saves time and increases the bias, since each window decides for itself.
    /// Without effect where samples contribute to other pixels.
    pub adaptive: bool,
}

/// The size of the image, the effort and the number of threads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderSettings {
    /// Columns and rows of the image.
    pub size: (u32, u32),
    /// When to stop.
    pub budget: Budget,
    /// The number of threads, or `None` for one on each core.
    pub threads: Option<usize>,
    /// The most vertices of paths whose techniques have layers of their own; 0 for none ([`Layer::Technique`]).
    pub layered: usize,
}

impl RenderSettings {
    /// On all cores, without layers of techniques.
    pub fn new(size: (u32, u32), budget: Budget) -> Self {
        RenderSettings { size, budget, threads: None, layered: 0 }
    }
}
