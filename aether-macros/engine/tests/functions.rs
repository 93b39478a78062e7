//! Every function of the language in a sampler: it is read, inverted with all branches that its
//! argument reaches, differentiated, checked on points by the compiler, and emitted.

use proc_macro2::TokenStream;

/// The documentation that the compiler gives a sampler of one uniform `u` and parameters `a`, `b`
/// from 1/4 to 4; the compiler's message if it refuses.
fn derivation(body: &str) -> Result<String, String> {
    let item = format!("fn s(u: [Uniform; 1], a: f64, b: f64) -> f64 {{ let u = u[0]; {body} }}");
    let attributes = "a in 0.25..=4.0, b in 0.25..=4.0";
    let tokens: TokenStream = item.parse().expect("the body is Rust");
    let out = aether_engine::sampler(attributes.parse().expect("attributes"), tokens).to_string();
    match out.split_once("compile_error") {
        Some((_, message)) => Err(message.split_inclusive('"').take(2).collect()),
        None => Ok(out
            .split("doc = \"")
            .skip(1)
            .filter_map(|text| text.split('"').next())
            .collect::<Vec<_>>()
            .join("\n")),
    }
}

/// Bodies with the number of preimages that a point can have.
const BODIES: [(&str, usize); 75] = [
    ("u * (0.25 * PI).sin() + (1.25 * PI).cos() * (2.25 * PI).tan()", 1),
    ("(a * u).exp()", 1),
    ("(a * u).exp2()", 1),
    ("(a * u).exp_m1()", 1),
    ("(a + u).ln()", 1),
    ("(a * u).ln_1p()", 1),
    ("(a + u).log2()", 1),
    ("(a + u).log10()", 1),
    ("(a + u).log(b + 1.5)", 1),
    ("(a * u).sqrt()", 1),
    ("(a * u).cbrt()", 1),
    ("(2.0 * u - 1.0).cbrt()", 1),
    ("(a * (2.0 * u - 1.0)).powi(3)", 1),
    ("(a * (2.0 * u - 1.0)).powi(5)", 1),
    ("(a * (2.0 * u - 1.0)).powi(2)", 2),
    ("(a * u).powf(b)", 1),
    ("(a + u).powf(-b)", 1),
    ("a.powf(u + 1.0) * 0.0 + (a + 1.5).powf(u)", 1),
    ("(a + u).recip()", 1),
    ("u.mul_add(a, b)", 1),
    ("(a * u).sinh()", 1),
    ("(a * (u - 0.5)).cosh()", 2),
    ("(a * u).cosh()", 1),
    ("(a * (u - 0.5)).tanh()", 1),
    ("(a * (u - 0.5)).asinh()", 1),
    ("(1.0 + a * u).acosh()", 1),
    ("(2.0 * u - 1.0).atanh()", 1),
    ("(PI * u).sin()", 2),
    ("(PI * u).cos()", 1),
    ("(TAU * u).cos()", 2),
    ("(TAU * u).sin()", 3),
    ("(0.5 * PI * u).tan()", 1),
    ("(PI * (u - 0.5)).tan()", 1),
    ("1.0 / (PI * u).tan()", 1),
    ("let (s, c) = (PI * u).sin_cos(); c / s", 1),
    ("let (s, c) = (0.5 * PI * u).sin_cos(); a * s / c", 1),
    ("(2.0 * u - 1.0).asin()", 1),
    ("(2.0 * u - 1.0).acos()", 1),
    ("(a * (u - 0.5)).atan()", 1),
    ("u.atan2(a)", 1),
    ("(2.0 * u - 1.0).atan2(a)", 1),
    ("a.atan2(2.0 * u - 1.0)", 1),
    ("b * a.atan2(b) + u", 1),
    ("(a * u).hypot(b)", 1),
    ("(a * u - 1.0).abs()", 2),
    ("(180.0 * u).to_radians().sin()", 2),
    ("(a * u).to_degrees()", 1),
    ("f64::exp(a * u)", 1),
    ("f64::cbrt(u - 0.5)", 1),
    ("f64::sqrt(a * u)", 1),
    ("erf(a * (u - 0.5))", 1),
    ("erfc(a * (u - 0.5))", 1),
    ("erf_inv(2.0 * u - 1.0)", 1),
    ("erfc_inv(2.0 * u)", 1),
    ("b + a * normal_quantile(u)", 1),
    ("normal_cdf(a * (u - 0.5))", 1),
    ("lambert_w(a * u)", 1),
    ("lambert_w(-u / E)", 1),
    ("special::lambert_w(a * u)", 1),
    ("u * ln_gamma(a + 3.0)", 1),
    ("u * ln_beta(a, b)", 1),
    ("beta_inc(a, b, u)", 1),
    ("beta_inc_inv(a, b, u)", 1),
    ("1.0 / (1.0 - beta_inc_inv(a, 0.5, 1.0 - u))", 1),
    ("(u / (1.0 - u)).ln().sinh()", 1),
    ("((u / (1.0 - u)).ln().asinh() * a + b).sinh()", 1),
    ("normal_quantile(u).exp()", 1),
    ("a * (u.ln() - (-u).ln_1p())", 1),
    ("a * (a + 1.5).powf(u) * b.powf(1.0 - u)", 1),
    ("let z = u.ln() - (-u).ln_1p(); z * (0.05 * a * z * z).exp()", 1),
    ("-normal_quantile((1.0 - u) * normal_cdf(-a) + u * normal_cdf(-a - b))", 1),
    ("a + b * (-a * (-u).ln_1p()).exp_m1() / a", 1),
    ("let f = ((1.0 + u).cos() - 2.0 - a) / (1.0 + u).sin(); (f * f + b).sqrt() + f * f", 2),
    ("u * (a * u).exp()", 1),
    ("u.sqrt() * (a * u * u).exp()", 1),
];

#[test]
fn every_function_is_inverted_and_checked() {
    let mut failed = Vec::new();
    for (body, preimages) in BODIES {
        match derivation(body) {
            Err(message) => failed.push(format!("{body}: refused: {message}")),
            Ok(text) => {
                println!("{body}\n{text}\n");
                let found = match text.split_once("A point has up to ") {
                    Some((_, rest)) => rest.split(' ').next().and_then(|n| n.parse().ok()),
                    None => Some(1),
                };
                if found != Some(preimages) {
                    failed.push(format!("{body}: {found:?} preimages, not {preimages}:\n{text}"));
                }
            }
        }
    }
    assert!(failed.is_empty(), "{} of {}:\n{}", failed.len(), BODIES.len(), failed.join("\n"));
}
