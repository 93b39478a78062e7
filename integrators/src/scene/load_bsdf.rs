//! From a `<bsdf>` to a [`Bsdf`].

use glam::{DVec3, Vec3};

use super::bsdf::*;
use super::document::{Document, ObjectId, Query};
use super::error::SceneError;
use super::indices;
use super::load_texture::Textures;
use super::spectrum::Purpose;

/// The plugins that exist here.
const SUPPORTED: &str = "diffuse, conductor, dielectric, thindielectric, roughconductor, \
                         roughdielectric, plastic, roughplastic, twosided, mask, blendbsdf";

/// How deep materials may be nested: a mixture in a mixture in a two-sided one has no use.
const DEEPEST: usize = 8;

/// Reads a material.
pub fn read(
    document: &Document,
    id: ObjectId,
    textures: &mut Textures,
) -> Result<Bsdf, SceneError> {
    nested(document, id, 0, textures)
}

fn nested(
    document: &Document,
    id: ObjectId,
    depth: usize,
    textures: &mut Textures,
) -> Result<Bsdf, SceneError> {
    let query = document.query(id);
    if depth > DEEPEST {
        return Err(query.error_at("", "materials are nested too deeply"));
    }
    let mut children = || -> Result<Vec<Bsdf>, SceneError> {
        let tagged = query.children().filter(|(_, id)| document.objects[*id].tag == "bsdf");
        tagged.map(|(_, id)| nested(document, id, depth + 1, textures)).collect()
    };
    let bsdf = match query.object.plugin.as_str() {
        "diffuse" => Bsdf::Diffuse(Diffuse {
            reflectance: textures.colour(document, &query, "reflectance", 0.5)?,
        }),
        "conductor" => Bsdf::Conductor(Conductor {
            metal: metal(&query)?,
            reflectance: textures.colour(document, &query, "specular_reflectance", 1.0)?,
        }),
        "roughconductor" => Bsdf::RoughConductor(RoughConductor {
            roughness: roughness(&query)?,
            metal: metal(&query)?,
            reflectance: textures.colour(document, &query, "specular_reflectance", 1.0)?,
        }),
        "dielectric" => Bsdf::Dielectric(Dielectric {
            eta: relative_index(&query)?,
            reflectance: textures.colour(document, &query, "specular_reflectance", 1.0)?,
            transmittance: textures.colour(document, &query, "specular_transmittance", 1.0)?,
        }),
        "thindielectric" => Bsdf::ThinDielectric(ThinDielectric {
            eta: relative_index(&query)?,
            reflectance: textures.colour(document, &query, "specular_reflectance", 1.0)?,
            transmittance: textures.colour(document, &query, "specular_transmittance", 1.0)?,
        }),
        "roughdielectric" => rough_dielectric(document, &query, textures)?,
        "plastic" => Bsdf::Plastic(Plastic {
            eta: plastic_index(&query)?,
            diffuse: textures.colour(document, &query, "diffuse_reflectance", 0.5)?,
            reflectance: textures.colour(document, &query, "specular_reflectance", 1.0)?,
            nonlinear: query.boolean("nonlinear")?.unwrap_or(false),
        }),
        "roughplastic" => Bsdf::RoughPlastic(RoughPlastic {
            roughness: roughness(&query)?,
            eta: plastic_index(&query)?,
            diffuse: textures.colour(document, &query, "diffuse_reflectance", 0.5)?,
            reflectance: textures.colour(document, &query, "specular_reflectance", 1.0)?,
            nonlinear: query.boolean("nonlinear")?.unwrap_or(false),
        }),
        "twosided" => two_sided(&query, children()?)?,
        "mask" => mask(&query, children()?)?,
        "blendbsdf" => blend(&query, children()?)?,
        _ => return Err(query.unsupported(SUPPORTED)),
    };
    let is_nested = matches!(bsdf, Bsdf::TwoSided(_) | Bsdf::Mask { .. } | Bsdf::Blend { .. });
    query.finish(if is_nested { &["bsdf"] } else { &["texture"] })?;
    let known =
        ["reflectance", "diffuse_reflectance", "specular_reflectance", "specular_transmittance"];
    let mut nested = query.children().filter(|_| !is_nested);
    if let Some((property, _)) = nested.find(|(p, _)| !known.contains(&p.name.as_str())) {
        return Err(property.place.error(format!(
            "unreferenced texture \"{}\" in {}",
            property.name, query.object.place.element
        )));
    }
    Ok(bsdf)
}

