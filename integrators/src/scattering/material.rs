//! Materials as the strategies and the integrand use them: a [`Bsdf`] of the scene, reduced to what a
//! kind of scene has.

use glam::Vec3;

use super::rough_plastic::Coat;
use crate::kind::{
    NotCovered, Part, PlasticOf, Presence, RoughPlasticOf, SceneKind, Specular, With,
};
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

/// What the share of a part in the light is multiplied by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Factor {
    /// A number.
    Of(Grey),
    /// What is left of one.
    Rest(Grey),
}

/// A part of a material: one model, and what is around it.
#[derive(Clone, Debug)]
pub struct Layer<K: SceneKind> {
    /// The model.
    pub model: Model<K>,
    /// Its share of the light is their product.
    pub factors: Box<[Factor]>,
    /// What turns the normals, and whether they are those of the front: a two-sided material around it
    /// mirrors them to the back.
    pub bump: Turned<K>,
}

/// What turns the normals of a part, if anything does; nothing where the kind has no such textures.
pub type Turned<K> = Option<With<<K as SceneKind>::Bumps, (Bump, bool)>>;

/// The parts of a mixture behind the first.
pub type Others<K> = (<K as SceneKind>::Blend, Box<[Layer<K>]>);

/// What is seen from one side of a surface: mixtures of mixtures are a list of parts.
#[derive(Clone, Debug)]
pub struct Side<K: SceneKind> {
    /// The first part, mostly the only one.
    pub base: Layer<K>,
    /// The others.
    pub more: Option<Others<K>>,
    /// Whether there are holes: what is left of the light after all parts passes through them.
    pub holes: Option<K::Mask>,
    /// Whether the parts have normals of their own.
    pub varied: bool,
    /// Whether the frame follows the texture coordinates.
    pub oriented: bool,
    /// Whether there are mirrors, panes or holes: lobes that are atoms.
    specular: bool,
}

impl<K: SceneKind> Model<K> {
    /// Whether it reflects nothing.
    #[inline]
    pub fn is_black(&self) -> bool {
        matches!(self, Model::Black)
    }

    /// Whether it has lobes that are atoms.
    fn is_specular(&self) -> bool {
        match self {
            Model::Conductor(_)
            | Model::Dielectric(_)
            | Model::ThinDielectric(_)
            | Model::Plastic(_) => true,
            Model::Black
            | Model::Diffuse(_)
            | Model::RoughConductor(_)
            | Model::RoughDielectric(_)
            | Model::RoughPlastic(_)
            | Model::Phong(_) => false,
        }
    }

    /// Whether no light gets to the other side.
    #[inline]
    pub fn is_opaque(&self) -> bool {
        !matches!(self, Model::Dielectric(_) | Model::ThinDielectric(_) | Model::RoughDielectric(_))
    }
}

impl<K: SceneKind> Side<K> {
    /// The parts behind the first.
    #[inline(always)]
    pub fn others(&self) -> &[Layer<K>] {
        // A kind without mixtures does not look.
        match &self.more {
            Some((_, others)) if K::Blend::VALUE.is_some() => others,
            _ => &[],
        }
    }

    /// Whether lobes are atoms.
    #[inline(always)]
    pub fn is_specular(&self) -> bool {
        Specular::<K>::VALUE.is_some() && self.specular
    }

    /// Whether there are other parts or holes.
    #[inline(always)]
    pub fn is_mixture(&self) -> bool {
        !self.others().is_empty() || self.holes.is_some()
    }

    /// Whether it scatters no light at all.
    #[inline]
    pub fn is_black(&self) -> bool {
        self.base.model.is_black()
            && self.others().iter().all(|layer| layer.model.is_black())
            && self.holes.is_none()
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
    let mut parts = Parts { layers: Vec::new(), blend: None, holes: None, oriented: false };
    parts.add(bsdf, front, &Around { factors: Vec::new(), bump: None, from_behind: false })?;
    let Parts { layers, blend, holes, oriented } = parts;
    let black = Layer { model: Model::Black, factors: Box::new([]), bump: None };
    let mut layers = layers.into_iter();
    let base = layers.next().unwrap_or(black);
    let others: Box<[_]> = layers.collect();
    let varied = others.iter().any(|layer| layer.bump != base.bump);
    let is_specular = |layer: &Layer<K>| layer.model.is_specular();
    let specular = holes.is_some() || is_specular(&base) || others.iter().any(is_specular);
    let more = blend.filter(|_| !others.is_empty()).map(|present| (present, others));
    Ok(Side { base, more, holes, varied, oriented, specular })
}

/// What is around a part of a material.
#[derive(Clone)]
struct Around<K: SceneKind> {
    factors: Vec<Factor>,
    bump: Turned<K>,
    /// Whether opaque models may be seen from behind, because turned normals may face there.
    from_behind: bool,
}

impl<K: SceneKind> Around<K> {
    fn times(&self, factor: Factor) -> Self {
        Around { factors: [&*self.factors, &[factor]].concat(), ..self.clone() }
    }
}

/// The parts of a side, while they are collected.
struct Parts<K: SceneKind> {
    layers: Vec<Layer<K>>,
    blend: Option<K::Blend>,
    holes: Option<K::Mask>,
    oriented: bool,
}

impl<K: SceneKind> Parts<K> {
    fn add(&mut self, bsdf: &Bsdf, front: bool, around: &Around<K>) -> Result<(), NotCovered> {
        let missing = || missing::<K>(bsdf.feature());
        match bsdf {
            Bsdf::TwoSided(sides) => {
                let around = Around { from_behind: false, ..around.clone() };
                self.add(&sides[usize::from(!front)], true, &around)
            }
            Bsdf::Mask { opacity, nested } => {
                let present = K::Mask::VALUE.ok_or_else(missing)?;
                if opacity.value == 1.0 {
                    return self.add(nested, front, around);
                }
                self.holes = Some(present);
                self.add(nested, front, &around.times(Factor::Of(*opacity)))
            }
            Bsdf::Bump { bump, nested } => {
                let turned = K::Bumps::with(|| (*bump, front)).ok_or_else(missing)?;
                self.oriented = true;
                let (from_behind, bump) = (!bump.flip_invalid, Some(turned));
                self.add(nested, front, &Around { bump, from_behind, ..around.clone() })
            }
            Bsdf::Blend { weight, nested } => {
                self.blend = Some(K::Blend::VALUE.ok_or_else(missing)?);
                if weight.value < 1.0 {
                    self.add(&nested[0], front, &around.times(Factor::Rest(*weight)))?;
                }
                if weight.value > 0.0 {
                    self.add(&nested[1], front, &around.times(Factor::Of(*weight)))?;
                }
                Ok(())
            }
            other => {
                self.oriented |= other.is_anisotropic() && K::Anisotropy::VALUE.is_some();
                self.layers.push(Layer {
                    model: model(other, front || around.from_behind)?,
                    factors: around.factors.clone().into(),
                    bump: around.bump,
                });
                Ok(())
            }
        }
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
        // These have been taken apart.
        Bsdf::TwoSided(_) | Bsdf::Mask { .. } | Bsdf::Blend { .. } | Bsdf::Bump { .. } => {
            return Ok(Model::Black);
        }
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
