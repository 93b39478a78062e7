//! The parts that samplers and maps share: the struct, its constructor, the hidden body.

use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::{format_ident, quote};
use syn::ItemFn;

use super::code::Code;
use super::documentation::Texts;
use super::interface::{bound, hidden_body, interface, type_name};
use crate::derive::{Derived, Preimage, Problem, Target};
use crate::expr::{Id, Leaf};
use crate::parse::{Options, ParamKind, Parsed, Signature, Space};

/// Writes the code of one item.
pub struct Emitter<'a> {
    /// The user's function.
    pub item: &'a ItemFn,
    /// What was parsed.
    pub parsed: &'a Parsed,
    /// What was derived.
    pub derived: &'a Derived,
    /// The attribute's arguments.
    pub options: &'a Options,
}

impl Emitter<'_> {
    pub(super) fn signature(&self) -> &Signature {
        &self.parsed.signature
    }
    pub(super) fn problem(&self) -> &Problem {
        &self.parsed.problem
    }

    /// `R`, or nothing for an item without parameters.
    pub(super) fn generics(&self) -> TokenStream {
        if self.is_generic() { quote!(<R>) } else { quote!() }
    }
    fn is_generic(&self) -> bool {
        self.signature().params.iter().any(|p| p.kind != ParamKind::Identity)
            || !self.parsed.constants.is_empty()
    }

    /// Name of the struct: the function's name in camel case.
    pub(super) fn type_name(&self) -> Ident {
        type_name(&self.signature().name)
    }

    /// How many scalar parameters there are.
    pub(super) fn scalars(&self) -> usize {
        self.problem().kinds.iter().map(crate::points::Kind::scalars).sum()
    }

    /// Everything.
    pub fn emit(&self, sampler: bool) -> TokenStream {
        let texts = Texts::new(self.problem(), self.derived);
        let docs = texts.attributes(self.signature(), self.derived, sampler);
        let interface =
            interface(self.item, self.signature(), self.options, &self.parsed.constants, &docs);
        let implementation = if sampler {
            super::sampler::implementation(self)
        } else {
            super::map::implementation(self)
        };
        let derivation = self.derivation(&texts);
        let hidden = hidden_body(self.item);
        let functions = self.functions();
        quote! {
            #interface
            #[allow(clippy::all, clippy::pedantic, unused, non_snake_case)]
            const _: () = {
                use ::aether_core::{Real as _, Mask as _, Point as _};
                use ::aether_core::real::{Mask, Real};
                #hidden
                #functions
                #derivation
                #implementation
            };
        }
    }

    /// Prints the derivation to the build's output.
    pub fn explain(&self) {
        let texts = Texts::new(self.problem(), self.derived);
        eprintln!("{}:", self.signature().name);
        eprintln!("  map      ({})", texts.forward);
        let g = &self.problem().graph;
        let computed: Vec<String> =
            self.derived.forward.iter().map(|f| crate::display::show(g, *f)).collect();
        eprintln!("  computed ({})", computed.join(", "));
        for step in &self.derived.steps {
            eprintln!("  step     {step}");
        }
        for line in texts.inverse.lines() {
            eprintln!("  inverse  {line}");
        }
        eprintln!("  √det JᵀJ {}", texts.jacobian);
        eprintln!("  pdf      {}", texts.pdf);
        if let Some(text) = &texts.numerical {
            eprintln!("  {}", text.trim_end());
        }
        eprintln!("  worst relative error in f64: {:.1e}", self.derived.worst_error);
    }

    fn derivation(&self, texts: &Texts) -> TokenStream {
        let Texts { forward, inverse, jacobian, pdf, .. } = texts;
        let name = self.signature().name.to_string();
        let measure = self.signature().space.measure();
        let preimages = Literal::usize_unsuffixed(self.derived.preimages.len());
        let worst = bound(self.derived.worst_error);
        let ty = self.type_name();
        let (bounds, args) =
            if self.is_generic() { (quote!(<R: Real>), quote!(<R>)) } else { (quote!(), quote!()) };
        quote! {
            #[automatically_derived]
            impl #bounds #ty #args {
                /// What the compiler derived, as text.
                pub const DERIVATION: ::aether_core::Derivation = ::aether_core::Derivation {
                    name: #name,
                    forward: #forward,
                    inverse: #inverse,
                    jacobian: #jacobian,
                    pdf: #pdf,
                    measure: #measure,
                    preimages: #preimages,
                    worst_error: #worst,
                };
            }
        }
    }

    /// The map, the volume, and for each preimage its inverse, tests and density, as free functions.
    fn functions(&self) -> TokenStream {
        let g = &self.problem().graph;
        let (n, m, p) =
            (self.problem().unknowns.len(), self.problem().outputs.len(), self.scalars());
        let forward_input = |l: Leaf| input(l, "u");
        let mut code = Code::new(g, &forward_input);
        let outputs: Vec<TokenStream> =
            self.derived.forward.iter().map(|&f| code.value(f)).collect();
        let lets = code.statements();
        let mut functions = quote! {
            #[inline(always)]
            fn forward<R: Real>(p: &[R; #p], u: &[R; #n]) -> [R; #m] { #lets [#(#outputs),*] }
        };
        let mut code = Code::new(g, &forward_input);
        let required: Vec<TokenStream> =
            self.problem().requirements.iter().map(|&r| code.value(r)).collect();
        let lets = code.statements();
        functions.extend(quote! {
            #[inline(always)]
            fn exists<R: Real>(p: &[R; #p], u: &[R; #n]) -> R::Mask {
                #lets
                <R::Mask as Mask>::TRUE #(.and(#required.gt(R::ZERO)))*
            }
        });
        let mut code = Code::new(g, &forward_input);
        let volume = code.value(self.derived.volume);
        let lets = code.statements();
        functions.extend(quote! {
            #[inline(always)]
            fn volume<R: Real>(p: &[R; #p], u: &[R; #n]) -> R { #lets #volume }
        });
        for (k, preimage) in self.derived.preimages.iter().enumerate() {
            functions.extend(self.preimage(k, preimage));
        }
        functions
    }

    fn preimage(&self, k: usize, preimage: &Preimage) -> TokenStream {
        let g = &self.problem().graph;
        let (n, m, p) =
            (self.problem().unknowns.len(), self.problem().outputs.len(), self.scalars());
        let at = |l: Leaf| input(l, "x");
        let (inverse, support, density) = (
            format_ident!("inverse_{k}"),
            format_ident!("support_{k}"),
            format_ident!("density_{k}"),
        );
        let mut code = Code::new(g, &at);
        let unknowns: Vec<TokenStream> = preimage.unknowns.iter().map(|&u| code.value(u)).collect();
        let inverse_lets = code.statements();
        let checked = self.checked(preimage);
        let c = checked.len();
        let mut code = Code::new(g, &at);
        let conditions: Vec<TokenStream> =
            preimage.conditions.iter().map(|&c| code.value(c)).collect();
        let requirements: Vec<TokenStream> =
            preimage.requirements.iter().map(|&c| code.value(c)).collect();
        let uniforms: Vec<TokenStream> =
            checked.iter().map(|&i| code.value(preimage.tested[i])).collect();
        let support_lets = code.statements();
        // The rim of a lobe belongs to it even if a rotation rounded the point below the horizon.
        let least = match self.problem().target {
            Target::Direction => quote!(R::of(-16.0) * R::EPSILON),
            _ => quote!(R::ZERO),
        };
        let mut code = Code::new(g, &at);
        let value = code.value(preimage.density);
        let density_lets = code.statements();
        quote! {
            #[inline(always)]
            fn #inverse<R: Real>(p: &[R; #p], x: &[R; #m]) -> [R; #n] { #inverse_lets [#(#unknowns),*] }
            #[inline(always)]
            fn #support<R: Real>(p: &[R; #p], x: &[R; #m]) -> ([R; #c], R::Mask) {
                #support_lets
                ([#(#uniforms),*], <R::Mask as Mask>::TRUE #(.and(#conditions.ge(#least)))* #(.and(#requirements.gt(R::ZERO)))*)
            }
            #[inline(always)]
            fn #density<R: Real>(p: &[R; #p], x: &[R; #m]) -> R { #density_lets #value }
        }
    }

    /// The unknowns whose range is not settled by interval arithmetic and has to be tested.
    pub(super) fn checked(&self, preimage: &Preimage) -> Vec<usize> {
        let g = &self.problem().graph;
        let settled = |id: Id| {
            let r = g.range(id);
            r.lo >= 0.0 && r.hi <= 1.0 + 1e-12
        };
        (0..preimage.tested.len()).filter(|&i| !settled(preimage.tested[i])).collect()
    }

    /// `let p = [...]`: the scalar parameters in order.
    pub(super) fn parameters(&self) -> TokenStream {
        let mut list = Vec::new();
        for param in &self.signature().params {
            let name = &param.name;
            match param.kind {
                ParamKind::Scalar => list.push(quote!(self.#name)),
                ParamKind::Vec2 => list.extend([quote!(self.#name.x), quote!(self.#name.y)]),
                ParamKind::Vec3 | ParamKind::Direction => {
                    list.extend([quote!(self.#name.x), quote!(self.#name.y), quote!(self.#name.z)]);
                }
                ParamKind::Mat3 | ParamKind::Frame => {
                    for c in ["x", "y", "z"].map(|c| Ident::new(c, Span::call_site())) {
                        list.extend([
                            quote!(self.#name.#c.x),
                            quote!(self.#name.#c.y),
                            quote!(self.#name.#c.z),
                        ]);
                    }
                }
                ParamKind::Identity => {}
            }
        }
        for (name, _) in &self.parsed.constants {
            let name = Ident::new(name, Span::call_site());
            list.push(quote!(self.#name));
        }
        let p = self.scalars();
        for &i in &self.derived.limits {
            let parameter = &list[i as usize];
            list[i as usize] = quote!(::aether_core::support::beside_zero(#parameter));
        }
        quote!(let p: [R; #p] = [#(#list),*];)
    }
}

fn input(l: Leaf, unknown: &str) -> TokenStream {
    match l {
        Leaf::Unknown(i) | Leaf::Out(i) => {
            let name = Ident::new(unknown, Span::call_site());
            let i = Literal::usize_unsuffixed(i as usize);
            quote!(#name[#i])
        }
        Leaf::Param(i) => {
            let i = Literal::usize_unsuffixed(i as usize);
            quote!(p[#i])
        }
        Leaf::Bound(_) => super::numeric::variable(l),
    }
}

/// A point of the space from its coordinates.
pub(super) fn point(
    space: &Space,
    coordinates: &TokenStream,
    identity: Option<&TokenStream>,
) -> TokenStream {
    match space {
        Space::Line => quote!(#coordinates[0]),
        Space::Plane => quote!(::aether_core::Vec2::from_array(#coordinates)),
        Space::Volume => quote!(::aether_core::Vec3::from_array(#coordinates)),
        Space::Direction => {
            quote!(::aether_core::Direction::from_unit(::aether_core::Vec3::from_array(#coordinates)))
        }
        Space::SurfacePoint => {
            quote!(::aether_core::SurfacePoint::new(::aether_core::Vec3::from_array(#coordinates), #identity))
        }
        Space::Embedded { .. } => quote!(::aether_core::Embedded(#coordinates)),
    }
}

/// The point type of a space.
pub(super) fn point_type(space: &Space) -> TokenStream {
    match space {
        Space::Line => quote!(R),
        Space::Plane => quote!(::aether_core::Vec2<R>),
        Space::Volume => quote!(::aether_core::Vec3<R>),
        Space::Direction => quote!(::aether_core::Direction<R>),
        Space::SurfacePoint => quote!(::aether_core::SurfacePoint<R>),
        Space::Embedded { k, n } => quote!(::aether_core::Embedded<#k, #n, R>),
    }
}
