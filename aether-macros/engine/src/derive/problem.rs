//! What is derived, and what from.

use super::back::Image;
use super::{Accuracy, Border, Signs};
use crate::expr::{Graph, Id, Leaf};
use crate::parse::{Made, Segment, Space, Stage, Test};
use crate::points::Kind;

/// What the type of the result guarantees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// The whole of R^n.
    Free,
    /// A unit vector, guaranteed by the type.
    Direction,
    /// A point of a surface that the type identifies.
    Identified,
    /// A manifold that only the map itself knows: membership is tested in every density.
    Embedded,
}

/// One point of a result.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    /// What its type guarantees.
    pub target: Target,
    /// How many coordinates it has.
    pub coordinates: usize,
    /// The dimension of its space.
    pub dimension: usize,
}

impl Part {
    /// A point of a space.
    pub fn of(space: &Space) -> Part {
        let (dimension, coordinates) = space.dimensions();
        let target = match space {
            Space::Direction => Target::Direction,
            Space::SurfacePoint => Target::Identified,
            Space::Embedded { .. } => Target::Embedded,
            _ => Target::Free,
        };
        Part { target, coordinates, dimension }
    }
}

/// An item as parsed: a map from unknowns to outputs.
pub struct Problem {
    /// The expressions.
    pub graph: Graph,
    /// The output coordinates.
    pub outputs: Vec<Id>,
    /// The unknowns: uniforms, or coordinates of a map's argument.
    pub unknowns: Vec<Leaf>,
    /// What the argument of a map is; `None` for a sampler.
    pub argument: Option<Kind>,
    /// The scalar parameters in groups.
    pub kinds: Vec<Kind>,
    /// Those that are made of others.
    pub made: Made,
    /// Parameters that are frames, by columns.
    pub frames: Vec<[[Id; 3]; 3]>,
    /// The points that the result consists of; mostly a single one.
    pub parts: Vec<Part>,
    /// Expressions that must be positive for there to be a result.
    pub requirements: Vec<Id>,
    /// What holds on this way through the branches of the body.
    pub guards: Vec<Test>,
    /// What has to hold of the parameters for this piece to have any points.
    pub existence: Vec<Test>,
    /// The parameters that are zero there, which the expressions do not mention.
    pub vanishing: Vec<Leaf>,
    /// What is declared of the parameters together.
    pub relations: Vec<Test>,
    /// Expressions of the unknowns whose sizes are lengths in terms of the point.
    pub lengths: Vec<(Id, Id)>,
    /// The same in two steps, to be tried where there is no inverse otherwise.
    pub stages: Vec<Stage>,
    /// The segments of the uniforms that the unknowns run over, where these are not all of [0, 1).
    pub segments: Vec<Option<Segment>>,
    /// Whether no inverse was found, with a numerical one asked for only where functions are monotone.
    pub stuck: bool,
}

impl Problem {
    /// Whether the result is one point, a direction.
    pub fn is_direction(&self) -> bool {
        matches!(self.parts[..], [Part { target: Target::Direction, .. }])
    }

    /// The parts with the places of their coordinates.
    pub fn placed(&self) -> Vec<(Part, std::ops::Range<usize>)> {
        let mut first = 0;
        let place = |part: &Part| {
            let range = first..first + part.coordinates;
            first = range.end;
            (*part, range)
        };
        self.parts.iter().map(place).collect()
    }
}

/// One preimage, ready to be emitted.
pub struct Preimage {
    /// The unknowns, as accurate as they can be had.
    pub unknowns: Vec<Id>,
    /// The unknowns in a shorter form, good enough to see whether they lie in [0, 1).
    pub tested: Vec<Id>,
    /// Must be at least zero.
    pub conditions: Vec<Id>,
    /// Must be greater than zero.
    pub requirements: Vec<Id>,
    /// The density of a sampler's point by way of this preimage.
    pub density: Id,
    /// The image of the unknowns, where that has to be compared with the point, if it is short.
    pub back: Option<Image>,
    /// For each unknown, where a coordinate by itself tells whether it lies in [0, 1].
    pub borders: Vec<Option<Border>>,
    /// For each unknown, the signs that tell whether it lies in [0, 1), if these are shorter.
    pub signs: Vec<Option<Signs>>,
    /// The conditions that do not follow from where coordinates lie between their borders.
    pub open: Vec<Id>,
    /// Those of them that do not follow from signs either.
    pub asked: Vec<Id>,
}

impl Preimage {
    /// All that is computed of a point to see whether it has this preimage, and with which density.
    pub(super) fn expressions(&mut self) -> impl Iterator<Item = &mut Id> {
        let lists = [&mut self.unknowns, &mut self.tested, &mut self.conditions];
        let more = [&mut self.requirements, &mut self.open, &mut self.asked];
        let borders = self.borders.iter_mut().flatten().flat_map(Border::expressions);
        let signs = self.signs.iter_mut().flatten().flat_map(Signs::expressions);
        let lists = lists.into_iter().chain(more).flatten();
        lists.chain(borders).chain(signs).chain([&mut self.density])
    }
}

/// Everything that was derived.
pub struct Derived {
    /// The outputs in their most accurate form.
    pub forward: Vec<Id>,
    /// The preimages of a point.
    pub preimages: Vec<Preimage>,
    /// √det(JᵀJ) in terms of the unknowns.
    pub volume: Id,
    /// One over it: the density of a sample by its uniforms.
    pub own_density: Id,
    /// Whether a preimage must be mapped forward again to see that it is one.
    pub check_forward: bool,
    /// Whether the map has no value at some of the points that are tried, as a root of what is negative has none.
    pub undefined: bool,
    /// The scalar parameters that must not be exactly zero, because the formulas have only a limit
    /// there; in no order, and one may be named twice.
    pub limits: Vec<u8>,
    /// Whether the map keeps the orientation of its unknowns, where it is the same at all points that are tried.
    pub orientation: Option<bool>,
    /// On how many pieces an equation is solved numerically; zero if none is that turns back.
    pub pieces: usize,
    /// By how much it is off at points inside of the domain, in `f64`.
    pub accuracy: Accuracy,
    /// The derivation, a line a step.
    pub steps: Vec<String>,
}
