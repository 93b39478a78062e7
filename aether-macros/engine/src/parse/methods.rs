//! Methods of the language: functions of numbers, written behind the first of them.

use syn::{Expr, ExprMethodCall};

use super::Value;
use super::body::Body;
use super::bounded::{bounded_argument, kept};
use super::operators::sum;
use super::special::SPECIAL;
use super::vectors::{matrix_method, vector_method};
use crate::expr::{Fun, Graph, Id};
use crate::matrix::dot;
use crate::rational::Q;

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
