//! Cases where an earlier implementation of the same idea compiled, ran and gave a wrong density.
//!
//! Each test states the true value in closed form.

use aether_core::battery::{self, Battery};
use aether_core::discrete::{Choices, shares};
use aether_core::prelude::*;
use aether_core::sequence::Erased;
use aether_core::strategy::Vertex;
use aether_core::tables::{PiecewiseConstant2D, Warp};
use aether_core::{Arena, PathView, WeightError, discrete, discrete_weighted};
use tests::catalogue::*;

/// Asserts that two densities agree to rounding.
#[track_caller]
fn close(found: f64, expected: f64) {
    assert!((found - expected).abs() <= 1e-13 * expected.abs(), "{found:e}, expected {expected:e}");
}

/// Asserts that a sample's own density and that of the point both have the value.
#[track_caller]
fn both<S: Sampler<f64>>(sampler: S, u: S::Uniforms, expected: f64) {
    let sample = sampler.sample(u);
    close(sample.pdf().value(), expected);
    close(sampler.pdf(&sample).value(), expected);
}

fn direction(x: f64, y: f64, z: f64) -> Direction {
    Direction::try_new(x, y, z).expect("a unit vector")
}

// Factors and matrices in front of a vector.

#[sampler]
fn doubled_cosine_hemisphere(u: [Uniform; 2]) -> Surface {
    let r = u[0].sqrt();
    let phi = TAU * u[1];
    Surface::from_vec(2.0 * Vec3::new(r * phi.cos(), r * phi.sin(), (1.0 - u[0]).sqrt()))
}

#[sampler]
fn linear_cosine_hemisphere(u: [Uniform; 2], m: Mat3) -> Surface {
    let r = u[0].sqrt();
    let phi = TAU * u[1];
    Surface::from_vec(m * Vec3::new(r * phi.cos(), r * phi.sin(), (1.0 - u[0]).sqrt()))
}

#[map]
fn linear_direction(w: Direction, m: Mat3) -> Direction {
    Direction::from_vec((m * w.vec()).normalize())
}

#[test]
fn a_factor_before_a_vector_divides_the_density_by_its_square() {
    let truth = 0.3_f64.sqrt() / (4.0 * PI);
    assert!((truth - 0.0436).abs() < 5e-5);
    both(doubled_cosine_hemisphere(), [0.7, 0.1], truth);
}

#[test]
fn a_matrix_that_is_no_rotation_changes_the_area() {
    let (u, m) = ([0.7_f64, 0.1], Mat3::diagonal(Vec3::new(2.0, 3.0, 1.0)));
    let w = cosine_hemisphere().sample(u).value();
    let cofactor = Vec3::new(w.x / 2.0, w.y / 3.0, w.z).length();
    let truth = w.z / PI / (6.0 * cofactor);
    assert!((truth - 0.0437).abs() < 5e-5);
    both(linear_cosine_hemisphere(m), u, truth);
}

#[test]
fn a_linearly_transformed_cosine_knows_its_own_samples() {
    let m = Mat3::from_cols(
        Vec3::new(0.5, 0.1, 0.0),
        Vec3::new(0.0, 2.0, 0.25),
        Vec3::new(0.3, 0.0, 1.0),
    );
    let det = 0.5 * 2.0 - 0.0 + 0.3 * (0.1 * 0.25 - 0.0);
    let lobe = cosine_hemisphere().then(linear_direction(m));
    for u in [[0.3, 0.6], [0.9, 0.01], [0.05, 0.8]] {
        let w = cosine_hemisphere().sample(u).value();
        let stretch = (m * w).length();
        close(lobe.sample(u).pdf().value(), w.z / PI * stretch.powi(3) / det);
        both(lobe, u, w.z / PI * stretch.powi(3) / det);
        let x = lobe.sample(u).value();
        assert_eq!(lobe.pdf(&direction(-x.x, -x.y, -x.z)).value(), 0.0);
    }
}

// Normalised vectors.

#[sampler]
fn cube_face(u: [Uniform; 2]) -> Direction {
    Direction::from_vec(Vec3::new(2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0, 1.0).normalize())
}

#[sampler]
fn perspective(u: [Uniform; 2], t: f64, a: f64) -> Direction {
    let v = Vec3::new(t * (2.0 * u[0] - 1.0), t * a * (2.0 * u[1] - 1.0), 1.0);
    Direction::from_vec(v.normalize())
}

#[test]
fn normalised_vectors_have_the_solid_angle_of_the_plane() {
    for u in [[0.3, 0.6], [0.0, 0.0], [0.5, 0.5], [0.99, 0.2]] {
        let (x, y) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
        both(cube_face(), u, 0.25 * (x * x + y * y + 1.0).powf(1.5));
    }
}

#[test]
fn a_camera_does_not_look_backwards() {
    let camera = perspective(0.7, 0.5);
    let w = camera.sample([0.3, 0.8]).value();
    both(camera, [0.3, 0.8], 1.0 / (4.0 * 0.7 * 0.7 * 0.5 * w.z.powi(3)));
    assert_eq!(camera.pdf(&direction(-w.x, -w.y, -w.z)).value(), 0.0);
    assert_eq!(camera.pdf(&direction(0.0, 1.0, 0.0)).value(), 0.0);
    assert_eq!(camera.pdf(&direction(1.0, 0.0, 0.0)).value(), 0.0);
}

// Parameters and literals.

#[sampler]
fn two_parameters(u: [Uniform; 1], a: f64, b: f64) -> f64 {
    a * u[0] + b * u[0]
}

#[map]
fn stretch(x: f64, k: f64) -> f64 {
    k * x
}

#[sampler]
fn times_root_two(u: [Uniform; 1]) -> f64 {
    2.0_f64.sqrt() * u[0]
}

#[sampler]
fn times_root_half(u: [Uniform; 1]) -> f64 {
    0.5_f64.sqrt() * u[0]
}

#[test]
fn parameters_of_one_source_line_stay_apart() {
    close(*two_parameters(2.0, 3.0).sample([0.5]), 2.5);
    both(two_parameters(2.0, 3.0), [0.5], 1.0 / 5.0);
    let twice = affine(0.0, 1.0).then(stretch(2.0).then(stretch(3.0)));
    close(*twice.sample([0.5]), 3.0);
    both(twice, [0.5], 1.0 / 6.0);
    let thrice = affine(0.0, 1.0).then(stretch(2.0)).then(stretch(3.0));
    both(thrice, [0.5], 1.0 / 6.0);
}

#[test]
fn roots_of_literals_are_roots() {
    close(*times_root_two().sample([0.25]), SQRT_2 / 4.0);
    both(times_root_two(), [0.25], 1.0 / SQRT_2);
    close(*times_root_half().sample([0.25]), 0.125 * SQRT_2);
    both(times_root_half(), [0.25], SQRT_2);
}

// Maps with several preimages.

#[sampler]
fn root_of_square(u: [Uniform; 1]) -> f64 {
    ((u[0] - 1.0) * (u[0] - 1.0)).sqrt()
}

#[sampler]
fn arch(u: [Uniform; 1]) -> f64 {
    (PI * u[0]).sin()
}

#[sampler]
fn centred_square(u: [Uniform; 1]) -> f64 {
    (u[0] - 0.5).powi(2)
}

#[sampler]
fn cosine_wave(u: [Uniform; 1]) -> f64 {
    (TAU * u[0]).cos()
}

#[sampler]
fn sine_wave(u: [Uniform; 1]) -> f64 {
    (TAU * u[0]).sin()
}

#[sampler]
fn square_fold(u: [Uniform; 1]) -> f64 {
    (2.0 * u[0] - 1.0).powi(2)
}

#[sampler]
fn root_fold(u: [Uniform; 1]) -> f64 {
    (2.0 * u[0] - 1.0).powi(2).sqrt()
}

#[sampler]
fn absolute_fold(u: [Uniform; 1]) -> f64 {
    (2.0 * u[0] - 1.0).abs()
}

#[test]
fn the_root_of_a_square_is_the_absolute_value() {
    close(*root_of_square().sample([0.3]), 0.7);
    both(root_of_square(), [0.3], 1.0);
    assert_eq!(root_of_square().pdf(&-0.7).value(), 0.0);
    for x in [0.1, 0.5, 0.9] {
        close(root_fold().pdf(&x).value(), 1.0);
        close(absolute_fold().pdf(&x).value(), 1.0);
        assert_eq!(root_fold().pdf(&-x).value(), 0.0);
        assert_eq!(absolute_fold().pdf(&-x).value(), 0.0);
        assert_eq!(root_fold().invert(&x).len(), 2);
        assert_eq!(absolute_fold().invert(&x).len(), 2);
    }
}

#[test]
fn two_to_one_maps_sum_over_both_preimages() {
    for x in [0.1, 0.5, 0.951] {
        let wave = 1.0 / (PI * ((1.0 - x) * (1.0 + x)).sqrt());
        close(arch().pdf(&x).value(), 2.0 * wave);
        assert_eq!(arch().pdf(&-x).value(), 0.0);
        assert_eq!(arch().invert(&x).len(), 2);
        for sign in [1.0, -1.0] {
            close(cosine_wave().pdf(&(sign * x)).value(), wave);
            close(sine_wave().pdf(&(sign * x)).value(), wave);
            assert_eq!(cosine_wave().invert(&(sign * x)).len(), 2);
            assert_eq!(sine_wave().invert(&(sign * x)).len(), 2);
        }
        close(square_fold().pdf(&x).value(), 0.5 / x.sqrt());
        assert_eq!(square_fold().pdf(&-x).value(), 0.0);
        close(centred_square().pdf(&(x / 4.0)).value(), 1.0 / (x / 4.0).sqrt());
    }
    assert!((sine_wave().pdf(&0.951).value() - 1.030).abs() < 1e-3);
    for x in [1.5, -1.5, f64::NAN] {
        assert_eq!(cosine_wave().pdf(&x).value(), 0.0);
        assert_eq!(arch().pdf(&x).value(), 0.0);
        assert_eq!(square_fold().pdf(&x).value(), 0.0);
        assert_eq!(centred_square().pdf(&x).value(), 0.0);
    }
}

// Discrete choices.

