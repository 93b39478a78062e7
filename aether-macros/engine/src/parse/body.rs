//! The statements and expressions of a body.

use std::collections::HashMap;

use proc_macro2::TokenStream;
use quote::{ToTokens, quote};
use syn::{BinOp, Block, Expr, Pat, Stmt};

use super::branch::Way;
use super::defined::Partial;
use super::made::Making;
use super::stages::Cut;
use super::{Domain, Options, Param, ParamKind, Segment, Source, Space, Test, Value};
use crate::diagnostics::Diagnostics;
use crate::expr::{Graph, Id, Leaf, UNKNOWNS};
use crate::interval::Interval;
use crate::points::Kind;
use crate::walk::{self, Bound, Look};

/// Reads a body into a graph.
pub struct Body<'a> {
    /// The expressions.
    pub graph: Graph,
    /// Conditions `require(…)`: expressions that must be positive.
    pub requirements: Vec<Id>,
    /// What functions that are not defined everywhere were taken of.
    pub(super) partial: Vec<Partial>,
    /// The way through the comparisons.
    pub way: Way,
    /// What the item computes once.
    pub(super) making: Making,
    /// What is declared of names of the body.
    pub(super) of_names: Vec<Domain>,
    /// How many blocks deep the statement is that is being read.
    pub(super) depth: usize,
    /// What is declared of the parameters together.
    pub(super) declared: Vec<Test>,
    pub(super) names: HashMap<String, Value>,
    /// The names of parameters, and whether they have come to stand for something else.
    parameters: HashMap<String, bool>,
    /// Whether the operands of a comparison are being read.
    pub(super) comparing: bool,
    /// What an early `return` gave.
    returned: Option<Value>,
    /// Numbers with a name that depend on the first parameter, in their order.
    pub(super) scalars: Vec<String>,
    /// Vectors with a name that depend on parameters alone.
    pub(super) vectors: Vec<(String, [Id; 3])>,
    /// Parameters that are whole numbers.
    pub(super) whole: Vec<Id>,
    /// What is read as inputs of their own.
    pub(super) cut: Cut,
    /// Such an unknown and what it stands for.
    pub(super) cuts: Vec<(Leaf, Id)>,
    /// Such a parameter and what it stands for.
    pub(super) constants_cut: Vec<(Leaf, Id)>,
    /// The name of the function that is read.
    pub(super) own_name: String,
    pub(super) bound: u8,
    pub(super) next_param: u8,
    errors: &'a mut Diagnostics,
}

impl<'a> Body<'a> {
    /// A reader that knows the first parameter and takes a way through the comparisons.
    pub fn new(
        graph: Graph,
        names: HashMap<String, Value>,
        way: Way,
        errors: &'a mut Diagnostics,
    ) -> Self {
        Body {
            graph,
            requirements: vec![],
            partial: vec![],
            way,
            making: Making::default(),
            of_names: vec![],
            depth: 0,
            declared: vec![],
            names,
            parameters: HashMap::new(),
            comparing: false,
            returned: None,
            scalars: vec![],
            vectors: vec![],
            whole: vec![],
            cut: Cut::default(),
            cuts: vec![],
            constants_cut: vec![],
            own_name: String::new(),
            bound: 0,
            next_param: 0,
            errors,
        }
    }

    /// Replaces uniforms by what maps the unit interval to their segments; the segments in the terms
    /// of this graph.
    pub(super) fn confine(
        &mut self,
        source: &Source,
        unknowns: &[Leaf],
        segments: &[Option<(Segment, &Graph)>],
    ) -> Vec<Option<Segment>> {
        let Source::Uniforms { name, .. } = source else { return vec![] };
        let g = &mut self.graph;
        let mut confined = Vec::new();
        let ids = unknowns
            .iter()
            .enumerate()
            .map(|(i, &leaf)| {
                let inner = g.get_leaf(leaf);
                let segment = segments.get(i).copied().flatten().map(|(s, from)| Segment {
                    low: g.import(from, s.low),
                    width: g.import(from, s.width),
                    closed: s.closed,
                });
                confined.push(segment);
                segment.map_or(inner, |s| {
                    let inside = g.mul(s.width, inner);
                    g.add(s.low, inside)
                })
            })
            .collect();
        self.names.insert(name.clone(), Value::Uniforms(ids));
        confined
    }

