//! Extremes: any bit pattern into every sampler of the registry, and logarithms of densities that no
//! number holds. The binaries `fuzz` and `stability` try more.

mod files;
mod oracle;
mod report;
mod textbook;

use aether_core::prelude::*;
use aether_core::uniform::clamped;
use aether_core::{DomainError, Pcg32, coin, mixture};
use tests::catalogue::*;
use tests::fuzz::fuzz;
use tests::leaks::{aimed, leaks, room};
use tests::registry::{Item, items};
use tests::stability::{Row, Settings, run};

#[test]
fn any_bit_pattern_is_survived_in_f64() {
    let found = fuzz::<f64>(&items(), 500_000, 1);
    assert_eq!(found.failures, 0, "{:#?}", found.examples);
}

#[test]
fn any_bit_pattern_is_survived_in_f32() {
    let found = fuzz::<f32>(&items(), 500_000, 2);
    assert_eq!(found.failures, 0, "{:#?}", found.examples);
}

#[test]
fn rays_aimed_at_edges_stay_in_closed_rooms() {
    let found = leaks(1_000_000);
    assert_eq!(found.lost, 0, "{:#?}", found.first);
    assert!(found.aimed >= 1_000_000 && found.rays > 3_000_000, "{found:?}");
    // Without a wall many are lost.
    let open = aimed(&room(1.0, 0, 5), 10_000, 3, &mut Pcg32::new(1, 0, 0));
    assert!(open.lost > 500, "{open:?}");
}

/// Half vectors on the horizon, and film points that two maps have rounded over the border of their pixel.
#[test]
fn samples_next_to_a_border_have_a_density() {
    let names = ["refracted_ggx", "renderer: camera, box filter", "renderer: camera, tent filter"];
    let items: Vec<Item> = items().into_iter().filter(|item| names.contains(&item.name)).collect();
    assert_eq!(items.len(), names.len());
    let settings = Settings { single: 5_000, double: 200, sweep: false };
    let rows = run(&items, settings, None, &|_, _| ()).expect("nothing is written");
    for row in rows {
        let Row { precision, false_zeros, examples, .. } = row;
        assert_eq!(false_zeros, 0, "in {precision}: {examples:?}");
    }
}

#[test]
fn any_number_is_a_uniform() {
    assert_eq!(clamped(f32::NAN), 0.0);
    assert_eq!(clamped(f32::NEG_INFINITY), 0.0);
    assert_eq!(clamped(-0.0f32).to_bits(), 0);
    assert_eq!(clamped(f32::INFINITY), 1.0 - f32::EPSILON / 2.0);
    assert_eq!(clamped(1e-300), 1e-300);
}

fn near(found: f64, expected: f64) {
    assert!((found - expected).abs() <= 1e-12 * expected.abs(), "{found} is not {expected}");
}

#[test]
fn densities_below_every_number_have_a_logarithm() -> Result<(), DomainError> {
    near(exponential(2.0).log_pdf(&1e4), 2f64.ln() - 2e4);
    near(laplace(0.5)?.log_pdf(&-1e4), -2e4);
    near(gumbel(0.0, 1.0).log_pdf(&-7.0), 7.0 - 7f64.exp());
    near(weibull(1.0, 2.0).log_pdf(&100.0), 200f64.ln() - 1e4);
    let normal = bivariate_normal(1.0, 0.0, 2.0)?;
    near(normal.log_pdf(&Vec2::new(60.0, 160.0)), -5000.0 - (2.0 * TAU).ln());
    let aside = Direction::new(1.0, 0.0, 0.0);
    near(von_mises_fisher(1e5)?.log_pdf(&aside), (1e5 / TAU).ln() - 1e5);
    let slanted = Direction::new(0.8, 0.0, 0.6);
    near(power_cosine(1e6).log_pdf(&slanted), ((1e6 + 1.0) / TAU).ln() + 1e6 * 0.6f64.ln());
    assert_eq!(exponential(2.0).pdf(&1e4).value(), 0.0);
    assert_eq!(exponential(2.0).log_pdf(&-1.0), f64::NEG_INFINITY);
    let single = exponential(2.0f32).log_pdf(&1e3);
    assert!((single - (2f32.ln() - 2e3)).abs() < 1e-3);
    Ok(())
}

