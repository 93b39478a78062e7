//! Something else than the item itself, at points next to all ends.

use super::judge::{Judge, Origin};
use super::measure::{Row, next_to_all_ends};
use super::probe::{Answer, Question};
use crate::registry::Item;

/// What is found in `f64` of what each of several answers, with parameters of an item, where that is tried: at uniforms up
/// to the last bit before their ends and with parameters over their declared domains.
pub fn beside<const N: usize>(
    item: &Item,
    answers: impl Fn(&[f64], &Question) -> [Option<Answer>; N],
) -> [Row; N] {
    let mut rows: [Row; N] = core::array::from_fn(|_| Row::default());
    next_to_all_ends::<f64>(item, true, &mut vec![], |numbers, u| {
        let judge = Judge::at::<f64>(item, numbers, u, Origin::Swept, false);
        let question = judge.question::<f64>();
        for (row, found) in rows.iter_mut().zip(answers(numbers, &question)) {
            if let Some(found) = found {
                judge.enter::<f64>(row, &found, &question.x.unwrap_or_default());
            }
        }
    });
    rows
}
