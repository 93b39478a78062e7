//! Points of the film, and the directions in which a camera sees them.

use aether_core::{Direction, Frame, Real};
use core::f64::consts::TAU;

use super::vector;
use crate::registry::Which;

/// The density of a sampler of film points.
pub fn density<R: Real>(which: Which, p: &[R], x: &[R]) -> Option<R> {
    let density = match which {
        Which::FilmBox => R::ONE,
        Which::FilmRectangle => (p[2] * p[3]).recip(),
        Which::FilmTent => tent(x[0] - p[0], x[1] - p[1], p[2], p[3]),
        Which::FilmGaussian => gaussian(x[0] - p[0], x[1] - p[1], p[2], p[3]),
        Which::FilmNear => {
            let (dx, dy) = (x[0] - p[0], x[1] - p[1]);
            (R::of(TAU) * (p[3] / p[2]).ln() * (dx * dx + dy * dy)).recip()
        }
        _ => return None,
    };
    Some(density)
}

/// A quadrant of the tent filter.
fn tent<R: Real>(dx: R, dy: R, rx: R, ry: R) -> R {
    let one = R::ONE;
    R::of(4.0) * (one - dx / rx) * (one - dy / ry) / (rx * ry).abs()
}

/// The Gaussian filter within the radius that has this share of it.
fn gaussian<R: Real>(dx: R, dy: R, deviation: R, mass: R) -> R {
    let variance = deviation * deviation;
    (-(dx * dx + dy * dy) / (R::of(2.0) * variance)).exp() / (R::of(TAU) * variance * mass)
}

/// The density of directions of the registry's camera: that of the film point, per area of the film at distance one, over
/// the cube of the cosine.
pub fn camera<R: Real>(which: Which, p: &[R], x: &[R]) -> Option<R> {
    let c = R::of;
    let shift = match which {
        Which::CameraBox | Which::CameraTent | Which::CameraGaussian => [R::ZERO; 2],
        Which::CameraLens => [p[3] / p[2], p[4] / p[2]],
        _ => return None,
    };
    let axis = Direction::new(c(0.48), c(0.64), c(0.6));
    let w = Frame::around(axis).to_local(vector(x, 0));
    let dx = c(320.5) + shift[0] + w.x / w.z / p[2] - p[0];
    let dy = c(240.5) + shift[1] + w.y / w.z / p[2] - p[1];
    let film = match which {
        Which::CameraTent => tent(dx, dy, R::ONE, -R::ONE),
        Which::CameraGaussian => gaussian(dx, dy, c(0.5), c(0.9999998874648253)),
        _ => R::ONE,
    };
    Some(film / (p[2] * p[2] * w.z * w.z * w.z))
}
