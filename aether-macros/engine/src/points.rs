//! Points to try an item on while it is compiled: uniforms with their extremes, parameters over
//! their domains.

use std::ops::Range;

use crate::expr::Leaf;
use crate::interval::Interval;
use crate::number::{Dd, Number};

/// What a group of scalar parameters is.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// A number with the interval that it is declared (or taken) to lie in.
    Scalar(Option<Interval>),
    /// A whole number of this interval.
    Whole(Interval),
    /// A vector with this many coordinates.
    Vector(usize),
    /// A unit vector.
    Direction,
    /// A matrix, nine numbers by columns.
    Matrix,
    /// An orthonormal matrix, nine numbers by columns.
    Frame,
}

impl Kind {
    /// How many scalars it takes.
    pub fn scalars(&self) -> usize {
        match self {
            Kind::Scalar(_) | Kind::Whole(_) => 1,
            Kind::Vector(n) => *n,
            Kind::Direction => 3,
            Kind::Matrix | Kind::Frame => 9,
        }
    }
}

/// Groups of scalar parameters with the places of their numbers.
pub fn placed(kinds: &[Kind]) -> impl Iterator<Item = (&Kind, Range<usize>)> {
    let mut first = 0;
    kinds.iter().map(move |kind| {
        let place = first..first + kind.scalars();
        first = place.end;
        (kind, place)
    })
}

/// One point: values of the unknowns and of the scalar parameters.
#[derive(Clone, Debug)]
pub struct Point {
    /// Unknowns in order; in double-double, so that unit vectors have unit length.
    pub unknowns: Vec<Dd>,
    /// Scalar parameters in order.
    pub params: Vec<Dd>,
    /// Whether no unknown is close to an end of its range.
    pub interior: bool,
    /// Whether parameters are larger or smaller than the map may be meant for, because nothing was
    /// declared of them: good for comparing forms, but no test of the map.
    pub stress: bool,
    /// Whether directions graze, so that it is good for comparing forms of the inverse, in which half vectors are sums of
    /// nearly opposite ones.
    pub grazing: bool,
    /// Whether a uniform is zero or several are next to their ends: good for comparing forms of the sample and of its own
    /// density, but rounding the sample may leave nothing of the other uniforms, as it does of an azimuth at a pole.
    pub corner: bool,
}

impl Point {
    /// A point inside of the domain, with parameters that the map is meant for.
    fn inside(unknowns: Vec<Dd>, params: Vec<Dd>) -> Point {
        Point { unknowns, params, interior: true, stress: false, grazing: false, corner: false }
    }

    /// The value of an input; outputs come from `outs`.
    pub fn input(&self, leaf: Leaf, outs: &[Dd]) -> Dd {
        let (list, i) = match leaf {
            Leaf::Unknown(i) => (&self.unknowns[..], i),
            Leaf::Param(i) => (&self.params[..], i),
            Leaf::Out(i) => (outs, i),
            Leaf::Bound(_) => return Dd::from_f64(f64::NAN),
        };
        list.get(i as usize).copied().unwrap_or(Dd::from_f64(f64::NAN))
    }

    /// The same with numbers that single precision has, uniforms below one; `None` if a parameter leaves its
    /// domain. Of unit vectors this is left to those who evaluate: they would not have unit length.
    pub fn in_single(&self, kinds: &[Kind], argument: Option<&Kind>) -> Option<Point> {
        let round = |x: Dd| Dd::from_f64(f64::from(x.to_f64() as f32));
        let below_one = Dd::from_f64(1.0 - f64::from(f32::EPSILON) / 2.0);
        let unknowns = self.unknowns.iter().map(|&u| match argument {
            None => Number::min(round(u), below_one),
            Some(Kind::Direction) => u,
            Some(_) => round(u),
        });
        let mut point = Point { unknowns: unknowns.collect(), ..self.clone() };
        for (kind, place) in placed(kinds) {
            if matches!(kind, Kind::Direction | Kind::Frame) {
                continue;
            }
            for x in &mut point.params[place] {
                *x = round(*x);
                let legal = |x: f64| match kind {
                    Kind::Scalar(Some(d)) | Kind::Whole(d) => d.lo <= x && x <= d.hi,
                    _ => true,
                };
                if !x.is_finite() || !legal(x.to_f64()) {
                    return None;
                }
            }
        }
        Some(point)
    }

    /// The unknowns in double precision, for messages.
    pub fn shown(&self) -> Vec<f64> {
        self.unknowns.iter().map(|u| u.to_f64()).collect()
    }
}

/// A small deterministic generator (splitmix64), the same on every machine.
pub struct Rng(u64);

