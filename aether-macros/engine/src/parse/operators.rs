//! Operators of the language.

use syn::{BinOp, Expr, ExprBinary};

use super::Value;
use super::body::Body;
use crate::expr::{Graph, Id, shed};
use crate::matrix::dot;
use crate::rational::Q;

/// value · k.
pub fn scale(body: &mut Body, at: &Expr, value: Value, k: Id) -> Option<Value> {
    let g = &mut body.graph;
    match value {
        Value::Scalar(x) => Some(Value::Scalar(g.mul(x, k))),
        Value::Vector(v) | Value::Point(_, v, _) => {
            Some(Value::Vector(v.iter().map(|&c| g.mul(c, k)).collect()))
        }
        Value::Matrix(m) => {
            Some(Value::Matrix(m.map(|c| c.iter().map(|&x| g.mul(x, k)).collect())))
        }
        Value::Uniforms(_) => {
            body.error(at, "this is the array of all uniforms; take one of them: `u[0]`")
        }
        other => {
            let what = other.describe();
            body.error(at, format!("{what} cannot be multiplied"))
        }
    }
}

/// x + sign · y.
pub(super) fn sum(g: &mut Graph, x: Id, y: Id, sign: Q) -> Id {
    let sum = g.sum(Q::ZERO, &[(Q::ONE, x), (sign, y)]);
    shed(g, sum)
}

/// left op right.
pub fn binary(body: &mut Body, b: &ExprBinary, left: Value, right: Value) -> Option<Value> {
    use Value::{Matrix, Scalar};
    if body.left() {
        return Some(Value::Unit);
    }
    if let (Value::Integer(x), Value::Integer(y)) = (&left, &right) {
        return body.of_integers(b, *x, *y);
    }
    let (left, right) = (left.real(), right.real());
    if let (BinOp::Rem(_), Scalar(x), Scalar(y)) = (&b.op, &left, &right) {
        return body.remainder(&b.op, *x, *y).map(Scalar);
    }
    let g = &mut body.graph;
    match (&b.op, &left, &right) {
        (BinOp::Add(_), Scalar(x), Scalar(y)) => Some(Scalar(sum(g, *x, *y, Q::ONE))),
        (BinOp::Sub(_), Scalar(x), Scalar(y)) => Some(Scalar(sum(g, *x, *y, Q::ONE.neg()))),
        (BinOp::Mul(_), Scalar(x), Scalar(y)) => Some(Scalar(g.mul(*x, *y))),
        (BinOp::Div(_), Scalar(x), Scalar(y)) => Some(Scalar(g.div(*x, *y))),
        (BinOp::Add(_) | BinOp::Sub(_), x, y) if same_length(x, y) => {
            let sign = Q::int(if matches!(b.op, BinOp::Add(_)) { 1 } else { -1 });
            let (x, y) = (x.vector()?.to_vec(), y.vector()?.to_vec());
            Some(Value::Vector(x.iter().zip(&y).map(|(&x, &y)| sum(g, x, y, sign)).collect()))
        }
        (BinOp::Mul(_), Matrix(m), v) if v.vector().is_some_and(|v| v.len() == 3) => {
            let v = v.vector()?.to_vec();
            let rows = (0..3).map(|i| dot(g, &[m[0][i], m[1][i], m[2][i]], &v)).collect();
            Some(Value::Vector(rows))
        }
        (BinOp::Mul(_), Scalar(k), _) => scale(body, &b.right, right.clone(), *k),
        (BinOp::Mul(_), _, Scalar(k)) => scale(body, &b.left, left.clone(), *k),
        (BinOp::Div(_), _, Scalar(k)) => {
            let r = g.powi(*k, -1);
            scale(body, &b.left, left.clone(), r)
        }
        (BinOp::Mul(_) | BinOp::Div(_), x, y) if x.vector().is_some() && y.vector().is_some() => {
            body.error(b, "there is more than one product of vectors: write `a.dot(b)`, `a.cross(b)`, or a vector of products of coordinates, `Vec2::new(a.x * b.x, a.y * b.y)`")
        }
        (BinOp::Add(_) | BinOp::Sub(_) | BinOp::Mul(_) | BinOp::Div(_), ..) => {
            let (x, y) = (left.describe(), right.describe());
            body.error(b, format!("{x} and {y} do not go together here"))
        }
        _ => body.error(
            b.op,
            "of the operators only + - * / % are functions of numbers that can be inverted",
        ),
    }
}

fn same_length(a: &Value, b: &Value) -> bool {
    matches!((a.vector(), b.vector()), (Some(a), Some(b)) if a.len() == b.len())
}
