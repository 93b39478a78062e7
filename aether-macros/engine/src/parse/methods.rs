//! Operators, methods and constructors of the language.

use quote::ToTokens;
use syn::{BinOp, Expr, ExprBinary, ExprCall, ExprMethodCall, Lit};

use super::body::Body;
use super::bounded::{bounded_argument, kept};
use super::mixed::marked;
use super::special::{SPECIAL, special_function};
use super::{Space, Value};
use crate::expr::{Fun, Graph, Id, TurnedVector, shed};
use crate::rational::Q;
use crate::solve::linear::{cross, dot};

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
fn sum(g: &mut Graph, x: Id, y: Id, sign: Q) -> Id {
    let sum = g.sum(Q::ZERO, &[(Q::ONE, x), (sign, y)]);
    shed(g, sum)
}

/// left op right.
pub fn binary(body: &mut Body, b: &ExprBinary, left: Value, right: Value) -> Option<Value> {
    use Value::{Matrix, Scalar};
    let g = &mut body.graph;
    match (&b.op, &left, &right) {
        (BinOp::Add(_), Scalar(x), Scalar(y)) => Some(Scalar(sum(g, *x, *y, Q::ONE))),
        (BinOp::Sub(_), Scalar(x), Scalar(y)) => Some(Scalar(sum(g, *x, *y, Q::ONE.neg()))),
        (BinOp::Mul(_), Scalar(x), Scalar(y)) => Some(Scalar(g.mul(*x, *y))),
        (BinOp::Div(_), Scalar(x), Scalar(y)) if is_integer(&b.left) && is_integer(&b.right) => {
            let quotient = g.div(*x, *y);
            let whole = g.as_number(quotient).and_then(|q| Q::new(q.num() / q.den(), 1));
            Some(Scalar(whole.map_or(quotient, |whole| g.number(whole))))
        }
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
            "of the operators only + - * / are functions of numbers that can be inverted. The rest of a division is `x.rem_euclid(y)`, and of a division by one `x.fract()`",
        ),
    }
}

/// Whether this is arithmetic of integer literals, which divide without a rest.
fn is_integer(e: &Expr) -> bool {
    match e {
        Expr::Lit(literal) => matches!(&literal.lit, Lit::Int(n) if n.suffix() != "f64"),
        Expr::Paren(inner) => is_integer(&inner.expr),
        Expr::Group(inner) => is_integer(&inner.expr),
        Expr::Unary(negated) => is_integer(&negated.expr),
        Expr::Binary(both) => is_integer(&both.left) && is_integer(&both.right),
        _ => false,
    }
}

fn same_length(a: &Value, b: &Value) -> bool {
    matches!((a.vector(), b.vector()), (Some(a), Some(b)) if a.len() == b.len())
}

/// receiver.method(args).
pub fn method(body: &mut Body, m: &ExprMethodCall) -> Option<Value> {
    let name = m.method.to_string();
    if let Some(bounded) = bounded_argument(&name, &m.receiver) {
        let x = bounded.value(body)?;
        return scalar_function(body, m, &name, x);
    }
    let receiver = body.expr(&m.receiver)?;
    let args: Vec<&Expr> = m.args.iter().collect();
    match (&receiver, &args[..]) {
        (Value::Scalar(x), []) => scalar_function(body, m, &name, *x),
        (Value::Scalar(x), [a]) => scalar_with_argument(body, m, &name, *x, a),
        (Value::Scalar(x), [a, b]) if name == "mul_add" => {
            let (a, b) = (body.scalar(a)?, body.scalar(b)?);
            let product = body.graph.mul(*x, a);
            Some(Value::Scalar(sum(&mut body.graph, product, b, Q::ONE)))
        }
        (Value::Scalar(x), [low, high]) if name == "clamp" => {
            let (low, high) = (body.scalar(low)?, body.scalar(high)?);
            let above = kept(body, (*x, low), false);
            Some(Value::Scalar(kept(body, (above, high), true)))
        }
        (Value::Matrix(_), _) => matrix_method(body, m, &name, receiver, &args),
        (v, _) if v.vector().is_some() => {
            let v = v.vector()?.to_vec();
            vector_method(body, m, &name, v, &args)
        }
        (other, _) => {
            let what = other.describe();
            body.error(&m.method, format!("{what} has no method `{name}` in the language"))
        }
    }
}

