//! Ordinary Rust within a body: each construct in a sampler, beside the same sampler without it. Images, densities and
//! preimages must agree.

use aether_engine::interpret::Item;

/// What follows the name of a sampler, with a construct and without.
struct Pair {
    domains: &'static str,
    with: &'static str,
    without: &'static str,
}

const fn pair(domains: &'static str, with: &'static str, without: &'static str) -> Pair {
    Pair { domains, with, without }
}

fn read(domains: &str, text: &str) -> Item {
    let text = format!("fn s{text}");
    let item = Item::new(domains.parse().expect("domains"), text.parse().expect("is Rust"), true);
    item.unwrap_or_else(|why| panic!("{text}\n{why}"))
}

/// Asserts that two samplers are the same, of which each parameter is 1, 2 or 3.
fn compare(pair: &Pair) {
    let (with, without) = (read(pair.domains, pair.with), read(pair.domains, pair.without));
    let numbers = |item: &Item| item.parsed.signature.params.len();
    assert_eq!(numbers(&with), numbers(&without));
    let count = match with.parsed.signature.source {
        aether_engine::parse::Source::Uniforms { count, .. } => count,
        _ => unreachable!("samplers have uniforms"),
    };
    for step in 0..200 {
        let place = |k: usize| (0.5 + 0.618_033_988_749_895 * (step * 7 + 3 * k) as f64).fract();
        let p: Vec<f64> = (0..numbers(&with)).map(|k| 1.0 + (2.0 * place(k + 5)).round()).collect();
        let u: Vec<f64> = (0..count).map(place).collect();
        let (x, y) = (with.forward(&p, &u), without.forward(&p, &u));
        assert_eq!(x.is_some(), y.is_some(), "{} at {u:?} of {p:?}", pair.with);
        let (Some(x), Some(y)) = (x, y) else { continue };
        let close = |a: f64, b: f64| a == b || (a - b).abs() <= 1e-9 * b.abs().max(1e-3);
        assert!(x.iter().zip(&y).all(|(a, b)| close(*a, *b)), "{}: {x:?} for {y:?}", pair.with);
        let (d, e) = (with.pdf(&p, &x), without.pdf(&p, &x));
        assert!(close(d, e) && d > 0.0, "{} at {u:?}: density {d} for {e}", pair.with);
        let preimages = [&with, &without].map(|item| item.preimages(&p, &x).len());
        assert_eq!(preimages[0], preimages[1], "{} at {u:?}", pair.with);
    }
}

#[test]
fn constants() {
    let pairs = [
        pair(
            "",
            "(u: [Uniform; 1]) -> f64 { const SCALE: f64 = 2.0 * PI; const N: i32 = 7 / 2; N as f64 + SCALE * u[0] }",
            "(u: [Uniform; 1]) -> f64 { 3.0 + 2.0 * PI * u[0] }",
        ),
        pair(
            "",
            "(u: [Uniform; 1]) -> f64 { fn twice(x: f64) -> f64 { K * x } const K: f64 = 2.0; twice(u[0]) + std::f64::consts::LN_10 }",
            "(u: [Uniform; 1]) -> f64 { 2.0 * u[0] + (10.0).ln() }",
        ),
        pair(
            "",
            "(u: [Uniform; 1]) -> f64 { use std::f64::consts::FRAC_2_SQRT_PI; FRAC_2_SQRT_PI * u[0].max(f64::EPSILON) }",
            "(u: [Uniform; 1]) -> f64 { 2.0 / PI.sqrt() * u[0].max(1.0 / 4503599627370496.0) }",
        ),
        pair(
            "",
            "(u: [Uniform; 2]) -> Vec2 { const W: [f64; 2] = [2.0, 3.0]; const I: usize = 1; Vec2::new(W[0] * u[I], W[I] * u[0]) }",
            "(u: [Uniform; 2]) -> Vec2 { Vec2::new(2.0 * u[1], 3.0 * u[0]) }",
        ),
        // An inner name hides an outer one, and is gone after its block.
        pair(
            "",
            "(u: [Uniform; 1]) -> f64 { const K: f64 = 2.0; let a = { const K: f64 = 3.0; K * u[0] }; a + K }",
            "(u: [Uniform; 1]) -> f64 { 3.0 * u[0] + 2.0 }",
        ),
    ];
    pairs.iter().for_each(compare);
}

