//! The comparison of a sampler on lanes with the same sampler on scalars.

use std::fmt::Debug;

use aether_core::lanes::Portable;
use aether_core::{
    Direction, Embedded, Lanes, Map, Mask, Point, Real, Sampler, SurfaceId, SurfacePoint, Vec2,
    Vec3,
};

/// A point made of coordinates as they stand.
pub trait Raw<R: Real>: Point<R> {
    fn raw(c: &[R]) -> Self;
}
impl<R: Real> Raw<R> for R {
    fn raw(c: &[R]) -> Self {
        c[0]
    }
}
impl<R: Real> Raw<R> for Vec2<R> {
    fn raw(c: &[R]) -> Self {
        Vec2::new(c[0], c[1])
    }
}
impl<R: Real> Raw<R> for Vec3<R> {
    fn raw(c: &[R]) -> Self {
        Vec3::new(c[0], c[1], c[2])
    }
}
impl<R: Real> Raw<R> for Direction<R> {
    fn raw(c: &[R]) -> Self {
        Direction::from_unit(Vec3::raw(c))
    }
}
impl<R: Real> Raw<R> for Embedded<2, 3, R> {
    fn raw(c: &[R]) -> Self {
        Embedded([c[0], c[1], c[2]])
    }
}
impl<R: Real> Raw<R> for SurfacePoint<R> {
    fn raw(c: &[R]) -> Self {
        SurfacePoint::new(Vec3::raw(c), SurfaceId(7))
    }
}
impl<R: Real> Raw<R> for (R, Direction<R>) {
    fn raw(c: &[R]) -> Self {
        (c[0], Direction::raw(&c[1..]))
    }
}

/// Whether bits are compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exact {
    Yes,
    No,
}

/// Units in the last place, times the condition number, that the functions of host and lanes may be
/// apart.
const UNITS: f64 = 4.0;

/// What one number of a sampler has: a value, its condition, and what it is.
struct Checker {
    name: &'static str,
    bits: bool,
    worst: f64,
}

impl Checker {
    /// Compares the value of a lane with that of the scalar; `condition` is asked if bits differ.
    fn values(
        &mut self,
        what: &str,
        at: &dyn Debug,
        lane: f32,
        single: f32,
        condition: impl Fn() -> f64,
    ) {
        let same = lane.to_bits() == single.to_bits()
            || lane == single
            || lane.is_nan() && single.is_nan();
        if same {
            return;
        }
        let Checker { name, bits, .. } = self;
        assert!(!*bits, "{name}: {what} at {at:?} is {lane:e} in a lane, {single:e} alone");
        let ulp = f64::from(single.abs().max(f32::MIN_POSITIVE)) * f64::from(f32::EPSILON);
        let condition = condition();
        let error = f64::from((lane - single).abs()) / ulp / condition.max(1.0);
        let error = if error.is_nan() { f64::INFINITY } else { error };
        assert!(
            error <= UNITS,
            "{name}: {what} at {at:?} is {lane:e} in a lane, {single:e} alone: {error:.2} units times \
             the condition number {condition:.2e}"
        );
        self.worst = self.worst.max(error);
    }
}

/// Mixed uniforms: the ends of the unit interval, borders of pieces, and anything between.
fn uniforms<const N: usize>() -> Vec<[f32; N]> {
    let special = [0.0, 0.5, 0.25, 0.75, 1.0 / 3.0, 1e-30, 1.0 - 0.5 * f32::EPSILON, 0.3, 1e-6];
    let mut state = 7u64;
    let mut next = |below: u64| {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) % below
    };
    (0..2048)
        .map(|_| {
            core::array::from_fn(|_| match next(3) {
                0 => special[next(special.len() as u64) as usize],
                _ => next(1 << 24) as f32 / (1 << 24) as f32,
            })
        })
        .collect()
}

/// The samples, points a few roundings away, and points that are no sample: outside, infinite, NaN.
fn points<const N: usize, R: Real, S: Sampler<R, Uniforms = [R; N]>>(sampler: &S) -> Vec<Vec<f32>> {
    let number = |x: &R| x.to_f64() as f32;
    let mut all = Vec::new();
    for (k, u) in uniforms::<N>().into_iter().enumerate() {
        let x = sampler.sample(u.map(|u| R::of(u.into()))).value().coordinates();
        let x: Vec<f32> = x.as_ref().iter().map(number).collect();
        let i = k % x.len();
        let mut y = x.clone();
        y[i] = match k / x.len() % 11 {
            0 => -y[i],
            1 => 2.0 * y[i] + 1.0,
            2 => f32::NAN,
            3 => f32::INFINITY,
            4 => 0.0,
            5 => y[i].next_up(),
            6 => y[i].next_down(),
            7 => y[i].next_down().next_down().next_down(),
            8 => y[i] * (1.0 + 1e-4),
            9 => 1.0,
            _ => -1e30,
        };
        all.extend([x, y]);
    }
    all
}

