//! Constructors and functions of the language.

use quote::ToTokens;
use syn::{Expr, ExprCall};

use super::body::Body;
use super::methods::method;
use super::mixed::marked;
use super::special::{SPECIAL, special_function};
use super::vectors::{around, vector};
use super::whole::is_type;
use super::{Space, Value};

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
