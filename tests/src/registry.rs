//! Every sampler of the catalogue and of the renderer, once, with the parameters that it is tried with.
//!
//! To add one, add a line to the table: an item of the language by its type, a composition by an
//! expression of its parameters `p(0)`, `p(1)`, … and the values to try.

use aether_core::legal::{Parameter, ParameterKind};
use aether_core::prelude::*;
use aether_core::tables::cells;
use aether_core::{DomainError, Legal, Real, Sampler, Scalar};
use integrators::daylight;
use integrators::samplers as renderer;
use integrators::scattering::facets;

use crate::catalogue::*;
use crate::points::FromCoordinates;
use crate::precise::exactly;
use crate::reference::{Inputs, Reference};

/// Something to be done with a sampler of any space.
pub trait Visitor<R: Scalar> {
    /// What comes out.
    type Output;
    /// Does it.
    fn visit<S: Sampler<R>>(self, sampler: S) -> Self::Output
    where
        S::Point: FromCoordinates<R>;
}

/// A sampler and what is known of its parameters, without their precision.
#[derive(Clone, Debug)]
pub struct Item {
    /// Which one.
    pub which: Which,
    /// Its name: in the catalogue, that of the reference data.
    pub name: &'static str,
    /// The row of the catalogue; 0 for what the renderer has.
    pub row: u64,
    /// Its parameters, if they are an item's; none are known of a composition.
    pub parameters: &'static [Parameter],
    /// Parameters to try, as lists of numbers.
    pub sets: Vec<Vec<f64>>,
    /// How many preimages a point has at most; 16 for a composition.
    pub preimages: usize,
}

impl Item {
    /// Visits the sampler with these parameters.
    ///
    /// # Errors
    /// If they are not in their domain.
    pub fn visit<R: Scalar, V: Visitor<R>>(
        &self,
        numbers: &[f64],
        visitor: V,
    ) -> Result<V::Output, DomainError> {
        visit(self.which, numbers, visitor)
    }
}

/// Numbers of these parameters, rounded to the precision; directions are made unit vectors there.
pub fn rounded<R: Real>(parameters: &[Parameter], numbers: &[f64]) -> Vec<R> {
    let mut rounded: Vec<R> = numbers.iter().map(|x| exactly(*x)).collect();
    let mut first = 0;
    for parameter in parameters {
        let n = parameter.kind.numbers();
        if parameter.kind == ParameterKind::Direction
            && let Some([x, y, z]) = rounded.get_mut(first..first + n)
        {
            [*x, *y, *z] = Direction::new(*x, *y, *z).to_array();
        }
        first += n;
    }
    rounded
}

/// An item with these parameters.
fn make<S: Legal>(numbers: &[f64]) -> Result<S, DomainError> {
    S::from_parameters(&rounded::<S::Real>(S::PARAMETERS, numbers))
}

