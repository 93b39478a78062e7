//! Circular and hyperbolic functions of twice or half an angle that is told by one of its functions: sin(2 asin a) is
//! 2 a √(1 - a²), and tanh(acosh(a) / 2) is √(a - 1) / √(a + 1).

use crate::expr::{Fun, Graph, Id, Node};
use crate::jacobian::cost;
use crate::rational::Q;

/// A function of twice or half an angle.
pub(crate) fn of_multiple(g: &mut Graph, f: Fun, x: Id) -> Option<Id> {
    let (q, angle) = g.split(x);
    let Node::Call(told_by, args) = g.node(angle).clone() else { return None };
    let twice = q == Q::int(2);
    if !twice && q != Q::HALF {
        return None;
    }
    let circular = matches!(f, Fun::Sin | Fun::Cos | Fun::Tan);
    let hyperbolic = matches!(f, Fun::Sinh | Fun::Cosh | Fun::Tanh);
    let [sine, cosine] = match (twice, told_by) {
        (true, Fun::Asin | Fun::Acos | Fun::Atan | Fun::Atan2) if circular => {
            let sides = sides(g, told_by, &args)?;
            twice_a_circular(g, sides)
        }
        (true, Fun::Asinh | Fun::Acosh | Fun::Atanh) if hyperbolic => {
            let sides = sides(g, told_by, &args)?;
            twice_a_hyperbolic(g, sides)
        }
        (false, Fun::Acos) if circular => {
            let (a, one) = (args[0], g.int(1));
            half_a_circular(g, a, one)
        }
        // Half of an angle from zero to π.
        (false, Fun::Atan2) if circular && g.range(args[0]).nonnegative() => {
            let squares = [args[0], args[1]].map(|x| (Q::ONE, g.powi(x, 2)));
            let sum = g.sum(Q::ZERO, &squares);
            let length = g.sqrt(sum);
            half_a_circular(g, args[1], length)
        }
        (false, Fun::Acosh) if hyperbolic => {
            let forms = [Q::int(-1), Q::ONE].map(|one| g.sum(one, &[(Q::ONE, args[0])]));
            forms.map(|form| root_of_half(g, form))
        }
        _ => return None,
    };
    Some(match f {
        Fun::Sin | Fun::Sinh => sine,
        Fun::Cos | Fun::Cosh => cosine,
        _ => g.div(sine, cosine),
    })
}

/// Squares a² of the sine and b² of the cosine of an angle, all times the same number, and their product a b.
struct Sides {
    squares: [Id; 2],
    product: Id,
}

/// The sine and cosine of an angle that a function tells of a number, times whatever both share.
fn sides(g: &mut Graph, told_by: Fun, args: &[Id]) -> Option<Sides> {
    let (a, one) = (args[0], g.int(1));
    let square = g.powi(a, 2);
    let rest = |g: &mut Graph, c: i64, q: i64| g.sum(Q::int(c), &[(Q::int(q), square)]);
    let (squares, other) = match told_by {
        Fun::Atan | Fun::Atanh => ([square, one], one),
        Fun::Atan2 => ([square, g.powi(args[1], 2)], args[1]),
        Fun::Asin => {
            let rest = rest(g, 1, -1);
            ([square, rest], root_beside_one(g, a, square))
        }
        Fun::Acos => {
            let rest = rest(g, 1, -1);
            ([rest, square], root_beside_one(g, a, square))
        }
        Fun::Asinh => {
            let rest = rest(g, 1, 1);
            ([square, rest], g.sqrt(rest))
        }
        Fun::Acosh => {
            let forms = [Q::int(-1), Q::ONE].map(|one| g.sum(one, &[(Q::ONE, a)]));
            let roots = forms.map(|form| g.sqrt(form));
            ([rest(g, -1, 1), square], g.mul(roots[0], roots[1]))
        }
        _ => return None,
    };
    Some(Sides { squares, product: g.mul(a, other) })
}

