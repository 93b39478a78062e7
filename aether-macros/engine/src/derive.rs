//! From a map's outputs to its inverse, Jacobian and density, each checked while compiling.

mod accuracy;
mod atom_bounds;
mod atoms;
mod back;
mod borders;
mod capped;
mod cases;
mod continuity;
mod density;
mod factored;
mod fractions;
mod gaps;
mod holding;
mod implied;
mod joint;
mod limits;
mod line;
mod near_one;
mod nearby;
mod one_root;
mod opened;
mod opposed;
mod parts;
mod regimes;
mod rooted;
mod sample;
mod scaled;
mod shares;
mod signs;
mod staged;
mod strays;
mod through;
mod turned;
mod units;
mod valued;
mod volume;

use std::collections::BTreeMap;

use crate::display::show;
use crate::expr::{Graph, Id, Leaf, OUTS, leaf_bit};
use crate::interval::Interval;
use crate::jacobian::{Source, cost_together, simplify, sphere, volume};
use crate::measure::{Inputs, Measure};
use crate::overflow::guard;
use crate::parse::{Made, Piece, Segment, Space, Stage, Test};
use crate::points::{Kind, placed};
use crate::solve::{Condition, Numerical, Solution, System, solve};
use crate::stabilise::stabilise_point;

pub use accuracy::{Accuracy, Worst};
pub use atoms::{Atom, atoms};
pub use borders::Border;
pub use continuity::Limit;
pub(crate) use fractions::by_fractions;
pub use signs::Signs;

pub use back::Image;
use borders::find_borders;
use capped::keep_capped;
pub use cases::on_which_way;
use cases::{Case, cases, in_single, inputs, prune, verify_volume};
use density::{Sums, accurate, density, finish};
use limits::parameters_with_limits;
use line::line;
use opened::opened;
use sample::{at_the_sample, shorter};
pub use scaled::Scaled;
use signs::find_signs;
use units::units;
use valued::share_values;
use volume::pick_volume;

/// What the type of the result guarantees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// The whole of R^n.
    Free,
    /// A unit vector, guaranteed by the type.
    Direction,
    /// A point of a surface that the type identifies.
    Identified,
    /// A manifold that only the map itself knows: membership is tested in every density.
    Embedded,
}

/// One point of a result.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    /// What its type guarantees.
    pub target: Target,
    /// How many coordinates it has.
    pub coordinates: usize,
    /// The dimension of its space.
    pub dimension: usize,
}

impl Part {
    /// A point of a space.
    pub fn of(space: &Space) -> Part {
        let (dimension, coordinates) = space.dimensions();
        let target = match space {
            Space::Direction => Target::Direction,
            Space::SurfacePoint => Target::Identified,
            Space::Embedded { .. } => Target::Embedded,
            _ => Target::Free,
        };
        Part { target, coordinates, dimension }
    }
}

impl Problem {
    /// Whether the result is one point, a direction.
    pub fn is_direction(&self) -> bool {
        matches!(self.parts[..], [Part { target: Target::Direction, .. }])
    }

    /// The parts with the places of their coordinates.
    pub fn placed(&self) -> Vec<(Part, std::ops::Range<usize>)> {
        let mut first = 0;
        let place = |part: &Part| {
            let range = first..first + part.coordinates;
            first = range.end;
            (*part, range)
        };
        self.parts.iter().map(place).collect()
    }
}