/// The product that an own density is may leave the range of numbers on the way; the density of the point is another one.
#[test]
fn own_densities_that_leave_the_range_on_the_way() -> Result<(), DomainError> {
    let near = |found: f64, expected: f64, tolerance: f64| {
        assert!((found / expected - 1.0).abs() < tolerance, "{found:e} is not {expected:e}");
    };
    near(sinh_arcsinh(5.0, 9.505)?.sample([1e-300]).pdf().value(), 8.975747084632735e-308, 1e-11);
    near(
        kumaraswamy(0.1004995, 0.5)?.sample([1.232595164407831e-32]).pdf().value(),
        4.01328298e281,
        1e-8,
    );
    let small = f64::from(weibull(1f32, 0.5).sample([1e-20]).pdf().value());
    near(small, 5e19, 1e-5);
    Ok(())
}

/// The end of an exponential that grows by more than numbers can.
#[test]
fn exponentials_that_grow_beyond_every_number() {
    let steep = truncated_exponential(-800.0, 1.0);
    for (u, x) in [(1.232595164407831e-32, 0.9081579985758073), (1e-300, 0.13653059012723287)] {
        assert!((steep.sample([u]).value() / x - 1.0).abs() < 1e-15);
    }
}

/// Stretches a line.
#[map(a in 1e-3..)]
fn stretched(x: f64, a: f64) -> f64 {
    a * x
}

#[test]
fn logarithms_of_compositions_and_mixtures() -> Result<(), DomainError> {
    let far = exponential(1.0).then(stretched(4.0)?);
    near(far.log_pdf(&8000.0), -2000.0 - 4f64.ln());
    let both = mixture((exponential(1.0), exponential(2.0)), coin(0.25)).expect("there are two");
    near(both.log_pdf(&2000.0), 0.75f64.ln() - 2000.0);
    let x = normal_sample();
    near(x.log_pdf(), x.pdf().value().ln());
    Ok(())
}

/// Moves a line.
#[map]
fn moved(x: f64, by: f64) -> f64 {
    x + by
}

/// Uniform between two numbers.
#[sampler]
fn between(u: [Uniform; 1], a: f64, b: f64) -> f64 {
    a + (b - a) * u[0]
}

#[test]
fn compositions_know_the_errors_of_their_maps() {
    let at = |a: f32, b: f32| between(a, b).then(moved(1e4));
    // The next number after 10001 is a thousandth away, and so is then the point that has been moved back.
    let beside = 10001f32.next_up();
    assert_eq!(between(0f32, 1.0).pdf(&(beside - 1e4)).value(), 0.0);
    assert_eq!(at(0.0, 1.0).pdf(&beside).value(), 1.0);
    assert_eq!(at(0.0, 1.0).log_pdf(&beside), 0.0);
    assert_eq!(at(0.0, 1.0).pdf(&10001.02).value(), 0.0);
    let twice = at(0.0, 1.0).then(moved(-5e3));
    assert_eq!(twice.pdf(&(beside - 5e3)).value(), 1.0);
    // What another component may have made is not of this one.
    let both = |second| mixture((at(0.0, 1.0), second), coin(0.5f32)).expect("there are two");
    assert_eq!(both(at(1.0, 2.0)).pdf(&beside).value(), 0.5);
    assert_eq!(both(at(5.0, 6.0)).pdf(&beside).value(), 0.5);
}

