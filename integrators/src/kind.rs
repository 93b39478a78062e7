//! Kinds of scenes: which scattering models, lights and sensors a renderer is compiled for.
//!
//! Everything that samples or evaluates light paths is generic over a [`SceneKind`]. What a kind leaves
//! out is [`Absent`], a type without values: enums have no variant for it, vertices no field, and the
//! compiler drops the code that would handle it. A kind with one scattering model has no dispatch.
//!
//! ```
//! use integrators::scene_kind;
//!
//! scene_kind! {
//!     /// Matte rooms with windows.
//!     pub struct Rooms: Diffuse, Area, Constant;
//! }
//! ```

use std::fmt::Debug;

use crate::scene::Scene;
use crate::scene::bsdf::{
    Conductor, Dielectric, Diffuse, Phong, Plastic, RoughConductor, RoughDielectric, RoughPlastic,
    ThinDielectric,
};

mod presence;
mod sets;

pub use presence::{Absent, Either, Part, Presence, Present, Value, With};
pub use sets::{
    DiffuseRooms, Everything, FEATURES, GlossyRooms, NotCovered, Surfaces, covers, has,
};

/// Which features a renderer is compiled for: each is a type that is there or [`Absent`].
///
/// Made by [`scene_kind!`](crate::scene_kind).
pub trait SceneKind: Copy + Debug + PartialEq + Send + Sync + 'static {
    /// The name, as the program shows it.
    const NAME: &'static str;
    /// Lambertian reflection.
    type Diffuse: Part<Diffuse>;
    /// Smooth metal.
    type Conductor: Part<Conductor>;
    /// Smooth glass.
    type Dielectric: Part<Dielectric>;
    /// A thin pane.
    type ThinDielectric: Part<ThinDielectric>;
    /// Smooth plastic.
    type Plastic: Part<Plastic>;
    /// Metal with microfacets.
    type RoughConductor: Part<RoughConductor>;
    /// Glass with microfacets.
    type RoughDielectric: Part<RoughDielectric>;
    /// Plastic with microfacets.
    type RoughPlastic: Part<RoughPlastic>;
    /// A matte base with a glossy lobe about the mirror direction.
    type Phong: Part<Phong>;
    /// Surfaces that let part of the light through unchanged.
    type Mask: Presence;
    /// Mixtures of two materials.
    type Blend: Presence;
    /// Roughness that differs along and across a surface.
    type Anisotropy: Presence;
    /// Normals that a texture turns.
    type Bumps: Presence;
    /// Colours and other parameters that vary over a surface.
    type Textures: Presence;
    /// Surfaces that emit.
    type Area: Presence;
    /// A sky that emits the same in all directions.
    type Constant: Presence;
    /// A sky as a picture shows it.
    type Envmap: Presence;
    /// Light from points, evenly or in a cone.
    type Point: Presence;
    /// Parallel light.
    type Directional: Presence;
    /// Cameras with a lens instead of a pinhole.
    type ThinLens: Presence;
    /// Cameras that project along parallel lines.
    type Orthographic: Presence;
    /// Reconstruction filters with negative lobes.
    type SignedFilter: Presence;
}

/// Whether the kind has a surface that is a mirror, a pane or a hole: scattering into single directions.
pub type Specular<K> = Either<
    Either<ConductorOf<K>, DielectricOf<K>>,
    Either<Either<ThinOf<K>, PlasticOf<K>>, <K as SceneKind>::Mask>,
>;
/// Whether a surface of the kind refracts in a single direction.
pub type Refraction<K> = DielectricOf<K>;
/// Whether light may pass a surface of the kind unchanged.
pub type Passage<K> = Either<ThinOf<K>, <K as SceneKind>::Mask>;
/// Whether the kind has rough plastic.
pub type RoughPlasticOf<K> = <<K as SceneKind>::RoughPlastic as Part<RoughPlastic>>::Presence;
/// Whether the kind has reflection at microfacets.
pub type Facetted<K> = Either<
    <<K as SceneKind>::RoughConductor as Part<RoughConductor>>::Presence,
    <<K as SceneKind>::RoughPlastic as Part<RoughPlastic>>::Presence,
>;
/// Whether the kind has reflection and refraction at microfacets.
pub type Interface<K> = <<K as SceneKind>::RoughDielectric as Part<RoughDielectric>>::Presence;
/// Whether the kind has reflection into all directions alike.
pub type Matte<K> = Either<
    Either<<<K as SceneKind>::Diffuse as Part<Diffuse>>::Presence, PhongOf<K>>,
    Either<PlasticOf<K>, <<K as SceneKind>::RoughPlastic as Part<RoughPlastic>>::Presence>,
>;
/// Whether a material of the kind may have several lobes on one side.
pub type Several<K> = Either<
    Either<Either<DielectricOf<K>, ThinOf<K>>, Either<PlasticOf<K>, RoughPlasticOf<K>>>,
    Either<PhongOf<K>, Either<<K as SceneKind>::Mask, <K as SceneKind>::Blend>>,
>;
/// Whether the kind has materials that depend on how texture coordinates run over a surface.
pub type Oriented<K> = Either<<K as SceneKind>::Anisotropy, <K as SceneKind>::Bumps>;
/// Whether the kind has Phong's model.
pub type PhongOf<K> = <<K as SceneKind>::Phong as Part<Phong>>::Presence;

type ConductorOf<K> = <<K as SceneKind>::Conductor as Part<Conductor>>::Presence;
type DielectricOf<K> = <<K as SceneKind>::Dielectric as Part<Dielectric>>::Presence;
type ThinOf<K> = <<K as SceneKind>::ThinDielectric as Part<ThinDielectric>>::Presence;
/// Whether the kind has smooth plastic.
pub type PlasticOf<K> = <<K as SceneKind>::Plastic as Part<Plastic>>::Presence;

/// Something to be made for a precompiled kind.
pub trait WithKind: Sized {
    /// What comes out.
    type Output;
    /// Makes it for the kind `K`.
    ///
    /// # Errors
    /// If the scene needs what the kind leaves out.
    fn with<K: SceneKind>(self) -> Result<Self::Output, NotCovered>;
}

/// The names of the precompiled kinds, the smallest first.
pub const KINDS: [&str; 4] =
    [DiffuseRooms::NAME, GlossyRooms::NAME, Surfaces::NAME, Everything::NAME];

/// The name of the smallest of the precompiled kinds that covers a scene.
pub fn smallest(scene: &Scene) -> &'static str {
    if covers::<DiffuseRooms>(scene).is_ok() {
        DiffuseRooms::NAME
    } else if covers::<GlossyRooms>(scene).is_ok() {
        GlossyRooms::NAME
    } else if covers::<Surfaces>(scene).is_ok() {
        Surfaces::NAME
    } else {
        Everything::NAME
    }
}

/// What `action` makes for a precompiled kind, by its name; `None` if there is no such kind.
///
/// # Errors
/// If the scene needs what the kind leaves out.
pub fn named<A: WithKind>(name: &str, action: A) -> Option<Result<A::Output, NotCovered>> {
    match name {
        DiffuseRooms::NAME => Some(action.with::<DiffuseRooms>()),
        GlossyRooms::NAME => Some(action.with::<GlossyRooms>()),
        Surfaces::NAME => Some(action.with::<Surfaces>()),
        Everything::NAME => Some(action.with::<Everything>()),
        _ => None,
    }
}
