//! Factors of polynomials, as far as square roots and exact division find them.

use super::{Poly, half};
use crate::expr::Id;
use crate::rational::{Q, gcd};

/// Polynomials with more terms than this are left whole.
const MOST_TERMS: usize = 20;

impl Poly {
    /// Factors with their exponents, without a constant factor; atoms come first. What is not found to
    /// have any stays whole.
    pub fn split(&self) -> Vec<(Poly, u32)> {
        let (_, common, rest) = self.content();
        let mut found: Vec<(Poly, u32)> =
            common.iter().map(|(a, e)| (Poly::atom(*a), *e)).collect();
        let mut open = vec![(rest, 1)];
        while let Some((p, e)) = open.pop() {
            if p.as_constant().is_some() {
                continue;
            }
            if p.len() > MOST_TERMS {
                found.push((p, e));
                continue;
            }
            let p = p.monic().unwrap_or(p);
            if let Some(root) = p.sqrt() {
                open.push((root, 2 * e));
            } else if let Some(parts) =
                two_factors(&p).or_else(|| coefficient_factor(&p)).or_else(|| linear_factor(&p))
            {
                open.extend(parts.into_iter().map(|part| (part, e)));
            } else {
                match found.iter_mut().find(|(q, _)| *q == p) {
                    Some((_, have)) => *have += e,
                    None => found.push((p, e)),
                }
            }
        }
        found
    }

    /// The polynomial as s² r, with as much in s as [`Poly::split`] finds.
    pub fn square_part(&self) -> Option<(Poly, Poly)> {
        let mut s = Poly::constant(Q::ONE);
        for (factor, e) in self.split() {
            s = s.mul(&factor.powi(e / 2)?)?;
        }
        let rest = self.exact_div(&s.mul(&s)?)?;
        Some((s, rest))
    }

    /// A positive number times a polynomial with integer coefficients without a common divisor.
    pub fn integral(&self) -> Option<(Q, Poly)> {
        let bottom = self
            .0
            .iter()
            .try_fold(1, |l: i128, (_, q)| l.checked_mul(q.den() / gcd(l, q.den())))?;
        let k = self
            .0
            .iter()
            .try_fold(0, |d: i128, (_, q)| Some(gcd(d, q.num().checked_mul(bottom / q.den())?)))?;
        let k = Q::new(k, bottom)?;
        Some((k, self.scale(k.recip()?)?))
    }

    /// A multiple with a leading coefficient of one.
    fn monic(&self) -> Option<Poly> {
        let (_, lead) = self.0.last()?;
        self.scale(lead.recip()?)
    }
}

/// The two factors of a polynomial, if there are any that these rules find: a² - b² with monomials a and
/// b, and a quadratic in one of the atoms whose discriminant is a square.
pub(super) fn two_factors(p: &Poly) -> Option<Vec<Poly>> {
    difference_of_squares(p).or_else(|| p.atoms().iter().find_map(|&a| of_quadratic(p, a)))
}

/// a² - b² as (a - b)(a + b), where both are squares of monomials.
fn difference_of_squares(p: &Poly) -> Option<Vec<Poly>> {
    let [(m, q), (n, r)] = &p.0[..] else { return None };
    let root = |m: &[(Id, u32)], q: Q| Some(Poly::term(half(m)?, q.sqrt()?));
    let (pos, neg) = if r.is_negative() { ((m, q), (n, r)) } else { ((n, r), (m, q)) };
    if pos.1.is_negative() || !neg.1.is_negative() {
        return None;
    }
    let (a, b) = (root(pos.0, *pos.1)?, root(neg.0, neg.1.neg())?);
    Some(vec![a.sub(&b)?, a.add(&b)?])
}

/// The two factors of a polynomial of degree two in `x` whose discriminant is a square.
fn of_quadratic(p: &Poly, x: Id) -> Option<Vec<Poly>> {
    let powers = p.by_powers_of(x)?;
    let [c0, c1, c2] = &powers[..] else { return None };
    let discriminant = c1.mul(c1)?.sub(&c0.mul(c2)?.scale(Q::int(4))?)?;
    let twice = c2.mul(&Poly::atom(x))?.scale(Q::int(2))?.add(c1)?;
    let root = discriminant.sqrt()?;
    // Their product is 4 c₂ times too large; what is too much of it is a monomial or no factor.
    let factor = |s: Poly| twice.add(&s).map(|f| f.content().2);
    let (a, b) = (factor(root.scale(Q::int(-1))?)?, factor(root)?);
    p.exact_div(&a)?.exact_div(&b)?.as_constant()?;
    Some(vec![a, b])
}

/// A factor that one coefficient of the powers of some atom has, and with it the whole polynomial; and
/// what is left.
fn coefficient_factor(p: &Poly) -> Option<Vec<Poly>> {
    p.atoms().into_iter().find_map(|x| {
        let powers = p.by_powers_of(x)?;
        let shortest = powers.iter().filter(|c| !c.is_zero()).min_by_key(|c| c.len())?;
        if powers.len() < 2 || shortest.len() < 2 {
            return None;
        }
        shortest.split().into_iter().filter(|(f, _)| f.len() > 1).find_map(|(f, _)| {
            let rest = p.exact_div(&f)?;
            Some(vec![f, rest])
        })
    })
}

/// a + r with a small rational r, of a polynomial in a alone; and what is left.
fn linear_factor(p: &Poly) -> Option<Vec<Poly>> {
    let [a] = p.atoms()[..] else { return None };
    let degree = p.by_powers_of(a)?.len();
    let roots = [Q::ONE, Q::int(-1), Q::int(2), Q::int(-2), Q::HALF, Q::HALF.neg()];
    roots.into_iter().filter(|_| degree > 3).find_map(|r| {
        let factor = Poly::atom(a).add(&Poly::constant(r))?;
        let rest = p.exact_div(&factor)?;
        Some(vec![factor, rest])
    })
}
