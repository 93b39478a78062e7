//! Random programs: whatever the compiler accepts of them is right. The oracle is the function as it
//! was written, compiled as plain Rust: its differences, its preimages by search, its samples.
//!
//! `random_programs/programs.rs` is generated; the first test says how if it is out of date.

#[cfg(not(clippy))]
#[rustfmt::skip]
#[path = "random_programs/programs.rs"]
#[allow(missing_docs, unused_parens, unused_variables)]
mod programs;

/// One in their place for lints, which ask no style of generated programs and would look at them for a fifth of
/// their time.
#[cfg(clippy)]
mod programs {
    use super::{Case, case, frame};
    use aether_core::prelude::*;

    #[sampler]
    fn rotated(u: [Uniform; 2], frame: Frame) -> Direction {
        Direction::from_vec(frame.to_world(Vec3::new(u[0], u[1], 1.0).normalize()))
    }

    pub fn all() -> Vec<Case> {
        let plain = |u: [f64; 2]| frame().to_world(Vec3::new(u[0], u[1], 1.0).normalize());
        vec![case("rotated", rotated(frame()), move |u| Direction::from_vec(plain(u)))]
    }
}

use aether_core::battery::{Kind, Space};
use aether_core::prelude::*;
use aether_core::{Pcg32, Uniforms, draw_uniforms};
use tests::forward::{Search, distance, norm, volume};
use tests::points::uniforms;

type Function<T> = Box<dyn Fn(&[f64]) -> T>;

/// A compiled program with its types erased, and the same function as plain Rust.
pub struct Case {
    name: &'static str,
    uniforms: usize,
    kind: Kind,
    plain: Function<Vec<f64>>,
    forward: Function<Vec<f64>>,
    own: Function<f64>,
    pdf: Function<f64>,
    invert: Function<Vec<Vec<f64>>>,
}

fn coordinates<P: Point<f64>>(x: &P) -> Vec<f64> {
    x.coordinates().as_ref().to_vec()
}

fn case<S>(
    name: &'static str,
    sampler: S,
    plain: impl Fn(S::Uniforms) -> S::Point + 'static,
) -> Case
where
    S: Sampler<f64> + 'static,
    S::Point: Space<f64> + 'static,
{
    let model = sampler.sample(S::Uniforms::from_fn(|_| 0.3)).value();
    Case {
        name,
        uniforms: S::Uniforms::COUNT,
        kind: <S::Point as Space<f64>>::KIND,
        plain: Box::new(move |u| coordinates(&plain(uniforms(u)))),
        forward: Box::new(move |u| coordinates(&sampler.forward(uniforms(u)).0)),
        own: Box::new(move |u| sampler.sample(uniforms(u)).pdf().value()),
        pdf: Box::new(move |x| sampler.pdf(&model.moved_to(x)).value()),
        invert: Box::new(move |x| {
            sampler.invert(&model.moved_to(x)).iter().map(|u| u.as_ref().to_vec()).collect()
        }),
    }
}

/// The frame that the programs with such a parameter are given.
fn frame() -> Frame {
    Frame::around(Direction::from_vec(Vec3::new(0.48, 0.64, 0.6)))
}

/// What the checks at single points found.
#[derive(Default)]
struct Tried {
    points: usize,
    folds: usize,
}

impl Case {
    fn plain(&self, u: &[f64]) -> Option<Vec<f64>> {
        Some((self.plain)(u)).filter(|x| x.iter().all(|c| c.is_finite()))
    }