fn function_named(name: &str) -> Option<Fun> {
    Some(match name {
        "exp" => Fun::Exp,
        "exp_m1" => Fun::ExpM1,
        "ln" => Fun::Ln,
        "ln_1p" => Fun::Ln1p,
        "sin" => Fun::Sin,
        "cos" => Fun::Cos,
        "tan" => Fun::Tan,
        "asin" => Fun::Asin,
        "acos" => Fun::Acos,
        "atan" => Fun::Atan,
        "sinh" => Fun::Sinh,
        "cosh" => Fun::Cosh,
        "tanh" => Fun::Tanh,
        "asinh" => Fun::Asinh,
        "acosh" => Fun::Acosh,
        "atanh" => Fun::Atanh,
        "cbrt" => Fun::Cbrt,
        "abs" => Fun::Abs,
        _ => return None,
    })
}

fn scalar_function(body: &mut Body, m: &ExprMethodCall, name: &str, x: Id) -> Option<Value> {
    match name {
        "abs" => return Some(Value::Scalar(body.absolute(x))),
        "signum" => return Some(Value::Scalar(body.signum(x))),
        "floor" => return body.floor(&m.method, x).map(Value::Scalar),
        "fract" => {
            let whole = body.floor(&m.method, x)?;
            if !body.graph.range(x).nonnegative() {
                return body.error(
                    &m.method,
                    "`fract` is x - trunc(x), which turns round at zero, and this number may be negative: write `x - x.floor()` if that is meant, or declare domains of parameters that exclude it",
                );
            }
            return Some(Value::Scalar(body.graph.sub(x, whole)));
        }
        _ => {}
    }
    let g = &mut body.graph;
    if let Some(f) = function_named(name) {
        let value = g.call(f, &[x]);
        body.note_partial(value);
        return Some(Value::Scalar(value));
    }
    let id = match name {
        "sqrt" => g.sqrt(x),
        "recip" => g.powi(x, -1),
        "exp2" => {
            let two = g.int(2);
            g.pow(two, x)
        }
        "log2" | "log10" => {
            let base = g.int(if name == "log2" { 2 } else { 10 });
            logarithm(g, x, base)
        }
        "to_radians" | "to_degrees" => {
            let pi = g.pi();
            let right = g.int(180);
            let radians = g.div(pi, right);
            if name == "to_radians" { g.mul(x, radians) } else { g.div(x, radians) }
        }
        "sin_cos" => {
            let (s, c) = (g.call(Fun::Sin, &[x]), g.call(Fun::Cos, &[x]));
            return Some(Value::Tuple(vec![Value::Scalar(s), Value::Scalar(c)]));
        }
        "clone" | "to_owned" => x,
        "ceil" | "round" | "trunc" => {
            return body.error(
                &m.method,
                format!("`{name}` is not a function of the language: write it with `floor`"),
            );
        }
        _ => {
            return body.error(
                &m.method,
                format!("`{name}` is not a function of the language. Numbers have: sqrt cbrt recip exp exp2 exp_m1 ln ln_1p log log2 log10 sin cos sin_cos tan asin acos atan atan2 to_radians to_degrees sinh cosh tanh asinh acosh atanh abs powi powf hypot mul_add; free functions are {SPECIAL}"),
            );
        }
    };
    body.note_partial(id);
    Some(Value::Scalar(id))
}

/// log of x to a base.
fn logarithm(g: &mut Graph, x: Id, base: Id) -> Id {
    let (top, bottom) = (g.call(Fun::Ln, &[x]), g.call(Fun::Ln, &[base]));
    g.div(top, bottom)
}