/// An item as parsed: a map from unknowns to outputs.
pub struct Problem {
    /// The expressions.
    pub graph: Graph,
    /// The output coordinates.
    pub outputs: Vec<Id>,
    /// The unknowns: uniforms, or coordinates of a map's argument.
    pub unknowns: Vec<Leaf>,
    /// What the argument of a map is; `None` for a sampler.
    pub argument: Option<Kind>,
    /// The scalar parameters in groups.
    pub kinds: Vec<Kind>,
    /// Those that are made of others.
    pub made: Made,
    /// Parameters that are frames, by columns.
    pub frames: Vec<[[Id; 3]; 3]>,
    /// The points that the result consists of; mostly a single one.
    pub parts: Vec<Part>,
    /// Expressions that must be positive for there to be a result.
    pub requirements: Vec<Id>,
    /// What holds on this way through the branches of the body.
    pub guards: Vec<Test>,
    /// What has to hold of the parameters for this piece to have any points.
    pub existence: Vec<Test>,
    /// The parameters that are zero there, which the expressions do not mention.
    pub vanishing: Vec<Leaf>,
    /// What is declared of the parameters together.
    pub relations: Vec<Test>,
    /// Expressions of the unknowns whose sizes are lengths in terms of the point.
    pub lengths: Vec<(Id, Id)>,
    /// The same in two steps, to be tried where there is no inverse otherwise.
    pub stages: Vec<Stage>,
    /// The segments of the uniforms that the unknowns run over, where these are not all of [0, 1).
    pub segments: Vec<Option<Segment>>,
    /// Whether no inverse was found, with a numerical one asked for only where functions are monotone.
    pub stuck: bool,
}

/// One preimage, ready to be emitted.
pub struct Preimage {
    /// The unknowns, as accurate as they can be had.
    pub unknowns: Vec<Id>,
    /// The unknowns in a shorter form, good enough to see whether they lie in [0, 1).
    pub tested: Vec<Id>,
    /// Must be at least zero.
    pub conditions: Vec<Id>,
    /// Must be greater than zero.
    pub requirements: Vec<Id>,
    /// The density of a sampler's point by way of this preimage.
    pub density: Id,
    /// The image of the unknowns, where that has to be compared with the point, if it is short.
    pub back: Option<Image>,
    /// For each unknown, where a coordinate by itself tells whether it lies in [0, 1].
    pub borders: Vec<Option<Border>>,
    /// For each unknown, the signs that tell whether it lies in [0, 1), if these are shorter.
    pub signs: Vec<Option<Signs>>,
    /// The conditions that do not follow from where coordinates lie between their borders.
    pub open: Vec<Id>,
    /// Those of them that do not follow from signs either.
    pub asked: Vec<Id>,
}

impl Preimage {
    /// All that is computed of a point to see whether it has this preimage, and with which density.
    fn expressions(&mut self) -> impl Iterator<Item = &mut Id> {
        let lists = [&mut self.unknowns, &mut self.tested, &mut self.conditions];
        let more = [&mut self.requirements, &mut self.open, &mut self.asked];
        let borders = self.borders.iter_mut().flatten().flat_map(Border::expressions);
        let signs = self.signs.iter_mut().flatten().flat_map(Signs::expressions);
        let lists = lists.into_iter().chain(more).flatten();
        lists.chain(borders).chain(signs).chain([&mut self.density])
    }
}

/// Everything that was derived.
pub struct Derived {
    /// The outputs in their most accurate form.
    pub forward: Vec<Id>,
    /// The preimages of a point.
    pub preimages: Vec<Preimage>,
    /// √det(JᵀJ) in terms of the unknowns.
    pub volume: Id,
    /// One over it: the density of a sample by its uniforms.
    pub own_density: Id,
    /// Whether a preimage must be mapped forward again to see that it is one.
    pub check_forward: bool,
    /// Whether the map has no value at some of the points that are tried, as a root of what is negative has none.
    pub undefined: bool,
    /// The scalar parameters that must not be exactly zero, because the formulas have only a limit
    /// there; in no order, and one may be named twice.
    pub limits: Vec<u8>,
    /// Whether the map keeps the orientation of its unknowns, where it is the same at all points that are tried.
    pub orientation: Option<bool>,
    /// On how many pieces an equation is solved numerically; zero if none is that turns back.
    pub pieces: usize,
    /// By how much it is off at points inside of the domain, in `f64`.
    pub accuracy: Accuracy,
    /// The derivation, a line a step.
    pub steps: Vec<String>,
}

