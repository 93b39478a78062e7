//! Samplers whose inverse, or whose forward step, has no closed form.
//!
//! Reference values: 60 digits, by bisection of the forward map and the closed formula of the density.

// References are given with seventeen digits.
#![allow(clippy::excessive_precision)]

use aether_core::battery;
use aether_core::prelude::*;
use tests::catalogue::{
    Hyperexponential, Kepler, PlanarFlow, Quintic, Smoothstep, hyperexponential, kepler,
    planar_flow, quintic, smoothstep,
};

/// A logistic variable with the tails of Lambert's W.
#[sampler(h in 0.0..=10.0)]
fn lambert_tail(u: [Uniform; 1], h: f64) -> f64 {
    let z = u[0].ln() - (-u[0]).ln_1p();
    z * (0.5 * h * z * z).exp()
}

/// Student's t with four degrees of freedom, by its distribution function.
#[sampler]
fn student(u: [Uniform; 1]) -> f64 {
    solve(
        |t| {
            let r = 1.0 + t * t / 4.0;
            0.5 + 0.375 * t / r.sqrt() * (1.0 - t * t / (12.0 * r))
        },
        ..,
        u[0],
    )
}

/// Rises to a pole, before which the quarter turn of single precision does not end.
#[sampler]
fn up_to_a_pole(u: [Uniform; 1]) -> f64 {
    let t = FRAC_PI_2 * u[0];
    t.tan() + t
}

/// The same by the equation.
#[sampler]
fn solved_up_to_a_pole(u: [Uniform; 1]) -> f64 {
    solve(|t| t.tan() + t, 0.0..FRAC_PI_2, u[0] / (1.0 - u[0]))
}

/// Between two poles.
#[sampler]
fn between_poles(u: [Uniform; 1]) -> f64 {
    let t = PI * (u[0] - 0.5);
    t.tan() + t
}

/// The raised cosine, whose slope vanishes at both ends.
#[sampler]
fn raised_cosine(u: [Uniform; 1]) -> f64 {
    solve(|z| 0.5 * (1.0 + z + (PI * z).sin() / PI), -1.0..1.0, u[0])
}

/// The second coordinate depends on the first, and neither has a closed inverse.
#[sampler(k in 0.0..=10.0)]
fn chain(u: [Uniform; 2], k: f64) -> Vec2 {
    let x = u[0] + u[0].powi(5);
    let y = u[1] + k * u[0] * u[1].exp();
    Vec2::new(x, y)
}

/// Neither coordinate tells one of the unknowns without the other.
#[sampler(k in 0.0..=0.3)]
fn bent(u: [Uniform; 2], k: f64) -> Vec2 {
    Vec2::new(u[0] + k * u[1].powi(3), u[1] + k * u[0].powi(3))
}

/// The same, where each coordinate increases with the unknown of the other one.
#[sampler(k in 0.0..=0.3)]
fn crossed(u: [Uniform; 2], k: f64) -> Vec2 {
    Vec2::new(u[1].exp() - k * u[0].cos(), u[0] + k * (TAU * u[1]).sin() / TAU)
}

/// A sum of logarithms has a closed inverse.
#[sampler]
fn logistic(u: [Uniform; 1], s: f64) -> f64 {
    s * (u[0].ln() - (-u[0]).ln_1p())
}

fn flow() -> PlanarFlow {
    planar_flow(0.75, Vec2::new(0.5, -2.0), 0.25).unwrap()
}

#[test]
fn inverses_pass_the_battery() {
    for k in [0.0, 0.5, 40.0] {
        battery::check(&quintic(k).unwrap()).assert_ok();
    }
}

#[test]
fn lambert_inverses_and_chains_pass_the_battery() {
    for h in [1e-10, 0.1, 0.5] {
        battery::check(&lambert_tail(h).unwrap()).assert_ok();
    }
    battery::check(&chain(0.0).unwrap()).assert_ok();
    battery::check(&chain(2.0).unwrap()).assert_ok();
}

#[test]
fn implicit_steps_pass_the_battery() {
    battery::check(&smoothstep(0.0, 1.0)).assert_ok();
    battery::check(&smoothstep(2.0, -5.0)).assert_ok();
    for e in [0.0, 0.6, 0.99] {
        battery::check(&kepler(e).unwrap()).assert_ok();
    }
    battery::check(&hyperexponential(0.3, 2.0, 0.1).unwrap()).assert_ok();
    battery::check(&student()).assert_ok();
    battery::check(&raised_cosine()).assert_ok();
}

