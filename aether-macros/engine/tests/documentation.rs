//! What the documentation of an item says.

use proc_macro2::TokenStream;

/// The documentation of an item, its lines joined.
fn documented(
    expand: fn(TokenStream, TokenStream) -> TokenStream,
    attribute: &str,
    item: &str,
) -> String {
    let parse = |text: &str| text.parse::<TokenStream>().expect("is Rust");
    let text = expand(parse(attribute), parse(item)).to_string();
    assert!(!text.contains("compile_error"), "{text}");
    let docs = text.split("doc = \"").skip(1).filter_map(|rest| rest.split('"').next());
    docs.collect::<Vec<_>>().join("\n")
}

fn says(text: &str, parts: &[&str]) {
    for part in parts {
        assert!(text.contains(part), "{part}\nis not in\n{text}");
    }
}

#[test]
fn a_sampler_shows_formulas_measure_error_and_kind() {
    let text = documented(
        aether_engine::sampler,
        "",
        "/// About +z.
        fn cosine(u: [Uniform; 2]) -> Direction {
            let (r, phi) = (u[0].sqrt(), TAU * u[1]);
            Direction::new(r * phi.cos(), r * phi.sin(), (1.0 - u[0]).sqrt())
        }",
    );
    says(
        &text,
        &[
            "About +z.",
            "inverse  u₁ = x² + y²",
            "√det JᵀJ",
            "pdf      z / π",
            "measure  solid angle",
            "worst relative error of the density in `f64` on the points tried: ",
            "Every point has one preimage in closed form.",
        ],
    );
    let worst = text.split("points tried: ").nth(1).and_then(|t| t.split(".\n").next());
    let worst: f64 = worst.and_then(|t| t.parse().ok()).expect("a number");
    assert!(worst > 0.0 && worst < 1e-14, "{worst}");
}

#[test]
fn every_preimage_and_piece_has_a_line() {
    let fold = "fn fold(u: [Uniform; 1]) -> f64 { let t = 3.0 * u[0] - 1.0; t * t }";
    let text = documented(aether_engine::sampler, "", fold);
    says(&text, &["A point has up to 2 preimages in closed form, whose densities add up."]);
    assert_eq!(text.lines().filter(|l| l.contains("u = ")).count(), 2, "{text}");
    let halves =
        "fn halves(u: [Uniform; 1]) -> f64 { if u[0] < 0.25 { u[0] } else { 3.0 - u[0] } }";
    let text = documented(aether_engine::sampler, "", halves);
    says(&text, &["map      ", "or       ", "where", "A point has up to 2 preimages"]);
}

#[test]
fn numerical_inverses_are_called_so() {
    let quintic = "fn quintic(u: [Uniform; 1], k: f64) -> f64 { u[0] + k * u[0].powi(5) }";
    let text = documented(aether_engine::sampler, "k in 0.0..=9.0", quintic);
    says(
        &text,
        &[
            "The inverse has no closed form and is computed numerically",
            "Every point has one preimage.",
        ],
    );
    assert!(!text.contains("in closed form."));
    // The constructor says what it refuses.
    says(&text, &["# Errors"]);
}

#[test]
fn maps_and_compositions_name_their_measures() {
    let plane = "fn hit(w: Direction, eye: Vec3, id: SurfaceId) -> SurfacePoint {
        let t = -eye.z / w.z;
        require(t > 0.0);
        SurfacePoint::new(eye + t * w, id)
    }";
    let text = documented(aether_engine::map, "", plane);
    says(&text, &["measure  solid angle to area", "A point has up to 2 preimages in closed form."]);
    let chain = "fn chain(u: [Uniform; 2], n: Direction) -> Direction { rotate(n).apply(&lobe().sample(u)) }";
    says(
        &documented(aether_engine::sampler, "", chain),
        &["A composition", "Measure: solid angle."],
    );
}