macro_rules! registry {
    (
        catalogue { $($row:literal $name:literal $which:ident: $item:ty;)* }
        composed { $($line:literal $made:literal $made_of:ident: |$q:ident| $composition:expr;)* }
        more { $($number:literal $other:literal $more:ident: $type:ty, $parameters:expr;)* }
        tables { $($place:literal $table:literal $tabulated:ident: $variable:expr;)* }
        renderer { $($part:literal $here:ident: |$p:ident| $sampler:expr, $sets:expr;)* }
    ) => {
        /// Which sampler.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[allow(missing_docs)]
        pub enum Which { $($which,)* $($made_of,)* $($more,)* $($tabulated,)* $($here,)* }

        /// All items.
        pub fn items() -> Vec<Item> {
            type R = f64;
            let tried = [Reference::load(), Reference::load_branched()];
            vec![
                $(Item {
                    which: Which::$which,
                    name: $name,
                    row: $row,
                    parameters: <$item>::PARAMETERS,
                    sets: sets(&tried, $row, $name),
                    preimages: <$item>::DERIVATION.preimages,
                },)*
                $(Item {
                    which: Which::$made_of,
                    name: $made,
                    row: $line,
                    parameters: &[],
                    sets: sets(&tried, $line, $made),
                    preimages: 16,
                },)*
                $(Item {
                    which: Which::$more,
                    name: $other,
                    row: $number,
                    parameters: <$type>::PARAMETERS,
                    sets: $parameters.iter().map(|s| s.to_vec()).collect(),
                    preimages: <$type>::DERIVATION.preimages,
                },)*
                $(Item {
                    which: Which::$tabulated,
                    name: $table,
                    row: $place,
                    parameters: &[],
                    sets: vec![vec![]],
                    preimages: 16,
                },)*
                $(Item {
                    which: Which::$here,
                    name: concat!("renderer: ", $part),
                    row: 0,
                    parameters: &[],
                    sets: $sets.iter().map(|s| s.to_vec()).collect(),
                    preimages: 16,
                },)*
            ]
        }

        /// The item that an entry of the reference data is about.
        ///
        /// # Panics
        /// If there is none.
        pub fn item_of(inputs: &Inputs) -> Which {
            match (inputs.row, inputs.name.as_str()) {
                $(($row, $name) => Which::$which,)*
                $(($line, $made) => Which::$made_of,)*
                _ => panic!("the catalogue has no sampler {} in row {}", inputs.name, inputs.row),
            }
        }

        /// Visits a sampler with these parameters.
        ///
        /// # Errors
        /// If they are not in their domain.
        pub fn visit<R: Scalar, V: Visitor<R>>(
            which: Which,
            numbers: &[f64],
            visitor: V,
        ) -> Result<V::Output, DomainError> {
            Ok(match which {
                $(Which::$which => visitor.visit(make::<$item>(numbers)?),)*
                $(Which::$more => visitor.visit(make::<$type>(numbers)?),)*
                $(Which::$made_of => {
                    let $q = |i: usize| exactly::<R>(numbers[i]);
                    visitor.visit($composition)
                })*
                $(Which::$tabulated => visitor.visit($variable),)*
                $(Which::$here => {
                    #[allow(unused_variables)]
                    let $p = |i: usize| exactly::<R>(numbers[i]);
                    visitor.visit($sampler)
                })*
            })
        }
    };
}

/// The parameters that the reference data has of a row.
fn sets(tried: &[Reference], row: u64, name: &str) -> Vec<Vec<f64>> {
    let mut sets: Vec<Vec<f64>> = Vec::new();
    let points = tried.iter().flat_map(|r| &r.points).map(|p| &p.inputs);
    for inputs in points.filter(|i| i.row == row && i.name == name) {
        let numbers = inputs.numbers();
        if !sets.contains(&numbers) {
            sets.push(numbers);
        }
    }
    sets
}

/// Three numbers as a vector.
fn vector<R: Scalar>(p: impl Fn(usize) -> R, first: usize) -> Vec3<R> {
    Vec3::new(p(first), p(first + 1), p(first + 2))
}

/// A viewer above the surface, at this height.
fn view<R: Scalar>(z: R) -> Direction<R> {
    Direction::new((R::ONE - z * z).sqrt(), R::ZERO, z)
}

/// A film sample as the direction that a camera looking along (0.48, 0.64, 0.6) sees there.
fn camera<R: Scalar, S: Sampler<R, Point = Vec2<R>>>(
    film: S,
    scale: R,
) -> impl Sampler<R, Point = Direction<R>> {
    behind_lens(film, scale, Vec2::new(R::ZERO, R::ZERO))
}

/// The same from a point of a lens, at `point` over the distance of the plane in focus.
fn behind_lens<R: Scalar, S: Sampler<R, Point = Vec2<R>>>(
    film: S,
    scale: R,
    point: Vec2<R>,
) -> impl Sampler<R, Point = Direction<R>> {
    let half = R::of(0.5);
    let axis = Direction::new(R::of(0.48), R::of(0.64), R::of(0.6));
    let centre =
        Vec2::new(R::of(320.0) + half + point.x / scale, R::of(240.0) + half + point.y / scale);
    film.then(renderer::pinhole(centre, Vec2::new(scale, scale)))
        .then(renderer::rotate(Frame::around(axis)))
}

/// The unit square as one of film points about a pixel.
fn square<R: Scalar>(x: R, y: R, radius: R) -> cells::StretchedSquare<R> {
    cells::stretched_square(Vec2::new(x - radius, y - radius), Vec2::new(x + radius, y + radius))
}

