//! From a Rust function to expressions.

mod assign;
mod attribute;
mod bindings;
mod body;
mod bounded;
mod branch;
mod calls;
mod compare;
mod defined;
mod expression;
mod functions;
mod macros;
mod made;
mod methods;
mod mixed;
mod operators;
mod order;
mod param;
mod parameters;
mod patterns;
mod pieces;
mod plain;
mod point;
mod proven;
mod rebound;
mod repeat;
mod rounding;
mod shared;
mod signature;
mod solve;
mod space;
mod special;
mod stages;
mod steps;
mod value;
mod vanishing;
mod vectors;
mod way;
mod whole;

pub use attribute::{Domain, Options, Relation};
pub use body::Body;
pub use calls::Callable;
pub use made::{Constant, Constants, Made, has_one_end};
pub use mixed::{AtomWay, Mark};
pub(crate) use order::assume_nonnegative;
pub use param::{Param, ParamKind};
pub use pieces::{Segment, Test};
pub use plain::plain;
pub use rebound::bound_once;
pub use shared::shared;
pub use signature::{Signature, Source, signature, type_name};
pub use space::Space;
pub use special::{is_number, is_of_the_language};
use stages::Cut;
pub use stages::{Stage, stages};
pub use value::Value;
use vanishing::vanishing;

use std::collections::HashMap;

use proc_macro2::TokenStream;
use syn::ItemFn;

use crate::derive::{Part, Problem};
use crate::diagnostics::Diagnostics;
use crate::expr::{Deps, Graph, Id, Leaf, UNKNOWNS};
use crate::interval::Interval;
use crate::points::Kind;

/// A parsed item: its signature, and the equations of its body.
pub struct Parsed {
    /// Name, parameters, spaces.
    pub signature: Signature,
    /// The map, a piece for each way through its branches that leads to a point.
    pub pieces: Vec<Piece>,
    /// The ways that end in atoms.
    pub atoms: Vec<AtomWay>,
    /// Whether every way leads to a point that has a density.
    pub total: bool,
    /// The identity expressions of the result's points on surfaces.
    pub identities: Vec<TokenStream>,
    /// What is computed once from the parameters by plain Rust code.
    pub constants: Constants,
    /// Whether that is all that the body makes of parameters alone.
    pub making: bool,
}

impl Parsed {
    /// For each way that leads through where a parameter vanishes, the others that vanish there.
    pub fn vanishing_with(&self, parameter: u8) -> impl Iterator<Item = Vec<u8>> {
        let number = |leaf: &Leaf| match leaf {
            Leaf::Param(i) => Some(*i),
            _ => None,
        };
        self.pieces.iter().filter_map(move |piece| {
            let all: Vec<u8> = piece.problem.vanishing.iter().filter_map(number).collect();
            all.contains(&parameter).then(|| all.into_iter().filter(|i| *i != parameter).collect())
        })
    }
}

/// One way through the branches of a body.
pub struct Piece {
    /// The map on a unit cube, to be inverted.
    pub problem: Problem,
    /// The expressions of the tests below.
    pub graph: Graph,
    /// Which uniforms (or points) take this way.
    pub tests: Vec<Test>,
    /// The way, and the segments of the uniforms in terms of these expressions.
    way: way::Way,
    ends: Vec<Option<Segment>>,
}

impl Piece {
    /// All that it is made of.
    fn used(&self) -> Deps {
        let Problem { graph, outputs, requirements, guards, existence, segments, .. } =
            &self.problem;
        let tests = guards.iter().chain(existence).map(|test| test.difference);
        let ends = segments.iter().flatten().flat_map(|s| [s.low, s.width]);
        let all = outputs.iter().chain(requirements).copied().chain(tests).chain(ends);
        let own = self.tests.iter().map(|test| self.graph.deps(test.difference));
        all.map(|id| graph.deps(id)).chain(own).fold(0, |all, deps| all | deps)
    }
}

/// What reading a body once has found.
struct Reading {
    graph: Graph,
    way: way::Way,
    unknowns: Vec<Leaf>,
    argument: Option<Kind>,
    kinds: Vec<Kind>,
    frames: Vec<[[Id; 3]; 3]>,
    requirements: Vec<Id>,
    constants: Constants,
    /// Coordinates and identities; `None` where the body yields no sample.
    point: Option<(Vec<Id>, Vec<TokenStream>)>,
    /// The number of the atom that the point is, and this as written.
    atom: Option<(usize, TokenStream)>,
    segments: Vec<Option<Segment>>,
    relations: Vec<Test>,
    /// Numbers with a name that depend on the first parameter.
    scalars: Vec<String>,
    /// Vectors with a name that depend on parameters alone.
    vectors: Vec<(String, [Id; 3])>,
    /// Unknowns in the place of numbers, and what these stand for.
    cuts: Vec<(Leaf, Id)>,
    /// Parameters in the place of coordinates of vectors, and what these stand for.
    constants_cut: Vec<(Leaf, Id)>,
}

