//! From a `<bsdf>` to a [`Bsdf`].

use glam::{DVec3, Vec3};

use super::bsdf::*;
use super::document::{Document, ObjectId, Property, Query};
use super::error::SceneError;
use super::indices;
use super::load_texture::Textures;
use super::spectrum::Purpose;
use super::texture::{Grey, Pattern};

/// The plugins that exist here.
const SUPPORTED: &str = "diffuse, conductor, dielectric, thindielectric, roughconductor, \
                         roughdielectric, plastic, roughplastic, phong, twosided, mask, blendbsdf, \
                         bumpmap, normalmap, null";

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
            facets: facets(document, &query, textures)?,
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
            conserving: true,
        }),
        "phong" => phong(document, &query, textures)?,
        "twosided" => two_sided(&query, children()?)?,
        // All light passes: a mask with nothing but holes.
        "null" => {
            let black = Bsdf::Diffuse(Diffuse { reflectance: Vec3::ZERO.into() });
            Bsdf::Mask { opacity: 0.0.into(), nested: Box::new(black) }
        }
        "mask" => {
            let nested = children()?;
            mask(&query, share(document, &query, textures, "opacity", Some(0.5))?, nested)?
        }
        "blendbsdf" => {
            let nested = children()?;
            blend(&query, share(document, &query, textures, "weight", None)?, nested)?
        }
        "bumpmap" | "normalmap" => {
            let nested = children()?;
            bumped(document, &query, textures, nested)?
        }
        _ => return Err(query.unsupported(SUPPORTED)),
    };
    if let Bsdf::Conductor(_) | Bsdf::Dielectric(_) = &bsdf {
        // What old files keep of a rough material that was made smooth.
        query.ignore(&["alpha"]);
    }
    let tags: &[&str] = match &bsdf {
        Bsdf::TwoSided(_) => &["bsdf"],
        Bsdf::Mask { .. } | Bsdf::Blend { .. } | Bsdf::Bump { .. } => &["bsdf", "texture"],
        _ => &["texture"],
    };
    query.finish(tags)?;
    let known = textures_of(&bsdf);
    let mut nested = query.children().filter(|(_, id)| document.objects[*id].tag == "texture");
    if let Some((property, _)) =
        nested.find(|(p, _)| !known.contains(&p.name.as_str()) && !known.is_empty())
    {
        return Err(property.place.error(format!(
            "unreferenced texture \"{}\" in {}; supported: {}",
            property.name,
            query.object.place.element,
            known.join(", ")
        )));
    }
    Ok(bsdf)
}

/// The names of the textures that a material can have; that of a height field has any name.
fn textures_of(bsdf: &Bsdf) -> &'static [&'static str] {
    match bsdf {
        Bsdf::Diffuse(_) => &["reflectance"],
        Bsdf::Conductor(_) => &["specular_reflectance"],
        Bsdf::RoughConductor(_) => &["specular_reflectance", "alpha", "alpha_u", "alpha_v"],
        Bsdf::Dielectric(_) | Bsdf::ThinDielectric(_) => {
            &["specular_reflectance", "specular_transmittance"]
        }
        Bsdf::RoughDielectric(_) => {
            &["specular_reflectance", "specular_transmittance", "alpha", "alpha_u", "alpha_v"]
        }
        Bsdf::Plastic(_) | Bsdf::RoughPlastic(_) | Bsdf::Phong(_) => {
            &["diffuse_reflectance", "specular_reflectance"]
        }
        Bsdf::Mask { .. } => &["opacity"],
        Bsdf::Blend { .. } => &["weight"],
        Bsdf::TwoSided(_) | Bsdf::Bump { .. } => &[],
    }
}