fn two_sided(query: &Query, mut nested: Vec<Bsdf>) -> Result<Bsdf, SceneError> {
    query.ignore(&["allow_transmission"]);
    if nested.is_empty() || nested.len() > 2 {
        return Err(query.error_at("", "needs one or two nested <bsdf>"));
    }
    for side in &nested {
        if let Bsdf::Dielectric(_)
        | Bsdf::ThinDielectric(_)
        | Bsdf::RoughDielectric(_)
        | Bsdf::Mask { .. } = side
        {
            let message = format!("\"{}\" lets light through: it has both sides", side.name());
            return Err(query.error_at("", message));
        }
    }
    let back = nested.pop();
    let front = nested.pop().or_else(|| back.clone());
    match (front, back) {
        (Some(front), Some(back)) => Ok(Bsdf::TwoSided(Box::new([front, back]))),
        _ => Err(query.error_at("", "needs one or two nested <bsdf>")),
    }
}

fn mask(query: &Query, mut nested: Vec<Bsdf>) -> Result<Bsdf, SceneError> {
    let opacity = share(query, "opacity", Some(0.5))?;
    match (nested.pop(), nested.pop()) {
        (Some(Bsdf::Mask { .. }), None) => {
            Err(query.error_at("", "a mask within a mask: multiply their opacities"))
        }
        (Some(nested), None) => Ok(Bsdf::Mask { opacity, nested: Box::new(nested) }),
        _ => Err(query.error_at("", "needs one nested <bsdf>")),
    }
}

fn blend(query: &Query, nested: Vec<Bsdf>) -> Result<Bsdf, SceneError> {
    let weight = share(query, "weight", None)?;
    let nested: [Bsdf; 2] =
        nested.try_into().map_err(|_| query.error_at("", "needs two nested <bsdf>"))?;
    if nested.iter().any(|bsdf| matches!(bsdf, Bsdf::Blend { .. } | Bsdf::Mask { .. })) {
        let message = "mixtures of mixtures and of masks are not supported; put the mask outside";
        return Err(query.error_at("", message));
    }
    Ok(Bsdf::Blend { weight, nested: Box::new(nested) })
}

/// A grey value in [0, 1].
fn share(query: &Query, name: &'static str, default: Option<f64>) -> Result<f32, SceneError> {
    reject_texture(query, name)?;
    let value = query.color(name, Purpose::Reflectance)?.map(|c| c.element_sum() / 3.0).or(default);
    let value =
        value.ok_or_else(|| query.error_at("", format!("the float \"{name}\" is missing")))?;
    if !(0.0..=1.0).contains(&value) {
        return Err(query.error_at(name, format!("\"{name}\" is {value}, but must lie in [0, 1]")));
    }
    Ok(value as f32)
}

/// A reflectance or transmittance.
pub fn colour(query: &Query, name: &'static str, default: f64) -> Result<Vec3, SceneError> {
    reject_texture(query, name)?;
    let colour = query.color(name, Purpose::Reflectance)?.unwrap_or(DVec3::splat(default));
    if colour.min_element() < 0.0 || colour.max_element() > 1.0 {
        let what = name.replace('_', " ");
        let message = format!("the {what} {colour} must lie in [0, 1]");
        return Err(query.error_at(name, message));
    }
    Ok(colour.as_vec3())
}

/// The index of refraction of a metal: by name, or as `eta` and `k`, over what is outside.
fn metal(query: &Query) -> Result<Option<Metal>, SceneError> {
    let material = query.string("material")?;
    let eta = query.color("eta", Purpose::Reflectance)?;
    let k = query.color("k", Purpose::Reflectance)?;
    let outside = index(query, "ext_eta", "vacuum")?;
    let (eta, k) = match (material, eta, k) {
        (Some(_), Some(_), _) | (Some(_), _, Some(_)) => {
            return Err(query.error_at("material", "give either a material or eta and k, not both"));
        }
        (Some("none"), None, None) => return Ok(None),
        (Some(name), None, None) => {
            indices::metal(name).map_err(|e| query.error_at("material", e))?
        }
        (None, Some(eta), Some(k)) => (eta, k),
        // Mitsuba's defaults.
        (None, None, None) => return Ok(None),
        (None, _, _) => return Err(query.error_at("", "\"eta\" and \"k\" belong together")),
    };
    let (eta, k) = (eta / outside, k / outside);
    if eta.min_element() < 0.0
        || k.min_element() < 0.0
        || eta.max_element().max(k.max_element()) > 1e3
    {
        return Err(query.error_at("eta", "eta and k must lie in [0, 1000]"));
    }
    Ok(Some(Metal { eta: eta.as_vec3(), k: k.as_vec3() }))
}

