//! Items evaluated in the compiler itself, without rustc: for tools and tests that look at many.
//!
//! What an item computes here is what its code computes in the middle of its domain. On borders
//! emitted code weighs rounding errors, which needs the runtime; here a fixed tolerance decides.

use proc_macro2::TokenStream;
use syn::ItemFn;

use crate::derive::{Atom, Derived, Preimage, atoms, derive, derive_by_pieces, on_which_way};
use crate::diagnostics::Diagnostics;
use crate::eval::Evaluator;
use crate::expr::{Graph, Id, Leaf};
use crate::parse::{
    Options, Parsed, Piece, Signature, Test, bound_once, has_one_end, parse, plain, shared,
    signature, stages,
};

/// How far outside [0, 1] a uniform may be recovered, and how far (relative to its size) the image
/// of a preimage may lie from the point.
const TOLERANCE: f64 = 1e-9;

/// An item with everything that was derived of it.
pub struct Item {
    /// The item as read.
    pub parsed: Parsed,
    /// What was derived, a piece each.
    pub derived: Vec<Derived>,
    /// The atoms, a way to one each.
    pub atoms: Vec<Atom>,
}

/// What is derived of a piece by names of the body.
fn in_two_steps(
    function: &ItemFn,
    parsed: &mut Parsed,
    piece: usize,
    options: &Options,
) -> Option<Derived> {
    let stages = stages(&bound_once(function), parsed, piece, options);
    let problem = &mut parsed.pieces[piece].problem;
    problem.stages = stages;
    if problem.stages.is_empty() { None } else { derive(problem).ok() }
}

/// An item without branches by names for all that its body mentions more than once.
fn by_its_parts(function: &ItemFn, parsed: &Parsed, options: &Options) -> Option<Item> {
    if parsed.pieces.len() != 1 {
        return None;
    }
    let named = shared(function)?;
    // What is wrong with the body is said of the body as it is.
    let mut errors = Diagnostics::new();
    let mut parsed = parse(&named, parsed.signature.clone(), options, parsed.making, &mut errors)?;
    let derived = in_two_steps(&named, &mut parsed, 0, options)?;
    errors.is_empty().then(|| Item { parsed, derived: vec![derived], atoms: vec![] })
}

/// An item without branches where all that parameters alone make is computed once.
fn by_constants(function: &ItemFn, parsed: &Parsed, options: &Options) -> Option<Item> {
    if parsed.making || parsed.signature.mixed || !has_one_end(function) {
        return None;
    }
    let mut errors = Diagnostics::new();
    let mut parsed = parse(function, parsed.signature.clone(), options, true, &mut errors)?;
    if parsed.constants.made().is_empty() || parsed.pieces.len() != 1 {
        return None;
    }
    let derived = derive(&mut parsed.pieces[0].problem).ok();
    match derived.or_else(|| in_two_steps(function, &mut parsed, 0, options)) {
        Some(derived) => Some(Item { parsed, derived: vec![derived], atoms: vec![] }),
        None => by_its_parts(function, &parsed, options),
    }
}

impl Item {
    /// Compiles `#[sampler(attr)]` or `#[map(attr)]` on a function. The error is what the user would
    /// read.
    pub fn new(attr: TokenStream, item: TokenStream, sampler: bool) -> Result<Item, String> {
        let mut errors = Diagnostics::new();
        let function = syn::parse2::<ItemFn>(item).map_err(|e| e.to_string())?;
        let mut options = errors.ok(syn::parse2::<Options>(attr)).unwrap_or_default();
        let item = signature(&function, sampler, &mut errors).and_then(|s| {
            options.declared_of_names(&function, &s);
            Item::compile(&function, s, &options, &mut errors)
        });
        item.filter(|_| errors.is_empty()).ok_or_else(|| errors.messages().join("\n"))
    }

