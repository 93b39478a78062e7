//! What files of versions before 2 call otherwise, as Mitsuba 3 reads them.

use glam::{DMat4, DVec3};

use super::document::{Object, Property, Value};

/// Brings an object of an old file up to date. Names are in the new style already.
pub fn upgrade(object: &mut Object) {
    if object.tag == "bsdf" && object.plugin == "diffuse" {
        let old = object.properties.iter_mut().find(|p| p.name == "diffuse_reflectance");
        if let Some(property) = old {
            property.name = "reflectance".to_owned();
        }
    }
    if object.tag == "texture" {
        place_texture(object);
    }
}

/// Scales and offsets of texture coordinates are a transform today.
fn place_texture(object: &mut Object) {
    let mut take = |name: &str, default: f64| {
        let at = object.properties.iter().position(|p| p.name == name)?;
        match object.properties[at].value {
            Value::Float(x) => Some((x, Some(object.properties.remove(at).place))),
            Value::Integer(x) => Some((x as f64, Some(object.properties.remove(at).place))),
            // Of the wrong type: nobody will know it.
            _ => Some((default, None)),
        }
    };
    let mut found = |name, default| take(name, default).unwrap_or((default, None));
    let both = found("uvscale", 1.0);
    let [u, v] = ["uscale", "vscale"].map(|name| found(name, both.0));
    let [x, y] = ["uoffset", "voffset"].map(|name| found(name, 0.0));
    let found = [both, u, v, x, y];
    let Some(place) = found.iter().find_map(|(_, place)| place.clone()) else { return };
    let [_, u, v, x, y] = found.map(|(value, _)| value);
    let to_uv =
        DMat4::from_translation(DVec3::new(x, y, 0.0)) * DMat4::from_scale(DVec3::new(u, v, 1.0));
    object.properties.push(Property {
        name: "to_uv".to_owned(),
        value: Value::Transform(to_uv),
        place,
    });
}