/// √(1 - a²), without the square of a unless that is simpler, as that of a root.
fn root_beside_one(g: &mut Graph, a: Id, square: Id) -> Id {
    if cost(g, square) < cost(g, a) {
        let rest = g.sum(Q::ONE, &[(Q::int(-1), square)]);
        return g.sqrt(rest);
    }
    let roots = [Q::ONE, Q::int(-1)].map(|q| {
        let side = g.sum(Q::ONE, &[(q, a)]);
        g.sqrt(side)
    });
    g.mul(roots[0], roots[1])
}

/// The sine and cosine of twice an angle: 2 a b and b² - a² over a² + b².
fn twice_a_circular(g: &mut Graph, Sides { squares: [a, b], product }: Sides) -> [Id; 2] {
    let length = g.sum(Q::ZERO, &[(Q::ONE, a), (Q::ONE, b)]);
    let cosine = g.sum(Q::ZERO, &[(Q::ONE, b), (Q::int(-1), a)]);
    let sine = g.sum(Q::ZERO, &[(Q::int(2), product)]);
    [sine, cosine].map(|x| g.div(x, length))
}

/// The same of the hyperbolic functions: 2 a b and a² + b² over b² - a².
fn twice_a_hyperbolic(g: &mut Graph, Sides { squares: [a, b], product }: Sides) -> [Id; 2] {
    let length = g.sum(Q::ZERO, &[(Q::ONE, b), (Q::int(-1), a)]);
    let cosine = g.sum(Q::ZERO, &[(Q::ONE, b), (Q::ONE, a)]);
    let sine = g.sum(Q::ZERO, &[(Q::int(2), product)]);
    [sine, cosine].map(|x| g.div(x, length))
}

/// The sine and cosine of half an angle from zero to π with this cosine times a length.
fn half_a_circular(g: &mut Graph, cosine: Id, length: Id) -> [Id; 2] {
    [Q::int(-1), Q::ONE].map(|q| {
        let sum = g.sum(Q::ZERO, &[(Q::ONE, length), (q, cosine)]);
        let share = g.div(sum, length);
        root_of_half(g, share)
    })
}

/// √(a / 2).
fn root_of_half(g: &mut Graph, a: Id) -> Id {
    let half = g.sum(Q::ZERO, &[(Q::HALF, a)]);
    g.sqrt(half)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eval::evaluate;
    use crate::expr::Leaf;
    use crate::interval::Interval;

    #[test]
    fn functions_of_twice_and_half_an_angle() {
        let circular = [Fun::Sin, Fun::Cos, Fun::Tan];
        let hyperbolic = [Fun::Sinh, Fun::Cosh, Fun::Tanh];
        let cases = [
            (circular, Fun::Asin, 2.0, [-0.7, 0.3, 0.9]),
            (circular, Fun::Acos, 2.0, [-0.7, 0.3, 0.9]),
            (circular, Fun::Acos, 0.5, [-0.7, 0.3, 0.9]),
            (circular, Fun::Atan, 2.0, [-0.7, 0.3, 40.0]),
            (hyperbolic, Fun::Asinh, 2.0, [-0.7, 0.3, 40.0]),
            (hyperbolic, Fun::Acosh, 2.0, [1.1, 2.0, 40.0]),
            (hyperbolic, Fun::Acosh, 0.5, [1.1, 2.0, 40.0]),
            (hyperbolic, Fun::Atanh, 2.0, [-0.7, 0.3, 0.9]),
        ];
        for (functions, told_by, times, numbers) in cases {
            for f in functions {
                let mut g = Graph::new();
                let a = g.leaf(Leaf::Param(0), "a", Interval::ALL);
                let angle = g.call(told_by, &[a]);
                let q = if times == 2.0 { Q::int(2) } else { Q::HALF };
                let multiple = g.sum(Q::ZERO, &[(q, angle)]);
                let id = g.call(f, &[multiple]);
                let form = of_multiple(&mut g, f, multiple).unwrap();
                assert!(g.within(&[form]).iter().all(|&id| !matches!(g.node(id), Node::Call(..))));
                for x in numbers {
                    let [was, is]: [f64; 2] = [id, form].map(|id| evaluate(&g, id, &|_| x));
                    assert!(
                        (was - is).abs() <= 1e-13 * was.abs(),
                        "{f:?} {told_by:?} {x}: {was} {is}"
                    );
                }
            }
        }
    }
}
