//! What is known of the variables in scope.

use std::collections::{BTreeMap, BTreeSet};

use syn::{Expr, Ident};

use super::names::mentioned;

/// What is known of a value.
#[derive(Clone, Copy, Debug, Default)]
pub struct Facts {
    /// It depends on what was drawn, and cannot be read from the vertex.
    pub random: bool,
    /// It depends on the path before.
    pub path: bool,
    /// It depends on the outcome of a choice that is not identified from the vertex.
    pub choice: bool,
    /// It is read from the vertex.
    pub constant: bool,
    /// It came from a ray that starts at the path.
    pub ray: bool,
    /// The locally constant calls that it was made from, a bit for each.
    pub calls: u128,
}

impl Facts {
    /// What is known of a value made from both.
    pub fn and(self, other: Facts) -> Facts {
        Facts {
            random: self.random || other.random,
            path: self.path || other.path,
            choice: self.choice || other.choice,
            constant: self.constant || other.constant,
            ray: self.ray || other.ray,
            calls: self.calls | other.calls,
        }
    }
}

/// A decision on the way to a leaf.
#[derive(Clone, Copy, PartialEq)]
pub struct Turn {
    /// Which branch, in order of appearance.
    pub branch: usize,
    /// Which arm of it.
    pub arm: usize,
    /// Whether it depends on a choice that is not identified.
    pub choice: bool,
}

/// What is in scope at some place of the body.
#[derive(Clone, Default)]
pub struct Scope {
    /// What is known of each variable.
    pub facts: BTreeMap<String, Facts>,
    /// Random points, each with the points that it is mapped from.
    pub points: BTreeMap<String, BTreeSet<String>>,
    /// The draw on the way to here.
    pub drawn: Option<Ident>,
    /// Whether that is an atom.
    pub atom: bool,
    /// Names that code evaluated after inversion will look up.
    pub needed: BTreeSet<String>,
    /// The decisions on the way to here.
    pub turns: Vec<Turn>,
}

impl Scope {
    /// What is known of a value made from these variables.
    pub fn of(&self, names: &BTreeSet<String>) -> Facts {
        let known = names.iter().filter_map(|name| self.facts.get(name));
        known.fold(Facts::default(), |all, facts| all.and(*facts))
    }

    /// What is known of the value of an expression.
    pub fn of_expr(&self, expr: &Expr) -> Facts {
        self.of(&mentioned(expr))
    }
}