#[test]
fn equal_items_share_their_probability_once() {
    let twins = discrete(["a", "a"]).expect("two items");
    close(twins.pdf(&"a").value(), 1.0);
    let weighted = discrete_weighted(["a", "b", "a"], [1.0, 2.0, 5.0]).expect("three items");
    close(weighted.pdf(&"a").value(), 0.75);
}

#[test]
fn weights_that_are_all_zero_are_an_error() {
    let made = discrete_weighted(["a", "b"], [0.0, 0.0]);
    assert_eq!(made.err(), Some(WeightError::AllZero));
}

/// A vertex on a line.
#[derive(Clone, Copy, Debug)]
struct Spot(f64);

impl Vertex for Spot {
    type Real = f64;
    type Point = f64;
    fn point(&self) -> f64 {
        self.0
    }
}

#[sampler]
fn up_to_three(u: [Uniform; 1]) -> f64 {
    3.0 * u[0]
}

#[strategy]
fn one_of_twins(path: &PathView<Spot>, twins: &Choices<Vec<f64>, f64>) -> Spot {
    let _twin = choose(twins);
    let x = draw(up_to_three());
    Spot(x)
}

#[test]
fn equal_items_count_once_in_a_path_whose_density_is_in_double_precision() {
    let twins = discrete(vec![1.0, 1.0]).expect("two items");
    let strategy = one_of_twins(&twins);
    let arena = Arena::<Spot, Erased<'_, Spot>>::new();
    let mut path = arena.sequence();
    for _ in 0..3 {
        path.append(Erased(&strategy));
    }
    path.sample(&mut || 0.4);
    let found: f64 = path.pdf().value();
    assert!((27.0 * found - 1.0).abs() < 1e-15, "{found:e}");
}

#[test]
fn tables_in_two_dimensions_have_a_density() {
    let table = PiecewiseConstant2D::new(&[1.0, 2.0, 3.0, 4.0], 2).expect("four values");
    for (x, expected) in [([0.25, 0.25], 0.4), ([0.75, 0.25], 0.8), ([0.1, 0.9], 1.2)] {
        close(table.sampler().pdf(&Vec2::new(x[0], x[1])).value(), expected);
    }
}

// Points off the manifold or outside the support.

#[sampler]
fn triangle(u: [Uniform; 2], a: Vec3, b: Vec3, c: Vec3) -> Surface {
    let s = u[0].sqrt();
    Surface::from_vec(a + s * (1.0 - u[1]) * (b - a) + s * u[1] * (c - a))
}

#[sampler]
fn simplex(u: [Uniform; 2]) -> Surface {
    let a = 1.0 - (1.0 - u[0]).sqrt();
    let b = (1.0 - a) * u[1];
    Surface::new(a, b, 1.0 - a - b)
}

#[test]
fn a_point_inside_the_ball_is_no_direction() {
    assert!(Direction::try_new(0.1, 0.1, 0.5).is_none());
    assert!(Direction::try_new(0.0, 0.6, 0.1).is_none());
    assert!(Direction::try_new(f64::NAN, 0.0, 1.0).is_none());
}

/// The root that its uniforms are found by has forgotten on which side of the first corner a point lies.
#[test]
fn a_triangle_does_not_reach_beyond_its_first_corner() {
    let (a, e, f) =
        (Vec3::new(0.5, 1.0, -2.0), Vec3::new(1.0, 0.5, 0.0), Vec3::new(-0.5, 1.0, 2.0));
    let whole = triangle(a, a + e, a + f);
    let area = 0.5 * e.cross(f).length();
    for (p, q) in [(0.25, 0.5), (0.5, 0.25), (0.125, 0.125)] {
        let at = |p: f64, q: f64| whole.pdf(&Surface::from_vec(a + p * e + q * f)).value();
        close(at(p, q), 1.0 / area);
        for (p, q) in [(-p, -q), (-p, q), (p, -q), (1.0 - 0.25 * p, 1.0 - 0.25 * q)] {
            assert_eq!(at(p, q), 0.0, "{p} {q}");
        }
    }
}

#[test]
fn a_small_triangle_does_not_reach_beyond_its_plane() {
    let (a, e) = (Vec3::new(3.0, -1.0, 2.0), 1e-4);
    let small = triangle(a, a + Vec3::new(e, 0.0, 0.0), a + Vec3::new(0.0, e, 0.0));
    assert_eq!(small.pdf(&Surface::new(3.0 + e / 4.0, -1.0 + e / 4.0, 2.0 + 5e-4)).value(), 0.0);
    assert_eq!(small.pdf(&Surface::new(3.0 + 2.0 * e, -1.0 + e / 4.0, 2.0)).value(), 0.0);
    let exact = triangle(Vec3::ZERO, Vec3::new(e, 0.0, 0.0), Vec3::new(0.0, e, 0.0));
    assert_eq!(exact.pdf(&Surface::new(e / 4.0, e / 4.0, 5e-4)).value(), 0.0);
    close(exact.pdf(&Surface::new(e / 4.0, e / 4.0, 0.0)).value(), 2.0 / (e * e));
    for u in [[0.0, 0.0], [0.0, 0.5], [0.3, 0.0], [0.3, 0.6], [1e-300, 0.5], [0.999999, 0.999999]] {
        let sample = exact.sample(u);
        close(exact.pdf(&sample).value(), 2.0 / (e * e));
        // Rounding of the corners, 2 ulp of 3, is 1e-11 of the edge.
        let found = small.pdf(&small.sample(u)).value() * (e * e) / 2.0;
        assert!((found - 1.0).abs() < 1e-10, "{found} at {u:?}");
    }
}

#[test]
fn the_cosine_hemisphere_ends_at_the_horizon_and_includes_its_pole() {
    let p = |x, y, z| cosine_hemisphere().pdf(&direction(x, y, z)).value();
    close(p(0.6, 0.0, 0.8), 0.8 / PI);
    close(p(0.0, 0.0, 1.0), 1.0 / PI);
    assert_eq!(p(0.0, 0.6, -0.8), 0.0);
    assert_eq!(p(0.0, 0.0, -1.0), 0.0);
    assert_eq!(p(1.0, 0.0, 0.0), 0.0);
}

#[test]
fn a_height_field_has_no_density_at_the_wrong_height() {
    let field = height_field(0.8);
    assert_eq!(field.pdf(&Surface::new(0.3, 0.6, 0.1)).value(), 0.0);
    both(field, [0.5, 0.5], 1.0);
}

#[test]
fn a_simplex_has_no_density_off_its_plane() {
    assert_eq!(simplex().pdf(&Surface::new(0.5, 0.4, 0.5)).value(), 0.0);
    assert_eq!(simplex().pdf(&Surface::new(0.2, 0.3, 0.4)).value(), 0.0);
    for u in [[0.3, 0.6], [0.0, 0.0], [0.0, 0.5], [0.9, 0.0]] {
        both(simplex(), u, 2.0 / 3.0_f64.sqrt());
    }
}

// A ray that meets a plane.

#[map]
fn hit_plane(w: Direction, o: Vec3, p0: Vec3, n: Vec3, id: SurfaceId) -> SurfacePoint {
    let t = n.dot(p0 - o) / n.dot(w.vec());
    require(t > 0.0);
    SurfacePoint::new(o + t * w, id)
}

#[map]
fn plane_point(w: Direction, o: Vec3, p0: Vec3, n: Vec3) -> Surface {
    let t = n.dot(p0 - o) / n.dot(w.vec());
    require(t > 0.0);
    Surface::from_vec(o + t * w)
}

#[test]
fn a_ray_meets_a_plane_in_front_of_it_only() {
    let (o, p0) = (Vec3::new(0.5, -0.25, 0.0), Vec3::new(0.0, 0.0, 2.0));
    let n = Vec3::new(0.25, -0.125, 1.0);
    let known = uniform_sphere().then(hit_plane(o, p0, n, SurfaceId(7)));
    let checked = uniform_sphere().then(plane_point(o, p0, n));
    let w = direction(0.36, 0.48, 0.8);
    let t = n.dot(p0 - o) / n.dot(w.vec());
    let truth = 0.25 / PI * (n.dot(w.vec()) / n.length()).abs() / (t * t);
    let x = o + t * w;
    close(known.pdf(&SurfacePoint::new(x, SurfaceId(7))).value(), truth);
    close(checked.pdf(&Surface::from_vec(x)).value(), truth);
    assert_eq!(known.pdf(&SurfacePoint::new(x, SurfaceId(8))).value(), 0.0);
    let above = x + 0.125 * n;
    assert_eq!(checked.pdf(&Surface::from_vec(above)).value(), 0.0);
    // The point of the line on the other side of the origin is no point of the plane.
    assert_eq!(checked.pdf(&Surface::from_vec(o - t * w)).value(), 0.0);
    // Directions away from the plane have no sample.
    let away = uniform_sphere().sample([0.9, 0.3]);
    assert!(away.z < -0.5);
    assert!(!known.sample([0.9, 0.3]).is_valid());
    assert_eq!(known.sample([0.9, 0.3]).pdf().value(), 0.0);
    let hemisphere = cosine_hemisphere().then(hit_plane(o, p0, n, SurfaceId(7)));
    let behind = SurfacePoint::new(o - t * w, SurfaceId(7));
    assert_eq!(hemisphere.pdf(&behind).value(), 0.0);
}

#[test]
fn planes_of_any_distance_have_densities_in_single_precision() {
    // The third power of these distances is no number.
    for d in [1e-17_f32, 1.0, 1e17] {
        let (o, p0, n) =
            (Vec3::new(0.0, 0.0, 0.0), Vec3::new(0.0, 0.0, d), Vec3::new(0.0, 0.0, 1.0));
        let onto = uniform_sphere().then(hit_plane(o, p0, n, SurfaceId(7)));
        let x = SurfacePoint::new(Vec3::new(0.75 * d, 0.0, d), SurfaceId(7));
        let truth = 0.25 / std::f32::consts::PI * 0.8 / (1.25 * d).powi(2);
        let density = onto.pdf(&x).value();
        assert!((density / truth - 1.0).abs() < 1e-6, "{d}: {density} for {truth}");
    }
}

// A uniform of zero.