    /// Compares densities, inverse and forward map with the plain function at `count` random points;
    /// the density of the sampler goes through `mutate` first.
    fn check(&self, count: usize, mutate: &dyn Fn(f64, usize) -> f64) -> Result<Tried, String> {
        let f = |u: &[f64]| self.plain(u);
        let search = Search::new(&f, self.uniforms);
        let mut random = Pcg32::new(7, 1, 0);
        let mut tried = Tried::default();
        for _ in 0..count {
            let drawn: [f64; 3] = draw_uniforms(&mut random);
            let u: Vec<f64> = drawn[..self.uniforms].iter().map(|u| 0.001 + 0.998 * u).collect();
            let x = f(&u).ok_or_else(|| format!("no value at {u:?}"))?;
            let compiled = (self.forward)(&u);
            let scale = 1.0 + norm(&x);
            if distance(&x, &compiled) > 1e-12 * scale {
                return Err(format!("{u:?} maps to {x:?} and, compiled, to {compiled:?}"));
            }
            let found = (self.invert)(&x);
            // The sample's own uniforms are exact, inverted ones nearly so, and those of the search
            // as good as the slope of the map allows.
            let mut all = vec![u.clone()];
            let known = |all: &[Vec<f64>], u: &[f64]| all.iter().any(|v| distance(u, v) < 1e-6);
            for v in &found {
                let back = f(v).map_or(f64::INFINITY, |y| distance(&x, &y));
                if back > 1e-7 * scale {
                    return Err(format!("{x:?} has the preimage {v:?}, which maps {back:e} away"));
                }
                if !known(&all, v) {
                    all.push(v.clone());
                }
            }
            for v in search.preimages(&x) {
                if !known(&all, &v) {
                    all.push(v);
                }
            }
            let Some((expected, error)) = density(&f, &all) else { continue };
            if !known(&found, &u) {
                return Err(format!("{u:?} maps to {x:?}, which has the preimages {found:?}"));
            }
            for p in [(self.own)(&u), (self.pdf)(&x)] {
                let gap = (mutate(p, all.len()) / expected - 1.0).abs();
                // A NaN is not right.
                let agrees = gap <= 1e-6 + 10.0 * error;
                if !agrees {
                    return Err(format!(
                        "{x:?} of {u:?} has density {p}, by differences {expected} (relative error \
                         {error:.0e}); preimages {found:?}, by search {all:?}"
                    ));
                }
            }
            tried.points += 1;
            tried.folds += usize::from(all.len() > 1);
        }
        if tried.points < count / 4 {
            Err(format!("only {} points", tried.points))
        } else {
            Ok(tried)
        }
    }
}

/// The sum of 1/√det(JᵀJ) over preimages with its relative error; `None` where differences do not
/// decide: next to a kink or a border, or where the map is so flat that a preimage is not determined.
fn density(f: &dyn Fn(&[f64]) -> Option<Vec<f64>>, preimages: &[Vec<f64>]) -> Option<(f64, f64)> {
    let (mut sum, mut worst) = (0.0, 0.0_f64);
    for u in preimages {
        if u.iter().any(|u| !(1e-3..=0.999).contains(u)) {
            return None;
        }
        let (stretch, error) = volume(f, u)?;
        let precise = error < 1e-6;
        if stretch < 1e-5 || !precise {
            return None;
        }
        sum += 1.0 / stretch;
        worst = worst.max(error);
    }
    Some((sum, worst))
}

const POINTS: usize = 100;

#[test]
fn the_file_is_what_the_generator_writes() {
    let file = include_str!("random_programs/programs.rs");
    assert!(
        file == tests::programs::file(),
        "the programs are out of date: `cargo run -p tests --bin random_programs`"
    );
    let refused = file.matches(" is refused: ").count();
    let all = tests::programs::CORE + tests::programs::WIDE;
    assert!(all - refused >= 200 && 10 * refused <= all, "{refused} of {all} are refused");
    // Of affine, polar, normalise and rotate nothing is.
    let core = file.matches("// core_").count();
    assert!(core == 0, "{core} programs of the core are refused");
}

/// The density of every second program is that of differences; one that is off by one percent, or misses a
/// preimage, is not.
fn densities_of_half(first: usize) {
    let (mut folds, mut wrong) = (0, Vec::new());
    let cases = programs::all();
    for case in cases.iter().skip(first).step_by(2) {
        assert!(case.check(POINTS, &|p, _| 1.01 * p).is_err(), "{}: 1 %", case.name);
        match case.check(POINTS, &|p, _| p) {
            Ok(Tried { folds: 0, .. }) => {}
            Ok(_) => {
                folds += 1;
                let dropped = |p: f64, n: usize| if n > 1 { p * (1.0 - 1.0 / n as f64) } else { p };
                assert!(case.check(POINTS, &dropped).is_err(), "{}: dropped", case.name);
            }
            Err(message) => wrong.push(format!("{}: {message}", case.name)),
        }
    }
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), cases.len(), wrong.join("\n"));
    assert!(folds >= 10, "only {folds} programs have points with several preimages");
}

// Two tests, for two threads.

#[test]
fn densities_of_even_programs_are_those_of_differences() {
    densities_of_half(0);
}

#[test]
fn densities_of_odd_programs_are_those_of_differences() {
    densities_of_half(1);
}

#[path = "random_programs/mass.rs"]
mod mass;
