//! From a `<texture>` to a [`Texture`].

use std::collections::HashMap;

use glam::{Affine2, DVec3, Mat2, Vec2, Vec3};

use super::document::{Document, ObjectId, Property, Query};
use super::error::SceneError;
use super::files::find_file;
use super::spectrum::Purpose;
use super::texture::{Colour, Interpolation, Pattern, Texture, Wrap};
use crate::image::decode;

/// The textures of a scene under construction.
#[derive(Default)]
pub struct Textures {
    /// All that are referred to.
    pub list: Vec<Texture>,
    indices: HashMap<ObjectId, u32>,
}

impl Textures {
    /// A reflectance that may vary over the surface.
    pub fn colour(
        &mut self,
        document: &Document,
        query: &Query,
        name: &'static str,
        default: f64,
    ) -> Result<Colour, SceneError> {
        let Some((property, id)) = query.children().find(|(property, _)| property.name == name)
        else {
            return super::load_bsdf::colour(query, name, default).map(Colour::from);
        };
        self.between(document, (property, id), 1.0)
    }

    /// Radiance that may vary over the surface, if a texture gives it.
    pub fn radiance(
        &mut self,
        document: &Document,
        query: &Query,
    ) -> Result<Option<Colour>, SceneError> {
        let found = query.children().find(|(property, _)| property.name == "radiance");
        found.map(|found| self.between(document, found, 1e18)).transpose()
    }

    /// A texture with values from zero to `most`.
    fn between(
        &mut self,
        document: &Document,
        (property, id): (&Property, ObjectId),
        most: f32,
    ) -> Result<Colour, SceneError> {
        let index = match self.indices.get(&id) {
            Some(index) => *index,
            None => {
                let texture = read(document, id)?;
                let index = self.list.len() as u32;
                self.list.push(texture);
                self.indices.insert(id, index);
                index
            }
        };
        let texture = &self.list[index as usize];
        let (least, largest) = texture.range();
        if !(least >= 0.0 && largest <= most) {
            let name = &property.name;
            return Err(property.place.error(format!(
                "the values of \"{name}\" are from {least} to {largest}, but must lie in [0, {most}]"
            )));
        }
        Ok(Colour { value: texture.mean(), texture: Some(index) })
    }
}

fn read(document: &Document, id: ObjectId) -> Result<Texture, SceneError> {
    let query = document.query(id);
    let pattern = match query.object.plugin.as_str() {
        "bitmap" => bitmap(&query)?,
        "checkerboard" => {
            let colour = |name, default| -> Result<Vec3, SceneError> {
                let colour =
                    query.color(name, Purpose::Reflectance)?.unwrap_or(DVec3::splat(default));
                Ok(colour.as_vec3())
            };
            Pattern::Checkerboard([colour("color0", 0.4)?, colour("color1", 0.2)?])
        }
        _ => return Err(query.unsupported("bitmap, checkerboard")),
    };
    let to_uv = query.transform("to_uv")?.map_or(Affine2::IDENTITY, |m| {
        let m = m.as_mat4();
        Affine2::from_mat2_translation(
            Mat2::from_cols(m.x_axis.truncate().truncate(), m.y_axis.truncate().truncate()),
            Vec2::new(m.w_axis.x, m.w_axis.y),
        )
    });
    query.finish(&[])?;
    Ok(Texture { pattern, to_uv })
}

fn bitmap(query: &Query) -> Result<Pattern, SceneError> {
    let name = query.string("filename")?;
    let name = name.ok_or_else(|| query.error_at("", "the string \"filename\" is missing"))?;
    let path = find_file(name, &query.object.folders).map_err(|e| query.error_at("filename", e))?;
    let raw = query.boolean("raw")?.unwrap_or(false);
    let choice = |name: &'static str, default, choices: &[&str]| {
        let found = query.string(name)?.unwrap_or(default);
        choices.iter().position(|choice| *choice == found).ok_or_else(|| {
            let supported = choices.join(", ");
            query.error_at(name, format!("\"{found}\" is not supported; supported: {supported}"))
        })
    };
    let interpolation = [Interpolation::Bilinear, Interpolation::Nearest]
        [choice("filter_type", "bilinear", &["bilinear", "nearest"])?];
    let wrap = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp]
        [choice("wrap_mode", "repeat", &["repeat", "mirror", "clamp"])?];
    query.ignore(&["format", "accel", "gamma", "max_anisotropy"]);
    let image = decode::read(&path, raw).map_err(|e| query.error_at("filename", e.to_string()))?;
    Ok(Pattern::Picture { image, interpolation, wrap })
}