#[sampler(m in 0.0..=2.0)]
fn cone(u: [Uniform; 2], m: f64) -> Direction {
    let z = 1.0 - m * u[0];
    let r = (1.0 - z * z).sqrt();
    let phi = TAU * u[1];
    Direction::new(r * phi.cos(), r * phi.sin(), z)
}

#[test]
fn a_uniform_of_zero_is_a_legal_sample() {
    both(cosine_hemisphere(), [0.0, 0.0], 1.0 / PI);
    both(cosine_hemisphere(), [0.0, 0.7], 1.0 / PI);
    both(cosine_hemisphere(), [0.3, 0.0], 0.7_f64.sqrt() / PI);
    both(uniform_sphere(), [0.0, 0.3], 0.25 / PI);
    both(uniform_hemisphere(), [0.0, 0.0], 0.5 / PI);
    both(polar_disk(2.0), [0.0, 0.6], 0.25 / PI);
    let axis = cone(0.01).expect("an angle");
    both(axis, [0.0, 0.25], 1.0 / (0.01 * TAU));
    close(axis.pdf(&direction(0.0, 0.0, 1.0)).value(), 1.0 / (0.01 * TAU));
    close(power_cosine(50.0).pdf(&direction(0.0, 0.0, 1.0)).value(), 51.0 / TAU);
}

// Several dimensions.

#[sampler]
fn sum_and_difference(u: [Uniform; 2]) -> Vec2 {
    Vec2::new(u[0] + u[1], u[0] - u[1])
}

#[sampler]
fn sheared_square(u: [Uniform; 2]) -> Vec2 {
    Vec2::new(u[0] + u[1] * u[1], u[1])
}

#[sampler]
fn unit_square(u: [Uniform; 2]) -> Vec2 {
    Vec2::new(u[0], u[1])
}

#[sampler]
fn parallelepiped(u: [Uniform; 3], m: Mat3, t: Vec3) -> Vec3 {
    t + m * Vec3::new(u[0], u[1], u[2])
}

#[sampler]
fn box_muller(u: [Uniform; 2]) -> Vec2 {
    let r = (-2.0 * (1.0 - u[0]).ln()).sqrt();
    let phi = TAU * u[1];
    Vec2::new(r * phi.cos(), r * phi.sin())
}

#[test]
fn maps_between_spaces_of_one_dimension_have_a_determinant() {
    both(unit_square(), [0.3, 0.6], 1.0);
    both(sum_and_difference(), [0.3, 0.6], 0.5);
    assert_eq!(sum_and_difference().pdf(&Vec2::new(0.1, 0.9)).value(), 0.0);
    both(sheared_square(), [0.3, 0.6], 1.0);
    assert_eq!(sheared_square().pdf(&Vec2::new(0.1, 0.9)).value(), 0.0);
    let m = Mat3::from_cols(
        Vec3::new(1.0, 2.0, 0.0),
        Vec3::new(0.0, 3.0, -1.0),
        Vec3::new(0.5, 0.0, 2.0),
    );
    let solid = parallelepiped(m, Vec3::new(5.0, -3.0, 0.25));
    both(solid, [0.3, 0.6, 0.2], 1.0 / 5.0);
    assert_eq!(solid.pdf(&Vec3::new(0.0, 0.0, 0.0)).value(), 0.0);
    let z = box_muller().sample([0.3, 0.6]).value();
    both(box_muller(), [0.3, 0.6], (-0.5 * z.length_squared()).exp() / TAU);
    both(box_muller(), [0.0, 0.6], 1.0 / TAU);
}

// One dimension.

#[sampler]
fn cauchy(u: [Uniform; 1], g: f64) -> f64 {
    g * (PI * (u[0] - 0.5)).tan()
}

#[sampler]
fn square_and_itself(u: [Uniform; 1]) -> f64 {
    u[0] * u[0] + u[0]
}

#[sampler]
fn root_and_itself(u: [Uniform; 1]) -> f64 {
    u[0] + u[0].sqrt()
}

#[sampler]
fn fraction(u: [Uniform; 1]) -> f64 {
    u[0] / (2.0 - u[0])
}

#[sampler]
fn root_of_odds(u: [Uniform; 1]) -> f64 {
    (u[0] / (1.0 - u[0])).sqrt()
}

#[sampler]
fn arc_tangent(u: [Uniform; 1]) -> f64 {
    u[0].atan()
}

#[sampler]
fn arc_sine(u: [Uniform; 1]) -> f64 {
    u[0].asin()
}

#[sampler]
fn ggx_slopes(u: [Uniform; 2], a: f64) -> Vec2 {
    let r = a * (u[0] / (1.0 - u[0])).sqrt();
    let phi = TAU * u[1];
    Vec2::new(r * phi.cos(), r * phi.sin())
}

#[test]
fn maps_that_did_not_compile_have_their_density() {
    for u in [0.05, 0.3, 0.5, 0.75] {
        let x = *cauchy(2.0).sample([u]);
        both(cauchy(2.0), [u], 2.0 / (PI * (4.0 + x * x)));
        both(square_and_itself(), [u], 1.0 / (1.0 + 2.0 * u));
        both(root_and_itself(), [u], 1.0 / (1.0 + 0.5 / u.sqrt()));
        both(fraction(), [u], (2.0 - u) * (2.0 - u) / 2.0);
        let x = *root_of_odds().sample([u]);
        both(root_of_odds(), [u], 2.0 * x / (1.0 + x * x).powi(2));
        both(arc_tangent(), [u], 1.0 + u * u);
        both(arc_sine(), [u], (1.0 - u * u).sqrt());
        let slope = ggx_slopes(0.25).sample([u, 0.7]).value();
        let r2 = slope.length_squared() / 0.0625;
        both(ggx_slopes(0.25), [u, 0.7], 1.0 / (PI * 0.0625 * (1.0 + r2).powi(2)));
    }
    for x in [-0.1, 1.1, f64::INFINITY] {
        assert_eq!(fraction().pdf(&x).value(), 0.0);
        assert_eq!(arc_tangent().pdf(&x).value(), 0.0);
    }
    assert_eq!(square_and_itself().pdf(&2.5).value(), 0.0);
    assert_eq!(square_and_itself().pdf(&-0.1).value(), 0.0);
}

#[test]
fn the_last_uniform_of_a_piece_is_not_rounded_to_its_end() {
    // In f32, (u - 0.35) / 0.65 of the last uniform is one, and the direction had no height.
    let sampler = mixture::<f32>(0.35, 8.0).unwrap();
    let sample = sampler.sample([1.0 - f32::EPSILON / 2.0, 0.25]);
    assert!(sample.value().z > 0.0);
    assert!(sample.pdf().value() > 0.0 && sampler.pdf(&sample).value() > 0.0);
}

#[test]
fn a_folded_triangle_has_a_density() {
    let corner = |x, y, z| Vec3::new(x, y, z);
    let triangle =
        triangle_fold(corner(0.25, -0.5, 1.0), corner(2.25, -0.5, 1.0), corner(0.25, 0.5, 1.0));
    // Of an area of one; either half of the square fills it.
    for u in [[0.25, 0.5], [0.75, 0.625], [0.9, 0.2], [0.01, 0.02]] {
        both(triangle, u, 1.0);
    }
}

#[test]
fn a_phase_function_knows_its_own_samples() {
    let density = |g: f64, z: f64| {
        let lobe = (1.0 - g * g) / (1.0 + g * g - 2.0 * g * z).powf(1.5);
        lobe / (4.0 * std::f64::consts::PI)
    };
    for g in [-0.75, 0.25, 0.5, 0.875] {
        for u in [[0.1, 0.3], [0.5, 0.9], [0.95, 0.6]] {
            for sample in [
                henyey_greenstein(g).map(|lobe| lobe.sample(u).value()),
                henyey_greenstein_as_printed(g).map(|lobe| lobe.sample(u).value()),
            ] {
                let w = sample.expect("a legal mean cosine");
                let found = henyey_greenstein(g).expect("a legal mean cosine").pdf(&w).value();
                let expected = density(g, w.z);
                assert!((found / expected - 1.0).abs() < 1e-13, "{g} {u:?}: {found} {expected}");
            }
        }
    }
}

/// The third side is rounded, and with it the root may be that of less than zero, by as much as its squares are large.
#[sampler]
fn beyond_a_right_angle(u: [Uniform; 1], a: f64, b: f64, c: f64) -> f64 {
    (a * a + b * b - c * c + u[0] * u[0]).sqrt()
}

#[test]
fn what_may_be_less_than_zero_is_as_large_as_what_it_is_the_difference_of() {
    let (a, b) = (1e6_f64 / 3.0, 2e6_f64 / 3.0);
    let c = a.hypot(b);
    for c in [c.next_down(), c, c.next_up()] {
        let x = beyond_a_right_angle(a, b, c).sample([0.0]).value();
        assert!((0.0..0.05).contains(&x), "{x}");
    }
    // Not that of what is plainly too long.
    assert!(beyond_a_right_angle(3e-9_f64, 4e-9, 6e-9).sample([0.0]).value().is_nan());
}

#[test]
fn ends_may_come_in_any_order() {
    // Free flight up to d, also backwards.
    for d in [1.2, -1.2, 1e-9, -1e-9] {
        let flight = truncated_exponential(0.7, d);
        let density = |x: f64| (-0.7 * x).exp() * 0.7 / (-0.7 * d).exp_m1().abs();
        for part in [0.0, 1e-12, 0.3, 1.0 - 1e-12] {
            close(flight.pdf(&(part * d)).value(), density(part * d));
        }
        for part in [-5.0, -0.2, -1e-3, 1.001, 1.2, 7.0, f64::INFINITY, f64::NAN] {
            assert_eq!(flight.pdf(&(part * d)).value(), 0.0, "{part} of {d}");
        }
    }
    // A root of a uniform lies below one, its inverse above.
    for (k, inside, outside) in
        [(2.5, [0.2, 0.999], [1.001, 1.5, -0.2]), (-2.5, [1.001, 40.0], [0.999, 0.2, -3.0])]
    {
        for x in inside {
            close(power(k).pdf(&x).value(), 2.5 * x.powf(k - 1.0));
        }
        for x in outside {
            assert_eq!(power(k).pdf(&x).value(), 0.0, "{x} to {k}");
        }
    }
}

