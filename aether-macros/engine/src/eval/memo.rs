//! Values by expression.

use crate::expr::Id;

/// What has been evaluated: a table in which the place of an expression is the first free one from its number on.
///
/// The maps of the standard library take ten times as long where the compiler runs unoptimised, and evaluating an
/// expression at a point does little else.
pub struct Memo<T> {
    /// Numbers of entries, plus one; zero where there is none. Twice as many as entries at least, and a power of two.
    places: Vec<u32>,
    ids: Vec<Id>,
    values: Vec<T>,
}

/// Places of a new table.
const PLACES: usize = 64;

impl<T: Copy> Memo<T> {
    /// An empty one.
    pub fn new() -> Self {
        Memo { places: vec![0; PLACES], ids: Vec::new(), values: Vec::new() }
    }

    /// What is known of an expression.
    pub fn get(&self, id: Id) -> Option<T> {
        match self.places[self.place(id)] {
            0 => None,
            entry => Some(self.values[entry as usize - 1]),
        }
    }

    /// Adds what was not known.
    pub fn insert(&mut self, id: Id, value: T) {
        self.ids.push(id);
        self.values.push(value);
        if 2 * self.ids.len() <= self.places.len() {
            let place = self.place(id);
            self.places[place] = self.ids.len() as u32;
            return;
        }
        self.places = vec![0; 2 * self.places.len()];
        let mut k = 0;
        while k < self.ids.len() {
            let place = self.place(self.ids[k]);
            k += 1;
            self.places[place] = k as u32;
        }
    }

    /// Where an expression is or would be.
    #[inline(always)]
    fn place(&self, id: Id) -> usize {
        let mask = self.places.len() - 1;
        // Numbers that follow one another are often asked for together, and spread well enough.
        let mut place = id.0 as usize & mask;
        while self.places[place] != 0 && self.ids[self.places[place] as usize - 1].0 != id.0 {
            place = (place + 1) & mask;
        }
        place
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_put_in_is_found_again_and_nothing_else() {
        let mut memo = Memo::new();
        // Many that begin at the same place.
        let numbers: Vec<u32> = (0..300).map(|i| 64 * (i % 7) + i / 7).collect();
        for n in &numbers {
            assert_eq!(memo.get(Id(*n)), None);
            memo.insert(Id(*n), f64::from(*n));
        }
        for n in 0..1000 {
            let expected = numbers.contains(&n).then(|| f64::from(n));
            assert_eq!(memo.get(Id(n)), expected, "{n}");
        }
    }
}
