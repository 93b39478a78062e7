//! Densities of points, and their logarithms.

use proc_macro2::TokenStream;
use quote::{format_ident, quote};

use super::exists::{existence, existence_where_it_belongs};
use crate::emit::item::{Emitter, point_type};
use crate::emit::pieces::Place;
use crate::emit::quick;
use crate::emit::seldom::numbers;
use crate::emit::tame::Tame;

/// The density at `point`; the method that tells it, if it is one of its own; and that for points whose coordinates are finite, if
/// it is another.
pub(super) fn density(e: &Emitter) -> [TokenStream; 3] {
    let (parameters, coordinates, belongs) = (e.parameters(), e.coordinates(), e.belongs());
    let density = match (e.support, quick::density(e)) {
        (Some(support), _) => {
            let (test, value) = (support.test(), support.value());
            support.where_it_belongs(e, &quote!(R::select(belongs #test, #value, R::ZERO)))
        }
        (None, Some(quick)) if quick::asks_of_others(e) => return density_where(e, &quick),
        (None, Some(quick)) => quote!(let belongs = || -> R::Mask { #belongs }; #quick),
        (None, None) => {
            let handed_on = numbers(e);
            quote!(pdf_anywhere::<R>(#handed_on #belongs, None))
        }
    };
    let density = quote! {
        #parameters
        let x = #coordinates;
        ::aether_core::Density::new({ #density })
    };
    [density, quote!(), quote!()]
}

/// The same by a method that is told whether the point belongs to the space.
fn density_where(e: &Emitter, quick: &TokenStream) -> [TokenStream; 3] {
    let (parameters, coordinates, belongs) = (e.parameters(), e.coordinates(), e.belongs());
    let (ty, args, point) = (e.density_type(), e.generics(), point_type(&e.signature().space));
    let (outside, inside) = e.bounds();
    let method = quote! {
        impl #outside #ty #args {
            #[inline(always)]
            fn density_where #inside(&self, point: &#point, belongs: impl Fn() -> R::Mask) -> ::aether_core::PdfOf<Self, R> {
                #parameters
                let x = #coordinates;
                ::aether_core::Density::new(#quick)
            }
        }
    };
    let density = quote! {
        let x = #coordinates;
        self.density_where(point, || #belongs)
    };
    let of_finite = quote! {
        #[inline(always)]
        fn pdf_of_finite(&self, point: &Self::Point) -> ::aether_core::PdfOf<Self, R> {
            self.density_where(point, || <R::Mask as Mask>::TRUE)
        }
    };
    [density, method, of_finite]
}

/// [`pdf_near`](::aether_core::Sampler::pdf_near), unless every point of the space has a density.
pub(super) fn density_near(e: &Emitter) -> Option<TokenStream> {
    let (parameters, coordinates, belongs) = (e.parameters(), e.coordinates(), e.belongs());
    let (_, m, _) = e.sizes();
    let density = match e.support {
        Some(support) => support.density_near(e)?,
        None => {
            let handed_on = numbers(e);
            quote!(pdf_anywhere::<R>(#handed_on #belongs, Some(&errors)))
        }
    };
    Some(quote! {
        fn pdf_near(
            &self,
            point: &Self::Point,
            errors: ::aether_core::sampler::Errors<'_, Self::Point, R>,
        ) -> ::aether_core::PdfOf<Self, R> {
            #parameters
            let x = #coordinates;
            let errors = || -> [R; #m] { ::aether_core::support::numbers(errors()) };
            ::aether_core::Density::new(#density)
        }
    })
}

/// The density at any point, where it is known which belong to the space and by how much coordinates may be off.
pub(in crate::emit) fn general_density(e: &Emitter) -> TokenStream {
    let existence = existence_where_it_belongs(e, true);
    let (n, _, _) = e.sizes();
    let places = e.places();
    let single = places.len() == 1;
    let terms = places.into_iter().map(|place| {
        let [strict, recovered] =
            ["strict", "recovered"].map(|name| format_ident!("{name}_{}", place.number));
        let value = value_at(e, place, &quote!(inside));
        let sum = if single { quote!(sum = d) } else { quote!(sum += d) };
        quote! {
            let inside = #strict.or(::aether_core::support::lanes_of::<R, #n>(&#recovered));
            if inside.any() {
                let d = #value;
                let d = R::select(inside.and(d.gt(R::ZERO)), d, R::ZERO);
                #sum;
            }
        }
    });
    quote! {
        #existence
        let mut sum = R::ZERO;
        #(#terms)*
        sum
    }
}

/// The density at `x` by way of a preimage, or its limit where it is 0/0 and `wanted`.
pub(in crate::emit) fn value_at(e: &Emitter, place: Place, wanted: &TokenStream) -> TokenStream {
    let (_, m, s) = e.sizes();
    let density = format_ident!("density_{}", place.number);
    if Tame::new(&place.problem.graph, false, false).all(&[place.preimage.density]) {
        quote!(#density::<R>(&p, &x))
    } else {
        quote!(::aether_core::support::limit::<R, #s, #m>(#wanted, &p, &x, #density::<R>))
    }
}

/// The logarithm of the density where the density has left the range of numbers.
pub(super) fn log_density(e: &Emitter) -> TokenStream {
    let existence = existence(e);
    let (n, _, _) = e.sizes();
    let (parameters, coordinates) = (e.parameters(), e.coordinates());
    let terms = e.places().into_iter().map(|place| {
        let [density, strict, recovered] = ["log_density", "strict", "recovered"]
            .map(|name| format_ident!("{name}_{}", place.number));
        quote! {
            let inside = #strict.or(::aether_core::support::lanes_of::<R, #n>(&#recovered));
            if inside.any() {
                let d = #density::<R>(&p, &x);
                let d = R::select(inside.and(d.ge(d)), d, -R::INFINITY);
                sum = ::aether_core::support::add_logs(sum, d);
            }
        }
    });
    quote! {
        fn log_pdf(&self, point: &Self::Point) -> R {
            let density = ::aether_core::Sampler::pdf(self, point).value();
            ::aether_core::support::log_density(density, || {
                #parameters
                let x = #coordinates;
                #existence
                let mut sum = -R::INFINITY;
                #(#terms)*
                sum
            })
        }
    }
}
