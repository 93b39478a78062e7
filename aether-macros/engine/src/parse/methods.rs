//! Operators, methods and constructors of the language.

use quote::ToTokens;
use syn::{BinOp, Expr, ExprBinary, ExprCall, ExprMethodCall};

use super::body::Body;
use super::bounded::{bounded_argument, kept};
use super::mixed::marked;
use super::special::{SPECIAL, special_function};
use super::vectors::{around, matrix_method, vector, vector_method};
use super::whole::is_type;
use super::{Space, Value};
use crate::expr::{Fun, Graph, Id, shed};
use crate::rational::Q;
use crate::solve::linear::dot;

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

/// receiver.method(args).
pub fn method(body: &mut Body, m: &ExprMethodCall) -> Option<Value> {
    let name = m.method.to_string();
    if let Some(inside) = body.contains(m) {
        return inside;
    }
    if let Some(bounded) = bounded_argument(&name, &m.receiver) {
        let x = bounded.value(body)?;
        return scalar_function(body, m, &name, x);
    }
    let receiver = body.expr(&m.receiver)?;
    if body.left() {
        return Some(Value::Unit);
    }
    let args: Vec<&Expr> = m.args.iter().collect();
    if let Some(all) = receiver.elements() {
        return body.list_method(m, all, &args);
    }
    if let Some(value) = body.option_method(m, &receiver) {
        return value;
    }
    match (&receiver, &args[..]) {
        (Value::Integer(x), _) => body.integer_method(m, *x, &args),
        (Value::Bool(b), [a]) if matches!(name.as_str(), "then_some" | "then") => {
            if !b {
                return Some(Value::Nothing);
            }
            match body.expr(a)? {
                Value::Callable(f) if name == "then" => body.apply(m, &f, vec![]),
                value => Some(value),
            }
        }
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
        "ceil" => return body.ceiling(&m.method, x).map(Value::Scalar),
        "trunc" => return body.truncated(&m.method, x).map(Value::Scalar),
        "round" => return body.rounded(&m.method, x).map(Value::Scalar),
        "fract" => {
            let whole = body.truncated(&m.method, x)?;
            return Some(Value::Scalar(body.graph.sub(x, whole)));
        }
        // What is no number is no sample, so that there is nothing to ask.
        "is_nan" | "is_infinite" => return Some(Value::Bool(false)),
        "is_finite" => return Some(Value::Bool(true)),
        "is_sign_positive" => return Some(Value::Bool(body.decide(x, false))),
        "is_sign_negative" => return Some(Value::Bool(!body.decide(x, false))),
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
        "clone" | "to_owned" | "into" => x,
        _ => {
            return body.error(
                &m.method,
                format!("`{name}` is not a function of the language. Numbers have: sqrt cbrt recip exp exp2 exp_m1 ln ln_1p log log2 log10 sin cos sin_cos tan asin acos atan atan2 to_radians to_degrees sinh cosh tanh asinh acosh atanh abs signum floor ceil round trunc fract powi powf hypot mul_add; free functions are {SPECIAL}"),
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
            body.rest(&m.method, x, period).map(Value::Scalar)
        }
        "div_euclid" => {
            let period = body.scalar(a)?;
            body.turns(&m.method, x, period).map(Value::Scalar)
        }
        "midpoint" => {
            let y = body.scalar(a)?;
            Some(Value::Scalar(body.graph.sum(Q::ZERO, &[(Q::HALF, x), (Q::HALF, y)])))
        }
        _ => body.error(&m.method, format!("`{name}` is not a function of two numbers in the language: there are powi, powf, log, hypot, atan2, min, max (both: clamp), copysign, midpoint, rem_euclid and div_euclid")),
    }
}

/// Type::constructor(args) and functions.
pub fn call(body: &mut Body, c: &ExprCall) -> Option<Value> {
    let args: Vec<&Expr> = c.args.iter().collect();
    let Expr::Path(p) = &*c.func else {
        return match body.expr(&c.func)? {
            Value::Callable(f) => body.call_with(c, &f, &args),
            _ => body.error(c, "only functions can be called here"),
        };
    };
    if let Some(name) = p.path.get_ident()
        && let Some(Value::Callable(f)) = body.names.get(&name.to_string()).cloned()
    {
        return body.call_with(c, &f, &args);
    }
    let names: Vec<String> = p.path.segments.iter().map(|s| s.ident.to_string()).collect();
    let name = names.last().cloned().unwrap_or_default();
    let owner = names.len().checked_sub(2).map(|i| names[i].clone()).unwrap_or_default();
    let is_module = names.len() > 1 && names[0].starts_with(char::is_lowercase);
    if is_module && !is_type(&names[0]) && !OURS.contains(&names[0].as_str()) {
        return unknown_function(body, c, &names.join("::"));
    }
    match (owner.as_str(), name.as_str(), &args[..]) {
        (_, "solve", [f, range, target]) => super::solve::solve(body, c, [f, range, target]),
        (_, "precomputed", [a]) if names.len() == 1 => body.precomputed(a),
        (_, "Some", [a]) => match body.expr(a)? {
            Value::Nothing => body.error(
                a,
                "an option of an option has no meaning here: a point exists, or it does not",
            ),
            value => Some(value),
        },
        ("f64", "from", [a]) => {
            let value = match body.expr(a)? {
                Value::Bool(b) => Value::Scalar(body.graph.int(i64::from(b))),
                value => value,
            };
            body.converted(a, value, "f64")
        }
        (ty, "from", [a]) if is_type(ty) => {
            let value = body.expr(a)?;
            body.converted(a, value, ty)
        }
        ("Vec2" | "Vec3", "from_array", [a]) => {
            let v = vector(body, a)?;
            if let [x, y, z] = v[..] {
                body.graph.note_vector([x, y, z]);
            }
            Some(Value::Vector(v))
        }
        ("Vec2" | "Vec3", "from", [a]) => vector(body, a).map(Value::Vector),
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