#[test]
fn conditions() {
    let pairs = [
        pair(
            "",
            "(u: [Uniform; 1]) -> f64 { debug_assert!(u[0] >= 0.0, \"{}\", u[0]); if matches!(u[0], 0.25..0.5) { u[0] } else { 2.0 * u[0] } }",
            "(u: [Uniform; 1]) -> f64 { if u[0] >= 0.25 && u[0] < 0.5 { u[0] } else { 2.0 * u[0] } }",
        ),
        pair(
            "",
            "(u: [Uniform; 1]) -> f64 { if !(0.25..=0.75).contains(&u[0]) { 4.0 + u[0] } else { 2.0 * u[0] } }",
            "(u: [Uniform; 1]) -> f64 { if u[0] < 0.25 || u[0] > 0.75 { 4.0 + u[0] } else { 2.0 * u[0] } }",
        ),
        pair(
            "",
            "(u: [Uniform; 1], k: f64) -> f64 { if matches!(k, x if x > 1.5) { k * u[0] } else { 5.0 + u[0] } }",
            "(u: [Uniform; 1], k: f64) -> f64 { if k > 1.5 { k * u[0] } else { 5.0 + u[0] } }",
        ),
    ];
    pairs.iter().for_each(compare);
}

#[test]
fn steps() {
    let pairs = [
        pair(
            "",
            "(u: [Uniform; 1]) -> f64 { let x = 5.0 * u[0] - 2.25; x.round() + x * x.fract() }",
            "(u: [Uniform; 1]) -> f64 {
                let x = 5.0 * u[0] - 2.25;
                let n = if x < 0.0 { -(0.5 - x).floor() } else { (x + 0.5).floor() };
                let t = if x < 0.0 { -(-x).floor() } else { x.floor() };
                n + x * (x - t)
            }",
        ),
        pair(
            "",
            "(u: [Uniform; 1]) -> f64 { let x = 3.0 * u[0]; x.ceil() + 0.5 * x.trunc() * x + x }",
            "(u: [Uniform; 1]) -> f64 { let x = 3.0 * u[0]; -(-x).floor() + 0.5 * x.floor() * x + x }",
        ),
        pair(
            "",
            "(u: [Uniform; 1]) -> f64 { let x = 4.0 * u[0] - 2.0; x.div_euclid(1.5) + x % 1.5 + x }",
            "(u: [Uniform; 1]) -> f64 {
                let x = 4.0 * u[0] - 2.0;
                let t = if x < 0.0 { -(-x / 1.5).floor() } else { (x / 1.5).floor() };
                (x / 1.5).floor() + (x - 1.5 * t) + x
            }",
        ),
        // A choice among three by one uniform, which is used again.
        pair(
            "",
            "(u: [Uniform; 1]) -> f64 {
                let centers = [0.0, 2.0, 5.0];
                let i = ((3.0 * u[0]) as usize).min(2);
                let v = 3.0 * u[0] - i as f64;
                centers[i] + if i % 2 == 0 { v } else { 0.5 * v }
            }",
            "(u: [Uniform; 1]) -> f64 {
                let k = (3.0 * u[0]).floor();
                let v = 3.0 * u[0] - k;
                if k < 0.5 { v } else if k < 1.5 { 2.0 + 0.5 * v } else { 5.0 + v }
            }",
        ),
        pair(
            "",
            "(u: [Uniform; 1]) -> f64 { match (2.0 * u[0]) as u32 { 0 => 3.0 * u[0], _ => 5.0 + u[0] } }",
            "(u: [Uniform; 1]) -> f64 { if u[0] < 0.5 { 3.0 * u[0] } else { 5.0 + u[0] } }",
        ),
    ];
    pairs.iter().for_each(compare);
}

