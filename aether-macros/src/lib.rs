//! The attributes of `aether-core`, which re-exports and documents them in use.
//!
//! The compiler behind them is the library `aether-engine`; here are only the entry points.

use proc_macro::TokenStream;

/// Derives a random variable from a function of uniforms: inverse, Jacobian and density.
#[proc_macro_attribute]
pub fn sampler(attr: TokenStream, item: TokenStream) -> TokenStream {
    aether_engine::sampler(attr.into(), item.into()).into()
}

/// Derives the inverse and the change of measure of a function from one space to another.
#[proc_macro_attribute]
pub fn map(attr: TokenStream, item: TokenStream) -> TokenStream {
    aether_engine::map(attr.into(), item.into()).into()
}

/// Derives the density of a function that samples the next vertex of a path: discrete choices
/// marginalised, locally constant calls read back from the vertex.
///
/// ```ignore
/// #[strategy]
/// pub fn scatter(path: &PathView<Hit>, scene: &Scene) -> Hit {
///     let here = given(path.last());
///     if !choose(coin(here.albedo())) {
///         return stop();
///     }
///     let w = draw(cosine_hemisphere().then(rotate(here.frame())));
///     let face = constant(scene.cast(here, &w));
///     Hit::new(face, hit_plane(here.position, face.plane()).apply(&w))
/// }
/// ```
///
/// The first parameter is the path; the others become the fields of a struct `Scatter<'scene>`,
/// which implements `Strategy<Hit>` and which the function, now `scatter(&scene)`, returns. Large
/// parameters are best taken by reference, because others are cloned for each call.
///
/// The special forms are those of `aether_core::forms`. Around them the body is ordinary Rust:
/// `let`, `let .. else { return stop() }`, `if`, `if let` and `match` (also as the value of a `let`),
/// `return`. Loops and closures may not contain special forms. The vertex at the end is made from
/// values read back from it and one random point: what was drawn, or maps of it, `map.apply(&w)`.
/// With no random point it is an atom. Conditions (`if w.z < 0.0`) and coins (`choose(coin(..))`)
/// may depend on what was drawn: the density evaluates them after inversion.
///
/// `#[strategy(connected = true)]` (or `false`) overrides whether the vertex before sees the new one,
/// which is otherwise so if a locally constant call found the vertex from the path and the draw.
#[proc_macro_attribute]
pub fn strategy(attr: TokenStream, item: TokenStream) -> TokenStream {
    aether_engine::strategy(attr.into(), item.into()).into()
}
