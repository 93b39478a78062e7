//! Programs that random search found to be refused, or compiled wrongly, and what is right for them.

use aether_engine::interpret::Item;

fn compile(item: &str) -> Item {
    let tokens = item.parse().expect("tokens");
    Item::new(Default::default(), tokens, true).unwrap_or_else(|e| panic!("{item}: {e}"))
}

/// Comparisons are made in the same order when the range of `floor`'s argument is known better.
#[test]
fn floor_before_another_comparison() {
    let item = compile(
        "fn teeth(u: [Uniform; 1]) -> f64 { let t = (3.0 * u[0]).fract(); t.max(1.0 - t) }",
    );
    for k in 0..100 {
        let u = (f64::from(k) + 0.37) / 100.0;
        let t = (3.0 * u).fract();
        let x = item.forward(&[], &[u]).expect("a value")[0];
        assert!((x - t.max(1.0 - t)).abs() < 1e-12, "{u}: {x}");
        assert_eq!(item.preimages(&[], &[x]).len(), 6);
        assert!((item.pdf(&[], &[x]) - 2.0).abs() < 1e-12);
    }
}

/// The second comparison of the same two numbers has one outcome.
#[test]
fn the_larger_and_the_smaller_uniform() {
    let item =
        compile("fn sorted(u: [Uniform; 2]) -> Vec2 { Vec2::new(u[0].max(u[1]), u[0].min(u[1])) }");
    assert_eq!(item.parsed.pieces.len(), 2);
    assert!((item.pdf(&[], &[0.7, 0.2]) - 2.0).abs() < 1e-12);
}

/// Unit vectors that are moved or stretched and normalised again: λ X lies on a quadric.
#[test]
fn normalised_again() {
    let unit = "let r = (1.0 - u[0] * u[0]).sqrt(); let phi = TAU * u[1];
        let v = Vec3::new(r * phi.cos(), r * phi.sin(), u[0]);";
    for last in [
        "(v + Vec3::new(0.0, 0.0, 0.5)).normalize()",
        "(v + Vec3::new(0.3, -0.2, 0.4)).normalize()",
        "Vec3::new(3.0 * v.x, 0.6 * v.y, v.z).normalize()",
    ] {
        let item = compile(&format!(
            "fn moved(u: [Uniform; 2]) -> Direction {{ {unit} Direction::from_vec({last}) }}"
        ));
        let u = [0.3, 0.6];
        let x = item.forward(&[], &u).expect("a value");
        let found = item.preimages(&[], &x);
        assert!(found.len() == 1 && (found[0][0] - 0.3).abs() < 1e-9, "{last}: {found:?}");
    }
}

/// At the border of a power no inverse can recover the uniform from the rotated point.
#[test]
fn a_power_rotated() {
    compile(
        "fn turned(u: [Uniform; 2]) -> Vec2 { let x = u[0] * u[0];
            Vec2::new(0.6 * x - 0.8 * u[1], 0.8 * x + 0.6 * u[1]) }",
    );
}

/// A factor of zero hides that the unknown occurs elsewhere: the equation is not one in 1 - u.
#[test]
fn an_unknown_inside_and_outside_of_a_factor() {
    let item = compile(
        "fn f(u: [Uniform; 1]) -> f64 { (1.0 - u[0]).sqrt() * (-(1.0 + u[0]).sqrt()).exp() }",
    );
    for u in [0.03, 0.4, 0.97] {
        let at = |u: f64| item.forward(&[], &[u]).expect("a value")[0];
        let (x, h) = (at(u), 1e-6);
        let found = item.preimages(&[], &[x]);
        assert!(found.len() == 1 && (found[0][0] - u).abs() < 1e-12, "{u}: {found:?}");
        let slope = (at(u - h) - at(u + h)) / (2.0 * h);
        assert!((item.pdf(&[], &[x]) * slope - 1.0).abs() < 1e-6);
    }
}

