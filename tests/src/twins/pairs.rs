//! Which derived sampler each twin is compared with, and with which parameters.

use core::fmt::Debug;

use aether_core::prelude::{Direction, Vec3};
use aether_core::{DomainError, Sampler, Uniforms};

use super::{ByHand, direction, line, plane, space};
use crate::catalogue as derived;
use crate::points::FromCoordinates;

/// Something to be done with a derived sampler and its twin.
pub trait Visitor {
    /// Does it. The row of the catalogue names both.
    fn visit<S, H>(&mut self, row: u64, name: &'static str, derived: S, by_hand: H)
    where
        S: Sampler<f64>,
        S::Point: FromCoordinates<f64> + Copy + Debug,
        H: ByHand<Uniforms = S::Uniforms, Point = S::Point>;
}

/// A stream of numbers in [0, 1).
#[derive(Clone, Debug)]
pub struct Numbers(u64);

impl Numbers {
    /// The stream of a seed.
    pub fn new(seed: u64) -> Self {
        Numbers(seed)
    }

    /// The next number (the mixing function of Steele, Lea and Flood 2014, SplitMix).
    pub fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniforms of a sample.
    pub fn uniforms<U: Uniforms<f64>>(&mut self) -> U {
        U::from_fn(|_| self.number())
    }