#[test]
fn functions_within() {
    let pairs = [
        pair(
            "",
            "(u: [Uniform; 1], k: f64) -> f64 { let f = |x: f64| k * x * x; let k = 7.0; f(u[0]) + k }",
            "(u: [Uniform; 1], k: f64) -> f64 { k * u[0] * u[0] + 7.0 }",
        ),
        pair(
            "",
            "(u: [Uniform; 2]) -> Vec2 {
                fn disk(u: [f64; 2]) -> (f64, f64) { let [a, b] = u; let r = a.sqrt(); (r, 2.0 * PI * b) }
                let (r, phi) = disk(u);
                Vec2::new(r * phi.cos(), r * phi.sin())
            }",
            "(u: [Uniform; 2]) -> Vec2 {
                let r = u[0].sqrt();
                let phi = 2.0 * PI * u[1];
                Vec2::new(r * phi.cos(), r * phi.sin())
            }",
        ),
        // A function that returns early, and one that is handed on.
        pair(
            "",
            "(u: [Uniform; 1]) -> f64 {
                fn side(x: f64) -> f64 { if x < 0.5 { return x; } 2.0 * x }
                let twice = |f: fn(f64) -> f64, x: f64| f(x) + f(x);
                1.0 + twice(side, u[0])
            }",
            "(u: [Uniform; 1]) -> f64 { 1.0 + if u[0] < 0.5 { 2.0 * u[0] } else { 4.0 * u[0] } }",
        ),
    ];
    pairs.iter().for_each(compare);
}

#[test]
fn loops() {
    let pairs = [
        pair(
            "",
            "(u: [Uniform; 1]) -> f64 { let mut x = u[0]; for i in 1..=3 { x += x * x / i as f64; } x }",
            "(u: [Uniform; 1]) -> f64 {
                let a = u[0];
                let b = a + a * a;
                let c = b + b * b / 2.0;
                c + c * c / 3.0
            }",
        ),
        pair(
            "",
            "(u: [Uniform; 1]) -> f64 { let w = [1.0, 2.0, 4.0]; let total: f64 = w.iter().sum(); total * u[0] + (0..3).map(|i| i as f64 * w[i]).sum::<f64>() }",
            "(u: [Uniform; 1]) -> f64 { 7.0 * u[0] + 10.0 }",
        ),
        pair(
            "",
            "(u: [Uniform; 1]) -> f64 {
                let mut x = u[0];
                for i in 0..5 { if i == 1 { continue; } if x > 2.0 { break; } x += i as f64 * 0.5; }
                x
            }",
            "(u: [Uniform; 1]) -> f64 { if u[0] + 1.0 > 2.0 { u[0] + 1.0 } else { let x = u[0] + 2.5; x } }",
        ),
        // A closure of `solve` with a name, and a `return` of its own.
        pair(
            "",
            "(u: [Uniform; 1]) -> f64 { let f = |t: f64| { return t + t.powi(3); }; solve(f, 0.0..1.0, 2.0 * u[0]) }",
            "(u: [Uniform; 1]) -> f64 { solve(|t| t + t.powi(3), 0.0..1.0, 2.0 * u[0]) }",
        ),
        // Choosing by weights, as one finds it: the uniform is used again.
        pair(
            "",
            "(u: [Uniform; 1]) -> f64 {
                let weights = [0.25, 0.5, 0.25];
                let mut rest = u[0];
                let mut chosen = 2;
                for (i, w) in weights.iter().enumerate() {
                    if rest < *w { chosen = i; break; }
                    rest -= w;
                }
                chosen as f64 * 2.0 + rest / weights[chosen]
            }",
            "(u: [Uniform; 1]) -> f64 {
                if u[0] < 0.25 { u[0] / 0.25 } else if u[0] - 0.25 < 0.5 { 2.0 + (u[0] - 0.25) / 0.5 }
                else { 4.0 + (u[0] - 0.75) / 0.25 }
            }",
        ),
    ];
    pairs.iter().for_each(compare);
}

