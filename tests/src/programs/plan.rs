//! What proptest composes: the steps of a program, without knowing yet whether they fit.

use proptest::prelude::*;

/// A number of a program: a constant, or one of the parameters `a` and `b`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Number {
    /// A constant.
    Constant(f64),
    /// A parameter, positive.
    Parameter(usize),
}

/// What is done to one coordinate.
#[derive(Clone, Debug, PartialEq)]
pub enum Scalar {
    /// shift ± scale · x, in one of several spellings.
    Affine(Number, f64, u8),
    /// A root, a whole power, a reciprocal, or x^number.
    Power(Number, u8),
    /// Exponentials, logarithms, hyperbolic functions and their like.
    Exponential(Number, u8),
    /// Sines and cosines, monotone or not.
    Wave(u8),
    /// |x - m| and other functions with two preimages.
    Fold(u8),
    /// Different functions below and above a threshold, by `if` or by `match`.
    Branch(f64, u8),
}

/// What is done to two coordinates.
#[derive(Clone, Debug, PartialEq)]
pub enum Pair {
    /// (r, φ) to (r cos φ, r sin φ).
    Polar(u8),
    /// By an angle.
    Rotate(Number, u8),
    /// At a line through the origin.
    Reflect(u8),
    /// One coordinate moves or stretches the other.
    Shear(Number, u8),
    /// A triangle of a square.
    Triangle,
    /// Pieces cut by a line.
    Branch(u8),
    /// At the diagonal: two preimages.
    Fold,
}

/// What is done to a vector of space.
#[derive(Clone, Debug, PartialEq)]
pub enum Turn {
    /// About an axis.
    Rotate(usize, Number, u8),
    /// At a plane.
    Reflect(usize),
    /// Into the frame that is a parameter.
    Frame,
    /// Stretched along the axes; a direction is normalised again.
    Stretch(Number, Number),
    /// Moved; a direction is normalised again.
    Shift(usize),
    /// The point mirrored into the upper half: two preimages.
    Fold,
    /// Mirrored about the half vector.
    Half(usize),
}

/// A step.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// On one coordinate.
    One(usize, Scalar),
    /// On two.
    Two(usize, Pair),
}

/// How coordinates become a point of a space.
#[derive(Clone, Debug, PartialEq)]
pub enum Finish {
    /// The coordinates as they are, of one, two or three dimensions; the turns are for three.
    Flat(usize, Vec<Turn>),
    /// Two coordinates to the unit sphere: by height and angle, two angles, or (x, y, h) normalised.
    Direction(u8, Vec<Turn>),
    /// Two coordinates to a surface in space.
    Surface(u8, Vec<Turn>),
}

/// A program as proptest composes it.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// From the uniforms on.
    pub steps: Vec<Step>,
    /// To the result.
    pub finish: Finish,
    /// Which intermediate results get a name, bit by bit.
    pub names: u32,
    /// Whether the parameters have a declared domain.
    pub declared: bool,
}

fn constant() -> impl Strategy<Value = f64> {
    prop::sample::select(vec![0.25, 0.3, 0.5, 0.6, 0.75, 0.8, 1.2, 1.25, 1.5, 1.7, 2.0, 2.5, 3.0])
}

fn number() -> impl Strategy<Value = Number> {
    prop_oneof![
        4 => constant().prop_map(Number::Constant),
        1 => (0..2usize).prop_map(Number::Parameter),
    ]
}

fn affine() -> impl Strategy<Value = Scalar> {
    (number(), prop::sample::select(vec![-1.0, -0.5, 0.0, 0.25, 0.4, 1.0, 1.5]), 0..6u8)
        .prop_map(|(k, c, form)| Scalar::Affine(k, c, form))
}

