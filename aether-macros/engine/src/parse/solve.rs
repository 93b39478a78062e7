//! `solve(|t| body, lo..hi, target)`: a step of sampling that is known only implicitly.

use syn::{Expr, ExprCall, ExprRange, Pat};

use super::Value;
use super::body::Body;
use crate::derivative::derivative;
use crate::display::show;
use crate::expr::{Id, Leaf, Root, leaf_bit};
use crate::interval::Interval;
use crate::monotone::{Unproven, direction};
use crate::rational::Q;

/// How deep such steps may be nested: one inside the closure of another.
const DEPTH: u8 = 4;

/// The root, as a node, once its closure is proven to be monotone.
pub fn solve(body: &mut Body, c: &ExprCall, [f, range, target]: [&Expr; 3]) -> Option<Value> {
    // A closure with a name is called in place.
    let called: Expr = syn::parse_quote!(|t| #f(t));
    let named = match f {
        Expr::Path(p) => p.path.get_ident().and_then(|name| body.names.get(&name.to_string())),
        _ => None,
    };
    let f = if let Some(Value::Callable(_)) = named { &called } else { f };
    let Some((name, function)) = closure(f) else {
        return body.error(
            f,
            "the function to be solved is a closure with one argument: `solve(|t| t + t.powi(3), 0.0..1.0, u[0])`",
        );
    };
    let Expr::Range(range) = range else {
        return body.error(
            range,
            "the numbers to look for a solution in are a range, such as `0.0..1.0` or `0.0..`",
        );
    };
    let (lo, hi) =
        (end(body, &range.start, f64::NEG_INFINITY)?, end(body, &range.end, f64::INFINITY)?);
    let target = body.scalar(target)?;
    let interval = Interval::new(body.graph.range(lo).lo, body.graph.range(hi).hi);
    if body.bound >= DEPTH {
        return body.error(
            c,
            format!(
                "equations can be nested {DEPTH} deep; solve some of them in a `#[map]` of its own"
            ),
        );
    }
    // All but the bit of this depth are taken.
    let taken = crate::expr::BOUNDS & !leaf_bit(Leaf::Bound(body.bound));
    let Some(variable) = body.graph.bound_variable(taken, &name, interval) else {
        return body
            .error(c, "there are too many equations in this item; split it in several maps");
    };
    let t = body.graph.get_leaf(variable);
    let outer = body.names.insert(name.clone(), Value::Scalar(t));
    body.bound += 1;
    // A `return` of the closure is its own.
    let returned = body.returned.take();
    let value = body.expr(function);
    let value = body.returned.take().or(value);
    body.returned = returned;
    body.bound -= 1;
    match outer {
        Some(value) => body.names.insert(name.clone(), value),
        None => body.names.remove(&name),
    };
    let value = match value?.real() {
        Value::Scalar(id) => id,
        other => {
            let what = other.describe();
            return body.error(function, format!("a number is needed here, and this is {what}"));
        }
    };
    match direction(&mut body.graph, value, variable) {
        Ok(sign) => {
            let g = &mut body.graph;
            let [value, target] = [value, target].map(|id| g.sum(Q::ZERO, &[(Q::int(sign), id)]));
            let slope = derivative(g, value, variable);
            let root =
                Root { variable, body: value, slope, target, lo, hi, inside: true, folds: false };
            Some(Value::Scalar(g.root(root)))
        }
        Err(why) => {
            let text = unproven(body, &name, value, range, &why);
            body.error(function, text)
        }
    }
}

/// The name of a closure's only argument, and its value.
fn closure(f: &Expr) -> Option<(String, &Expr)> {
    let Expr::Closure(f) = f else { return None };
    let [pattern] = &f.inputs.iter().collect::<Vec<_>>()[..] else { return None };
    let name = match pattern {
        Pat::Type(p) => &p.pat,
        p => *p,
    };
    let Pat::Ident(name) = name else { return None };
    Some((name.ident.to_string(), &f.body))
}

fn end(body: &mut Body, e: &Option<Box<Expr>>, open: f64) -> Option<Id> {
    match e {
        Some(e) => body.scalar(e),
        None => Some(body.graph.float(open)),
    }
}

fn unproven(body: &Body, name: &str, value: Id, range: &ExprRange, why: &Unproven) -> String {
    let way = match &why.unbounded {
        Some(p) => format!(
            "declare a domain of `{p}` in which it does, as in `#[sampler({p} in 0.0..=10.0)]`"
        ),
        None => "narrow the range or the domains of the parameters".to_owned(),
    };
    let range = quote::quote!(#range);
    format!(
        "an equation is solved only if it is proven to have one solution: `{}` must always increase or always decrease with {name} in {range}, and there is no proof for {}. If it does, {way}",
        show(&body.graph, value),
        why.place
    )
}
