//! Vectors, matrices and frames of the language: their methods, and how they are written.

use syn::{Expr, ExprMethodCall};

use super::body::Body;
use super::operators::sum;
use super::{Space, Value};
use crate::expr::{Id, TurnedVector};
use crate::matrix::{cross, dot};
use crate::rational::Q;

/// A method of a vector.
pub(super) fn vector_method(
    body: &mut Body,
    m: &ExprMethodCall,
    name: &str,
    v: Vec<Id>,
    args: &[&Expr],
) -> Option<Value> {
    match (name, args) {
        ("length" | "length_squared" | "normalize", []) => {
            let g = &mut body.graph;
            let squared = dot(g, &v, &v);
            match name {
                "length_squared" => Some(Value::Scalar(squared)),
                "length" => Some(Value::Scalar(g.sqrt(squared))),
                _ => {
                    let e = g.number(Q::HALF.neg());
                    let r = g.pow(squared, e);
                    let unit: Vec<Id> = v.iter().map(|&c| g.mul(c, r)).collect();
                    if let [x, y, z] = unit[..] {
                        g.note_vector([x, y, z]);
                    }
                    Some(Value::Vector(unit))
                }
            }
        }
        ("dot" | "cross", [a]) => {
            let other = body.expr(a)?;
            let Some(w) = other.vector().filter(|w| w.len() == v.len()).map(<[Id]>::to_vec) else {
                return body.error(a, format!("`{name}` needs another vector with as many coordinates"));
            };
            let g = &mut body.graph;
            if name == "dot" {
                return Some(Value::Scalar(dot(g, &v, &w)));
            }
            if v.len() != 3 {
                return body.error(m, "the vector product is one of vectors of space");
            }
            Some(Value::Vector(cross(&mut body.graph, &v, &w)))
        }
        ("distance" | "distance_squared" | "lerp", [a, rest @ ..]) if rest.len() == usize::from(name == "lerp") => {
            let other = body.expr(a)?;
            let Some(w) = other.vector().filter(|w| w.len() == v.len()).map(<[Id]>::to_vec) else {
                return body.error(a, format!("`{name}` needs another vector with as many coordinates"));
            };
            if let [t] = rest {
                let t = body.scalar(t)?;
                let g = &mut body.graph;
                let one = g.int(1);
                let kept = g.sub(one, t);
                let between = v.iter().zip(&w).map(|(&a, &b)| {
                    let (a, b) = (g.mul(a, kept), g.mul(b, t));
                    sum(g, a, b, Q::ONE)
                });
                return Some(Value::Vector(between.collect()));
            }
            let g = &mut body.graph;
            let apart: Vec<Id> = v.iter().zip(&w).map(|(&a, &b)| sum(g, a, b, Q::ONE.neg())).collect();
            let squared = dot(g, &apart, &apart);
            Some(Value::Scalar(if name == "distance" { g.sqrt(squared) } else { squared }))
        }
        ("vec" | "clone" | "into", []) => Some(Value::Vector(v)),
        ("to_array", []) => Some(Value::List(v.into_iter().map(Value::Scalar).collect())),
        _ => body.error(&m.method, format!("`{name}` is not a method of vectors in the language: there are dot, cross, length, length_squared, normalize, distance, distance_squared, lerp and to_array")),
    }
}

/// A method of a matrix.
pub(super) fn matrix_method(
    body: &mut Body,
    m: &ExprMethodCall,
    name: &str,
    matrix: Value,
    args: &[&Expr],
) -> Option<Value> {
    let Value::Matrix(columns) = matrix else { return None };
    let transposed: [Vec<Id>; 3] = [0, 1, 2].map(|i| columns.iter().map(|c| c[i]).collect());
    match (name, args) {
        ("transpose", []) => Some(Value::Matrix(transposed)),
        ("to_world" | "to_local", [a]) => {
            let v = body.expr(a)?;
            let Some(v) = v.vector().filter(|v| v.len() == 3).map(<[Id]>::to_vec) else {
                return body.error(a, format!("`{name}` needs a vector of space"));
            };
            let is_outward = name == "to_world";
            let rows = if is_outward { &transposed } else { &columns };
            let g = &mut body.graph;
            let turned: Vec<Id> = rows.iter().map(|r| dot(g, r, &v)).collect();
            if let ([x, y, z], Ok(inside)) = (&turned[..], v.try_into()) {
                let (written, axes) = ([*x, *y, *z], columns.map(|c| [c[0], c[1], c[2]]));
                g.note_vector(written);
                if is_outward && g.made_frames().contains(&axes) {
                    g.note_turned(TurnedVector { axes, inside, written });
                }
            }
            Some(Value::Vector(turned))
        }
        _ => body.error(&m.method, format!("`{name}` is not a method of matrices in the language: there are transpose, and to_world and to_local of frames")),
    }
}