/// Corners, from an ordinary triangle to a sliver and one far away.
const TRIANGLES: [[f64; 9]; 5] = [
    [0.0, 0.0, 1.0, 2.0, 0.0, 1.5, 0.25, 1.75, 0.25],
    [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.5, 1e-9, 0.0],
    [1e6, 1e6, 1e6, 1e6 + 1.0, 1e6, 1e6, 1e6, 1e6 + 1.0, 1e6 + 1.0],
    [0.0, 0.0, 0.0, 1e-6, 0.0, 0.0, 0.0, 1e-6, 1e-6],
    [0.0, 0.0, 0.0, 1e6, 0.0, 0.0, 0.0, 1e6, 1e6],
];

registry! {
    catalogue {
        1 "affine" Affine: Affine<R>;
        2 "power" Power: Power<R>;
        3 "exponential" Exponential: Exponential<R>;
        4 "truncated exponential" TruncatedExponential: TruncatedExponential<R>;
        5 "linear" Linear: Linear<R>;
        18 "Weibull" Weibull: Weibull<R>;
        19 "Gumbel" Gumbel: Gumbel<R>;
        23 "softplus of logistic" SoftplusLogistic: SoftplusLogistic;
        42 "disk polar" PolarDisk: PolarDisk<R>;
        57 "affine of two logistics" AffineLogistics: AffineLogistics<R>;
        60 "uniform sphere" UniformSphere: UniformSphere;
        61 "equirectangular" Equirectangular: Equirectangular;
        62 "uniform hemisphere" UniformHemisphere: UniformHemisphere;
        63 "cosine hemisphere" CosineHemisphere: CosineHemisphere;
        64 "power cosine" PowerCosine: PowerCosine<R>;
        93 "sphere surface" SphereSurface: SphereSurface<R>;
        107 "height field" HeightField: HeightField<R>;
        6 "tent" Tent: Tent<R>;
        7 "triangular" Triangular: Triangular<R>;
        15 "student_2" Student2: Student2;
        16 "student" Student: Student<R>;
        17 "laplace" Laplace: Laplace<R>;
        32 "rational_quadratic" RationalQuadratic: RationalQuadratic<R>;
        33 "cosine" Cosine: Cosine;
        34 "parabola" Parabola: Parabola;
        34 "square" Square: Square;
        34 "fold" Fold: Fold;
        35 "sawtooth" Sawtooth: Sawtooth<R>;
        36 "cubic" Cubic: Cubic;
        46 "elliptical_grid" EllipticalGrid: EllipticalGrid;
        53 "bilinear_density" BilinearDensity: BilinearDensity<R>;
        56 "complex_square_xy" ComplexSquareXy: ComplexSquareXy;
        52 "pentagon" Pentagon: Pentagon;
        52 "regular_polygon" RegularPolygon: RegularPolygon<R>;
        43 "concentric_disk" ConcentricDisk: ConcentricDisk;
        44 "annular_sector" AnnularSector: AnnularSector<R>;
        50 "bivariate_normal" BivariateNormal: BivariateNormal<R>;
        51 "ggx_slopes" GgxSlopes: GgxSlopes<R>;
        54 "bilinear_quad" BilinearQuad: BilinearQuad<R>;
        56 "complex_square" ComplexSquare: ComplexSquare;
        116 "radial_flow" RadialFlow: RadialFlow<R>;
        117 "affine_coupling" AffineCoupling: AffineCoupling<R>;
        67 "equal_area_octahedral" EqualAreaOctahedral: EqualAreaOctahedral;
        86 "visible_normals" VisibleNormals: VisibleNormals<R>;
        86 "anisotropic_normals" BrushedNormals: AnisotropicNormals<R>;
        85 "anisotropic_normals_as_printed" BrushedNormalsAsPrinted: AnisotropicNormalsAsPrinted<R>;
        89 "reflected_ggx" ReflectedGgx: ReflectedGgx<R>;
        90 "refracted_ggx" RefractedGgx: RefractedGgx<R>;
        76 "rayleigh" Rayleigh: Rayleigh;
        68 "zonal_window" ZonalWindow: ZonalWindow<R>;
        65 "cone" Cone: Cone<R>;
        66 "concentric_hemisphere" ConcentricHemisphere: ConcentricHemisphere;
        69 "double_lune" DoubleLune: DoubleLune<R>;
        74 "von_mises_fisher" VonMisesFisher: VonMisesFisher<R>;
        74 "von_mises_fisher_as_printed" VonMisesFisherAsPrinted: VonMisesFisherAsPrinted<R>;
        75 "henyey_greenstein" HenyeyGreenstein: HenyeyGreenstein<R>;
        75 "henyey_greenstein_as_printed" HenyeyGreensteinAsPrinted: HenyeyGreensteinAsPrinted<R>;
        77 "transformed_cosine" TransformedCosine: TransformedCosine<R>;
        81 "beckmann" Beckmann: Beckmann<R>;
        82 "ggx" Ggx: Ggx<R>;
        83 "anisotropic_ggx" AnisotropicGgx: AnisotropicGgx<R>;
        84 "ashikhmin_shirley" AshikhminShirley: AshikhminShirley<R>;
        91 "mixture" Mixture: Mixture<R>;
        92 "sheen" Sheen: Sheen<R>;
        99 "perspective" Perspective: Perspective<R>;
        54 "bilinear_patch" BilinearPatch: BilinearPatch<R>;
        98 "sphere_light" SphereLight: SphereLight<R>;
        102 "chained_frames" ChainedFrames: ChainedFrames;
        102 "scattered_twice" ScatteredTwice: ScatteredTwice<R>;
        106 "scattering_vertex" ScatteringVertex: ScatteringVertex<R>;
        111 "stick_breaking" StickBreaking: StickBreaking;
        40 "helix" Helix: Helix<R>;
        95 "truncated_cone" TruncatedCone: TruncatedCone<R>;
        97 "onto_plane" OntoPlane: OntoPlane<R>;
        47 "triangle" Triangle: Triangle<R>;
        48 "triangle_heitz" TriangleHeitz: TriangleHeitz<R>;
        49 "triangle_fold" TriangleFold: TriangleFold<R>;
        79 "quaternion" Quaternion: Quaternion;
        94 "ellipsoid" Ellipsoid: Ellipsoid<R>;
        96 "torus" Torus: Torus<R>;
        103 "shell" Shell: Shell<R>;
        104 "tetrahedron" Tetrahedron: Tetrahedron<R>;
        105 "simplex" Simplex: Simplex;
        113 "ordered" Ordered: Ordered;
        114 "correlation_factor" CorrelationFactor: CorrelationFactor;
        8 "smoothstep" Smoothstep: Smoothstep<R>;
        9 "epanechnikov" Epanechnikov: Epanechnikov;
        10 "logistic" Logistic: Logistic<R>;
        11 "truncated_logistic" TruncatedLogistic: TruncatedLogistic<R>;
        11 "truncated_logistic_as_printed" TruncatedLogisticAsPrinted: TruncatedLogisticAsPrinted<R>;
        12 "normal" Normal: Normal<R>;
        13 "lower_normal" LowerNormal: LowerNormal<R>;
        13 "upper_normal" UpperNormal: UpperNormal<R>;
        14 "cauchy" Cauchy: Cauchy<R>;
        20 "pareto" Pareto: Pareto<R>;
        21 "kumaraswamy" Kumaraswamy: Kumaraswamy<R>;
        22 "power_law" PowerLaw: PowerLaw<R>;
        24 "sinh_arcsinh" SinhArcsinh: SinhArcsinh<R>;
        25 "heavy_tails" HeavyTails: HeavyTails<R>;
        26 "equiangular" Equiangular: Equiangular<R>;
        26 "equiangular_as_printed" EquiangularAsPrinted: EquiangularAsPrinted<R>;
        28 "linear_extinction" LinearExtinction: LinearExtinction<R>;
        29 "falling_extinction" FallingExtinction: FallingExtinction<R>;
        37 "kepler" Kepler: Kepler<R>;
        38 "hyperexponential" Hyperexponential: Hyperexponential<R>;
        100 "thin_lens" ThinLens: ThinLens<R>;
        101 "portal_segment" PortalSegment: PortalSegment<R>;
        108 "small_angles" SmallAngles: SmallAngles<R>;
    }
    composed {
        101 "tilted_portal" TiltedPortal: |p| tilted_portal(
            p(0), vector(p, 1), Direction::from_vec(vector(p, 4)), vector(p, 7), Direction::from_vec(vector(p, 10)),
        )?;
        85 "heitz_normals" HeitzNormals: |p| heitz_normals(p(0), Direction::from_vec(vector(p, 1)))?;
        70 "seen_triangle" SeenTriangle: |p| seen_triangle(vector(p, 0), vector(p, 3), vector(p, 6))?;
        71 "seen_rectangle" SeenRectangle: |p| seen_rectangle(p(0), p(1), p(2), p(3), p(4))?;
    }
    more {
        14 "cauchy_by_tangent" CauchyByTangent: CauchyByTangent<R>, [[1.0], [20.0]];
        27 "wavelength" Wavelength: Wavelength, [[]];
        33 "arcsine" Arcsine: Arcsine, [[]];
        39 "quintic" Quintic: Quintic<R>, [[0.0], [1.0], [100.0]];
        85 "visible_normals_as_printed" VisibleNormalsAsPrinted: VisibleNormalsAsPrinted<R>,
            [[0.25, 0.48, 0.64, 0.6], [0.05, 0.6, 0.0, 0.8]];
        115 "planar_flow" PlanarFlow: PlanarFlow<R>, [[0.75, 0.5, -2.0, 0.25], [0.0, 1.0, 1.0, 0.0]];
    }
    tables {
        30 "piecewise_constant" Steps: tables::steps::<R>().sampler();
        31 "piecewise_linear" Polygon: tables::polygon::<R>().sampler();
        55 "piecewise_constant_cells" Cells: tables::cells::<R>().sampler();
        55 "environment" CellsOfTheSky: tables::cells::<R>().directions();
    }
    renderer {
        "diffuse lobe" DiffuseLobe: |p| renderer::cosine_hemisphere(), [[]];
        "diffuse, hit at a distance" DiffuseHit:
            |p| renderer::cosine_hemisphere()
                .then(renderer::rotate(Frame::around(Direction::from_vec(vector(p, 0)))))
                .then(renderer::hit_plane(Vec3::new(R::ZERO, R::ZERO, R::ZERO), vector(p, 3), Direction::from_vec(vector(p, 6)), SurfaceId(0))),
            [
                [0.0, 0.0, 1.0, 0.0, 0.0, 2.0, 0.2, -0.1, 1.0],
                [0.48, 0.64, 0.6, 1.0, 2.0, 1.0, 0.0, 0.6, -0.8],
                [0.0, 0.0, -1.0, 0.0, 0.0, -1e-6, 0.0, 0.0, 1.0],
                [0.6, 0.0, 0.8, 1e6, 0.0, 1e5, -0.8, 0.0, 0.6],
            ];
        "rough conductor, visible GGX" VisibleGgx:
            |p| facets::visible_ggx_normals(p(0), p(0), view(p(1)))?.then(facets::reflect(view(p(1)))),
            [[0.5, 0.6], [0.1, 0.9], [1e-2, 0.3], [1e-4, 0.6], [0.3, 1e-3]];
        "rough conductor, Beckmann" Beckmanns:
            |p| facets::beckmann_normals(p(0), p(0))?.then(facets::reflect(view(p(1)))),
            [[0.5, 0.6], [0.1, 0.9], [1e-2, 0.3], [1e-4, 0.6]];
        "visible slopes, Beckmann" VisibleBeckmannSlopes:
            |p| facets::visible_beckmann_slopes(p(0))?, [[1e-3], [0.5], [1.0], [8.0], [128.0]];
        "rough conductor, visible Beckmann" VisibleBeckmann:
            |p| facets::visible_beckmann_slopes(p(2))?
                .then(facets::tilted(p(0), p(0), R::ONE, R::ZERO)?)
                .then(facets::reflect(view(p(1)))),
            [[0.5, 0.6, 1.5], [0.1, 0.9, 20.0], [1e-2, 0.3, 40.0], [0.3, 1e-3, 3e-3]];
        "glossy lobe" GlossyLobe: |p| renderer::power_lobe(p(0))?, [[0.0], [1.0], [30.0], [1e3], [1e5]];
        "rough dielectric, refraction" RoughRefraction:
            |p| facets::visible_ggx_normals(p(0), p(0), view(p(1)))?
                .then(facets::refract_in(view(p(1)), p(2))?),
            [[0.5, 0.6, 0.667], [0.1, 0.9, 0.75], [1e-2, 0.3, 0.667], [1e-4, 0.6, 0.5]];
        "rough dielectric, refraction into air" RoughEscape:
            |p| facets::visible_ggx_normals(p(0), p(1), view(p(2)))?
                .then(facets::refract_out(view(p(2)), p(3))?),
            [[0.5, 0.3, 0.6, 1.5], [0.1, 0.1, 0.9, 1.333], [1e-2, 1e-2, 0.95, 1.5], [0.3, 0.3, 0.7, 1.00003]];
        "rough dielectric, index next to one" RoughNearOne:
            |p| facets::visible_ggx_normals(p(0), p(0), view(p(1)))?
                .then(facets::refract_in(view(p(1)), p(2))?),
            [[0.3, 0.7, 0.99997], [0.05, 0.7, 0.999999]];
        "rough conductor, anisotropic GGX" AnisotropicNormals:
            |p| facets::ggx_normals(p(0), p(1))?.then(facets::reflect(view(p(2)))),
            [[0.5, 0.1, 0.6], [1e-2, 0.3, 0.9], [1e-4, 1e-2, 0.5]];
        "rough conductor, anisotropic visible GGX" AnisotropicVisible:
            |p| facets::visible_ggx_normals(p(0), p(1), view(p(2)))?.then(facets::reflect(view(p(2)))),
            [[0.5, 0.1, 0.6], [1e-2, 0.3, 0.9], [1e-4, 1e-2, 0.5]];
        "sphere light by its cone" LightCone: |p| renderer::uniform_cone(p(0))?, [[0.5], [1e-3], [1e-7], [1.0]];
        "triangle light by direction" TriangleByDirection:
            |p| renderer::spherical_triangle(p(0), p(1), p(2))?,
            [[0.6, -0.6, 1.2], [0.9, -0.7, 1.6], [0.2, 0.05, 0.1], [0.03, -0.02, 0.01]];
        "rectangle light by direction" RectangleByDirection:
            |p| renderer::spherical_rectangle(p(0), p(1), p(2), p(3))?,
            [[0.57, 0.17, -0.27, 0.65], [0.2, 0.9, -0.1, 0.15], [3.0, 0.1, -1.2, 2.4], [0.05, 0.3, 0.01, 0.02]];
        "sky" Sky: |p| renderer::uniform_directions(), [[]];
        "triangle light" TriangleLight:
            |p| renderer::uniform_triangle(vector(p, 0), vector(p, 3), vector(p, 6), SurfaceId(0)),
            TRIANGLES;
        "sphere light" SphereLightSurface:
            |p| renderer::uniform_sphere_surface(vector(p, 0), p(3), SurfaceId(0)),
            [[1.0, 2.0, 3.0, 2.5], [0.0, 0.0, 0.0, 1e-6], [0.0, 0.0, 0.0, 1e6], [100.0, -50.0, 1.0, 0.125]];
        "disk light" DiskLight:
            |p| renderer::uniform_disk(vector(p, 0), vector(p, 3), vector(p, 6), SurfaceId(0)),
            [
                [1.0, 2.0, 3.0, 1.0, 0.5, 0.0, -0.5, 1.0, 0.25],
                [0.0, 0.0, 0.0, 1e-6, 0.0, 0.0, 0.0, 1e-6, 0.0],
                [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1e-9, 0.0],
            ];
        "cylinder light" CylinderLight:
            |p| renderer::uniform_cylinder(
                vector(p, 0), Frame::around(Direction::from_vec(vector(p, 3))), p(6), p(7), SurfaceId(0),
            ),
            [
                [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 0.5],
                [100.0, -50.0, 1.0, 1.0, -2.0, 0.5, 1e-3, 10.0],
                [0.0, 0.0, 0.0, 0.0, 0.6, -0.8, 1e6, 1e-6],
            ];
        "rectangle light" RectangleLight:
            |p| renderer::uniform_rectangle(vector(p, 0), vector(p, 3), vector(p, 6), SurfaceId(0)),
            [
                [1.0, 2.0, 3.0, 2.0, 0.5, 0.0, -0.5, 1.0, 0.25],
                [0.0, 0.0, 0.0, 1e-6, 0.0, 0.0, 0.0, 1e-6, 0.0],
                [0.0, 0.0, 1.0, 1e6, 0.0, 0.0, 0.0, 1e-6, 0.0],
            ];
        "lens" Lens: |p| renderer::disk(p(0)), [[1.0], [1e-6], [1e6]];
        "rectangle of the film" FilmRectangle:
            |p| renderer::film_rectangle(Vec2::new(p(0), p(1)), Vec2::new(p(2), p(3))),
            [[0.0, 0.0, 640.0, 480.0], [8191.0, 4095.0, 1.0, 2.0]];
        "about a pixel" FilmNear:
            |p| renderer::film_near(Vec2::new(p(0), p(1)), p(2), p(3))?,
            [[0.5, 0.5, 0.1, 100.0], [320.5, 240.5, 0.1, 64.0]];
        "about a direction" ConeNear: |p| renderer::cone_near(p(0), p(1))?, [[1e-4, 0.1], [1e-2, 1.0]];
        "square of directions" SquareOfDirections:
            |p| renderer::square_of_directions(p(0))?, [[0.5], [0.01], [1.0]];
        "window by direction" Window:
            |p| daylight::unit_triangle().then(daylight::through(vector(p, 0), vector(p, 3), vector(p, 6))),
            [
                [-1.0, -1.0, 2.0, 2.0, 0.0, 0.0, 0.0, 2.0, 0.5],
                [1.0, -1.0, 1e-3, 0.0, 2.0, 0.0, 0.0, 0.0, 2.0],
                [0.0, 0.0, 1e3, 1e-2, 0.0, 0.0, 0.0, 1e-2, 0.0],
            ];
        "parallel film" ParallelFilm:
            |p| renderer::film_box(p(0), p(1)).then(renderer::parallel_hit(
                Vec2::new(R::of(320.0), R::of(240.0)), vector(p, 2), vector(p, 5), vector(p, 8), vector(p, 11),
                vector(p, 14), vector(p, 17), SurfaceId(0),
            )),
            [
                [
                    12.5, 40.5, 0.0, 0.0, 0.0, 0.01, 0.0, 0.0, 0.0, 0.01, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 9.0, 0.0, 0.6,
                    -0.8,
                ],
                [
                    320.5, 240.5, 100.0, -50.0, 1.0, 0.1, 0.0, 0.02, 0.01, -0.2, 0.0, 0.1, 0.2, 0.97, 110.0, -40.0,
                    90.0, 0.6, 0.0, -0.8,
                ],
            ];
        "film, box filter" FilmBox: |p| renderer::film_box(p(0), p(1)), [[0.5, 0.5], [320.5, 240.5], [8191.5, 8191.5]];
        "film, tent filter" FilmTent:
            |p| renderer::film_tent(p(0), p(1), p(2), p(3)),
            [[0.5, 0.5, 1.0, 1.0], [320.5, 240.5, -1.0, 1.0], [8191.5, 8191.5, 1.0, -1.0]];
        "film, Gaussian filter" FilmGaussian:
            |p| renderer::film_gaussian(p(0), p(1), p(2), p(3)),
            [[0.5, 0.5, 0.5, 0.9999998874648253], [8191.5, 8191.5, 0.5, 0.9999998874648253]];
        "film, Mitchell's filter" FilmMitchell:
            |p| tables::mitchell::<R>().sampler().then(square(p(0), p(1), R::of(2.0))),
            [[0.5, 0.5], [320.5, 240.5]];
        "film, Lanczos' filter" FilmLanczos:
            |p| tables::lanczos::<R>().sampler().then(square(p(0), p(1), R::of(3.0))),
            [[0.5, 0.5], [320.5, 240.5]];
        "environment map" EnvironmentMap:
            |p| tables::sky::<R>().directions().then(renderer::rotate(Frame::around(Direction::from_vec(vector(p, 0))))),
            [[0.0, 0.0, 1.0], [0.48, 0.64, 0.6]];
        "camera, box filter" CameraBox:
            |p| camera(renderer::film_box(p(0), p(1)), p(2)),
            [[320.5, 240.5, 0.002], [639.5, 0.5, 0.002], [320.5, 240.5, 1e-6], [639.5, 479.5, 0.1]];
        "camera with a lens, box filter" CameraLens:
            |p| behind_lens(renderer::film_box(p(0), p(1)), p(2), Vec2::new(p(3), p(4))),
            [[320.5, 240.5, 0.002, 0.03, -0.04], [639.5, 0.5, 0.002, 1e-6, 2.0], [320.5, 240.5, 1e-6, 0.1, 0.1]];
        "camera, tent filter" CameraTent:
            |p| camera(renderer::film_tent(p(0), p(1), R::ONE, -R::ONE), p(2)),
            [[320.5, 240.5, 0.002], [639.5, 0.5, 0.002]];
        "camera, Gaussian filter" CameraGaussian:
            |p| camera(renderer::film_gaussian(p(0), p(1), R::of(0.5), R::of(0.9999998874648253)), p(2)),
            [[320.5, 240.5, 0.002], [639.5, 0.5, 0.002]];
    }
}