/// A product of two auxiliary unknowns is known, and neither of them alone: the density must do
/// without.
#[test]
fn a_product_of_auxiliary_unknowns() {
    let item = compile(
        "fn f(u: [Uniform; 2]) -> Direction {
            let v = Vec3::new((2.0 * u[0] - 1.0).asin(), 1.5, u[1].tanh()).normalize();
            let (s, c) = (0.25 * PI).sin_cos();
            let w = Vec3::new(v.x, c * v.y - s * v.z, s * v.y + c * v.z);
            Direction::from_vec(Vec3::new(1.25 * w.x, 0.25 * w.y, w.z).normalize())
        }",
    );
    let x = item.forward(&[], &[0.3, 0.6]).expect("a value");
    let found = item.preimages(&[], &x);
    assert!((found[0][0] - 0.3).abs() < 1e-12 && (found[0][1] - 0.6).abs() < 1e-12, "{found:?}");
    assert!(item.pdf(&[], &x).is_finite() && item.pdf(&[], &x) > 0.0);
}

/// What uniforms map to leads back to them.
fn leads_back(item: &str) {
    let item = compile(item);
    for u in [[0.3, 0.6], [0.71, 0.16], [0.05, 0.93]] {
        let x = item.forward(&[], &u).expect("a value");
        let found = item.preimages(&[], &x);
        let near = |v: &Vec<f64>| (v[0] - u[0]).abs() < 1e-9 && (v[1] - u[1]).abs() < 1e-9;
        assert!(found.iter().any(near), "{u:?}: {found:?}");
    }
}

/// Lengths that are divided by, where coordinates have rational factors, and where lengths are nested.
#[test]
fn stretched_spheres() {
    leads_back(
        "fn stretched(u: [Uniform; 2]) -> Direction { let z = 2.0 * u[0] - 1.0;
            let r = (1.0 - z * z).sqrt(); let phi = TAU * u[1];
            Direction::from_vec(Vec3::new(2.5 * r * phi.cos(), 2.0 * r * phi.sin(), z).normalize()) }",
    );
    leads_back(
        "fn moved(u: [Uniform; 2]) -> Direction { let v = Vec3::new(u[0], 1.5, u[1]).normalize();
            Direction::from_vec((v + Vec3::new(0.0, 0.0, 0.5)).normalize()) }",
    );
}

/// A window of angles that begins at no multiple of a quarter turn, at its very beginning.
#[test]
fn the_first_angle_of_a_window() {
    leads_back(
        "fn window(u: [Uniform; 2]) -> Direction { let r = u[0];
            let (sin, cos) = (TAU * ((u[1] + 0.5) / 1.7)).sin_cos();
            Direction::from_vec(Vec3::new(r * cos, 1.5, r * sin).normalize()) }",
    );
}

/// Where the tangent is vertical, differences with any step are wrong, and say nothing about the Jacobian.
#[test]
fn a_cube_root_of_a_cosine() {
    let item = compile("fn root(u: [Uniform; 1]) -> f64 { let x = (PI * u[0]).cos().cbrt(); x }");
    // x³ = cos(π u), so that du/dx = 3 x² / (π sin(π u)).
    let (x, u) = (0.5f64, 0.125f64.acos() / std::f64::consts::PI);
    let truth = 0.75 / (std::f64::consts::PI * (1.0 - 0.125f64 * 0.125).sqrt());
    assert!((item.pdf(&[], &[x]) / truth - 1.0).abs() < 1e-12);
    assert!((item.preimages(&[], &[x])[0][0] - u).abs() < 1e-12);
}

/// A curve that an earlier number moves: its density is per length of the curve as that number leaves it, whatever way the
/// points go as the number changes.
#[test]
fn a_number_and_a_point_of_a_curve_that_moves_with_it() {
    let circle = "let phi = TAU * u[1]; let circle = Curve::new((1.0 + t) * phi.cos(), (1.0 + t) * phi.sin(), t * t);";
    for (space, last) in [("(f64, Curve)", "(t, circle)"), ("(Curve, f64)", "(circle, t)")] {
        let item = compile(&format!(
            "fn ring(u: [Uniform; 2]) -> {space} {{ let t = u[0].sqrt(); {circle} {last} }}"
        ));
        let x = item.forward(&[], &[0.49, 0.3]).expect("a value");
        // 2 t per length of the number, and one over the length of the circle.
        let expected = 2.0 * 0.7 / (std::f64::consts::TAU * 1.7);
        let found = item.pdf(&[], &x);
        assert!((found / expected - 1.0).abs() < 1e-12, "{space}: {found} {expected}");
    }
}