/// `Vec3 { x, y, z }`.
pub(super) fn literal(body: &mut Body, s: &syn::ExprStruct) -> Option<Value> {
    let name = s.path.segments.last().map(|s| s.ident.to_string()).unwrap_or_default();
    let axes: &[&str] = match name.as_str() {
        "Vec2" => &["x", "y"],
        "Vec3" | "Mat3" => &["x", "y", "z"],
        _ => return body.error(s, format!("`{name}` is not known to the language: values are numbers, vectors, matrices, and tuples and arrays of these")),
    };
    let field = |axis: &&str| {
        s.fields.iter().find(|f| matches!(&f.member, syn::Member::Named(name) if name == axis))
    };
    let fields: Option<Vec<&syn::FieldValue>> = axes.iter().map(field).collect();
    let Some(fields) = fields else {
        return body.error(s, "write all of its coordinates here");
    };
    if name == "Mat3" {
        let columns: Option<Vec<Vec<Id>>> = fields.iter().map(|f| vector(body, &f.expr)).collect();
        return <[Vec<Id>; 3]>::try_from(columns?).ok().map(Value::Matrix);
    }
    let v: Vec<Id> = fields.iter().map(|f| body.scalar(&f.expr)).collect::<Option<_>>()?;
    if let [x, y, z] = v[..] {
        body.graph.note_vector([x, y, z]);
    }
    Some(Value::Vector(v))
}

/// The frame about a direction, as `Frame::around` makes it (Duff et al. 2017, "Building an Orthonormal Basis, Revisited"):
/// a piece above the horizon, and one below.
pub(super) fn around(body: &mut Body, e: &Expr) -> Option<Value> {
    let value = body.expr(e)?;
    let typed = matches!(value, Value::Point(Space::Direction, ..));
    let n = value.vector().and_then(|n| <[Id; 3]>::try_from(n).ok());
    let Some([x, y, z]) = n.filter(|n| typed || body.graph.units().contains(n)) else {
        let what = value.describe();
        return body.error(e, format!("a frame is about a direction, and this is {what}: write `Frame::around(Direction::from_vec(v))` for a vector of unit length"));
    };
    let sign = body.signum(z);
    let g = &mut body.graph;
    let one = g.int(1);
    let below = g.add(sign, z);
    let a = g.div(one, below);
    let across = [[x, x], [x, y], [y, y]].map(|pair| {
        let product = g.mul(pair[0], pair[1]);
        g.mul(product, a)
    });
    let turned = [across[0], across[1], x].map(|c| g.mul(sign, c));
    let right = [g.sub(one, turned[0]), g.neg(turned[1]), g.neg(turned[2])];
    let up = [g.neg(across[1]), g.sub(sign, across[2]), g.neg(y)];
    let columns = [right, up, [x, y, z]];
    g.note_frame(columns);
    Some(Value::Matrix(columns.map(|column| column.to_vec())))
}

/// The coordinates of an expression that must be a vector.
pub(super) fn vector(body: &mut Body, e: &Expr) -> Option<Vec<Id>> {
    let value = body.expr(e)?;
    if let Some(all) = value.elements() {
        let numbers = all.into_iter().map(|x| match x.real() {
            Value::Scalar(id) => Some(id),
            _ => None,
        });
        return match numbers.collect() {
            Some(numbers) => Some(numbers),
            None => body.error(e, "a vector is needed here, and these are no numbers"),
        };
    }
    match value.vector() {
        Some(v) => Some(v.to_vec()),
        None if body.left() => Some(vec![body.graph.int(0); 3]),
        None => {
            let what = value.describe();
            body.error(e, format!("a vector is needed here, and this is {what}"))
        }
    }
}