    /// A point of a space, wherever the support may be.
    pub fn stray<P: FromCoordinates<f64>>(&mut self) -> P {
        let mut coordinates = [0.0; 8];
        coordinates.fill_with(|| 3.0 * self.number() - 1.5);
        P::made_of(&coordinates)
    }
}

/// Visits all pairs.
///
/// # Errors
/// None: all parameters lie in their domains.
pub fn visit_all(visitor: &mut impl Visitor) -> Result<(), DomainError> {
    visit_line(visitor)?;
    visit_plane(visitor)?;
    visit_directions(visitor)?;
    visit_space(visitor)
}

fn visit_line(v: &mut impl Visitor) -> Result<(), DomainError> {
    use line::*;
    v.visit(1, "affine", derived::affine(-0.5, 1.0), Affine { a: -0.5, b: 1.0 });
    v.visit(2, "power", derived::power(3.5), Power { k: 3.5 });
    v.visit(3, "exponential", derived::exponential(0.7), Exponential { s: 0.7 });
    let truncated = TruncatedExponential { s: 0.7, d: 1.2 };
    v.visit(4, "truncated exponential", derived::truncated_exponential(0.7, 1.2), truncated);
    v.visit(5, "linear", derived::linear(0.4, 1.7)?, Linear { a: 0.4, b: 1.7 });
    v.visit(6, "tent", derived::tent(1.1)?, Tent { r: 1.1 });
    v.visit(15, "Student's t", derived::student_2(), Student2 {});
    v.visit(17, "Laplace", derived::laplace(0.6)?, Laplace { b: 0.6 });
    v.visit(18, "Weibull", derived::weibull(0.8, 1.7), Weibull { l: 0.8, k: 1.7 });
    v.visit(33, "cosine of an angle", derived::cosine(), Cosine {});
    Ok(())
}

fn visit_plane(v: &mut impl Visitor) -> Result<(), DomainError> {
    use plane::*;
    v.visit(42, "disk", derived::polar_disk(1.2), PolarDisk { radius: 1.2 });
    v.visit(43, "concentric disk", derived::concentric_disk(), ConcentricDisk {});
    let sector = AnnularSector { a: 0.3, b: 1.2, p: 0.4, d: 2.0 };
    v.visit(44, "annular sector", derived::annular_sector(0.3, 1.2, 0.4, 2.0)?, sector);
    let normal = BivariateNormal { l11: 0.8, l21: 0.3, l22: 0.5 };
    v.visit(50, "normal of the plane", derived::bivariate_normal(0.8, 0.3, 0.5)?, normal);
    v.visit(51, "GGX slopes", derived::ggx_slopes(0.4)?, GgxSlopes { alpha: 0.4 });
    let bilinear = BilinearDensity { w00: 0.5, w10: 1.0, w01: 2.0, w11: 0.8 };
    v.visit(53, "bilinear", derived::bilinear_density(0.5, 1.0, 2.0, 0.8)?, bilinear);
    Ok(())
}

fn visit_directions(v: &mut impl Visitor) -> Result<(), DomainError> {
    use direction::*;
    let w = Direction::new(0.6, 0.2, 0.7);
    v.visit(60, "uniform sphere", derived::uniform_sphere(), UniformSphere {});
    v.visit(62, "uniform hemisphere", derived::uniform_hemisphere(), UniformHemisphere {});
    v.visit(63, "cosine hemisphere", derived::cosine_hemisphere(), CosineHemisphere {});
    v.visit(64, "power cosine", derived::power_cosine(20.0), PowerCosine { n: 20.0 });
    v.visit(65, "cone", derived::cone(0.3)?, Cone { m: 0.3 });
    let concentric = derived::concentric_hemisphere();
    v.visit(66, "concentric hemisphere", concentric, ConcentricHemisphere {});
    let octahedral = derived::equal_area_octahedral();
    v.visit(67, "equal-area octahedral", octahedral, EqualAreaOctahedral {});
    let window = ZonalWindow { z0: -0.2, z1: 0.7, p: 0.4, d: 2.0 };
    v.visit(68, "zonal window", derived::zonal_window(-0.2, 0.7, 0.4, 2.0)?, window);
    let von_mises = derived::von_mises_fisher(3.0)?;
    v.visit(74, "von Mises-Fisher", von_mises, VonMisesFisher { kappa: 3.0 });
    let henyey = derived::henyey_greenstein(0.6)?;
    v.visit(75, "Henyey-Greenstein", henyey, HenyeyGreenstein { g: 0.6 });
    v.visit(76, "Rayleigh", derived::rayleigh(), Rayleigh {});
    v.visit(81, "Beckmann", derived::beckmann(0.4)?, Beckmann { alpha: 0.4 });
    v.visit(82, "GGX", derived::ggx(0.4)?, Ggx { alpha: 0.4 });
    let anisotropic = derived::anisotropic_ggx(0.4, 0.2)?;
    v.visit(83, "anisotropic GGX", anisotropic, AnisotropicGgx { ax: 0.4, ay: 0.2 });
    let visible = derived::visible_normals(0.4, w)?;
    v.visit(86, "visible GGX normals", visible, VisibleNormals { alpha: 0.4, w });
    v.visit(89, "reflected GGX", derived::reflected_ggx(0.4, w)?, ReflectedGgx { alpha: 0.4, w });
    v.visit(91, "mixture", derived::mixture(0.3, 20.0)?, Mixture { p: 0.3, n: 20.0 });
    v.visit(92, "sheen", derived::sheen(0.4)?, Sheen { alpha: 0.4 });
    v.visit(99, "perspective", derived::perspective(0.5, 0.75)?, Perspective { t: 0.5, a: 0.75 });
    Ok(())
}

fn visit_space(v: &mut impl Visitor) -> Result<(), DomainError> {
    use space::*;
    let (a, b, c) = (Vec3::new(0.1, 0.2, 0.9), Vec3::new(1.3, 0.0, 0.4), Vec3::new(0.2, 1.1, 0.3));
    let d = Vec3::new(0.0, -0.2, -0.7);
    v.visit(47, "triangle", derived::triangle(a, b, c), Triangle { a, b, c });
    let sphere = SphereSurface { centre: a, radius: 0.7 };
    v.visit(93, "sphere surface", derived::sphere_surface(a, 0.7), sphere);
    v.visit(
        98,
        "sphere light",
        derived::sphere_light(0.05, 2.0, 0.8)?,
        SphereLight { m: 0.05, d: 2.0, r: 0.8 },
    );
    v.visit(103, "shell", derived::shell(0.4, 1.2)?, Shell { a: 0.4, b: 1.2 });
    v.visit(104, "tetrahedron", derived::tetrahedron(a, b, c, d), Tetrahedron { a, b, c, d });
    Ok(())
}