#[test]
fn a_point_on_a_border_has_the_limit_of_the_density() -> Result<(), DomainError> {
    // Folded: a point next to the border has two preimages.
    near(fold().pdf(&0.0).value(), 1.0);
    near(fold().sample([0.5]).pdf().value(), 1.0);
    for u in [0.5 - 1e-15, 0.5 + 1e-15] {
        near(fold().sample([u]).pdf().value(), 1.0);
    }
    let pole = Direction::new(0.0, 0.0, 1.0);
    near(tests::catalogue::mixture(0.25, 3.0)?.pdf(&pole).value(), 0.25 * 4.0 / TAU + 0.75 / PI);
    // Continued: it has one.
    near(tent(0.5)?.pdf(&0.0).value(), 2.0);
    Ok(())
}

fn normal_sample() -> aether_core::Sample<Exponential<f64>, f64> {
    exponential(3.0).sample([0.3])
}

/// What stable code is made by, a rule each. The samplers are written as in textbooks; the expected numbers are
/// the experts' forms, in which nothing cancels.
mod rules {
    use super::*;

    fn towards(tangent: f64) -> Direction<f64> {
        let length = 1f64.hypot(tangent);
        Direction::new(tangent / length, 0.0, 1.0 / length)
    }

    #[test]
    fn at_the_horizon_the_height_tells_how_far_the_others_are_from_one() -> Result<(), DomainError>
    {
        let alpha = 1e-3f64;
        for z in [0.04f64, 0.1] {
            let s = (1.0 - z * z).sqrt();
            let expected = (1.0 + 2.0 * alpha) / (2.0 * alpha * PI)
                * z
                * ((-z * z).ln_1p() / (2.0 * alpha)).exp();
            // Along a circle x and y say so little of it that many digits of the power are lost.
            for phi in [0.3f64, 1.0, 2.0] {
                let x = Direction::from_unit(Vec3::new(s * phi.cos(), s * phi.sin(), z));
                let found = sheen(alpha)?.pdf(&x).value();
                assert!((found - expected).abs() < 1e-14 * expected, "{found} {expected}");
            }
        }
        Ok(())
    }

    #[test]
    fn half_vectors_of_grazing_views_are_free_of_the_errors_of_lengths() -> Result<(), DomainError>
    {
        let (alpha, height) = (1e-3f64, 1e-4f64);
        let w = Direction::new((1.0 - height * height).sqrt(), 0.0, height);
        for tangent in [3e-5f64, 7e-4, 2e-3] {
            let cosine = 1.0 / 1f64.hypot(tangent);
            let along = (w.x * tangent + w.z) * cosine;
            let twice = 2.0 * along * cosine;
            let x = Direction::from_unit(Vec3::new(twice * tangent - w.x, 0.0, twice - w.z));
            let slope = 1.0 + (tangent / alpha).powi(2);
            let expected =
                1.0 / (PI * alpha * alpha * slope * slope * cosine.powi(3) * 4.0 * along);
            let found = reflected_ggx(alpha, w)?.pdf(&x).value();
            assert!((found - expected).abs() < 1e-13 * expected, "{found} {expected}");
        }
        Ok(())
    }

    #[test]
    fn logarithms_and_powers_next_to_one() {
        let tiny = 2f64.powi(-60);
        near(*exponential(1.0).sample([tiny]), tiny);
        near(*truncated_exponential(1e-12, 1.0).sample([0.25]), 0.25);
        near(truncated_exponential(1e-12, 1.0).pdf(&0.25).value(), 1.00000000000025);
        near(*linear(1.0, 1.0 + 2f64.powi(-40)).unwrap().sample([0.3]), 0.3);
    }

    #[test]
    fn next_to_a_pole_the_small_coordinates_tell_and_at_the_horizon_the_height()
    -> Result<(), DomainError> {
        let (alpha, tangent) = (1e-5f64, 3e-5f64);
        let slope = 1.0 + (tangent / alpha).powi(2);
        let cosine = 1.0 / 1f64.hypot(tangent);
        let expected = 1.0 / (PI * alpha * alpha * cosine.powi(3) * slope * slope);
        let found = ggx(alpha)?.pdf(&towards(tangent)).value();
        // The tangent itself is known to a unit of rounding.
        assert!((found / expected - 1.0).abs() < 1e-14, "{found} is not {expected}");
        let grazing = Direction::new(1.0, 0.0, 1e-12);
        near(cosine_hemisphere().pdf(&grazing).value(), 1e-12 / PI);
        Ok(())
    }