// Pieces that meet, or exclude each other by parameters.

#[sampler]
fn two_normals(u: [Uniform; 1]) -> f64 {
    if u[0] < 0.5 { normal_quantile(2.0 * u[0]) } else { 3.0 + normal_quantile(2.0 * u[0] - 1.0) }
}

#[sampler(b in 1e-3..=1e3)]
fn laplace_by_branches(u: [Uniform; 1], m: f64, b: f64) -> f64 {
    if u[0] < 0.5 { m + b * (2.0 * u[0]).ln() } else { m - b * (2.0 - 2.0 * u[0]).ln() }
}

#[sampler(least in -0.999..=0.999999)]
fn cap_about(u: [Uniform; 2], axis: Direction, least: f64) -> Direction {
    let c = 1.0 - u[0] * (1.0 - least);
    let s = (1.0 - c * c).sqrt();
    let phi = TAU * u[1];
    Direction::from_vec(Frame::around(axis).to_world(Vec3::new(s * phi.cos(), s * phi.sin(), c)))
}

#[test]
fn what_ends_at_infinity_does_not_go_on_from_the_other_one() {
    let normal = |x: f64| (-0.5 * x * x).exp() / TAU.sqrt();
    for x in [-1.0, 0.0, 1.0, 1.5, 3.0, 5.0] {
        close(two_normals().pdf(&x).value(), 0.5 * normal(x) + 0.5 * normal(x - 3.0));
        let found: Vec<[f64; 1]> = two_normals().invert(&x).iter().collect();
        assert!(matches!(found[..], [[a], [b]] if a < 0.5 && b > 0.5), "{x}: {found:?}");
    }
}

#[test]
fn a_sample_that_is_rounded_over_the_end_of_its_piece_counts_once() {
    let sampler = laplace_by_branches(100.0f32, 0.01).expect("in the domain");
    for i in 1..10_000u16 {
        let sample = sampler.sample([f32::from(i) / 1e4]);
        let by_hand = 50.0 * (-(sample.value() - 100.0).abs() / 0.01).exp();
        let own = sample.pdf().value();
        // The sample is rounded to 8e-6, eight ten thousandths of its scale.
        assert!((own / by_hand - 1.0).abs() < 2e-3, "{i}: {own}, expected {by_hand}");
    }
}

#[test]
fn of_pieces_that_parameters_choose_one_is_there() {
    // Across the axes of the frame its two branches meet.
    for (least, z) in [(0.99f32, 0.0f32), (0.999995, 0.0), (0.999995, -0.0), (0.999998, 1e-12)] {
        let sampler = cap_about(Direction::new(0.0, -1.0, z), least).expect("in the domain");
        let expected = 1.0 / (std::f32::consts::TAU * (1.0 - least));
        for k in 0..100u8 {
            let u = [k % 10, k / 10].map(|k| (f32::from(k) + 0.5) / 10.0);
            let sample = sampler.sample(u);
            for found in [sample.pdf().value(), sampler.pdf(&sample).value()] {
                assert!((found / expected - 1.0).abs() < 1e-4, "{least} {u:?}: {found} {expected}");
            }
        }
    }
}

// Powers and exponentials.

#[sampler(a in 1e-3..=1e3, b in 0.1..=50.0)]
fn log_logistic(u: [Uniform; 1], a: f64, b: f64) -> f64 {
    a * (u[0] / (1.0 - u[0])).powf(1.0 / b)
}

/// As hair scatters about its axis: a logistic distribution, cut off half a turn away.
#[sampler(s in 1e-2..=10.0)]
fn trimmed_logistic(u: [Uniform; 1], s: f64, middle: f64) -> f64 {
    let low = 1.0 / (1.0 + (PI / s).exp());
    middle - s * (1.0 / (u[0] * (1.0 - 2.0 * low) + low) - 1.0).ln()
}

#[test]
fn a_power_of_a_quotient_is_inverted_as_a_whole() {
    let sampler = log_logistic(1.0, 1.0).expect("in the domain");
    for x in [-1e-6, -1e-12, 1e-9, 0.5, 1e3, 1e6, 1e12] {
        let truth = if x < 0.0 { 0.0 } else { 1.0 / (1.0 + x) / (1.0 + x) };
        close(sampler.pdf(&x).value(), truth);
    }
    let sampler = log_logistic(1.0f32, 1.0).expect("in the domain");
    assert_eq!([-0.1, -1e-3, -1e-6].map(|x| sampler.pdf(&x).value()), [0.0; 3]);
}

#[test]
fn an_exponential_of_parameters_may_be_out_of_the_range_of_numbers() {
    for s in [0.04f32, 0.035, 0.02, 0.011] {
        let sampler = trimmed_logistic(s, 0.0).expect("in the domain");
        let sample = sampler.sample([0.3]);
        let e = (-sample.value().abs() / s).exp();
        let expected = e / (s * (1.0 + e) * (1.0 + e));
        for found in [sample.pdf().value(), sampler.pdf(&sample).value()] {
            assert!((found / expected - 1.0).abs() < 1e-5, "{s}: {found}, expected {expected}");
        }
        assert_eq!(sampler.invert(&sample).iter().count(), 1);
    }
}

// Parameters next to the end of a domain.

#[sampler(m in 0.0..=10.0)]
fn nearly_uniform(u: [Uniform; 1], m: f64) -> f64 {
    if m < 1e-3 { u[0] } else { (u[0] * m.exp_m1()).ln_1p() / m }
}

#[test]
fn a_branch_may_be_taken_next_to_the_end_of_a_domain_alone() {
    for m in [0.0, 1e-4, 2e-3, 10.0] {
        let sampler = nearly_uniform(m).expect("in the domain");
        let truth = if m < 1e-3 { 1.0 } else { m * (m * 0.3).exp() / m.exp_m1() };
        let found = sampler.pdf(&0.3).value();
        assert!((found / truth - 1.0).abs() < 1e-12, "{m}: {found}, expected {truth}");
    }
}

/// A smoothstep that is faded in: cubic in u, and linear at t = 0.
#[sampler(t in 0.0..=1.0)]
fn faded(u: [Uniform; 1], t: f64) -> f64 {
    (1.0 - t) * u[0] + t * u[0] * u[0] * (3.0 - 2.0 * u[0])
}

#[test]
fn a_cubic_that_is_nearly_linear_keeps_the_digits_of_its_inverse() {
    for t in [1e-15, 1e-12, 1e-9, 1e-6, 1e-3, 0.5, 1.0] {
        let sampler = faded(t).expect("in the domain");
        for u in [0.05, 0.3, 0.5, 0.95] {
            let x = sampler.sample([u]).value();
            let found: Vec<[f64; 1]> = sampler.invert(&x).iter().collect();
            let is_near = matches!(found[..], [[v]] if (v - u).abs() < 1e-13);
            assert!(is_near, "{found:?} for {u}, t = {t:e}");
            let truth = 1.0 / ((1.0 - t) + 6.0 * t * u * (1.0 - u));
            assert!((sampler.pdf(&x).value() / truth - 1.0).abs() < 1e-12, "{t:e} {u}");
        }
    }
}

#[sampler]
fn closed_end(u: [Uniform; 1]) -> f64 {
    if u[0] > 0.5 { u[0] } else { (1.0 - 2.0 * u[0]).ln() }
}

#[sampler]
fn four_regions(u: [Uniform; 2]) -> Vec2 {
    let (a, b) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
    let (r, phi) = if a.abs() > b.abs() {
        if a > 0.0 { (a, FRAC_PI_4 * (b / a)) } else { (-a, FRAC_PI_4 * (4.0 + b / a)) }
    } else if b > 0.0 {
        (b, FRAC_PI_4 * (2.0 - a / b))
    } else {
        (-b, FRAC_PI_4 * (6.0 - a / b))
    };
    Vec2::new(r * phi.cos(), r * phi.sin())
}

#[test]
fn the_end_of_a_piece_that_belongs_to_it_has_a_sample() {
    let x = Sampler::<f64>::sample(&closed_end(), [0.5]);
    assert!(x.is_valid() && x.value().is_finite() && x.value() < -30.0, "{x:?}");
    // The second point of every Sobol sequence.
    let centre = Sampler::<f64>::sample(&four_regions(), [0.5, 0.5]);
    assert!(centre.is_valid() && centre.value().length() < 1e-15, "{centre:?}");
    assert!((centre.pdf().value() * PI - 1.0).abs() < 1e-12);
}

#[sampler(kappa in 1e-3..)]
fn von_mises_fisher(u: [Uniform; 2], kappa: f64) -> Direction {
    let w = 1.0 + 1.0 / kappa * (u[0] + (1.0 - u[0]) * (-2.0 * kappa).exp()).ln();
    let theta = TAU * u[1];
    let s = (1.0 - w * w).sqrt();
    Direction::new(s * theta.cos(), s * theta.sin(), w)
}

#[test]
fn no_direction_is_infinite() {
    for kappa in [1.0f64, 400.0, 1e4] {
        let x = von_mises_fisher(kappa).expect("in the domain").sample([0.0, 0.3]);
        assert!(!x.is_valid() || x.value().z.is_finite(), "{kappa}: {x:?}");
    }
    let x = von_mises_fisher(100.0f32).expect("in the domain").sample([0.0, 0.3]);
    assert!(!x.is_valid(), "{x:?}");
}

#[sampler]
fn normal_plane(u: [Uniform; 2]) -> Vec2 {
    let r = (-2.0 * (1.0 - u[0]).ln()).sqrt();
    let phi = TAU * u[1];
    Vec2::new(r * phi.cos(), r * phi.sin())
}

#[test]
fn a_table_over_a_tail_vanishes_with_it() {
    let table = PiecewiseConstant2D::new(&[1.0, 2.0, 3.0, 4.0], 2).expect("a table");
    let points = table.sampler().then(Warp(normal_plane()));
    let at = |r: f64| points.pdf(&Vec2::new(0.8 * r, 0.6 * r)).value();
    assert!(at(30.0) > 0.0 && at(38.0) < at(30.0));
    assert_eq!([39.0, 1e3, 1e300].map(at), [0.0; 3]);
}

// What the battery says of densities that are right.

