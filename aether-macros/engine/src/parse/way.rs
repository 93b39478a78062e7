//! One way through the comparisons of a body, and the next one.

use std::collections::BTreeMap;

use super::Test;
use super::steps::Span;
use crate::expr::{Id, Leaf};

/// A body may fall into this many pieces.
pub(super) const MAX_PIECES: usize = 32;

/// The outcome of one comparison, and whether the other one is possible.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outcome {
    pub(super) holds: bool,
    pub(super) open: bool,
    /// Whether that is proven, so that no point has to be asked.
    pub(super) proven: bool,
    /// Whether there is no point where it comes out otherwise.
    pub(super) required: bool,
}

/// One way through the comparisons of a body.
#[derive(Clone, Debug, Default)]
pub struct Way {
    pub(super) outcomes: Vec<Outcome>,
    pub(super) position: usize,
    /// Tests that are implied by the ranges of this reading's inputs, by their place.
    pub(super) implied: Vec<usize>,
    /// What has to hold for a point to take this way, with the place of the comparison.
    pub(super) tests: Vec<(usize, Test)>,
    /// Comparisons made on this reading: difference, whether strict, and the outcome.
    pub(super) made: Vec<(Id, bool, bool)>,
    /// What each `floor` passes, by the place of its first comparison and the number of those before it, of which some make no
    /// comparison: later readings know more of its argument, and have to make the same comparisons.
    pub(super) spans: BTreeMap<(usize, usize), Span>,
    /// How many there were on this reading.
    pub(super) floors: usize,
    /// What follows for the parameters if any point takes this way.
    pub(super) existence: Vec<Test>,
    /// Whether a comparison was found to have the other outcome wherever this way leads.
    pub(super) impossible: bool,
    /// What is zero wherever this way leads, by a comparison that holds nowhere else.
    pub(super) zeros: Vec<Id>,
    /// Parameters that are zero wherever this way leads.
    pub(super) vanishing: Vec<Leaf>,
}

impl Way {
    /// The same way again, from the start, where some of the tests need not be made.
    pub(super) fn again(&self, implied: Vec<usize>) -> Way {
        Way {
            outcomes: self.outcomes.clone(),
            implied,
            spans: self.spans.clone(),
            vanishing: self.vanishing.clone(),
            ..Way::default()
        }
    }

    /// Whether it has led through no comparison that may come out otherwise.
    pub(super) fn is_straight(&self) -> bool {
        self.outcomes.is_empty()
    }

    /// The next way, in the order of a depth-first search; `None` after the last.
    pub(super) fn next(mut self) -> Option<Way> {
        while let Some(last) = self.outcomes.pop() {
            if last.open && last.holds {
                let place = self.outcomes.len();
                self.outcomes.push(Outcome {
                    holds: false,
                    open: false,
                    proven: false,
                    required: false,
                });
                self.spans.retain(|(begin, _), _| *begin <= place);
                return Some(self.again(vec![]));
            }
        }
        None
    }
}
