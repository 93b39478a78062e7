//! Lights that are tiny, huge, or lie in the plane of what they light: irradiance in closed form.

use std::f64::consts::PI;

use super::{assert_mean, camera, rendered, scene};

const ALBEDO: f64 = 0.5;

/// A white square in the plane z = 0 of half the width `half`, facing up.
fn receiver(half: f64) -> String {
    format!(
        r#"<shape type="rectangle"><transform name="to_world"><scale value="{half}"/></transform>
            <bsdf type="diffuse"><rgb name="reflectance" value="{ALBEDO}"/></bsdf></shape>"#
    )
}

fn light(kind: &str, to_world: &str, radiance: f64) -> String {
    format!(
        r#"<shape type="{kind}"><transform name="to_world">{to_world}</transform>
            <emitter type="area"><rgb name="radiance" value="{radiance}"/></emitter></shape>"#
    )
}

/// The radiance that the middle of the receiver reflects, compared with irradiance · albedo / π. Pixels see
/// a spot of 1e-5 about the middle.
fn assert_irradiance(what: &str, light: &str, irradiance: f64) {
    let camera = camera([1.0, -0.5, 0.4], [0.0; 3], 0.000_4);
    let mut scene = scene(&camera, 8, 2, &(receiver(1e-2) + light));
    let film = rendered(&mut scene, 4096, 1);
    assert_mean(what, &film, irradiance * ALBEDO / PI);
}

#[test]
fn spheres_of_any_size() {
    // A sphere that is wholly above the horizon: E = π L (r/d)² cos θ.
    for radius in [1e-6, 1e-4, 1e-2, 0.5, 0.9] {
        let radiance = 1.0 / (radius * radius);
        let to_world = format!(r#"<scale value="{radius}"/><translate x="0" y="0" z="1"/>"#);
        let what = format!("a sphere of radius {radius:e} at distance 1");
        assert_irradiance(&what, &light("sphere", &to_world, radiance), PI);
        let aside = format!(r#"<scale value="{radius}"/><translate x="-0.6" y="0" z="0.8"/>"#);
        if radius < 0.6 {
            assert_irradiance(&(what + ", aside"), &light("sphere", &aside, radiance), 0.8 * PI);
        }
    }
}

#[test]
fn disks_and_squares_of_any_size() {
    for half in [1e-6, 1e-3, 1.0, 1e3, 1e6] {
        let facing = format!(
            r#"<scale value="{half}"/><rotate x="1" angle="180"/><translate x="0" y="0" z="1"/>"#
        );
        // Disk: E = π L r² / (r² + d²).
        let radiance = (1.0 + half * half) / (half * half);
        let what = format!("a disk of radius {half:e} at distance 1");
        assert_irradiance(&what, &light("disk", &facing, radiance), PI);
        // Square: four quarters, each (1/2π) · 2 · a/√(1+a²) · atan(a/√(1+a²)).
        let a = half / (1.0 + half * half).sqrt();
        let factor = 4.0 / PI * a * a.atan();
        let what = format!("a square of half width {half:e} at distance 1");
        assert_irradiance(&what, &light("rectangle", &facing, 1.0 / factor), PI);
    }
}

#[test]
fn enclosing_lights() {
    let inwards = r#"<boolean name="flip_normals" value="true"/>"#;
    for radius in [2.0, 1e3, 1e6] {
        let sphere = light("sphere", &format!(r#"<scale value="{radius}"/>"#), 1.0);
        let sphere = sphere.replace("<emitter", &format!("{inwards}<emitter"));
        assert_irradiance(&format!("inside a sphere of radius {radius:e}"), &sphere, PI);
    }
}

#[test]
fn a_light_in_the_plane_of_the_receiver_gives_nothing() {
    let beside = r#"<scale value="1"/><translate x="2" y="0" z="0"/>"#;
    let camera = camera([1.0, -0.5, 0.4], [0.0; 3], 0.000_4);
    let lights = light("rectangle", beside, 1e6) + &light("disk", beside, 1e6);
    let mut scene = scene(&camera, 8, 3, &(receiver(1e-2) + &lights));
    let film = rendered(&mut scene, 64, 1);
    assert!(film.pixels().iter().all(|p| p.mean() == [0.0; 3]), "light from its own plane");
}

/// A vertical square light whose lower edge touches the plane of the receiver at distance `d`:
/// F = (atan(1/Y) - Y/√(X²+Y²) atan(1/√(X²+Y²))) / 2π for each half, with edges 1 along the plane.
#[test]
fn a_wall_that_begins_at_a_small_distance() {
    for d in [2e-5, 1e-4, 1e-2] {
        let wall = format!(
            r#"<translate x="0" y="1" z="0"/><scale value="0.5"/><scale x="2"/>
               <rotate x="1" angle="90"/><rotate z="1" angle="0"/><translate x="0" y="{d}" z="0"/>"#
        );
        // Upright, 2 wide and 1 high, facing -y towards the receiver's middle.
        let (x, y) = (1.0f64, d);
        let root = x.hypot(y);
        let factor = 2.0 * ((1.0 / y).atan() - y / root * (1.0 / root).atan()) / (2.0 * PI);
        assert_irradiance(
            &format!("a wall at distance {d:e}"),
            &light("rectangle", &wall, 1.0),
            PI * factor,
        );
    }
}

/// Between two plates 1e-6 apart, one of which shines: all that the other one sees is light.
#[test]
fn a_point_just_above_a_light() {
    let lamp = light("rectangle", r#"<scale value="1"/>"#, 1.0);
    for gap in [1e-2, 1e-4, 1e-6] {
        let plate = format!(
            r#"<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="180"/>
                <translate x="0" y="0" z="{gap}"/></transform>
                <bsdf type="diffuse"><rgb name="reflectance" value="{ALBEDO}"/></bsdf></shape>"#
        );
        let camera = camera([0.01, 0.02, 0.5 * gap], [0.01, 0.02, gap], 50.0);
        let mut scene = scene(&camera, 8, 2, &(lamp.clone() + &plate));
        let a = 1.0 / f64::hypot(1.0, gap);
        let irradiance = PI * 4.0 / PI * a * (1.0 / f64::hypot(1.0, gap)).atan();
        // A square of half width 1 at distance `gap`, seen from its middle, up to 1e-4 at the largest gap.
        let film = rendered(&mut scene, 1024, 1);
        assert_mean(&format!("{gap:e} above a light"), &film, irradiance * ALBEDO / PI);
    }
}
/// A long lens: pixels a few rounding errors wide lose nothing at their rims.
#[test]
fn a_long_lens_loses_no_light() {
    let lamp = light("rectangle", r#"<scale value="10"/>"#, 1.0);
    for fov in [40.0, 1.0, 1e-2, 1e-4] {
        let camera = camera([1.0, -0.5, 0.4], [0.3, 0.1, 0.0], fov);
        let film = rendered(&mut scene(&camera, 2, 1, &lamp), 4096, 1);
        for pixel in film.pixels() {
            assert!((pixel.mean()[0] - 1.0).abs() < 1e-5, "fov {fov}: {}", pixel.mean()[0]);
        }
    }
}
