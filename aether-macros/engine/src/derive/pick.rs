//! Which of several forms of one value is taken: the most accurate, and the cheapest of those that are as accurate.

use crate::expr::{Graph, Id, Node};
use crate::jacobian::cost;
use crate::measure::{Errors, Loss, Measure, Part};
use crate::rational::Q;
use crate::stabilise::stabilise;

/// The cheapest among the most accurate expressions.
pub(super) fn pick(
    g: &mut Graph,
    candidates: &[Id],
    truth: &[f64],
    measure: &mut Measure,
) -> (Id, f64) {
    let errors: Vec<Errors> = candidates.iter().map(|&c| measure.errors(g, c, truth)).collect();
    // Points at which no form has a value say nothing of which is better.
    let told: Vec<bool> =
        (0..truth.len()).map(|k| errors.iter().any(|e| !e.is_unknown(k))).collect();
    let losses = errors.iter().map(|e| e.loss_where(&told, true));
    let mut scored: Vec<(Id, Loss, usize)> =
        candidates.iter().zip(losses).map(|(&c, loss)| (c, loss, cost(g, c))).collect();
    // What counts first is double precision; single tells those apart that are as good in it.
    for part in 0..2 {
        let least = |f: &dyn Fn(Part) -> f64| {
            scored.iter().map(|s| f(s.1.parts()[part])).fold(f64::INFINITY, f64::min)
        };
        let (bits, worst) = (least(&|l| l.bits), least(&|l| l.worst).max(16.0 * f64::EPSILON));
        let good = |l: Part| l.bits <= bits + 1.0 && l.worst <= 4.0 * worst;
        if scored.iter().any(|s| good(s.1.parts()[part])) {
            scored.retain(|s| good(s.1.parts()[part]));
        }
    }
    // Of those that cost the same, one that multiplies by fewer numbers.
    let least = scored.iter().map(|s| s.2).min();
    scored.retain(|s| Some(s.2) == least);
    let best = scored.iter().min_by_key(|s| coefficients(g, s.0));
    best.map_or((candidates[0], f64::INFINITY), |s| (s.0, s.1.worst()))
}

/// How many terms of sums are multiplied by a number.
fn coefficients(g: &Graph, id: Id) -> usize {
    let multiplied = |id: Id| match g.node(id) {
        Node::Sum(_, terms) => terms.iter().filter(|(q, _)| q.abs() != Q::ONE).count(),
        _ => 0,
    };
    g.within(&[id]).into_iter().map(multiplied).sum()
}

/// Coordinates one by one in their most accurate form: as written, tidied or stabilised.
pub(super) fn accurate(
    g: &mut Graph,
    written: &[Id],
    tidied: &[Id],
    measure: &mut Measure,
) -> Vec<Id> {
    let mut best = |(&written, &tidied): (&Id, &Id)| {
        let truth = measure.truths(g, written);
        let forms = [written, tidied, stabilise(g, tidied, measure)];
        pick(g, &forms, &truth, measure).0
    };
    written.iter().zip(tidied).map(&mut best).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::{Fun, Leaf};
    use crate::interval::Interval;
    use crate::measure::Inputs;

    #[test]
    fn points_that_no_form_tells_do_not_hide_which_is_accurate() {
        let mut g = Graph::new();
        let x = g.leaf(Leaf::Out(0), "x", Interval::new(0.0, 1.0));
        let one = g.int(1);
        let more = g.add(one, x);
        // ln(1 + x) / x, and the same without cancellation: both are 0/0 at zero.
        let [short, accurate] = [(Fun::Ln, more), (Fun::Ln1p, x)].map(|(f, argument)| {
            let log = g.call(f, &[argument]);
            g.div(log, x)
        });
        let points: Vec<Inputs> =
            [0.0, 1e-12].map(|x| Inputs::from_iter([(Leaf::Out(0), x)])).to_vec();
        let mut measure = Measure::new(points, vec![]);
        let picked = pick(&mut g, &[short, accurate], &[1.0, 1.0 - 5e-13], &mut measure);
        assert_eq!(picked.0, accurate);
    }
}