/// Parses the body of a sampler or a map. With `making`, all that it makes of parameters alone is read as parameters of
/// their own. `None` if there were errors.
pub fn parse(
    item: &ItemFn,
    signature: Signature,
    options: &Options,
    making: bool,
    errors: &mut Diagnostics,
) -> Option<Parsed> {
    let mut reader = Reader { item, signature: &signature, options, making, errors };
    let (mut pieces, mut atoms, mut total) = (Vec::new(), Vec::new(), true);
    let mut identities = Vec::new();
    let mut constants = Constants::default();
    let mut next = Some(way::Way::default());
    while let Some(way) = next {
        if pieces.len() + atoms.len() == way::MAX_PIECES {
            errors.error(
                &item.sig.ident,
                format!("the branches of this body multiply to more than {} cases: split it, and choose between the parts in a `#[strategy]`", way::MAX_PIECES),
            );
            return None;
        }
        let first = reader.read(Graph::new(), (way, &[]), Cut::default())?;
        next = first.way.clone().next();
        if let Some((number, tokens)) = first.atom.clone() {
            total = false;
            let parts = signature.space.parts().iter().map(Part::of).collect();
            atoms.push(first.into_atom(number, tokens, parts));
        } else if let Some((_, surfaces)) = &first.point {
            identities.clone_from(surfaces);
            constants.clone_from(&first.constants);
            pieces.extend(reader.piece(first)?);
        } else {
            total = false;
        }
    }
    for d in &options.of_names {
        let is_known =
            |c: &&made::Constant| c.domain.as_ref().is_some_and(|own| own.name == d.name);
        if constants.all.iter().find(is_known).is_none() {
            errors.error(&d.name, format!("`{}` is no number that parameters alone make, in a `let` of the body itself, and a domain is declared of nothing else", d.name));
        }
    }
    constants.keep(
        pieces.iter().map(Piece::used).chain(atoms.iter().map(AtomWay::used)).fold(0, |a, b| a | b),
    );
    if pieces.is_empty() {
        let message = match atoms[..] {
            [] => "no way through this body leads to a point",
            _ => {
                "every way through this body ends in an atom, so that there is no density to derive: for a choice among points use `discrete`, or a `#[strategy]`"
            }
        };
        errors.error(&item.sig.ident, message);
        return None;
    }
    Some(Parsed { signature, pieces, atoms, total, identities, constants, making })
}

struct Reader<'a> {
    item: &'a ItemFn,
    signature: &'a Signature,
    options: &'a Options,
    making: bool,
    errors: &'a mut Diagnostics,
}

