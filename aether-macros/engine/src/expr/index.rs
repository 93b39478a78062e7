//! Finding the id of a node, the most frequent of all things that the compiler does.
//!
//! The compiler runs unoptimised in most builds, where the hash map of the standard library is a hundred small
//! functions: this is a table with open addressing that compares hashes before nodes.

use super::{Id, Leaf, Node};
use crate::hash::mixed;
use crate::rational::Q;

/// The ids of nodes, which somebody else keeps.
#[derive(Clone, Default)]
pub(super) struct Index {
    /// The hash of each node.
    hashes: Vec<u64>,
    /// Numbers of nodes, one more than they are, at the places that the hashes give; zero where there is none. Twice
    /// as many as nodes at least, and a power of two.
    places: Vec<u32>,
}

impl Index {
    /// The id of a node among `nodes`, or the hash to enter it by.
    pub(super) fn find(&self, nodes: &[Node], node: &Node) -> Result<Id, u64> {
        let hash = hash(node);
        if self.places.is_empty() {
            return Err(hash);
        }
        let mask = self.places.len() - 1;
        let mut at = place(hash) & mask;
        loop {
            let entry = self.places[at];
            if entry == 0 {
                return Err(hash);
            }
            let number = entry as usize - 1;
            if self.hashes[number] == hash && nodes[number] == *node {
                return Ok(Id(entry - 1));
            }
            at = (at + 1) & mask;
        }
    }

    /// Enters the next node by its hash, and tells its id.
    pub(super) fn enter(&mut self, hash: u64) -> Id {
        let number = self.hashes.len() as u32;
        self.hashes.push(hash);
        if self.places.len() < 2 * self.hashes.len() {
            self.places = vec![0; (2 * self.places.len()).max(256)];
            for number in 0..=number {
                self.put(number);
            }
        } else {
            self.put(number);
        }
        Id(number)
    }

    fn put(&mut self, number: u32) {
        let mask = self.places.len() - 1;
        let mut at = place(self.hashes[number as usize]) & mask;
        while self.places[at] != 0 {
            at = (at + 1) & mask;
        }
        self.places[at] = number + 1;
    }
}

/// Where to begin; multiplication leaves its best bits at the top.
fn place(hash: u64) -> usize {
    (hash >> 32) as usize
}

fn hash(node: &Node) -> u64 {
    match node {
        Node::Number(q) => of_number(1, q),
        Node::Float(bits) => mixed(2, *bits),
        Node::Pi => 3,
        Node::Leaf(leaf) => of_leaf(4, *leaf),
        Node::Sum(c, terms) => {
            let mut h = of_number(5, c);
            for (q, t) in terms {
                h = mixed(of_number(h, q), u64::from(t.0));
            }
            h
        }
        Node::Product(factors) => {
            let mut h = 6;
            for (b, e) in factors {
                h = mixed(h, u64::from(b.0) << 32 | u64::from(e.0));
            }
            h
        }
        Node::Call(f, args) => {
            let mut h = mixed(7, *f as u64);
            for a in args {
                h = mixed(h, u64::from(a.0));
            }
            h
        }
        Node::If(test, yes, no) => of_ids(8, [*test, *yes, *no]),
        Node::Root(r) => of_ids(of_leaf(9, r.variable), [r.body, r.target, r.lo]),
    }
}

fn of_number(h: u64, q: &Q) -> u64 {
    // Numerators and denominators are short.
    mixed(mixed(h, q.num() as u64), q.den() as u64)
}

fn of_leaf(h: u64, leaf: Leaf) -> u64 {
    let (kind, number) = match leaf {
        Leaf::Unknown(i) => (0, i),
        Leaf::Out(i) => (1, i),
        Leaf::Param(i) => (2, i),
        Leaf::Bound(i) => (3, i),
    };
    mixed(h, kind << 8 | u64::from(number))
}

fn of_ids(h: u64, ids: [Id; 3]) -> u64 {
    let mut h = h;
    for id in ids {
        h = mixed(h, u64::from(id.0));
    }
    h
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_node_is_found_and_no_other() {
        let nodes: Vec<Node> = (0..2000)
            .map(|k| match k % 4 {
                0 => Node::Number(Q::int(k)),
                1 => Node::Product(vec![(Id(k as u32), Id(0)), (Id(1), Id(k as u32))]),
                2 => Node::Sum(Q::HALF, vec![(Q::int(k), Id(3))]),
                _ => Node::Call(crate::expr::Fun::Sin, vec![Id(k as u32)]),
            })
            .collect();
        let mut index = Index::default();
        for (k, node) in nodes.iter().enumerate() {
            let hash = index.find(&nodes, node).expect_err("not there yet");
            assert_eq!(index.enter(hash), Id(k as u32));
        }
        for (k, node) in nodes.iter().enumerate() {
            assert_eq!(index.find(&nodes, node), Ok(Id(k as u32)));
        }
        assert!(index.find(&nodes, &Node::Pi).is_err());
    }
}
