//! The macro that names a kind, the precompiled kinds, and which of them covers a scene.

use std::fmt;

use super::{Part, Presence, SceneKind};
use crate::scene::Scene;
use crate::scene::bsdf::Bsdf;
use crate::scene::camera::Projection;

/// Names a kind of scene by listing what it has; see [`SceneKind`] for the features.
///
/// ```
/// integrators::scene_kind! {
///     /// Glass and metal under a sky.
///     pub struct Still: Dielectric, RoughConductor, Constant;
/// }
/// ```
#[macro_export]
macro_rules! scene_kind {
    ($(#[$meta:meta])* $visibility:vis struct $name:ident: $($feature:ident),+ $(,)?;) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        $visibility struct $name;

        impl $crate::kind::SceneKind for $name {
            const NAME: &'static str = stringify!($name);
            type Diffuse = $crate::__feature!(Diffuse; $($feature)+);
            type Conductor = $crate::__feature!(Conductor; $($feature)+);
            type Dielectric = $crate::__feature!(Dielectric; $($feature)+);
            type ThinDielectric = $crate::__feature!(ThinDielectric; $($feature)+);
            type Plastic = $crate::__feature!(Plastic; $($feature)+);
            type RoughConductor = $crate::__feature!(RoughConductor; $($feature)+);
            type RoughDielectric = $crate::__feature!(RoughDielectric; $($feature)+);
            type RoughPlastic = $crate::__feature!(RoughPlastic; $($feature)+);
            type Phong = $crate::__feature!(Phong; $($feature)+);
            type Mask = $crate::__feature!(Mask; $($feature)+);
            type Blend = $crate::__feature!(Blend; $($feature)+);
            type Anisotropy = $crate::__feature!(Anisotropy; $($feature)+);
            type Bumps = $crate::__feature!(Bumps; $($feature)+);
            type Textures = $crate::__feature!(Textures; $($feature)+);
            type Area = $crate::__feature!(Area; $($feature)+);
            type Constant = $crate::__feature!(Constant; $($feature)+);
            type Envmap = $crate::__feature!(Envmap; $($feature)+);
            type Point = $crate::__feature!(Point; $($feature)+);
            type Directional = $crate::__feature!(Directional; $($feature)+);
            type ThinLens = $crate::__feature!(ThinLens; $($feature)+);
            type Orthographic = $crate::__feature!(Orthographic; $($feature)+);
            type SignedFilter = $crate::__feature!(SignedFilter; $($feature)+);
        }

        // A feature that does not exist is an error.
        const _: () = {
            fn check<K: $crate::kind::SceneKind>() {
                $(let _ = core::marker::PhantomData::<K::$feature>;)+
            }
            let _ = check::<$name>;
        };
    };
}

/// The type of one feature, given the list of those that a kind has.
#[doc(hidden)]
#[macro_export]
macro_rules! __feature {
    ($wanted:ident;) => { $crate::kind::Absent };
    (Diffuse; Diffuse $($rest:ident)*) => { $crate::scene::bsdf::Diffuse };
    (Conductor; Conductor $($rest:ident)*) => { $crate::scene::bsdf::Conductor };
    (Dielectric; Dielectric $($rest:ident)*) => { $crate::scene::bsdf::Dielectric };
    (ThinDielectric; ThinDielectric $($rest:ident)*) => { $crate::scene::bsdf::ThinDielectric };
    (Plastic; Plastic $($rest:ident)*) => { $crate::scene::bsdf::Plastic };
    (RoughConductor; RoughConductor $($rest:ident)*) => { $crate::scene::bsdf::RoughConductor };
    (RoughDielectric; RoughDielectric $($rest:ident)*) => { $crate::scene::bsdf::RoughDielectric };
    (RoughPlastic; RoughPlastic $($rest:ident)*) => { $crate::scene::bsdf::RoughPlastic };
    (Phong; Phong $($rest:ident)*) => { $crate::scene::bsdf::Phong };
    (Mask; Mask $($rest:ident)*) => { $crate::kind::Present };
    (Blend; Blend $($rest:ident)*) => { $crate::kind::Present };
    (Anisotropy; Anisotropy $($rest:ident)*) => { $crate::kind::Present };
    (Bumps; Bumps $($rest:ident)*) => { $crate::kind::Present };
    (Textures; Textures $($rest:ident)*) => { $crate::kind::Present };
    (Area; Area $($rest:ident)*) => { $crate::kind::Present };
    (Constant; Constant $($rest:ident)*) => { $crate::kind::Present };
    (Envmap; Envmap $($rest:ident)*) => { $crate::kind::Present };
    (Point; Point $($rest:ident)*) => { $crate::kind::Present };
    (Directional; Directional $($rest:ident)*) => { $crate::kind::Present };
    (ThinLens; ThinLens $($rest:ident)*) => { $crate::kind::Present };
    (Orthographic; Orthographic $($rest:ident)*) => { $crate::kind::Present };
    (SignedFilter; SignedFilter $($rest:ident)*) => { $crate::kind::Present };
    ($wanted:ident; $other:ident $($rest:ident)*) => { $crate::__feature!($wanted; $($rest)*) };
}

scene_kind! {
    /// Matte surfaces, some of which shine.
    pub struct DiffuseRooms: Diffuse, Area;
}

scene_kind! {
    /// Surfaces that scatter into all directions, without atoms: matte, or rough metal, glass and plastic.
    pub struct GlossyRooms: Diffuse, RoughConductor, RoughDielectric, RoughPlastic, Textures, Area,
        Constant;
}

scene_kind! {
    /// Every scattering model, with lights that have a surface.
    pub struct Surfaces: Diffuse, Conductor, Dielectric, ThinDielectric, Plastic, RoughConductor,
        RoughDielectric, RoughPlastic, Textures, Area;
}

scene_kind! {
    /// Everything that a scene can contain.
    pub struct Everything: Diffuse, Conductor, Dielectric, ThinDielectric, Plastic, RoughConductor,
        RoughDielectric, RoughPlastic, Phong, Mask, Blend, Anisotropy, Bumps, Textures, Area, Constant,
        Envmap, Point, Directional, ThinLens, Orthographic, SignedFilter;
}

/// What a scene has and a kind has not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NotCovered {
    /// The kind.
    pub kind: &'static str,
    /// The feature, by its name in [`SceneKind`].
    pub feature: &'static str,
}

