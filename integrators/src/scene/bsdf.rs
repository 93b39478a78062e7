//! Scattering models and their parameters, as a scene file gives them. Conventions are Mitsuba's.
//!
//! What they do with light is in [`crate::scattering`].

use glam::Vec3;

use super::texture::{Colour, Grey};

/// A Lambertian reflector: `reflectance / π`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Diffuse {
    /// Albedo in linear Rec. 709, each channel in [0, 1].
    pub reflectance: Colour,
}

impl Diffuse {
    /// Whether it reflects nothing.
    pub fn is_black(&self) -> bool {
        self.reflectance.value == Vec3::ZERO
    }
}

/// The complex index of refraction of a metal, relative to what is outside, for each channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metal {
    /// Real part.
    pub eta: Vec3,
    /// Imaginary part (absorption).
    pub k: Vec3,
}

/// A smooth metal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conductor {
    /// Index of refraction; none for a perfect mirror.
    pub metal: Option<Metal>,
    /// Scales the reflected light.
    pub reflectance: Colour,
}

/// A smooth boundary between two dielectrics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dielectric {
    /// Index of refraction behind the surface over that before it.
    pub eta: f32,
    /// Scales the reflected light.
    pub reflectance: Colour,
    /// Scales the refracted light.
    pub transmittance: Colour,
}

/// A thin pane, within which light is reflected to and fro.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinDielectric {
    /// Index of refraction of the pane over that around it.
    pub eta: f32,
    /// Scales the reflected light.
    pub reflectance: Colour,
    /// Scales the light that passes.
    pub transmittance: Colour,
}

/// A matte base under a smooth dielectric coat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plastic {
    /// Index of refraction of the coat over that outside.
    pub eta: f32,
    /// Albedo of the base.
    pub diffuse: Colour,
    /// Scales the light reflected by the coat.
    pub reflectance: Colour,
    /// Whether the colour shifts because light is reflected within the coat.
    pub nonlinear: bool,
}

/// The statistics of microfacets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Distribution {
    /// Slopes have a normal distribution.
    Beckmann,
    /// Trowbridge and Reitz: long tails.
    Ggx,
}

/// A rough surface made of small mirrors, at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roughness {
    /// How the facets are distributed.
    pub distribution: Distribution,
    /// Root mean square slope along the tangent and across it.
    pub alpha: [f32; 2],
    /// Whether facets are sampled by how much of them can be seen.
    pub sample_visible: bool,
}

/// A rough surface made of small mirrors, as its roughness may vary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facets {
    /// How the facets are distributed.
    pub distribution: Distribution,
    /// Root mean square slope along the first texture coordinate and across it.
    pub alpha: [Grey; 2],
    /// Whether facets are sampled by how much of them can be seen.
    pub sample_visible: bool,
}

/// A metal with microfacets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughConductor {
    /// The facets.
    pub facets: Facets,
    /// Index of refraction; none for perfect mirrors.
    pub metal: Option<Metal>,
    /// Scales the reflected light.
    pub reflectance: Colour,
}

/// A boundary between two dielectrics with microfacets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughDielectric {
    /// The facets.
    pub facets: Facets,
    /// Index of refraction behind the surface over that before it.
    pub eta: f32,
    /// Scales the reflected light.
    pub reflectance: Colour,
    /// Scales the refracted light.
    pub transmittance: Colour,
}

/// A matte base under a dielectric coat with microfacets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughPlastic {
    /// The facets.
    pub roughness: Roughness,
    /// Index of refraction of the coat over that outside.
    pub eta: f32,
    /// Albedo of the base.
    pub diffuse: Colour,
    /// Scales the light reflected by the coat.
    pub reflectance: Colour,
    /// Whether the colour shifts because light is reflected within the coat.
    pub nonlinear: bool,
    /// Whether what facets block from each other reaches the base; otherwise it is lost, as in Mitsuba 3.
    pub conserving: bool,
}

/// A matte base and a lobe about the mirror direction (Lafortune and Willems 1994):
/// `diffuse / π + specular (n + 2) / 2π cosⁿ(angle with the mirror direction)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phong {
    /// Albedo of the base.
    pub diffuse: Colour,
    /// Of the lobe; its albedo at normal incidence.
    pub specular: Colour,
    /// The exponent n.
    pub exponent: f32,
    /// Scales both, so that together they reflect no more light than there is.
    pub scale: f32,
}

/// What a texture that turns normals says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Relief {
    /// Heights over the surface, times this.
    Heights(f32),
    /// Coordinates of the normal in the frame of the surface, from 0 for -1 to 1 for 1.
    Normals,
}

/// A texture that turns the normals of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bump {
    /// Index in [`super::Scene::textures`].
    pub texture: u32,
    /// What it says.
    pub relief: Relief,
    /// Whether normals that face away from the viewer are turned about that of the surface.
    pub flip_invalid: bool,
    /// Whether light at grazing angles is dimmed, so that the terminator is smooth.
    pub shadowing: bool,
}