#[test]
fn names_that_change() {
    let pairs = [
        pair(
            "",
            "(u: [Uniform; 1], k: f64) -> f64 { let mut x = u[0]; x *= k + 1.0; if x > 1.0 { x = 2.0 * x - 1.0; } x }",
            "(u: [Uniform; 1], k: f64) -> f64 { let x = u[0] * (k + 1.0); if x > 1.0 { 2.0 * x - 1.0 } else { x } }",
        ),
        pair(
            "",
            "(u: [Uniform; 2]) -> Vec2 {
                let mut p = Vec2::new(u[0], u[1]);
                if u[0] + u[1] > 1.0 { p.x = 1.0 - p.x; p.y = 1.0 - p.y; }
                p
            }",
            "(u: [Uniform; 2]) -> Vec2 {
                let (a, b) = if u[0] + u[1] > 1.0 { (1.0 - u[0], 1.0 - u[1]) } else { (u[0], u[1]) };
                Vec2::new(a, b)
            }",
        ),
        pair(
            "",
            "(u: [Uniform; 2]) -> Vec2 {
                let (mut a, mut b) = (u[0], u[1]);
                let sign;
                if a < b { (a, b) = (b, a); sign = -1.0; } else { sign = 1.0; }
                Vec2::new(a + b, sign * (a - b))
            }",
            "(u: [Uniform; 2]) -> Vec2 { Vec2::new(u[0] + u[1], u[0] - u[1]) }",
        ),
        // What a block changes after it has bound the name again is its own.
        pair(
            "",
            "(u: [Uniform; 1]) -> f64 { let mut x = u[0]; { x += 1.0; let mut x = 5.0; x += 1.0; let _ = x; } x }",
            "(u: [Uniform; 1]) -> f64 { u[0] + 1.0 }",
        ),
        pair(
            "",
            "(mut u: [Uniform; 2]) -> Vec2 { u[0] = 2.0 * u[0]; u[1] -= 0.5; let Vec2 { x, y } = Vec2::new(u[0], u[1]); Vec2 { x: x + y, y } }",
            "(u: [Uniform; 2]) -> Vec2 { Vec2::new(2.0 * u[0] + u[1] - 0.5, u[1] - 0.5) }",
        ),
    ];
    pairs.iter().for_each(compare);
}

#[test]
fn options() {
    let pairs = [
        pair(
            "",
            "(u: [Uniform; 1], k: f64) -> Option<f64> {
                fn inside(x: f64) -> Option<f64> { if x > 0.25 { Some(2.0 * x) } else { None } }
                let x = inside(u[0])?;
                let Some(y) = inside(x - 0.5) else { return Some(9.0 + x) };
                Some(k * y)
            }",
            "(u: [Uniform; 1], k: f64) -> Option<f64> {
                if u[0] > 0.25 {
                    let x = 2.0 * u[0];
                    if x - 0.5 > 0.25 { Some(k * 2.0 * (x - 0.5)) } else { Some(9.0 + x) }
                } else {
                    None
                }
            }",
        ),
        // What follows a `?` on a way without a value is not read.
        pair(
            "",
            "(u: [Uniform; 1]) -> Option<f64> {
                let above = |x: f64| if x > 0.5 { Some(x) } else { None };
                let y = 1.0 + (2.0 * above(u[0])?).sqrt();
                if above(u[0] - 0.25)? > 0.625 { Some(y + 1.0) } else { Some(y) }
            }",
            "(u: [Uniform; 1]) -> Option<f64> {
                if u[0] <= 0.5 { return None; }
                let y = 1.0 + (2.0 * u[0]).sqrt();
                if u[0] - 0.25 <= 0.5 { return None; }
                if u[0] - 0.25 > 0.625 { Some(y + 1.0) } else { Some(y) }
            }",
        ),
        pair(
            "",
            "(u: [Uniform; 1]) -> f64 {
                let side = if u[0] < 0.5 { Some(u[0]) } else { None };
                match side { None => 5.0 + u[0], Some(x) if x < 0.25 => 3.0 * x, Some(x) => x }
            }",
            "(u: [Uniform; 1]) -> f64 {
                if u[0] < 0.25 { 3.0 * u[0] } else if u[0] < 0.5 { u[0] } else { 5.0 + u[0] }
            }",
        ),
        pair(
            "",
            "(u: [Uniform; 1]) -> f64 {
                let side = (u[0] < 0.5).then_some(u[0]);
                if let Some(x) = side && x < 0.25 { 3.0 * x } else { u[0] + 1.0 }
            }",
            "(u: [Uniform; 1]) -> f64 { if u[0] < 0.25 { 3.0 * u[0] } else { u[0] + 1.0 } }",
        ),
    ];
    pairs.iter().for_each(compare);
}