#[sampler(s in 1e-3..=1e3)]
fn normal(u: [Uniform; 1], m: f64, s: f64) -> f64 {
    m + s * normal_quantile(u[0])
}

#[sampler(s1 in 1e-3..=1e3, s2 in 1e-3..=1e3, d in 1e-3..=1e3)]
fn two_slabs(u: [Uniform; 1], s1: f64, s2: f64, d: f64) -> f64 {
    let depth = -(1.0 - u[0]).ln();
    if depth < s1 * d { depth / s1 } else { d + (depth - s1 * d) / s2 }
}

#[test]
fn tails_that_end_within_the_unit_interval_are_no_contradictions() {
    let lobe = |m, s| normal(m, s).expect("in the domain");
    let lobes = [lobe(-1.0, 0.3), lobe(1.0, 0.5), lobe(0.0, 2.0)];
    battery::check(&aether_core::mixture::mixture(lobes, shares([1.0, 2.0, 3.0])).expect("shares"))
        .assert_ok();
    battery::check(&two_normals()).assert_ok();
}

#[test]
fn no_differences_are_taken_across_a_jump() {
    let slabs = two_slabs(1.0, 2.0, 0.5).expect("in the domain");
    Battery::new(&slabs).jumps(0, [0.5]).run().assert_ok();
}

// Points by weights that add up to one.

/// A triangle by its corners, as pbrt writes it (Heitz 2019).
#[sampler]
fn folded_triangle(u: [Uniform; 2], p0: Vec3, p1: Vec3, p2: Vec3) -> Surface {
    let (b0, b1) = if u[0] < u[1] {
        let b0 = u[0] / 2.0;
        (b0, u[1] - b0)
    } else {
        let b1 = u[1] / 2.0;
        (u[0] - b1, b1)
    };
    let b2 = 1.0 - b0 - b1;
    Surface::from_vec(b0 * p0 + b1 * p1 + b2 * p2)
}

/// A triangle by its corners (Turk 1990).
#[sampler]
fn weighed_triangle(u: [Uniform; 2], p0: Vec3, p1: Vec3, p2: Vec3) -> Surface {
    let root = u[0].sqrt();
    let (b0, b1) = (1.0 - root, u[1] * root);
    Surface::from_vec(b0 * p0 + b1 * p1 + (1.0 - b0 - b1) * p2)
}

/// A cube folded into a tetrahedron (Rocchini and Cignoni 2001).
#[sampler]
fn folded_cube(u: [Uniform; 3], v0: Vec3, v1: Vec3, v2: Vec3, v3: Vec3) -> Vec3 {
    let (s, t) = if u[0] + u[1] > 1.0 { (1.0 - u[0], 1.0 - u[1]) } else { (u[0], u[1]) };
    let (a, b, c) = if t + u[2] > 1.0 {
        (s, 1.0 - u[2], 1.0 - s - t)
    } else if s + t + u[2] > 1.0 {
        (1.0 - t - u[2], t, s + t + u[2] - 1.0)
    } else {
        (s, t, u[2])
    };
    (1.0 - a - b - c) * v0 + a * v1 + b * v2 + c * v3
}

#[test]
fn a_triangle_whose_plane_contains_the_origin_has_its_density() {
    let triangles = [
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        [[1.0, 1.0, 0.0], [3.0, 1.0, 0.0], [1.0, 2.0, 0.0]],
        [[1.0, 2.0, 3.0], [2.0, 4.0, 1.0], [0.0, 0.0, 0.0]],
        [[0.3, 0.1, 1.0], [1.0, 0.2, 1.5], [0.0, 1.0, 2.0]],
    ];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|[x, y, z]| Vec3::new(x, y, z));
        let truth = 2.0 / (b - a).cross(c - a).length();
        for u in [[0.39, 0.017], [0.2, 0.7], [0.9, 0.85]] {
            let (folded, weighed) = (folded_triangle(a, b, c), weighed_triangle(a, b, c));
            let (x, y) = (folded.sample(u), weighed.sample(u));
            close(folded.pdf(&x).value(), truth);
            close(weighed.pdf(&y).value(), truth);
            assert_eq!(
                [folded.invert(&x).iter().count(), weighed.invert(&y).iter().count()],
                [1, 1]
            );
        }
    }
}

#[test]
fn a_folded_cube_has_all_its_preimages_along_axes() {
    for v0 in [Vec3::new(0.0, 0.0, 0.0), Vec3::new(1.0, 1.0, 1.0), Vec3::new(0.1, -0.2, 0.3)] {
        let edges = [Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.0, 1.0, 0.0), Vec3::new(0.0, 0.0, 1.0)];
        let [v1, v2, v3] = edges.map(|edge| v0 + edge);
        let tetrahedron = folded_cube(v0, v1, v2, v3);
        for u in [[0.83, 0.3, 0.15], [0.2, 0.1, 0.4], [0.3, 0.6, 0.9]] {
            let x = tetrahedron.sample(u);
            close(x.pdf().value(), 6.0);
            close(tetrahedron.pdf(&x).value(), 6.0);
            assert_eq!(tetrahedron.invert(&x).iter().count(), 6);
        }
    }
}

// Domains in single precision.

#[sampler(s in 0.01..=0.8, t in 0.3..0.6)]
fn between_decimals(u: [Uniform; 1], s: f64, t: f64) -> f64 {
    t + s * u[0]
}

#[test]
fn the_end_of_a_domain_in_single_precision_is_within() {
    // Of these, 0.01 is rounded down and 0.8 up.
    for (s, next) in [(0.01f32, 0.01f32.next_up()), (0.8, 0.8f32.next_down())] {
        let sampler = between_decimals(s, 0.5).expect("is the end");
        let width = f64::from(sampler.sample([0.5]).value() - 0.5) * 2.0;
        assert!((width / f64::from(next) - 1.0).abs() < 1e-5);
        assert!((0.01..=0.8).contains(&f64::from(sampler.s)), "{}", sampler.s);
    }
    for s in [0.01f32.next_down(), 0.8f32.next_up()] {
        assert!(between_decimals(s, 0.5).is_err());
    }
    // The end of an open range is outside in any precision, and in double precision ends are as they are written.
    assert!(between_decimals(0.5, 0.6f32).is_err() && between_decimals(0.5, 0.6f64).is_err());
    assert!(between_decimals(0.8f64.next_up(), 0.5).is_err());
    assert_eq!(between_decimals(0.8f64, 0.5).expect("is the end").s, 0.8);
}

/// Ureña, Fajardo and King 2013, "An Area-Preserving Parametrization for Spherical Rectangles", as printed but for bounds.
#[sampler(
    x0 in -5.0..=5.0, x1 in -5.0..=5.0, y0 in -5.0..=5.0, y1 in -5.0..=5.0, z0 in -5.0..=-0.1,
    where x0 + 0.1 < x1, where y0 + 0.1 < y1
)]
fn spherical_rectangle(u: [Uniform; 2], x0: f64, x1: f64, y0: f64, y1: f64, z0: f64) -> Direction {
    let n0 = Vec3::new(0.0, z0, -y0).normalize();
    let n1 = Vec3::new(-z0, 0.0, x1).normalize();
    let n2 = Vec3::new(0.0, -z0, y1).normalize();
    let n3 = Vec3::new(z0, 0.0, -x0).normalize();
    let g0 = (-n0.dot(n1)).acos();
    let g1 = (-n1.dot(n2)).acos();
    let g2 = (-n2.dot(n3)).acos();
    let g3 = (-n3.dot(n0)).acos();
    let (b0, b1) = (n0.z, n2.z);
    let k = TAU - g2 - g3;
    let s = g0 + g1 - k;
    let au = u[0] * s + k;
    let fu = (au.cos() * b0 - b1) / au.sin();
    let cu = 1.0 / (fu * fu + b0 * b0).sqrt() * if fu > 0.0 { 1.0 } else { -1.0 };
    let xu = -(cu * z0) / (1.0 - cu * cu).sqrt();
    let d = (xu * xu + z0 * z0).sqrt();
    let h0 = y0 / (d * d + y0 * y0).sqrt();
    let h1 = y1 / (d * d + y1 * y1).sqrt();
    let hv = h0 + u[1] * (h1 - h0);
    let yv = (hv * d) / (1.0 - hv * hv).sqrt();
    Direction::from_vec(Vec3::new(xu, yv, z0).normalize())
}

/// Next to x = 0, where it changes its sign, a sample leads back to both pieces, to within rounding.
#[test]
fn a_sample_of_one_side_has_no_second_preimage_on_the_other() {
    for (half, distance) in [(0.1_f32, 5.0_f32), (5.0, 0.1), (1.0, 1.0)] {
        let rectangle = spherical_rectangle(-half, half, -half, half, -distance).unwrap();
        let square = f64::from(half * half);
        let angle = 4.0 * (square / (square + f64::from(distance * distance))).asin();
        for i in 0..1000u16 {
            let u = [0.5 + (f32::from(i) - 500.0) * 1e-5, (f32::from(i) * 0.618).fract()];
            let own = f64::from(rectangle.sample(u).pdf().value()) * angle;
            assert!((own - 1.0).abs() < 1e-3, "{own} at {u:?} of {half} at {distance}");
        }
    }
}

// Uniforms of exactly zero, as the first Sobol point has them.

/// pbrt-v3's anisotropic Beckmann normals.
#[sampler(alpha_x in 1e-2..=1.0, alpha_y in 1e-2..=1.0)]
fn beckmann_normals(u: [Uniform; 2], alpha_x: f64, alpha_y: f64) -> Direction {
    let log_sample = (1.0 - u[0]).ln();
    let phi = (alpha_y / alpha_x * (TAU * u[1] + 0.5 * PI).tan()).atan();
    let phi = if u[1] > 0.5 { phi + PI } else { phi };
    let (sin_phi, cos_phi) = phi.sin_cos();
    let (alpha_x2, alpha_y2) = (alpha_x * alpha_x, alpha_y * alpha_y);
    let tan2_theta = -log_sample / (cos_phi * cos_phi / alpha_x2 + sin_phi * sin_phi / alpha_y2);
    let cos_theta = 1.0 / (1.0 + tan2_theta).sqrt();
    let sin_theta = (1.0 - cos_theta * cos_theta).max(0.0).sqrt();
    Direction::new(sin_theta * cos_phi, sin_theta * sin_phi, cos_theta)
}

