//! Why a sampler misses the limit somewhere: what the report says of it.

use Where::{Both, Double, Single};

/// The precisions in which a sampler misses the limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Where {
    /// In both.
    Both,
    /// In `f64` alone, or for another reason than in `f32`.
    Double,
    /// In `f32` alone, or for another reason than in `f64`.
    Single,
}

impl Where {
    /// Whether a precision, `f64` or `f32`, belongs to it.
    pub fn has(self, precision: &str) -> bool {
        self == Both || (self == Double) == (precision == "f64")
    }
}

/// The reasons that are known, by the name of the sampler.
pub const REASONS: &[(&str, Where, &str)] = &[
    ("linear", Single, LEAST),
    ("planar_flow", Single, LEAST),
    ("bilinear_patch", Both, LEAST),
    ("renderer: rough conductor, visible Beckmann", Single, LEAST),
    ("renderer: triangle light", Single, LEAST),
    (
        "renderer: environment map",
        Both,
        "an azimuth next to half a turn is found from a coordinate next to zero, and has fewer digits than that; and next to it the density vanishes",
    ),
    ("student", Single, FAR),
    ("sheen", Single, EXPONENT),
    ("scattered_twice", Single, "the own density is a power of ten thousand of a rounded cosine"),
    (
        "power",
        Single,
        "x is below the normal numbers and has few digits; k xᵏ / x leaves the range before it is multiplied by k",
    ),
    ("Weibull", Single, SUBNORMAL),
    ("truncated exponential", Single, TINY),
    (
        "affine of two logistics",
        Single,
        "a matrix that has no inverse but for rounding, which magnifies a rounded point by 1e7 and more",
    ),
    ("power cosine", Double, EXPONENT),
    (
        "height field",
        Single,
        "the slope at the top of a hill of 1e8 is the cosine of a rounded quarter turn",
    ),
    ("triangular", Both, "a peak at the lower end: c - √((1 - u)(c - a)(c - b)) cancels"),
    (
        "rational_quadratic",
        Both,
        "at the upper end a quadratic equation is solved by the root whose denominator cancels",
    ),
    (
        "bilinear_density",
        Double,
        "a corner a million times the others: the own density takes 1 - y of a rounded y; corners of zero: the last uniform is rounded onto one, where the density is zero",
    ),
    (
        "bilinear_density",
        Single,
        "corners of zero: the own density takes 1 - y of a rounded y, the least uniforms vanish beside them, and the last uniform is rounded onto a corner, where the density is zero",
    ),
    ("sawtooth", Single, BORDER),
    ("pentagon", Single, BORDER),
    ("regular_polygon", Single, BORDER),
    (
        "environment",
        Single,
        "a coordinate next to zero tells on which side of the border between two cells a direction lies, its rounded azimuth does not",
    ),
    (
        "radial_flow",
        Both,
        "the last uniform: the radius is recovered from a difference and exponentiated",
    ),
    (
        "affine_coupling",
        Both,
        "the middle of the second variable, where its density has no slope, and so no condition number, while rounding moves the point by a thousandth of its width in f64 and by far more than that in f32",
    ),
    (
        "anisotropic_normals",
        Both,
        "the last normals lie on the horizon: their height is what the view and a nearly opposite direction leave of each other",
    ),
    (
        "anisotropic_normals_as_printed",
        Both,
        "as printed, 1 - a² - b² at the rim of the disk is a difference",
    ),
    (
        "truncated_logistic_as_printed",
        Both,
        "as printed: a sample next to zero is the logarithm of odds next to one, of a rounded probability",
    ),
    (
        "equiangular_as_printed",
        Single,
        "the last uniform, for a light that is seen under next to no angle: the angle of the upper end is rounded beyond it",
    ),
    ("visible_normals", Both, OPPOSITE),
    (
        "refracted_ggx",
        Single,
        "next to total reflection, and half vectors on the horizon, which rounding crosses",
    ),
    (
        "mixture",
        Both,
        "the last uniform of a piece: how far it is from the end is taken from its rounded place in the piece",
    ),
    ("sheen", Double, EXPONENT),
    ("sphere_light", Both, "next to the rim: differences of squares"),
    (
        "chained_frames",
        Double,
        "a grazing second direction: its height above the plane is a difference",
    ),
    (
        "chained_frames",
        Single,
        "a grazing second direction, whose height above the plane is a difference; and one along the first, where the frame turns rounding into an azimuth",
    ),
    (
        "scattering_vertex",
        Double,
        "the first and last directions at g next to one: the multiplied-out cosine cancels; far from the origin, a length of 1e-3 is a difference",
    ),
    (
        "scattering_vertex",
        Single,
        "the first and last directions at g next to one: the multiplied-out cosine cancels; next to the origin, the density is larger and the point smaller than any number",
    ),
    (
        "onto_plane",
        Both,
        "grazing directions: the cosine at the plane is what is left of large terms; in f32 also a million from the origin, where the plane is 32 roundings away",
    ),
    (
        "bivariate_normal",
        Single,
        "a deviation of 1e-9 across a line whose points are rounded by more",
    ),
    ("triangle_heitz", Both, BORDER),
    ("triangle_fold", Both, BORDER),
    ("ellipsoid", Both, "near the tips, 1 - z²/s² of a rounded z"),
    (
        "shell",
        Single,
        "the cube of a radius of 1e-5 times the least uniform is smaller than any number",
    ),
    (
        "ordered",
        Single,
        "the last uniforms: a density next to the least numbers, as a product whose parts are smaller than these",
    ),
    (
        "correlation_factor",
        Both,
        "the product of two of the least uniforms under one root is smaller than any number",
    ),
    ("cubic", Single, "two roots meet, and a rounded sample does not tell them apart"),
    ("elliptical_grid", Both, "the corners, where the map folds"),
    (
        "truncated_logistic",
        Double,
        "the last uniforms: the density next to the upper end is a difference of exponentials of the ends",
    ),
    (
        "truncated_logistic",
        Single,
        "the last uniforms: the density next to the upper end is a difference of exponentials of the ends, which are next to the end of their range",
    ),
    ("cauchy", Single, FAR),
    (
        "cauchy_by_tangent",
        Both,
        "as printed, u - 1/2 loses a small u, and the tangent is taken next to its pole",
    ),
    ("pareto", Both, TINY),
    (
        "kumaraswamy",
        Double,
        "the last uniforms are rounded onto the end, one; and samples below the normal numbers have few digits",
    ),
    ("kumaraswamy", Single, "samples below the normal numbers have few digits"),
    ("sinh_arcsinh", Single, FAR),
    ("heavy_tails", Single, FAR),
    ("linear_extinction", Both, TINY),
    ("falling_extinction", Both, TINY),
    (
        "portal_segment",
        Both,
        "grazing lines, whose ends are so far away that they do not tell where the opening is, and the tip of the opening, to which a whole side of uniforms leads",
    ),
    (
        "tilted_portal",
        Both,
        "lines that graze the far plane: the cosine there is what is left of large coordinates",
    ),
    (
        "seen_triangle",
        Single,
        "the corner from which the arcs of a sliver start, which has no azimuth",
    ),
    (
        "seen_rectangle",
        Double,
        "one that fills nearly half of the sky: it starts next to a quarter turn, and heights are next to one",
    ),
    (
        "seen_rectangle",
        Single,
        "one that fills nearly half of the sky: it starts next to a quarter turn, and heights are next to one; one that is four roundings wide",
    ),
    (
        "quintic",
        Single,
        "the root of a sum whose terms are a hundred times as large as its slope at the end",
    ),
    (
        "visible_normals_as_printed",
        Both,
        "as printed, 1 - a² - b² at the rim of the disk is a difference",
    ),
    ("renderer: diffuse, hit at a distance", Both, "a grazing plane a million units away"),
    ("renderer: rough conductor, visible GGX", Both, OPPOSITE),
    (
        "renderer: visible slopes, Beckmann",
        Both,
        "viewed nearly from above, slopes are small differences from the steepest one that is seen",
    ),
    ("renderer: rough dielectric, refraction", Both, OPPOSITE),
    (
        "renderer: rough dielectric, refraction into air",
        Both,
        "next to total reflection, and where light is hardly bent: differences of nearly equal numbers",
    ),
    (
        "renderer: rough dielectric, index next to one",
        Both,
        "light that is hardly bent: its half vector is the difference of nearly equal directions",
    ),
    ("renderer: rough conductor, anisotropic GGX", Single, BACK),
    ("renderer: rough conductor, anisotropic visible GGX", Both, OPPOSITE),
    (
        "renderer: film, tent filter",
        Single,
        "far out on the film, the last samples are rounded onto the end of the filter",
    ),
];

const TINY: &str = "the least parameter times the least uniform is a subnormal number, which has few digits, or none";

const LEAST: &str = "the least uniform is a subnormal number, and what it is multiplied with leaves none of its digits";

const FAR: &str = "far out, squares overflow, or the density is smaller than any number";

const EXPONENT: &str = "the least uniform: the own density is a power of it whose exponent is a difference, and ln u multiplies the rounding of that";

const BORDER: &str =
    "a point within rounding of a border between pieces counts for both or for none";

const SUBNORMAL: &str = "the sample is below the normal numbers, and has few digits";

const OPPOSITE: &str =
    "grazing views, and a half or the last of uniforms: two nearly opposite vectors are added";

const BACK: &str = "light that goes straight on, by a facet that is seen edge-on: the half vector is the sum of two nearly opposite directions, and a rounded one has not quite unit length";

/// Why a sampler misses the limit in a precision.
pub fn reason(name: &str, precision: &str) -> &'static str {
    let about = |r: &&(&str, Where, &str)| r.0 == name && r.1.has(precision);
    REASONS.iter().find(about).map_or("not explained", |r| r.2)
}
