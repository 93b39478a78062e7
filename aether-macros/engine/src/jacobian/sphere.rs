//! The change of measure of a direction in terms of its height and its azimuth, and of points at
//! distances in such directions.
//!
//! A unit vector (A cos t, A sin t, h) covers the area |∂(h, t)|: that of a cylinder around the sphere
//! (Archimedes). How A follows from h does not matter, so none of its roots is ever differentiated.

use super::{distinct, simplify};
use crate::derivative::derivative;
use crate::expr::{Fun, Graph, Id, Leaf, Node, UNKNOWNS, children, leaf_bit};
use crate::matrix::determinant;
use crate::poly::Expander;
use crate::rational::Q;
use crate::solve::polar::with_factor;

/// Equal expressions for the area that a unit vector covers, if two of its coordinates tell an azimuth.
pub fn area(g: &mut Graph, outputs: &[Id], unknowns: &[Leaf]) -> Option<Vec<Id>> {
    let (&[_, _, _], &[u, v]) = (outputs, unknowns) else { return None };
    let (height, [t_u, t_v]) =
        [(0, 1, 2), (1, 2, 0), (2, 0, 1)].iter().find_map(|&(i, j, k)| {
            let turned = turned(g, outputs[i], outputs[j], [u, v])?;
            Some((outputs[k], turned))
        })?;
    let [h_u, h_v] = [u, v].map(|l| derivative(g, height, l));
    let (first, second) = (g.mul(h_u, t_v), g.mul(h_v, t_u));
    let d = g.sub(first, second);
    let tidy = simplify(g, d, None);
    Some(distinct([tidy, d].map(|d| g.call(Fun::Abs, &[d])).to_vec()))
}

/// The same for points that turn out to have unit length.
pub fn unit_sphere(g: &mut Graph, outputs: &[Id], unknowns: &[Leaf]) -> Option<Vec<Id>> {
    is_unit(g, outputs).then(|| area(g, outputs, unknowns)).flatten()
}

/// Whether a vector turns out to have unit length.
pub fn is_unit(g: &mut Graph, vector: &[Id]) -> bool {
    let squares: Vec<(Q, Id)> = vector.iter().map(|&x| (Q::ONE, g.powi(x, 2))).collect();
    let sum = g.sum(Q::ZERO, &squares);
    let length = Expander::new(g).normal_form(sum);
    length.is_some_and(|length| g.as_number(length) == Some(Q::ONE))
}

/// The derivatives of the angle of a vector (a, b) in the plane: of t where it is A cos t and A sin t, else
/// (f h' - h f') / (f² + h²) where it is A f and A h, with f and h of the same single unknown.
fn turned(g: &mut Graph, a: Id, b: Id, unknowns: [Leaf; 2]) -> Option<[Id; 2]> {
    if let Some((angle, _)) = shared(g, a, b) {
        return Some(unknowns.map(|l| derivative(g, angle, l)));
    }
    let other = g.factors(b);
    let common: Vec<(Id, Id)> = g.factors(a).into_iter().filter(|x| other.contains(x)).collect();
    let common = g.product(&common);
    let (f, h) = (g.div(a, common), g.div(b, common));
    let open = g.deps(f) & UNKNOWNS;
    if open.count_ones() != 1 || g.deps(h) & UNKNOWNS != open {
        return None;
    }
    let (f2, h2) = (g.powi(f, 2), g.powi(h, 2));
    let bottom = g.add(f2, h2);
    Some(unknowns.map(|l| {
        let (df, dh) = (derivative(g, f, l), derivative(g, h, l));
        let (first, second) = (g.mul(f, dh), g.mul(h, df));
        let top = g.sub(first, second);
        let top = simplify(g, top, None);
        g.div(top, bottom)
    }))
}

/// The t and the A of A cos t and A sin t, in any order.
fn shared(g: &mut Graph, a: Id, b: Id) -> Option<(Id, Id)> {
    let ((p, a), (q, b)) = (g.split(a), g.split(b));
    let (angle, amplitude) = [(a, b), (b, a)].into_iter().find_map(|(x, y)| {
        let sines = with_factor(g, y, Fun::Sin);
        with_factor(g, x, Fun::Cos).into_iter().find(|p| sines.contains(p))
    })?;
    (p.abs() == q.abs()).then(|| (angle, g.sum(Q::ZERO, &[(p, amplitude)])))
}

/// A point c + ρ (a cos t, a sin t, h), in any order of the coordinates, with a² + h² = 1.
struct Spherical {
    distance: Id,
    height: Id,
    angle: Id,
}

