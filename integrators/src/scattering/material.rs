//! Materials as the strategies and the integrand use them: a [`Bsdf`] of the scene, reduced to what a
//! kind of scene has.

use glam::Vec3;

use super::rough_plastic::Coat;
use crate::kind::{NotCovered, Part, PlasticOf, Presence, RoughPlasticOf, SceneKind, With};
use crate::scene::bsdf::{Bsdf, Bump, Plastic, RoughPlastic};
use crate::scene::texture::Grey;

use super::fresnel;

/// One scattering model with its parameters.
#[derive(Clone, Debug)]
pub enum Model<K: SceneKind> {
    /// Reflects nothing.
    Black,
    /// Matte.
    Diffuse(K::Diffuse),
    /// Smooth metal.
    Conductor(K::Conductor),
    /// Smooth glass.
    Dielectric(K::Dielectric),
    /// A thin pane.
    ThinDielectric(K::ThinDielectric),
    /// Smooth plastic, and what of a diffuse field its coat reflects inside.
    Plastic(With<PlasticOf<K>, (Plastic, f32)>),
    /// Rough metal.
    RoughConductor(K::RoughConductor),
    /// Rough glass.
    RoughDielectric(K::RoughDielectric),
    /// Rough plastic, and what its coat reflects.
    RoughPlastic(With<RoughPlasticOf<K>, (RoughPlastic, Coat)>),
    /// A matte base and a glossy lobe.
    Phong(K::Phong),
}

/// The share of light that does not pass through the holes of a material, and of the parts of a mixture.
#[derive(Clone, Copy, Debug)]
pub struct Opacity {
    /// That of both.
    pub whole: Grey,
    /// That of the two parts by themselves.
    pub parts: [Grey; 2],
}

impl Opacity {
    /// Whether there are no holes.
    #[inline]
    fn is_full(&self) -> bool {
        [self.whole, self.parts[0], self.parts[1]].iter().all(|opacity| opacity.value == 1.0)
    }
}

/// What is seen from one side of a surface.
#[derive(Clone, Debug)]
pub struct Side<K: SceneKind> {
    /// The material.
    pub base: Model<K>,
    /// A second material, and its share.
    pub blend: Option<(K::Blend, Model<K>, Grey)>,
    /// The share of light that does not pass through holes.
    pub mask: Option<(K::Mask, Opacity)>,
    /// What turns the normals, and whether they are those of the front: a two-sided material around it
    /// mirrors them to the back.
    pub bump: Option<(K::Bumps, Bump, bool)>,
    /// Whether the frame follows the texture coordinates.
    pub oriented: bool,
}

impl<K: SceneKind> Model<K> {
    /// Whether it reflects nothing.
    #[inline]
    pub fn is_black(&self) -> bool {
        matches!(self, Model::Black)
    }
}

impl<K: SceneKind> Side<K> {
    /// Whether it scatters no light at all.
    #[inline]
    pub fn is_black(&self) -> bool {
        self.base.is_black()
            && self
                .blend
                .as_ref()
                .is_none_or(|(_, model, share)| model.is_black() || share.value == 0.0)
            && self.mask.as_ref().is_none_or(|(_, opacity)| opacity.is_full())
    }
}

/// A material: what is seen from the side that the normal points to, and from the other one.
#[derive(Clone, Debug)]
pub struct Material<K: SceneKind> {
    /// The side of the normal.
    pub front: Side<K>,
    /// The other side.
    pub back: Side<K>,
}

impl<K: SceneKind> Material<K> {
    /// A material of the scene.
    ///
    /// # Errors
    /// If it needs what the kind leaves out.
    pub fn new(bsdf: &Bsdf) -> Result<Self, NotCovered> {
        Ok(Material { front: side(bsdf, true)?, back: side(bsdf, false)? })
    }

    /// Whether it matters how texture coordinates run over the surface.
    pub fn is_oriented(&self) -> bool {
        self.front.oriented || self.back.oriented
    }
}

fn missing<K: SceneKind>(feature: &'static str) -> NotCovered {
    NotCovered { kind: K::NAME, feature }
}