/// How much larger the relative change of a value is than that of each input it comes from: the change
/// that one unit in the last place of the input makes, in units of the value.
fn conditions(inputs: &[f32], f: impl Fn(&[f64]) -> f64) -> Vec<f64> {
    let mut at: Vec<f64> = inputs.iter().map(|x| f64::from(*x)).collect();
    let value = f(&at);
    let size = value.abs().max(f64::from(f32::MIN_POSITIVE)) * f64::from(f32::EPSILON);
    let mut change = |i: usize, y: f32| {
        at[i] = f64::from(y);
        let change = (f(&at) - value).abs() / size;
        at[i] = f64::from(inputs[i]);
        if change.is_nan() { f64::INFINITY } else { change }
    };
    let each = inputs.iter().enumerate();
    each.map(|(i, x)| change(i, x.next_up()).max(change(i, x.next_down()))).collect()
}

/// The condition with respect to all inputs.
fn condition(inputs: &[f32], f: impl Fn(&[f64]) -> f64) -> f64 {
    conditions(inputs, f).iter().sum()
}

fn lanes<const N: usize>(rows: &[[f32; N]; 8]) -> [Lanes; N] {
    core::array::from_fn(|k| Lanes::new(rows.map(|row| row[k])))
}

/// The condition of coordinate k of a map's image at the sample that it is applied to: the condition of
/// a composition is the sum over its stages.
pub fn condition_after<S, M, const N: usize>(first: &S, map: &M, u: &[f32; N], k: usize) -> f64
where
    S: Sampler<f32, Uniforms = [f32; N]>,
    M: Map<f64, Source: Raw<f64>>,
{
    let x = first.sample(*u).value().coordinates();
    condition(x.as_ref(), |x| map.apply(&Raw::raw(x)).coordinates().as_ref()[k])
}

/// Samples, densities and preimages on lanes, each lane against the scalar. `later` is the condition of
/// the stages that follow the first, for each coordinate.
pub fn compare<const N: usize, S, W, D>(
    name: &'static str,
    exact: Exact,
    (single, wide, fine): (&S, &W, &D),
    later: impl Fn(&[f32; N], usize) -> f64,
) where
    S: Sampler<f32, Uniforms = [f32; N], Point: Raw<f32>>,
    W: Sampler<Lanes, Uniforms = [Lanes; N], Point: Raw<Lanes>>,
    D: Sampler<f64, Uniforms = [f64; N], Point: Raw<f64>>,
{
    let bits = exact == Exact::Yes || cfg!(feature = "portable");
    let mut checker = Checker { name, bits, worst: 0.0 };
    for u in uniforms::<N>().as_chunks::<8>().0 {
        samples(&mut checker, u, (single, wide, fine), &later);
    }
    let all = points(single);
    let mut counts = [0; 2];
    for x in all.as_chunks::<8>().0 {
        let inside = densities(&mut checker, x, single, wide, fine);
        preimages(&mut checker, x, single, wide, fine);
        counts[usize::from(inside != 0 && inside != 8)] += 1;
    }
    assert!(counts[1] > 100, "{name}: only {counts:?} groups of lanes are mixed");
    println!("{name}: {:.2} of {UNITS} units times the condition number", checker.worst);
}