    #[test]
    fn a_sliver_has_its_area() {
        let sliver = 1.0 + 1e-9;
        let origin = Vec3::new(0.0, 0.0, 0.0);
        let (b, c) = (Vec3::new(1.0, 1.0, 1.0), Vec3::new(1.0, 1.0, sliver));
        let found = triangle(origin, b, c).sample([0.3, 0.4]).pdf().value();
        near(found, 2f64.sqrt() / (sliver - 1.0));
    }

    #[test]
    fn a_window_of_angles_goes_across_a_half_turn() -> Result<(), DomainError> {
        let window = zonal_window(-0.5, 0.5, 3.0, 0.5)?;
        for (angle, inside) in [(-3.0, true), (3.1, true), (3.4, true), (2.9, false), (-2.7, false)]
        {
            let at = Direction::new(f64::cos(angle), f64::sin(angle), 0.0);
            assert_eq!(window.pdf(&at).value() > 0.0, inside, "{angle}");
        }
        Ok(())
    }

    #[test]
    fn anchors_are_subtracted_first() {
        let centre = Vec3::new(1e6f32, -1e6, 1e6);
        let sphere = sphere_surface(centre, 0.5);
        for i in 0..100 {
            let sample = sphere.sample([i as f32 / 100.0, (i * 37 % 100) as f32 / 100.0]);
            assert!(sphere.pdf(&sample).value() > 0.0, "{i}");
        }
    }

    #[test]
    fn what_is_no_point_has_no_density_and_every_preimage_counts_once() {
        for x in [f64::NAN, f64::INFINITY, -1.0] {
            assert_eq!(exponential(1.0).pdf(&x).value(), 0.0);
        }
        let count = |x: f64| {
            let mut found = 0;
            fold().preimages(&x, |_, exists| found += usize::from(exists));
            found
        };
        assert_eq!([count(0.5), count(0.25), count(1.5)], [2, 2, 0]);
        near(fold().pdf(&0.25).value(), 1.0);
    }
}

#[test]
fn narrow_lobes_as_printed_have_all_their_samples_in_f32() -> Result<(), DomainError> {
    let g = 1.0 - 2f32.powi(-20);
    let lobe = henyey_greenstein_as_printed(g)?;
    for i in 0..2000 {
        let u = [(i as f32 + 0.5) / 2000.0, (i * 37 % 2000) as f32 / 2000.0];
        let sample = lobe.sample(u);
        assert!(lobe.pdf(&sample).value() > 0.0 && sample.pdf().value() > 0.0, "{u:?}");
    }
    // 1 + g² - 2 g z is (1 - g)² + 2 g (1 - z), and 1 - z is x² / (1 + z).
    let x = 1e-6f32;
    let (g, x2) = (f64::from(g), f64::from(x).powi(2));
    let square = (1.0 - g).powi(2) + g * x2;
    let expected = (1.0 - g * g) / (4.0 * PI * square.powf(1.5));
    let found = f64::from(lobe.pdf(&Direction::new(x, 0.0, 1.0)).value());
    assert!((found / expected - 1.0).abs() < 1e-6, "{found} is not {expected}");
    Ok(())
}

#[test]
fn squares_that_overflow_have_a_root() -> Result<(), DomainError> {
    let line = linear(1e-20f32, 1e20)?;
    let sample = line.sample([0.3]);
    assert!((*sample - 0.3f32.sqrt()).abs() < 1e-6, "{}", *sample);
    assert!((sample.pdf().value() - 2.0 * 0.3f32.sqrt()).abs() < 1e-6);
    Ok(())
}
