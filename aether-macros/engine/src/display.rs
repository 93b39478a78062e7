//! Expressions as text, for documentation, `explain` and error messages.

use crate::expr::{Fun, Graph, Id, Node};
use crate::rational::Q;
use crate::sorted;

/// The longest text of an expression, in characters.
const LONGEST: usize = 400;

thread_local! {
    /// Parts of an expression that may still be written: one in which parts occur again and again
    /// has a text that is far longer than anybody reads, and would take long to write.
    static ROOM: std::cell::Cell<usize> = const { std::cell::Cell::new(0) };
}

/// The expression in ordinary mathematical notation; of a long one the beginning.
pub fn show(g: &Graph, id: Id) -> String {
    // What is below a line is written after what is above, so that there has to be some more.
    ROOM.set(4 * LONGEST);
    let text = print(g, id, 0);
    if text.chars().count() <= LONGEST {
        return text;
    }
    let head: String = text.chars().take(LONGEST - 10).collect();
    format!("{head} …")
}

/// Precedences: 0 sum, 1 product, 2 power or call.
fn print(g: &Graph, id: Id, outer: u8) -> String {
    let Some(room) = ROOM.get().checked_sub(1) else { return "…".to_owned() };
    ROOM.set(room);
    let (text, own) = match g.node(id) {
        Node::Number(q) => (
            q.to_string(),
            if q.is_negative() {
                0
            } else if q.is_int() {
                3
            } else {
                1
            },
        ),
        Node::Float(bits) => (format!("{}", f64::from_bits(*bits)).replace("inf", "∞"), 3),
        Node::Pi => ("π".to_owned(), 3),
        Node::Leaf(l) => (g.name(*l).to_owned(), 3),
        Node::Sum(c, terms) if c.is_zero() && terms.len() == 1 => {
            (scaled(g, terms[0].0, terms[0].1), 1)
        }
        Node::Sum(c, terms) => (sum(g, *c, terms), 0),
        Node::Product(factors) => {
            (product(g, Q::ONE, factors), if factors.len() == 1 { 2 } else { 1 })
        }
        Node::Call(f, args) => {
            // What the first argument of an incomplete beta function leaves of one goes without saying.
            let args: Vec<String> = args.iter().take(3).map(|a| print(g, *a, 0)).collect();
            (format!("{}({})", name(*f), args.join(", ")), 3)
        }
        Node::If(test, yes, no) => {
            let [test, yes, no] = [test, yes, no].map(|part| print(g, *part, 0));
            (format!("{{{yes} if {test} > 0, else {no}}}"), 3)
        }
        Node::Root(r) => {
            let [body, target, lo, hi] =
                [r.body, r.target, r.lo, r.hi].map(|part| print(g, part, 0));
            let t = g.name(r.variable);
            (format!("root({t} in {lo}..{hi}: {body} = {target})"), 3)
        }
    };
    if own < outer { format!("({text})") } else { text }
}

fn sum(g: &Graph, c: Q, terms: &[(Q, Id)]) -> String {
    let mut out = String::new();
    let mut ordered: Vec<&(Q, Id)> = terms.iter().collect();
    // Start with something positive if there is anything.
    sorted::sort_by_key(&mut ordered, |(q, _)| q.is_negative());
    if !c.is_zero() {
        out.push_str(&c.to_string());
    }
    for (q, t) in ordered {
        let text = scaled(g, q.abs(), *t);
        match (out.is_empty(), q.is_negative()) {
            (true, false) => out.push_str(&text),
            (true, true) => out.push_str(&format!("-{text}")),
            (false, negative) => {
                out.push_str(&format!(" {} {text}", if negative { '-' } else { '+' }))
            }
        }
    }
    out
}

fn scaled(g: &Graph, q: Q, t: Id) -> String {
    let one = [(t, Id(u32::MAX))];
    let factors: &[(Id, Id)] = match g.node(t) {
        Node::Product(f) => f,
        _ => &one,
    };
    if q.is_negative() {
        format!("-{}", product(g, q.neg(), factors))
    } else {
        product(g, q, factors)
    }
}

fn product(g: &Graph, q: Q, factors: &[(Id, Id)]) -> String {
    let (mut top, mut bottom) = (Vec::new(), Vec::new());
    if q.num() != 1 {
        top.push(q.num().to_string());
    }
    if q.den() != 1 {
        bottom.push(q.den().to_string());
    }
    for (b, e) in factors {
        let exponent = if e.0 == u32::MAX { Some(Q::ONE) } else { g.as_number(*e) };
        match exponent {
            Some(e) if e.is_negative() => bottom.push(power(g, *b, e.neg())),
            Some(e) => top.push(power(g, *b, e)),
            None => top.push(format!("{}^{}", print(g, *b, 3), print(g, *e, 3))),
        }
    }
    let top = if top.is_empty() { "1".to_owned() } else { top.join(" ") };
    match bottom.len() {
        0 => top,
        1 => format!("{top} / {}", bottom[0]),
        _ => format!("{top} / ({})", bottom.join(" ")),
    }
}

fn power(g: &Graph, b: Id, e: Q) -> String {
    if e == Q::ONE {
        return print(g, b, 2);
    }
    if e == Q::HALF {
        return format!("√{}", print(g, b, 3));
    }
    let base = print(g, b, 3);
    if e.is_int() {
        let digits: String = e.to_string().chars().map(superscript).collect();
        return format!("{base}{digits}");
    }
    format!("{base}^({e})")
}

fn superscript(c: char) -> char {
    match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        d => d.to_digit(10).and_then(|d| char::from_u32(0x2070 + d)).unwrap_or(c),
    }
}

fn name(f: Fun) -> &'static str {
    match f {
        Fun::Exp => "exp",
        Fun::ExpM1 => "expm1",
        Fun::Ln => "ln",
        Fun::Ln1p => "ln1p",
        Fun::Sin => "sin",
        Fun::Cos => "cos",
        Fun::Tan => "tan",
        Fun::Asin => "asin",
        Fun::Acos => "acos",
        Fun::Atan => "atan",
        Fun::Sinh => "sinh",
        Fun::Cosh => "cosh",
        Fun::Tanh => "tanh",
        Fun::Asinh => "asinh",
        Fun::Acosh => "acosh",
        Fun::Atanh => "atanh",
        Fun::Cbrt => "cbrt",
        Fun::Erf => "erf",
        Fun::Erfc => "erfc",
        Fun::ErfInv => "erf⁻¹",
        Fun::ErfcInv => "erfc⁻¹",
        Fun::LnErfc => "ln erfc",
        Fun::ErfcInvExp => "erfc⁻¹ exp",
        Fun::LambertW => "W",
        Fun::LnGamma => "lnΓ",
        Fun::LnBeta => "lnB",
        Fun::BetaInc => "I",
        Fun::BetaIncInv => "I⁻¹",
        Fun::Abs => "abs",
        Fun::Sign => "sign",
        Fun::Atan2 => "atan2",
        Fun::Turn => "turn",
        Fun::TurnTo => "turn_to",
        Fun::SinPi => "sinpi",
        Fun::CosPi => "cospi",
        Fun::Pow1p => "pow1p",
    }
}
