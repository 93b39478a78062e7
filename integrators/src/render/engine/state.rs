//! The state of a render in progress, as it is kept to go on later. Whatever has been computed is in it, also of a
//! pass that was cut short: pixels know how many samples they have, and sums have no order.

use std::io::{self, Read, Write};
use std::sync::atomic::Ordering;
use std::time::Instant;

use super::{Job, Tile, lock};
use crate::render::Budget;
use crate::render::splats::SplatSums;
use crate::stored::{Stored, malformed};
use crate::work::Work;

impl Job<'_> {
    /// Writes the state.
    pub(super) fn save(&self, to: &mut dyn Write) -> io::Result<()> {
        (self.size.0, self.size.1, self.layered, self.splats.is_some()).store(to)?;
        (self.done, self.good_enough, self.invalid.load(Ordering::Relaxed)).store(to)?;
        (self.sampling(), self.sampled()).store(to)?;
        self.batches.store(to)?;
        self.tiles.iter().try_for_each(|tile| lock(tile).save(to))?;
        if let Some(sums) = &self.splats {
            lock(sums).store(to)?;
        }
        self.kernel.save(to)
    }

    /// Takes over what [`Job::save`] has written, and nothing may follow it.
    pub(super) fn restore(&mut self, from: &mut dyn Read) -> io::Result<()> {
        let of = <(u32, u32, usize, bool)>::load(from)?;
        if of != (self.size.0, self.size.1, self.layered, self.splats.is_some()) {
            return Err(malformed("it is that of another image"));
        }
        let (done, good_enough, invalid) = Stored::load(from)?;
        let earlier = <(f64, Work)>::load(from)?;
        self.batches = Stored::load(from)?;
        self.tiles.iter().try_for_each(|tile| lock(tile).restore(from))?;
        if let Some(sums) = &self.splats {
            *lock(sums) = SplatSums::load(from)?;
        }
        self.kernel.restore(from)?;
        // Asking for more has the end of a compressed file checked too.
        if from.read(&mut [0])? > 0 {
            return Err(malformed("it is longer than it should be"));
        }
        (self.done, self.good_enough, self.earlier) = (done, good_enough, earlier);
        self.invalid.store(invalid, Ordering::Relaxed);
        // What was good enough may not be for the target of this render.
        if let Budget::Error(limit) = self.budget
            && self.good_enough
        {
            self.judge(&self.film(), limit);
        }
        // What it took to get here is no part of what comes.
        (self.start, self.before) = (Instant::now(), Work::here());
        Ok(())
    }
}

impl Tile<'_> {
    fn save(&self, to: &mut dyn Write) -> io::Result<()> {
        self.good_enough.store(to)?;
        self.pixels.iter().try_for_each(|pixel| pixel.store(to))?;
        self.chain.iter().try_for_each(|chain| chain.save(to))
    }

    fn restore(&mut self, from: &mut dyn Read) -> io::Result<()> {
        self.good_enough = Stored::load(from)?;
        for pixel in &mut self.pixels {
            *pixel = Stored::load(from)?;
        }
        self.chain.iter_mut().try_for_each(|chain| chain.restore(from))
    }
}
