//! From an `<emitter>` to a light.

use glam::{DMat4, DVec3, Vec3};

use super::document::{Document, Query};
use super::envmap::EnvironmentMap;
use super::error::SceneError;
use super::lights::{Bulb, Cone, Distant, Sky, Slide};
use super::load_bsdf::reject_texture;
use super::load_texture::Textures;
use super::spectrum::Purpose;
use super::texture::Colour;
use crate::image::decode;

/// The plugins that exist outside of shapes.
const SUPPORTED: &str = "area (inside a <shape>), constant, envmap, point, spot, directional";

/// A light without a surface; positions are those of the file.
pub enum Lone {
    /// The sky.
    Sky(Sky),
    /// A point light and its position in double precision.
    Bulb(Bulb, DVec3),
    /// Parallel light.
    Distant(Distant),
}

/// Reads an emitter that stands alone.
pub fn read_lone(
    document: &Document,
    query: &Query,
    textures: &mut Textures,
) -> Result<Lone, SceneError> {
    let light = match query.object.plugin.as_str() {
        "constant" => Lone::Sky(Sky::Constant(emission(query, "radiance")?)),
        "envmap" => Lone::Sky(Sky::Picture(envmap(query)?)),
        "point" => {
            let position = position(query)?;
            let bulb =
                Bulb { position: Vec3::ZERO, intensity: emission(query, "intensity")?, cone: None };
            Lone::Bulb(bulb, position)
        }
        "spot" => spot(document, query, textures)?,
        "directional" => directional(query)?,
        "area" => return Err(query.error_at("", "an area emitter must stand inside a <shape>")),
        _ => return Err(query.unsupported(SUPPORTED)),
    };
    query.ignore(&["sampling_weight"]);
    query.finish(if query.object.plugin == "spot" { &["texture"] } else { &[] })?;
    Ok(light)
}

/// Reads the emission of a shape, which may vary over it.
pub fn read_area(
    document: &Document,
    query: &Query,
    textures: &mut Textures,
) -> Result<Colour, SceneError> {
    if query.object.plugin != "area" {
        return Err(query.unsupported("area"));
    }
    let radiance = match textures.emitted(document, query, "radiance")? {
        Some(texture) => texture,
        None => emission(query, "radiance")?.into(),
    };
    query.ignore(&["sampling_weight"]);
    only_texture(query, "radiance")?;
    query.finish(&["texture"])?;
    Ok(radiance)
}

/// That a light has no texture but one of that name.
fn only_texture(query: &Query, name: &str) -> Result<(), SceneError> {
    match query.children().find(|(property, _)| property.name != name) {
        Some((property, _)) => {
            let message = format!("this light has no texture but \"{name}\"");
            Err(property.place.error(message))
        }
        None => Ok(()),
    }
}

fn emission(query: &Query, name: &'static str) -> Result<Vec3, SceneError> {
    reject_texture(query, name)?;
    let value = query.color(name, Purpose::Emission)?.unwrap_or(DVec3::ONE);
    if value.is_nan() || value.min_element() < 0.0 || value.max_element() > 1e18 {
        let message = format!("the {name} {value} must lie in [0, 1e18]");
        return Err(query.error_at(name, message));
    }
    Ok(value.as_vec3())
}

fn envmap(query: &Query) -> Result<EnvironmentMap, SceneError> {
    let path = query.file()?;
    let to_world = query.transform("to_world")?.unwrap_or(DMat4::IDENTITY);
    let scale = query.float("scale")?.unwrap_or(1.0);
    if scale < 0.0 {
        return Err(query.error_at("scale", "must not be negative"));
    }
    // These concern how others sample, store and decode it.
    query.ignore(&["mis_compensation", "cache", "gamma"]);
    let image = decode::read(&path, false);
    let image = image.map_err(|e| query.error_at("filename", e.to_string()))?;
    EnvironmentMap::new(image.into_image(), scale, &to_world).map_err(|e| query.error_at("", e))
}

fn position(query: &Query) -> Result<DVec3, SceneError> {
    let to_world = query.transform("to_world")?;
    let position = query.vector("position")?;
    if to_world.is_some() && position.is_some() {
        return Err(query.error_at("position", "give either position or to_world, not both"));
    }
    let moved = to_world.map(|m| m.w_axis.truncate());
    let named = if moved.is_some() { "to_world" } else { "position" };
    query.near_enough("light", (named, position.or(moved).unwrap_or(DVec3::ZERO)))
}

fn spot(document: &Document, query: &Query, textures: &mut Textures) -> Result<Lone, SceneError> {
    let intensity = emission(query, "intensity")?;
    let picture = textures.emitted(document, query, "texture")?;
    only_texture(query, "texture")?;
    let to_world = query.transform("to_world")?.unwrap_or(DMat4::IDENTITY);
    let axis = to_world.transform_vector3(DVec3::Z).try_normalize();
    let axis = axis.ok_or_else(|| query.error_at("to_world", "the transform flattens space"))?;
    let cutoff = query.float("cutoff_angle")?.unwrap_or(20.0);
    let beam_width = query.float("beam_width")?.unwrap_or(0.75 * cutoff);
    if !(cutoff > 0.0 && cutoff <= 180.0 && beam_width >= 0.0 && beam_width < cutoff) {
        let message = "needs 0 <= beam_width < cutoff_angle <= 180 degrees";
        return Err(query.error_at("cutoff_angle", message));
    }
    let axes = [DVec3::X, DVec3::Y]
        .map(|axis| to_world.transform_vector3(axis).normalize_or_zero().as_vec3());
    let slide = picture
        .and_then(|Colour { value: mean, texture }| Some(Slide { texture: texture?, mean, axes }));
    let cone = Cone {
        axis: axis.as_vec3(),
        beam_width: beam_width.to_radians() as f32,
        cutoff: cutoff.to_radians() as f32,
        slide,
    };
    let bulb = Bulb { position: Vec3::ZERO, intensity, cone: Some(cone) };
    Ok(Lone::Bulb(bulb, query.near_enough("light", ("to_world", to_world.w_axis.truncate()))?))
}

fn directional(query: &Query) -> Result<Lone, SceneError> {
    let to_world = query.transform("to_world")?;
    let direction = query.vector("direction")?;
    let along = match (to_world, direction) {
        (Some(_), Some(_)) => {
            return Err(query.error_at("direction", "give either direction or to_world, not both"));
        }
        (_, Some(direction)) => direction,
        (Some(m), None) => m.transform_vector3(DVec3::Z),
        (None, None) => DVec3::Z,
    };
    let along = along.try_normalize();
    let along = along.ok_or_else(|| query.error_at("direction", "must not be zero"))?;
    let irradiance = emission(query, "irradiance")?;
    Ok(Lone::Distant(Distant { towards: -along.as_vec3(), irradiance }))
}