    /// The value of a body, by its last expression or by a `return` before it.
    pub fn result(&mut self, block: &Block) -> Option<Value> {
        let value = self.block(block);
        self.returned.take().or(value)
    }

    /// Records what an early `return` gives.
    pub(super) fn leave(&mut self, value: Value) {
        self.returned.get_or_insert(value);
    }

    /// Reports an error on tokens.
    pub fn error<T>(
        &mut self,
        tokens: impl ToTokens,
        message: impl core::fmt::Display,
    ) -> Option<T> {
        self.errors.error(tokens, message);
        None
    }

    pub(super) fn scalar_param(&mut self, name: &str, range: Interval) -> Id {
        let leaf = Leaf::Param(self.next_param);
        self.next_param += 1;
        self.graph.leaf(leaf, name, range)
    }

    /// Makes a parameter known under its name.
    pub fn declare_param(
        &mut self,
        p: &Param,
        options: &Options,
        kinds: &mut Vec<Kind>,
        frames: &mut Vec<[[Id; 3]; 3]>,
    ) {
        let name = p.name.to_string();
        self.parameters.insert(name.clone(), false);
        let coordinates = |body: &mut Self, n: usize, range| -> Vec<Id> {
            (0..n)
                .map(|i| body.scalar_param(&format!("{name}.{}", ["x", "y", "z"][i]), range))
                .collect()
        };
        let value = match p.kind {
            ParamKind::Scalar => {
                let declared = options.domain(&name);
                let domain = declared.map(|d| d.interval);
                let id = self.scalar_param(&name, domain.unwrap_or(Interval::ALL));
                kinds.push(match declared {
                    Some(d) if d.whole => {
                        self.whole.push(id);
                        Kind::Whole(d.interval)
                    }
                    _ => Kind::Scalar(domain),
                });
                Value::Scalar(id)
            }
            ParamKind::Vec2 | ParamKind::Vec3 => {
                let n = if p.kind == ParamKind::Vec2 { 2 } else { 3 };
                kinds.push(Kind::Vector(n));
                Value::Vector(coordinates(self, n, Interval::ALL))
            }
            ParamKind::Direction => {
                kinds.push(Kind::Direction);
                let v = coordinates(self, 3, Interval::new(-1.0, 1.0));
                self.graph.declare_unit([v[0], v[1], v[2]]);
                Value::Vector(v)
            }
            ParamKind::Mat3 | ParamKind::Frame => {
                let is_frame = p.kind == ParamKind::Frame;
                let range = if is_frame { Interval::new(-1.0, 1.0) } else { Interval::ALL };
                let columns: [Vec<Id>; 3] = ["x", "y", "z"].map(|c| {
                    let element = |i: usize| format!("{name}.{c}{}", ["x", "y", "z"][i]);
                    (0..3).map(|i| self.scalar_param(&element(i), range)).collect()
                });
                if is_frame {
                    kinds.push(Kind::Frame);
                    frames.push([0, 1, 2].map(|c| [columns[c][0], columns[c][1], columns[c][2]]));
                } else {
                    kinds.push(Kind::Matrix);
                }
                Value::Matrix(columns)
            }
            ParamKind::Identity => {
                let ident = &p.name;
                Value::Opaque(quote!(self.#ident))
            }
        };
        self.names.insert(name, value);
    }

    /// The value of a block.
    pub fn block(&mut self, block: &Block) -> Option<Value> {
        let saved = self.names.clone();
        self.depth += 1;
        let mut result = None;
        let mut failed = false;
        let last = block.stmts.len().saturating_sub(1);
        for (i, stmt) in block.stmts.iter().enumerate() {
            if self.returned.is_some() {
                break;
            }
            match stmt {
                Stmt::Local(local) => failed |= self.local(local).is_none(),
                Stmt::Expr(Expr::Call(call), Some(_)) if is_call(call, "require") => {
                    failed |= self.require(call).is_none();
                }
                Stmt::Expr(e, None) if i == last => result = self.expr(e),
                Stmt::Expr(Expr::Return(r), _) => {
                    let value = r.expr.as_ref().and_then(|e| self.expr(e));
                    failed |= value.is_none();
                    self.returned = self.returned.take().or(value);
                }
                Stmt::Expr(e @ (Expr::If(_) | Expr::Match(_)), None) if i < last => {
                    failed |= self.expr(e).is_none();
                }
                Stmt::Expr(e @ (Expr::If(_) | Expr::Match(_)), Some(_)) => {
                    failed |= self.expr(e).is_none();
                }
                Stmt::Expr(e @ (Expr::ForLoop(_) | Expr::While(_) | Expr::Loop(_)), _) => {
                    failed = true;
                    let _ = self.expr(e);
                }
                Stmt::Item(syn::Item::Use(_)) => {}
                Stmt::Macro(m) => {
                    failed = true;
                    let _ = self
                        .expr(&Expr::Macro(syn::ExprMacro { attrs: vec![], mac: m.mac.clone() }));
                }
                Stmt::Expr(e, semicolon) if self.errors.is_empty() || i < last => {
                    failed = true;
                    self.statement(e, semicolon.is_some() && i == last);
                }
                Stmt::Expr(..) => failed = true,
                other => {
                    failed = true;
                    self.errors.error(other, "a body is a chain of `let`s and a result; this statement has no place in it: move it out of the function");
                }
            }
        }
        self.names = saved;
        self.depth -= 1;
        if failed {
            return None;
        }
        if self.returned.is_some() {
            return Some(Value::Unit);
        }
        if result.is_none() && matches!(block.stmts.last(), Some(Stmt::Expr(_, Some(_))) | None) {
            return Some(Value::Unit);
        }
        if result.is_none() && self.errors.is_empty() {
            self.errors.error(
                block,
                "this block has no result: end it with the point, without a semicolon",
            );
        }
        result
    }

    /// What is wrong with an expression as a statement.
    fn statement(&mut self, e: &Expr, last: bool) {
        let assigns = match e {
            Expr::Assign(_) => true,
            Expr::Binary(b) => {
                let text = b.op.to_token_stream().to_string();
                text.len() > 1
                    && text.ends_with('=')
                    && !matches!(text.as_str(), "==" | "<=" | ">=" | "!=")
            }
            _ => false,
        };
        let message = if assigns {
            "values do not change here, so that every name stands for one formula: use a new `let` with a new name"
        } else if last {
            "the result of the function is its last expression: leave the semicolon after it away"
        } else {
            "a body is a chain of `let`s and a result, and a value that is not used has no place in it: give it a name with `let`, or leave it away"
        };
        self.errors.error(e, message);
    }

    fn local(&mut self, local: &syn::Local) -> Option<()> {
        let Some(init) = &local.init else {
            let _ = self.bind(&local.pat, Value::Unknown);
            return self.error(local, "give this name its value at once, so that it stands for one formula: `let r = …;`, also `let r = if … { … } else { … };`");
        };
        if init.diverge.is_some() {
            self.bind_names(&local.pat);
            return self.error(local, "`let … else` has no meaning here, because every value of a body exists: write `let x = …;`. Where there is no sample, `return None;` from a function that returns an `Option`");
        }
        self.name_constant(local, &init.expr);
        let mut value = self.expr(&init.expr);
        if let (Some(Value::Unit), None) = (&value, &self.returned) {
            self.errors.error(&init.expr, "this has no value on one way through it: an `if` needs an `else`, and a block ends with its value, without a semicolon");
            value = None;
        }
        let found = value.is_some();
        if let Pat::Ident(name) = &local.pat {
            let name = name.ident.to_string();
            match &mut value {
                Some(Value::Scalar(id)) => *id = self.named_number(&name, *id),
                Some(Value::Vector(v)) => *v = self.named_vector(&name, v),
                _ => {}
            }
        }
        // Names are bound in any case, so that one mistake is reported once.
        self.bind(&local.pat, value.unwrap_or(Value::Unknown))?;
        found.then_some(())
    }

    /// The value that a named number is read with.
    fn named_number(&mut self, name: &str, value: Id) -> Id {
        if !self.graph.has(value, UNKNOWNS) {
            return value;
        }
        self.scalars.push(name.to_owned());
        if !self.cut.numbers.iter().any(|c| c == name) {
            return value;
        }
        let leaf = Leaf::Unknown(self.cut.first + self.cuts.len() as u8);
        self.cuts.push((leaf, value));
        self.graph.leaf(leaf, name, self.graph.range(value))
    }

    /// The coordinates that a named vector is read with.
    fn named_vector(&mut self, name: &str, value: &[Id]) -> Vec<Id> {
        let &[x, y, z] = value else { return value.to_vec() };
        if value.iter().any(|id| self.graph.has(*id, UNKNOWNS)) {
            return value.to_vec();
        }
        self.vectors.push((name.to_owned(), [x, y, z]));
        if !self.cut.frame.iter().any(|c| c == name) {
            return value.to_vec();
        }
        let axes = ["x", "y", "z"].iter().zip(value);
        axes.map(|(axis, &id)| {
            let leaf = Leaf::Param(super::stages::FIRST_CONSTANT + self.constants_cut.len() as u8);
            self.constants_cut.push((leaf, id));
            self.graph.leaf(leaf, &format!("{name}.{axis}"), Interval::new(-1.0, 1.0))
        })
        .collect()
    }

    /// Makes the names of a pattern known without values, so that one mistake is reported once.
    fn bind_names(&mut self, pat: &Pat) {
        let mut bound = Bound::default();
        walk::pat(&mut bound, pat);
        self.names.extend(bound.0.into_iter().map(|name| (name, Value::Unknown)));
    }

    pub(super) fn bind(&mut self, pat: &Pat, value: Value) -> Option<()> {
        match (pat, value) {
            (Pat::Ident(p), value) => {
                self.parameters.entry(p.ident.to_string()).and_modify(|shadowed| *shadowed = true);
                if p.subpat.is_some() || p.by_ref.is_some() || p.mutability.is_some() {
                    self.names.insert(p.ident.to_string(), value);
                    return self
                        .error(p, "values do not change here, so that every name stands for one formula: use a new `let` with a new name");
                }
                self.names.insert(p.ident.to_string(), value);
                Some(())
            }
            (Pat::Type(p), value) => self.bind(&p.pat, value),
            (Pat::Paren(p), value) => self.bind(&p.pat, value),
            (Pat::Wild(_), _) => Some(()),
            (Pat::Tuple(p), Value::Unknown) => {
                let values = vec![Value::Unknown; p.elems.len()];
                self.bind_each(&p.elems, values)
            }
            (Pat::Tuple(p), Value::Tuple(values)) if p.elems.len() == values.len() => {
                self.bind_each(&p.elems, values)
            }
            (Pat::Slice(p), Value::Uniforms(ids)) if p.elems.len() == ids.len() => {
                self.bind_each(&p.elems, ids.into_iter().map(Value::Scalar).collect())
            }
            (pat, value) => {
                let what = value.describe();
                self.error(pat, format!("{what} does not fit this pattern"))
            }
        }
    }

    /// Binds all parts of a pattern, also those after one that is wrong.
    fn bind_each(
        &mut self,
        parts: &syn::punctuated::Punctuated<Pat, syn::Token![,]>,
        values: Vec<Value>,
    ) -> Option<()> {
        let mut bound = Some(());
        for (part, value) in parts.iter().zip(values) {
            bound = self.bind(part, value).and(bound);
        }
        bound
    }

    /// `require(a > b)`: the point exists only where it holds.
    fn require(&mut self, call: &syn::ExprCall) -> Option<()> {
        let [condition] = &call.args.iter().collect::<Vec<_>>()[..] else {
            return self.error(call, "`require` takes one condition: `require(t > 0.0)`");
        };
        self.require_all(condition)
    }

    /// One comparison, or several with `&&` between them.
    fn require_all(&mut self, condition: &Expr) -> Option<()> {
        let b = match condition {
            Expr::Paren(inner) => return self.require_all(&inner.expr),
            Expr::Binary(b) if matches!(b.op, BinOp::And(_)) => {
                let (left, right) = (self.require_all(&b.left), self.require_all(&b.right));
                return left.and(right);
            }
            Expr::Binary(b) if !matches!(b.op, BinOp::Or(_)) => b,
            _ => return self.error(condition, "`require` takes comparisons of numbers, with `&&` between them: `require(t > 0.0 && t < 1.0)`. For anything else return an `Option`, and `None` where there is no point"),
        };
        let (left, right) = (self.scalar(&b.left)?, self.scalar(&b.right)?);
        let difference = match b.op {
            BinOp::Gt(_) => self.graph.sub(left, right),
            BinOp::Lt(_) => self.graph.sub(right, left),
            _ => return self.error(b.op, "`require` takes `>` or `<`"),
        };
        self.requirements.push(difference);
        Some(())
    }

    /// Whether tokens mention a name that depends on the first parameter.
    pub fn depends(&self, tokens: &impl ToTokens) -> bool {
        let open = |id: &Id| self.graph.has(*id, UNKNOWNS);
        let mut found = false;
        each_name(tokens.to_token_stream(), &mut |name| {
            found |= self.names.get(&name).is_some_and(|v| match v {
                Value::Scalar(id) => open(id),
                Value::Uniforms(_) => true,
                v => v.vector().is_some_and(|v| v.iter().any(open)),
            });
        });
        found
    }

    /// A value computed once by plain Rust code from the parameters.
    pub fn precomputed(&mut self, code: &Expr) -> Option<Value> {
        struct Shadowed<'n>(&'n HashMap<String, bool>, Option<String>);
        impl Look for Shadowed<'_> {
            fn name(&mut self, name: &proc_macro2::Ident) {
                let name = name.to_string();
                if self.0.get(&name) == Some(&true) {
                    self.1 = Some(name);
                }
            }
        }
        let mut shadowed = Shadowed(&self.parameters, None);
        walk::expr(&mut shadowed, code);
        if let Some(name) = shadowed.1 {
            return self.error(
                code,
                format!("`{name}` is no longer the parameter here, and `precomputed` reads parameters alone: give what the body makes another name"),
            );
        }
        let name = self.making.name.take();
        let domain = name.as_ref().and_then(|name| self.domain_of_name(name));
        let range = domain.as_ref().map_or(Interval::ALL, |d| d.interval);
        let kind = Kind::Scalar(domain.as_ref().map(|d| d.interval));
        let constant = (name, kind, code.to_token_stream(), None);
        match self.constant(constant, domain, range) {
            Some(ids) => Some(Value::Scalar(ids[0])),
            None => self.error(
                code,
                "this is one number more than an item can keep: give it fewer parameters",
            ),
        }
    }