#[test]
fn coupled_coordinates_pass_the_battery() {
    battery::check(&flow()).assert_ok();
    battery::check(&logistic(2.0)).assert_ok();
}

#[test]
fn coupled_unknowns_have_the_density_of_both_together() {
    for k in [0.0, 0.1, 0.3] {
        for u in [[0.3, 0.6], [0.999, 0.99], [1e-9, 0.5], [0.5, 1e-12]] {
            let sample = bent(k).unwrap().sample(u);
            let expected = 1.0 / (1.0 - (3.0 * k * u[0] * u[1]).powi(2));
            for found in [sample.pdf(), bent(k).unwrap().pdf(&sample)] {
                let off = found.value() / expected - 1.0;
                assert!(off.abs() < 1e-13, "{k} {u:?}: {found:?}, expected {expected:e}");
            }
            let sample = crossed(k).unwrap().sample(u);
            let expected = 1.0 / (u[1].exp() - k * u[0].sin() * k * (TAU * u[1]).cos());
            for found in [sample.pdf(), crossed(k).unwrap().pdf(&sample)] {
                let off = found.value() / expected - 1.0;
                assert!(off.abs() < 1e-13, "{k} {u:?}: {found:?}, expected {expected:e}");
            }
        }
    }
}

/// Next to the ends of both unknowns rounding puts samples out of the support, and one unknown stays at its end while
/// the other one is looked for.
#[test]
fn samples_next_to_the_ends_of_coupled_unknowns_have_their_density() {
    fn check<R: Scalar>(ends: &[R], k: R) {
        for (a, b) in ends.iter().flat_map(|a| ends.iter().map(move |b| (*a, *b))) {
            let (bent, crossed) = (bent(k).unwrap(), crossed(k).unwrap());
            let (one, other) = (bent.sample([a, b]), crossed.sample([a, b]));
            let pairs = [(bent.pdf(&one), one.pdf()), (crossed.pdf(&other), other.pdf())];
            for (found, own) in pairs.map(|(x, y)| (x.value().to_f64(), y.value().to_f64())) {
                let off = (found / own - 1.0).abs();
                assert!(off < 32.0 * R::EPSILON.to_f64(), "{k:?} {a:?} {b:?}: {found}, {own}");
            }
        }
        let large = R::of(1.0 + 1e-3) + k;
        let out = [R::of(-1e-3), large].map(|x| [Vec2::new(x, R::of(0.5)), Vec2::new(large, x)]);
        for point in out.into_iter().flatten().filter(|x| x.x > R::ONE || x.x < R::ZERO) {
            assert_eq!(bent(k).unwrap().pdf(&point).value(), R::ZERO, "{k:?} {point:?}");
        }
    }
    let (last, small) = (LAST, 1.0 - f32::EPSILON / 2.0);
    for i in 0..=60 {
        let double = [0.0, 1e-300, 1e-17, 1e-9, 0.3, 1.0 - 1e-9, last.next_down(), last];
        check::<f64>(&double, 0.005 * f64::from(i));
        let single = [0.0, 1e-30, 1e-9, 1e-4, 0.3, 0.9999, small.next_down(), small];
        check::<f32>(&single, (0.005 * f64::from(i)).min(0.299) as f32);
    }
}

#[test]
fn single_precision() {
    battery::check_f32(&quintic(3.0f32).unwrap()).assert_ok();
    battery::check_f32(&smoothstep(0.0f32, 1.0)).assert_ok();
    battery::check_f32(&kepler(0.6f32).unwrap()).assert_ok();
    battery::check_f32(&hyperexponential(0.25f32, 2.0, 0.125).unwrap()).assert_ok();
}

/// (u, x, density at x, condition of x, condition of the density).
type Row = (f64, f64, f64, f64, f64);