/// Derives and verifies. The error is a text for the user.
pub fn derive(problem: &mut Problem) -> Result<Derived, String> {
    derive_with(problem, Numerical::Monotone)
}

/// The same where nothing else has an inverse: functions that turn back are inverted on each piece on which they are
/// monotone.
pub fn derive_by_pieces(problem: &mut Problem) -> Result<Derived, String> {
    derive_with(problem, Numerical::Pieces)
}

fn derive_with(problem: &mut Problem, most: Numerical) -> Result<Derived, String> {
    let as_written = |problem: &mut Problem| derive_as_written(problem, most);
    match turned::turned(problem) {
        Some(turned) => turned.derive(problem, as_written),
        None => as_written(problem),
    }
}

/// The inverse in closed form, if there is one and roots on several pieces are not asked for.
fn derive_as_written(problem: &mut Problem, most: Numerical) -> Result<Derived, String> {
    crate::poly::start_budget();
    let targets = declare_outputs(problem);
    all_used(problem)?;
    let whole = parts::whole(problem);
    let (outputs, inner) = match &whole {
        Some(whole) => whole.volume(problem),
        None => (problem.outputs.clone(), any_volumes(problem)?),
    };
    let volumes = per_uniform(problem, &inner);
    let (all, undefined) = cases(problem, volumes[0])?;
    let (corners, cases): (Vec<Case>, Vec<Case>) = all.into_iter().partition(|c| c.point.corner);
    let others = cases::of_other_signs(problem, volumes[0], &cases);
    let plain = cases.len();
    let selecting: Vec<Case> = cases.into_iter().chain(others).collect();
    // Without a short Jacobian there is a long one; without an inverse there is nothing.
    crate::poly::refill_budget(2);
    let inverse = |problem: &mut Problem, numerical| {
        // The search must not fail because the Jacobian is long.
        crate::poly::start_budget();
        let solutions = find_solutions(problem, &targets, numerical)?;
        prune(problem, solutions, &selecting).map_err(NoInverse::Wrong)
    };
    let numerically = |problem: &mut Problem| inverse(problem, Numerical::Monotone);
    // A closed form may be missing, or fail where its parts overflow.
    let mut staged = None;
    let closed = match most {
        Numerical::Pieces => None,
        _ => Some(inverse(problem, Numerical::No)),
    };
    let (solutions, check_forward) = match closed {
        None => inverse(problem, Numerical::Pieces).map_err(NoInverse::text)?,
        Some(Ok(found)) => found,
        Some(Err(NoInverse::Stuck(_))) => match in_stages(problem, &targets, &selecting) {
            Some((found, stage)) => {
                staged = Some(stage);
                found
            }
            None => {
                let found = numerically(problem);
                problem.stuck = matches!(found, Err(NoInverse::Stuck(_)));
                found.map_err(NoInverse::text)?
            }
        },
        Some(Err(NoInverse::Wrong(why))) => numerically(problem).map_err(|_| why)?,
    };
    let cases: Vec<Case> = selecting.into_iter().take(plain).collect();
    verify_volume(problem, inner[0], &cases)?;
    let orientation = cases::orientation(problem, &cases);
    let named = staged.as_ref().and_then(|stage| staged::volumes(problem, stage));
    let (mut volumes, mut named) = match (named, &staged) {
        (Some(named), Some(stage)) => {
            let own = named.iter().map(|&v| staged::spelled_out(problem, stage, v)).collect();
            (own, named)
        }
        _ => (volumes.clone(), volumes),
    };
    for forms in [&mut volumes, &mut named] {
        let open: Vec<Id> =
            forms.iter().filter_map(|&form| opened(&mut problem.graph, form)).collect();
        forms.extend(open);
    }

    // What is tried from here on are forms, in both precisions.
    let cases = {
        let single = in_single(problem, volumes[0], &cases);
        cases.into_iter().chain(single).collect::<Vec<Case>>()
    };
    let corners = {
        let single = in_single(problem, volumes[0], &corners);
        corners.into_iter().chain(single).collect::<Vec<Case>>()
    };
    let measured = |problem: &Problem, unknowns| {
        let points = |single: bool| -> Vec<Inputs> {
            let corners = if unknowns { &corners[..] } else { &[] };
            let cases = cases.iter().chain(corners).filter(|c| c.single == single);
            // Grazing directions are for the forms of inverses.
            let cases = cases.filter(|c| !(unknowns && c.point.grazing));
            cases.map(|c| inputs(problem, c, unknowns)).collect()
        };
        Measure::new(points(false), points(true))
    };
    let mut unknown_points = measured(problem, true);
    let mut out_points = measured(problem, false);
    let written = problem.outputs.clone();
    crate::poly::refill_budget(8);
    let gaps = gaps::gaps(problem, &solutions);
    let forward = match &whole {
        // Each part counts, however small.
        Some(_) => accurate(&mut problem.graph, &written, &outputs, &mut unknown_points),
        None => stabilise_point(&mut problem.graph, &written, &mut unknown_points, &gaps),
    };
    let forward = shorter(&mut problem.graph, forward, &written, &mut unknown_points);
    let forward: Vec<Id> = forward.into_iter().map(|f| guard(&mut problem.graph, f)).collect();
    let mut own = pick_volume(problem, &volumes, &mut unknown_points);
    let mut preimages = Vec::new();
    let mut accuracy = Accuracy::default();
    let mut steps = Vec::new();
    let injective = solutions.len() == 1;
    crate::poly::refill_budget(8);
    let (mut unit, mut stretched) = (vec![], vec![]);
    for together in if injective { units(problem) } else { vec![] } {
        match together.unit(&mut problem.graph) {
            Some(places) => unit.push(places),
            None => stretched.push(together),
        }
    }
    let sums = Sums {
        whole: whole.as_ref(),
        units: unit,
        stretched,
        pairs: opposed::pairs(problem),
        is_direction: problem.is_direction(),
    };
    // Mapping forward again is a test that contains all others, but what tells opposite preimages apart may be smaller
    // than rounding lets it see.
    let conditions: Vec<Vec<Id>> = match check_forward {
        true => {
            let opposed = holding::opposed(&mut problem.graph, &solutions);
            let sides = holding::sides(problem, &targets);
            let ends = solutions.iter().map(|s| s.pieces.iter().flat_map(|p| &p.conditions));
            // Of roots on neighbouring pieces both may lead back where rounding puts them beyond an end.
            opposed
                .into_iter()
                .zip(ends)
                .map(|(c, ends)| c.into_iter().chain(ends.copied()).chain(sides.clone()).collect())
                .collect()
        }
        false => solutions.iter().map(|s| s.conditions.iter().map(|c| c.0).collect()).collect(),
    };
    for (s, conditions) in solutions.iter().zip(&conditions) {
        steps.extend(s.steps.iter().cloned());
        crate::poly::start_budget();
        crate::poly::refill_budget(4);
        let density = density(problem, s, (&named, &sums), &cases, &mut out_points, injective);
        crate::poly::refill_budget(8);
        let mut preimage =
            finish(problem, s, (density, &sums), &cases, &mut out_points, conditions);
        if check_forward {
            let made = (&forward[..], &preimage.unknowns[..]);
            if let Some(image) = back::back(problem, made, s, &cases, &mut out_points) {
                let asked = image.conditions.iter().filter(|c| !preimage.conditions.contains(c));
                let asked: Vec<Id> = asked.copied().collect();
                for list in [&mut preimage.conditions, &mut preimage.open, &mut preimage.asked] {
                    list.extend(&asked);
                }
                preimage.back = Some(image);
            }
        }
        accuracy.add(problem, s, (preimage.density, &preimage.unknowns), &cases);
        keep_ranges(problem, s, &preimage.tested);
        keep_capped(problem, &preimage.tested, &cases);
        preimages.push(preimage);
    }
    if let ([preimage], [solution]) = (&mut preimages[..], &solutions[..]) {
        always_inside(problem, &forward, &preimage.tested);
        if problem.argument.is_none() {
            find_borders(problem, &forward, solution, &cases, preimage);
        }
    }
    // Where all preimages have one formula for their densities, it is that of the sample.
    if let [first, others @ ..] = &preimages[..]
        && others.iter().all(|other| other.density == first.density)
    {
        let sample = (&forward[..], first.density, &gaps);
        own = at_the_sample(problem, own, sample, &mut unknown_points);
    }
    for preimage in &mut preimages {
        if !check_forward {
            holding::ask_for_values(problem, preimage);
        }
        shorten_tests(problem, preimage);
        if problem.argument.is_none() {
            share_values(&mut problem.graph, preimage, &mut out_points);
        }
    }
    let at_uniforms: Vec<Id> = forward.iter().copied().chain([own]).collect();
    let at_point = preimages.iter().flat_map(|p| p.tested.iter().copied().chain([p.density]));
    let at_point: Vec<Id> = at_point.collect();
    let mut limits = parameters_with_limits(&problem.graph, &at_uniforms, &unknown_points);
    limits.extend(parameters_with_limits(&problem.graph, &at_point, &out_points));
    accuracy.add_own(problem, own, &cases);
    let g = &mut problem.graph;
    let one = g.int(1);
    let own_density = g.div(one, own);
    Ok(Derived {
        forward,
        preimages,
        volume: own,
        own_density,
        check_forward,
        undefined,
        limits,
        orientation,
        pieces: solutions.iter().flat_map(|s| &s.pieces).map(|p| p.of).max().unwrap_or(0),
        accuracy,
        steps,
    })
}

