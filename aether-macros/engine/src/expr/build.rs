//! Making expressions from others.

use super::{Fun, Graph, Id, Node};
use crate::rational::Q;

impl Graph {
    /// The exact number `q`.
    pub fn number(&mut self, q: Q) -> Id {
        self.intern(Node::Number(q))
    }

    /// The integer `n`.
    pub fn int(&mut self, n: i64) -> Id {
        let place = (n + 3) as usize;
        if let Some(Some(known)) = self.small.get(place) {
            return *known;
        }
        let id = self.number(Q::int(n));
        if let Some(known) = self.small.get_mut(place) {
            *known = Some(id);
        }
        id
    }

    /// The circle constant.
    pub fn pi(&mut self) -> Id {
        self.intern(Node::Pi)
    }

    /// A double, kept exactly.
    pub fn float(&mut self, x: f64) -> Id {
        self.intern(Node::Float(x.to_bits()))
    }

    /// Splits an expression into a rational coefficient and the rest.
    pub fn split(&mut self, id: Id) -> (Q, Id) {
        match self.node(id) {
            Node::Number(q) => {
                let q = *q;
                (q, self.int(1))
            }
            Node::Sum(c, terms) if c.is_zero() && terms.len() == 1 => terms[0],
            _ => (Q::ONE, id),
        }
    }

    /// a + b.
    pub fn add(&mut self, a: Id, b: Id) -> Id {
        self.sum(Q::ZERO, &[(Q::ONE, a), (Q::ONE, b)])
    }

    /// a - b.
    pub fn sub(&mut self, a: Id, b: Id) -> Id {
        self.sum(Q::ZERO, &[(Q::ONE, a), (Q::int(-1), b)])
    }

    /// -a.
    pub fn neg(&mut self, a: Id) -> Id {
        self.sum(Q::ZERO, &[(Q::int(-1), a)])
    }

    /// a · b.
    pub fn mul(&mut self, a: Id, b: Id) -> Id {
        let one = self.int(1);
        self.product(&[(a, one), (b, one)])
    }

    /// a / b.
    pub fn div(&mut self, a: Id, b: Id) -> Id {
        let one = self.int(1);
        let minus = self.int(-1);
        self.product(&[(a, one), (b, minus)])
    }

    /// a^e.
    pub fn pow(&mut self, a: Id, e: Id) -> Id {
        self.product(&[(a, e)])
    }

    /// a^n.
    pub fn powi(&mut self, a: Id, n: i64) -> Id {
        let e = self.int(n);
        self.pow(a, e)
    }

    /// √a.
    pub fn sqrt(&mut self, a: Id) -> Id {
        let half = self.number(Q::HALF);
        self.pow(a, half)
    }

    /// A function of its arguments, in canonical form.
    ///
    /// Those of the incomplete beta function have one more than it takes: what the first leaves of one, whose digits
    /// may be known where they are lost in the first. Left out, it is that difference.
    pub fn call(&mut self, f: Fun, args: &[Id]) -> Id {
        if let (Fun::BetaInc | Fun::BetaIncInv, &[x, a, b]) = (f, args) {
            let one = self.int(1);
            let rest = self.sub(one, x);
            return self.call(f, &[x, a, b, rest]);
        }
        crate::functions::simplify_call(self, f, args)
            .unwrap_or_else(|| self.intern(Node::Call(f, args.to_vec())))
    }

    /// `yes` where `test` is greater than zero, else `no`. Within either, the same test has been answered.
    pub fn if_positive(&mut self, test: Id, yes: Id, no: Id) -> Id {
        let range = self.range(test);
        let yes = match *self.node(yes) {
            Node::If(same, answer, _) if same == test => answer,
            _ => yes,
        };
        let no = match *self.node(no) {
            Node::If(same, _, answer) if same == test => answer,
            _ => no,
        };
        if yes == no || range.hi <= 0.0 {
            no
        } else if range.lo > 0.0 {
            yes
        } else {
            self.intern(Node::If(test, yes, no))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Leaf;
    use crate::interval::Interval;

    #[test]
    fn a_question_is_asked_once() {
        let mut g = Graph::new();
        let [x, y, a, b, c] =
            [0, 1, 2, 3, 4].map(|i| g.leaf(Leaf::Param(i), &format!("p{i}"), Interval::ALL));
        let inner = g.if_positive(x, a, b);
        let [yes, no, other] = [(x, inner, c), (x, c, inner), (y, inner, c)]
            .map(|(t, yes, no)| g.if_positive(t, yes, no));
        assert_eq!(yes, g.if_positive(x, a, c));
        assert_eq!(no, g.if_positive(x, c, b));
        assert_eq!(*g.node(other), Node::If(y, inner, c));
    }
}