/// Ashikhmin and Shirley 2000, by quadrants.
#[sampler(nu in 0.0..=1e4, nv in 0.0..=1e4)]
fn phong_in_quadrants(u: [Uniform; 2], nu: f64, nv: f64) -> Direction {
    let k = ((nu + 1.0) / (nv + 1.0)).sqrt();
    let phi = if u[0] < 0.25 {
        (k * (TAU * u[0]).tan()).atan()
    } else if u[0] < 0.5 {
        PI - (k * (TAU * (0.5 - u[0])).tan()).atan()
    } else if u[0] < 0.75 {
        PI + (k * (TAU * (u[0] - 0.5)).tan()).atan()
    } else {
        TAU - (k * (TAU * (1.0 - u[0])).tan()).atan()
    };
    let (s, c) = phi.sin_cos();
    let cos_theta = (1.0 - u[1]).powf(1.0 / (nu * c * c + nv * s * s + 1.0));
    let sin_theta = (1.0 - cos_theta * cos_theta).sqrt();
    Direction::new(sin_theta * c, sin_theta * s, cos_theta)
}

/// At the pole the uniforms are 0/0 of the point, at the first turn a tangent is infinite there; and next to the pole the
/// derived volume has no digits where the density of the point has all.
#[test]
fn uniforms_of_zero_have_their_density() {
    for first in [0.0, 1e-18, 1e-9, 0.3] {
        for turn in [0.0, 0.1, 0.25, 0.3, 0.5, 0.6, 0.75, 0.9] {
            let (ax, ay) = (0.5, 0.2);
            let normals = beckmann_normals(ax, ay).unwrap();
            let n = normals.sample([first, turn]);
            let slopes = (n.x / ax).powi(2) + (n.y / ay).powi(2);
            let z2 = n.z * n.z;
            let expected = (-slopes / z2).exp() / (PI * ax * ay * n.z * z2);
            both(normals, [first, turn], expected);

            let (nu, nv) = (50.0, 10.0);
            let lobe = phong_in_quadrants(nu, nv).unwrap();
            let n = lobe.sample([turn, first]);
            let across = n.x * n.x + n.y * n.y;
            let share = if across > 0.0 { n.x * n.x / across } else { 0.0 };
            let power = nu * share + nv * (1.0 - share);
            let expected = ((nu + 1.0) * (nv + 1.0)).sqrt() / TAU * n.z.powf(power);
            both(lobe, [turn, first], expected);
        }
    }
}

// What is tested of a point.

#[sampler]
fn cosine_by_root(u: [Uniform; 2]) -> Direction {
    let r = (1.0 - u[0]).sqrt();
    let phi = TAU * u[1];
    Direction::new(r * phi.cos(), r * phi.sin(), u[0].sqrt())
}

#[sampler]
fn halves_of_a_parabola(u: [Uniform; 2]) -> Vec2 {
    let b = (u[1] - u[1] * u[1]).sqrt();
    if u[1] < 0.5 { Vec2::new(u[0], b) } else { Vec2::new(u[0], 3.0 - b) }
}

/// The unknown is z², which is between zero and one for every direction.
#[test]
fn a_root_has_no_preimage_below_the_horizon() {
    both(cosine_by_root(), [0.64, 0.3], 0.8 / PI);
    let below = direction(0.6, 0.0, -0.8);
    assert_eq!(cosine_by_root().pdf(&below).value(), 0.0);
    assert_eq!(Sampler::<f64>::invert(&cosine_by_root(), &below).iter().count(), 0);
}

/// The unknown is 1/2 + √(1 - 4 (3 - y)²) / 2, which is no number where it is not between zero and one.
#[test]
fn an_unknown_without_a_value_is_none() {
    for y in [-0.2, 0.7, 1.5, 2.4, 3.2, 3.6] {
        let x = Vec2::new(0.3, y);
        assert_eq!(halves_of_a_parabola().pdf(&x).value(), 0.0, "{y}");
        assert_eq!(Sampler::<f64>::invert(&halves_of_a_parabola(), &x).iter().count(), 0, "{y}");
    }
    for (y, b) in [(0.2, 0.2f64), (2.8, 0.2)] {
        let expected = 2.0 * b / (1.0 - 4.0 * b * b).sqrt();
        close(halves_of_a_parabola().pdf(&Vec2::new(0.3, y)).value(), expected);
    }
}

// Samples in heaps that are far apart.

#[sampler]
fn opposite_quarters(u: [Uniform; 2]) -> Direction {
    let phi = TAU * u[0];
    let z = if phi.cos() > 0.0 { u[1] } else { -u[1] };
    let r = (1.0 - z * z).sqrt();
    Direction::new(r * phi.cos(), r * phi.sin(), z)
}

#[sampler]
fn two_boxes(u: [Uniform; 2]) -> Vec2 {
    if u[0] < 0.5 { Vec2::new(u[0] * u[0], u[1]) } else { Vec2::new(u[0] + 2.0, u[1] * 0.5 + 5.0) }
}

/// What a bin has of two heaps at its ends is as narrow as it is full.
#[test]
fn right_densities_of_heaps_that_are_apart_pass_the_battery() {
    battery::check(&opposite_quarters()).assert_ok();
    battery::check(&two_boxes()).assert_ok();
}

/// A triangle by folding the unit square.
#[sampler]
fn triangle_by_folding(u: [Uniform; 2], a: Vec3, b: Vec3, c: Vec3) -> Surface {
    let (s, t) = if u[0] + u[1] > 1.0 { (1.0 - u[0], 1.0 - u[1]) } else { (u[0], u[1]) };
    Surface::from_vec((1.0 - s - t) * a + s * b + t * c)
}

/// At the fold the map jumps: a preimage that rounding carried over it is one beside it.
#[test]
fn points_of_a_fold_have_preimages() {
    let corners = [
        [Vec3::new(0.0, 0.0, 1.0), Vec3::new(1.0, 0.2, 1.5), Vec3::new(0.3, 1.0, 0.0)],
        [Vec3::new(-1.3, 0.7, 0.1), Vec3::new(1.1, 1.9, -0.6), Vec3::new(0.2, -1.7, 1.4)],
    ];
    for [a, b, c] in corners {
        let triangle = triangle_by_folding(a, b, c);
        let full = 1.0 / (b - a).cross(c - a).length() * 2.0;
        for i in 1..64 {
            let u = f64::from(i) / 64.0;
            let x = triangle.sample([u, 1.0 - u]);
            let (own, p) = (x.pdf().value(), triangle.pdf(&x).value());
            let is_once_or_twice = [0.5, 1.0].iter().any(|k| (p / full - k).abs() < 1e-13);
            assert!(is_once_or_twice && (own - p).abs() < 1e-13 * p, "{u}: {own} {p} {full}");
        }
    }
}

/// A cell of the sky, uniform in solid angle.
#[sampler(
    z0 in -1.0..=1.0, z1 in -1.0..=1.0, p0 in 0.0..=6.283185307179586, p1 in 0.0..=6.283185307179586,
    where z0 < z1, where p0 < p1
)]
fn sky_cell(u: [Uniform; 2], z0: f64, z1: f64, p0: f64, p1: f64) -> Direction {
    let z = z0 + u[0] * (z1 - z0);
    let r = (1.0 - z * z).sqrt();
    let phi = p0 + u[1] * (p1 - p0);
    Direction::new(r * phi.cos(), r * phi.sin(), z)
}

/// An angle next to where a range begins is no whole turn above.
#[test]
fn a_range_of_angles_has_density_where_it_begins() {
    for k in 1..100 {
        let p0 = 0.06 * f64::from(k);
        let cell = sky_cell(-0.5, 0.7, p0, p0 + 0.3).unwrap();
        for u in [0.0, 1e-17, 0.5, 1.0 - f64::EPSILON] {
            let x = cell.sample([0.3, u]);
            assert!((cell.pdf(&x).value() * 0.36 - 1.0).abs() < 1e-12, "{p0} {u}");
        }
        let outside = cell.sample([0.3, 0.5]);
        let opposite = Direction::from_vec(Vec3::new(-outside.x, -outside.y, outside.z));
        assert_eq!(cell.pdf(&opposite).value(), 0.0);
    }
    let whole = sky_cell(-1.0, 1.0, 0.0, TAU).unwrap();
    for u in [0.0, 0.3, 1.0 - f64::EPSILON] {
        let x = whole.sample([0.3, u]);
        assert!((whole.pdf(&x).value() * 4.0 * PI - 1.0).abs() < 1e-12, "{u}");
    }
}

/// Directions between two angles from the pole, uniform in solid angle.
#[sampler(t0 in 1e-6..=3.14, t1 in 1e-6..=3.14, where t0 < t1)]
fn between_angles(u: [Uniform; 2], t0: f64, t1: f64) -> Direction {
    let z = (1.0 - u[0]) * t0.cos() + u[0] * t1.cos();
    let r = (1.0 - z * z).sqrt();
    let phi = TAU * u[1];
    Direction::new(r * phi.cos(), r * phi.sin(), z)
}

/// Two cosines next to one have no digits left for their difference, which is a product of sines.
#[test]
fn a_narrow_zone_next_to_the_pole_has_all_digits_of_its_density() {
    for (t0, t1) in [(1e-6, 2e-6), (1e-3, 1.5e-3)] {
        let zone = between_angles(t0, t1).unwrap();
        // 1 - cos t = t²/2 - t⁴/24
        let (low, high): (f64, f64) = (t0 * t0, t1 * t1);
        let height = 0.5 * (high - low) * (1.0 - (high + low) / 12.0);
        close(zone.sample([0.5, 0.3]).pdf().value(), 1.0 / (TAU * height));
    }
}

/// A fisheye camera whose angle from the axis grows with the distance from the centre of the film.
#[sampler(fov in 0.1..=6.28)]
fn equidistant_fisheye(u: [Uniform; 2], fov: f64) -> Option<Direction> {
    let (x, y) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
    let r = (x * x + y * y).sqrt();
    if r > 1.0 {
        return None;
    }
    let (theta, phi) = (0.5 * r * fov, y.atan2(x));
    Some(Direction::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()))
}

