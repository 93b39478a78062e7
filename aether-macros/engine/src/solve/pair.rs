//! Two equations for two unknowns, neither of which can be had without the other.
//!
//! f(u, v) = X and g(u, v) = Y have one solution where f increases with u, g with v, and the determinant of the
//! derivatives is positive (Gale and Nikaido, "The Jacobian matrix and global univalence of mappings", 1965). Then
//! f(u, v) = X has one root u(v), which is the nearer end where that lies beyond it, and g(u(v), v) increases with v: by the
//! determinant over ∂f/∂u, or by ∂g/∂v. So both are roots of one unknown, one within the other.

use super::numeric::end;
use super::{Equation, State};
use crate::derivative::derivative;
use crate::display::show;
use crate::expr::{Graph, Id, Leaf, Root, UNKNOWNS};
use crate::jacobian::cost;
use crate::monotone::{Unproven, direction, sign_of};
use crate::rational::Q;

/// The cost of an equation of which no proof is tried: the determinant is longer by far.
const LONG: usize = 100;

/// The state in which one of two unknowns that two equations share is known; the reason if it cannot be shown that
/// there is one solution.
pub(super) fn system(g: &mut Graph, state: &State) -> Result<State, Option<String>> {
    let mut reason = None;
    let open = |g: &Graph, e: &Equation| if e.modulo_turn { 0 } else { g.deps(e.rhs) & UNKNOWNS };
    for (i, first) in state.equations.iter().enumerate() {
        let both = open(g, first);
        if both.count_ones() != 2 || cost(g, first.rhs) > LONG {
            continue;
        }
        let low = both.trailing_zeros() as u8;
        let high = (both & (both - 1)).trailing_zeros() as u8;
        let unknowns = [low, high].map(Leaf::Unknown);
        for (j, second) in state.equations.iter().enumerate().skip(i + 1) {
            if open(g, second) != both || cost(g, second.rhs) > LONG {
                continue;
            }
            for [f, h] in [[i, j], [j, i]] {
                match nested(g, state, [f, h], unknowns) {
                    Ok(next) => return Ok(next),
                    Err(why) => {
                        reason.get_or_insert_with(|| explain(g, state, [i, j], unknowns, &why));
                    }
                }
            }
        }
    }
    Err(reason)
}

/// The state in which equation `second` gives v, with u from equation `first` at every v.
fn nested(
    g: &mut Graph,
    state: &State,
    [first, second]: [usize; 2],
    [u, v]: [Leaf; 2],
) -> Result<State, Unproven> {
    let [f, h] = [first, second].map(|i| state.equations[i].clone());
    // Each with the sign with which it increases with its own unknown.
    let signs = [direction(g, f.rhs, u)?, direction(g, h.rhs, v)?];
    let [[f_u, f_v], [h_u, h_v]] =
        [f.rhs, h.rhs].map(|side| [u, v].map(|x| derivative(g, side, x)));
    let (along, across) = (g.mul(f_u, h_v), g.mul(f_v, h_u));
    let determinant = g.sub(along, across);
    let sign = sign_of(g, determinant, u)?;
    if sign != signs[0] * signs[1] {
        let place = "the determinant of their derivatives has the other sign".to_owned();
        return Err(Unproven { place, unbounded: None });
    }
    let too_many = || Unproven { place: "an equation within an equation".into(), unbounded: None };
    let taken = g.bound_bits(f.rhs) | g.bound_bits(h.rhs);
    let bind = |g: &mut Graph, taken, leaf: Leaf| {
        let (name, range) = (g.name(leaf).to_owned(), g.leaf_range(leaf));
        g.bound_variable(taken, &name, range).ok_or_else(too_many)
    };
    let inner = bind(g, taken, u)?;
    let outer = bind(g, taken | crate::expr::leaf_bit(inner), v)?;
    let [s, t, u_id, v_id] = [inner, outer, u, v].map(|l| g.get_leaf(l));
    let body = g.substitute(f.rhs, &[(u_id, s), (v_id, t)].into());
    let u_of_v = root(g, (body, f.known, signs[0]), inner, true);
    let body = g.substitute(h.rhs, &[(u_id, u_of_v), (v_id, t)].into());
    let found = root(g, (body, h.known, signs[1]), outer, false);
    let mut s = state.clone();
    s.equations[second] = Equation { known: found, rhs: v_id, modulo_turn: false };
    s.solution.known.entry(h.rhs).or_insert(h.known);
    let text = |g: &Graph, e: &Equation| format!("{} = {}", show(g, e.known), show(g, e.rhs));
    let step = format!("{} and {} have one solution: solved numerically", text(g, &f), text(g, &h));
    s.solution.steps.push(step);
    Ok(s)
}

