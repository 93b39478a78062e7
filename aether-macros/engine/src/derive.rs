//! From a map's outputs to its inverse, Jacobian and density, each checked while compiling.

mod accuracy;
mod atom_bounds;
mod atoms;
mod back;
mod borders;
mod by_inverse;
mod capped;
mod cases;
mod continuity;
mod density;
mod determinant;
mod factored;
mod finish;
mod fractions;
mod gaps;
mod holding;
mod implied;
mod inverse;
mod joint;
mod limits;
mod line;
mod near_one;
mod nearby;
mod occurring;
mod one_root;
mod opened;
mod opposed;
mod parts;
mod pick;
mod problem;
mod ranges;
mod recognised;
mod regimes;
mod rooted;
mod sample;
mod scaled;
mod shares;
mod signs;
mod staged;
mod strays;
mod sums;
mod texts;
mod through;
mod together;
mod tried_points;
mod turned;
mod units;
mod valued;
mod volume;

use crate::expr::{Id, Leaf, OUTS, UNKNOWNS, leaf_bit};
use crate::interval::Interval;
use crate::measure::Measure;
use crate::overflow::guard;
use crate::solve::{Numerical, Solution};
use crate::stabilise::stabilise_point;

pub use accuracy::{Accuracy, Worst};
pub use atoms::{Atom, atoms};
pub use back::Image;
pub use borders::Border;
pub use continuity::Limit;
pub(crate) use fractions::by_fractions;
pub(crate) use joint::{Block, blocks};
pub use problem::{Derived, Part, Preimage, Problem, Target};
pub use scaled::Scaled;
pub use signs::Signs;
pub use texts::{in_words, texts};
pub use tried_points::on_which_way;

use borders::find_borders;
use capped::keep_capped;
use cases::{Case, cases, measured, verify_volume, with_single};
use density::density;
use determinant::{any_volumes, per_uniform};
use finish::finish;
use inverse::Inverse;
use limits::parameters_with_limits;
use parts::Whole;
use pick::accurate;
use ranges::{always_inside, keep_ranges, shorten_tests};
use sample::{at_the_sample, shorter};
use sums::Sums;
use together::multiplied_once;
use units::units;
use valued::share_values;
use volume::pick_volume;

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
    // Without a short Jacobian there is a long one; without an inverse there is nothing.
    crate::poly::refill_budget(2);
    let (inverse, cases) = inverse::find(problem, &targets, (volumes[0], cases), most)?;
    verify_volume(problem, inner[0], &cases)?;
    let orientation = cases::orientation(problem, &cases);
    let [volumes, named] = staged::in_terms_of(problem, inverse.stage.as_ref(), volumes);

    // What is tried from here on are forms, in both precisions.
    let [cases, corners] = [cases, corners].map(|these| with_single(problem, volumes[0], these));
    let mut trial = Trial {
        at_uniforms: measured(problem, cases.iter().chain(&corners), true),
        at_points: measured(problem, cases.iter(), false),
        cases,
    };
    let written = problem.outputs.clone();
    crate::poly::refill_budget(8);
    let gaps = gaps::gaps(problem, &inverse.solutions);
    let forward = match &whole {
        // Each part counts, however small.
        Some(_) => accurate(&mut problem.graph, &written, &outputs, &mut trial.at_uniforms),
        None => stabilise_point(&mut problem.graph, &written, &mut trial.at_uniforms, &gaps),
    };
    let forward = shorter(&mut problem.graph, forward, &written, &mut trial.at_uniforms);
    let forward: Vec<Id> = forward.into_iter().map(|f| guard(&mut problem.graph, f)).collect();
    let mut own = pick_volume(problem, &volumes, &mut trial.at_uniforms);
    let mut accuracy = Accuracy::default();
    let known = (&forward[..], &named[..], whole.as_ref(), &targets[..]);
    let mut preimages = all_preimages(problem, &inverse, known, &mut trial, &mut accuracy);
    // Where all preimages have one formula for their densities, it is that of the sample.
    if let [first, others @ ..] = &preimages[..]
        && others.iter().all(|other| other.density == first.density)
    {
        let sample = (&forward[..], first.density, &gaps);
        own = at_the_sample(problem, own, sample, &mut trial.at_uniforms);
    }
    for preimage in &mut preimages {
        if !inverse.check_forward {
            holding::ask_for_values(problem, preimage);
        }
        shorten_tests(problem, preimage);
        if problem.argument.is_none() {
            preimage.density =
                multiplied_once(&mut problem.graph, preimage.density, &mut trial.at_points);
            share_values(&mut problem.graph, preimage, &mut trial.at_points);
        }
    }
    let limits = limits(problem, (&forward, own), &preimages, &trial);
    accuracy.add_own(problem, own, &trial.cases);
    let g = &mut problem.graph;
    let one = g.int(1);
    // Of parameters alone, both are one number, and nothing need be asked of the sample then.
    let own_density = match &preimages[..] {
        [only] if !g.has(own, OUTS | UNKNOWNS) && !g.has(only.density, OUTS | UNKNOWNS) => {
            only.density
        }
        _ => g.div(one, own),
    };
    let Inverse { solutions, check_forward, .. } = inverse;
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
        steps: solutions.into_iter().flat_map(|s| s.steps).collect(),
    })
}

