//! A sample and its density in one, where its point may have a preimage in the other of two pieces: nearly always the sample is
//! plain, and so is whether the other piece has its point.

use proc_macro2::TokenStream;
use quote::{format_ident, quote};

use super::exclusion::{exclusive, folded};
use super::inside;
use crate::emit::item::Emitter;
use crate::emit::pieces::{Place, is_unguarded};
use crate::emit::tame::Tame;

/// Whether plain samples have a way of their own: not where there are more than two pieces, of which others may coincide, or
/// guards, which are asked with error bounds.
pub(super) fn draws_plainly(e: &Emitter) -> bool {
    let is_plain = |place: &Place| is_unguarded(*place) && !place.derived.check_forward;
    e.parsed.pieces.len() == 2 && !e.has_surfaces() && e.places().iter().all(is_plain)
}

/// What returns a sample and its density where all uniforms take one piece and nothing there is in doubt; other samples go on.
/// It is what the general way finds, by the same operations, without the flags and the numbers that it keeps for what is
/// seldom.
pub(super) fn plain_sample(e: &Emitter) -> TokenStream {
    let places = e.places();
    let (_, m, _) = e.sizes();
    let (made, coordinates) = (e.point(&quote!(y)), e.coordinates());
    let pieces = e.by_piece(|j| {
        let [enter, both, exists] =
            ["enter", "both", "exists"].map(|name| format_ident!("{name}_{j}"));
        let (inside, others) = (inside(e, j, &quote!(t)), others(e, j, &places));
        quote! {
            if taken.all() {
                let t = #enter::<R>(&p, &u);
                let (y, d) = #both::<R>(&p, &t);
                let plain = ::aether_core::support::plain::<R, #m>(&y, d) #inside;
                if !plain.and(#exists::<R>(&p, &t)).all() {
                    break 'plain;
                }
                let point = #made;
                let mut sum = d;
                {
                    let point = &point;
                    let x = #coordinates;
                    #others
                }
                return (point, <R::Mask as Mask>::TRUE, ::aether_core::Density::new(sum));
            }
        }
    });
    quote!('plain: { #pieces })
}

/// Adds to `sum` the density by way of the other piece at the point of a sample of piece `j`; leaves the block where it is in
/// doubt whether there is one, or whether it is that of the sample itself, which lies next to an end that is no fold.
fn others(e: &Emitter, j: usize, places: &[Place]) -> TokenStream {
    let own: Vec<&Place> = places.iter().filter(|place| place.piece == j).collect();
    let overlapping = places
        .iter()
        .filter(|place| place.piece != j && own.iter().any(|own| !exclusive(e, own, place)));
    let terms = overlapping.map(|place| {
        let [plainly, possibly, density] =
            ["plainly", "possibly", "density"].map(|name| format_ident!("{name}_{}", place.number));
        let wide = place.wide();
        let is_fold = own.iter().any(|own| folded(own, place));
        let segments = e.parsed.pieces[j].problem.segments.iter().enumerate();
        let ends = segments
            .filter(|(_, s)| s.is_some() && !is_fold)
            .map(|(i, _)| quote!(if ::aether_core::support::at_end(t[#i]).any() { break 'plain; }));
        let tame = Tame::new(&place.problem.graph, false, false).all(&[place.preimage.density]);
        let known = (!tame).then(|| {
            quote!(if !d.ge(d).all() {
                break 'plain;
            })
        });
        quote! {
            let strict = #plainly::<R>(&p, &x) #wide;
            if strict.all() {
                #(#ends)*
                let d = #density::<R>(&p, &x);
                #known
                sum += R::select(d.gt(R::ZERO), d, R::ZERO);
            } else if strict.any() || (#possibly::<R>(&p, &x) #wide).any() {
                break 'plain;
            }
        }
    });
    quote!(#(#terms)*)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The function of a sample with its density, without spaces, of a sampler of the line.
    fn drawn(body: &str) -> String {
        let function = format!("fn f(u: [Uniform; 1]) -> f64 {{ {body} }}");
        let text = crate::sampler(TokenStream::new(), function.parse().unwrap()).to_string();
        let text = text.replace(' ', "");
        let (_, after) = text.split_once("fnforward_with_pdf(").unwrap();
        after.split_once("fnpreimages").unwrap().0.to_string()
    }

    #[test]
    fn plain_samples_ask_of_ends_only_where_there_is_no_fold() {
        let border = "if::aether_core::support::at_end(t[0usize]).any(){break'plain;}";
        // The images of both pieces overlap, and the map goes on upwards.
        let upwards = drawn("if u[0] < 0.25 { u[0].sqrt() } else { u[0] * u[0] }");
        assert!(upwards.contains("'plain:{") && upwards.contains(border), "{upwards}");
        assert!(upwards.contains("self.drawn_by_piece(u)"), "{upwards}");
        // Here it turns round where the pieces meet.
        let fold = drawn("if u[0] < 0.5 { u[0] * u[0] } else { 0.5 * (1.0 - u[0]) }");
        assert!(fold.contains("'plain:{") && !fold.contains(border), "{fold}");
    }

    #[test]
    fn three_pieces_have_no_quick_way() {
        let three = drawn(
            "if u[0] < 0.25 { u[0].sqrt() } else if u[0] < 0.5 { u[0] * u[0] } else { u[0].sqrt() - 0.5 }",
        );
        assert!(!three.contains("'plain:{"), "{three}");
    }
}
