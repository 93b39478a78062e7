//! Something else than the item itself, at points next to all ends.

use super::few::Few;
use super::judge::{Judge, Origin};
use super::measure::{Row, sets};
use super::oracle::{Format, exact};
use super::places::{next_to_ends, swept};
use super::probe::{Answer, Question, dimensions, legal};
use crate::precise::Precise;
use crate::registry::Item;

/// What is found in `f64` of what `answer` says, with parameters of an item, where that is tried: at uniforms up to the last bit
/// before their ends and with parameters over their declared domains.
pub fn beside(item: &Item, answer: impl Fn(&[f64], &Question) -> Option<Answer>) -> Row {
    let mut row = Row { name: item.name.to_owned(), precision: "f64", ..Row::default() };
    let tried = sets::<f64>(item, &mut row.dropped);
    let Some(dimensions) = tried.first().and_then(|set| dimensions::<f64>(item, set)) else {
        return row;
    };
    let is_legal = |set: &Vec<f64>| legal::<f64>(item, set, &mut vec![]);
    let swept: Vec<_> = swept(item).into_iter().filter(is_legal).collect();
    for (sets, dense) in [(tried, true), (swept, false)] {
        for (numbers, u) in sets.iter().flat_map(|set| {
            next_to_ends::<f64>(dimensions, dense).into_iter().map(move |u| (set, u))
        }) {
            let precise: Vec<Precise> = u.iter().map(|u| Precise::f64(*u)).collect();
            let exact = exact(item, numbers, &precise);
            let x = Judge::rounded::<f64>(&exact);
            let question = Question { u: Few::new(&u), x: Some(x) };
            let (format, origin) = (Format::of::<f64>(), Origin::Swept);
            let judge = Judge { item, numbers, u: &u, exact, format, origin, by_hand: false };
            if let Some(found) = answer(numbers, &question) {
                judge.enter::<f64>(&mut row, &found, &x);
            }
        }
    }
    row
}