fn scalar_with_argument(
    body: &mut Body,
    m: &ExprMethodCall,
    name: &str,
    x: Id,
    a: &Expr,
) -> Option<Value> {
    match name {
        "powi" => {
            let n = body.scalar(a)?;
            if body.graph.as_number(n).is_none_or(|q| !q.is_int()) {
                return body.error(a, "the exponent of `powi` is an integer that is known while compiling, because it decides how many roots there are; use `powf` for a parameter");
            }
            Some(Value::Scalar(body.graph.pow(x, n)))
        }
        "powf" => {
            let e = body.scalar(a)?;
            let power = body.graph.pow(x, e);
            body.note_partial(power);
            Some(Value::Scalar(power))
        }
        "log" => {
            let base = body.scalar(a)?;
            let value = logarithm(&mut body.graph, x, base);
            body.note_partial(value);
            Some(Value::Scalar(value))
        }
        "hypot" => {
            let y = body.scalar(a)?;
            let g = &mut body.graph;
            let s = dot(g, &[x, y], &[x, y]);
            Some(Value::Scalar(g.sqrt(s)))
        }
        "atan2" => {
            let y = body.scalar(a)?;
            Some(Value::Scalar(body.graph.call(Fun::Atan2, &[x, y])))
        }
        "min" | "max" => {
            let y = body.scalar(a)?;
            Some(Value::Scalar(kept(body, (x, y), name == "min")))
        }
        "copysign" => {
            let sign = body.scalar(a)?;
            let (size, sign) = (body.absolute(x), body.signum(sign));
            Some(Value::Scalar(body.graph.mul(size, sign)))
        }
        "rem_euclid" => {
            let period = body.scalar(a)?;
            // Whatever its sign, the rest is not negative.
            let period = body.absolute(period);
            let turns = body.graph.div(x, period);
            let turns = body.floor(&m.method, turns)?;
            let whole = body.graph.mul(turns, period);
            Some(Value::Scalar(body.graph.sub(x, whole)))
        }
        _ => body.error(&m.method, format!("`{name}` is not a function of two numbers in the language: there are powi, powf, log, hypot, atan2, min, max (both: clamp), copysign and rem_euclid")),
    }
}

fn vector_method(
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
        ("vec" | "clone", []) => Some(Value::Vector(v)),
        _ => body.error(&m.method, format!("`{name}` is not a method of vectors in the language: there are dot, cross, length, length_squared and normalize")),
    }
}

