//! Lanes against scalars: every lane has what `f32` has on the same input.
//!
//! Where a sampler is made of arithmetic, square roots and choices alone, bits are compared. Elsewhere
//! the functions of lanes are those of this project and the functions of `f32` those of the host, each
//! off by up to one unit in the last place: then values may differ by 4 units times the condition
//! number, which is what one unit in the last place of each input changes, in units of the output, found
//! in double precision (for a composition, the sum over its stages). With the feature `portable`, both
//! have the same functions, and bits are compared everywhere.
//!
//! Without that feature, bits are compared with `Portable`, one number with the functions of lanes.

mod compare;
mod samplers;

use aether_core::lanes::Portable;
use aether_core::prelude::*;
use aether_core::{LaneMask, Lanes, Mask};
use compare::{Exact, compare, compare_bits, condition_after};
use samplers::*;
use tests::catalogue::easy::*;
use tests::catalogue::{hyperexponential, kepler, normal, smoothstep, upper_normal};
use tests::checks::right;

/// One test a sampler: whether bits are compared, the number of uniforms, and the sampler, with a
/// function that makes a parameter of a number.
macro_rules! samplers {
    ($($name:ident: $exact:ident $n:literal |$r:ident| $make:expr;)*) => {
        $(#[test]
        fn $name() {
            fn make<R: Real>() -> impl Sampler<R, Uniforms = [R; $n], Point: compare::Raw<R>> {
                #[allow(unused)]
                let $r = |x: f64| R::of(x);
                $make
            }
            let (single, wide, fine) = (make::<f32>(), make::<Lanes>(), make::<f64>());
            compare(stringify!($name), Exact::$exact, (&single, &wide, &fine), |_, _| 0.0);
            compare_bits(stringify!($name), (&make::<Portable>(), &wide));
        })*
    };
}

fn v<R: Real>(x: f64, y: f64, z: f64) -> Vec3<R> {
    Vec3::new(R::of(x), R::of(y), R::of(z))
}

fn tilted<R: Real>() -> Frame<R> {
    Frame::around(Direction::from_vec(v(0.3, -0.5, -0.7)))
}

samplers! {
    intervals: Yes 1 |r| affine(r(-1.5), r(2.25));
    powers: No 1 |r| power(r(2.7));
    exponentials: No 1 |r| exponential(r(3.0));
    truncated_exponentials: No 1 |r| truncated_exponential(r(3.0), r(0.5));
    ramps: Yes 1 |r| right(linear(r(0.25), r(3.0)));
    weibulls: No 1 |r| weibull(r(2.0), r(1.5));
    gumbels: No 1 |r| gumbel(r(0.5), r(2.0));
    softplus_logistics: No 1 |_r| softplus_logistic();
    polar_disks: No 2 |r| polar_disk(r(2.0));
    pairs_of_logistics: No 2 |r| affine_logistics(r(1.0), r(0.5), r(-0.25), r(2.0), r(0.5), r(-3.0));
    spheres: No 2 |_r| uniform_sphere();
    equirectangulars: No 2 |_r| equirectangular();
    hemispheres: No 2 |_r| uniform_hemisphere();
    cosine_hemispheres: No 2 |_r| cosine_hemisphere();
    power_cosines: No 2 |r| power_cosine(r(10.0));
    spheres_in_space: No 2 |r| sphere_surface(v(1.0, -2.0, 0.5), r(3.0));
    height_fields: No 2 |r| height_field(r(0.5));
    tents: Yes 1 |r| tent(r(2.0));
    laplaces: No 1 |r| laplace(r(0.7));
    folds: Yes 1 |_r| fold();
    saws: Yes 1 |_r| sawtooth();
    waves: No 1 |_r| sine_wave();
    folded_triangles: Yes 2 |_r| folded_triangle();
    heitz_triangles: Yes 2 |_r| heitz_triangle();
    concentric_disks: No 2 |_r| concentric_disk();
    lobes_and_spheres: No 2 |r| right(lobe_and_sphere(r(0.3)));
    triangles_over_a_line: Yes 1 |r| right(triangular(r(-1.0), r(0.5), r(2.0)));
    four_slopes: Yes 1 |_r| quarters();
    flights_within: No 1 |r| right(flight_within(r(2.0), r(0.5)));
    kinked_squares: Yes 2 |_r| kinked_square();
    boxes: Yes 3 |_r| parallelepiped(
        Mat3::from_cols(v(1.0, 2.0, 0.0), v(0.0, 3.0, -1.0), v(0.5, 0.0, 2.0)), v(5.0, -3.0, 0.25));
    triangles: Yes 2 |_r| triangle(v(0.5, 0.0, 1.0), v(1.0, 2.0, 3.0), v(-1.0, 0.25, 0.0));
    panels: Yes 2 |_r| panel(v(1.0, 2.0, 3.0), v(0.5, 0.0, 0.25), v(0.0, -2.0, 1.0), SurfaceId(7));
    pairs_of_normals: No 2 |_r| box_muller();
    normals: No 1 |r| right(normal(r(-3.0), r(0.25)));
    normal_tails: No 1 |r| upper_normal(r(0.5), r(2.0));
    lambert_tails: No 1 |r| right(lambert_tail(r(0.1)));
    gamma_scales: No 1 |r| right(gamma_scale(r(2.5)));
    cauchys: No 1 |r| right(cauchy(r(2.0)));
    hyperbolic_sines: No 1 |r| right(sinh_arcsine(r(1.5)));
    quintics: No 1 |r| right(quintic(r(0.5)));
    smoothsteps: No 1 |r| smoothstep(r(-1.0), r(3.0));
    keplers: No 1 |r| right(kepler(r(0.7)));
    hyperexponentials: No 1 |r| right(hyperexponential(r(0.3), r(2.0), r(0.5)));
    narrowings: No 3 |r| narrowing(r(2.0));
}

