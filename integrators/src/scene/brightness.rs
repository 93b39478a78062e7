//! How bright images of a scene are, roughly.

use std::f64::consts::PI;

use glam::Vec3;

use super::Scene;

/// The largest and smallest exponent of a power of two that is told.
const MOST: i32 = 400;

impl Scene {
    /// Of how bright images are, the power of two: halfway, on a logarithmic scale, between the brightest light as the
    /// camera sees it and what surfaces in the scene would reflect if they shared all light. Where lamps are small these are far
    /// apart, and pixels lie between them. With all lights brighter by a power of two it is larger by that; zero without light.
    pub fn brightness_exponent(&self) -> i32 {
        let (_, radius) = self.bounding_sphere();
        let cross_section = PI * f64::from(radius).powi(2);
        let sum = |colour: Vec3| colour.to_array().map(f64::from).iter().sum::<f64>();
        // What is seen of each, and its power.
        let surfaces = self.emitters.iter().map(|emitter| {
            let radiance = sum(emitter.radiance);
            (radiance, PI * f64::from(emitter.area) * radiance)
        });
        let sky = self.sky.iter().map(|sky| {
            let radiance = sum(sky.mean());
            (radiance, 4.0 * PI * cross_section * radiance)
        });
        // Points and parallel light have no radiance: what matters is what they do to surfaces.
        let from_afar = |power: f64| (power / cross_section, power);
        let bulbs = self.bulbs.iter().map(|bulb| from_afar(sum(bulb.power())));
        let distant =
            self.distant.iter().map(|light| from_afar(cross_section * sum(light.irradiance)));
        let (mut brightest, mut power) = (0.0f64, 0.0);
        for (seen, emitted) in surfaces.chain(sky).chain(bulbs).chain(distant) {
            brightest = brightest.max(seen);
            power += emitted;
        }
        let exponents = [brightest, power / cross_section].map(exponent);
        match exponents {
            [Some(bright), Some(dim)] => (bright + dim).div_euclid(2).clamp(-MOST, MOST),
            [bright, dim] => bright.or(dim).unwrap_or(0).clamp(-MOST, MOST),
        }
    }
}

/// The power of two that is not larger than a positive number, by its bits, so that it is the same everywhere.
fn exponent(number: f64) -> Option<i32> {
    number.is_normal().then(|| (number.to_bits() >> 52 & 0x7ff) as i32 - 1023)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exponent_of(lights: &str) -> i32 {
        let xml = format!(
            r#"<scene version="3.0.0"><sensor type="perspective"/>{lights}
            <shape type="rectangle"><bsdf type="diffuse"/></shape></scene>"#
        );
        Scene::from_str(&xml, std::path::Path::new("."), &[]).unwrap().brightness_exponent()
    }

    #[test]
    fn of_brighter_lights_it_is_larger_by_as_much() {
        let lights: [fn(f64) -> String; 4] = [
            |factor| {
                let radiance = 3.0 * factor;
                format!(
                    r#"<shape type="sphere"><emitter type="area"><rgb name="radiance" value="{radiance:e}"/></emitter></shape>"#
                )
            },
            |factor| {
                let radiance = 0.7 * factor;
                format!(
                    r#"<emitter type="constant"><rgb name="radiance" value="{radiance:e}"/></emitter>"#
                )
            },
            |factor| {
                let intensity = 12.0 * factor;
                format!(
                    r#"<emitter type="point"><rgb name="intensity" value="{intensity:e}"/></emitter>"#
                )
            },
            |factor| {
                let irradiance = 1.1 * factor;
                format!(
                    r#"<emitter type="directional"><rgb name="irradiance" value="{irradiance:e}"/></emitter>"#
                )
            },
        ];
        for light in lights {
            let usual = exponent_of(&light(1.0));
            assert!((-8..8).contains(&usual), "{usual} of {}", light(1.0));
            for power in [-100, -60, -1, 1, 30, 50] {
                assert_eq!(exponent_of(&light(2f64.powi(power))), usual + power, "{power}");
            }
        }
    }

    #[test]
    fn without_light_it_is_zero() {
        assert_eq!(exponent_of(""), 0);
    }
}