impl Reader<'_> {
    /// A way through the body as a map on the unit cube. `Some(None)` if it has no volume.
    fn piece(&mut self, mut first: Reading) -> Option<Option<Piece>> {
        let (segments, implied) = if first.argument.is_none() {
            pieces::segments(&mut first.graph, &first.way.tests, &first.unknowns)
        } else {
            (vec![], vec![])
        };
        let empty = |s: &Segment| first.graph.range(s.width).hi <= 0.0;
        if segments.iter().flatten().any(empty) {
            return Some(None);
        }
        let mut rare = Vec::new();
        if let Some(leaves) = vanishing(&mut first) {
            first.way.vanishing = leaves;
            let zeros = first.way.zeros.iter();
            rare.extend(zeros.map(|&difference| Test { difference, strict: false }));
        }
        let cut = segments.iter().any(Option::is_some);
        let ends_of_segments = implied.clone();
        let second = if cut {
            let ends: Vec<Option<(Segment, &Graph)>> =
                segments.iter().map(|s| s.map(|s| (s, &first.graph))).collect();
            self.read(Graph::new(), (first.way.again(implied), &ends), Cut::default())?
        } else {
            self.read(Graph::new(), (first.way.again(vec![]), &[]), Cut::default())?
        };
        if second.way.impossible {
            return Some(None);
        }
        // What the segments settle need not be tested, and might be denied by a rounding.
        let is_rare = !rare.is_empty();
        let open = |place: &usize| {
            is_rare
                || ends_of_segments.contains(place)
                || second.way.tests.iter().any(|(p, _)| p == place)
        };
        // Of parameters alone no rounded point tells anything: forwards and backwards the same numbers are compared. A map
        // has no uniforms to be left without.
        let is_sampler = second.argument.is_none();
        let (mut guards, settled): (Vec<Test>, Vec<Test>) = second
            .way
            .tests
            .iter()
            .map(|(_, test)| *test)
            .partition(|test| !is_sampler || second.graph.has(test.difference, UNKNOWNS));
        let mut existence = [second.way.existence.clone(), settled].concat();
        let way = second.way.again(vec![]);
        let mut graph = second.graph;
        let rare = rare.into_iter().map(|test: Test| {
            let difference = graph.import(&first.graph, test.difference);
            Test { difference, ..test }
        });
        if is_sampler {
            existence.extend(rare)
        } else {
            guards.extend(rare)
        }
        let tests = first.way.tests.iter().filter(|(p, _)| open(p)).map(|(_, t)| *t).collect();
        let outputs = second.point.map_or(vec![], |p| p.0);
        let parts = self.signature.space.parts().iter().map(Part::of).collect();
        let problem = Problem {
            graph,
            outputs,
            unknowns: second.unknowns,
            argument: second.argument,
            kinds: second.kinds,
            made: second.constants.made(),
            frames: second.frames,
            parts,
            requirements: second.requirements,
            guards,
            segments: second.segments,
            existence,
            vanishing: way.vanishing.clone(),
            lengths: Vec::new(),
            stages: Vec::new(),
            relations: second.relations,
            stuck: false,
        };
        Some(Some(Piece { problem, graph: first.graph, tests, way, ends: segments }))
    }

    /// Reads the body into a graph on one way, with uniforms confined to segments and some named numbers as unknowns
    /// of their own ([`Body::cut`]).
    fn read(
        &mut self,
        mut graph: Graph,
        (way, segments): (way::Way, &[Option<(Segment, &Graph)>]),
        cut: Cut,
    ) -> Option<Reading> {
        // What the item before has used up is no concern of this one.
        crate::poly::start_budget();
        let mut names: HashMap<String, Value> = HashMap::new();
        let (unknowns, argument) = declare_source(&mut graph, &mut names, &self.signature.source);
        let mut body = Body::new(graph, names, way, self.errors);
        body.own_name = self.signature.name.to_string();
        body.cut = cut;
        body.making.on = self.making;
        body.of_names.clone_from(&self.options.of_names);
        let (mut kinds, mut frames) = (Vec::new(), Vec::new());
        for p in &self.signature.params {
            body.declare_param(p, self.options, &mut kinds, &mut frames);
        }
        let relations: Option<Vec<Test>> =
            self.options.relations.iter().map(|r| body.relate(&r.comparison)).collect();
        let relations = relations?;
        body.vanish(&self.signature.params);
        let segments = body.confine(&self.signature.source, &unknowns, segments);
        let result = body.result(&self.item.block)?;
        let (point, atom) = body.ending(result, self.signature, &self.item.block)?;
        let point = point.filter(|(outputs, _)| atom.is_some() || body.is_defined(outputs));
        let Body { graph, requirements, making, way, .. } = body;
        let constants = making.constants;
        let (scalars, vectors) = (body.scalars, body.vectors);
        let (cuts, constants_cut) = (body.cuts, body.constants_cut);
        let first = kinds.iter().map(Kind::scalars).sum::<usize>();
        kinds.extend(constants.all.iter().map(|constant| constant.kind.clone()));
        debug_assert!(first <= 64);
        Some(Reading {
            graph,
            way,
            unknowns,
            argument,
            kinds,
            frames,
            requirements,
            constants,
            point,
            atom,
            segments,
            relations,
            scalars,
            vectors,
            cuts,
            constants_cut,
        })
    }
}

/// Makes the uniforms or the argument known under their name.
fn declare_source(
    graph: &mut Graph,
    names: &mut HashMap<String, Value>,
    source: &Source,
) -> (Vec<Leaf>, Option<Kind>) {
    match source {
        Source::Uniforms { name, count } => {
            let range = Interval::new(0.0, 1.0);
            let unknowns: Vec<Leaf> = (0..*count).map(|i| Leaf::Unknown(i as u8)).collect();
            let ids: Vec<Id> = unknowns
                .iter()
                .enumerate()
                .map(|(i, &leaf)| {
                    let text =
                        if *count == 1 { name.clone() } else { format!("{name}{}", subscript(i)) };
                    graph.leaf(leaf, &text, range)
                })
                .collect();
            names.insert(name.clone(), Value::Uniforms(ids));
            (unknowns, None)
        }
        Source::Point { name, space } => {
            let (coordinates, kind) = space.argument();
            let range =
                if *space == Space::Direction { Interval::new(-1.0, 1.0) } else { Interval::ALL };
            let unknowns: Vec<Leaf> = (0..coordinates).map(|i| Leaf::Unknown(i as u8)).collect();
            let ids: Vec<Id> = unknowns
                .iter()
                .enumerate()
                .map(|(i, &leaf)| {
                    let text = if coordinates == 1 {
                        name.clone()
                    } else {
                        format!("{name}.{}", ["x", "y", "z"][i])
                    };
                    graph.leaf(leaf, &text, range)
                })
                .collect();
            if *space == Space::Direction {
                graph.declare_unit([ids[0], ids[1], ids[2]]);
            }
            let value = if ids.len() == 1 { Value::Scalar(ids[0]) } else { Value::Vector(ids) };
            names.insert(name.clone(), value);
            (unknowns, Some(kind))
        }
    }
}

fn subscript(i: usize) -> String {
    (i + 1).to_string().chars().filter_map(|c| char::from_u32(0x2080 + c.to_digit(10)?)).collect()
}