fn agrees<S: Sampler<f64, Uniforms = [f64; 1], Point = f64>>(sampler: &S, rows: &[Row]) {
    for &(u, x, pdf, condition_x, condition_pdf) in rows {
        let limit = |condition: f64| 1e-12 * condition.max(1.0);
        let sample = sampler.sample([u]);
        let error = (sample.value() / x - 1.0).abs();
        assert!(error <= limit(condition_x), "x at {u:e}: {} for {x}", sample.value());
        for p in [sampler.pdf(&x).value(), sample.pdf().value()] {
            let own = if p == sampler.pdf(&x).value() {
                condition_pdf
            } else {
                condition_pdf * condition_x
            };
            assert!((p / pdf - 1.0).abs() <= limit(own), "density at {u:e}: {p:e} for {pdf:e}");
        }
    }
}

const LAST: f64 = 1.0 - 1.1102230246251565e-16;

#[test]
fn reference_values() {
    agrees(
        &quintic(3.0).unwrap(),
        &[
            (1e-12, 1.9999999999995e-12, 0.500_000_000_000_25, 1.0, 1.0),
            (0.7, 1.7348382510621702, 0.19268805504077621, 2.1, 1.3),
        ],
    );
    agrees(&quintic(50.0).unwrap(), &[(LAST, 51.693147180559917, 0.0039761431411530832, 4.9, 1.0)]);
    agrees(&quintic(0.0).unwrap(), &[(0.25, 0.47314355131420976, 0.55555555555555556, 1.0, 1.0)]);
    agrees(
        &lambert_tail(1e-10).unwrap(),
        &[(0.9, 2.1972245778666072, 0.089999999934824732, 4.6, 1.8)],
    );
    agrees(
        &lambert_tail(0.5).unwrap(),
        &[
            (LAST, 1.2452225312552521e148, 4.8467297834989178e-166, 1.7e17, 18.0),
            (1e-6, -7.3051602045196572e21, 1.9611276467640641e-29, 48.0, 6.4),
        ],
    );
    agrees(
        &lambert_tail(0.3).unwrap(),
        &[(1e-9, -1.9627594422396835e29, 8.1319664861672272e-40, 65.0, 9.8)],
    );
    agrees(
        &smoothstep(0.0, 1.0),
        &[
            (0.5, 0.73361474783713553, 1.6498453493880846, 1.0, 2.1),
            (1e-18, 7.9370063097756225e-7, 3.7797621496842894e-12, 1.0, 3.0),
        ],
    );
    agrees(&smoothstep(2.0, 5.0), &[(0.3, 3.7944329600611568, 0.43021717832046006, 1.0, 3.9)]);
    agrees(
        &kepler(1.0 - 1.0 / 1_048_576.0).unwrap(),
        &[(1e-9, 0.0027905844022684616, 7.714795111752769e-7, 2.1e5, 2.1e5)],
    );
    agrees(&kepler(0.99).unwrap(), &[(0.5, PI, 0.31671833675287172, 1.0, 1.0)]);
    agrees(
        &kepler(0.6).unwrap(),
        &[(1e-12, 1.5707963267948965e-11, 0.063661977236758138, 1.5, 1.5)],
    );
    agrees(
        &hyperexponential(0.3, 2.0, 0.1).unwrap(),
        &[
            (0.6, 5.5962612061078963, 0.040007852792708688, 2.7, 1.0),
            (1e-18, 1.492537313432836e-18, 0.66999999999999998, 1.0, 1.0),
        ],
    );
    agrees(
        &hyperexponential(0.0, 1.0, 3.0).unwrap(),
        &[(0.25, 0.095894024150593642, 2.25, 1.2, 1.0)],
    );
    agrees(
        &student(),
        &[
            (0.99, 3.7469473879791958, 0.0086818664474695092, 31.0, 3.9),
            (0.3, -0.56864906304970548, 0.30876445928200917, 1.8, 1.0),
            (1e-3, -7.1731822197823084, 0.00052400860207163141, 1.0, 4.7),
        ],
    );
    agrees(
        &raised_cosine(),
        &[
            (0.7, 0.20715855262069995, 0.89779733856786821, 3.8, 1.0),
            (1e-6, -0.98932661999483361, 2.810625652498493e-4, 1.0, 190.0),
            (0.999, 0.89306723028517916, 0.027949444048855887, 40.0, 17.0),
        ],
    );
}