#[test]
fn rotated_lobes() {
    fn make<R: Real>() -> impl Sampler<R, Uniforms = [R; 2], Point = Direction<R>> {
        power_cosine(R::of(7.0)).then(rotate(tilted()))
    }
    let later = |u: &[f32; 2], k| condition_after(&power_cosine(7.0), &rotate(tilted()), u, k);
    compare("rotated_lobes", Exact::No, (&make(), &make(), &make()), later);
    compare_bits("rotated_lobes", (&make::<Portable>(), &make()));
}

#[test]
fn spots() {
    fn make<R: Real>() -> Spot<R> {
        spot(R::of(4.0), tilted(), v(1.0, 2.0, 3.0))
    }
    let map = Map::then(rotate(tilted()), to_floor(v(1.0, 2.0, 3.0)));
    let later = |u: &[f32; 2], k| condition_after(&power_cosine(4.0), &map, u, k);
    compare("spots", Exact::No, (&make(), &make(), &make()), later);
    compare_bits("spots", (&make::<Portable>(), &make()));
}

#[test]
fn each_lane_has_its_own_parameters() {
    let scales: [f32; 8] = core::array::from_fn(|i| 0.5 + 0.7 * i as f32);
    let wide = right(normal(Lanes::splat(1.0), Lanes::new(scales)));
    let x = wide.sample([Lanes::splat(0.3)]);
    let gammas = right(gamma_scale(Lanes::new(scales))).sample([Lanes::splat(0.75)]);
    for (i, s) in scales.into_iter().enumerate() {
        let single = right(normal(1.0, s));
        let near =
            |a: f32, b: f32| assert!((a - b).abs() <= 4.0 * f32::EPSILON * b.abs(), "{a}, {b}");
        near(x.value().to_array()[i], single.sample([0.3]).value());
        near(x.pdf().value().to_array()[i], single.sample([0.3]).pdf().value());
        near(gammas.value().to_array()[i], right(gamma_scale(s)).sample([0.75]).value());
    }
}

#[test]
fn a_parameter_outside_its_domain_in_one_lane_is_an_error() {
    let mut scales = [1.0; 8];
    scales[5] = -2.0;
    let error = normal(Lanes::splat(0.0), Lanes::new(scales)).unwrap_err();
    assert_eq!(error.value, -2.0);
    let error = triangular(Lanes::splat(0.0), Lanes::new(scales), Lanes::splat(3.0)).unwrap_err();
    assert_eq!(error.requirement, "a <= b");
}

#[test]
fn a_map_has_preimages_in_some_lanes() {
    let heights = [1.0, -1.0, f32::NAN, 0.0, 2.0, -3.0, f32::INFINITY, 0.5];
    let y = Vec2::new(Lanes::splat(0.25), Lanes::new(heights));
    let mut found = [0; 8];
    Map::preimages(&kink(), &y, |x: Vec2<Lanes>, mask: LaneMask| {
        assert!(mask.any());
        for i in (0..8).filter(|i| mask.lane(*i)) {
            let alone = kink().apply(&Vec2::new(x.x.lane(i), x.y.lane(i)));
            assert_eq!((alone.x, alone.y), (0.25, heights[i]));
            found[i] += 1;
        }
    });
    assert_eq!(found, [1, 1, 0, 1, 1, 1, 0, 1]);
}

/// They iterate in double precision, a lane at a time.
#[test]
fn incomplete_beta_functions_have_the_bits_of_the_scalar() {
    fn all<R: Real>(a: R, b: R, x: R) -> [R; 2] {
        [beta_inc(a, b, x), beta_inc_inv(a, b, x)]
    }
    for (a, b) in [(1.75, 0.5), (0.5, 40.0), (500.0, 0.5)] {
        for k in 0..64 {
            let x: [f32; 8] = core::array::from_fn(|i| (k * 8 + i) as f32 / 511.0);
            let wide = all(Lanes::splat(a), Lanes::splat(b), Lanes::new(x));
            for (i, x) in x.into_iter().enumerate() {
                for (wide, single) in wide.iter().zip(all(a, b, x)) {
                    let lane = wide.to_array()[i];
                    assert_eq!(lane.to_bits(), single.to_bits(), "a = {a}, b = {b}, x = {x}");
                }
            }
        }
    }
}