/// Samples, densities and preimages on lanes, each lane against one number with the functions of lanes, to the bit.
pub fn compare_bits<const N: usize, S, W>(name: &'static str, (single, wide): (&S, &W))
where
    S: Sampler<Portable, Uniforms = [Portable; N], Point: Raw<Portable>>,
    W: Sampler<Lanes, Uniforms = [Lanes; N], Point: Raw<Lanes>>,
{
    let same = |what: &str, at: &dyn Debug, lane: f32, alone: Portable| {
        let same = lane.to_bits() == alone.0.to_bits()
            || lane == alone.0
            || lane.is_nan() && alone.0.is_nan();
        assert!(same, "{name}: {what} at {at:?} is {lane:e} in a lane, {:e} alone", alone.0);
    };
    for u in uniforms::<N>().as_chunks::<8>().0 {
        let sample = wide.sample(lanes(u));
        let (x, own) = (sample.value().coordinates(), sample.pdf().value());
        for (i, u) in u.iter().enumerate() {
            let alone = single.sample(u.map(Portable));
            assert_eq!(sample.is_valid().lane(i), alone.is_valid(), "{name}: {u:?}");
            same("sample.pdf()", u, own.lane(i), alone.pdf().value());
            if alone.is_valid() {
                let c = alone.value().coordinates();
                let both = x.as_ref().iter().zip(c.as_ref());
                both.for_each(|(lane, alone)| same("the sample", u, lane.lane(i), *alone));
            }
        }
    }
    for x in points(single).as_chunks::<8>().0 {
        let p = wide.pdf(&point(x)).value();
        let mut found: [Vec<[f32; N]>; 8] = Default::default();
        wide.preimages(&point(x), |u, mask| {
            for i in (0..8).filter(|i| mask.lane(*i)) {
                found[i].push(u.map(|u| u.lane(i)));
            }
        });
        for (i, x) in x.iter().enumerate() {
            let at: Vec<Portable> = x.iter().map(|x| Portable(*x)).collect();
            same("pdf(x)", x, p.lane(i), single.pdf(&Raw::raw(&at)).value());
            let alone = single.invert(&Raw::raw(&at));
            assert_eq!(found[i].len(), alone.iter().count(), "{name}: preimages of {x:?}");
            for (found, alone) in found[i].iter().zip(alone.iter()) {
                found.iter().zip(alone).for_each(|(f, a)| same("a preimage", x, *f, a));
            }
        }
    }
}

fn samples<const N: usize, S, W, D>(
    checker: &mut Checker,
    u: &[[f32; N]; 8],
    (single, wide, fine): (&S, &W, &D),
    later: impl Fn(&[f32; N], usize) -> f64,
) where
    S: Sampler<f32, Uniforms = [f32; N], Point: Raw<f32>>,
    W: Sampler<Lanes, Uniforms = [Lanes; N], Point: Raw<Lanes>>,
    D: Sampler<f64, Uniforms = [f64; N], Point: Raw<f64>>,
{
    let sample = wide.sample(lanes(u));
    let (x, own) = (sample.value().coordinates(), sample.pdf().value());
    let array = |u: &[f64]| core::array::from_fn(|k| u[k]);
    for (i, u) in u.iter().enumerate() {
        let alone = single.sample(*u);
        assert_eq!(sample.is_valid().lane(i), alone.is_valid(), "{}: {u:?}", checker.name);
        if !alone.is_valid() {
            assert_eq!(own.lane(i), 0.0);
            continue;
        }
        let coordinates = alone.value().coordinates();
        let of_sample = |k: usize| {
            condition(u, |u| fine.sample(array(u)).value().coordinates().as_ref()[k]) + later(u, k)
        };
        for (k, c) in coordinates.as_ref().iter().enumerate() {
            checker.values("the sample", u, x.as_ref()[k].lane(i), *c, || of_sample(k));
        }
        // The density may be computed at the sample, which has the errors of the sample.
        checker.values("sample.pdf()", u, own.lane(i), alone.pdf().value(), || {
            let at_sample = conditions(coordinates.as_ref(), |x| fine.pdf(&Raw::raw(x)).value());
            let at_sample = at_sample.iter().enumerate().map(|(k, c)| c * of_sample(k).max(1.0));
            condition(u, |u| fine.sample(array(u)).pdf().value()) + at_sample.sum::<f64>()
        });
    }
}

fn densities<const N: usize, S, W, D>(
    checker: &mut Checker,
    x: &[Vec<f32>; 8],
    single: &S,
    wide: &W,
    fine: &D,
) -> usize
where
    S: Sampler<f32, Uniforms = [f32; N], Point: Raw<f32>>,
    W: Sampler<Lanes, Uniforms = [Lanes; N], Point: Raw<Lanes>>,
    D: Sampler<f64, Uniforms = [f64; N], Point: Raw<f64>>,
{
    let p = wide.pdf(&point(x)).value();
    for (i, x) in x.iter().enumerate() {
        let alone = single.pdf(&Raw::raw(x)).value();
        assert!(p.lane(i) >= 0.0, "{}: the density at {x:?} is {}", checker.name, p.lane(i));
        checker.values("pdf(x)", x, p.lane(i), alone, || {
            condition(x, |x| fine.pdf(&Raw::raw(x)).value())
        });
    }
    p.to_array().iter().filter(|p| **p > 0.0).count()
}

fn preimages<const N: usize, S, W, D>(
    checker: &mut Checker,
    x: &[Vec<f32>; 8],
    single: &S,
    wide: &W,
    fine: &D,
) where
    S: Sampler<f32, Uniforms = [f32; N], Point: Raw<f32>>,
    W: Sampler<Lanes, Uniforms = [Lanes; N], Point: Raw<Lanes>>,
    D: Sampler<f64, Uniforms = [f64; N], Point: Raw<f64>>,
{
    let mut found: [Vec<[f32; N]>; 8] = Default::default();
    wide.preimages(&point(x), |u, mask| {
        for i in (0..8).filter(|i| mask.lane(*i)) {
            found[i].push(u.map(|u| u.lane(i)));
        }
    });
    for (x, found) in x.iter().zip(found) {
        let alone: Vec<[f32; N]> = single.invert(&Raw::raw(x)).iter().collect();
        assert_eq!(found.len(), alone.len(), "{}: preimages of {x:?}", checker.name);
        for (j, (found, alone)) in found.iter().zip(&alone).enumerate() {
            for k in 0..N {
                checker.values("a preimage", x, found[k], alone[k], || {
                    let at = |x: &[f64]| fine.invert(&Raw::raw(x)).iter().nth(j).map(|u| u[k]);
                    condition(x, |x| at(x).unwrap_or(f64::NAN))
                });
            }
        }
    }
}

/// A point of lanes.
fn point<P: Raw<Lanes>>(x: &[Vec<f32>; 8]) -> P {
    let coordinates: Vec<Lanes> =
        (0..x[0].len()).map(|k| Lanes::new(core::array::from_fn(|i| x[i][k]))).collect();
    P::raw(&coordinates)
}
