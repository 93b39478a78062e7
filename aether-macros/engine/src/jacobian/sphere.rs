//! The change of measure of a direction in terms of its height and its azimuth.
//!
//! A unit vector (A cos t, A sin t, h) covers the area |∂(h, t)|: that of a cylinder around the sphere
//! (Archimedes). How A follows from h does not matter, so none of its roots is ever differentiated.

use super::{distinct, simplify};
use crate::derivative::derivative;
use crate::expr::{Fun, Graph, Id, Leaf};
use crate::solve::polar::with_factor;

/// Equal expressions for the area that a unit vector covers, if two of its coordinates are a cosine and
/// a sine with the same amplitude.
pub fn area(g: &mut Graph, outputs: &[Id], unknowns: &[Leaf]) -> Option<Vec<Id>> {
    let (&[_, _, _], &[u, v]) = (outputs, unknowns) else { return None };
    let (height, angle) = [(0, 1, 2), (1, 2, 0), (2, 0, 1)].iter().find_map(|&(i, j, k)| {
        let angle = shared_angle(g, outputs[i], outputs[j])?;
        Some((outputs[k], angle))
    })?;
    let mut slopes = |x| [u, v].map(|l| derivative(g, x, l));
    let ([h_u, h_v], [t_u, t_v]) = (slopes(height), slopes(angle));
    let (first, second) = (g.mul(h_u, t_v), g.mul(h_v, t_u));
    let d = g.sub(first, second);
    let tidy = simplify(g, d, None);
    Some(distinct([tidy, d].map(|d| g.call(Fun::Abs, &[d])).to_vec()))
}

/// The t of A cos t and A sin t, in any order.
fn shared_angle(g: &mut Graph, a: Id, b: Id) -> Option<Id> {
    [(a, b), (b, a)].into_iter().find_map(|(x, y)| {
        let sines = with_factor(g, y, Fun::Sin);
        let pair = with_factor(g, x, Fun::Cos).into_iter().find(|p| sines.contains(p));
        pair.map(|(angle, _)| angle)
    })
}
