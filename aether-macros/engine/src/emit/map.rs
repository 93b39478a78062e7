//! `impl Map`.

use proc_macro2::{Literal, TokenStream};
use quote::{format_ident, quote};

use super::item::{Emitter, point, point_type};
use crate::expr::Id;
use crate::jacobian::{cost, cost_together};
use crate::parse::{Source, Space};

/// The implementation of the trait for a map whose inverse was derived.
pub fn implementation(e: &Emitter) -> TokenStream {
    let (ty, args) = (e.type_name(), e.generics());
    let Source::Point { space: source, .. } = &e.signature().source else { return quote!() };
    let (source_ty, target_ty) = (point_type(source), point_type(&e.signature().space));
    let parameters = e.parameters();
    let made = e.point(&quote!(c));
    let (_, m, _) = e.sizes();
    let [visits, visits_near] = [false, true].map(|near| visits(e, source, near));
    let (forward, jacobian) = (forward(e), jacobian(e));
    let pushed = pushed(e);
    let coordinates = e.coordinates();
    let injective = e.places().len() <= 1;
    let members = e.places().into_iter().filter(|place| place.derived.check_forward);
    let members = members.map(|place| e.member(place, &quote!(::aether_core::support::track(x))));
    quote! {
        #(#members)*

        #[automatically_derived]
        impl<R: Real> ::aether_core::Map<R> for #ty #args {
            type Source = #source_ty;
            type Target = #target_ty;
            const INJECTIVE: bool = #injective;

            #[inline(always)]
            fn forward(&self, point: &Self::Source) -> (Self::Target, R::Mask) {
                #parameters
                let u = point.coordinates();
                #forward
                (#made, exists)
            }

            #[inline(always)]
            fn preimages(&self, point: &Self::Target, mut visit: impl FnMut(Self::Source, R::Mask)) {
                #parameters
                let x = #coordinates;
                #visits
            }

            fn preimages_near(
                &self,
                point: &Self::Target,
                errors: ::aether_core::sampler::Errors<'_, Self::Target, R>,
                mut visit: impl FnMut(Self::Source, ::aether_core::sampler::Errors<'_, Self::Source, R>, R::Mask),
            ) {
                #parameters
                let x = #coordinates;
                let errors = || -> [R; #m] { ::aether_core::support::numbers(errors()) };
                #visits_near
            }

            #[inline(always)]
            fn jacobian(&self, point: &Self::Source) -> R {
                #parameters
                let u = point.coordinates();
                #jacobian
            }

            #pushed
        }
    }
}

/// The density of a point from that of its only preimage, where what it is multiplied by costs no more in terms of the point,
/// beside its preimage, than the change of measure in terms of the preimage: the point is not rounded once more.
fn pushed(e: &Emitter) -> Option<TokenStream> {
    let places = e.places();
    let (&[place], true) = (&places[..], e.is_whole()) else { return None };
    let (g, preimage) = (&place.problem.graph, place.preimage);
    let known = [&preimage.unknowns[..], &preimage.tested, &preimage.conditions].concat();
    let more =
        cost_together(g, &[&known[..], &[preimage.density]].concat()) - cost_together(g, &known);
    let volume = cost(g, place.derived.volume);
    let (parameters, coordinates) = (e.parameters(), e.coordinates());
    (volume > 0 && more <= volume).then(|| {
        quote! {
            #[inline(always)]
            fn pushed(&self, density: R, (_, point): (&Self::Source, &Self::Target)) -> R {
                #parameters
                let x = #coordinates;
                density * density_0::<R>(&p, &x)
            }
        }
    })
}

/// Binds the coordinates `c` of the image and whether it `exists`.
fn forward(e: &Emitter) -> TokenStream {
    if e.is_whole() {
        return quote!(let (c, exists) = (forward_0::<R>(&p, &u), exists_0::<R>(&p, &u)););
    }
    let (_, m, _) = e.sizes();
    let pieces = e.by_piece(|j| {
        let [forward, exists] = ["forward", "exists"].map(|name| format_ident!("{name}_{j}"));
        quote! {
            let y = #forward::<R>(&p, &u);
            c = ::core::array::from_fn(|i| R::select(taken, y[i], c[i]));
            exists = exists.or(taken.and(#exists::<R>(&p, &u)));
        }
    });
    quote! {
        let mut c = [R::ZERO; #m];
        let mut exists = <R::Mask as Mask>::FALSE;
        #pieces
    }
}

fn jacobian(e: &Emitter) -> TokenStream {
    if e.is_whole() {
        return quote!(volume_0::<R>(&p, &u));
    }
    let pieces = e.by_piece(|j| {
        let volume = format_ident!("volume_{j}");
        quote!(jacobian = R::select(taken, #volume::<R>(&p, &u), jacobian);)
    });
    quote! {
        let mut jacobian = R::ZERO;
        #pieces
        jacobian
    }
}

/// Calls `visit` with each preimage; `near` with bounds for the errors that it has by those of the point.
fn visits(e: &Emitter, source: &Space, near: bool) -> TokenStream {
    let belongs = e.belongs();
    let (n, m, s) = e.sizes();
    let each = e.places().into_iter().map(|place| {
        let (k, j) = (place.number, place.piece);
        let (inverse, support) = (format_ident!("inverse_{k}"), format_ident!("support_{k}"));
        let guards = format_ident!("guards_{j}");
        let guarded =
            (!place.problem.guards.is_empty()).then(|| quote!(.and(#guards::<R>(&p, &checked))));
        let made = point(source, &quote!(u), None);
        let bounds = near.then(|| {
            let tracked = e.tracked();
            quote! {
                &|| ::aether_core::support::errors_of::<R, #n>(|i| {
                    let (p, x) = (&::aether_core::support::lane(&p, i), &::aether_core::support::lane(&x, i));
                    let errors = ::aether_core::support::lane(&errors(), i);
                    let tx = ::aether_core::support::widened::<R::Lane, #m>(#tracked, Some(errors));
                    #inverse::<<R::Lane as Single>::Tracked>(&::aether_core::support::track(p), &tx)
                }),
            }
        });
        let member = format_ident!("member_{k}");
        let membership = place.derived.check_forward.then(|| {
            quote! {
                let ok = ok.and(::aether_core::support::member::<R, #m, #s>(ok, &p, &x, #member::<R::Lane>));
            }
        });
        // What is made of finite numbers between bounds is finite.
        let g = &place.problem.graph;
        let is_bounded = |u: &Id| g.range(*u).lo.is_finite() && g.range(*u).hi.is_finite();
        let open = (0..n).filter(|i| !is_bounded(&place.preimage.unknowns[*i]));
        let open: Vec<Literal> = open.map(Literal::usize_unsuffixed).collect();
        let count = open.len();
        let finite = (count > 0)
            .then(|| quote!(.and(::aether_core::support::finite::<R, #count>(&[#(u[#open]),*]))));
        quote! {
            {
                let (checked, _, ok, _) = #support::<R>(&p, &x);
                let ok = ok.and(belongs) #guarded;
                #membership
                if ok.any() {
                    let u = #inverse::<R>(&p, &x);
                    visit(#made, #bounds ok #finite);
                }
            }
        }
    });
    quote! {
        let belongs: R::Mask = #belongs;
        #(#each)*
    }
}

#[cfg(test)]
mod tests {
    /// What is emitted for a map.
    fn text(function: &str) -> String {
        crate::map(Default::default(), function.parse().unwrap()).to_string()
    }

    #[test]
    fn a_density_is_told_by_the_point_where_that_is_shorter() {
        let onto_plane = text(
            "fn onto(w: Direction, o: Vec3, point: Vec3, normal: Direction, id: SurfaceId) -> SurfacePoint {
                let t = normal.dot(point - o) / normal.dot(w);
                require(t > 0.0);
                SurfacePoint::new(o + t * w, id)
            }",
        );
        assert!(onto_plane.contains("fn pushed"));
        // The cosine of the height above the point over the squared distance: no parameter of the plane but its normal.
        let density = onto_plane.split("fn density_0").nth(1).unwrap().split("fn ").next().unwrap();
        assert!(density.contains("p [6") && !density.contains("p [3"), "{density}");
        // What stretches everything alike, and nothing at all.
        assert!(!text("fn twice(x: Vec2, k: f64) -> Vec2 { k * x }").contains("fn pushed"));
        let turned = "fn turned(w: Direction, frame: Frame) -> Direction { frame.to_world(w) }";
        assert!(!text(turned).contains("fn pushed"));
    }
}