/// Finds out what need not be asked of a point, where nothing but the ends of unknowns limits a sampler's piece.
fn shorten_tests(problem: &mut Problem, preimage: &mut Preimage) {
    if problem.argument.is_some() || !problem.guards.is_empty() {
        return;
    }
    let g = &mut problem.graph;
    // An unknown that is in its range whatever the point is needs no test: its border is one if no point lies beyond.
    for (border, &tested) in preimage.borders.iter_mut().zip(&preimage.tested) {
        border.take_if(|border| g.range(tested).within_one() && !border.contains_all(g));
    }
    // What depends on coordinates between their borders alone holds there.
    let told = preimage.borders.iter().flatten();
    let told = told.fold(0, |told, border| told | g.deps(border.coordinate));
    let open = |c: &Id| told == 0 || g.deps(*c) & OUTS == 0 || g.has(*c, OUTS & !told);
    preimage.open.retain(open);
    let sides = preimage.tested.iter().zip(&preimage.borders).map(|(&u, border)| {
        let (range, open) = (g.range(u), border.is_none());
        (u, [open && !range.nonnegative(), open && !range.at_most_one()])
    });
    let sides: Vec<(Id, [bool; 2])> = sides.collect();
    (preimage.signs, preimage.asked) = find_signs(g, &sides, &preimage.open);
}