    /// Reads a body and derives everything. `None` if there were errors.
    pub(crate) fn compile(
        function: &ItemFn,
        signature: Signature,
        options: &Options,
        errors: &mut Diagnostics,
    ) -> Option<Item> {
        let function = &plain(function);
        let making = !options.of_names.is_empty();
        if making && !has_one_end(function) {
            errors.error(&function.sig.ident, "domains are declared of names of a body that has one end, and no names that change in blocks: leave `return` and such assignments away, or pass what they stand for as parameters");
            return None;
        }
        let mut parsed = parse(function, signature, options, making, errors)?;
        let ways = std::mem::take(&mut parsed.atoms);
        let atoms = atoms(ways).map_err(|(tokens, why)| errors.error(tokens, why)).ok()?;
        let mut derived = Vec::new();
        for k in 0..parsed.pieces.len() {
            let found = derive(&mut parsed.pieces[k].problem);
            let stuck = parsed.pieces[k].problem.stuck;
            let found = found
                .or_else(|message| in_two_steps(function, &mut parsed, k, options).ok_or(message));
            match found {
                Ok(d) => derived.push(d),
                Err(message) => {
                    let item = by_its_parts(function, &parsed, options);
                    let item = item.or_else(|| by_constants(function, &parsed, options));
                    if let Some(item) = item {
                        return Some(Item { atoms, ..item });
                    }
                    let problem = &mut parsed.pieces[k].problem;
                    let found = if stuck { derive_by_pieces(problem) } else { Err(message) };
                    let found = found.map_err(|why| {
                        errors.error(&function.sig.ident, on_which_way(problem, why))
                    });
                    derived.push(found.ok()?);
                }
            }
        }
        Some(Item { parsed, derived, atoms })
    }

    fn pieces(&self) -> impl Iterator<Item = (&Piece, &Derived)> {
        self.parsed.pieces.iter().zip(&self.derived)
    }

    /// The parameters, where formulas that have only a limit at zero can be evaluated.
    fn beside_zero(&self, p: &[f64]) -> Vec<f64> {
        let limit = |i: usize| self.derived.iter().any(|d| d.limits.contains(&(i as u8)));
        let zero = |i: &u8| p[usize::from(*i)] == 0.0;
        let own_way =
            |i: usize| self.parsed.vanishing_with(i as u8).any(|others| others.iter().all(zero));
        let beside = |(i, p): (usize, &f64)| {
            let moved = *p == 0.0 && limit(i) && !own_way(i);
            if moved { f64::EPSILON * f64::EPSILON } else { *p }
        };
        p.iter().enumerate().map(beside).collect()
    }

    /// The coordinates of the point of uniforms `u` (or of an argument), `None` if there is no point
    /// there. `p` are the scalar parameters, vectors and matrices spelled out by columns.
    pub fn forward(&self, p: &[f64], u: &[f64]) -> Option<Vec<f64>> {
        let p = &self.beside_zero(p);
        let (piece, derived) =
            self.pieces().find(|(piece, _)| passed(&piece.graph, &piece.tests, p, u))?;
        let problem = &piece.problem;
        let t = enter(piece, p, u);
        let exists = values(&problem.graph, &problem.requirements, p, &t).iter().all(|r| *r > 0.0);
        exists.then(|| values(&problem.graph, &derived.forward, p, &t))
    }

    /// The sum over the preimages of `x` of the density by way of each.
    pub fn pdf(&self, p: &[f64], x: &[f64]) -> f64 {
        self.found(p, x).into_iter().map(|(_, density)| density).sum()
    }

    /// The probability of an atom; zero if there is none of this number.
    pub fn probability(&self, p: &[f64], number: usize) -> f64 {
        let ways = self.atoms.iter().filter(|atom| atom.way.number == number);
        let open = ways.filter(|atom| passed(&atom.way.graph, &atom.open, p, &[]));
        open.map(|atom| values(&atom.graph, &[atom.probability], p, &[])[0]).sum()
    }

    /// The preimages of `x`.
    pub fn preimages(&self, p: &[f64], x: &[f64]) -> Vec<Vec<f64>> {
        self.found(p, x).into_iter().map(|(u, _)| u).collect()
    }