#[test]
fn reference_values_of_the_flow() {
    let rows = [
        ([0.3, 0.6], [-0.41445831211481798, -1.5717948371238917], 0.043701677285449585),
        ([1e-9, 0.2], [0.091830767373097989, -0.3672252583114999], 0.039824458034217882),
        ([0.999, 0.9], [3.3820496145652548, -3.6847376345902237], 0.00015914519538075168),
    ];
    for (u, [x, y], pdf) in rows {
        let point = flow().sample(u).value();
        assert!(
            (point.x / x - 1.0).abs() < 1e-12 && (point.y / y - 1.0).abs() < 1e-12,
            "{point:?}"
        );
        for p in [flow().pdf(&Vec2::new(x, y)).value(), flow().sample(u).pdf().value()] {
            assert!((p / pdf - 1.0).abs() < 1e-11, "{u:?}: {p:e} for {pdf:e}");
        }
    }
}

#[test]
fn points_that_are_never_sampled() {
    let sampler = quintic(3.0).unwrap();
    for x in [-1e-9, -1.0, 4.8, 1e300, f64::INFINITY, f64::NAN] {
        assert_eq!(sampler.pdf(&x).value(), 0.0, "{x}");
    }
    // Rounding at the border does not count.
    assert!(sampler.pdf(&0.0).value() > 0.0);
    let last = sampler.sample([LAST]).value();
    assert!(sampler.pdf(&last).value() > 0.0);
    let kepler = kepler(0.6).unwrap();
    for x in [-1e-9, 6.3, -1e300, 1e300, f64::NAN] {
        assert_eq!(kepler.pdf(&x).value(), 0.0, "{x}");
    }
}

#[test]
fn only_what_must_be_is_numerical() {
    let inverse = |text: &str| text.contains("root(");
    assert!(inverse(Quintic::<f64>::DERIVATION.inverse));
    assert!(inverse(PlanarFlow::<f64>::DERIVATION.inverse));
    for derivation in [
        Kepler::<f64>::DERIVATION,
        Smoothstep::<f64>::DERIVATION,
        Hyperexponential::<f64>::DERIVATION,
    ] {
        assert!(derivation.forward.contains("root(") && !inverse(derivation.inverse));
        assert!(!inverse(derivation.pdf), "{}", derivation.pdf);
    }
    assert!(inverse(Bent::<f64>::DERIVATION.inverse));
    assert!(!inverse(Logistic::<f64>::DERIVATION.inverse));
}

#[test]
fn ends_that_rounding_puts_beyond_a_pole() {
    for i in 1..200_u16 {
        let u = f32::from(i) / 200.0;
        let (up, between) = (up_to_a_pole().sample([u]), between_poles().sample([u]));
        let [up_again, between_again] =
            [up_to_a_pole().pdf(&*up).value(), between_poles().pdf(&*between).value()];
        for (found, t, width) in [
            ([up.pdf().value(), up_again], FRAC_PI_2 * f64::from(u), FRAC_PI_2),
            ([between.pdf().value(), between_again], PI * (f64::from(u) - 0.5), PI),
        ] {
            let truth = 1.0 / (width * (1.0 + t.cos().powi(-2)));
            for p in found {
                assert!((f64::from(p) / truth - 1.0).abs() < 1e-3, "{u} {t} {p} {truth}");
            }
        }
        let sample = solved_up_to_a_pole().sample([u]);
        let (t, u) = (f64::from(sample.value()), f64::from(u));
        let slope = 1.0 + t.cos().powi(-2);
        let truth = slope / (1.0 + t.tan() + t).powi(2);
        assert!((t.tan() + t - u / (1.0 - u)).abs() < 2e-7 * slope, "{u} {t}");
        // Of the cosine next to the pole the sine tells the square of the distance from it.
        let digits = 1e-5 + 3e-7 / (1.0 - u).powi(2);
        for p in [sample.pdf().value(), solved_up_to_a_pole().pdf(&*sample).value()] {
            assert!((f64::from(p) / truth - 1.0).abs() < digits, "{u} {t} {p} {truth}");
        }
    }
    // Samples in double precision are as they were, also at the ends.
    for u in [1e-9_f64, 0.3, 0.5, 0.999_999] {
        let sample = between_poles().sample([u]);
        let (own, again) = (sample.pdf().value(), between_poles().pdf(&*sample).value());
        let t: f64 = PI * (u - 0.5);
        let truth = 1.0 / (PI * (1.0 + t.cos().powi(-2)));
        for p in [own, again] {
            assert!((p / truth - 1.0).abs() < 1e-6, "{u} {p} {truth}");
        }
    }
}
