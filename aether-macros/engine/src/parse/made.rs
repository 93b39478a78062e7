//! What a body makes of its parameters alone, as parameters of its own.
//!
//! A direction that is built from corners, or an area from angles between normals, is spelled out in every place where
//! the body mentions it, and no inverse is found behind that. It depends on no uniform: whatever it is, the item computes
//! it once when it is constructed, by the body's own code, and derives the rest for any number or vector in its place. A
//! domain that is declared of such a name is asked for there.

use proc_macro2::{Ident, TokenStream};
use quote::{ToTokens, format_ident, quote};
use syn::{Expr, ItemFn, Pat};

use super::assign::operator;
use super::body::{Body, is_call};
use super::signature::MOST_NUMBERS;
use super::{Domain, Options, Signature, Space, Value};
use crate::eval::evaluate;
use crate::expr::{Deps, Graph, Id, Leaf, Node, UNKNOWNS, leaf_bit};
use crate::interval::Interval;
use crate::jacobian::simplify;
use crate::matrix::dot;
use crate::number::{Dd, Number};
use crate::points::{Kind, Point};
use crate::rational::Q;
use crate::walk::{self, Bound, Look};

/// What an item computes once: a number, or the coordinates of a vector.
#[derive(Clone)]
pub struct Constant {
    /// A number or a vector, as a parameter.
    pub kind: Kind,
    /// The fields that it is kept in; none if nothing is derived with it.
    pub fields: Vec<Ident>,
    /// Plain Rust code in `f64`.
    pub code: TokenStream,
    /// What is declared of it.
    pub domain: Option<Domain>,
    /// The first parameter that stands for it.
    pub first: u8,
    /// What that and those after it are in terms of the parameters and of the constants before; of `precomputed(…)` nothing
    /// is known.
    pub values: Option<Vec<Id>>,
}

/// What an item computes once, in its order.
#[derive(Clone, Default)]
pub struct Constants {
    /// Numbers and vectors.
    pub all: Vec<Constant>,
    /// The bindings of the body that they are made with.
    pub lets: Vec<TokenStream>,
}

impl Constants {
    /// The fields that are kept.
    pub fn fields(&self) -> impl Iterator<Item = &Ident> {
        self.all.iter().flat_map(|constant| &constant.fields)
    }

    /// Leaves fields to those alone that are derived with, or asked for their domain.
    pub fn keep(&mut self, used: Deps) {
        for constant in &mut self.all {
            let leaves = (constant.first..).take(constant.kind.scalars()).map(Leaf::Param);
            if constant.domain.is_none() && leaves.fold(0, |b, l| b | leaf_bit(l)) & used == 0 {
                constant.fields.clear();
            }
        }
    }

    /// Those that are read of the body, by their parameters.
    pub fn made(&self) -> Made {
        let made = self.all.iter().filter_map(|constant| {
            let domain = constant.domain.as_ref().map_or(Interval::ALL, |d| d.interval);
            constant.values.clone().map(|values| (constant.first, values, domain))
        });
        Made(made.collect())
    }
}

/// Parameters that are made of others: the first of them, what they are, and where these lie.
#[derive(Clone, Debug, Default)]
pub struct Made(Vec<(u8, Vec<Id>, Interval)>);

impl Made {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Gives them their values in a point; whether these are numbers of their domains.
    pub fn complete(&self, g: &Graph, point: &mut Point) -> bool {
        self.0.iter().all(|(first, values, domain)| {
            (usize::from(*first)..).zip(values).all(|(place, &id)| {
                let value = evaluate::<Dd>(g, id, &|leaf| point.input(leaf, &[]));
                point.params[place] = value;
                let value = value.to_f64();
                value.is_finite() && domain.lo <= value && value <= domain.hi
            })
        })
    }
}

/// The bindings of a body that are read as constants, while it is read.
#[derive(Default)]
pub(super) struct Making {
    /// Whether all that parameters alone make is one. What a domain is declared of is one in any case.
    pub(super) on: bool,
    /// What is being read is part of a constant.
    inside: bool,
    /// The name that is bound to what is being read.
    pub(super) name: Option<String>,
    pub(super) constants: Constants,
}

impl Options {
    /// Tells domains of names of the body from those of parameters.
    pub fn declared_of_names(&mut self, item: &ItemFn, signature: &Signature) {
        let is_parameter = |d: &Domain| signature.params.iter().any(|p| p.name == d.name);
        let mut names = Bound::default();
        walk::block(&mut names, &item.block);
        let (of_names, of_parameters) = std::mem::take(&mut self.domains)
            .into_iter()
            .partition(|d| !is_parameter(d) && names.0.iter().any(|name| d.name == name));
        (self.of_names, self.domains) = (of_names, of_parameters);
    }
}

/// Whether a body has the same constants on each way through it: it has one end, and no names that change within blocks.
pub fn has_one_end(item: &ItemFn) -> bool {
    struct Returns(bool);
    impl Look for Returns {
        fn expr(&mut self, e: &Expr) -> bool {
            self.0 |= matches!(e, Expr::Return(_) | Expr::Try(_) | Expr::Assign(_));
            self.0 |= matches!(e, Expr::Binary(b) if operator(&b.op).is_some());
            true
        }
        fn call_of_macro(&mut self, call: &syn::Macro) {
            self.0 |= call.path.is_ident("unreachable");
        }
    }
    let mut returns = Returns(false);
    walk::block(&mut returns, &item.block);
    !returns.0
}

