//! Maps that every renderer has, inverted.

use super::*;
use crate::interval::Interval;
use crate::jacobian::{Source, volume};
use crate::rational::Q;

struct Setup {
    g: Graph,
    u: Vec<Id>,
}

fn setup(n: u8) -> Setup {
    let mut g = Graph::new();
    let u = (0..n)
        .map(|i| g.leaf(Leaf::Unknown(i), &format!("u{i}"), Interval::new(0.0, 1.0)))
        .collect();
    Setup { g, u }
}

fn outs(g: &mut Graph, n: u8, unit: bool) -> Vec<Id> {
    let range = if unit { Interval::new(-1.0, 1.0) } else { Interval::ALL };
    (0..n).map(|i| g.leaf(Leaf::Out(i), ["x", "y", "z"][i as usize], range)).collect()
}

fn report(s: &mut Setup, f: &[Id], unit: bool) -> (String, String) {
    let targets = outs(&mut s.g, f.len() as u8, unit);
    let leaves: Vec<Leaf> = (0..s.u.len() as u8).map(Leaf::Unknown).collect();
    let solutions =
        solve(&mut s.g, &System::new(&targets, f), &leaves, &[], &[], Numerical::No).unwrap();
    let inverse: Vec<String> = solutions
        .iter()
        .map(|x| x.unknowns.values().map(|v| show(&s.g, *v)).collect::<Vec<_>>().join("; "))
        .collect();
    let v = volume(&mut s.g, f, &leaves, (Source::Free, false), &[]).unwrap();
    let best = *v.iter().min_by_key(|v| crate::jacobian::cost(&s.g, **v)).unwrap();
    let p = s.g.powi(best, -1);
    let p = s.g.substitute(p, &solutions[0].known);
    (inverse.join(" | "), show(&s.g, p))
}

fn spherical(g: &mut Graph, c: Id, v: Id) -> Vec<Id> {
    let one = g.int(1);
    let c2 = g.powi(c, 2);
    let s2 = g.sub(one, c2);
    let r = g.sqrt(s2);
    let pi = g.pi();
    let two = g.int(2);
    let tau = g.mul(two, pi);
    let phi = g.mul(tau, v);
    let cos = g.call(crate::expr::Fun::Cos, &[phi]);
    let sin = g.call(crate::expr::Fun::Sin, &[phi]);
    vec![g.mul(r, cos), g.mul(r, sin), c]
}

#[test]
fn cosine_hemisphere() {
    let mut s = setup(2);
    let one = s.g.int(1);
    let q = s.g.sub(one, s.u[0]);
    let c = s.g.sqrt(q);
    let f = spherical(&mut s.g, c, s.u[1]);
    let (inverse, p) = report(&mut s, &f, true);
    assert_eq!(p, "z / π");
    assert_eq!(inverse, "x² + y²; turn(atan2(y, x)) / (2 π)");
}

#[test]
fn uniform_sphere() {
    let mut s = setup(2);
    let c = s.g.sum(Q::ONE, &[(Q::int(-2), s.u[0])]);
    let f = spherical(&mut s.g, c, s.u[1]);
    let (inverse, p) = report(&mut s, &f, true);
    assert_eq!(p, "1 / (4 π)");
    assert_eq!(inverse, "1/2 - z / 2; turn(atan2(y, x)) / (2 π)");
}

#[test]
fn linear_density() {
    // u(a+b)/(a+√((1-u)a²+u b²))
    let mut s = setup(1);
    let a = s.g.leaf(Leaf::Param(0), "a", Interval::POSITIVE);
    let b = s.g.leaf(Leaf::Param(1), "b", Interval::POSITIVE);
    let one = s.g.int(1);
    let q = s.g.sub(one, s.u[0]);
    let (a2, b2) = (s.g.powi(a, 2), s.g.powi(b, 2));
    let l = s.g.mul(q, a2);
    let r = s.g.mul(s.u[0], b2);
    let sum = s.g.add(l, r);
    let root = s.g.sqrt(sum);
    let bottom = s.g.add(a, root);
    let ab = s.g.add(a, b);
    let top = s.g.mul(s.u[0], ab);
    let f = s.g.div(top, bottom);
    let (inverse, p) = report(&mut s, &[f], false);
    eprintln!("{inverse}\n{p}");
    assert!(!inverse.contains('√'), "{inverse}");
}

#[test]
fn triangle() {
    let mut s = setup(2);
    let r = s.g.sqrt(s.u[0]);
    let one = s.g.int(1);
    let v1 = s.g.sub(one, s.u[1]);
    let p = s.g.mul(r, v1);
    let q = s.g.mul(r, s.u[1]);
    let f: Vec<Id> = (0..3u8)
        .map(|i| {
            let mut leaf = |k: u8, n: &str| {
                s.g.leaf(Leaf::Param(3 * k + i), &format!("{n}{i}"), Interval::ALL)
            };
            let (a, b, c) = (leaf(0, "a"), leaf(1, "b"), leaf(2, "c"));
            let e1 = s.g.sub(b, a);
            let e2 = s.g.sub(c, a);
            let x = s.g.mul(p, e1);
            let y = s.g.mul(q, e2);
            s.g.sum(Q::ZERO, &[(Q::ONE, a), (Q::ONE, x), (Q::ONE, y)])
        })
        .collect();
    let (_, p) = report(&mut s, &f, false);
    assert!(!p.contains('x') && !p.contains('z'), "the density is constant: {p}");
}

#[test]
fn angles_are_seen_to_stay_within_a_turn_over_declared_domains_alone() {
    let item = |domain: &str, (from, to): (&str, &str), start: &str| {
        let text = format!(
            "fn f(u: [Uniform; 2], s: f64) -> Vec2 {{
                let r = u[0].sqrt();
                let (a, b) = (1.0 / (1.0 + (-{from} / s).exp()), 1.0 / (1.0 + (-{to} / s).exp()));
                let phi = {start} - s * (1.0 / (u[1] * (b - a) + a) - 1.0).ln();
                Vec2::new(r * phi.cos(), r * phi.sin())
            }}"
        );
        crate::interpret::Item::new(domain.parse().unwrap(), text.parse().unwrap(), true)
    };
    let declared = "s in 0.1..=2.0";
    for (ends, start) in [(("-PI", "PI"), "0.0"), (("-PI", "PI"), "9.0"), (("-1.0", "4.0"), "2.0")]
    {
        let item = item(declared, ends, start).unwrap_or_else(|e| panic!("{ends:?} {start}: {e}"));
        for u in [[0.3, 0.1], [0.5, 0.9]] {
            let x = item.forward(&[0.5], &u).unwrap();
            let back = item.preimages(&[0.5], &x);
            assert!(back.len() == 1 && (back[0][1] - u[1]).abs() < 1e-9, "{u:?} {back:?}");
        }
    }
    // More than a turn; and moderate values of what is not declared tell nothing of others.
    assert!(item(declared, ("-4.0", "4.0"), "0.0").is_err());
    assert!(item("s in 0.1..", ("-PI", "PI"), "0.0").is_err());
    assert!(item("", ("-PI", "PI"), "0.0").is_err());
}
