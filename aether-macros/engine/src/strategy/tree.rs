//! The body of a strategy as a tree in which every path of execution ends in a leaf.

use syn::{Expr, Ident, Pat, Stmt, Type};

/// Statements, and how they end. What follows a branch is part of each of its arms.
pub struct Block<S, L> {
    /// In order of execution.
    pub steps: Vec<S>,
    /// What comes after them.
    pub end: End<S, L>,
}

/// The end of a [`Block`]: a leaf, or a branch.
pub enum End<S, L> {
    /// No next vertex.
    Stop,
    /// A next vertex.
    Vertex(L),
    /// The next vertex of another strategy.
    Delegate {
        /// The strategy.
        strategy: Expr,
        /// Its number among the vertices.
        number: usize,
    },
    /// `if`, also `if let`.
    If {
        /// The condition.
        condition: Expr,
        /// Whether the condition depends on what was drawn.
        late: bool,
        /// Where it holds.
        then: Box<Block<S, L>>,
        /// Where it does not.
        otherwise: Box<Block<S, L>>,
    },
    /// `match`.
    Match {
        /// What is matched.
        value: Expr,
        /// Patterns (with their guards) and what they lead to.
        arms: Vec<(Pat, Block<S, L>)>,
    },
}

/// The body as it is written.
pub type Body = Block<Step, Expr>;

/// A statement as it is written.
pub enum Step {
    /// A statement without special forms.
    Plain(Stmt),
    /// `let pat = value else { return stop(); };`
    LetElse {
        /// What is bound.
        pat: Pat,
        /// The value.
        value: Expr,
    },
    /// `let pat = form(..);`
    Bind {
        /// What is bound.
        pat: Pat,
        /// The special form.
        form: Form,
    },
}

/// A special form and its argument.
pub enum Form {
    /// `choose(distribution)`, `choose(distribution).identified_by(rule)`.
    Choose {
        /// The distribution.
        distribution: Expr,
        /// How to tell the outcome from the vertex.
        rule: Option<Expr>,
    },
    /// `draw(sampler)`.
    Draw(Expr),
    /// `atom(direction, measure)`, as the random variable that it is.
    Atom(Expr),
    /// `constant(call)`.
    Constant(Expr),
    /// `given(option)`.
    Given(Expr),
}

/// The body after analysis.
pub type Plan = Block<Action, Leaf>;

/// Two ways to yield atoms between which an unidentified choice decides, so that their atoms must not
/// be of the same kind. Only the types of strategies say which kinds they yield.
pub struct Apart {
    /// One strategy.
    pub strategy: Expr,
    /// The other way.
    pub other: Other,
}

/// What a strategy must be told apart from.
pub enum Other {
    /// An atom of the body itself, and whether it is a direction.
    Atom(bool),
    /// Another strategy.
    Strategy(Expr),
}

/// A statement after analysis.
pub enum Action {
    /// The same in sampling and density.
    Plain(Stmt),
    /// Depends on what was drawn: in a density it is evaluated after inversion.
    Late(Stmt),
    /// The same in sampling and density; no vertex if the pattern does not match.
    LetElse {
        /// What is bound.
        pat: Pat,
        /// The value.
        value: Expr,
    },
    /// A choice that is enumerated, or identified by a rule.
    Choose {
        /// What is bound to the item.
        pat: Pat,
        /// The distribution.
        distribution: Expr,
        /// How to tell the outcome from the vertex.
        rule: Option<Expr>,
        /// The number of the choice.
        number: usize,
    },
    /// A choice whose probabilities depend on what was drawn: its outcomes are enumerated (or
    /// identified by a rule) before inversion, and weighed after it.
    LateChoose {
        /// What is bound to the outcome.
        pat: Pat,
        /// The name of its index in the density.
        index: Ident,
        /// The distribution.
        distribution: Expr,
        /// How to tell the outcome from the vertex.
        rule: Option<Expr>,
        /// The number of the choice.
        number: usize,
    },
    /// A continuous random variable.
    Draw {
        /// Its value.
        name: Ident,
        /// Annotated type.
        ty: Option<Type>,
        /// The random variable.
        sampler: Expr,
    },
    /// A map of a random point.
    Map {
        /// The image.
        name: Ident,
        /// The map.
        map: Expr,
        /// The point that it is applied to.
        of: Ident,
    },
    /// A locally constant call.
    Constant {
        /// What is bound to its value.
        pat: Pat,
        /// The call.
        call: Expr,
        /// Its number.
        number: usize,
    },
    /// A deterministic value that may be missing.
    Given {
        /// What is bound to it.
        pat: Pat,
        /// The value.
        value: Expr,
    },
}

/// A next vertex.
pub struct Leaf {
    /// The expression that makes it.
    pub vertex: Expr,
    /// How it is distributed.
    pub kind: Kind,
    /// Whether it was found from the vertex before by a ray cast.
    pub visible: bool,
    /// Its number.
    pub number: usize,
}

/// How a vertex is distributed once the choices are made.
pub enum Kind {
    /// With the density of this random point.
    Density(Ident),
    /// It is at a fixed position.
    AtomPosition,
    /// It lies in a fixed direction from the vertex before: with a probability, or with the density of
    /// this point, the image of an atom of which it is stated.
    AtomDirection(Option<Ident>),
}

impl<S, L> Block<S, L> {
    /// Calls `visit` with each strategy that is delegated to.
    pub fn delegates<'a>(&'a self, visit: &mut impl FnMut(&'a Expr)) {
        match &self.end {
            End::Stop | End::Vertex(_) => {}
            End::Delegate { strategy, .. } => visit(strategy),
            End::If { then, otherwise, .. } => {
                then.delegates(visit);
                otherwise.delegates(visit);
            }
            End::Match { arms, .. } => arms.iter().for_each(|(_, arm)| arm.delegates(visit)),
        }
    }

    /// Calls `visit` with each statement of the tree, and then `leaf` with each vertex.
    pub fn walk(&self, visit: &mut impl FnMut(&S), leaf: &mut impl FnMut(&L)) {
        self.steps.iter().for_each(&mut *visit);
        match &self.end {
            End::Stop | End::Delegate { .. } => {}
            End::Vertex(vertex) => leaf(vertex),
            End::If { then, otherwise, .. } => {
                then.walk(visit, leaf);
                otherwise.walk(visit, leaf);
            }
            End::Match { arms, .. } => arms.iter().for_each(|(_, arm)| arm.walk(visit, leaf)),
        }
    }
}
