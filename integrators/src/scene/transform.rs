//! The `<transform>` element.

use glam::{DMat4, DVec3};
use roxmltree::Node;

use super::error::{Place, SceneError};
use super::values;
use super::xml::{Attributes, Context, Reader, attribute};

impl Reader {
    /// The operations composed: the first is applied first.
    pub(super) fn transform(&mut self, context: &Context, node: Node) -> Result<DMat4, SceneError> {
        let mut total = DMat4::IDENTITY;
        for child in node.children().filter(Node::is_element) {
            let place = context.place(child);
            if child.children().any(|c| c.is_element()) {
                return Err(place.error("this element cannot have children"));
            }
            let step = self.transform_step(child, &place)?;
            total = step * total;
            if !total.is_finite() {
                return Err(place.error("the transform overflows"));
            }
        }
        Ok(total)
    }

    fn transform_step(&mut self, node: Node, place: &Place) -> Result<DMat4, SceneError> {
        const AXES: [&str; 4] = ["value", "x", "y", "z"];
        let step = match node.tag_name().name() {
            "translate" => {
                let a = self.attributes(place, node, &[], &AXES)?;
                axes(&a, Some(0.0)).map(DMat4::from_translation)
            }
            "scale" => {
                let a = self.attributes(place, node, &[], &AXES)?;
                axes(&a, Some(1.0)).map(DMat4::from_scale)
            }
            "rotate" => {
                let a = self.attributes(place, node, &["angle"], &AXES)?;
                let axis = axes(&a, Some(0.0));
                axis.and_then(|axis| values::rotate(axis, values::number(&a[0].1)?))
            }
            "matrix" => {
                let a = self.attributes(place, node, &["value"], &[])?;
                values::matrix(&a[0].1)
            }
            "lookat" | "lookAt" => {
                let a = self.attributes(place, node, &["origin", "target"], &["up"])?;
                look_at(&a)
            }
            _ => Err("not supported inside <transform>; supported: translate, rotate, scale, \
                      matrix, lookat"
                .to_owned()),
        };
        step.map_err(|e| place.error(e))
    }
}

/// A vector from `value` or from `x`, `y`, `z`; absent components take the default, if any.
pub fn axes(attributes: &Attributes, default: Option<f64>) -> Result<DVec3, String> {
    let parts = ["x", "y", "z"].map(|axis| attribute(attributes, axis));
    if let Some(value) = attribute(attributes, "value") {
        if parts.iter().any(Option::is_some) {
            return Err("\"value\" and \"x\", \"y\", \"z\" exclude each other".to_owned());
        }
        return values::vector(value);
    }
    let component = |part: Option<&str>| match part {
        Some(text) => values::number(text),
        None => {
            default.ok_or_else(|| "\"x\", \"y\" and \"z\", or \"value\", are needed".to_owned())
        }
    };
    Ok(DVec3::new(component(parts[0])?, component(parts[1])?, component(parts[2])?))
}

fn look_at(attributes: &Attributes) -> Result<DMat4, String> {
    let point = |name: &str| attribute(attributes, name).map(values::vector).transpose();
    let origin = point("origin")?.unwrap_or_default();
    let target = point("target")?.unwrap_or_default();
    let up = point("up")?.filter(|up| *up != DVec3::ZERO);
    // Without an up vector any perpendicular one will do; this is the one that Mitsuba takes.
    let up = up.unwrap_or_else(|| (target - origin).normalize_or_zero().any_orthonormal_pair().0);
    values::look_at(origin, target, up)
}