/// One whose pixels see equal solid angles.
#[sampler]
fn equisolid_fisheye(u: [Uniform; 2]) -> Option<Direction> {
    let (x, y) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
    let r2 = x * x + y * y;
    if r2 > 1.0 {
        return None;
    }
    let (theta, phi) = (2.0 * (r2.sqrt() / SQRT_2).asin(), y.atan2(x));
    Some(Direction::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()))
}

/// Uniform in a hyperbolic disk, as points of the Poincaré disk.
#[sampler(radius in 0.1..=5.0)]
fn hyperbolic_disk(u: [Uniform; 2], radius: f64) -> Vec2 {
    let rho = (1.0 + u[0] * (radius.cosh() - 1.0)).acosh();
    let r = (rho / 2.0).tanh();
    let phi = TAU * u[1];
    Vec2::new(r * phi.cos(), r * phi.sin())
}

/// A film has an axis in its middle, where angles are 0/0 and cosines are one.
#[test]
fn cameras_see_along_their_axis() {
    assert_eq!(EquisolidFisheye::DERIVATION.pdf, "1/8");
    let middle = [0.5, 0.500_000_001, 0.500_000_1, 0.6];
    for u in middle.iter().flat_map(|u| middle.map(|v| [*u, v])) {
        let camera = equidistant_fisheye(3.0).unwrap();
        let theta = 3.0 * (u[0] - 0.5_f64).hypot(u[1] - 0.5);
        // Of r dr for sin θ dθ, per four units of film.
        let stretch = if theta > 0.0 { theta / theta.sin() } else { 1.0 };
        let sample = camera.sample(u);
        for found in [sample.pdf().value(), camera.pdf(&sample).value()] {
            assert!((found * 9.0 / stretch - 1.0).abs() < 1e-14, "{u:?} {found}");
        }
        both(equisolid_fisheye(), u, 0.125);
    }
    assert!(battery::check(&equidistant_fisheye(3.0).unwrap()).failures().next().is_none());
    assert!(battery::check(&equisolid_fisheye()).failures().next().is_none());
    for u in [[0.5_f32, 0.5], [0.500_01, 0.500_01], [0.500_1, 0.5]] {
        let camera = equidistant_fisheye(3.0_f32).unwrap();
        let sample = camera.sample(u);
        let found = [sample.pdf().value(), camera.pdf(&sample).value()];
        assert!(found.iter().all(|p| (9.0 * p - 1.0).abs() < 4e-6), "{u:?} {found:?}");
    }
}

/// acosh(1 + s) has digits of s where 1 + s has none.
#[test]
fn a_hyperbolic_disk_has_a_middle() {
    for (radius, u) in [(0.1, 0.0), (0.1, 1e-14), (0.1, 1e-7), (2.0, 0.0), (2.0, 1e-30), (5.0, 0.9)]
    {
        let disk = hyperbolic_disk(radius).unwrap();
        let sample = disk.sample([u, 0.3]);
        let half: f64 = (0.5 * radius).sinh();
        let s = 2.0 * u * half * half;
        // r² = s / (2 + s), and the area of the hyperbolic plane is 4 / (1 - r²)² times that of the disk.
        let r2 = s / (2.0 + s);
        let found = sample.value().x.hypot(sample.value().y);
        assert!((found - r2.sqrt()).abs() <= 1e-14 * r2.sqrt(), "{radius} {u} {found}");
        let truth = 1.0 / ((1.0 - r2).powi(2) * PI * half * half);
        for p in [sample.pdf().value(), disk.pdf(&sample).value()] {
            assert!((p - truth).abs() <= 2e-13 * truth, "{radius} {u} {p} {truth}");
        }
    }
    for (radius, u) in [(0.1_f32, 0.0), (0.1, 1e-5), (1.0, 6e-8)] {
        let disk = hyperbolic_disk(radius).unwrap();
        let sample = disk.sample([u, 0.3]);
        let truth = 1.0 / (core::f32::consts::PI * (0.5 * radius).sinh().powi(2));
        for p in [sample.pdf().value(), disk.pdf(&sample).value()] {
            assert!((p - truth).abs() <= 1e-4 * truth, "{radius} {u} {p} {truth}");
        }
    }
}

/// The sphere by twice an arc sine, which is a sine and a cosine without it.
#[sampler]
fn sphere_by_half_angles(u: [Uniform; 2]) -> Direction {
    let theta = 2.0 * u[0].sqrt().asin();
    let phi = TAU * u[1];
    Direction::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
}

#[test]
fn twice_an_angle_leaves_no_trace_in_a_density() {
    assert_eq!(SphereByHalfAngles::DERIVATION.pdf, "1 / (4 π)");
    both(sphere_by_half_angles(), [0.3, 0.7], 0.25 / PI);
}

// Points on lines in whatever direction, of which single coordinates may not vary.

#[sampler]
fn segment(u: [Uniform; 1], a: Vec3, b: Vec3) -> Curve {
    Curve::from_vec(a + u[0] * (b - a))
}

#[sampler(s in 1e-3..=1e3)]
fn flight_along(u: [Uniform; 1], o: Vec3, d: Direction, s: f64) -> Curve {
    Curve::from_vec(o - (-u[0]).ln_1p() / s * d)
}

#[sampler]
fn segment_of_plane(u: [Uniform; 1], a: Vec2, b: Vec2) -> Embedded<1, 2> {
    let p = a + u[0] * (b - a);
    Embedded([p.x, p.y])
}

#[map]
fn along(t: f64, o: Vec3, d: Vec3) -> Curve {
    Curve::from_vec(o + t * d)
}

#[map]
fn gnomonic(w: Direction, h: f64) -> Surface {
    require(w.z > 0.0);
    Surface::new(h * w.x / w.z, h * w.y / w.z, h)
}

#[test]
fn a_line_may_be_parallel_to_any_axis() {
    let a = Vec3::new(1.0, -0.5, 2.0);
    for d in [[0.0, 2.0, 3.0], [0.0, 0.0, -2.0], [1e-12, 0.0, 1.0], [1.0, 1.0, 0.0]] {
        let d = Vec3::new(d[0], d[1], d[2]);
        let length: f64 = d.length();
        both(segment(a, a + d), [0.3], 1.0 / (a + d - a).length());
        both(segment_of_line().then(along(a, d)), [0.3], 0.5 / length);
        let w = Direction::from_vec(d / length);
        let flight = flight_along(a, w, 2.0).unwrap();
        both(flight, [0.3], 2.0 * 0.7);
        let (p, q) = (Vec2::new(a.x, a.z), Vec2::new(d.x, d.z));
        if q.length() > 0.0 {
            both(segment_of_plane(p, p + q), [0.3], 1.0 / (p + q - p).length());
        }
    }
    // In single precision as well, nearly along an axis.
    let flight = flight_along(
        Vec3::new(1.0, 0.0, 0.0),
        Direction::from_unit(Vec3::new(1e-7, 0.0, 1.0)),
        2.0,
    );
    let flight: FlightAlong<f32> = flight.unwrap();
    let sample = flight.sample([0.44]);
    for p in [sample.pdf().value(), flight.pdf(&sample).value()] {
        assert!((p - 1.12).abs() < 1e-5, "{p}");
    }
}

/// Uniform on [0, 2).
#[sampler]
fn segment_of_line(u: [Uniform; 1]) -> f64 {
    2.0 * u[0]
}

#[test]
fn a_direction_seen_on_a_plane_is_found_again() {
    let seen = sphere_by_half_angles().then(gnomonic(2.0));
    let sample = seen.sample([0.2, 0.7]);
    let w = sphere_by_half_angles().sample([0.2, 0.7]).value();
    // Solid angle per area is the cosine over the squared distance.
    let truth = 0.25 / PI * w.z.powi(3) / 4.0;
    close(sample.pdf().value(), truth);
    close(seen.pdf(&sample).value(), truth);
}

// Cubic polynomials whose leading coefficient may vanish.

#[sampler(m0 in 0.0..=3.0, m1 in 0.0..=3.0)]
fn hermite(u: [Uniform; 1], m0: f64, m1: f64) -> f64 {
    let t = u[0];
    let (t2, t3) = (t * t, t * t * t);
    (t3 - 2.0 * t2 + t) * m0 + (3.0 * t2 - 2.0 * t3) + (t3 - t2) * m1
}

#[sampler]
fn cubic_of_line(u: [Uniform; 1], a: f64, b: f64, c: f64) -> f64 {
    let t = u[0];
    a * t.powi(3) + b * t.powi(2) + c * t
}

#[sampler]
fn bezier(u: [Uniform; 1], a: Vec3, b: Vec3, c: Vec3, d: Vec3) -> Curve {
    let (t, s) = (u[0], 1.0 - u[0]);
    Curve::from_vec(
        s.powi(3) * a + 3.0 * s.powi(2) * t * b + 3.0 * s * t.powi(2) * c + t.powi(3) * d,
    )
}