/// The root of an equation in a bound variable, over the range of that.
fn root(g: &mut Graph, (body, known, sign): (Id, Id, i64), variable: Leaf, inside: bool) -> Id {
    let [body, target] = [body, known].map(|id| g.sum(Q::ZERO, &[(Q::int(sign), id)]));
    let slope = derivative(g, body, variable);
    let range = g.leaf_range(variable);
    let [lo, hi] = [range.lo, range.hi].map(|x| end(g, x));
    g.root(Root { variable, body, slope, target, lo, hi, inside, folds: false })
}

fn explain(
    g: &Graph,
    state: &State,
    [i, j]: [usize; 2],
    [u, v]: [Leaf; 2],
    why: &Unproven,
) -> String {
    let way = match &why.unbounded {
        Some(p) => format!("declare a domain of `{p}` in which it is, as in `#[sampler({p} in 0.0..=10.0)]`"),
        None => "narrow the domains of the parameters, or write the map as a composition of maps that can be inverted one at a time".to_owned(),
    };
    let [first, second] = [i, j].map(|k| show(g, state.equations[k].rhs));
    format!(
        "`{first}` and `{second}` have no closed inverse, and a numerical one needs a proof that each is monotone in one of {} and {}, with a determinant of their derivatives of one sign: there is none for {}. If it is so, {way}",
        g.name(u),
        g.name(v),
        why.place
    )
}

#[cfg(test)]
mod tests {
    use crate::interpret::Item;

    fn item(domain: &str, point: &str) -> Result<Item, String> {
        let text = format!("fn bent(u: [Uniform; 2], k: f64) -> Vec2 {{ Vec2::new({point}) }}");
        Item::new(domain.parse().unwrap(), text.parse().unwrap(), true)
    }

    #[test]
    fn neither_unknown_is_had_without_the_other() {
        let domain = "k in 0.0..=0.3";
        let cubes = item(domain, "u[0] + k * u[1].powi(3), u[1] + k * u[0].powi(3)").unwrap();
        // The equations in the other order: each coordinate tells the other unknown.
        let crossed =
            item(domain, "u[1].exp() - k * u[0].cos(), u[0] + k * (TAU * u[1]).sin() / TAU");
        let crossed = crossed.unwrap();
        let tau = std::f64::consts::TAU;
        for k in [0.0, 0.1, 0.3] {
            for [u, v] in [[0.3, 0.6], [0.999, 0.99], [1e-9, 0.5], [0.5, 1e-12]] {
                let x = cubes.forward(&[k], &[u, v]).unwrap();
                let expected = 1.0 / (1.0 - 9.0 * k * k * u * u * v * v);
                let found = cubes.pdf(&[k], &x);
                assert!((found / expected - 1.0).abs() < 1e-13, "{k} {u} {v}: {found}, {expected}");
                let x = crossed.forward(&[k], &[u, v]).unwrap();
                let determinant = v.exp() - k * u.sin() * k * (tau * v).cos();
                let found = crossed.pdf(&[k], &x);
                assert!((found * determinant - 1.0).abs() < 1e-13, "{k} {u} {v}: {found}");
            }
            // Beyond an end of either unknown, and of both.
            for [x, y] in [[-1e-3, 0.5], [0.5, -1e-3], [1.0, 1.4], [1.4, 1.4], [-0.1, -0.1]] {
                assert_eq!(cubes.pdf(&[k], &[x, y]), 0.0, "{k} {x} {y}");
            }
        }
    }

    #[test]
    fn a_determinant_that_changes_its_sign_is_refused() {
        // 1 - 9 k² u² v² is zero at the corner for k = 1/3.
        for most in ["0.34", "3.0"] {
            let point = "u[0] + k * u[1].powi(3), u[1] + k * u[0].powi(3)";
            let refused = item(&format!("k in 0.0..={most}"), point);
            assert!(refused.is_err_and(|e| e.contains("cannot invert")));
        }
    }
}
