//! Paths of a thousand vertices: nothing overflows, underflows or becomes 0/0.

use super::{assert_mean, camera, rendered, scene};

/// Inside walls that emit one and reflect `albedo`, the radiance is the geometric sum over the bounces.
#[test]
fn a_furnace_a_thousand_edges_deep() {
    for (albedo, depth) in [(1.0, 1000), (0.999, 1000), (1.0, 40)] {
        let elements = format!(
            r#"<shape type="cube"><boolean name="flip_normals" value="true"/>
                <bsdf type="diffuse"><rgb name="reflectance" value="{albedo}"/></bsdf>
                <emitter type="area"><rgb name="radiance" value="1"/></emitter></shape>
            <shape type="sphere"><float name="radius" value="0.3"/>
                <bsdf type="diffuse"><rgb name="reflectance" value="{albedo}"/></bsdf>
                <emitter type="area"><rgb name="radiance" value="1"/></emitter></shape>"#
        );
        let camera = camera([0.2, -0.8, 0.1], [0.0, 0.5, -0.1], 60.0);
        let mut scene = scene(&camera, 4, depth, &elements);
        let film = rendered(&mut scene, 16, 1);
        let terms = f64::from(depth);
        let expected =
            if albedo == 1.0 { terms } else { (1.0 - f64::powf(albedo, terms)) / (1.0 - albedo) };
        assert_mean(&format!("albedo {albedo}, depth {depth}"), &film, expected);
    }
}
