//! Lenses of all sizes, in focus at any distance: the blurred edge of a lamp has a closed form.

use std::f64::consts::PI;

use super::{assert_mean, camera, rendered, scene_through};

/// The share of a disk of radius one that lies to the right of the line x = -s.
fn share(s: f64) -> f64 {
    let s = s.clamp(-1.0, 1.0);
    0.5 + (s * (1.0 - s * s).sqrt() + s.asin()) / PI
}

/// Looks through a lens of radius `r` in focus at distance `f`, along its axis, at the edge of a lamp at distance `d`: from
/// a point of the lens at x, the ray meets the lamp's plane at x (1 - d / f).
fn edge(r: f64, d: f64, f: f64, s: f64, seed: u64) {
    let blur = r * (1.0 - d / f).abs();
    let (size, edge) = (20.0 * blur, -s * blur);
    let lens = format!(
        r#"{}<float name="aperture_radius" value="{r}"/><float name="focus_distance" value="{f}"/>"#,
        camera([0.0, 0.0, d], [0.0, 0.0, 0.0], 1e-3 * (blur / d).min(1.0))
    );
    let lamp = format!(
        r#"<shape type="rectangle"><transform name="to_world"><scale value="{size}"/>
            <translate x="{}"/></transform><emitter type="area"/></shape>"#,
        edge + size
    );
    let film = rendered(&mut scene_through("thinlens", &lens, 4, 1, &lamp), 2000, seed);
    assert_mean(&format!("radius {r}, lamp at {d}, focus at {f}"), &film, share(s));
}

#[test]
fn the_edge_of_a_lamp_is_blurred_as_it_should_be() {
    let mut seed = 0;
    for (r, d, f) in [
        (1.0, 10.0, 20.0),
        (1e-5, 1.0, 2.0),
        (1e-4, 1.0, 1e-6),
        (1e4, 1.0, 1e3),
        (1e4, 1e5, 1e2),
        (1.0, 10.0, 1e12),
        (1e-3, 1e-2, 1e-2 * (1.0 + 1e-2)),
        (0.1, 1e3, 1.0),
        (1e4, 1e5, 1.0),
        (1.0, 10.0, 1e-4),
    ] {
        for s in [0.4, -0.7] {
            seed += 1;
            edge(r, d, f, s, seed);
        }
    }
}

/// What is in focus is seen as through a pinhole, whatever the size of the lens: all of the lamp.
#[test]
fn what_is_in_focus_is_sharp() {
    for (seed, r) in (1..).zip([1e-20, 1e-6, 1e-2, 1.0, 10.0]) {
        let lens = format!(
            r#"{}<float name="aperture_radius" value="{r}"/><float name="focus_distance" value="5"/>"#,
            camera([0.0, 0.0, 5.0], [0.0, 0.0, 0.0], 20.0)
        );
        // As large as the image.
        let half = 5.0 * 10f64.to_radians().tan();
        let lamp = format!(
            r#"<shape type="rectangle"><transform name="to_world"><scale value="{}"/></transform>
                <emitter type="area"/></shape>"#,
            half * (1.0 + 1e-4)
        );
        let film = rendered(&mut scene_through("thinlens", &lens, 4, 1, &lamp), 500, seed);
        assert_mean(&format!("radius {r}"), &film, 1.0);
    }
}
