//! Paths of a thousand vertices: nothing overflows, underflows or becomes 0/0.

use integrators::algorithm::Algorithm;
use integrators::bidirectional::Bidirectional;
use integrators::metropolis::Metropolis;
use integrators::scene::Scene;

use super::{assert_mean, camera, common, rendered, rendered_by, scene};

/// Walls and a ball that emit one and reflect `albedo`.
fn furnace(albedo: f64, depth: i32) -> Scene {
    let elements = format!(
        r#"<shape type="cube"><boolean name="flip_normals" value="true"/>
            <bsdf type="diffuse"><rgb name="reflectance" value="{albedo}"/></bsdf>
            <emitter type="area"><rgb name="radiance" value="1"/></emitter></shape>
        <shape type="sphere"><float name="radius" value="0.3"/>
            <bsdf type="diffuse"><rgb name="reflectance" value="{albedo}"/></bsdf>
            <emitter type="area"><rgb name="radiance" value="1"/></emitter></shape>"#
    );
    scene(&camera([0.2, -0.8, 0.1], [0.0, 0.5, -0.1], 60.0), 4, depth, &elements)
}

/// The radiance is the geometric sum over the bounces.
#[test]
fn a_furnace_a_thousand_edges_deep() {
    for (albedo, depth) in [(1.0, 1000), (0.999, 1000), (1.0, 40)] {
        let mut scene = furnace(albedo, depth);
        let film = rendered(&mut scene, 16, 1);
        let terms = f64::from(depth);
        let expected =
            if albedo == 1.0 { terms } else { (1.0 - f64::powf(albedo, terms)) / (1.0 - albedo) };
        assert_mean(&format!("albedo {albedo}, depth {depth}"), &film, expected);
    }
}

/// Five thousand connections a sample, each with weights over a hundred techniques.
#[test]
fn a_furnace_a_hundred_edges_deep_from_both_ends() {
    let scene = furnace(1.0, 100);
    let bidirectional = Algorithm::Bidirectional(Bidirectional::new(common::settings(&scene)));
    let film = rendered_by(bidirectional, &scene, 4, 1);
    assert_mean("100 edges from both ends", &film, 100.0);
}

/// A room with a lamp, of this half width.
fn lit_room(size: f64) -> Scene {
    let lamp = 0.5 * size;
    let elements = format!(
        r#"<shape type="cube"><transform name="to_world"><scale value="{size}"/></transform>
            <boolean name="flip_normals" value="true"/>
            <bsdf type="diffuse"><rgb name="reflectance" value="0.8"/></bsdf></shape>
        <shape type="sphere"><float name="radius" value="{lamp}"/>
            <bsdf type="diffuse"><rgb name="reflectance" value="0.5"/></bsdf>
            <emitter type="area"><rgb name="radiance" value="1"/></emitter></shape>"#
    );
    let [eye, target] = [[0.25, -0.875, 0.125], [0.0, 0.5, -0.125]].map(|p| p.map(|x| x * size));
    scene(&camera(eye, target, 60.0), 8, 30, &elements)
}

/// What a chain is distributed as is a product of all factors of a path, which by far leaves the range of single precision.
#[test]
fn chains_find_the_same_light_in_any_unit_of_length() {
    let image = |size: f64| {
        let scene = lit_room(size);
        let path = common::settings(&scene);
        let chains = Metropolis { candidates: Some(500), ..Metropolis::new(path) };
        rendered_by(Algorithm::Metropolis(chains), &scene, 32, 3).image()
    };
    let expected = image(1.0);
    let mean = expected.pixels().iter().flatten().sum::<f32>() / 192.0;
    assert!(mean > 0.5, "{mean}");
    for size in [2f64.powi(14), 2f64.powi(-14)] {
        // Powers of two round nothing, so that even the steps of chains are the same.
        for (a, b) in image(size).pixels().iter().flatten().zip(expected.pixels().iter().flatten())
        {
            assert!((a - b).abs() <= 1e-4 * mean, "{size}: {a}, expected {b}");
        }
    }
}
