//! Items with mistakes are emitted again with the user's body, so that an editor completes in it, and
//! with a constructor, so that one mistake is not reported again wherever the item is used.

use proc_macro2::TokenStream;

type Expand = fn(TokenStream, TokenStream) -> TokenStream;

/// The expansion, as text without spaces.
fn expanded(expand: Expand, attribute: &str, item: &str) -> String {
    let parse = |text: &str| text.parse::<TokenStream>().expect("tokens");
    expand(parse(attribute), parse(item)).to_string().replace(char::is_whitespace, "")
}

/// Checks that the body is there once, in a function, and the struct and constructor beside it.
fn keeps(text: &str, body: &str) {
    let body = body.replace(char::is_whitespace, "");
    assert_eq!(text.matches(&body).count(), 1, "{body}\nis not once in\n{text}");
    for part in ["fnbody(", "structLobe", "fnlobe", "Sampler<R>forLobe"] {
        assert!(text.contains(part), "{part}\nis not in\n{text}");
    }
}

/// Bodies of a sampler of two uniforms and a parameter `k`, each with what is wrong with it.
const WRONG: [(&str, &str); 12] = [
    ("unknown name", "Vec2::new(u[0], elsewhere)"),
    ("unknown method", "Vec2::new(u[0], u[1].smooth())"),
    ("another space", "k * u[0] + u[1]"),
    ("no result", "let x = u[0];"),
    ("a name that is none", "let x = u[0]; y += k; Vec2::new(x, u[1])"),
    ("a loop", "while k > u[0] {} Vec2::new(u[0], u[1])"),
    ("a uniform that is not used", "Vec2::new(u[0], k * u[0])"),
    ("a jump", "Vec2::new((k * u[0]).floor(), u[1])"),
    ("no inverse", "Vec2::new(u[0] + u[1].exp() * (4.0 * u[0]).sin(), u[1] + (u[0] * u[1]).cos())"),
    ("a macro", "println!(\"{}\", k); Vec2::new(u[0], u[1])"),
    ("a composition that computes", "let x = unit(k).sample(u); x + x"),
    ("several mistakes", "let a = b; Vec2::new(c, u[7])"),
];

#[test]
fn a_body_with_an_error_of_the_language_is_emitted_again() {
    for (what, body) in WRONG {
        let item = format!("pub fn lobe(u: [Uniform; 2], k: f64) -> Vec2 {{ {body} }}");
        let text = expanded(aether_engine::sampler, "", &item);
        assert!(text.contains("compile_error!"), "{what}: no error");
        keeps(&text, body);
    }
}

#[test]
fn a_wrong_attribute_or_signature_keeps_the_body() {
    let item = "fn lobe(u: [Uniform; 1], k: f64) -> f64 { k * u[0] }";
    for attribute in
        ["k in 2.0..=1.0", "k", "where", "q in 0.0..=1.0", "k in 0..1, k in 0..2", "where a < k"]
    {
        let text = expanded(aether_engine::sampler, attribute, item);
        assert!(text.contains("compile_error!"), "{attribute}");
        keeps(&text, "{ k * u[0] }");
    }
    // A signature that cannot be understood leaves the body alone.
    for item in [
        "fn lobe(u: [Uniform; N]) -> f64 { 2.0 * u[0] }",
        "fn lobe() -> f64 { 2.0 * u[0] }",
        "fn lobe(u: [Uniform; 1]) -> String { 2.0 * u[0] }",
        "fn lobe(u: [Uniform; 1]) { 2.0 * u[0] }",
        "fn lobe<T>(u: [Uniform; 1], t: T) -> f64 { 2.0 * u[0] }",
    ] {
        let text = expanded(aether_engine::sampler, "", item);
        assert!(text.contains("compile_error!") && text.contains("fnbody"), "{item}");
        assert_eq!(text.matches("{2.0*u[0]}").count(), 1, "{item}\n{text}");
    }
}

#[test]
fn a_body_that_is_no_rust_yet_is_emitted_as_it_stands() {
    for body in [
        "{ let x = u[0]. }",
        "{ let x = u[0].sq; let }",
        "{ Vec2::new(u[0], ) . }",
        "{ if u[0] < }",
    ] {
        let item = format!("/// Half done.\npub fn lobe(u: [Uniform; 2], k: f64) -> Vec2 {body}");
        keeps(&expanded(aether_engine::sampler, "", &item), body);
        let item = format!("pub fn lobe(x: Vec2, k: f64) -> Vec2 {body}");
        let text = expanded(aether_engine::map, "", &item);
        assert!(text.contains("Map<R>forLobe") && text.contains(&body.replace(' ', "")), "{text}");
        let item = format!("fn lobe(path: &PathView<Spot>) -> Spot {body}");
        assert!(expanded(aether_engine::strategy, "", &item).contains(&body.replace(' ', "")));
    }
    // Without a signature there is nothing but the tokens.
    let text = expanded(aether_engine::sampler, "", "fn lobe(u: [Uniform; 2], ) -> { u[0]. }");
    assert!(text.contains("{u[0].}"), "{text}");
}

#[test]
fn a_return_in_the_value_of_a_let_is_no_mistake() {
    let body = "let x = if u[0] < k { return None; } else { u[0] }; Some(2.0 * x)";
    let item = format!("fn lobe(u: [Uniform; 1], k: f64) -> Option<f64> {{ {body} }}");
    let text = expanded(aether_engine::sampler, "k in 0.1..=0.9", &item);
    assert!(!text.contains("compile_error"), "{text}");
}

#[test]
fn a_method_stays_a_method() {
    let text = expanded(
        aether_engine::sampler,
        "",
        "pub fn lobe(&self, u: [Uniform; 1]) -> f64 { self.k * u[0] }",
    );
    assert!(text.contains("pubfnlobe(&self,u:[Uniform;1])->f64{self.k*u[0]}"), "{text}");
    assert!(text.contains("hasno`self`") && !text.contains("const_"), "{text}");
}

#[test]
fn what_is_no_function_is_kept_and_refused() {
    let text = expanded(aether_engine::sampler, "", "struct Lobe { k: f64 }");
    assert!(text.contains("structLobe{k:f64}") && text.contains("belongsonafunction"), "{text}");
}
