//! Inputs, and what is declared of them: their ranges and names, unit vectors, frames.

use super::{Graph, Id, Leaf, Node, TurnedVector};
use crate::interval::Interval;

impl Graph {
    /// Declares an input with its printed name and the interval of its values.
    pub fn leaf(&mut self, leaf: Leaf, name: &str, range: Interval) -> Id {
        self.leaf_ranges.insert(leaf, range);
        self.names.insert(leaf, name.to_owned());
        self.intern(Node::Leaf(leaf))
    }

    /// The expression of a declared input.
    pub fn get_leaf(&mut self, leaf: Leaf) -> Id {
        self.intern(Node::Leaf(leaf))
    }

    /// Whether an expression is this input.
    pub fn is_leaf(&self, id: Id, leaf: Leaf) -> bool {
        *self.node(id) == Node::Leaf(leaf)
    }

    /// The interval that an input was declared with.
    pub fn leaf_range(&self, leaf: Leaf) -> Interval {
        self.leaf_ranges.get(&leaf).copied().unwrap_or(Interval::ALL)
    }

    /// The printed name of an input.
    pub fn name(&self, leaf: Leaf) -> &str {
        self.names.get(&leaf).map_or("?", String::as_str)
    }

    /// Declares that the squares of three expressions add up to one.
    pub fn declare_unit(&mut self, coordinates: [Id; 3]) {
        self.units.push(coordinates);
    }

    /// The triples that were declared so.
    pub fn units(&self) -> &[[Id; 3]] {
        &self.units
    }

    /// Notes three expressions that the author calls a vector.
    pub fn note_vector(&mut self, coordinates: [Id; 3]) {
        if !self.vectors.contains(&coordinates) {
            self.vectors.push(coordinates);
        }
    }

    /// The vectors that were noted, in the order in which they were made.
    pub fn vectors(&self) -> &[[Id; 3]] {
        &self.vectors
    }

    /// Notes three vectors, perpendicular to each other and of unit length, that the body makes a frame of.
    pub fn note_frame(&mut self, columns: [[Id; 3]; 3]) {
        columns.iter().for_each(|column| self.note_vector(*column));
        if !self.made_frames.contains(&columns) {
            self.made_frames.push(columns);
        }
    }

    /// The frames that were noted.
    pub fn made_frames(&self) -> &[[[Id; 3]; 3]] {
        &self.made_frames
    }

    /// Notes that a vector is another one turned by a frame.
    pub fn note_turned(&mut self, turned: TurnedVector) {
        self.turned.push(turned);
    }

    /// The vectors that were noted as turned.
    pub fn turned(&self) -> &[TurnedVector] {
        &self.turned
    }
}
