//! Monomials, products of powers of atoms, and lists of them in lexicographic order.

use std::cmp::Ordering;

use super::Mono;
use crate::expr::Id;
use crate::rational::Q;

/// The sum of two lists of terms in order.
pub(super) fn merge(a: &[(Mono, Q)], b: &[(Mono, Q)]) -> Option<Vec<(Mono, Q)>> {
    let mut r = Vec::with_capacity(a.len() + b.len());
    let (mut i, mut j) = (0, 0);
    while i < a.len() && j < b.len() {
        match order(&a[i].0, &b[j].0) {
            Ordering::Less => {
                r.push(a[i].clone());
                i += 1;
            }
            Ordering::Greater => {
                r.push(b[j].clone());
                j += 1;
            }
            Ordering::Equal => {
                let q = a[i].1.add(b[j].1)?;
                if !q.is_zero() {
                    r.push((a[i].0.clone(), q));
                }
                i += 1;
                j += 1;
            }
        }
    }
    r.extend_from_slice(&a[i..]);
    r.extend_from_slice(&b[j..]);
    Some(r)
}

/// The lexicographic order of monomials.
pub(super) fn order(a: &[(Id, u32)], b: &[(Id, u32)]) -> Ordering {
    let mut k = 0;
    while k < a.len() && k < b.len() {
        let (x, y) = (a[k], b[k]);
        if x.0.0 != y.0.0 {
            return x.0.0.cmp(&y.0.0);
        }
        if x.1 != y.1 {
            return x.1.cmp(&y.1);
        }
        k += 1;
    }
    a.len().cmp(&b.len())
}

/// The product of two monomials.
pub(super) fn times(a: &Mono, b: &Mono) -> Mono {
    if a.is_empty() || b.is_empty() {
        return if a.is_empty() { b.clone() } else { a.clone() };
    }
    let mut r = Vec::with_capacity(a.len() + b.len());
    let (mut i, mut j) = (0, 0);
    while i < a.len() && j < b.len() {
        let (x, y) = (a[i], b[j]);
        match x.0.0.cmp(&y.0.0) {
            Ordering::Greater => {
                r.push(x);
                i += 1;
            }
            Ordering::Less => {
                r.push(y);
                j += 1;
            }
            Ordering::Equal => {
                r.push((x.0, x.1 + y.1));
                i += 1;
                j += 1;
            }
        }
    }
    r.extend_from_slice(&a[i..]);
    r.extend_from_slice(&b[j..]);
    r.into()
}

/// The quotient of two monomials, if it is one.
pub(super) fn over(a: &[(Id, u32)], b: &[(Id, u32)]) -> Option<Mono> {
    let mut r = Vec::with_capacity(a.len());
    let mut j = 0;
    for &(x, e) in a {
        let below = if j < b.len() && b[j].0.0 == x.0 { b[j].1 } else { 0 };
        j += usize::from(below > 0);
        match e.checked_sub(below)? {
            0 => {}
            left => r.push((x, left)),
        }
    }
    (j == b.len()).then(|| r.into())
}

/// The square root of a monomial, if it is one.
pub(super) fn half(m: &[(Id, u32)]) -> Option<Mono> {
    m.iter().map(|(a, e)| (e % 2 == 0).then_some((*a, e / 2))).collect()
}
