//! Errors as they come in: the worst, the median, and where the worst was.

use serde_json::{Value, json};

/// Errors of one kind.
#[derive(Clone, Debug)]
pub struct Tally {
    /// The worst error in units.
    pub worst: f64,
    /// The worst error over its condition number, which counts as one if it is less; to within four percent.
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
    /// An error over its condition number is not looked at if it is larger than the worst by no more than this factor:
    /// where a density and its condition number are the same everywhere, each point would be.
    pub const MORE: f64 = 1.04;

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
        let least = Self::MORE * self.worst_over;
        if error > least {
            let over = error / condition(error / least).max(1.0);
            if over > least {
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

    /// A tally without errors, which looks only at what is worse than all in this one.
    pub fn onward(&self) -> Tally {
        Tally { worst_over: self.worst_over, at: self.at.clone(), ..Tally::default() }
    }

    /// All that is known, for [`Tally::from_json`].
    pub(super) fn as_json(&self) -> Value {
        let counted = self.bins.iter().enumerate().filter(|(_, n)| **n > 0);
        let bins: Vec<[u64; 2]> = counted.map(|(i, n)| [i as u64, *n]).collect();
        json!({ "worst": self.worst, "over": self.worst_over, "at": self.at, "bins": bins })
    }

    pub(super) fn from_json(value: &Value) -> Option<Tally> {
        let mut tally = Tally {
            worst: value["worst"].as_f64()?,
            worst_over: value["over"].as_f64()?,
            at: value["at"].as_str()?.to_owned(),
            ..Tally::default()
        };
        for bin in value["bins"].as_array()? {
            *tally.bins.get_mut(bin[0].as_u64()? as usize)? = bin[1].as_u64()?;
        }
        Some(tally)
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