impl Rng {
    /// A generator with a seed.
    pub fn new(seed: u64) -> Rng {
        Rng(seed)
    }
    /// A number in (0, 1).
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64 + 0.5 / (1u64 << 53) as f64
    }
}

/// Uniforms that are tried in every position: both ends approached, and the middle.
const EXTREMES: [f64; 6] =
    [8.673617379884035e-19, 1e-9, 0.5, 0.999, 1.0 - 1e-9, 1.0 - 1.1102230246251565e-16];

/// Rounds of points with parameters of their own; a few more follow with stress.
const ROUNDS: usize = 8;
/// The one of them whose parameters are close to zero, if zero lies inside of their domain.
const LEAST: usize = 6;

/// Uniforms of corners, where several are next to an end.
const ENDS: [f64; 5] = [0.0, 1.0 - 1.1102230246251565e-16, 8.673617379884035e-19, 1e-9, 1.0 - 1e-9];

/// Rounds in which parameters that are vectors are larger or smaller than others, after those with stress for numbers.
const SIZES: [f64; 3] = [1e3, 1e6, 1e-6];

/// Enough points where a condition narrows the choice.
const ENOUGH: usize = 80;
/// Rounds with directions next to the horizon, where half vectors are sums of nearly opposite ones.
const GRAZING: usize = 5;
/// How far above it.
const HEIGHTS: [f64; GRAZING] = [1e-2, 1e-3, 1e-4, 1e-6, 1e-5];

/// Rounds that are tried for them; in the later ones, undeclared parameters are of any size and sign. If none of them passes, as
/// many follow with others at any distance from an end of their domain, or from zero: next to it alone a branch may be taken.
const MOST_ROUNDS: usize = 400;
const WILD: usize = 40;

/// The points for an item with `unknowns` uniforms and these parameters. With `guarded`, those that
/// `accept` lets pass; it may change parameters that others decide about.
pub fn sampler_points(
    unknowns: usize,
    kinds: &[Kind],
    guarded: bool,
    accept: &dyn Fn(&mut Point) -> bool,
) -> Vec<Point> {
    let mut rng = Rng::new(0xae7e);
    let mut ends = Rng::new(0xe4d5);
    let mut points = Vec::new();
    let accepted = |mut made: Vec<Point>| {
        made.retain_mut(|point| !guarded || accept(point));
        made
    };
    let open = |kind: &Kind| match kind {
        Kind::Scalar(domain) => domain.is_none_or(|d| d.hi == f64::INFINITY),
        Kind::Whole(domain) => domain.hi == f64::INFINITY,
        _ => false,
    };
    let few = if kinds.iter().any(open) { ROUNDS + 4 } else { ROUNDS };
    let rounds = if guarded { 2 * MOST_ROUNDS } else { few };
    for round in 0..rounds {
        let found = points.iter().filter(|p: &&Point| !p.stress).count();
        if round >= few && found >= ENOUGH || round == MOST_ROUNDS && found > 0 {
            break;
        }
        let stress = (ROUNDS..few).contains(&round);
        let params = parameters(&mut rng, kinds, round);
        let mut made = around(&mut rng, unknowns, round, &params, stress);
        if round < few {
            made.extend(corners(&mut ends, unknowns, round, &params));
        }
        points.extend(accepted(made));
    }
    for (round, size) in SIZES.into_iter().enumerate() {
        let mut params = parameters(&mut ends, kinds, 2 + round);
        if scale_vectors(&mut params, kinds, size) {
            let made = around(&mut ends, unknowns, round, &params, true).into_iter();
            points.extend(accepted(made.step_by(2).collect()));
        }
    }
    if kinds.contains(&Kind::Direction) {
        for round in 0..2 * GRAZING {
            let mut params = parameters(&mut rng, kinds, round);
            lower(&mut params, kinds, [0.0, 0.0, 1.0].map(Dd::from_f64), round);
            let made = around(&mut rng, unknowns, round, &params, true);
            let made = made.into_iter().map(|point| Point { grazing: true, ..point });
            points.extend(accepted(made.collect()));
        }
    }
    points
}

