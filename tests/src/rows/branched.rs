//! The rows of `reference/catalogue-mh.json`.

use aether_core::{Direction, Mat3, Scalar, Vec2, Vec3};

use super::Visitor;
use crate::catalogue::*;
use crate::checks::right;
use crate::reference::Inputs;

/// Visits the sampler that an entry is about, by its name.
pub(super) fn visit<R: Scalar, V: Visitor<R>>(entry: &Inputs, visitor: V) -> V::Output {
    match entry.row {
        0..=36 => line(entry, visitor),
        43..=46 | 50..=56 | 116..=117 => plane(entry, visitor),
        65..=77 | 81..=92 | 99 => direction(entry, visitor),
        _ => space(entry, visitor),
    }
}

fn unknown(entry: &Inputs) -> ! {
    panic!("the catalogue has no sampler {} in row {}", entry.name, entry.row)
}

fn line<R: Scalar, V: Visitor<R>>(entry: &Inputs, visitor: V) -> V::Output {
    let p = |name: &str| entry.scalar::<R>(name);
    match entry.name.as_str() {
        "tent" => visitor.visit(right(tent(p("r")))),
        "triangular" => visitor.visit(triangular(p("a"), p("b"), p("c"))),
        "student_2" => visitor.visit(student_2()),
        "student" => visitor.visit(right(student(p("nu")))),
        "laplace" => visitor.visit(right(laplace(p("b")))),
        "rational_quadratic" => visitor.visit(right(rational_quadratic(p("s"), p("d0"), p("d1")))),
        "cosine" => visitor.visit(cosine()),
        "parabola" => visitor.visit(parabola()),
        "square" => visitor.visit(square()),
        "fold" => visitor.visit(fold()),
        "cubic" => visitor.visit(cubic()),
        "sawtooth" => visitor.visit(sawtooth()),
        _ => unknown(entry),
    }
}

fn plane<R: Scalar, V: Visitor<R>>(entry: &Inputs, visitor: V) -> V::Output {
    let p = |name: &str| entry.scalar::<R>(name);
    match entry.name.as_str() {
        "concentric_disk" => visitor.visit(concentric_disk()),
        "annular_sector" => visitor.visit(right(annular_sector(p("a"), p("b"), p("p"), p("d")))),
        "bivariate_normal" => visitor.visit(right(bivariate_normal(p("l11"), p("l21"), p("l22")))),
        "ggx_slopes" => visitor.visit(right(ggx_slopes(p("alpha")))),
        "bilinear_quad" => {
            let corner = |x, y| Vec2::new(p(x), p(y));
            let (a, b) = (corner("ax", "ay"), corner("bx", "by"));
            visitor.visit(bilinear_quad(a, b, corner("cx", "cy"), corner("dx", "dy")))
        }
        "bilinear_patch" => {
            let corner = |name: &str| Vec3::from_array(entry.vector::<R>(name));
            let [a, b, c, d] = ["a", "b", "c", "d"].map(corner);
            visitor.visit(bilinear_patch(a, b, c, d))
        }
        "elliptical_grid" => visitor.visit(elliptical_grid()),
        "bilinear_density" => {
            let sampler = bilinear_density(p("w00"), p("w10"), p("w01"), p("w11"));
            visitor.visit(right(sampler))
        }
        "complex_square_xy" => visitor.visit(complex_square_xy()),
        "complex_square" => visitor.visit(complex_square()),
        "radial_flow" => visitor.visit(right(radial_flow(p("alpha"), p("beta")))),
        "pentagon" => visitor.visit(pentagon()),
        "affine_coupling" => visitor.visit(affine_coupling(p("s"), p("t"))),
        _ => unknown(entry),
    }
}

