//! By which tests emitted code tells whether a point lies in the support.

use proc_macro2::TokenStream;

/// What is emitted for a sampler, without spaces.
fn emitted(attribute: &str, item: &str) -> String {
    let parse = |text: &str| text.parse::<TokenStream>().expect("is Rust");
    let text = aether_engine::sampler(parse(attribute), parse(item)).to_string();
    assert!(!text.contains("compile_error"), "{text}");
    text.split_whitespace().collect()
}

/// The body of an emitted function.
fn function<'a>(text: &'a str, name: &str) -> &'a str {
    let (_, rest) = text.split_once(&format!("fn{name}<")).expect("the function is emitted");
    rest.split_once("#[").map_or(rest, |(body, _)| body)
}

#[test]
fn a_coordinate_between_two_ends_needs_no_inverse() {
    let text = emitted(
        "a in 0.0.., b in 0.0..",
        "fn linear(u: [Uniform; 1], a: f64, b: f64) -> f64 {
            u[0] * (a + b) / (a + ((1.0 - u[0]) * a * a + u[0] * b * b).sqrt())
        }",
    );
    let tests = function(&text, "plainly_0");
    assert!(tests.contains("x[0].ge(R::ZERO)).and(x[0].lt(R::ONE))"), "{tests}");
    assert!(!tests.contains("p[0]"), "{tests}");
}

#[test]
fn a_coordinate_that_takes_all_values_is_not_tested() {
    let text = emitted(
        "",
        "fn student(u: [Uniform; 1]) -> f64 {
            (2.0 * u[0] - 1.0) / (2.0 * u[0] * (1.0 - u[0])).sqrt()
        }",
    );
    assert!(!function(&text, "plainly_0").contains("x[0]"), "{text}");
}

#[test]
fn an_angle_is_asked_for_only_between_the_heights() {
    let text = emitted(
        "a in -1.0..=1.0, b in -1.0..=1.0, d in 0.1..=6.0, where a < b",
        "fn window(u: [Uniform; 2], a: f64, b: f64, d: f64) -> Direction {
            let z = (1.0 - u[0]) * a + u[0] * b;
            let r = (1.0 - z * z).sqrt();
            let phi = d * u[1];
            Direction::new(r * phi.cos(), r * phi.sin(), z)
        }",
    );
    let (first, then) = function(&text, "plainly_0").split_once("return").expect("two steps");
    assert!(first.contains("x[2].ge(p[0])).and(x[2].lt(p[1]))"), "{first}");
    assert!(!first.contains("atan2") && then.contains("atan2"), "{first}");
}

/// A circle has one preimage, but its coordinates have each value twice: none tells where the angle is.
#[test]
fn a_coordinate_that_has_values_twice_tells_nothing() {
    let text = emitted(
        "d in 0.1..=6.0",
        "fn arc(u: [Uniform; 2], d: f64) -> Vec2 {
            let (r, phi) = (1.0 + u[1], d * u[0]);
            Vec2::new(r * phi.cos(), r * phi.sin())
        }",
    );
    assert!(function(&text, "plainly_0").contains("atan2"), "{text}");
}

#[test]
fn what_takes_no_other_way_takes_the_last_one() {
    let text = emitted(
        "r in 0.1..",
        "fn tent(u: [Uniform; 1], r: f64) -> f64 {
            if u[0] < 0.5 { r * ((2.0 * u[0]).sqrt() - 1.0) } else { r * (1.0 - (2.0 * (1.0 - u[0])).sqrt()) }
        }",
    );
    let whole = function(&text, "whole");
    assert!(whole.contains("taken_0") && !whole.contains("taken_1"), "{whole}");
}

#[test]
fn where_a_way_leads_nowhere_the_last_one_is_tested() {
    let text = emitted(
        "",
        "fn half(u: [Uniform; 1]) -> Option<f64> {
            if u[0] < 0.25 { None } else if u[0] < 0.5 { Some(u[0]) } else { Some(2.0 * u[0]) }
        }",
    );
    assert!(function(&text, "whole").contains("taken_1"), "{text}");
}

#[test]
fn a_share_of_what_is_positive_is_told_by_a_difference() {
    let text = emitted(
        "",
        "fn corner(u: [Uniform; 3], a: Vec3, b: Vec3, c: Vec3, d: Vec3) -> Vec3 {
            let r = u[0].cbrt();
            let s = u[1].sqrt();
            a + r * (1.0 - s) * (b - a) + r * s * (1.0 - u[2]) * (c - a) + r * s * u[2] * (d - a)
        }",
    );
    // Three barycentric coordinates are quotients, and their sum is below one.
    assert_eq!(function(&text, "plainly_0").matches("/t").count(), 3, "{text}");
}

#[test]
fn a_cosine_of_a_point_in_space_is_not_tested() {
    let text = emitted(
        "",
        "fn ball(u: [Uniform; 3]) -> Vec3 {
            let (r, z, phi) = (u[0].cbrt(), 1.0 - 2.0 * u[1], TAU * u[2]);
            let s = r * (1.0 - z * z).sqrt();
            Vec3::new(s * phi.cos(), s * phi.sin(), r * z)
        }",
    );
    let tests = function(&text, "plainly_0");
    assert!(!tests.contains("either"), "{tests}");
}

#[test]
fn a_density_that_does_not_depend_on_a_uniform_has_a_value_where_that_is_zero() {
    let both = |body: &str| {
        let item = format!("fn s(u: [Uniform; 1], a: f64, b: f64) -> f64 {{ {body} }}");
        let text = emitted("a in 0.1.., b in 0.1..", &item);
        let (_, rest) = text.split_once("fnforward_with_pdf").expect("the function is emitted");
        rest.split_once("fnpreimages").expect("another follows").0.to_owned()
    };
    let line = both("a + (b - a) * u[0]");
    assert!(!line.contains("u[0usize].gt(R::ZERO)"), "{line}");
    // What is no positive number at zero shows it, and a function that may jump there does not.
    let power = both("a * u[0].powf(1.0 / b)");
    assert!(!power.contains("u[0usize].gt(R::ZERO)"), "{power}");
    let step = both("b * (a * u[0]).tanh()");
    assert!(step.contains("u[0usize].gt(R::ZERO)"), "{step}");
}

#[test]
fn no_point_of_a_disk_is_infinite() {
    let text = emitted(
        "",
        "fn disk(u: [Uniform; 2]) -> Vec2 {
            let (r, phi) = (u[0].sqrt(), TAU * u[1]);
            Vec2::new(r * phi.cos(), r * phi.sin())
        }",
    );
    let (_, rest) = text.split_once("fnpdf(").expect("the density is emitted");
    let (density, _) = rest.split_once("fnpdf_of_uniforms").expect("another follows");
    assert!(density.contains("x[0]*x[0]+x[1]*x[1]") && !density.contains("finite"), "{density}");
}