/// Makes known which ranges unknowns have, as because a coordinate is no longer than its point, whatever form they are
/// emitted in.
fn keep_ranges(problem: &mut Problem, s: &Solution, unknowns: &[Id]) {
    let g = &mut problem.graph;
    for (leaf, &value) in problem.unknowns.iter().zip(unknowns) {
        let Some(&found) = s.unknowns.get(leaf) else { continue };
        let (range, known) = (g.range(found), g.range(value));
        if range.intersection(known) != known {
            g.assume(value, range);
        }
    }
}

/// Makes known which unknowns lie in [0, 1] whatever the direction is.
fn always_inside(problem: &mut Problem, forward: &[Id], unknowns: &[Id]) {
    if !problem.is_direction() || problem.argument.is_some() {
        return;
    }
    let g = &mut problem.graph;
    for (leaf, &value) in problem.unknowns.iter().zip(unknowns) {
        if holding::from_pole_to_pole(g, &problem.outputs, forward, *leaf) {
            g.assume(value, Interval::new(0.0, 1.0));
        }
    }
}

/// Equal expressions for √det(JᵀJ), also by what is written without functions of twice an angle.
fn any_volumes(problem: &mut Problem) -> Result<Vec<Id>, String> {
    let mut volumes = any_volume(problem)?;
    let written = problem.outputs.clone();
    let g = &mut problem.graph;
    let forms: Vec<Id> = written.iter().map(|&x| opened(g, x).unwrap_or(x)).collect();
    if forms != written {
        crate::poly::start_budget();
        problem.outputs = forms;
        let more = any_volume(problem);
        problem.outputs = written;
        volumes.extend(more?);
    }
    Ok(volumes)
}