/// The sine of the angle of a lobe of Henyey and Greenstein whose anisotropy is an exponential: its square, 1 - c², is a
/// product, of which nothing cancels next to the poles and nothing leaves the range of numbers.
#[test]
fn a_cosine_over_an_exponential_has_a_sine_in_factors() {
    let item = compile(
        "fn scattered(u: [Uniform; 3]) -> (f64, Direction) {
            let t = u[0];
            let g = 0.9 * (-t).exp();
            let s = (1.0 - g * g) / (1.0 - g + 2.0 * g * u[1]);
            let c = (1.0 + g * g - s * s) / (2.0 * g);
            let r = (1.0 - c * c).sqrt();
            let phi = TAU * u[2];
            (t, Direction::new(r * phi.cos(), r * phi.sin(), c))
        }",
    );
    for (t, v) in [(0.4, 0.3), (0.7, 1e-12), (0.2, 1.0 - 1e-12)] {
        let x = item.forward(&[], &[t, v, 0.0]).expect("a value");
        let g = 0.9 * (-t).exp();
        let product = v * (1.0 - v) * (1.0 + g * v) * (1.0 - g + g * v);
        let expected = 2.0 * product.sqrt() * (1.0 - g * g) / (1.0 - g + 2.0 * g * v).powi(2);
        assert!((x[1] / expected - 1.0).abs() < 1e-13, "{t} {v}: {} {expected}", x[1]);
    }
}

/// What a body makes of functions has no value where one of them has none, whatever is left of them: no sample there, and no
/// density.
#[test]
fn a_function_that_is_undone_has_its_domain() {
    let wide = "2.0 * u[0] - 1.0";
    for (body, upper) in [
        (format!("({wide}).sqrt().powi(2)"), 1.0),
        (format!("({wide}).ln().exp()"), 1.0),
        (format!("({wide}).powf(1.5).powf(2.0 / 3.0)"), 1.0),
        (format!("let r = ({wide}).sqrt(); r * r"), 1.0),
        ("(2.0 * u[0] - 1.0).ln_1p().exp_m1()".into(), f64::NAN),
        ("(2.0 * u[0]).asin().sin()".into(), 1.0),
    ] {
        let item = compile(&format!("fn undone(u: [Uniform; 1]) -> f64 {{ {body} }}"));
        for u in [0.1, 0.45, 0.55, 0.9] {
            let x = if body.contains("asin") { 2.0 * u } else { 2.0 * u - 1.0 };
            let defined = upper.is_nan() || (0.0..=upper).contains(&x);
            let found = item.forward(&[], &[u]).map(|x| x[0]);
            assert_eq!(found.is_some(), defined, "{body} {u}");
            assert!(found.is_none_or(|found| (found - x).abs() < 1e-14), "{body} {u}");
            assert_eq!(item.pdf(&[], &[x]), if defined { 0.5 } else { 0.0 }, "{body} {u}");
        }
    }
    // Where arguments are never negative nothing is asked.
    let ball = compile(
        "fn squared(u: [Uniform; 1]) -> f64 { let r = (1.0 - u[0] * (2.0 - u[0])).sqrt(); r * r }",
    );
    assert!(ball.parsed.pieces[0].tests.is_empty());
}