impl Body<'_> {
    /// Whether an expression may be a constant: made of parameters, in a statement of the body itself.
    pub(super) fn is_made(&self, e: &Expr) -> bool {
        if !self.making.on || self.making.inside || self.depth != 1 || self.comparing {
            return false;
        }
        let compound = match e {
            Expr::Binary(_) | Expr::MethodCall(_) | Expr::If(_) | Expr::Unary(_) => true,
            Expr::Call(call) => !is_call(call, "precomputed"),
            _ => false,
        };
        compound && !self.depends(e)
    }

    /// Keeps a statement that constants may be made with, and the name that it binds.
    pub(super) fn name_constant(&mut self, local: &syn::Local, value: &Expr) {
        let of_parameters = self.depth == 1 && !self.depends(value);
        if self.making.on && !self.making.inside && of_parameters {
            self.making.constants.lets.push(local.to_token_stream());
        }
        let computed = match value {
            Expr::Call(call) => is_call(call, "precomputed"),
            _ => false,
        };
        self.making.name = match &local.pat {
            Pat::Ident(name) if computed || self.is_made(value) => Some(name.ident.to_string()),
            _ => None,
        };
    }

    /// The value of an expression of parameters, by a constant if it takes several of them.
    pub(super) fn made(&mut self, e: &Expr) -> Option<Value> {
        let name = self.making.name.take();
        let way = std::mem::take(&mut self.way);
        let value = self.read_whole(e);
        let straight = std::mem::replace(&mut self.way, way).is_straight();
        let value = value?;
        let found = match &value {
            Value::Scalar(id) => self.made_number(name, e, *id, straight).map(Value::Scalar),
            Value::Vector(v) => self.made_vector(name, e, v, straight).map(Value::Vector),
            Value::Point(Space::Direction, v, tokens) => self
                .made_vector(name, e, v, straight)
                .map(|v| Value::Point(Space::Direction, v, tokens.clone())),
            _ => None,
        };
        if found.is_some() {
            return found;
        }
        // Comparisons are made on the way that is read.
        self.read_whole(e)
    }

    /// The value of an expression, without constants in it.
    fn read_whole(&mut self, e: &Expr) -> Option<Value> {
        self.making.inside = true;
        let value = self.read(e);
        self.making.inside = false;
        value
    }

    fn made_number(
        &mut self,
        name: Option<String>,
        e: &Expr,
        id: Id,
        straight: bool,
    ) -> Option<Id> {
        let domain = name.as_ref().and_then(|name| self.domain_of_name(name));
        if domain.is_none() && straight && of_few(&self.graph, &[id], 1) {
            return None;
        }
        let known = if straight { self.graph.range(id) } else { Interval::ALL };
        let range = domain.as_ref().map_or(known, |d| known.intersection(d.interval));
        let code = quote!({ #e });
        let kind = Kind::Scalar(Some(range).filter(|r| *r != Interval::ALL));
        let constant = (name, kind, code, straight.then(|| vec![id]));
        self.constant(constant, domain, range).map(|ids| ids[0])
    }

    fn made_vector(
        &mut self,
        name: Option<String>,
        e: &Expr,
        v: &[Id],
        straight: bool,
    ) -> Option<Vec<Id>> {
        if v.len() > 3 || straight && of_few(&self.graph, v, v.len()) {
            return None;
        }
        let unit = straight && self.has_unit_length(v);
        let code = quote!({ #e });
        let (kind, range) = match unit {
            true => (Kind::Direction, Interval::new(-1.0, 1.0)),
            false => (Kind::Vector(v.len()), Interval::ALL),
        };
        let constant = (name, kind, code, straight.then(|| v.to_vec()));
        let ids = self.constant(constant, None, range)?;
        if unit {
            self.graph.declare_unit([ids[0], ids[1], ids[2]]);
        }
        Some(ids)
    }

    /// New parameters for what an item computes once; `None` if it has too many.
    pub(super) fn constant(
        &mut self,
        (name, kind, code, values): (Option<String>, Kind, TokenStream, Option<Vec<Id>>),
        domain: Option<Domain>,
        range: Interval,
    ) -> Option<Vec<Id>> {
        let (first, count) = (self.next_param, kind.scalars() as u8);
        if first + count > MOST_NUMBERS {
            return None;
        }
        let number = self.making.constants.fields().count();
        let name = name.unwrap_or_else(|| format!("constant{number}"));
        let fields =
            (number..).take(kind.scalars()).map(|i| format_ident!("constant{i}")).collect();
        let axes = ["x", "y", "z"].iter().take(usize::from(count));
        let names: Vec<String> = match kind {
            Kind::Scalar(_) => vec![name],
            _ => axes.map(|axis| format!("{name}.{axis}")).collect(),
        };
        let constant = Constant { kind, fields, code, domain, first, values };
        self.making.constants.all.push(constant);
        Some(names.iter().map(|name| self.scalar_param(name, range)).collect())
    }

    /// The domain that is declared of a name of the body.
    pub(super) fn domain_of_name(&self, name: &str) -> Option<Domain> {
        self.of_names.iter().find(|d| d.name == name).cloned()
    }

    fn has_unit_length(&mut self, v: &[Id]) -> bool {
        let Ok(v) = <[Id; 3]>::try_from(v.to_vec()) else { return false };
        crate::poly::start_budget();
        let g = &mut self.graph;
        let square = dot(g, &v, &v);
        let square = simplify(g, square, None);
        crate::poly::start_budget();
        g.as_number(square) == Some(Q::ONE)
    }
}

/// Whether expressions are made of so few parameters that nothing is won by a name.
fn of_few(g: &Graph, ids: &[Id], few: usize) -> bool {
    let parameters = ids.iter().fold(0, |bits, id| bits | g.deps(*id) & !UNKNOWNS);
    let is_leaf = |id: &Id| matches!(g.node(*id), Node::Leaf(Leaf::Param(_)));
    ids.iter().all(is_leaf) || parameters.count_ones() as usize <= few
}
