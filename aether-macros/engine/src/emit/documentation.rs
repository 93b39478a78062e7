//! The derivation as a block of the item's documentation.

use proc_macro2::TokenStream;
use quote::quote;

use crate::derive::{Accuracy, Atom, Derived, Problem, in_words, texts};
use crate::display::show;
use crate::expr::Id;
use crate::parse::{Piece, Signature, Source};

/// The texts that are shown and kept with an item.
pub struct Texts {
    /// The map.
    pub forward: String,
    /// Its inverse.
    pub inverse: String,
    /// √det(JᵀJ).
    pub jacobian: String,
    /// The density.
    pub pdf: String,
    /// Which direction has no closed form, if one has none.
    pub numerical: Option<String>,
    /// Each way to an atom: where it lies, and with which probability it leads there.
    pub atoms: Vec<String>,
}

impl Texts {
    /// The texts of a derivation.
    pub fn new(pieces: &mut [Piece], derived: &[Derived], atoms: &[Atom]) -> Texts {
        let [forward, inverse, jacobian, pdf] = texts(pieces, derived);
        let numerical = pieces.iter().zip(derived).find_map(|(p, d)| numerical(&p.problem, d));
        let atoms = atoms.iter().map(atom).collect();
        Texts { forward, inverse, jacobian, pdf, numerical, atoms }
    }

    /// `#[doc]` attributes with the derivation, its measure, what was checked, and whether the inverse
    /// is a formula.
    pub fn attributes(
        &self,
        signature: &Signature,
        derived: &[Derived],
        sampler: bool,
    ) -> TokenStream {
        let mut lines =
            vec![String::new(), "# Derived".to_owned(), String::new(), "```text".to_owned()];
        let mut listed = |first: &str, text: &str| {
            for (i, line) in text.lines().enumerate() {
                lines.push(format!("{} {line}", if i == 0 { first } else { "or      " }));
            }
        };
        listed("map     ", &self.forward);
        listed("inverse ", &self.inverse);
        listed("√det JᵀJ", &self.jacobian);
        if sampler {
            lines.push(format!("pdf      {}", self.pdf));
            lines.extend(self.atoms.iter().cloned());
        }
        lines.push(format!("measure  {}", measures(signature)));
        lines.push("```".to_owned());
        lines.extend(self.numerical.clone());
        lines.push(checked(derived, sampler));
        lines.push(self.preimages(derived, sampler));
        lines.iter().map(|l| quote!(#[doc = #l])).collect()
    }

    /// How many preimages there are, and of what kind.
    pub fn preimages(&self, derived: &[Derived], sampler: bool) -> String {
        let form = if self.numerical.is_none() { " in closed form" } else { "" };
        match derived.iter().map(|d| d.preimages.len()).sum::<usize>() {
            1 => format!("Every point has one preimage{form}."),
            n if sampler => {
                format!("A point has up to {n} preimages{form}, whose densities add up.")
            }
            n => format!("A point has up to {n} preimages{form}."),
        }
    }
}

/// `atom 0   (wall) with probability exp(-wall)`.
fn atom(atom: &Atom) -> String {
    let coordinates: Vec<String> =
        atom.way.place.iter().map(|&c| show(&atom.way.graph, c)).collect();
    format!(
        "atom {:<3} ({}) with probability {}{}",
        atom.way.number,
        coordinates.join(", "),
        show(&atom.graph, atom.probability),
        in_words(&atom.way.graph, &atom.open, "where")
    )
}

/// The measure of a sampler's density, or of both sides of a map.
pub(super) fn measures(signature: &Signature) -> String {
    let target = signature.space.measure();
    if signature.mixed {
        return format!("{target}, and counting measure on the atoms");
    }
    match &signature.source {
        Source::Uniforms { .. } => target.to_owned(),
        Source::Point { space, .. } => format!("{} to {target}", space.measure()),
    }
}

/// What was checked, and the worst error that was seen.
fn checked(derived: &[Derived], sampler: bool) -> String {
    let what = if sampler { "density" } else { "Jacobian" };
    let worst = accuracy(derived).density;
    format!(
        "Checked while compiling against differences of the map itself; worst relative error of the {what} in `f64` on the points tried: {worst}."
    )
}

/// The largest errors over all pieces.
pub(super) fn accuracy(derived: &[Derived]) -> Accuracy {
    derived.iter().fold(Accuracy::default(), |all, d| all.or(&d.accuracy))
}

/// Says so if the map or its inverse is found by solving an equation numerically.
fn numerical(problem: &Problem, derived: &Derived) -> Option<String> {
    let any = |ids: &[Id]| ids.iter().any(|id| problem.graph.is_numerical(*id));
    let forward = any(&problem.outputs);
    let inverse = derived.preimages.iter().any(|p| any(&p.tested));
    let what = match (forward, inverse) {
        (false, false) => return None,
        (true, false) => "The map has no closed form and is computed",
        (false, true) => "The inverse has no closed form and is computed",
        (true, true) => "The map and its inverse have no closed form and are computed",
    };
    let monotone = match derived.pieces {
        0 => "monotone".to_owned(),
        n => format!("monotone on each of {n} pieces between its turning points"),
    };
    Some(format!(
        "{what} numerically: the equation is proven to be {monotone}, and `root` is its solution, by Newton's method in a bracket, to full precision. The density is that of the implicit function.\n"
    ))
}