fn side<K: SceneKind>(bsdf: &Bsdf, front: bool) -> Result<Side<K>, NotCovered> {
    let plain = |base| Side {
        base,
        blend: None,
        mask: None,
        bump: None,
        oriented: bsdf.is_anisotropic() && K::Anisotropy::VALUE.is_some(),
    };
    match bsdf {
        Bsdf::TwoSided(sides) => side(&sides[usize::from(!front)], true),
        Bsdf::Mask { opacity, nested } => {
            let present = K::Mask::VALUE.ok_or_else(|| missing::<K>(bsdf.feature()))?;
            let inside = side(nested, front)?;
            let parts = inside.mask.map_or([1.0.into(); 2], |(_, opacity)| opacity.parts);
            Ok(Side { mask: Some((present, Opacity { whole: *opacity, parts })), ..inside })
        }
        Bsdf::Bump { bump, nested } => {
            let present = K::Bumps::VALUE.ok_or_else(|| missing::<K>(bsdf.feature()))?;
            let bump = Some((present, *bump, front));
            Ok(Side { bump, oriented: true, ..side(nested, front)? })
        }
        Bsdf::Blend { weight, nested } => {
            let present = K::Blend::VALUE.ok_or_else(|| missing::<K>(bsdf.feature()))?;
            let [first, second] = [part::<K>(&nested[0], front)?, part(&nested[1], front)?];
            let blend = Some((present, second.model, *weight));
            // Both are turned alike: the loader refuses others.
            let (mask, bump) = (first.opacity.or(second.opacity), first.bump);
            let mask = mask.map(|(present, _)| {
                let parts = [first.opacity, second.opacity];
                let parts = parts.map(|part| part.map_or(1.0.into(), |(_, opacity)| opacity));
                (present, Opacity { whole: 1.0.into(), parts })
            });
            let oriented = bump.is_some() || first.oriented || second.oriented;
            Ok(Side { blend, mask, bump, oriented, ..plain(first.model) })
        }
        other => model(other, front).map(plain),
    }
}

/// A part of a mixture: a model, its holes, and what turns its normals.
struct Component<K: SceneKind> {
    model: Model<K>,
    opacity: Option<(K::Mask, Grey)>,
    bump: Option<(K::Bumps, Bump, bool)>,
    oriented: bool,
}

/// A part of a mixture. Holes may be around what turns the normals.
fn part<K: SceneKind>(bsdf: &Bsdf, front: bool) -> Result<Component<K>, NotCovered> {
    match bsdf {
        Bsdf::Mask { opacity, nested } => {
            let present = K::Mask::VALUE.ok_or_else(|| missing::<K>(bsdf.feature()))?;
            Ok(Component { opacity: Some((present, *opacity)), ..part(nested, front)? })
        }
        Bsdf::Bump { bump, nested } => {
            let present = K::Bumps::VALUE.ok_or_else(|| missing::<K>(bsdf.feature()))?;
            Ok(Component { bump: Some((present, *bump, front)), ..part(nested, front)? })
        }
        other => Ok(Component {
            model: model(other, front)?,
            opacity: None,
            bump: None,
            oriented: other.is_anisotropic() && K::Anisotropy::VALUE.is_some(),
        }),
    }
}

/// A model that is no mixture. Opaque ones are black from behind.
fn model<K: SceneKind>(bsdf: &Bsdf, front: bool) -> Result<Model<K>, NotCovered> {
    let keep = match bsdf {
        Bsdf::Dielectric(glass) => K::Dielectric::keep(*glass).map(Model::Dielectric),
        Bsdf::ThinDielectric(pane) => K::ThinDielectric::keep(*pane).map(Model::ThinDielectric),
        Bsdf::RoughDielectric(glass) => {
            K::RoughDielectric::keep(*glass).map(Model::RoughDielectric)
        }
        Bsdf::TwoSided(sides) => return model(&sides[usize::from(!front)], true),
        _ if !front => return Ok(Model::Black),
        Bsdf::Diffuse(matte) if matte.is_black() => return Ok(Model::Black),
        Bsdf::Diffuse(matte) => K::Diffuse::keep(*matte).map(Model::Diffuse),
        Bsdf::Conductor(metal) => K::Conductor::keep(*metal).map(Model::Conductor),
        Bsdf::RoughConductor(metal) => K::RoughConductor::keep(*metal).map(Model::RoughConductor),
        // What is computed for a model is computed only if the kind has it.
        Bsdf::Plastic(plastic) => {
            PlasticOf::<K>::with(|| (*plastic, internal_reflectance(plastic))).map(Model::Plastic)
        }
        Bsdf::RoughPlastic(plastic) => {
            RoughPlasticOf::<K>::with(|| (*plastic, Coat::new(plastic))).map(Model::RoughPlastic)
        }
        Bsdf::Phong(phong) => K::Phong::keep(*phong).map(Model::Phong),
        // The loader refuses mixtures within mixtures.
        Bsdf::Mask { .. } | Bsdf::Blend { .. } | Bsdf::Bump { .. } => return Ok(Model::Black),
    };
    keep.ok_or_else(|| missing::<K>(bsdf.feature()))
}

/// What the coat of plastic reflects of a diffuse field inside it.
fn internal_reflectance(plastic: &Plastic) -> f32 {
    1.0 - (1.0 - fresnel::diffuse_average(plastic.eta)) / (plastic.eta * plastic.eta)
}

/// How light that gets through the coat comes out again from a matte base: albedo over what is left after
/// reflection to and fro.
pub fn base_albedo(diffuse: Vec3, inside: f32, nonlinear: bool) -> Vec3 {
    if nonlinear { diffuse / (Vec3::ONE - diffuse * inside) } else { diffuse / (1.0 - inside) }
}
