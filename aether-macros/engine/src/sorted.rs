//! Short lists in order.
//!
//! The sorts of the standard library are made for long lists, and each kind of list brings ten thousand bytes of its own;
//! the lists of this crate are short, and many kinds. Maps that are collected sort as well.

use std::cmp::Ordering;
use std::collections::BTreeMap;

/// Sorts by a comparison; what is equal keeps its order.
pub fn sort_by<T>(list: &mut [T], order: impl Fn(&T, &T) -> Ordering) {
    for end in 1..list.len() {
        let place = list[..end].partition_point(|x| order(x, &list[end]).is_le());
        let mut k = end;
        while k > place {
            list.swap(k - 1, k);
            k -= 1;
        }
    }
}

/// Sorts; what is equal keeps its order.
pub fn sort<T: Ord>(list: &mut [T]) {
    sort_by(list, T::cmp);
}

/// Sorts by a key, which is found several times for each element; what has equal keys keeps its order.
pub fn sort_by_key<T, K: Ord>(list: &mut [T], key: impl Fn(&T) -> K) {
    sort_by(list, |x, y| key(x).cmp(&key(y)));
}

/// The map of some keys and values, of which the last ones count.
pub fn map<K: Ord, V>(entries: impl IntoIterator<Item = (K, V)>) -> BTreeMap<K, V> {
    let mut map = BTreeMap::new();
    map.extend(entries);
    map
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_equal_keeps_its_order() {
        let numbers: Vec<u32> = (0..200).map(|k| k * 7919 % 61).collect();
        let mut found: Vec<(usize, u32)> = numbers.iter().copied().enumerate().collect();
        let mut expected = found.clone();
        sort_by_key(&mut found, |(_, n)| *n);
        expected.sort_by_key(|(_, n)| *n);
        assert_eq!(found, expected);
        let mut found = numbers.clone();
        sort(&mut found);
        assert!(found.is_sorted());
        let pairs = || numbers.iter().copied().zip(0..);
        assert_eq!(map::<_, u32>(pairs()), pairs().collect());
    }
}