/// Equal expressions for √det(JᵀJ).
fn any_volume(problem: &mut Problem) -> Result<Vec<Id>, String> {
    if let Some(volume) = joint::volume(problem).or_else(|| spherical(problem)) {
        return volume;
    }
    if let Some(line) = line(problem) {
        return line.volume(&mut problem.graph);
    }
    if let Some(volume) = through::volume(problem) {
        return Ok(volume);
    }
    let source = (source_of(problem), problem.is_direction());
    let g = &mut problem.graph;
    volume(g, &problem.outputs, &problem.unknowns, source, &problem.frames)
}

/// The volume of what is written in spherical coordinates. That a direction has unit length is tried at
/// the points, like everything else.
fn spherical(problem: &mut Problem) -> Option<Result<Vec<Id>, String>> {
    if problem.argument.is_some() {
        return None;
    }
    let covered = if problem.is_direction() { sphere::area } else { sphere::volume };
    covered(&mut problem.graph, &problem.outputs, &problem.unknowns).map(Ok)
}

/// Volumes in terms of the uniforms, where the unknowns run over segments of them.
fn per_uniform(problem: &mut Problem, volumes: &[Id]) -> Vec<Id> {
    let g = &mut problem.graph;
    let widths: Vec<Id> = problem.segments.iter().flatten().map(|s| s.width).collect();
    let scale = widths.into_iter().fold(g.int(1), |product, w| g.mul(product, w));
    volumes.iter().map(|&v| g.div(v, scale)).collect()
}

/// Every unknown must matter to the result.
fn all_used(problem: &Problem) -> Result<(), String> {
    let g = &problem.graph;
    for (i, &u) in problem.unknowns.iter().enumerate() {
        if problem.argument.is_none() && problem.outputs.iter().all(|o| !g.has(*o, leaf_bit(u))) {
            return Err(format!(
                "uniform number {i} is not used: the result does not depend on it, so it fills fewer dimensions than its space has. Use it, or take fewer uniforms and return a space of lower dimension"
            ));
        }
    }
    Ok(())
}

fn declare_outputs(problem: &mut Problem) -> Vec<Id> {
    // The outputs are called x, y, z unless a parameter is; those of several points a.x, b.x, ….
    let taken = |name: &str| (0..64).any(|i| problem.graph.name(Leaf::Param(i)) == name);
    let plain = !["x", "y", "z"].iter().any(|n| taken(n));
    let letters = if plain { ["x", "y", "z", "w", "v"] } else { ["X", "Y", "Z", "W", "V"] };
    let joint = problem.parts.len() > 1;
    let mut outs: Vec<Id> = Vec::new();
    for (k, (part, place)) in problem.placed().into_iter().enumerate() {
        let unit = part.target == Target::Direction;
        let range = if unit { Interval::new(-1.0, 1.0) } else { Interval::ALL };
        for (i, j) in place.clone().enumerate() {
            let letter = letters.get(i).copied().unwrap_or("x");
            let owner = char::from(b'a' + k as u8);
            let name = if joint { format!("{owner}.{letter}") } else { letter.to_owned() };
            outs.push(problem.graph.leaf(Leaf::Out(j as u8), &name, range));
        }
        if unit {
            let o = &outs[place];
            problem.graph.declare_unit([o[0], o[1], o[2]]);
        }
    }
    outs
}

