//! Errors as they come in: the worst, the median, and where the worst was.

/// Errors of one kind.
#[derive(Clone, Debug)]
pub struct Tally {
    /// The worst error in units.
    pub worst: f64,
    /// The worst error over its condition number, which counts as one if it is less.
    pub worst_over: f64,
    /// Where `worst_over` was.
    pub at: String,
    /// How many errors there are of each size: eight bins for a factor of two, from a 16th of a unit.
    bins: Vec<u64>,
}

/// Bins for a factor of two.
const FINENESS: f64 = 8.0;
/// The logarithm of the least error that is told from none.
const LEAST: f64 = -4.0;

impl Default for Tally {
    fn default() -> Self {
        Tally { worst: 0.0, worst_over: 0.0, at: String::new(), bins: vec![0; 576] }
    }
}

impl Tally {
    /// Counts an error in units. The condition number is asked for only if it matters, with a limit above which
    /// it does not matter how large it is.
    pub fn add(
        &mut self,
        error: f64,
        condition: impl FnOnce(f64) -> f64,
        at: impl FnOnce() -> String,
    ) {
        let bin =
            if error > 0.0 { ((error.log2() - LEAST) * FINENESS).max(0.0) as usize } else { 0 };
        let last = self.bins.len() - 1;
        self.bins[bin.min(last)] += 1;
        self.worst = self.worst.max(error);
        if error > self.worst_over {
            let over = error / condition(error / self.worst_over).max(1.0);
            if over > self.worst_over {
                self.worst_over = over;
                self.at = at();
            }
        }
    }

    /// How many errors were counted.
    pub fn count(&self) -> u64 {
        self.bins.iter().sum()
    }

    /// The median, to within a tenth; NaN if nothing was counted.
    pub fn median(&self) -> f64 {
        let half = self.count().div_ceil(2);
        let mut below = 0;
        for (i, n) in self.bins.iter().enumerate() {
            below += n;
            if below >= half && below > 0 {
                return if i == 0 { 0.0 } else { (LEAST + (i as f64 + 0.5) / FINENESS).exp2() };
            }
        }
        f64::NAN
    }

    /// Adds the errors of another tally.
    pub fn merge(&mut self, other: &Tally) {
        self.worst = self.worst.max(other.worst);
        if other.worst_over > self.worst_over {
            self.worst_over = other.worst_over;
            self.at.clone_from(&other.at);
        }
        self.bins.iter_mut().zip(&other.bins).for_each(|(a, b)| *a += b);
    }
}
