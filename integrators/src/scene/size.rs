//! Whether single precision has room for the densities of a scene of some size.

use super::model::Bounds;

/// The largest extent, or distance from zero, of scenes that are not warned of, and one over the smallest extent. The Cornell
/// box renders alike at all scales from 1e-8 to 1e8; from 1e9 and 1e-10 on samples of `bdpt` are no numbers, and at 1e11 the
/// weights of `path` do not add up to one.
const MOST: f32 = 1e9;

/// What is strange about the size of a scene, and what to do.
pub(super) fn strange_size(bounds: &Bounds) -> Option<String> {
    let extent = (bounds.max - bounds.min).max_element();
    let far = bounds.min.abs().max(bounds.max.abs()).max_element();
    // Without shapes there is no extent.
    if extent < 0.0 || (extent == 0.0 && far <= MOST) {
        return None;
    }
    let too = if far > MOST {
        "large"
    } else if extent < 1.0 / MOST {
        "small"
    } else {
        return None;
    };
    Some(format!(
        "the scene, which is {extent:.1e} wide, is too {too} for single precision, and the image may be wrong; scale it \
         to an extent between {:e} and {MOST:e}",
        1.0 / MOST
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;
    use std::path::Path;

    fn warnings(scale: &str) -> Vec<String> {
        let xml = format!(
            r#"<scene version="3.0.0"><sensor type="perspective"/>
            <shape type="cube"><transform name="to_world"><scale value="{scale}"/></transform></shape></scene>"#
        );
        let scene = Scene::from_str(&xml, Path::new(""), &[]).unwrap();
        scene.warnings.iter().map(|warning| warning.to_string()).collect()
    }

    #[test]
    fn sizes_that_single_precision_has_no_room_for_are_warned_of() {
        for scale in ["1", "4e8", "6e-10"] {
            assert!(warnings(scale).is_empty(), "{:?}", warnings(scale));
        }
        let large = warnings("1e11");
        assert!(
            large[0].starts_with(
                "scene.xml:1:1: <scene>: the scene, which is 2.0e11 wide, is too large"
            ),
            "{large:?}"
        );
        assert!(warnings("1e-11")[0].contains("too small"));
    }

    #[test]
    fn a_scene_without_shapes_has_no_size() {
        assert_eq!(strange_size(&Bounds::EMPTY), None);
    }
}