    /// The coordinates of the result, for the space that the signature promises, and the identities of
    /// its points on surfaces.
    pub(super) fn outputs(
        &mut self,
        value: &Value,
        space: &Space,
        block: &Block,
    ) -> Option<(Vec<Id>, Vec<TokenStream>)> {
        let found = self.coordinates(value, space, block)?;
        if found.0.iter().all(|o| !self.graph.has(*o, UNKNOWNS)) {
            let at = block.stmts.last().map(ToTokens::to_token_stream).unwrap_or_default();
            return self.error(at, "on one way through the body the result does not depend on the first parameter: it is a single point (an atom), with a probability and no density. Of a sampler return `Mixed`, with `Mixed::Atom(0, point)` there and `Mixed::Continuous(x)` elsewhere. Or return `None` there, from a function that returns an `Option`, and let a `#[strategy]` choose between the point and the rest");
        }
        Some(found)
    }

    /// The same of a point that may be a single one.
    pub(super) fn coordinates(
        &mut self,
        value: &Value,
        space: &Space,
        block: &Block,
    ) -> Option<(Vec<Id>, Vec<TokenStream>)> {
        let at = block.stmts.last().map(ToTokens::to_token_stream).unwrap_or_default();
        let (mut outputs, mut identities) = (Vec::new(), Vec::new());
        let joint = match (space, value) {
            (Space::Joint(parts), Value::Tuple(values)) if parts.len() == values.len() => {
                Some(parts.iter().zip(values).map(|(s, v)| part(s, v)).collect())
            }
            (Space::Joint(_), _) => None,
            _ => Some(vec![part(space, value).or_else(|| self.direction(space, value))]),
        };
        let found: Option<Vec<_>> = joint.and_then(|parts: Vec<_>| parts.into_iter().collect());
        let Some(found) = found else {
            let what = value.describe();
            if let Space::Joint(parts) = space {
                let count = parts.len();
                let found = match value {
                    Value::Tuple(values) if values.len() != count => {
                        format!("a tuple of {}", values.len())
                    }
                    Value::Tuple(_) => "a tuple of others".to_owned(),
                    _ => what.to_owned(),
                };
                return self.error(at, format!("the signature promises {count} points, and the result is {found}: return a tuple with a point for each space of the signature, in its order"));
            }
            return self.error(at, format!("the result is {what}, and the signature promises a different space; construct it, as in `Direction::new(x, y, z)`"));
        };
        for (coordinates, identity) in found {
            outputs.extend(coordinates);
            identities.extend(identity);
        }
        Some((outputs, identities))
    }
}

