//! The parts of an image that threads work on, and what the samples of one add to it.

use std::sync::Mutex;
use std::sync::atomic::Ordering;

use super::{Job, lock};
use crate::render::film::PixelEstimate;
use crate::render::gathered::Gathered;
use crate::render::windows::WINDOW;
use crate::render::{AnyKernel, Chain, Splats, Worker};

/// The side of a tile in pixels: tiles are the windows whose error is judged.
const TILE: u32 = WINDOW;

/// How many contributions to other pixels a thread collects before it hands them over.
const COLLECTED: usize = 1 << 14;

/// A square part of the image (smaller at the right and lower border).
pub(super) struct Tile<'a> {
    pub origin: (u32, u32),
    pub width: u32,
    pub pixels: Vec<PixelEstimate>,
    pub chain: Option<Chain<'a>>,
    /// Whether it needs no more samples.
    pub good_enough: bool,
}

impl Tile<'_> {
    /// Where its pixels are in the image, in their order.
    pub fn positions(&self) -> impl Iterator<Item = (u32, u32)> + use<> {
        let ((x, y), width) = (self.origin, self.width);
        (0..self.pixels.len() as u32).map(move |k| (x + k % width, y + k / width))
    }
}

/// Cuts an image into tiles, row by row from the top left.
pub(super) fn tiles((width, height): (u32, u32), kernel: &dyn AnyKernel) -> Vec<Mutex<Tile<'_>>> {
    let mut tiles = Vec::new();
    for y in (0..height).step_by(TILE as usize) {
        for x in (0..width).step_by(TILE as usize) {
            let (columns, rows) = (TILE.min(width - x), TILE.min(height - y));
            let pixels = vec![PixelEstimate::default(); (columns * rows) as usize];
            let chain = kernel.chain(tiles.len());
            let tile = Tile { origin: (x, y), width: columns, pixels, chain, good_enough: false };
            tiles.push(Mutex::new(tile));
        }
    }
    tiles
}

impl Job<'_> {
    /// [`Job::run_pass`] for a tile: whether any pixel got a sample.
    pub(super) fn run_tile(
        &self,
        tile: &mut Tile<'_>,
        samples: u32,
        worker: &mut Worker<'_>,
    ) -> bool {
        if tile.good_enough {
            return false;
        }
        let (target, mut moved) = (self.done + samples, false);
        let mut added = Added::new(self, tile);
        'pixels: for (position, pixel) in tile.positions().zip(&mut tile.pixels) {
            if self.observer.cancelled() {
                break;
            }
            for number in pixel.count()..target {
                added.splats.begin();
                let value = worker(position, number, &mut added.splats);
                if added.splats.is_given_up() {
                    break 'pixels;
                }
                moved = true;
                let value = added.own(position, value);
                match &mut tile.chain {
                    None => pixel.add(value),
                    Some(chain) => {
                        chain.step(&mut added.splats);
                        pixel.add_chained(value);
                    }
                }
            }
            if added.splats.len() > COLLECTED {
                added.hand_over_splats();
            }
        }
        added.hand_over();
        moved
    }
}

/// What the samples of a tile add to other pixels than their own, until it is handed over.
struct Added<'j, 'a> {
    job: &'j Job<'a>,
    splats: Splats,
    /// What pixels have of samples that are shared, if they are.
    gathered: Option<Gathered>,
    /// The largest value of a sample that others get a share of.
    most_shared: f64,
    /// How many samples had no value.
    invalid: u64,
}

impl<'j, 'a> Added<'j, 'a> {
    fn new(job: &'j Job<'a>, tile: &Tile<'_>) -> Self {
        let mut splats = Splats::new(job.layered);
        splats.is_shared = job.filter.is_some();
        let sums = job.splats.as_ref().map(lock);
        let (scale, most) = sums.map_or((1.0, f64::MAX), |sums| (sums.scale(), sums.most()));
        let gathered = job.filter.map(|filter| {
            let rows = tile.pixels.len() as u32 / tile.width;
            Gathered::new(filter, job.size, tile.origin, (tile.width, rows)).scaled_by(scale)
        });
        Added { job, splats, gathered, most_shared: most.min(f32::MAX.into()), invalid: 0 }
    }

    /// What a sample of a pixel gives that pixel, by itself; others have their shares of it from now on.
    fn own(&mut self, position: (u32, u32), value: [f32; 3]) -> [f32; 3] {
        // What others get a share of may not be beyond all measure.
        let most = match self.splats.shares() {
            Some(_) => self.most_shared,
            None => f32::MAX.into(),
        };
        let valid = value.iter().all(|v| f64::from(v.abs()) <= most);
        let value = if valid { value } else { [0.0; 3] };
        self.invalid += u64::from(!valid);
        match (&mut self.gathered, self.splats.shares()) {
            (Some(gathered), Some(shares)) => {
                gathered.add(shares, value);
                let counts = shares.own().map_or(1.0, |(_, counts)| counts);
                if gathered.is_full() {
                    hand_over_gathered(self.job, gathered);
                }
                value.map(|v| v * counts)
            }
            (Some(_), None) => {
                self.splats.add(position, value);
                value
            }
            _ => value,
        }
    }

    fn hand_over_splats(&mut self) {
        if let (Some(sums), false) = (&self.job.splats, self.splats.is_empty()) {
            lock(sums).take(&mut self.splats);
        }
    }

    fn hand_over(mut self) {
        self.hand_over_splats();
        self.gathered.iter_mut().for_each(|gathered| hand_over_gathered(self.job, gathered));
        self.job.invalid.fetch_add(self.invalid, Ordering::Relaxed);
    }
}

fn hand_over_gathered(job: &Job<'_>, gathered: &mut Gathered) {
    if let Some(sums) = &job.splats {
        gathered.hand_over(&mut lock(sums));
    }
}
