//! The kinds of densities that a vertex may have.

use proc_macro2::{Span, TokenStream};
use quote::quote_spanned;

use crate::strategy::tree::{Action, End, Kind, Leaf};

/// Which kinds of vertices some code may end in.
#[derive(Clone, Copy, Default, PartialEq)]
pub(super) struct Kinds {
    pub(super) density: bool,
    pub(super) position: bool,
    pub(super) direction: bool,
}

impl Kinds {
    pub(super) fn of_end(end: &End<Action, Leaf>) -> Kinds {
        match end {
            End::Stop => Kinds::default(),
            End::Delegate { .. } => Kinds { density: true, position: true, direction: true },
            End::Vertex(leaf) => match leaf.kind {
                Kind::Density(_) => Kinds { density: true, ..Kinds::default() },
                Kind::AtomPosition => Kinds { position: true, ..Kinds::default() },
                Kind::AtomDirection(_) => Kinds { direction: true, ..Kinds::default() },
            },
            End::If { then, otherwise, .. } => {
                Kinds::of_end(&then.end).and(Kinds::of_end(&otherwise.end))
            }
            End::Match { arms, .. } => arms
                .iter()
                .fold(Kinds::default(), |kinds, (_, arm)| kinds.and(Kinds::of_end(&arm.end))),
        }
    }

    pub(super) fn and(self, other: Kinds) -> Kinds {
        Kinds {
            density: self.density || other.density,
            position: self.position || other.position,
            direction: self.direction || other.direction,
        }
    }

    /// Whether the kind that is asked for is one of these: elsewhere nothing is evaluated.
    pub(super) fn asked(self) -> TokenStream {
        let site = Span::mixed_site();
        let dirac = quote_spanned!(site=> ::aether_core::strategy::Dirac);
        let is = |wanted: bool, kind: TokenStream| wanted.then_some(kind);
        let some = quote_spanned!(site=> ::core::option::Option::Some);
        let kinds = [
            is(self.density, quote_spanned!(site=> ::core::option::Option::None)),
            is(self.position, quote_spanned!(site=> #some(#dirac::Position))),
            is(self.direction, quote_spanned!(site=> #some(#dirac::Direction))),
        ];
        let kinds = kinds.iter().flatten();
        quote_spanned!(site=> ::core::matches!(kind, #(#kinds)|*))
    }
}