fn two_sided(query: &Query, mut nested: Vec<Bsdf>) -> Result<Bsdf, SceneError> {
    query.ignore(&["allow_transmission"]);
    if nested.is_empty() || nested.len() > 2 {
        return Err(query.error_at("", "needs one or two nested <bsdf>"));
    }
    for side in &nested {
        if lets_light_through(side) {
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

/// Whether light may get to the other side.
fn lets_light_through(bsdf: &Bsdf) -> bool {
    match bsdf {
        Bsdf::Dielectric(_) | Bsdf::ThinDielectric(_) | Bsdf::RoughDielectric(_) => true,
        Bsdf::Mask { .. } => true,
        Bsdf::Bump { nested, .. } => lets_light_through(nested),
        Bsdf::Blend { nested, .. } => nested.iter().any(lets_light_through),
        _ => false,
    }
}

/// A surface whose normals are turned by heights, or by a texture that gives them.
fn bumped(
    document: &Document,
    query: &Query,
    textures: &mut Textures,
    mut nested: Vec<Bsdf>,
) -> Result<Bsdf, SceneError> {
    let heights = query.object.plugin == "bumpmap";
    let id = query.child("texture")?;
    let id = id.ok_or_else(|| query.error_at("", "needs one nested <texture>"))?;
    let named = |(property, _): &(&Property, ObjectId)| property.name == "normalmap";
    if !heights && !query.children().any(|child| named(&child)) {
        return Err(query.error_at("", "the texture \"normalmap\" is missing"));
    }
    let scale = if heights { query.float("scale")?.unwrap_or(1.0) } else { 1.0 };
    if scale.is_nan() || scale.abs() > 1e6 {
        let message = format!("\"scale\" is {scale}, but at most 1e6 is allowed");
        return Err(query.error_at("scale", message));
    }
    let texture = textures.index(document, id)?;
    if heights && matches!(textures.list[texture as usize].pattern, Pattern::Attribute { .. }) {
        return Err(query.error_at("", "attributes of meshes are not supported as heights"));
    }
    let bump = Bump {
        texture,
        relief: if heights { Relief::Heights(scale as f32) } else { Relief::Normals },
        flip_invalid: query.boolean("flip_invalid_normals")?.unwrap_or(true),
        shadowing: query.boolean("use_shadowing_function")?.unwrap_or(true),
    };
    match (nested.pop(), nested.pop()) {
        (Some(nested), None) if is_bumped(&nested) => {
            Err(query.error_at("", "other bumps within a bump are not supported"))
        }
        (Some(nested), None) => Ok(Bsdf::Bump { bump, nested: Box::new(nested) }),
        _ => Err(query.error_at("", "needs one nested <bsdf>")),
    }
}

fn phong(document: &Document, query: &Query, textures: &mut Textures) -> Result<Bsdf, SceneError> {
    let diffuse = textures.colour(document, query, "diffuse_reflectance", 0.5)?;
    let specular = textures.colour(document, query, "specular_reflectance", 0.2)?;
    let exponent = query.float("exponent")?.unwrap_or(30.0);
    if !(0.0..=1e5).contains(&exponent) {
        let message = format!("the exponent is {exponent}, but must lie in 0..=100000");
        return Err(query.error_at("exponent", message));
    }
    // As in Mitsuba 0.6: both are scaled where they may reflect more than there is.
    let most = (textures.largest(&diffuse) + textures.largest(&specular)).max_element();
    let scale = 1.0 / most.max(1.0);
    Ok(Bsdf::Phong(Phong { diffuse, specular, exponent: exponent as f32, scale }))
}

fn mask(query: &Query, opacity: Grey, mut nested: Vec<Bsdf>) -> Result<Bsdf, SceneError> {
    match (nested.pop(), nested.pop()) {
        (Some(nested), None) => Ok(Bsdf::Mask { opacity, nested: Box::new(nested) }),
        _ => Err(query.error_at("", "needs one nested <bsdf>")),
    }
}

fn blend(query: &Query, weight: Grey, nested: Vec<Bsdf>) -> Result<Bsdf, SceneError> {
    let nested: [Bsdf; 2] =
        nested.try_into().map_err(|_| query.error_at("", "needs two nested <bsdf>"))?;
    let parts: usize = nested.iter().map(parts).sum();
    if parts > MOST_PARTS {
        let message = format!("a mixture of {parts} materials; at most {MOST_PARTS} are supported");
        return Err(query.error_at("", message));
    }
    Ok(Bsdf::Blend { weight, nested: Box::new(nested) })
}

/// How many parts a mixture of mixtures may have.
const MOST_PARTS: usize = 15;

/// How many materials are mixed at most on one side.
fn parts(bsdf: &Bsdf) -> usize {
    match bsdf {
        Bsdf::TwoSided(sides) => parts(&sides[0]).max(parts(&sides[1])),
        Bsdf::Mask { nested, .. } | Bsdf::Bump { nested, .. } => parts(nested),
        Bsdf::Blend { nested, .. } => parts(&nested[0]) + parts(&nested[1]),
        _ => 1,
    }
}

/// Whether anything turns the normals of a material or of a part of it.
fn is_bumped(bsdf: &Bsdf) -> bool {
    match bsdf {
        Bsdf::Bump { .. } => true,
        Bsdf::Mask { nested, .. } => is_bumped(nested),
        Bsdf::TwoSided(nested) | Bsdf::Blend { nested, .. } => nested.iter().any(is_bumped),
        _ => false,
    }
}

/// A grey value in [0, 1], or a texture.
fn share(
    document: &Document,
    query: &Query,
    textures: &mut Textures,
    name: &'static str,
    default: Option<f64>,
) -> Result<Grey, SceneError> {
    if let Some(grey) = textures.grey(document, query, name, 1.0)? {
        return Ok(grey);
    }
    let value = query.color(name, Purpose::Reflectance)?.map(|c| c.element_sum() / 3.0).or(default);
    let value =
        value.ok_or_else(|| query.error_at("", format!("the float \"{name}\" is missing")))?;
    if !(0.0..=1.0).contains(&value) {
        return Err(query.error_at(name, format!("\"{name}\" is {value}, but must lie in [0, 1]")));
    }
    Ok(Grey::from(value as f32))
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
    let (facets, eta) = (facets(document, query, textures)?, relative_index(query)?);
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
    Ok(Bsdf::RoughDielectric(RoughDielectric { facets, eta, reflectance, transmittance }))
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

/// The microfacets of a surface whose roughness is the same everywhere and in all directions.
fn roughness(query: &Query) -> Result<Roughness, SceneError> {
    for name in ["alpha", "alpha_u", "alpha_v"] {
        reject_texture(query, name)?;
    }
    let alpha = alphas(query, [None; 2])?;
    if alpha[0] != alpha[1] {
        let message = "rough plastic has the same roughness in all directions; give one alpha";
        return Err(query.error_at("alpha_u", message));
    }
    let (distribution, sample_visible) = facet_normals(query)?;
    Ok(Roughness { distribution, alpha: alpha.map(|alpha| alpha.value), sample_visible })
}

/// The microfacets.
fn facets(
    document: &Document,
    query: &Query,
    textures: &mut Textures,
) -> Result<Facets, SceneError> {
    let mut texture = |name| textures.grey(document, query, name, 10.0);
    let alpha = match texture("alpha")? {
        Some(both) if query.get("alpha_u").or(query.get("alpha_v")).is_none() => [both; 2],
        Some(_) => return Err(query.error_at("alpha", EITHER)),
        None => {
            let across = [texture("alpha_u")?, texture("alpha_v")?];
            alphas(query, across)?
        }
    };
    let (distribution, sample_visible) = facet_normals(query)?;
    Ok(Facets { distribution, alpha, sample_visible })
}

/// What is wrong with three roughnesses.
const EITHER: &str = "give either alpha or alpha_u and alpha_v";

/// The roughness along and across the surface, of which textures may have given some.
fn alphas(query: &Query, textures: [Option<Grey>; 2]) -> Result<[Grey; 2], SceneError> {
    let number = |name: &'static str, texture: Option<Grey>| match texture {
        Some(texture) => Ok(Some(texture)),
        None => Ok(query.float(name)?.map(|alpha| Grey::from(alpha as f32))),
    };
    let both = number("alpha", None)?;
    let across = [number("alpha_u", textures[0])?, number("alpha_v", textures[1])?];
    if both.is_some() && across.iter().any(Option::is_some) {
        return Err(query.error_at("alpha", EITHER));
    }
    let both = both.unwrap_or(Grey::from(0.1));
    let alpha = across.map(|alpha| alpha.unwrap_or(both));
    let fits = |alpha: &Grey| alpha.texture.is_some() || (1e-5..=10.0).contains(&alpha.value);
    if !alpha.iter().all(fits) {
        let message =
            "the roughness must lie in 1e-5..=10; for less, there are the smooth materials";
        let names = ["alpha", "alpha_u", "alpha_v"];
        let name = names.into_iter().find(|name| query.get(name).is_some());
        return Err(query.error_at(name.unwrap_or(""), message));
    }
    Ok(alpha)
}

/// The distribution of the normals of facets, and whether only visible ones are sampled.
fn facet_normals(query: &Query) -> Result<(Distribution, bool), SceneError> {
    let distribution = match query.string("distribution")?.unwrap_or("beckmann") {
        "beckmann" => Distribution::Beckmann,
        "ggx" => Distribution::Ggx,
        other => {
            let message = format!("\"{other}\" is no distribution; supported: beckmann, ggx");
            return Err(query.error_at("distribution", message));
        }
    };
    Ok((distribution, query.boolean("sample_visible")?.unwrap_or(true)))
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
