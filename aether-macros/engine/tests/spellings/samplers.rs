//! The samplers of source files.

use std::path::Path;

use aether_engine::parse::Space;
use proc_macro2::TokenStream;
use quote::ToTokens;
use syn::visit::Visit;
use syn::{Item, ItemFn};

/// A sampler as it is written.
pub struct Sampler {
    /// File and function.
    pub name: String,
    /// The arguments of its attribute.
    pub attribute: TokenStream,
    /// The function without the attribute.
    pub function: ItemFn,
}

/// All `#[sampler]` functions of a file but compositions, whose parts only rustc can see.
pub fn samplers(path: &Path) -> Vec<Sampler> {
    let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let file = syn::parse_file(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let stem = path.file_stem().unwrap_or_default().display();
    let functions = file.items.into_iter().filter_map(|item| match item {
        Item::Fn(f) => Some(f),
        _ => None,
    });
    let sampler = |mut function: ItemFn| {
        let index = function.attrs.iter().position(|a| a.path().is_ident("sampler"))?;
        let attribute = match function.attrs.remove(index).meta {
            syn::Meta::List(list) => list.tokens,
            _ => TokenStream::new(),
        };
        let name = format!("{stem}::{}", function.sig.ident);
        (!composed(&function)).then_some(Sampler { name, attribute, function })
    };
    functions.filter_map(sampler).collect()
}

fn composed(function: &ItemFn) -> bool {
    struct Calls(bool);
    impl Visit<'_> for Calls {
        fn visit_expr_method_call(&mut self, call: &syn::ExprMethodCall) {
            self.0 |= call.method == "sample" || call.method == "apply";
            syn::visit::visit_expr_method_call(self, call);
        }
    }
    let mut calls = Calls(false);
    calls.visit_item_fn(function);
    calls.0
}

/// A sampler in another spelling, and how its points and uniforms relate to those of the original.
pub struct Spelling {
    /// What was done to it.
    pub name: &'static str,
    /// The function.
    pub function: ItemFn,
    /// Uniforms of the spelling from those of the original, and the other way round.
    pub uniforms: fn(&mut Vec<f64>),
    /// Points of the spelling from those of the original.
    pub image: Affine,
}

impl Spelling {
    /// The tokens to compile.
    pub fn tokens(&self) -> TokenStream {
        self.function.to_token_stream()
    }
}

/// x → matrix · x + shift, and by how much it stretches the measure of the space.
#[derive(Clone)]
pub struct Affine {
    /// The matrix.
    pub rows: Vec<Vec<f64>>,
    /// What is added.
    pub shift: Vec<f64>,
    /// The measure of an image over that of the original.
    pub stretch: f64,
}

impl Affine {
    /// The identity on the coordinates of a space.
    pub fn identity(space: &Space) -> Affine {
        Affine::scaling(space.dimensions().1, 1.0, 0.0)
    }

    /// Every coordinate times a factor, plus a summand; the measure is taken to stay.
    pub fn scaling(n: usize, factor: f64, summand: f64) -> Affine {
        let row = |i| (0..n).map(|j| if i == j { factor } else { 0.0 }).collect();
        Affine { rows: (0..n).map(row).collect(), shift: vec![summand; n], stretch: 1.0 }
    }

    /// The next coordinate in the place of each, the first one in place of the last.
    pub fn cycle(n: usize) -> Affine {
        let mut cycle = Affine::scaling(n, 1.0, 0.0);
        cycle.rows.rotate_left(1);
        cycle
    }

    /// One map beside another, on coordinates of their own.
    pub fn beside(mut self, other: Affine) -> Affine {
        let (n, m) = (self.rows.len(), other.rows.len());
        self.rows.iter_mut().for_each(|row| row.extend(vec![0.0; m]));
        self.rows.extend(other.rows.into_iter().map(|row| [vec![0.0; n], row].concat()));
        self.shift.extend(other.shift);
        self.stretch *= other.stretch;
        self
    }

    /// The image of a point.
    pub fn apply(&self, x: &[f64]) -> Vec<f64> {
        let sum = |row: &Vec<f64>| row.iter().zip(x).map(|(a, x)| a * x).sum::<f64>();
        self.rows.iter().zip(&self.shift).map(|(row, s)| sum(row) + s).collect()
    }
}