/// The index of refraction inside over that outside.
fn relative_index(query: &Query) -> Result<f32, SceneError> {
    let inside = index(query, "int_ior", "bk7")?;
    let outside = index(query, "ext_ior", "air")?;
    let eta = inside / outside;
    if !(0.01..=100.0).contains(&eta) {
        let message = format!("the relative index of refraction {eta} must lie in 0.01..=100");
        return Err(query.error_at("int_ior", message));
    }
    Ok(eta as f32)
}

/// Closer to one, an index of refraction bends light by less than single precision resolves well.
const LEAST_REFRACTION: f32 = 3e-5;

fn rough_dielectric(
    document: &Document,
    query: &Query,
    textures: &mut Textures,
) -> Result<Bsdf, SceneError> {
    let (roughness, eta) = (roughness(query)?, relative_index(query)?);
    let reflectance = textures.colour(document, query, "specular_reflectance", 1.0)?;
    let transmittance = textures.colour(document, query, "specular_transmittance", 1.0)?;
    if !(0.4..=2.5).contains(&eta) {
        let message = format!(
            "the relative index of refraction of a rough boundary is {eta}, but must lie in 0.4..=2.5"
        );
        return Err(query.error_at("int_ior", message));
    }
    if (eta - 1.0).abs() < LEAST_REFRACTION {
        // It reflects less than 1e-9 of the light, and the rest passes straight on.
        return Ok(Bsdf::ThinDielectric(ThinDielectric { eta: 1.0, reflectance, transmittance }));
    }
    Ok(Bsdf::RoughDielectric(RoughDielectric { roughness, eta, reflectance, transmittance }))
}

fn plastic_index(query: &Query) -> Result<f32, SceneError> {
    let eta = index(query, "int_ior", "polypropylene")? / index(query, "ext_ior", "air")?;
    if !(1.0..=100.0).contains(&eta) {
        let message = format!("the coat's relative index of refraction {eta} must lie in 1..=100");
        return Err(query.error_at("int_ior", message));
    }
    Ok(eta as f32)
}

/// An index of refraction: a number or the name of a material.
fn index(query: &Query, name: &'static str, default: &str) -> Result<f64, SceneError> {
    let value = match query.get(name).map(|property| &property.value) {
        None => indices::dielectric(default),
        Some(super::document::Value::String(material)) => indices::dielectric(material),
        Some(_) => Ok(query.float(name)?.unwrap_or(1.0)),
    };
    let value = value.map_err(|e| query.error_at(name, e))?;
    if value > 0.0 && value <= 1e3 {
        Ok(value)
    } else {
        Err(query.error_at(name, format!("the index of refraction {value} must lie in (0, 1000]")))
    }
}

/// The microfacets.
fn roughness(query: &Query) -> Result<Roughness, SceneError> {
    let distribution = match query.string("distribution")?.unwrap_or("beckmann") {
        "beckmann" => Distribution::Beckmann,
        "ggx" => Distribution::Ggx,
        other => {
            let message = format!("\"{other}\" is no distribution; supported: beckmann, ggx");
            return Err(query.error_at("distribution", message));
        }
    };
    reject_texture(query, "alpha")?;
    let both = query.float("alpha")?;
    let across = [query.float("alpha_u")?, query.float("alpha_v")?];
    let alpha = match (both, across) {
        (Some(_), [Some(_), _]) | (Some(_), [_, Some(_)]) => {
            return Err(query.error_at("alpha", "give either alpha or alpha_u and alpha_v"));
        }
        (both, [u, v]) => {
            let both = both.unwrap_or(0.1);
            [u.unwrap_or(both), v.unwrap_or(both)]
        }
    };
    if alpha[0] != alpha[1] {
        return Err(query.error_at(
            "alpha_u",
            "different roughnesses along and across the surface are \
             not supported; give one alpha",
        ));
    }
    if alpha.iter().any(|a| !(1e-5..=10.0).contains(a)) {
        let message =
            "the roughness must lie in 1e-5..=10; for less, there are the smooth materials";
        return Err(query.error_at("alpha", message));
    }
    let sample_visible = query.boolean("sample_visible")?.unwrap_or(true);
    Ok(Roughness { distribution, alpha: alpha.map(|a| a as f32), sample_visible })
}

/// Colours that vary over the surface are a likely wish; say so plainly.
pub fn reject_texture(query: &Query, name: &str) -> Result<(), SceneError> {
    match query.children().find(|(property, _)| property.name == name) {
        Some((property, _)) => Err(property.place.error(format!(
            "textures are not supported here; supported for \"{name}\": rgb, spectrum, float"
        ))),
        None => Ok(()),
    }
}
