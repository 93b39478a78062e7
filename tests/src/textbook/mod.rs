//! Densities as textbooks and renderers print them, for comparison: no care for the last digits, and no
//! test of the support.
//!
//! Where several uniforms lead to one point, the form is that of the whole density. Two samplers have no usual
//! form, because no formula undoes them: `quintic`, whose inverse is a root of fifth degree with a logarithm, and
//! `planar_flow`, whose density is printed at the variable before the flow. The renderer's tables have none either: what
//! they hold is not a formula, and is rounded.

mod direction;
mod film;
mod line;
mod microfacets;
mod plane;
mod space;
mod surface;
mod tables;

use aether_core::{Real, Vec3};

use crate::registry::Which;

/// The density of a sampler with the parameters `p` at the coordinates `x`, if there is a usual form. Directions
/// among the parameters have length one.
pub fn textbook<R: Real>(which: Which, p: &[R], x: &[R]) -> Option<R> {
    match x.len() {
        1 => line::density(which, p, x[0]).or_else(|| tables::on_line(which, x[0])),
        2 => plane::density(which, p, x)
            .or_else(|| tables::on_square(which, x[0], x[1]))
            .or_else(|| film::density(which, p, x))
            .or_else(|| microfacets::slopes(which, p, x)),
        _ => direction::density(which, p, x)
            .or_else(|| tables::on_sphere(which, x))
            .or_else(|| film::camera(which, p, x))
            .or_else(|| microfacets::density(which, p, x))
            .or_else(|| surface::density(which, p, x))
            .or_else(|| space::density(which, p, x)),
    }
}

/// Three numbers of a list, from the place `first` on.
fn vector<R: Real>(list: &[R], first: usize) -> Vec3<R> {
    Vec3::new(list[first], list[first + 1], list[first + 2])
}

/// The density of a logistic variable.
fn logistic<R: Real>(z: R) -> R {
    let e = (-z).exp();
    let s = R::ONE + e;
    e / (s * s)
}

/// The phase function of Henyey and Greenstein.
fn henyey_greenstein<R: Real>(g: R, cosine: R) -> R {
    let d = R::ONE + g * g - R::of(2.0) * g * cosine;
    (R::ONE - g * g) / (R::of(4.0 * core::f64::consts::PI) * d * d.sqrt())
}

/// Free flight that ends before the distance `end`.
fn truncated_exponential<R: Real>(extinction: R, end: R, t: R) -> R {
    extinction * (-extinction * t).exp() / (R::ONE - (-extinction * end).exp())
}
