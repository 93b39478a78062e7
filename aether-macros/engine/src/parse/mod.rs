//! From a Rust function to expressions.

mod attribute;
mod body;
mod expression;
mod methods;
mod signature;
mod solve;
mod value;

pub use attribute::{Domain, Options};
pub use body::Body;
pub use signature::{Param, ParamKind, Signature, Source, Space, signature};
pub use value::Value;

use std::collections::HashMap;

use proc_macro2::TokenStream;
use syn::ItemFn;

use crate::derive::{Problem, Target};
use crate::diagnostics::Diagnostics;
use crate::expr::{Graph, Id, Leaf};
use crate::interval::Interval;
use crate::points::Kind;

/// A parsed item: its signature, and the equations of its body.
pub struct Parsed {
    /// Name, parameters, spaces.
    pub signature: Signature,
    /// The map to be inverted.
    pub problem: Problem,
    /// The identity expression of a `SurfacePoint` result.
    pub identity: Option<TokenStream>,
    /// Values computed once from the parameters by plain Rust code: `precomputed(…)`.
    pub constants: Vec<(String, TokenStream)>,
}

/// Parses the body of a sampler or a map. `None` if there were errors.
pub fn parse(
    item: &ItemFn,
    signature: Signature,
    options: &Options,
    errors: &mut Diagnostics,
) -> Option<Parsed> {
    let mut graph = Graph::new();
    let mut names: HashMap<String, Value> = HashMap::new();
    let mut unknowns = Vec::new();
    let mut argument = None;
    match &signature.source {
        Source::Uniforms { name, count } => {
            let range = Interval::new(0.0, 1.0);
            let ids: Vec<Id> = (0..*count)
                .map(|i| {
                    let text =
                        if *count == 1 { name.clone() } else { format!("{name}{}", subscript(i)) };
                    unknowns.push(Leaf::Unknown(i as u8));
                    graph.leaf(Leaf::Unknown(i as u8), &text, range)
                })
                .collect();
            names.insert(name.clone(), Value::Uniforms(ids));
        }
        Source::Point { name, space } => {
            let (coordinates, kind) = space.argument();
            let range =
                if *space == Space::Direction { Interval::new(-1.0, 1.0) } else { Interval::ALL };
            let ids: Vec<Id> = (0..coordinates)
                .map(|i| {
                    let text = if coordinates == 1 {
                        name.clone()
                    } else {
                        format!("{name}.{}", ["x", "y", "z"][i])
                    };
                    unknowns.push(Leaf::Unknown(i as u8));
                    graph.leaf(Leaf::Unknown(i as u8), &text, range)
                })
                .collect();
            if *space == Space::Direction {
                graph.declare_unit([ids[0], ids[1], ids[2]]);
            }
            let value = if ids.len() == 1 { Value::Scalar(ids[0]) } else { Value::Vector(ids) };
            names.insert(name.clone(), value);
            argument = Some(kind);
        }
    }
    let mut body = Body::new(graph, names, errors);
    let mut kinds = Vec::new();
    let mut frames = Vec::new();
    for p in &signature.params {
        body.declare_param(p, options, &mut kinds, &mut frames);
    }
    let result = body.block(&item.block)?;
    let (outputs, identity) = body.outputs(&result, &signature.space, &item.block)?;
    let target = match signature.space {
        Space::Direction => Target::Direction,
        Space::SurfacePoint => Target::Identified,
        Space::Embedded { .. } => Target::Embedded,
        _ => Target::Free,
    };
    let Body { graph, requirements, constants, .. } = body;
    let first = kinds.iter().map(Kind::scalars).sum::<usize>();
    kinds.extend(constants.iter().map(|_| Kind::Scalar(None)));
    debug_assert!(first <= 64);
    let problem =
        Problem { graph, outputs, unknowns, argument, kinds, frames, target, requirements };
    Some(Parsed { signature, problem, identity, constants })
}

fn subscript(i: usize) -> String {
    (i + 1).to_string().chars().filter_map(|c| char::from_u32(0x2080 + c.to_digit(10)?)).collect()
}