/// A closure that captures a name which is bound again, and a value of its own that has the name of another one.
#[test]
fn closures_know_what_was_known_where_they_are() {
    compare(&pair(
        "",
        "(u: [Uniform; 1], k: f64) -> f64 {
            let a = k;
            let f = move |x: f64| { let k = x * a; k + a };
            let a = 5.0;
            f(u[0]) * a + k
        }",
        "(u: [Uniform; 1], k: f64) -> f64 { (u[0] * k + k) * 5.0 + k }",
    ));
}

/// Names that change in a body that is inverted by its names only: the visible normals of Heitz, seen at a slant.
#[test]
fn names_that_change_are_steps_of_an_inverse() {
    compare(&pair(
        "",
        "(u: [Uniform; 2]) -> Vec2 {
            const S: f64 = 0.75;
            let r = u[0].sqrt();
            let phi = TAU * u[1];
            let t1 = r * phi.cos();
            let mut t2 = r * phi.sin();
            t2 *= S;
            t2 += (1.0 - S) * (1.0 - t1 * t1).sqrt();
            Vec2::new(t1, t2)
        }",
        "(u: [Uniform; 2]) -> Vec2 {
            let r = u[0].sqrt();
            let phi = TAU * u[1];
            let t1 = r * phi.cos();
            let t2 = r * phi.sin();
            let h2 = 0.25 * (1.0 - t1 * t1).sqrt() + 0.75 * t2;
            Vec2::new(t1, h2)
        }",
    ));
}

#[test]
fn what_is_sampled_equals_no_other_number() {
    let pairs = [
        pair(
            "",
            "(u: [Uniform; 2]) -> Vec2 {
                let (a, b) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
                if a == 0.0 && b == 0.0 { return Vec2::new(0.0, 0.0); }
                let (r, t) = if a.abs() > b.abs() { (a, PI / 4.0 * (b / a)) } else { (b, PI / 2.0 - PI / 4.0 * (a / b)) };
                Vec2::new(r * t.cos(), r * t.sin())
            }",
            "(u: [Uniform; 2]) -> Vec2 {
                let (a, b) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
                let (r, t) = if a.abs() > b.abs() { (a, PI / 4.0 * (b / a)) } else { (b, PI / 2.0 - PI / 4.0 * (a / b)) };
                Vec2::new(r * t.cos(), r * t.sin())
            }",
        ),
        pair(
            "a in 0.5..=4.0",
            "(u: [Uniform; 2], a: f64) -> Vec2 { let p = Vec2::new(a * u[0], u[1]); if p != Vec2::ZERO { p } else { Vec2::X } }",
            "(u: [Uniform; 2], a: f64) -> Vec2 { Vec2::new(a * u[0], u[1]) }",
        ),
        pair(
            "",
            "(u: [Uniform; 1]) -> f64 { const N: f64 = 2.0; if N == 2.0 && 1.5 != N { 3.0 * u[0] } else { u[0] } }",
            "(u: [Uniform; 1]) -> f64 { 3.0 * u[0] }",
        ),
    ];
    pairs.iter().for_each(compare);
}
