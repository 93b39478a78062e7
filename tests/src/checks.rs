//! What tests say of samplers in one line.

use aether_core::battery::{Battery, Report, Space, Verdict};
use aether_core::prelude::{Direction, Vec3};
use aether_core::{DomainError, Sampler, Scalar};

use crate::mutation::OnePercentOff;

/// The sampler, whose parameters are in their domain.
///
/// # Panics
/// If they are not.
pub fn right<T>(made: Result<T, DomainError>) -> T {
    made.expect("the parameters are in their domain")
}

/// The battery with all its checks, for points that lie on a manifold or are several at once: over a parametrisation by the
/// unit cube, and by its inverse. A density that is off by one percent must not have the mass of the samples.
///
/// The test of samples against the density fails for one seed in a million, and its seed is fixed.
///
/// # Panics
/// If a check fails or is left out.
pub fn covered<S: Sampler<f64>>(
    sampler: S,
    cover: impl Fn(&[f64]) -> S::Point,
    place: impl Fn(&[f64]) -> Vec<f64>,
) where
    S::Point: Space<f64>,
{
    covered_by(sampler, [40_000, 200_000], cover, place);
}

/// The same with so many samples and evaluations of the density.
///
/// # Panics
/// If a check fails or is left out.
pub fn covered_by<S: Sampler<f64>>(
    sampler: S,
    [samples, evaluations]: [usize; 2],
    cover: impl Fn(&[f64]) -> S::Point,
    place: impl Fn(&[f64]) -> Vec<f64>,
) where
    S::Point: Space<f64>,
{
    let report = Battery::new(&sampler)
        .samples(samples)
        .evaluations(evaluations)
        .parametrised(&cover)
        .located(place)
        .run();
    let passed = report.findings().iter().all(|f| f.verdict == Verdict::Passed);
    assert!(passed, "{report}");
    let off = OnePercentOff(sampler);
    let off: Report =
        Battery::new(&off).samples(samples).evaluations(evaluations).parametrised(cover).run();
    assert!(off.failures().any(|f| f.check == "mass"), "{off}");
}

/// The battery for directions in which the rectangle with the corners (x0, y0, z0) and (x1, y1, z0) is seen, over the plane
/// of the rectangle: there the cubature can end its cells where the rectangle ends. On the sphere its sides lie slanted
/// in them, and by chance it stays coarse. Twice as much of the plane is looked at as the rectangle has in each direction.
///
/// # Panics
/// If a check fails.
pub fn seen_in_its_plane<R: Scalar, S>(sampler: &S, [x0, y0, x1, y1, z0]: [f64; 5])
where
    S: Sampler<R, Point = Direction<R>>,
    Direction<R>: Space<R>,
{
    let wide = |t: f64, low: f64, high: f64| low + (2.0 * t - 0.5) * (high - low);
    let cover = |t: &[f64]| {
        let corner = [wide(t[0], x0, x1), wide(t[1], y0, y1), z0].map(R::of);
        Direction::from_vec(Vec3::new(corner[0], corner[1], corner[2]).normalize())
    };
    let place = |w: &[f64]| {
        let narrow =
            |x: f64, low: f64, high: f64| 0.25 + 0.5 * (x * z0 / w[2] - low) / (high - low);
        vec![narrow(w[0], x0, x1), narrow(w[1], y0, y1)]
    };
    let battery = Battery::<_, R>::new(sampler).parametrised(cover).located(place);
    battery.jumps(0, [0.25, 0.75]).jumps(1, [0.25, 0.75]).run().assert_ok();
}

/// A module of tests for each line, `name: sampler, sampler, ...;`. The list before says which tests:
/// the battery in `double` and in `single` precision, and that it fails where the density is off by one
/// percent, `off`.
#[macro_export]
macro_rules! batteries {
    (@double $($sampler:expr),+) => {
        #[test]
        fn double_precision() {
            $(::aether_core::battery::check(&$sampler).assert_ok();)+
        }
    };
    (@single $($sampler:expr),+) => {
        #[test]
        fn single_precision() {
            // How much mass there is, and where, is told in double precision.
            $({
                let sampler = $sampler;
                let battery = ::aether_core::battery::Battery::<_, f32>::new(&sampler);
                battery.samples(50_000).run().assert_ok();
            })+
        }
    };
    (@off $($sampler:expr),+) => {
        #[test]
        fn one_percent_off() {
            $({
                let off = $crate::mutation::OnePercentOff($sampler);
                assert!(::aether_core::battery::Battery::<_, f64>::new(&off).fails());
            })+
        }
    };
    (@line [$($kind:ident)+] $samplers:tt) => {
        $($crate::batteries! { @unpack $kind $samplers })+
    };
    (@unpack $kind:ident [$($sampler:expr),+]) => {
        $crate::batteries! { @$kind $($sampler),+ }
    };
    ($kinds:tt $($name:ident: $($sampler:expr),+;)*) => {
        $(mod $name {
            #[allow(unused_imports)]
            use super::*;
            $crate::batteries! { @line $kinds [$($sampler),+] }
        })*
    };
}
