//! The parts that samplers and maps share: the struct, its constructor, the hidden body.

use proc_macro2::{Ident, Literal, TokenStream};
use quote::{format_ident, quote};
use syn::ItemFn;

use super::documentation::{Texts, accuracy, measures};
use super::interface::{bound, hidden_body, interface};
use super::ways::Ways;
use super::whole::Support;
use crate::derive::{Accuracy, Atom, Derived};
use crate::diagnostics::warning;
use crate::parse::{Options, Parsed, Signature, Source, Space, type_name};

/// Writes the code of one item.
pub struct Emitter<'a> {
    /// The user's function.
    pub item: &'a ItemFn,
    /// What was parsed.
    pub parsed: &'a Parsed,
    /// What was derived, for each piece.
    pub derived: &'a [Derived],
    /// The atoms, a way to one each.
    pub atoms: &'a [Atom],
    /// The same as text.
    pub texts: &'a Texts,
    /// The attribute's arguments.
    pub options: &'a Options,
    /// The support of a uniform density, if it is one of a few.
    pub support: Option<Support>,
    /// The branches that lead to the pieces, if they are told by them.
    pub ways: Option<Ways>,
    /// Which pieces meet, as far as it was asked.
    pub meeting: super::meeting::Known,
}

impl Emitter<'_> {
    pub(super) fn signature(&self) -> &Signature {
        &self.parsed.signature
    }
    /// Numbers of unknowns, of coordinates of the result, and of scalar parameters.
    pub(super) fn sizes(&self) -> (usize, usize, usize) {
        let problem = &self.parsed.pieces[0].problem;
        (problem.unknowns.len(), problem.outputs.len(), self.scalars())
    }
    /// The point with coordinates `c`.
    pub(super) fn point(&self, c: &TokenStream) -> TokenStream {
        self.point_with(c, &self.parsed.identities)
    }
    /// The same on these surfaces.
    pub(super) fn point_with(&self, c: &TokenStream, identities: &[TokenStream]) -> TokenStream {
        let Space::Joint(parts) = &self.signature().space else {
            return point(&self.signature().space, c, identities.first());
        };
        let (mut first, mut surfaces) = (0, identities.iter());
        let points = parts.iter().map(|part| {
            let n = part.dimensions().1;
            let coordinates = (first..first + n).map(|i| quote!(c[#i]));
            let identity = if *part == Space::SurfacePoint { surfaces.next() } else { None };
            first += n;
            point(part, &quote!([#(#coordinates),*]), identity)
        });
        let points: Vec<TokenStream> = points.collect();
        quote!({ let c = #c; (#(#points),*) })
    }

    /// The coordinates of `point`, as an array.
    pub(super) fn coordinates(&self) -> TokenStream {
        let (_, m, _) = self.sizes();
        match &self.signature().space {
            Space::Joint(_) => quote!(::aether_core::support::flat::<R, _, #m>(point)),
            _ => quote!(point.coordinates()),
        }
    }

    /// Whether points name the surface that they lie on.
    pub(super) fn has_surfaces(&self) -> bool {
        self.signature().space.parts().contains(&Space::SurfacePoint)
    }

    /// Whether `point` has finite coordinates `x` and lies on the right surfaces.
    pub(super) fn belongs(&self) -> TokenStream {
        let parts = self.signature().space.parts();
        let on_surface = (0..parts.len()).filter(|i| parts[*i] == Space::SurfacePoint);
        let tests = on_surface.zip(&self.parsed.identities).map(|(i, identity)| {
            let part = match parts.len() {
                1 => quote!(point),
                _ => {
                    let i = Literal::usize_unsuffixed(i);
                    quote!(point.#i)
                }
            };
            quote!(.and(::aether_core::support::mask(#part.surface == #identity)))
        });
        let (_, m, _) = self.sizes();
        quote!(::aether_core::support::finite::<R, #m>(&x) #(#tests)*)
    }

    /// The coordinates `x` with the bounds of their rounding: those of directions are rounded relative
    /// to one.
    pub(super) fn tracked(&self) -> TokenStream {
        let parts = self.signature().space.parts();
        match &parts[..] {
            [Space::Direction] => quote!(::aether_core::support::track_unit(x)),
            _ if !parts.contains(&Space::Direction) => quote!(::aether_core::support::track(x)),
            _ => {
                let unit = parts
                    .iter()
                    .flat_map(|part| vec![*part == Space::Direction; part.dimensions().1]);
                quote!(::aether_core::support::track_some(x, &[#(#unit),*]))
            }
        }
    }

    /// `R`, or nothing for an item without parameters.
    pub(super) fn generics(&self) -> TokenStream {
        if self.is_generic() { quote!(<R>) } else { quote!() }
    }
    /// What declares the number type for the type, and for each of its methods where the type says nothing of it.
    pub(super) fn bounds(&self) -> (Option<TokenStream>, Option<TokenStream>) {
        let bounds = quote!(<R: Real>);
        if self.is_generic() { (Some(bounds), None) } else { (None, Some(bounds)) }
    }
    fn is_generic(&self) -> bool {
        self.signature().params.iter().any(|p| p.kind.is_real())
            || !self.parsed.constants.all.is_empty()
    }

    /// Name of the struct: the function's name in camel case.
    pub(super) fn type_name(&self) -> Ident {
        type_name(&self.signature().name)
    }

    /// Name of the struct that has a density: of a distribution with atoms it is another one.
    pub(super) fn density_type(&self) -> Ident {
        let whole = self.type_name();
        if self.signature().mixed { format_ident!("{whole}Continuous") } else { whole }
    }

    /// How many scalar parameters there are.
    pub(super) fn scalars(&self) -> usize {
        self.parsed.pieces[0].problem.kinds.iter().map(crate::points::Kind::scalars).sum()
    }

    /// Everything.
    pub fn emit(&self, sampler: bool) -> TokenStream {
        let docs = self.texts.attributes(self.signature(), self.derived, sampler);
        let (constants, moved) = (&self.parsed.constants, self.moved());
        let moved: Vec<&Ident> = moved.into_iter().map(|(_, name)| name).collect();
        let interface =
            interface(self.item, self.signature(), self.options, (constants, &moved), &docs);
        let implementation = if sampler {
            let density = super::sampler::implementation(self);
            if self.signature().mixed {
                super::atoms::implementation(self, &density)
            } else {
                density
            }
        } else {
            super::map::implementation(self)
        };
        let derivation = self.derivation();
        let hidden = hidden_body(self.item);
        let functions = self.functions();
        let warning = self.warning();
        quote! {
            #interface
            #warning
            #[allow(clippy::all, clippy::pedantic, unused, non_snake_case)]
            const _: () = {
                use ::aether_core::{Real as _, Mask as _, Single as _, Point as _};
                use ::aether_core::real::{Mask, Real, Single};
                #hidden
                #functions
                #derivation
                #implementation
            };
        }
    }

    /// Prints the derivation to the build's output.
    pub fn explain(&self) {
        let Texts { forward, inverse, jacobian, pdf, numerical, .. } = self.texts;
        eprintln!("{}:", self.signature().name);
        for line in forward.lines() {
            eprintln!("  map      {line}");
        }
        for (piece, derived) in self.parsed.pieces.iter().zip(self.derived) {
            let g = &piece.problem.graph;
            let computed: Vec<String> =
                derived.forward.iter().map(|f| crate::display::show(g, *f)).collect();
            eprintln!("  computed ({})", computed.join(", "));
            for step in &derived.steps {
                eprintln!("  step     {step}");
            }
        }
        for line in inverse.lines() {
            eprintln!("  inverse  {line}");
        }
        for line in jacobian.lines() {
            eprintln!("  √det JᵀJ {line}");
        }
        let sampler = matches!(self.signature().source, Source::Uniforms { .. });
        if sampler {
            eprintln!("  pdf      {pdf}");
            self.texts.atoms.iter().for_each(|line| eprintln!("  {line}"));
        }
        eprintln!("  measure  {}", measures(self.signature()));
        eprintln!("  {}", self.texts.preimages(self.derived, sampler));
        if let Some(text) = numerical {
            eprintln!("  {}", text.trim_end());
        }
        let what = if sampler { "density" } else { "Jacobian" };
        eprintln!("  worst relative error of the {what} in f64: {}", self.accuracy().density);
    }

    /// The largest errors that were seen, over all pieces.
    fn accuracy(&self) -> Accuracy {
        accuracy(self.derived)
    }

    /// A warning if what was derived has lost more than half of its digits somewhere.
    fn warning(&self) -> Option<TokenStream> {
        let sampler = matches!(self.signature().source, Source::Uniforms { .. });
        let text = self.accuracy().complaint(&self.signature().name.to_string(), sampler)?;
        Some(warning(&self.signature().name, &self.item.attrs, &text))
    }

    fn derivation(&self) -> TokenStream {
        let Texts { forward, inverse, jacobian, pdf, atoms, .. } = self.texts;
        let pdf = std::iter::once(pdf).chain(atoms).cloned().collect::<Vec<_>>().join("; ");
        let name = self.signature().name.to_string();
        let measure = self.signature().space.measure();
        let preimages = Literal::usize_unsuffixed(self.places().len());
        let worst = bound(self.accuracy().density.error);
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
        Space::Joint(_) => quote!(compile_error!("a joint point inside a joint point")),
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
        Space::Joint(parts) => {
            let parts = parts.iter().map(point_type);
            quote!((#(#parts),*))
        }
    }
}