fn direction<R: Scalar, V: Visitor<R>>(entry: &Inputs, visitor: V) -> V::Output {
    let p = |name: &str| entry.scalar::<R>(name);
    let v = |name: &str| Vec3::from_array(entry.vector::<R>(name));
    let w = |name: &str| Direction::from_vec(v(name));
    match entry.name.as_str() {
        "equal_area_octahedral" => visitor.visit(equal_area_octahedral()),
        "visible_normals" => visitor.visit(right(visible_normals(p("alpha"), w("w")))),
        "reflected_ggx" => visitor.visit(right(reflected_ggx(p("alpha"), w("w")))),
        "refracted_ggx" => visitor.visit(right(refracted_ggx(p("alpha"), p("eta"), w("w")))),
        "cone" => visitor.visit(right(cone(p("m")))),
        "concentric_hemisphere" => visitor.visit(concentric_hemisphere()),
        "double_lune" => visitor.visit(right(double_lune(p("t")))),
        "von_mises_fisher" => visitor.visit(right(von_mises_fisher(p("kappa")))),
        "henyey_greenstein" => visitor.visit(right(henyey_greenstein(p("g")))),
        "von_mises_fisher_as_printed" => {
            visitor.visit(right(von_mises_fisher_as_printed(p("kappa"))))
        }
        "henyey_greenstein_as_printed" => {
            visitor.visit(right(henyey_greenstein_as_printed(p("g"))))
        }
        "rayleigh" => visitor.visit(rayleigh()),
        "transformed_cosine" => {
            visitor.visit(transformed_cosine(Mat3::from_cols(v("a"), v("b"), v("c"))))
        }
        "beckmann" => visitor.visit(right(beckmann(p("alpha")))),
        "ggx" => visitor.visit(right(ggx(p("alpha")))),
        "anisotropic_ggx" => visitor.visit(right(anisotropic_ggx(p("ax"), p("ay")))),
        "ashikhmin_shirley" => visitor.visit(right(ashikhmin_shirley(p("nu"), p("nv")))),
        "mixture" => visitor.visit(right(mixture(p("p"), p("n")))),
        "sheen" => visitor.visit(right(sheen(p("alpha")))),
        "zonal_window" => visitor.visit(right(zonal_window(p("z0"), p("z1"), p("p"), p("d")))),
        "perspective" => visitor.visit(right(perspective(p("t"), p("a")))),
        _ => unknown(entry),
    }
}

fn space<R: Scalar, V: Visitor<R>>(entry: &Inputs, visitor: V) -> V::Output {
    let p = |name: &str| entry.scalar::<R>(name);
    let v = |name: &str| Vec3::from_array(entry.vector::<R>(name));
    match entry.name.as_str() {
        "triangle" => visitor.visit(triangle(v("a"), v("b"), v("c"))),
        "triangle_heitz" => visitor.visit(triangle_heitz(v("a"), v("b"), v("c"))),
        "triangle_fold" => visitor.visit(triangle_fold(v("a"), v("b"), v("c"))),
        "ellipsoid" => visitor.visit(right(ellipsoid(p("s1"), p("s2"), p("s3")))),
        "torus" => visitor.visit(right(torus(p("large"), p("small")))),
        "shell" => visitor.visit(right(shell(p("a"), p("b")))),
        "tetrahedron" => visitor.visit(tetrahedron(v("a"), v("b"), v("c"), v("d"))),
        "helix" => visitor.visit(right(helix(p("r"), p("c"), p("T")))),
        "truncated_cone" => visitor.visit(right(truncated_cone(p("r0"), p("r1"), p("h")))),
        "onto_plane" => visitor.visit(onto_plane(v("o"), v("p0"), v("n"))),
        "sphere_light" => visitor.visit(right(sphere_light(p("m"), p("d"), p("r")))),
        "chained_frames" => visitor.visit(chained_frames()),
        "scattering_vertex" => {
            visitor.visit(right(scattering_vertex(v("o"), p("s"), p("d"), p("g"))))
        }
        "stick_breaking" => visitor.visit(stick_breaking()),
        "simplex" => visitor.visit(simplex()),
        "ordered" => visitor.visit(ordered()),
        "quaternion" => visitor.visit(quaternion()),
        "correlation_factor" => visitor.visit(correlation_factor()),
        _ => unknown(entry),
    }
}