fn matrix_method(
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

/// Type::constructor(args) and functions.
pub fn call(body: &mut Body, c: &ExprCall) -> Option<Value> {
    let Expr::Path(p) = &*c.func else {
        return body.error(c, "only named functions can be called here");
    };
    let names: Vec<String> = p.path.segments.iter().map(|s| s.ident.to_string()).collect();
    let name = names.last().cloned().unwrap_or_default();
    let owner = names.len().checked_sub(2).map(|i| names[i].clone()).unwrap_or_default();
    let args: Vec<&Expr> = c.args.iter().collect();
    let is_module = names.len() > 1 && names[0].starts_with(char::is_lowercase);
    if is_module && !OURS.contains(&names[0].as_str()) {
        return unknown_function(body, c, &names.join("::"));
    }
    match (owner.as_str(), name.as_str(), &args[..]) {
        (_, "solve", [f, range, target]) => super::solve::solve(body, c, [f, range, target]),
        (_, "precomputed", [a]) if names.len() == 1 => body.precomputed(a),
        (_, "Some", [a]) => body.expr(a),
        ("Mixed", "Continuous", [_]) | ("Mixed", "Atom", [_, _]) => marked(body, c, &args),
        ("Vec2", "new", [x, y]) => Some(Value::Vector(vec![body.scalar(x)?, body.scalar(y)?])),
        ("Vec3", "new", [x, y, z]) => {
            let v = [body.scalar(x)?, body.scalar(y)?, body.scalar(z)?];
            body.graph.note_vector(v);
            Some(Value::Vector(v.to_vec()))
        }
        ("Vec2" | "Vec3", "splat", [x]) => {
            let x = body.scalar(x)?;
            Some(Value::Vector(vec![x; if owner == "Vec2" { 2 } else { 3 }]))
        }
        ("Direction" | "Surface" | "Curve", "new", [x, y, z]) => {
            let v = vec![body.scalar(x)?, body.scalar(y)?, body.scalar(z)?];
            Some(Value::Point(space_named(&owner)?, v, None))
        }
        ("Direction" | "Surface" | "Curve", "from_vec", [v]) => {
            let v = vector(body, v)?;
            Some(Value::Point(space_named(&owner)?, v, None))
        }
        ("", "Embedded", [a]) => {
            let v = vector(body, a)?;
            let n = v.len();
            Some(Value::Point(Space::Embedded { k: 0, n }, v, None))
        }
        ("Embedded", "new", _) => body.error(
            &c.func,
            "a point of an embedded space is made of its coordinates: `Embedded([x, y])`",
        ),
        ("SurfacePoint", "new", [v, id]) => {
            let v = vector(body, v)?;
            match body.expr(id)? {
                Value::Opaque(tokens) => Some(Value::Point(Space::SurfacePoint, v, Some(tokens))),
                _ => body.error(id, "the identity of a surface is a parameter of type `SurfaceId`, because densities compare it and know nothing else of the surface: add `id: SurfaceId` to the parameters"),
            }
        }
        ("Mat3", "from_cols", [x, y, z]) => {
            Some(Value::Matrix([vector(body, x)?, vector(body, y)?, vector(body, z)?]))
        }
        ("Frame", "around", [n]) => around(body, n),
        ("" | "special", f, arguments) if SPECIAL.split(' ').any(|name| name == f) => {
            special_function(body, c, f, arguments)
        }
        // A method by its path.
        ("f64" | "Vec2" | "Vec3", _, [receiver, ..]) => {
            let (receiver, f) = (*receiver, &p.path.segments.last()?.ident);
            let rest = &args[1..];
            method(body, &syn::parse_quote_spanned!(f.span()=> (#receiver).#f(#(#rest),*)))
        }
        _ => unknown_function(body, c, &names.join("::")),
    }
}

/// Crates and modules that paths to functions of the language start with: others may have functions of the same names.
const OURS: [&str; 11] = [
    "std",
    "core",
    "f64",
    "glam",
    "aether_core",
    "prelude",
    "special",
    "forms",
    "point",
    "vec",
    "mixed",
];

/// The frame about a direction, as `Frame::around` makes it (Duff et al. 2017, "Building an Orthonormal Basis, Revisited"):
/// a piece above the horizon, and one below.
fn around(body: &mut Body, e: &Expr) -> Option<Value> {
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

fn unknown_function(body: &mut Body, c: &ExprCall, name: &str) -> Option<Value> {
    let way = if body.own_name == name {
        "It is this function itself, and a formula cannot contain itself: write the cases out, or let a `#[strategy]` choose among samplers".to_owned()
    } else if body.depends(&c.args) {
        "Its argument is sampled, so the compiler must see through it: write the formula here, or make it a `#[map]` and `.apply` it".to_owned()
    } else {
        format!(
            "It does not depend on the first parameter, so if it gives the same number each time it can be computed beforehand: `precomputed({})`. What is random in a sample comes from the uniforms alone",
            c.to_token_stream()
        )
    };
    body.error(&c.func, format!("`{name}` is not known to the language. {way}"))
}

fn space_named(name: &str) -> Option<Space> {
    Some(match name {
        "Direction" => Space::Direction,
        "Surface" => Space::Embedded { k: 2, n: 3 },
        "Curve" => Space::Embedded { k: 1, n: 3 },
        _ => return None,
    })
}

fn vector(body: &mut Body, e: &Expr) -> Option<Vec<Id>> {
    let value = body.expr(e)?;
    match value.vector() {
        Some(v) => Some(v.to_vec()),
        None => {
            let what = value.describe();
            body.error(e, format!("a vector is needed here, and this is {what}"))
        }
    }
}