/// Brings parameters that are directions next to the plane with this normal; each second one in a plane of two axes, as
/// views of isotropic materials often are: there every coordinate of a small sum is exact.
fn lower(params: &mut [Dd], kinds: &[Kind], normal: [Dd; 3], round: usize) {
    let height = Dd::from_f64(HEIGHTS[round % GRAZING]);
    for (kind, place) in placed(kinds) {
        if *kind == Kind::Direction {
            let w: [Dd; 3] = std::array::from_fn(|i| params[place.start + i]);
            let above = w[0] * normal[0] + w[1] * normal[1] + w[2] * normal[2];
            let level = if round.is_multiple_of(2) {
                cross([0.0, 1.0, 0.0].map(Dd::from_f64), normal)
            } else {
                std::array::from_fn(|i| w[i] - above * normal[i])
            };
            let height = if above.to_f64() < 0.0 { Dd::from_f64(0.0) - height } else { height };
            let level = normalise(level);
            let lowered = normalise(std::array::from_fn(|i| level[i] + height * normal[i]));
            params[place].copy_from_slice(&lowered);
        }
    }
}

/// Random uniforms, and some with one at an extreme.
fn around(rng: &mut Rng, unknowns: usize, round: usize, params: &[Dd], stress: bool) -> Vec<Point> {
    let mut points = Vec::new();
    for _ in 0..4 {
        let unknowns = (0..unknowns).map(|_| Dd::from_f64(0.02 + 0.96 * rng.uniform())).collect();
        points.push(Point { stress, ..Point::inside(unknowns, params.to_vec()) });
    }
    for (k, e) in EXTREMES.iter().enumerate() {
        let position = k % unknowns.max(1);
        let interior = *e == 0.5;
        let mut u: Vec<f64> = (0..unknowns).map(|_| 0.05 + 0.9 * rng.uniform()).collect();
        if let Some(x) = u.get_mut(position) {
            *x = *e;
        }
        if round % 2 == 1 && unknowns > 1 {
            u.rotate_right(1);
        }
        let unknowns = u.into_iter().map(Dd::from_f64).collect();
        points.push(Point { interior, stress, ..Point::inside(unknowns, params.to_vec()) });
    }
    points
}

/// A point with one uniform of zero, and one with all of them next to ends.
fn corners(rng: &mut Rng, unknowns: usize, round: usize, params: &[Dd]) -> Vec<Point> {
    let mut all = Vec::new();
    for several in [false, true] {
        let mut u: Vec<f64> = (0..unknowns).map(|_| 0.05 + 0.9 * rng.uniform()).collect();
        for (i, u) in u.iter_mut().enumerate() {
            let pick = (rng.uniform() * ENDS.len() as f64) as usize;
            match several {
                true => *u = ENDS[pick],
                false if i == round % unknowns => *u = 0.0,
                false => {}
            }
        }
        let unknowns = u.into_iter().map(Dd::from_f64).collect();
        let inside = Point::inside(unknowns, params.to_vec());
        all.push(Point { interior: false, stress: true, corner: true, ..inside });
    }
    all
}

/// A point with numbers that nothing was declared of, each of a random sign and at least one of them another than before; `None`
/// if there are no such numbers.
pub fn with_other_signs(point: &Point, kinds: &[Kind], rng: &mut Rng) -> Option<Point> {
    let open: Vec<usize> =
        placed(kinds).filter(|(kind, _)| is_open(kind)).map(|(_, place)| place.start).collect();
    let certain = (rng.uniform() * open.len() as f64) as usize;
    let mut params = point.params.clone();
    for (k, &i) in open.iter().enumerate() {
        if k == certain || rng.uniform() < 0.5 {
            params[i] = -params[i];
        }
    }
    (!open.is_empty()).then(|| Point { params, stress: true, ..point.clone() })
}

/// Whether it is a number that nothing was declared of.
fn is_open(kind: &Kind) -> bool {
    matches!(kind, Kind::Scalar(domain) if domain.is_none_or(|d| d == Interval::ALL))
}

/// Makes parameters that are vectors larger by a factor; whether there are any.
fn scale_vectors(params: &mut [Dd], kinds: &[Kind], factor: f64) -> bool {
    for (kind, place) in placed(kinds) {
        if matches!(kind, Kind::Vector(_)) {
            params[place].iter_mut().for_each(|x| *x = *x * Dd::from_f64(factor));
        }
    }
    kinds.iter().any(|kind| matches!(kind, Kind::Vector(_)))
}