fn source_of(problem: &mut Problem) -> Source {
    match problem.argument {
        Some(Kind::Direction) => {
            let w = [0, 1, 2].map(|i| problem.graph.get_leaf(Leaf::Unknown(i)));
            Source::Direction(w)
        }
        _ => Source::Free,
    }
}

/// Why there is no inverse.
enum NoInverse {
    /// The solver found none.
    Stuck(String),
    /// It found one that is wrong at some point.
    Wrong(String),
}

impl NoInverse {
    fn text(self) -> String {
        match self {
            NoInverse::Stuck(text) | NoInverse::Wrong(text) => text,
        }
    }
}

/// The inverse of the first of the two-step forms that has one.
fn in_stages(
    problem: &mut Problem,
    targets: &[Id],
    cases: &[Case],
) -> Option<((Vec<Solution>, bool), Stage)> {
    let stages = std::mem::take(&mut problem.stages);
    stages.into_iter().enumerate().find_map(|(k, stage)| {
        crate::poly::start_budget();
        let solutions = staged::solutions(problem, &stage, (k, targets))?;
        Some((prune(problem, solutions, cases).ok()?, stage))
    })
}

fn find_solutions(
    problem: &mut Problem,
    targets: &[Id],
    numerical: Numerical,
) -> Result<Vec<Solution>, NoInverse> {
    let mut outputs = problem.outputs.clone();
    let mut known = targets.to_vec();
    if problem.argument == Some(Kind::Direction) {
        // The argument has unit length: one more equation.
        let g = &mut problem.graph;
        let w = [0, 1, 2].map(|i| g.get_leaf(Leaf::Unknown(i)));
        let length = w.map(|c| (crate::rational::Q::ONE, g.powi(c, 2)));
        outputs.push(g.plain_sum(&length));
        known.push(g.int(1));
    }
    let line = line(problem);
    let (unknowns, frames) = (problem.unknowns.clone(), problem.frames.clone());
    let (undeclared, positive) = (undeclared(problem), problem.requirements.clone());
    let g = &mut problem.graph;
    let solved =
        |g: &mut Graph, system: &System| solve(g, system, &unknowns, &frames, &positive, numerical);
    // What the surfaces tell of two points of a line is used where that is enough.
    let written = System::new(&known, &outputs);
    let mut solutions = solved(g, &written)
        .or_else(|stuck| {
            let line = line.ok_or_else(|| stuck.clone())?;
            crate::poly::start_budget();
            let system = line.system(g, &known, &positive);
            solved(g, &system).map_err(|_| stuck)
        })
        .map_err(|s| {
        let words: Vec<&str> = s.equation.split(|c: char| !c.is_alphanumeric() && c != '_').collect();
        let concerned = undeclared.iter().find(|name| words.contains(&name.as_str()));
        let declare = concerned.map_or(String::new(), |name| format!("If that depends on the values of `{name}`, declare its domain, as in `#[sampler({name} in 0.1..=10.0)]`. Else write"));
        let write = if declare.is_empty() { "Write".to_owned() } else { declare };
        let way = s.numerical.unwrap_or_else(|| format!("{write} the map with each uniform in one place, or as a composition of samplers and maps that can be inverted one at a time"));
        NoInverse::Stuck(format!(
            "cannot invert this map: stuck at `{}`, which should give {}. {way}",
            s.equation,
            s.unknowns.join(" and ")
        ))
    })?;
    let g = &mut problem.graph;
    for s in &mut solutions {
        tidy(g, &mut s.unknowns);
        s.short = s.unknowns.clone();
        let spelled: Vec<_> = s.unknowns.iter().map(|(l, v)| (*l, s.spell_out(g, *v))).collect();
        s.unknowns = spelled.into_iter().collect();
        s.conditions = s.conditions.iter().map(|c| Condition(s.spell_out(g, c.0))).collect();
        let mut pieces = std::mem::take(&mut s.pieces);
        for id in pieces.iter_mut().flat_map(|p| p.conditions.iter_mut().chain(&mut p.widths)) {
            *id = s.spell_out(g, *id);
        }
        s.pieces = pieces;
    }
    Ok(solutions)
}