    /// Preimages with their densities; one on a border is found once.
    fn found(&self, p: &[f64], x: &[f64]) -> Vec<(Vec<f64>, f64)> {
        let p = &self.beside_zero(p);
        let mut found: Vec<(Vec<f64>, f64)> = Vec::new();
        for (piece, derived) in self.pieces() {
            for preimage in &derived.preimages {
                let Some(u) = recovered(piece, derived, preimage, p, x) else { continue };
                let same = |v: &[f64]| v.iter().zip(&u).all(|(a, b)| (a - b).abs() < TOLERANCE);
                if !found.iter().any(|(v, _)| same(v)) {
                    let d = values(&piece.problem.graph, &[preimage.density], p, x)[0];
                    found.push((u, d));
                }
            }
        }
        found
    }
}

/// The uniforms of a preimage, if it is one.
fn recovered(
    piece: &Piece,
    derived: &Derived,
    preimage: &Preimage,
    p: &[f64],
    x: &[f64],
) -> Option<Vec<f64>> {
    let problem = &piece.problem;
    let g = &problem.graph;
    let t = values(g, &preimage.unknowns, p, x);
    let free = problem.argument.is_some();
    let inside = |t: &f64| (-TOLERANCE..=1.0 + TOLERANCE).contains(t) || free && t.is_finite();
    let exists = t.iter().all(inside)
        && values(g, &preimage.conditions, p, x).iter().all(|c| *c >= -TOLERANCE)
        && values(g, &preimage.requirements, p, x).iter().all(|r| *r > 0.0)
        && passed(g, &problem.guards, p, &t);
    let near = |(y, x): (&f64, &f64)| (y - x).abs() <= TOLERANCE * (1.0 + x.abs());
    let leads_back = || values(g, &derived.forward, p, &t).iter().zip(x).all(near);
    if !exists || derived.check_forward && !leads_back() {
        return None;
    }
    let ends = segment_ends(piece, p);
    let leave = |(t, end): (f64, Option<(f64, f64)>)| end.map_or(t, |(low, width)| low + width * t);
    let narrow = ends.iter().flatten().any(|(_, width)| *width <= 0.0);
    let none = narrow || !passed(g, &problem.existence, p, &[]);
    (!none).then(|| t.into_iter().zip(ends).map(leave).collect())
}

/// The unknowns of a piece from the uniforms.
fn enter(piece: &Piece, p: &[f64], u: &[f64]) -> Vec<f64> {
    let enter = |(u, end): (&f64, Option<(f64, f64)>)| end.map_or(*u, |(low, w)| (u - low) / w);
    u.iter().zip(segment_ends(piece, p)).map(enter).collect()
}

/// Lower end and width of the segments that the uniforms are confined to.
fn segment_ends(piece: &Piece, p: &[f64]) -> Vec<Option<(f64, f64)>> {
    let problem = &piece.problem;
    let end = |i: usize| {
        let s = problem.segments.get(i).copied().flatten()?;
        let v = values(&problem.graph, &[s.low, s.width], p, &[]);
        Some((v[0], v[1]))
    };
    (0..problem.unknowns.len()).map(end).collect()
}

fn passed(g: &Graph, tests: &[Test], p: &[f64], u: &[f64]) -> bool {
    let differences: Vec<Id> = tests.iter().map(|t| t.difference).collect();
    let values = values(g, &differences, p, u);
    tests.iter().zip(values).all(|(t, d)| if t.strict { d > 0.0 } else { d >= 0.0 })
}

/// Expressions of the parameters `p` and of uniforms, unknowns or coordinates `x`.
fn values(g: &Graph, ids: &[Id], p: &[f64], x: &[f64]) -> Vec<f64> {
    let inputs = |leaf: Leaf| {
        let value = match leaf {
            Leaf::Param(i) => p.get(i as usize),
            Leaf::Unknown(i) | Leaf::Out(i) => x.get(i as usize),
            Leaf::Bound(_) => None,
        };
        value.copied().unwrap_or(f64::NAN)
    };
    let mut e = Evaluator::new(g, &inputs);
    ids.iter().map(|&id| e.value(id)).collect()
}
