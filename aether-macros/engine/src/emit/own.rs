//! The density of a sample from its uniforms.

use proc_macro2::TokenStream;
use quote::{format_ident, quote};

use super::item::Emitter;
use super::sampler::existence;

/// The Jacobian at the uniforms, and the densities by way of the other preimages.
pub(super) fn own_density(e: &Emitter) -> TokenStream {
    if e.is_whole() && e.places().len() == 1 { single(e) } else { among_several(e) }
}

fn single(e: &Emitter) -> TokenStream {
    let (n, m, _) = e.sizes();
    let made = e
        .point(&quote!(::aether_core::support::closed::<R, #n, #m>(&u, |t| forward_0::<R>(&p, t))));
    quote! {
        let d = R::ONE / volume_0::<R>(&p, &u);
        // At a uniform of zero the map may only have a limit (a pole, an axis), and so may the
        // Jacobian; the density at the point knows it.
        let inner = u.iter().fold(d.ge(R::ZERO), |m, u| m.and(u.gt(R::ZERO)));
        if inner.all() {
            ::aether_core::Density::new(d)
        } else {
            let limit = ::aether_core::Sampler::pdf(self, &#made).value();
            ::aether_core::Density::new(R::select(inner, d, limit))
        }
    }
}

/// Of the preimages in the piece that `u` takes, the nearest is `u` itself: its density is that of
/// the uniforms, not of the rounded point.
fn among_several(e: &Emitter) -> TokenStream {
    let (n, m, _) = e.sizes();
    let coordinates = e.coordinates();
    let existence = existence(e);
    let jacobians = jacobians(e);
    let distances = e.places().into_iter().map(|place| {
        let [distance, strict, recovered, inverse] = ["distance", "strict", "recovered", "inverse"]
            .map(|name| format_ident!("{name}_{}", place.number));
        let [leave, taken] = ["leave", "taken"].map(|name| format_ident!("{name}_{}", place.piece));
        // On a border `u` itself may have been found in the other piece.
        let mine = (!e.is_whole()).then(|| {
            quote!(.and(#taken::<R>(&p, &u).or(::aether_core::support::coincide(&u, &v))))
        });
        quote! {
            let inside = #strict.or(::aether_core::support::lanes_of::<R, #n>(&#recovered));
            let #distance = if inside.any() {
                let v = ::aether_core::support::merged::<R, #n>(#recovered, #strict, || #leave::<R>(&p, &#inverse::<R>(&p, &x)));
                R::select(inside #mine, ::aether_core::support::distance(&u, &v), R::INFINITY)
            } else {
                R::INFINITY
            };
            nearest = nearest.min(#distance);
        }
    });
    let others = e.places().into_iter().map(|place| {
        let [distance, strict, recovered, density] = ["distance", "strict", "recovered", "density"]
            .map(|name| format_ident!("{name}_{}", place.number));
        quote! {
            let itself = #distance.le(nearest).and(#distance.lt(R::INFINITY)).and(counted.not());
            counted = counted.or(itself);
            let inside = #strict.or(::aether_core::support::lanes_of::<R, #n>(&#recovered));
            let other = inside.and(itself.not());
            if other.any() {
                let d = ::aether_core::support::limit::<R, #m>(other, &x, |x| #density::<R>(&p, x));
                sum += R::select(other.and(d.gt(R::ZERO)), d, R::ZERO);
            }
        }
    });
    quote! {
        let (point, exists) = ::aether_core::Sampler::forward(self, u);
        let mut sum = R::ZERO;
        let mut inner = <R::Mask as Mask>::FALSE;
        #jacobians
        // At an end of a piece the map may only have a limit; the density at the point knows it.
        let outer = exists.and(inner.not());
        let limit = if outer.any() {
            ::aether_core::Sampler::pdf(self, &point).value()
        } else {
            R::ZERO
        };
        if !exists.and(inner).any() {
            return ::aether_core::Density::new(R::select(outer, limit, R::ZERO));
        }
        let point = &point;
        let x = #coordinates;
        #existence
        let mut nearest = R::INFINITY;
        #(#distances)*
        let mut counted = <R::Mask as Mask>::FALSE;
        #(#others)*
        ::aether_core::Density::new(R::select(exists, R::select(inner, sum, limit), R::ZERO))
    }
}

/// Adds to `sum` the density from the Jacobian of the piece that `u` takes; `inner` says whether it
/// has one there.
fn jacobians(e: &Emitter) -> TokenStream {
    let one = |j: usize| {
        let [enter, volume] = ["enter", "volume"].map(|name| format_ident!("{name}_{j}"));
        let (entered, taken) = if e.is_whole() {
            (quote!(u), quote!(<R::Mask as Mask>::TRUE))
        } else {
            (quote!(#enter::<R>(&p, &u)), quote!(taken))
        };
        quote! {
            let t = #entered;
            let d = R::ONE / #volume::<R>(&p, &t);
            let here = t.iter().fold(#taken.and(d.ge(R::ZERO)), |m, t| m.and(t.gt(R::ZERO)));
            sum = R::select(here, d, sum);
            inner = inner.or(here);
        }
    };
    if e.is_whole() { one(0) } else { e.by_piece(one) }
}