/// `powf` of a negative number has no value, also where the exponent has an odd divisor.
#[test]
fn a_broken_power_of_what_may_be_negative() {
    let item =
        compile("fn f(u: [Uniform; 1]) -> f64 { (2.0 * u[0] - 1.0).powf(2.0 / 3.0) + u[0] }");
    assert!(item.forward(&[], &[0.4]).is_none() && item.pdf(&[], &[0.8]) > 0.0);
    for u in [0.6f64, 0.9] {
        let t = 2.0 * u - 1.0;
        let x = item.forward(&[], &[u]).expect("a value")[0];
        assert!((x - t.powf(2.0 / 3.0) - u).abs() < 1e-14, "{u}: {x}");
        let expected = 1.0 / (4.0 / 3.0 * t.powf(-1.0 / 3.0) + 1.0);
        assert!((item.pdf(&[], &[x]) / expected - 1.0).abs() < 1e-12);
    }
    // Of 0.4 the real root would make |-0.2|^(2/3) + 0.4.
    assert_eq!(item.preimages(&[], &[0.04f64.cbrt() + 0.4]).len(), 1);
    let cube = compile("fn f(u: [Uniform; 1]) -> f64 { (2.0 * u[0] - 1.0).powf(1.0 / 3.0) }");
    assert!(cube.forward(&[], &[0.2]).is_none() && cube.pdf(&[], &[-0.5]) == 0.0);
    assert!((cube.pdf(&[], &[0.5]) - 3.0 * 0.25 / 2.0).abs() < 1e-14);
}

/// The way through a pole at which one of two lengths is infinite: the other one is found there.
#[test]
fn a_patch_seen_from_the_origin_has_its_middle() {
    let item = compile(
        "fn seen(u: [Uniform; 2]) -> Direction {
            let (x, y) = (u[0] - 0.5, u[1] - 0.5);
            Direction::from_vec(Vec3::new(x, y, x * x + y * y + 1.0).normalize())
        }",
    );
    // Of a point (p, q, 1 + s) with s = p² + q² the area is |1 - s|, and what is seen of it that over the third power of
    // the distance.
    for (p, q) in [(0.0f64, 0.0f64), (1e-9, 0.0), (-1e-5, 2e-5), (0.3, -0.2)] {
        let s = p * p + q * q;
        let length = (s + (1.0 + s) * (1.0 + s)).sqrt();
        let x = [p, q, 1.0 + s].map(|c| c / length);
        let expected = length.powi(3) / (1.0 - s);
        let found = item.pdf(&[], &x);
        assert!((found / expected - 1.0).abs() < 1e-12, "{p} {q}: {found} {expected}");
        let back = item.preimages(&[], &x);
        assert!(back.len() == 1 && (back[0][0] - 0.5 - p).abs() < 1e-15, "{p}: {back:?}");
    }
}

/// A quadrangle by its homography, whose Jacobian is the determinant of its matrix over the third power of what divides it.
#[test]
fn a_projective_map_of_the_square() {
    let item = compile(
        "fn quadrangle(u: [Uniform; 2]) -> Vec2 {
            let w = 0.3 * u[0] + 0.2 * u[1] + 1.0;
            Vec2::new((1.1 * u[0] + 0.4 * u[1] + 0.2) / w, (0.9 * u[1] - 0.2 * u[0] + 0.3) / w)
        }",
    );
    let rows = [[1.1, 0.4, 0.2], [-0.2, 0.9, 0.3], [0.3, 0.2, 1.0]];
    let minor = |i: usize, j: usize| rows[1][i] * rows[2][j] - rows[1][j] * rows[2][i];
    let determinant =
        rows[0][0] * minor(1, 2) - rows[0][1] * minor(0, 2) + rows[0][2] * minor(0, 1);
    for u in [[0.0, 0.0], [0.25, 0.75], [0.9, 0.1]] {
        let [x, y, w] = rows.map(|r| r[0] * u[0] + r[1] * u[1] + r[2]);
        let found = item.pdf(&[], &[x / w, y / w]);
        let expected = w.powi(3) / determinant;
        assert!((found / expected - 1.0).abs() < 1e-13, "{u:?}: {found} {expected}");
        let back = &item.preimages(&[], &[x / w, y / w])[0];
        assert!((back[0] - u[0]).abs() < 1e-14 && (back[1] - u[1]).abs() < 1e-14, "{back:?}");
    }
    assert_eq!(item.pdf(&[], &[1.1, 0.3]), 0.0);
    // The same with parameters.
    compile(
        "fn by_corners(u: [Uniform; 2], a: Vec3, b: Vec3, c: Vec3) -> Vec2 {
            let p = u[0] * a + u[1] * b + c;
            Vec2::new(p.x / p.z, p.y / p.z)
        }",
    );
}
