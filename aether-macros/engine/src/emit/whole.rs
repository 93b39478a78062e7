//! Uniform densities whose support is all of a sphere, a hemisphere or a disk: membership needs no inverse.

use std::f64::consts::{PI, TAU};

use proc_macro2::TokenStream;
use quote::quote;

use super::code::number;
use super::item::Emitter;
use crate::expr::Id;
use crate::interpret::Item;
use crate::parse::Space;

/// A support that a short test decides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Support {
    /// All directions.
    Sphere,
    /// Directions above the plane z = 0.
    Hemisphere,
    /// The unit disk about the origin.
    Disk,
}

/// How many points are tried.
const TRIED: usize = 200;

impl Support {
    /// The support of an item without parameters, if its density is one over the measure of a known set at all
    /// points of that set that are tried, and zero at the others. Since it integrates to one, what it covers
    /// has the measure of the set: there is no room for another support.
    pub fn of(item: &Item) -> Option<Self> {
        let problem = &item.parsed.pieces[0].problem;
        let known = match item.parsed.signature.space {
            Space::Direction => [Support::Sphere, Support::Hemisphere].as_slice(),
            Space::Plane => &[Support::Disk],
            _ => &[],
        };
        if !problem.kinds.is_empty() || problem.argument.is_some() {
            return None;
        }
        let mut pieces = item.parsed.pieces.iter().zip(&item.derived);
        let is_constant = |(piece, derived): (&crate::parse::Piece, &crate::derive::Derived)| {
            let g = &piece.problem.graph;
            let constant = |id: Id| g.deps(id) == 0;
            piece.problem.requirements.is_empty()
                && constant(derived.volume)
                && derived.preimages.iter().all(|p| constant(p.density))
        };
        if !pieces.all(is_constant) {
            return None;
        }
        known.iter().copied().find(|support| support.is_that_of(item))
    }

    fn is_that_of(self, item: &Item) -> bool {
        (0..TRIED).all(|i| {
            let x = self.point(i);
            let expected = if self.contains(&x) { self.density() } else { 0.0 };
            (item.pdf(&[], &x) - expected).abs() <= 1e-9 * self.density()
        })
    }

    /// Points spread over the space (golden section), none of which lies on the border.
    fn point(self, i: usize) -> Vec<f64> {
        let s = (i as f64 + 0.5) / TRIED as f64;
        let turn = TAU * (i as f64 * 0.618_033_988_749_894_9 + 0.1).fract();
        let (sine, cosine) = (libm::sin(turn), libm::cos(turn));
        if self == Support::Disk {
            let r = 1.5 * libm::sqrt(s);
            return vec![r * cosine, r * sine];
        }
        let z = 1.0 - 2.0 * s;
        let r = libm::sqrt(1.0 - z * z);
        vec![r * cosine, r * sine, z]
    }

    fn contains(self, x: &[f64]) -> bool {
        match self {
            Support::Sphere => true,
            Support::Hemisphere => x[2] > 0.0,
            Support::Disk => x[0] * x[0] + x[1] * x[1] < 1.0,
        }
    }

    fn density(self) -> f64 {
        match self {
            Support::Sphere => 0.5 / TAU,
            Support::Hemisphere => 1.0 / TAU,
            Support::Disk => 1.0 / PI,
        }
    }

    /// The constant.
    pub(super) fn value(self) -> TokenStream {
        number(self.density())
    }

    /// A density of points where they `belong` to the space as far as the test does not tell it: of a disk no infinite
    /// point passes it.
    pub(super) fn where_it_belongs(self, e: &Emitter, density: &TokenStream) -> TokenStream {
        if self == Support::Disk {
            return quote!({ let belongs = <R::Mask as Mask>::TRUE; #density });
        }
        let (_, m, _) = e.sizes();
        quote!(::aether_core::support::where_finite::<R, #m>(&x, move |belongs| #density))
    }

    /// Whether a point with finite coordinates `x` belongs to it, where rounding may have moved it.
    pub(super) fn test(self) -> TokenStream {
        self.test_within(&quote!(R::of(16.0) * R::EPSILON))
    }

    /// The density at a point whose coordinates may be off by what `errors` tells; nothing, if no error leads outside.
    pub(super) fn density_near(self, e: &Emitter) -> Option<TokenStream> {
        if self == Support::Sphere {
            return None;
        }
        let (test, value) = (self.test_within(&quote!(slack)), self.value());
        let density = self.where_it_belongs(e, &quote!(R::select(belongs #test, #value, R::ZERO)));
        Some(quote! {
            {
                // The square of a radius of one is off by twice as much as the radius.
                let most = errors().into_iter().fold(R::ZERO, |most, error| most + error);
                let slack = R::of(16.0) * (R::EPSILON + most);
                #density
            }
        })
    }

    fn test_within(self, slack: &TokenStream) -> TokenStream {
        match self {
            Support::Sphere => quote!(),
            Support::Hemisphere => quote!(.and(x[2].ge(-(#slack)))),
            Support::Disk => {
                quote!(.and((x[0] * x[0] + x[1] * x[1]).le(R::ONE + #slack)))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn support(body: &str) -> Option<Support> {
        let text = format!("fn s(u: [Uniform; 2]) -> Direction {{ {body} }}");
        let item = Item::new(TokenStream::new(), text.parse().unwrap(), true).unwrap();
        Support::of(&item)
    }

    #[test]
    fn supports_are_recognised_and_others_are_not() {
        let cap = |z: &str| {
            support(&format!(
                "let z = {z}; let r = (1.0 - z * z).sqrt(); let p = TAU * u[1];
                 Direction::new(r * p.cos(), r * p.sin(), z)"
            ))
        };
        assert_eq!(cap("1.0 - 2.0 * u[0]"), Some(Support::Sphere));
        assert_eq!(cap("u[0]"), Some(Support::Hemisphere));
        assert_eq!(cap("-u[0]"), None);
        assert_eq!(cap("0.5 * u[0]"), None);
        // Twice over the upper half: as much measure, but not the sphere.
        assert_eq!(cap("(1.0 - 2.0 * u[0]).abs()"), Some(Support::Hemisphere));
        assert_eq!(cap("u[0].sqrt()"), None);
    }
}