impl fmt::Display for NotCovered {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let NotCovered { kind, feature } = self;
        write!(
            f,
            "the scene needs `{feature}`, which the kind `{kind}` leaves out: add it to the kind"
        )
    }
}

impl std::error::Error for NotCovered {}

/// Whether a kind has all that a scene needs.
///
/// # Errors
/// The first feature that is missing.
pub fn covers<K: SceneKind>(scene: &Scene) -> Result<(), NotCovered> {
    let mut missing = None;
    let mut need = |feature, present: bool| {
        if !present {
            missing.get_or_insert(NotCovered { kind: K::NAME, feature });
        }
    };
    for bsdf in &scene.bsdfs {
        needed_by(bsdf, &mut |feature| need(feature, has::<K>(feature)));
    }
    for (exists, feature) in [
        (!scene.textures.is_empty(), "Textures"),
        (!scene.emitters.is_empty(), "Area"),
        (!scene.bulbs.is_empty(), "Point"),
        (!scene.distant.is_empty(), "Directional"),
        (matches!(scene.camera.projection, Projection::ThinLens { .. }), "ThinLens"),
        (matches!(scene.camera.projection, Projection::Orthographic { .. }), "Orthographic"),
        (scene.film.filter.is_signed(), "SignedFilter"),
    ] {
        if exists {
            need(feature, has::<K>(feature));
        }
    }
    if let Some(sky) = &scene.sky {
        need(sky.feature(), has::<K>(sky.feature()));
    }
    missing.map_or(Ok(()), Err)
}

/// The features of a scene, in the order of [`SceneKind`].
pub const FEATURES: [&str; 22] = [
    "Diffuse",
    "Conductor",
    "Dielectric",
    "ThinDielectric",
    "Plastic",
    "RoughConductor",
    "RoughDielectric",
    "RoughPlastic",
    "Phong",
    "Mask",
    "Blend",
    "Anisotropy",
    "Bumps",
    "Textures",
    "Area",
    "Constant",
    "Envmap",
    "Point",
    "Directional",
    "ThinLens",
    "Orthographic",
    "SignedFilter",
];

/// Whether a kind has a feature.
pub fn has<K: SceneKind>(feature: &str) -> bool {
    fn part<P: Part<T>, T>() -> bool {
        <P::Presence as Presence>::VALUE.is_some()
    }
    match feature {
        "Diffuse" => part::<K::Diffuse, _>(),
        "Conductor" => part::<K::Conductor, _>(),
        "Dielectric" => part::<K::Dielectric, _>(),
        "ThinDielectric" => part::<K::ThinDielectric, _>(),
        "Plastic" => part::<K::Plastic, _>(),
        "RoughConductor" => part::<K::RoughConductor, _>(),
        "RoughDielectric" => part::<K::RoughDielectric, _>(),
        "RoughPlastic" => part::<K::RoughPlastic, _>(),
        "Phong" => part::<K::Phong, _>(),
        "Mask" => K::Mask::VALUE.is_some(),
        "Blend" => K::Blend::VALUE.is_some(),
        "Anisotropy" => K::Anisotropy::VALUE.is_some(),
        "Bumps" => K::Bumps::VALUE.is_some(),
        "Textures" => K::Textures::VALUE.is_some(),
        "Area" => K::Area::VALUE.is_some(),
        "Constant" => K::Constant::VALUE.is_some(),
        "Envmap" => K::Envmap::VALUE.is_some(),
        "Point" => K::Point::VALUE.is_some(),
        "Directional" => K::Directional::VALUE.is_some(),
        "ThinLens" => K::ThinLens::VALUE.is_some(),
        "Orthographic" => K::Orthographic::VALUE.is_some(),
        "SignedFilter" => K::SignedFilter::VALUE.is_some(),
        _ => false,
    }
}

/// Calls `need` with what a material needs.
fn needed_by(bsdf: &Bsdf, need: &mut impl FnMut(&'static str)) {
    match bsdf {
        // A kind without matte surfaces may still have black ones.
        Bsdf::Diffuse(matte) if matte.is_black() => {}
        Bsdf::TwoSided(sides) => sides.iter().for_each(|side| needed_by(side, need)),
        Bsdf::Mask { nested, .. } | Bsdf::Bump { nested, .. } => {
            need(bsdf.feature());
            needed_by(nested, need);
        }
        Bsdf::Blend { nested, .. } => {
            need(bsdf.feature());
            nested.iter().for_each(|nested| needed_by(nested, need));
        }
        model => {
            need(model.feature());
            if model.is_anisotropic() {
                need("Anisotropy");
            }
        }
    }
}