impl Body<'_> {
    /// The coordinates of a parameter that is a direction, or of the opposite one.
    fn direction(
        &mut self,
        space: &Space,
        value: &Value,
    ) -> Option<(Vec<Id>, Option<TokenStream>)> {
        let v = <[Id; 3]>::try_from(value.vector()?).ok()?;
        let opposite = v.map(|c| self.graph.neg(c));
        let is_unit = |v: &[Id; 3]| self.graph.units().contains(v);
        let is_one = *space == Space::Direction && (is_unit(&v) || is_unit(&opposite));
        is_one.then(|| (v.to_vec(), None))
    }
}

/// The coordinates of one point, and its identity if it has one.
fn part(space: &Space, value: &Value) -> Option<(Vec<Id>, Option<TokenStream>)> {
    match (space, value) {
        (Space::Line, Value::Scalar(id)) => Some((vec![*id], None)),
        (Space::Plane, Value::Vector(v)) if v.len() == 2 => Some((v.clone(), None)),
        (Space::Volume, Value::Vector(v)) if v.len() == 3 => Some((v.clone(), None)),
        (s, Value::Point(t, v, identity)) if s == t => Some((v.clone(), identity.clone())),
        (Space::Embedded { n, .. }, Value::Point(Space::Embedded { .. }, v, _))
            if v.len() == *n =>
        {
            Some((v.clone(), None))
        }
        _ => None,
    }
}

/// Visits every identifier of some tokens.
pub(super) fn each_name(tokens: TokenStream, visit: &mut impl FnMut(String)) {
    for tree in tokens {
        match tree {
            proc_macro2::TokenTree::Ident(i) => visit(i.to_string()),
            proc_macro2::TokenTree::Group(g) => each_name(g.stream(), visit),
            _ => {}
        }
    }
}

/// Whether a call is to a function of this name.
pub fn is_call(call: &syn::ExprCall, name: &str) -> bool {
    matches!(&*call.func, Expr::Path(p) if p.path.segments.last().is_some_and(|s| s.ident == name))
}
