//! Powers of a cosine next to one: of a part of a length, as of a half vector, or of the product of two unit vectors.
//!
//! (a / √s)ⁿ with s = a² + r loses n times the rounding of a / √s, although r says to full precision how far that is from
//! one: it is (1 - r / (√s (√s + a)))ⁿ. And (v · w)ⁿ is (1 - |v - w|² / 2)ⁿ.

use crate::expr::{Fun, Graph, Id, Node};
use crate::matrix::dot;
use crate::rational::Q;

/// An expression with such powers by what is left of the length, or by the difference of the vectors; `None` where it has
/// none.
pub(super) fn by_the_rest(g: &mut Graph, written: Id) -> Option<Id> {
    g.with_products(written, |g, factors| {
        power_by_the_rest(g, factors).or_else(|| power_by_the_difference(g, factors))
    })
}

fn power_by_the_rest(g: &mut Graph, factors: &[(Id, Id)]) -> Option<Id> {
    let together = g.powers_together(factors)?;
    let [first, second] = together.inside[..] else { return None };
    let is_root = |(_, q): &(Id, Q)| *q == Q::HALF.neg();
    let (a, s) = if is_root(&second) { (first, second) } else { (second, first) };
    if a.1 != Q::ONE || !is_root(&s) {
        return None;
    }
    let (a, s, n) = (a.0, s.0, together.exponent);
    let Node::Sum(_, terms) = g.node(s).clone() else { return None };
    let square = g.powi(a, 2);
    if !terms.contains(&(Q::ONE, square)) {
        return None;
    }
    let (rest, length) = (g.sub(s, square), g.sqrt(s));
    let more = g.add(length, a);
    let divisor = g.mul(length, more);
    let lacking = g.div(rest, divisor);
    let lacking = g.neg(lacking);
    let near = g.call(Fun::Pow1p, &[lacking, n]);
    let half = g.sum(Q::ZERO, &[(Q::HALF.neg(), n)]);
    let far = g.product(&[(a, n), (s, half)]);
    let most = g.sum(Q::ZERO, &[(Q::ONE, a), (Q::HALF.neg(), length)]);
    let power = g.if_positive(most, near, far);
    let mut all: Vec<(Id, Id)> =
        factors.iter().filter(|factor| !together.contains(factor)).copied().collect();
    for (base, q) in together.outside {
        all.push((base, g.number(q)));
    }
    all.push((power, g.int(1)));
    Some(g.product(&all))
}

/// Whether a test is one of those of which [`by_the_rest`] makes powers of products of unit vectors.
pub(super) fn tells_an_angle(g: &mut Graph, test: Id) -> bool {
    let Node::Sum(c, terms) = g.node(test).clone() else { return false };
    let product = g.sum(Q::ZERO, &terms);
    c == Q::HALF.neg() && product_of_units(g, product).is_some()
}

/// The two unit vectors whose product this is.
fn product_of_units(g: &mut Graph, product: Id) -> Option<[[Id; 3]; 2]> {
    let units = g.units().to_vec();
    units.iter().enumerate().find_map(|(i, v)| {
        let w = units[..i].iter().find(|w| dot(g, v, *w) == product)?;
        Some([*v, *w])
    })
}

fn power_by_the_difference(g: &mut Graph, factors: &[(Id, Id)]) -> Option<Id> {
    let of_two = |g: &mut Graph, &(base, n): &(Id, Id)| {
        let open = g.as_number(n).is_none() && matches!(g.node(base), Node::Sum(..));
        let [v, w] = open.then(|| product_of_units(g, base)).flatten()?;
        Some((base, n, [0, 1, 2].map(|k| g.sub(v[k], w[k]))))
    };
    let (base, n, difference) = factors.iter().find_map(|factor| of_two(g, factor))?;
    let squared = dot(g, &difference, &difference);
    let lacking = g.sum(Q::ZERO, &[(Q::HALF.neg(), squared)]);
    let near = g.call(Fun::Pow1p, &[lacking, n]);
    let far = g.pow(base, n);
    let most = g.sum(Q::HALF.neg(), &[(Q::ONE, base)]);
    let power = g.if_positive(most, near, far);
    let one = g.int(1);
    let others = factors.iter().filter(|factor| **factor != (base, n)).copied();
    let all: Vec<(Id, Id)> = others.chain([(power, one)]).collect();
    Some(g.product(&all))
}

#[cfg(test)]
mod tests {
    use crate::interpret::Item;

    #[test]
    fn a_narrow_lobe_of_half_vectors_keeps_its_digits() {
        let text = "fn lobe(u: [Uniform; 2], n: f64, w: Direction) -> Direction {
            let z = u[0].powf(1.0 / (n + 1.0));
            let r = (1.0 - z * z).sqrt();
            let phi = TAU * u[1];
            let h = Vec3::new(r * phi.cos(), r * phi.sin(), z);
            Direction::from_vec(2.0 * h.dot(w) * h - w)
        }";
        let domain = "n in 0.0..=1e6".parse().unwrap();
        let item = Item::new(domain, text.parse().unwrap(), true).unwrap();
        let n = 1e6;
        for u in [[0.3, 0.6], [0.9, 0.1], [0.01, 0.95]] {
            // Seen from straight above, the sample is at twice the angle of the half vector.
            let v = item.forward(&[n, 0.0, 0.0, 1.0], &u).unwrap();
            let half = 0.5 * v[0].hypot(v[1]).atan2(v[2]);
            let power = f64::exp(0.5 * n * (-half.sin() * half.sin()).ln_1p());
            let expected = (n + 1.0) / std::f64::consts::TAU * power / (4.0 * half.cos());
            let found = item.pdf(&[n, 0.0, 0.0, 1.0], &v);
            assert!((found / expected - 1.0).abs() < 1e-13, "{u:?}: {found:e}, not {expected:e}");
        }
    }

    #[test]
    fn a_narrow_lobe_about_a_sampled_direction_keeps_its_digits() {
        let text = "fn chain(u: [Uniform; 4], n: f64) -> (Direction, Direction) {
            let (s, phi, psi) = (u[0].sqrt(), TAU * u[1], TAU * u[3]);
            let first = Direction::new(s * phi.cos(), s * phi.sin(), (1.0 - u[0]).sqrt());
            let c = u[2].powf(1.0 / (n + 1.0));
            let r = (1.0 - c * c).sqrt();
            let local = Vec3::new(r * psi.cos(), r * psi.sin(), c);
            (first, Direction::from_vec(Frame::around(first) * local))
        }";
        let item =
            Item::new("n in 0.0..=1e6".parse().unwrap(), text.parse().unwrap(), true).unwrap();
        let n = 1e6;
        for u in [[0.3, 0.6, 0.4, 0.1], [0.9, 0.1, 0.01, 0.7], [0.01, 0.95, 0.9, 0.45]] {
            let x = item.forward(&[n], &u).unwrap();
            let squared: f64 = (0..3).map(|k| (x[k] - x[k + 3]).powi(2)).sum();
            let power = f64::exp(n * (-0.5 * squared).ln_1p());
            let expected = x[2] * 2.0 * (n + 1.0) / std::f64::consts::TAU.powi(2) * power;
            let found = item.pdf(&[n], &x);
            assert!((found / expected - 1.0).abs() < 1e-13, "{u:?}: {found:e}, not {expected:e}");
        }
    }
}