fn scalar(core: bool) -> BoxedStrategy<Scalar> {
    if core {
        return affine().boxed();
    }
    prop_oneof![
        2 => affine(),
        2 => (number(), 0..7u8).prop_map(|(k, form)| Scalar::Power(k, form)),
        3 => (number(), 0..10u8).prop_map(|(k, form)| Scalar::Exponential(k, form)),
        1 => (0..6u8).prop_map(Scalar::Wave),
        1 => (0..5u8).prop_map(Scalar::Fold),
        2 => (prop::sample::select(vec![0.25, 0.4, 0.5, 0.7]), 0..6u8).prop_map(|(at, form)| Scalar::Branch(at, form)),
    ]
    .boxed()
}

fn pair(core: bool) -> BoxedStrategy<Pair> {
    let polar = (0..3u8).prop_map(Pair::Polar);
    let rotate = (number(), 0..3u8).prop_map(|(k, form)| Pair::Rotate(k, form));
    if core {
        return prop_oneof![polar, rotate].boxed();
    }
    prop_oneof![
        3 => polar,
        2 => rotate,
        1 => (0..2u8).prop_map(Pair::Reflect),
        2 => (number(), 0..5u8).prop_map(|(k, form)| Pair::Shear(k, form)),
        1 => Just(Pair::Triangle),
        2 => (0..4u8).prop_map(Pair::Branch),
        1 => Just(Pair::Fold),
    ]
    .boxed()
}

fn turn(core: bool) -> BoxedStrategy<Turn> {
    let rotate =
        (0..3usize, number(), 0..3u8).prop_map(|(axis, k, form)| Turn::Rotate(axis, k, form));
    let shift = (0..3usize).prop_map(Turn::Shift);
    let stretch = (number(), number()).prop_map(|(a, b)| Turn::Stretch(a, b));
    if core {
        return prop_oneof![rotate, shift, stretch, Just(Turn::Frame)].boxed();
    }
    prop_oneof![
        2 => rotate,
        1 => shift,
        2 => stretch,
        1 => Just(Turn::Frame),
        2 => (0..3usize).prop_map(Turn::Reflect),
        1 => Just(Turn::Fold),
        1 => (0..3usize).prop_map(Turn::Half),
    ]
    .boxed()
}

fn finish(core: bool, turns: usize) -> impl Strategy<Value = Finish> {
    let turns = move |most: usize| prop::collection::vec(turn(core), 0..=most.min(turns));
    prop_oneof![
        3 => Just(Finish::Flat(1, vec![])),
        4 => Just(Finish::Flat(2, vec![])),
        2 => turns(1).prop_map(|turns| Finish::Flat(3, turns)),
        5 => (0..4u8, turns(2)).prop_map(|(form, turns)| Finish::Direction(form, turns)),
        3 => (0..6u8, turns(2)).prop_map(|(form, turns)| Finish::Surface(form, turns)),
    ]
}

/// Programs: of affine, polar, normalise and rotate only and of depth up to three if `core`, of the whole
/// grammar otherwise.
pub fn plan(core: bool) -> impl Strategy<Value = Plan> {
    finish(core, if core { 1 } else { 2 })
        .prop_flat_map(move |finish| {
            let (two, most) = match &finish {
                Finish::Flat(1, _) => (false, if core { 3 } else { 4 }),
                Finish::Flat(..) => (true, if core { 3 } else { 4 }),
                // Reaching the space is a step of its own, and so is every turn.
                Finish::Direction(_, turns) | Finish::Surface(_, turns) => {
                    (true, if core { 2 - turns.len() } else { 3 })
                }
            };
            let one = (0..3usize, scalar(core)).prop_map(|(i, s)| Step::One(i, s));
            let both = (0..3usize, pair(core)).prop_map(|(i, s)| Step::Two(i, s));
            let step = if two { prop_oneof![3 => one, 2 => both].boxed() } else { one.boxed() };
            let least = usize::from(matches!(finish, Finish::Flat(..)));
            (prop::collection::vec(step, least..=most), Just(finish))
        })
        .prop_flat_map(move |(steps, finish)| {
            (any::<u32>(), prop::bool::weighted(if core { 1.0 } else { 0.9 })).prop_map(
                move |(names, declared)| Plan {
                    steps: steps.clone(),
                    finish: finish.clone(),
                    names,
                    declared,
                },
            )
        })
}
