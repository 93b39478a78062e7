//! No sample of the renderer's samplers has a density of zero, whatever the unit and the place.

use aether_core::prelude::*;
use aether_core::{Pcg32, UniformSource};
use integrators::samplers::*;

fn missed<const N: usize, S: Sampler<f32, Uniforms = [f32; N]>>(sampler: &S) -> usize {
    let mut uniforms = Pcg32::new(1, 2, 3);
    let missed = |_: &usize| {
        let u = std::array::from_fn(|_| UniformSource::<f32>::next(&mut uniforms));
        let (x, exists) = sampler.forward(u);
        let p = sampler.pdf(&x).value();
        exists && !(p > 0.0 && p < f32::INFINITY)
    };
    (0..20_000).filter(missed).count()
}

#[test]
fn points_of_lights_of_any_size_at_any_place() {
    for exponent in [-30, -20, -10, 0, 10, 20, 30] {
        let scale = 2f32.powi(exponent);
        for away in [0.0, 1.0, 1e3] {
            let v = |x: f32, y: f32, z: f32| Vec3::new(scale * x, scale * y, scale * z);
            let at = v(0.9 * away, -0.7 * away, away);
            let id = SurfaceId(1);
            let (a, b) = (v(0.5, 0.1, 0.2), v(-0.1, 0.3, 0.4));
            let found = [
                missed(&uniform_disk(at, a, b, id)),
                missed(&uniform_sphere_surface(at, 0.3 * scale, id)),
                missed(&uniform_triangle(at, at + a, at + b, id)),
                missed(&uniform_triangle(at, at + v(1.0, 0.0, 0.0), at + v(0.0, 1.0, 0.0), id)),
            ];
            assert_eq!(found, [0; 4], "scale 2^{exponent}, {away} away");
        }
    }
}

#[test]
fn points_of_the_film() {
    for x in [0.5, 17.5, 4095.5, 65_535.5] {
        let found = [
            missed(&film_box(x, x)),
            missed(&film_tent(x, x, 1.0, -1.0)),
            missed(&film_gaussian(x, x, 0.5, 1.0 - (-16f32).exp())),
        ];
        assert_eq!(found, [0; 3], "at {x}");
    }
}