/// The volume of points in spherical coordinates, |∂(ρ, h, t)| ρ²; or the area of a surface of revolution
/// ρ(u), h(u), t(v), which is ρ² √((ρ'/ρ)² (1 - h²) + h'²) |t'|.
pub fn volume(g: &mut Graph, outputs: &[Id], unknowns: &[Leaf]) -> Option<Vec<Id>> {
    let Spherical { distance, height, angle } = spherical(g, outputs)?;
    let squared = g.powi(distance, 2);
    match *unknowns {
        [_, _, _] => {
            let rows = [distance, height, angle]
                .map(|x| unknowns.iter().map(|&l| derivative(g, x, l)).collect::<Vec<_>>());
            let d = determinant(g, &rows);
            let tidy = simplify(g, d, None);
            let forms = [tidy, d].map(|d| {
                let size = g.call(Fun::Abs, &[d]);
                g.mul(squared, size)
            });
            Some(distinct(forms.to_vec()))
        }
        [u, v] => {
            let (along, around) = if g.has(angle, leaf_bit(v)) { (u, v) } else { (v, u) };
            let (other, own) = (leaf_bit(along), leaf_bit(around));
            if g.has(angle, other) || g.has(distance, own) || g.has(height, own) {
                return None;
            }
            let turned = derivative(g, angle, around);
            let turned = g.call(Fun::Abs, &[turned]);
            let slope = derivative(g, distance, along);
            let slope = g.div(slope, distance);
            let slope = simplify(g, slope, None);
            let (rise, h2) = (derivative(g, height, along), g.powi(height, 2));
            let one = g.int(1);
            let a2 = g.sub(one, h2);
            let (slope2, rise2) = (g.powi(slope, 2), g.powi(rise, 2));
            let outwards = g.mul(slope2, a2);
            let length = g.add(outwards, rise2);
            let tidy = simplify(g, length, None);
            let under = over_roots(g, length, distance).unwrap_or(length);
            let forms = [under, tidy, length].map(|l| {
                let length = g.sqrt(l);
                let area = g.mul(squared, length);
                g.mul(area, turned)
            });
            Some(distinct(forms.to_vec()))
        }
        _ => None,
    }
}

/// p / q for an expression that is one, where q is under a root of `rooted`: q as it was written, not
/// multiplied out.
fn over_roots(g: &mut Graph, id: Id, rooted: Id) -> Option<Id> {
    let mut open = vec![rooted];
    while let Some(part) = open.pop() {
        if let Node::Product(factors) = g.node(part).clone() {
            for (b, e) in factors {
                if g.as_number(e).is_some_and(|q| q.den() == 2) && g.has(b, UNKNOWNS) {
                    let top = g.mul(id, b);
                    let top = Expander::new(g).normal_form(top)?;
                    return (!g.has(top, UNKNOWNS)).then(|| g.div(top, b));
                }
            }
        }
        open.extend(children(g.node(part)));
    }
    None
}

fn spherical(g: &mut Graph, outputs: &[Id]) -> Option<Spherical> {
    let &[_, _, _] = outputs else { return None };
    let parts: Vec<Id> = outputs.iter().map(|&o| open_part(g, o)).collect();
    [(0, 1, 2), (1, 2, 0), (2, 0, 1)].iter().find_map(|&(i, j, k)| {
        let (angle, amplitude) = shared(g, parts[i], parts[j])?;
        let (q, body) = g.split(parts[k]);
        let (p, amplitude) = g.split(amplitude);
        let height = g.factors(body);
        let common: Vec<(Id, Id)> =
            g.factors(amplitude).into_iter().filter(|f| height.contains(f)).collect();
        let distance = g.product(&common);
        let (a, h) = (g.div(amplitude, distance), g.div(body, distance));
        let (a, h) = (g.sum(Q::ZERO, &[(p, a)]), g.sum(Q::ZERO, &[(q, h)]));
        let (a2, h2) = (g.powi(a, 2), g.powi(h, 2));
        let sum = g.add(a2, h2);
        // Up to a known factor, which belongs to the distance.
        let sum = Expander::new(g).normal_form(sum).filter(|s| !g.has(*s, UNKNOWNS))?;
        let length = g.sqrt(sum);
        if !g.has(distance, UNKNOWNS) || !g.has(h, UNKNOWNS) {
            return None;
        }
        Some(Spherical { distance: g.mul(distance, length), height: g.div(h, length), angle })
    })
}

/// A coordinate without the summands that are known.
fn open_part(g: &mut Graph, id: Id) -> Id {
    let Node::Sum(_, terms) = g.node(id).clone() else { return id };
    let (open, known): (Vec<_>, Vec<_>) = terms.into_iter().partition(|(_, t)| g.has(*t, UNKNOWNS));
    if known.is_empty() { id } else { g.sum(Q::ZERO, &open) }
}
