//! Surfaces that are seen, or lit, along themselves: radiance in closed form.

use std::f64::consts::PI;

use super::{assert_mean, camera, rendered, scene};

const ALBEDO: f64 = 0.5;
/// Sines of the angle between a direction and a surface.
const SINES: [f64; 6] = [0.3, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6];

/// A camera that sees a spot in the middle of the plane z = 0, in a direction with this sine to it.
fn along(sine: f64) -> String {
    let origin = [-(1.0 - sine * sine).sqrt(), 0.0, sine];
    // Rounding of the position must not move what is seen.
    camera(origin, [0.0; 3], 0.1 * sine)
}

fn floor(bsdf: &str) -> String {
    format!(r#"<shape type="rectangle">{bsdf}</shape>"#)
}

fn diffuse() -> String {
    floor(&format!(r#"<bsdf type="diffuse"><rgb name="reflectance" value="{ALBEDO}"/></bsdf>"#))
}

/// Parallel light of irradiance 1 across its direction: ALBEDO / π times the sine, exactly.
#[test]
fn light_that_grazes_a_wall() {
    for sine in SINES {
        let light = format!(
            r#"<emitter type="directional"><vector name="direction" x="{}" y="0" z="{}"/>
                <rgb name="irradiance" value="{}"/></emitter>"#,
            (1.0 - sine * sine).sqrt(),
            -sine,
            1.0 / sine
        );
        let mut scene =
            scene(&camera([0.3, -0.5, 0.4], [0.0; 3], 1.0), 4, 2, &(diffuse() + &light));
        let film = rendered(&mut scene, 4, 1);
        assert_mean(&format!("light with a sine of {sine:e}"), &film, ALBEDO / PI);
    }
}

/// A matt wall is as bright from everywhere.
#[test]
fn a_wall_that_is_seen_along_itself() {
    let light = r#"<emitter type="directional"><vector name="direction" x="0.6" y="0" z="-0.8"/>
        <rgb name="irradiance" value="1"/></emitter>"#;
    for sine in SINES {
        let mut scene = scene(&along(sine), 4, 2, &(diffuse() + light));
        let film = rendered(&mut scene, 4, 1);
        assert_mean(&format!("seen with a sine of {sine:e}"), &film, 0.8 * ALBEDO / PI);
    }
}

/// What glass of the index 1.5 reflects of natural light.
fn fresnel(sine: f64) -> f64 {
    let (n, i) = (1.5, sine);
    let t = (1.0 - (1.0 - i * i) / (n * n)).sqrt();
    let across = ((i - n * t) / (i + n * t)).powi(2);
    let along = ((n * i - t) / (n * i + t)).powi(2);
    0.5 * (across + along)
}

/// Glass seen along itself is a mirror: of a light that begins at its plane it shows what Fresnel's formula says, and
/// what goes through meets nothing.
#[test]
fn glass_that_is_seen_along_itself() {
    let glass = floor(r#"<bsdf type="dielectric"><float name="int_ior" value="1.5"/></bsdf>"#);
    let light = r#"<shape type="rectangle"><transform name="to_world"><rotate y="1" angle="-90"/>
        <translate x="1" y="0" z="1"/></transform>
        <emitter type="area"><rgb name="radiance" value="1"/></emitter></shape>"#;
    for sine in SINES {
        let mut scene = scene(&along(sine), 16, 2, &(glass.clone() + light));
        let film = rendered(&mut scene, 1024, 1);
        assert_mean(&format!("glass with a sine of {sine:e}"), &film, fresnel(sine));
    }
}