/// How a surface scatters.
#[derive(Clone, Debug, PartialEq)]
pub enum Bsdf {
    /// Matte, black from behind.
    Diffuse(Diffuse),
    /// Smooth metal, black from behind.
    Conductor(Conductor),
    /// Smooth glass.
    Dielectric(Dielectric),
    /// A thin pane.
    ThinDielectric(ThinDielectric),
    /// Smooth plastic, black from behind.
    Plastic(Plastic),
    /// Rough metal, black from behind.
    RoughConductor(RoughConductor),
    /// Rough glass.
    RoughDielectric(RoughDielectric),
    /// Rough plastic, black from behind.
    RoughPlastic(RoughPlastic),
    /// Phong's model, black from behind.
    Phong(Phong),
    /// What is seen from the front, and what is from behind.
    TwoSided(Box<[Bsdf; 2]>),
    /// A surface with holes too small to be seen.
    Mask {
        /// The share of light that meets the surface.
        opacity: Grey,
        /// The surface.
        nested: Box<Bsdf>,
    },
    /// A mixture of two materials.
    Blend {
        /// The share of the second.
        weight: Grey,
        /// The materials.
        nested: Box<[Bsdf; 2]>,
    },
    /// A material on a surface whose normals a texture turns.
    Bump {
        /// The texture.
        bump: Bump,
        /// The material.
        nested: Box<Bsdf>,
    },
}

impl Bsdf {
    /// What a [kind of scene](crate::kind::SceneKind) must have for it, besides what is nested; of a
    /// two-sided material that is all there is.
    pub fn feature(&self) -> &'static str {
        match self {
            Self::Diffuse(_) => "Diffuse",
            Self::Conductor(_) => "Conductor",
            Self::Dielectric(_) => "Dielectric",
            Self::ThinDielectric(_) => "ThinDielectric",
            Self::Plastic(_) => "Plastic",
            Self::RoughConductor(_) => "RoughConductor",
            Self::RoughDielectric(_) => "RoughDielectric",
            Self::RoughPlastic(_) => "RoughPlastic",
            Self::Phong(_) => "Phong",
            Self::TwoSided(sides) => sides[0].feature(),
            Self::Mask { .. } => "Mask",
            Self::Blend { .. } => "Blend",
            Self::Bump { .. } => "Bumps",
        }
    }

    /// Whether its roughness differs along and across the surface.
    pub fn is_anisotropic(&self) -> bool {
        match self {
            Self::RoughConductor(RoughConductor { facets, .. })
            | Self::RoughDielectric(RoughDielectric { facets, .. }) => {
                facets.alpha[0] != facets.alpha[1]
            }
            _ => false,
        }
    }

    /// The least roughness of its lobes that scatter into many directions, as the root mean square slope of
    /// facets, a texture's by its mean; infinite for matte surfaces, zero if it has no such lobe. It is the same
    /// from both sides.
    pub fn roughness(&self) -> f32 {
        let least = |nested: &[Self; 2]| nested[0].roughness().min(nested[1].roughness());
        match self {
            Self::Diffuse(_) | Self::Plastic(_) => f32::INFINITY,
            Self::Conductor(_) | Self::Dielectric(_) | Self::ThinDielectric(_) => 0.0,
            Self::RoughConductor(RoughConductor { facets, .. })
            | Self::RoughDielectric(RoughDielectric { facets, .. }) => {
                facets.alpha[0].value.min(facets.alpha[1].value)
            }
            Self::RoughPlastic(plastic) => {
                plastic.roughness.alpha[0].min(plastic.roughness.alpha[1])
            }
            // The power of a cosine that falls off like Beckmann's distribution (Walter et al. 2007).
            Self::Phong(phong) => (2.0 / (phong.exponent + 2.0)).sqrt(),
            Self::TwoSided(nested) | Self::Blend { nested, .. } => least(nested),
            Self::Mask { nested, .. } | Self::Bump { nested, .. } => nested.roughness(),
        }
    }

    /// Whether light passes through it, other than through holes.
    pub fn transmits(&self) -> bool {
        match self {
            Self::Dielectric(_) | Self::ThinDielectric(_) | Self::RoughDielectric(_) => true,
            Self::Mask { nested, .. } | Self::Bump { nested, .. } => nested.transmits(),
            Self::Blend { nested, .. } => nested.iter().any(Self::transmits),
            _ => false,
        }
    }

    /// Whether it transmits light at turned normals that are flipped where they face away from the viewer
    /// ([`Bump::flip_invalid`]): whether they do is not known to the light.
    pub fn flips_transmitting(&self) -> bool {
        match self {
            Self::Bump { bump, nested } => bump.flip_invalid && nested.transmits(),
            Self::Mask { nested, .. } => nested.flips_transmitting(),
            Self::TwoSided(nested) | Self::Blend { nested, .. } => {
                nested.iter().any(Self::flips_transmitting)
            }
            _ => false,
        }
    }

    /// Has rough plastic lose light as that of Mitsuba 3.9 does; see [`RoughPlastic::conserving`].
    pub fn lose_energy(&mut self) {
        match self {
            Self::RoughPlastic(plastic) => plastic.conserving = false,
            Self::TwoSided(nested) | Self::Blend { nested, .. } => {
                nested.iter_mut().for_each(Self::lose_energy);
            }
            Self::Mask { nested, .. } | Self::Bump { nested, .. } => nested.lose_energy(),
            _ => {}
        }
    }

    /// The plugin type.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Diffuse(_) => "diffuse",
            Self::Conductor(_) => "conductor",
            Self::Dielectric(_) => "dielectric",
            Self::ThinDielectric(_) => "thindielectric",
            Self::Plastic(_) => "plastic",
            Self::RoughConductor(_) => "roughconductor",
            Self::RoughDielectric(_) => "roughdielectric",
            Self::RoughPlastic(_) => "roughplastic",
            Self::Phong(_) => "phong",
            Self::TwoSided(_) => "twosided",
            Self::Mask { .. } => "mask",
            Self::Blend { .. } => "blendbsdf",
            Self::Bump { bump: Bump { relief: Relief::Heights(_), .. }, .. } => "bumpmap",
            Self::Bump { bump: Bump { relief: Relief::Normals, .. }, .. } => "normalmap",
        }
    }
}
