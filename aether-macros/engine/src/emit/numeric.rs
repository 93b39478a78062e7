//! Roots without a closed form as calls of the runtime.

use proc_macro2::TokenStream;
use quote::{format_ident, quote};

use super::code::Code;
use crate::expr::{BOUNDS, Graph, Id, Leaf, Node, Root, children};
use crate::number::Single;
use crate::root::passes_pole;

/// The name of a bound variable in emitted code.
pub(super) fn variable(leaf: Leaf) -> TokenStream {
    let Leaf::Bound(i) = leaf else { unreachable!("only bound variables are named here") };
    let name = format_ident!("root{i}");
    quote!(#name)
}

/// What is computed once, before the search for a root: its target, its ends, and the parts of its
/// body that no bound variable occurs in.
pub(super) fn outside(g: &Graph, root: &Root) -> Vec<Id> {
    let mut out = vec![root.target, root.lo, root.hi];
    let mut seen = std::collections::HashSet::new();
    let mut open = vec![root.body, root.slope];
    while let Some(id) = open.pop() {
        if !seen.insert(id) {
            continue;
        }
        let node = g.node(id);
        if !g.has(id, BOUNDS) {
            out.push(id);
        } else if let Node::If(test, ..) = node {
            // The sides of a choice are computed only where they are taken.
            open.push(*test);
        } else {
            if let Node::Root(r) = node {
                open.extend([r.body, r.slope]);
            }
            open.extend(children(node));
        }
    }
    out
}

/// Where the target of a root lies between the values at the ends, as a number between the ends.
pub(super) fn place(code: &mut Code, root: &Root) -> TokenStream {
    for id in [root.target, root.lo, root.hi] {
        code.value(id);
    }
    let mut inner = code.inner();
    let body = inner.value(root.body);
    let lets = inner.statements();
    let [target, lo, hi] = [root.target, root.lo, root.hi].map(|id| code.reference(id));
    let t = variable(root.variable);
    let call =
        quote!(::aether_core::support::place_of_root(|#t: R| { #lets #body }, #target, #lo, #hi));
    code.named(&call)
}

/// Whether rounding in single or double precision puts the ends beyond poles.
pub(super) fn poles(g: &Graph, root: &Root) -> [bool; 2] {
    [[root.lo, root.hi], [root.hi, root.lo]].map(|ends| {
        passes_pole::<Single>(g, root, ends, f64::from(f32::EPSILON))
            || passes_pole::<f64>(g, root, ends, f64::EPSILON)
    })
}

/// The call, with the body and its slope as one closure. What [`outside`] lists has been written.
pub(super) fn root(code: &Code, root: &Root) -> TokenStream {
    let mut inner = code.inner();
    let (body, slope) = (inner.value(root.body), inner.value(root.slope));
    let lets = inner.statements();
    let [target, lo, hi] = [root.target, root.lo, root.hi].map(|id| code.reference(id));
    let t = variable(root.variable);
    let function = match (root.inside, root.folds) {
        (true, _) => quote!(root_inside),
        (false, false) => quote!(root_or_beyond),
        (false, true) => quote!(root_or_fold),
    };
    let poles = poles(code.graph(), root);
    if poles == [false; 2] {
        return quote!(::aether_core::support::#function(|#t: R| { #lets (#body, #slope) }, #target, #lo, #hi));
    }
    let value = {
        let mut inner = code.inner();
        let body = inner.value(root.body);
        let lets = inner.statements();
        quote!(|#t: R| { #lets #body })
    };
    let place = |pole: bool, here: &TokenStream, there: &TokenStream| match pole {
        true => quote!(::aether_core::support::before_pole(#value, #here, #there)),
        false => quote!(#here),
    };
    let [first, last] = [place(poles[0], &lo, &hi), place(poles[1], &hi, &lo)];
    let body = if poles[0] { quote!(R::select(#t.le(first), -R::INFINITY, #body)) } else { body };
    let body = if poles[1] { quote!(R::select(#t.ge(last), R::INFINITY, #body)) } else { body };
    quote!({
        let (first, last) = (#first, #last);
        ::aether_core::support::#function(|#t: R| { #lets (#body, #slope) }, #target, #lo, #hi)
    })
}
