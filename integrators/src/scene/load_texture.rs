//! From a `<texture>` to a [`Texture`].

use std::collections::HashMap;

use glam::{Affine2, DVec3, Mat2, Vec2, Vec3};

use super::document::{Document, ObjectId, Property, Query};
use super::error::SceneError;
use super::spectrum::Purpose;
use super::texture::{
    Colour, Grey, Interpolation, Patch, Pattern, Square, Texture, Wrap, luminance,
};
use crate::image::decode;

/// The textures of a scene under construction.
#[derive(Default)]
pub struct Textures {
    /// All that are referred to.
    pub list: Vec<Texture>,
    indices: HashMap<ObjectId, u32>,
    /// Those whose values are not known yet, with what they are for and the largest value for that.
    awaited: Vec<(u32, Property, f32)>,
}

/// What the meshes of a scene have: the name of the attribute, and its values over one of them.
pub type Attributes = Vec<(String, Patch)>;

impl Textures {
    /// A reflectance that may vary over the surface.
    pub fn colour(
        &mut self,
        document: &Document,
        query: &Query,
        name: &'static str,
        default: f64,
    ) -> Result<Colour, SceneError> {
        match self.within(document, query, name, 1.0)? {
            Some(index) => {
                let value = self.list[index as usize].mean();
                Ok(Colour { value, texture: Some(index) })
            }
            None => super::load_bsdf::colour(query, name, default).map(Colour::from),
        }
    }

    /// A texture of numbers from 0 to `largest`, if the property is one.
    pub fn grey(
        &mut self,
        document: &Document,
        query: &Query,
        name: &'static str,
        largest: f32,
    ) -> Result<Option<Grey>, SceneError> {
        let index = self.within(document, query, name, largest)?;
        Ok(index.map(|index| {
            let value = luminance(self.list[index as usize].mean());
            Grey { value, texture: Some(index) }
        }))
    }

    /// The largest value of a colour in any channel and anywhere.
    pub fn largest(&self, colour: &Colour) -> Vec3 {
        match colour.texture {
            Some(index) => Vec3::splat(self.list[index as usize].range().1),
            None => colour.value,
        }
    }

    /// The place in the list of the texture of that name, if there is one, whose values must not be negative
    /// nor larger than `limit`.
    fn within(
        &mut self,
        document: &Document,
        query: &Query,
        name: &str,
        limit: f32,
    ) -> Result<Option<u32>, SceneError> {
        let Some((property, id)) = query.children().find(|(property, _)| property.name == name)
        else {
            return Ok(None);
        };
        self.between(document, (property, id), limit).map(Some)
    }

    /// What a light emits, if a texture of that name gives it.
    pub fn emitted(
        &mut self,
        document: &Document,
        query: &Query,
        name: &str,
    ) -> Result<Option<Colour>, SceneError> {
        let found = query.children().find(|(property, _)| property.name == name);
        let Some(found) = found else { return Ok(None) };
        if document.objects[found.1].plugin == "mesh_attribute" {
            let message =
                "attributes of meshes are not supported for light; supported: bitmap, checkerboard";
            return Err(found.0.place.error(message));
        }
        let index = self.between(document, found, 1e18)?;
        let value = self.list[index as usize].mean();
        Ok(Some(Colour { value, texture: Some(index) }))
    }

    /// The place in the list of a texture, whose values must not be negative nor larger than `most`.
    fn between(
        &mut self,
        document: &Document,
        (property, id): (&Property, ObjectId),
        most: f32,
    ) -> Result<u32, SceneError> {
        let index = self.index(document, id)?;
        if matches!(self.list[index as usize].pattern, Pattern::Attribute { .. }) {
            self.awaited.push((index, property.clone(), most));
            return Ok(index);
        }
        self.check(index, property, most)?;
        Ok(index)
    }

    /// All textures, given what the meshes have.
    ///
    /// # Errors
    /// If values are out of range.
    pub fn finished(mut self, attributes: &Attributes) -> Result<Vec<Texture>, SceneError> {
        for texture in &mut self.list {
            if let Pattern::Attribute { name, patches } = &mut texture.pattern {
                let named = attributes.iter().filter(|(other, _)| other == name);
                patches.extend(named.map(|(_, patch)| patch.clone()));
            }
        }
        for (index, property, most) in &self.awaited {
            self.check(*index, property, *most)?;
        }
        Ok(self.list)
    }

    /// Whether the values of a texture are neither negative nor larger than `most`.
    fn check(&self, index: u32, property: &Property, most: f32) -> Result<(), SceneError> {
        let (least, largest) = self.list[index as usize].range();
        // No mesh has it, so nothing uses it.
        let unused = least > largest;
        if !(unused || least >= 0.0 && largest <= most) {
            let name = &property.name;
            return Err(property.place.error(format!(
                "the values of \"{name}\" are from {least} to {largest}, but must lie in [0, {most}]"
            )));
        }
        Ok(())
    }

    /// The place in the list of a texture.
    pub fn index(&mut self, document: &Document, id: ObjectId) -> Result<u32, SceneError> {
        if let Some(index) = self.indices.get(&id) {
            return Ok(*index);
        }
        let texture = read(document, id, 0)?;
        let index = self.list.len() as u32;
        self.list.push(texture);
        self.indices.insert(id, index);
        Ok(index)
    }
}

/// How deep scaled textures may be nested.
const DEEPEST: usize = 8;