/// The points for a map whose argument has these coordinates.
pub fn map_points(
    argument: &Kind,
    kinds: &[Kind],
    guarded: bool,
    accept: &dyn Fn(&mut Point) -> bool,
) -> Vec<Point> {
    let mut rng = Rng::new(0x3a9);
    let mut points = Vec::new();
    for round in 0..if guarded { 10 * MOST_ROUNDS } else { 40 } {
        if guarded && points.len() >= ENOUGH {
            break;
        }
        let params = parameters(&mut rng, kinds, round % 8);
        let unknowns = parameters(&mut rng, std::slice::from_ref(argument), round % 8);
        let mut point = Point::inside(unknowns, params);
        if !guarded || accept(&mut point) {
            points.push(point);
        }
    }
    if *argument == Kind::Direction && kinds.contains(argument) {
        for round in 0..2 * GRAZING {
            let mut params = parameters(&mut rng, kinds, round);
            let argument = unit(&mut rng);
            lower(&mut params, kinds, argument, round);
            let inside = Point::inside(argument.to_vec(), params);
            let mut point = Point { stress: true, grazing: true, ..inside };
            if !guarded || accept(&mut point) {
                points.push(point);
            }
        }
    }
    points
}

fn parameters(rng: &mut Rng, kinds: &[Kind], round: usize) -> Vec<Dd> {
    let mut out = Vec::new();
    for kind in kinds {
        match kind {
            Kind::Scalar(domain) => out.push(Dd::from_f64(scalar(rng, *domain, round))),
            Kind::Whole(domain) => {
                out.push(Dd::from_f64(libm::rint(scalar(rng, Some(*domain), round))));
            }
            Kind::Vector(n) => out.extend((0..*n).map(|_| Dd::from_f64(4.0 * rng.uniform() - 2.0))),
            Kind::Matrix => {
                // Well conditioned: a random matrix with a strong diagonal.
                out.extend((0..9).map(|i| {
                    Dd::from_f64(rng.uniform() - 0.5 + if i % 4 == 0 { 1.6 } else { 0.0 })
                }));
            }
            Kind::Direction => out.extend(unit(rng)),
            Kind::Frame => {
                let z = unit(rng);
                let a = unit(rng);
                let x = normalise(cross(a, z));
                let y = cross(z, x);
                out.extend(x.into_iter().chain(y).chain(z));
            }
        }
    }
    out
}

fn scalar(rng: &mut Rng, domain: Option<Interval>, round: usize) -> f64 {
    let Some(d) = domain.filter(|d| *d != Interval::ALL) else {
        // Hundreds or hundredths under stress, then the same of billions.
        let moderate = 0.3 + 3.0 * rng.uniform();
        let size = if round < ROUNDS + 2 { 1e2 } else { 1e9 };
        return match round {
            0..ROUNDS => moderate,
            WILD.. => {
                let size = libm::exp2(40.0 * rng.uniform() - 30.0);
                if round.is_multiple_of(2) { -size } else { size }
            }
            _ if round.is_multiple_of(2) => size * moderate,
            _ => moderate / size,
        };
    };
    let lo = if d.lo.is_finite() { d.lo } else { -10.0f64.max(d.hi.abs()) };
    let hi = if d.hi.is_finite() { d.hi } else { 10.0f64.max(2.0 * lo) };
    match round {
        MOST_ROUNDS.. => {
            let near = (hi - lo) * libm::exp2(-60.0 * rng.uniform());
            match round % 4 {
                0 => lo + near,
                1 => hi - near,
                k if lo < 0.0 && hi > 0.0 => (if k == 2 { near } else { -near }).clamp(lo, hi),
                _ => lo + (hi - lo) * rng.uniform(),
            }
        }
        // What is declared without an upper end may be very large.
        ROUNDS.. if d.hi == f64::INFINITY && round < ROUNDS + 4 => {
            hi * libm::pow(1e3, (round - ROUNDS + 1) as f64) * (0.5 + rng.uniform())
        }
        // What may be zero may be close to it.
        LEAST if d.lo < 0.0 && d.hi > 0.0 => 1e-9 * (lo + (hi - lo) * rng.uniform()),
        0 if d.lo.is_finite() && d.lo != 0.0 => lo,
        1 if d.hi.is_finite() && d.hi != 0.0 => hi,
        _ if lo > 0.0 => lo * libm::pow(hi / lo, rng.uniform()),
        _ => lo + (hi - lo) * rng.uniform(),
    }
}

/// A random unit vector.
pub fn unit(rng: &mut Rng) -> [Dd; 3] {
    loop {
        let v: [f64; 3] = std::array::from_fn(|_| 2.0 * rng.uniform() - 1.0);
        let n = v.iter().map(|x| x * x).sum::<f64>();
        if n > 0.05 && n < 1.0 {
            return normalise(v.map(Dd::from_f64));
        }
    }
}

fn normalise(v: [Dd; 3]) -> [Dd; 3] {
    let n = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    v.map(|x| x / n)
}

fn cross(a: [Dd; 3], b: [Dd; 3]) -> [Dd; 3] {
    std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        a[j] * b[k] - a[k] * b[j]
    })
}