/// Simplifies expressions, but for those that cost less as they are, next to the others.
fn tidy(g: &mut Graph, values: &mut BTreeMap<Leaf, Id>) {
    let written: Vec<(Leaf, Id)> = values.iter().map(|(leaf, v)| (*leaf, *v)).collect();
    for v in values.values_mut() {
        *v = simplify(g, *v, None);
    }
    let together = |g: &Graph, values: &BTreeMap<Leaf, Id>| {
        cost_together(g, &values.values().copied().collect::<Vec<_>>())
    };
    for (leaf, as_written) in written {
        let before = together(g, values);
        let tidied = values.insert(leaf, as_written);
        if let Some(tidied) = tidied.filter(|_| together(g, values) >= before) {
            values.insert(leaf, tidied);
        }
    }
}

/// The numbers among the parameters that no domain is declared of.
fn undeclared(problem: &Problem) -> Vec<String> {
    let open = placed(&problem.kinds).filter(|(kind, _)| **kind == Kind::Scalar(None));
    open.map(|(_, place)| problem.graph.name(Leaf::Param(place.start as u8)).to_owned()).collect()
}

/// The texts of the documentation: (forward, inverse, jacobian, density), a line a piece (and a
/// preimage).
pub fn texts(pieces: &mut [Piece], derived: &[Derived]) -> [String; 4] {
    let mut lines: [Vec<String>; 4] = Default::default();
    for (piece, derived) in pieces.iter_mut().zip(derived) {
        let condition = condition(piece);
        let problem = &mut piece.problem;
        let g = &mut problem.graph;
        let list = |ids: &[Id]| ids.iter().map(|i| show(g, *i)).collect::<Vec<_>>().join(", ");
        let strictly = |&difference: &Id| Test { difference, strict: true };
        let required: Vec<Test> = problem.requirements.iter().map(strictly).collect();
        let required = in_words(g, &required, "if");
        lines[0].push(format!("({}){condition}{required}", list(&problem.outputs)));
        for preimage in &derived.preimages {
            let values = preimage.tested.iter().enumerate().map(|(i, &v)| {
                let whole = match problem.segments.get(i).copied().flatten() {
                    Some(s) => {
                        let inside = g.mul(s.width, v);
                        g.add(s.low, inside)
                    }
                    None => v,
                };
                format!("{} = {}", g.name(problem.unknowns[i]), show(g, whole))
            });
            lines[1].push(values.collect::<Vec<_>>().join(",  "));
        }
        lines[2].push(format!("{}{condition}", show(g, derived.volume)));
        lines[3].extend(derived.preimages.iter().map(|p| show(g, p.density)));
    }
    let [forward, inverse, jacobian, density] = lines;
    [forward.join("\n"), inverse.join("\n"), jacobian.join("\n"), density.join(" + ")]
}

/// The conditions of a piece in words: `  where u < 1/2`.
fn condition(piece: &Piece) -> String {
    in_words(&piece.graph, &piece.tests, "where")
}

/// Tests in words, after a conjunction.
pub fn in_words(g: &Graph, tests: &[Test], conjunction: &str) -> String {
    let tests = tests.iter().map(|t| {
        let sign = if t.strict { ">" } else { "≥" };
        format!("{} {sign} 0", show(g, t.difference))
    });
    let tests: Vec<String> = tests.collect();
    if tests.is_empty() { String::new() } else { format!("  {conjunction} {}", tests.join(", ")) }
}