/// The points at which forms are tried.
struct Trial {
    cases: Vec<Case>,
    /// By the unknowns there.
    at_uniforms: Measure,
    /// By the coordinates there.
    at_points: Measure,
}

/// What is known before preimages are made ready: the map, its volumes in terms of stages, the combination of its
/// coordinates that is one, and the coordinates of a point.
type Known<'k> = (&'k [Id], &'k [Id], Option<&'k Whole>, &'k [Id]);

/// The preimages of a point, each in the most accurate form with its share of the density.
fn all_preimages(
    problem: &mut Problem,
    inverse: &Inverse,
    (forward, volumes, whole, targets): Known<'_>,
    trial: &mut Trial,
    accuracy: &mut Accuracy,
) -> Vec<Preimage> {
    let injective = inverse.solutions.len() == 1;
    crate::poly::refill_budget(8);
    let sums = sums(problem, whole, injective);
    let conditions = conditions(problem, inverse, targets);
    let mut preimages = Vec::new();
    for (s, conditions) in inverse.solutions.iter().zip(&conditions) {
        let Trial { cases, at_points, .. } = &mut *trial;
        crate::poly::start_budget();
        crate::poly::refill_budget(4);
        let density = density(problem, s, (volumes, &sums), cases, at_points, injective);
        crate::poly::refill_budget(8);
        let mut preimage = finish(problem, s, (density, &sums), cases, at_points, conditions);
        if inverse.check_forward {
            compare_images(problem, (forward, s), trial, &mut preimage);
        }
        let cases = &trial.cases;
        accuracy.add(problem, s, (preimage.density, &preimage.unknowns), cases);
        keep_ranges(problem, s, &preimage.tested);
        keep_capped(problem, &preimage.tested, cases);
        preimages.push(preimage);
    }
    if let ([preimage], [solution]) = (&mut preimages[..], &inverse.solutions[..]) {
        always_inside(problem, forward, &preimage.tested);
        if problem.argument.is_none() {
            find_borders(problem, forward, solution, &trial.cases, preimage);
        }
    }
    preimages
}

/// What is known of sums of the coordinates of a point and of their squares.
fn sums<'w>(problem: &mut Problem, whole: Option<&'w Whole>, injective: bool) -> Sums<'w> {
    let (mut unit, mut stretched) = (vec![], vec![]);
    for together in if injective { units(problem) } else { vec![] } {
        match together.unit(&mut problem.graph) {
            Some(places) => unit.push(places),
            None => stretched.push(together),
        }
    }
    let pairs = opposed::pairs(problem);
    Sums { whole, units: unit, stretched, pairs, is_direction: problem.is_direction() }
}

/// What has to hold of a point for each of its preimages.
fn conditions(problem: &mut Problem, inverse: &Inverse, targets: &[Id]) -> Vec<Vec<Id>> {
    let solutions = &inverse.solutions;
    if !inverse.check_forward {
        return solutions.iter().map(|s| s.conditions.iter().map(|c| c.0).collect()).collect();
    }
    // Mapping forward again is a test that contains all others, but what tells opposite preimages apart may be smaller
    // than rounding lets it see.
    let opposed = holding::opposed(&mut problem.graph, solutions);
    let sides = holding::sides(problem, targets);
    // Of roots on neighbouring pieces both may lead back where rounding puts them beyond an end.
    let ends = solutions.iter().map(|s| s.pieces.iter().flat_map(|p| &p.conditions));
    let all = opposed.into_iter().zip(ends);
    all.map(|(c, ends)| c.into_iter().chain(ends.copied()).chain(sides.clone()).collect()).collect()
}

/// Has a preimage ask for what its image shows, where that is short.
fn compare_images(
    problem: &mut Problem,
    (forward, s): (&[Id], &Solution),
    Trial { cases, at_points, .. }: &mut Trial,
    preimage: &mut Preimage,
) {
    let made = (forward, &preimage.unknowns[..]);
    let Some(image) = back::back(problem, made, s, cases, at_points) else { return };
    let asked = image.conditions.iter().filter(|c| !preimage.conditions.contains(c));
    let asked: Vec<Id> = asked.copied().collect();
    for list in [&mut preimage.conditions, &mut preimage.open, &mut preimage.asked] {
        list.extend(&asked);
    }
    preimage.back = Some(image);
}

/// The parameters that must not be exactly zero: for samples and their own densities, and for what is asked of a point.
fn limits(
    problem: &Problem,
    (forward, own): (&[Id], Id),
    preimages: &[Preimage],
    trial: &Trial,
) -> Vec<u8> {
    let at_uniforms: Vec<Id> = forward.iter().copied().chain([own]).collect();
    let at_point = preimages.iter().flat_map(|p| p.tested.iter().copied().chain([p.density]));
    let at_point: Vec<Id> = at_point.collect();
    let mut limits = parameters_with_limits(&problem.graph, &at_uniforms, &trial.at_uniforms);
    limits.extend(parameters_with_limits(&problem.graph, &at_point, &trial.at_points));
    limits
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