#[test]
fn a_cubic_without_its_cube_is_a_quadratic() {
    for (m0, m1) in [(1.0, 1.0), (0.5, 1.5), (1.5, 0.5), (1.0, 1.0 + 1e-9), (0.5, 1.0)] {
        for t in [0.1, 0.3, 0.5, 0.9] {
            let slope =
                m0 * (3.0 * t - 1.0) * (t - 1.0) + 6.0 * t * (1.0 - t) + m1 * t * (3.0 * t - 2.0);
            let hermite = hermite(m0, m1).unwrap();
            let sample = hermite.sample([t]);
            for p in [sample.pdf().value(), hermite.pdf(&sample).value()] {
                assert!((p * slope - 1.0).abs() < 1e-12, "{m0} {m1} {t} {p}");
            }
        }
    }
    for a in [0.0, 1e-300, 1e-9, -1e-9, 1e-6, 1e-3, 0.1, -0.1, 10.0] {
        for (b, c) in [(0.5, 1.0), (-0.3, 1.0), (0.0, 2.0), (1.0, 1e-3)] {
            for t in [1e-9, 0.1, 0.5, 0.9] {
                let slope: f64 = c + 2.0 * b * t + 3.0 * a * t * t;
                let cubic = cubic_of_line(a, b, c);
                let sample = cubic.sample([t]);
                let found = cubic.pdf(&sample).value();
                let there = cubic.invert(&sample.value());
                let nearest = there.iter().map(|u| (u[0] - t).abs()).fold(1.0, f64::min);
                assert!(nearest < 1e-13 / slope.abs(), "{a} {b} {c} {t}: off by {nearest:e}");
                if there.len() == 1 {
                    assert!((found * slope.abs() - 1.0).abs() < 1e-12, "{a} {b} {c} {t} {found}");
                }
            }
        }
    }
    let p = Vec3::new;
    for (b, c) in [
        (p(1.0, 2.0, 0.0), p(2.0, -1.0, 0.5)),
        (p(1.0, 0.0, 0.0), p(2.0, 1.0, 0.0)),
        (p(0.0, 2.0, 1.0), p(3.0, 2.0, 1.0)),
    ] {
        let d = p(3.0, 1.0, 1.0);
        let curve = bezier(p(0.0, 0.0, 0.0), b, c, d);
        for t in [0.1, 0.4, 0.7] {
            let s: f64 = 1.0 - t;
            let speed = (3.0 * s * s * b + 6.0 * s * t * (c - b) + 3.0 * t * t * (d - c)).length();
            let sample = curve.sample([t]);
            for p in [sample.pdf().value(), curve.pdf(&sample).value()] {
                assert!((p * speed - 1.0).abs() < 1e-11, "{b:?} {t} {p} {speed}");
            }
        }
    }
}

// A cylinder as it is seen, where single coordinates of a direction vanish.

#[sampler]
fn cylinder_seen(u: [Uniform; 2], o: Vec3, r: f64, h: f64) -> Direction {
    let phi = TAU * u[1];
    let p = Vec3::new(r * phi.cos(), r * phi.sin(), h * u[0]);
    Direction::from_vec((p - o).normalize())
}

#[test]
fn a_cylinder_is_seen_in_planes_of_coordinates_too() {
    for (o, u0) in [([0.0, 0.0, 0.0], 0.3), ([0.3, 0.2, 0.1], 0.6), ([0.0, -0.5, 1.0], 0.1)] {
        let seen = cylinder_seen(Vec3::new(o[0], o[1], o[2]), 1.0, 2.0);
        for u1 in [0.0, 0.25, 0.5, 0.75, 0.1, 1e-9] {
            let phi: f64 = TAU * u1;
            let d = Vec3::new(phi.cos() - o[0], phi.sin() - o[1], 2.0 * u0 - o[2]);
            // Squared distance over the cosine, of points uniform by area, of which one is seen from within.
            let cosine = (d.x * phi.cos() + d.y * phi.sin()) / d.length();
            let truth = d.dot(d) / cosine / (2.0 * TAU);
            let sample = seen.sample([u0, u1]);
            for p in [sample.pdf().value(), seen.pdf(&sample).value()] {
                assert!((p / truth - 1.0).abs() < 1e-12, "{o:?} {u1} {p} {truth}");
            }
        }
        // Where the first coordinate is zero exactly.
        let w = Direction::from_vec(Vec3::new(0.0, 1.0, 0.1).normalize());
        let beside = Direction::from_vec(Vec3::new(1e-9, 1.0, 0.1).normalize());
        let [at, near] = [w, beside].map(|w| seen.pdf(&w).value());
        assert!((at / near - 1.0).abs() < 1e-7, "{at} {near}");
    }
}

// Comparisons of which the outcome follows from others.

#[sampler]
fn in_order(u: [Uniform; 3]) -> Vec3 {
    let (a, b) = (u[0].min(u[1]), u[0].max(u[1]));
    let (c, d) = (b.min(u[2]), b.max(u[2]));
    Vec3::new(a.min(c), a.max(c), d)
}

#[map]
fn onto_cube(w: Direction) -> Surface {
    let (x, y, z) = (w.x.abs(), w.y.abs(), w.z.abs());
    if x > y && x > z {
        Surface::from_vec(w.vec() / x)
    } else if y > z {
        Surface::from_vec(w.vec() / y)
    } else {
        Surface::from_vec(w.vec() / z)
    }
}

#[test]
fn what_is_larger_than_the_larger_one_is_the_largest() {
    // Six orders of three uniforms.
    for u in [[0.3, 0.9, 0.5], [0.9, 0.5, 0.3], [0.2, 0.1, 0.8]] {
        both(in_order(), u, 6.0);
        let mut sorted = u;
        sorted.sort_by(f64::total_cmp);
        let x = in_order().sample(u).value();
        assert_eq!([x.x, x.y, x.z], sorted);
    }
    assert_eq!(in_order().pdf(&Vec3::new(0.5, 0.3, 0.9)).value(), 0.0);
    let cube = Sampler::<f64>::then(sphere_by_half_angles(), onto_cube());
    for u in [[0.1, 0.2], [0.5, 0.01], [0.5, 0.26], [0.45, 0.6], [0.9, 0.8], [0.4, 0.74]] {
        let sample = cube.sample(u);
        let x = sample.value().vec();
        // Solid angle per area of a face at a distance of one.
        let truth = 0.25 / PI / x.length().powi(3);
        for p in [sample.pdf().value(), cube.pdf(&sample).value()] {
            assert!((p / truth - 1.0).abs() < 1e-13, "{u:?} {p} {truth}");
        }
    }
}

/// The square of what divides the sample leaves the range of numbers before it does.
#[sampler(a in 0.001..=700.0)]
fn over_a_large_cosine(u: [Uniform; 1], a: f64) -> f64 {
    (a * u[0]).sinh() / a.cosh()
}

#[test]
fn one_and_a_square_that_overflows_have_a_root() {
    // The density is cosh a / (a cosh(a u)).
    for (a, u) in [(700.0, 0.99), (700.0, 0.6), (400.0, 0.9), (2.0, 0.3)] {
        let sampler = over_a_large_cosine(a).unwrap();
        let sample = sampler.sample([u]);
        let truth = f64::cosh(a) / (a * f64::cosh(a * u));
        for p in [sample.pdf().value(), sampler.pdf(&sample).value()] {
            assert!((p / truth - 1.0).abs() < 1e-12, "{a} {u} {p} {truth}");
        }
    }
    for (a, u) in [(80.0_f32, 0.99_f32), (85.0, 0.8), (50.0, 0.95)] {
        let sampler = over_a_large_cosine(a).unwrap();
        let sample = sampler.sample([u]);
        let truth = a.cosh() / (a * (a * u).cosh());
        for p in [sample.pdf().value(), sampler.pdf(&sample).value()] {
            assert!((p / truth - 1.0).abs() < 1e-4, "{a} {u} {p} {truth}");
        }
    }
}

/// A sphere but for its poles, by quotients of large numbers.
#[sampler(a in 1e-6..=1e6)]
fn sphere_by_large_numbers(u: [Uniform; 2], a: f64) -> Direction {
    let q = a.powi(4);
    let c = (2.0 * u[0] - 1.0) * q / (1.0 + q);
    let r = (1.0 - c * c).sqrt();
    let phi = TAU * u[1];
    Direction::new(r * phi.cos(), r * phi.sin(), c)
}

#[test]
fn roots_of_a_product_that_overflows_are_taken_apart() {
    for a in [1e6_f32, 3e5, 1e4, 1.0] {
        let sampler = sphere_by_large_numbers(a).unwrap();
        for u in [[0.3_f32, 0.2], [0.5, 0.6], [0.999, 0.9], [1e-6, 0.4]] {
            let sample = sampler.sample(u);
            let w = sample.value();
            assert!((w.dot(w) - 1.0).abs() < 1e-5, "{a} {u:?} {w:?}");
            let q = f64::from(a).powi(4);
            let truth = (1.0 + q) / (4.0 * PI * q);
            for p in [sample.pdf().value(), sampler.pdf(&sample).value()] {
                assert!((f64::from(p) / truth - 1.0).abs() < 1e-5, "{a} {u:?} {p} {truth}");
            }
        }
    }
}

/// A weight between zero and one whose inverse, taken over eˢ, is infinity over infinity in single precision.
#[sampler(s in 0.0..=200.0)]
fn with_a_small_exponential(u: [Uniform; 1], s: f64) -> f64 {
    let k = (-s).exp();
    u[0] / (1.0 + k * u[0])
}

#[test]
fn an_exponential_above_and_below_the_line_is_taken_over_it() {
    for s in [0.0_f32, 1.0, 50.0, 100.0, 150.0, 200.0] {
        let sampler = with_a_small_exponential(s).unwrap();
        for u in [0.1_f32, 0.5, 0.9] {
            let sample = sampler.sample([u]);
            let truth = (1.0 + (-s).exp() * u).powi(2);
            for p in [sample.pdf().value(), sampler.pdf(&sample).value()] {
                assert!((p / truth - 1.0).abs() < 1e-5, "{s} {u} {p} {truth}");
            }
        }
    }
}

/// A truncated exponential as it is often written, with what loses its digits for a small rate.
#[sampler(k in 0.0..=30.0)]
fn exponential_without_expm1(u: [Uniform; 1], k: f64) -> f64 {
    let m = 1.0 - (-k).exp();
    -(1.0 - m * u[0]).ln() / k
}

#[test]
fn a_limit_that_the_written_form_has_not() {
    for k in [0.0, 1e-300, 1e-17, 1e-12, 1e-6] {
        let sampler = exponential_without_expm1(k).unwrap();
        for u in [0.1, 0.5, 0.9] {
            let sample = sampler.sample([u]);
            assert!((sample.value() - u).abs() < 1e-6, "{k} {u} {}", sample.value());
            for p in [sample.pdf().value(), sampler.pdf(&sample).value()] {
                assert!((p - 1.0).abs() < 1e-6, "{k} {u} {p}");
            }
        }
    }
    for k in [0.0_f32, 1e-20, 1e-5] {
        let sampler = exponential_without_expm1(k).unwrap();
        let sample = sampler.sample([0.3]);
        assert!((sample.value() - 0.3).abs() < 1e-5);
        for p in [sample.pdf().value(), sampler.pdf(&sample).value()] {
            assert!((p - 1.0).abs() < 1e-5, "{k} {p}");
        }
    }
}