fn read(document: &Document, id: ObjectId, depth: usize) -> Result<Texture, SceneError> {
    let query = document.query(id);
    if query.object.tag != "texture" {
        return Err(query.error_at("", "a <texture> is expected here"));
    }
    if query.object.plugin == "scale" {
        return scaled(document, &query, depth);
    }
    let pattern = match query.object.plugin.as_str() {
        "bitmap" => bitmap(&query)?,
        "checkerboard" => {
            let square = |name, default| square(document, &query, name, default, depth);
            Pattern::Checkerboard([square("color0", 0.4)?, square("color1", 0.2)?])
        }
        "mesh_attribute" => return attribute(&query),
        _ => return Err(query.unsupported("bitmap, checkerboard, mesh_attribute, scale")),
    };
    let to_uv = placed(&query)?;
    let squares = if matches!(pattern, Pattern::Checkerboard(_)) { &["texture"][..] } else { &[] };
    query.finish(squares)?;
    Ok(Texture { pattern, to_uv, scale: 1.0 })
}

/// What one kind of squares of a checkerboard shows.
fn square(
    document: &Document,
    query: &Query,
    name: &'static str,
    default: f64,
    depth: usize,
) -> Result<Square, SceneError> {
    if let Some((property, id)) = query.children().find(|(property, _)| property.name == name) {
        if depth > DEEPEST {
            return Err(query.error_at("", "textures are nested too deeply"));
        }
        let texture = read(document, id, depth + 1)?;
        if matches!(texture.pattern, Pattern::Attribute { .. }) {
            let message = "attributes of meshes are not supported within a checkerboard";
            return Err(property.place.error(message));
        }
        return Ok(Square::Textured(Box::new(texture)));
    }
    let mut others = query.children().filter(|(_, id)| document.objects[*id].tag == "texture");
    if let Some((property, _)) = others.find(|(p, _)| !["color0", "color1"].contains(&&*p.name)) {
        let message =
            format!("a checkerboard has no \"{}\"; supported: color0, color1", property.name);
        return Err(property.place.error(message));
    }
    let colour = query.color(name, Purpose::Reflectance)?.unwrap_or(DVec3::splat(default));
    Ok(Square::Plain(colour.as_vec3()))
}

/// What a mesh has at its vertices or faces.
fn attribute(query: &Query) -> Result<Texture, SceneError> {
    let name = attribute_name(query)?;
    let scale = query.float("scale")?.unwrap_or(1.0);
    if scale.is_nan() || scale.abs() > 1e6 {
        let message = format!("\"scale\" is {scale}, but at most 1e6 is allowed");
        return Err(query.error_at("scale", message));
    }
    query.finish(&[])?;
    let pattern = Pattern::Attribute { name, patches: Vec::new() };
    Ok(Texture { pattern, to_uv: Affine2::IDENTITY, scale: scale as f32 })
}

/// The name of the attribute that a `mesh_attribute` shows.
fn attribute_name(query: &Query) -> Result<String, SceneError> {
    let name = query.string("name")?;
    let name = name.ok_or_else(|| query.error_at("", "needs the string \"name\""))?;
    if !["vertex_", "face_"].iter().any(|start| name.starts_with(start)) {
        let message = "the name of an attribute begins with \"vertex_\" or \"face_\"";
        return Err(query.error_at("name", message));
    }
    Ok(name.to_owned())
}

/// The names of the attributes that a material and what is in it show.
pub fn attributes_shown(document: &Document, id: ObjectId) -> Result<Vec<String>, SceneError> {
    let (mut names, mut waiting) = (Vec::new(), vec![(id, 0)]);
    while let Some((id, depth)) = waiting.pop() {
        let query = document.query(id);
        if query.object.plugin == "mesh_attribute" {
            names.push(attribute_name(&query)?);
        }
        // Materials and textures that are nested deeper have been refused.
        if depth <= 2 * DEEPEST {
            waiting.extend(query.children().map(|(_, child)| (child, depth + 1)));
        }
    }
    Ok(names)
}

/// From the coordinates of the surface to those of the texture.
fn placed(query: &Query) -> Result<Affine2, SceneError> {
    if let Some(m) = query.transform("to_uv")? {
        let m = m.as_mat4();
        return Ok(Affine2::from_mat2_translation(
            Mat2::from_cols(m.x_axis.truncate().truncate(), m.y_axis.truncate().truncate()),
            Vec2::new(m.w_axis.x, m.w_axis.y),
        ));
    }
    // As old files have it.
    let number = |name, default| -> Result<f32, SceneError> {
        Ok(query.float(name)?.map_or(default, |x| x as f32))
    };
    let both = number("uvscale", 1.0)?;
    let scale = Vec2::new(number("uscale", both)?, number("vscale", both)?);
    let offset = Vec2::new(number("uoffset", 0.0)?, number("voffset", 0.0)?);
    Ok(Affine2::from_mat2_translation(Mat2::from_diagonal(scale), offset))
}

/// A texture within one that scales its values: old files have such.
fn scaled(document: &Document, query: &Query, depth: usize) -> Result<Texture, SceneError> {
    if depth > DEEPEST {
        return Err(query.error_at("", "textures are nested too deeply"));
    }
    let scale = query.float("scale")?.unwrap_or(1.0);
    if scale.is_nan() || scale.abs() > 1e6 {
        return Err(
            query.error_at("scale", format!("\"scale\" is {scale}, but at most 1e6 is allowed"))
        );
    }
    let nested = query.child("texture")?;
    let nested = nested.ok_or_else(|| query.error_at("", "needs one nested <texture>"))?;
    query.finish(&["texture"])?;
    let texture = read(document, nested, depth + 1)?;
    Ok(Texture { scale: texture.scale * scale as f32, ..texture })
}

fn bitmap(query: &Query) -> Result<Pattern, SceneError> {
    let path = query.file()?;
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
