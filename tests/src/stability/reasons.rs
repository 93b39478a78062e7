//! Why a sampler misses the limit somewhere: what the report says of it.

/// The reasons that are known, by the name of the sampler.
const REASONS: &[(&str, &str)] = &[
    (
        "affine of two logistics",
        "the inverse of a nearly singular matrix magnifies the rounding of products",
    ),
    ("affine_coupling", "far out, the product of exponentials is one of nearly equal sizes"),
    (
        "truncated_logistic",
        "a width of 1e6: the logarithm of a ratio next to one; one of 0.001: at the last uniforms, 1 - u of a rounded u; in \
         f32, exponentials next to the end of their range",
    ),
    ("cauchy", TAIL),
    (
        "cauchy_by_tangent",
        "as printed, u - 1/2 loses a small u, and the tangent is taken next to its pole",
    ),
    ("pareto", TINY),
    (
        "kumaraswamy",
        "last uniforms, and x below every number: powers of a rounded x next to one and to zero",
    ),
    ("sinh_arcsinh", TAIL),
    ("heavy_tails", TAIL),
    ("linear_extinction", TINY),
    (
        "quintic",
        "in f32, the root of a sum whose terms are a hundred times as large as its slope at the end",
    ),
    (
        "visible_normals_as_printed",
        "as printed, 1 - a² - b² at the rim of the disk is a difference",
    ),
    ("annular_sector", "in f32, squares of the radius underflow"),
    ("anisotropic_ggx", "the own density at the last uniforms adds terms in u instead of 1 - u"),
    (
        "bilinear_density",
        "corners of zero, or equal rows: the inverse divides by a difference of sums",
    ),
    ("chained_frames", "the grazing second direction: its cosine is a difference"),
    ("concentric_hemisphere", BORDER),
    ("cone", "f32 tests narrow cones by 1 - z, which has been rounded"),
    ("correlation_factor", "next to a factor of -1 or 1 the rounded point lies off the manifold"),
    ("cubic", "two roots meet, and a rounded sample does not tell them apart"),
    ("double_lune", BORDER),
    ("elliptical_grid", "the corners, where the map folds"),
    ("ellipsoid", "near the tips, 1 - z²/s² of a rounded z"),
    ("equal_area_octahedral", BORDER),
    ("fold", "at the fold the density is that of one side"),
    ("henyey_greenstein", "f32 at g next to 1: the lobe is narrower than the rounding of z"),
    ("linear", "a uniform of 1e-300 at a = 0: an intermediate product underflows"),
    ("mixture", BORDER),
    ("onto_plane", "the foot of the normal direction: sums of squares far from the origin"),
    ("ordered", "the last uniforms: differences of exponentials"),
    ("pentagon", BORDER),
    ("power", "f32 cannot hold x at small k"),
    ("power cosine", "an exponent of 1e12: a power of z near the pole, where x and y would tell"),
    (
        "radial_flow",
        "the last uniform: the radius is recovered from a difference and exponentiated",
    ),
    ("rational_quadratic", "at the upper end the density is a difference"),
    (
        "reflected_ggx",
        "half vectors on the horizon; grazing views, where the half vector is the sum of two nearly opposite directions",
    ),
    ("falling_extinction", TINY),
    (
        "portal_segment",
        "grazing lines, whose ends are so far away that they do not tell where the opening is, and the tip of the \
         opening, to which a whole side of uniforms leads",
    ),
    (
        "seen_triangle",
        "in f32, the corner from which the arcs of a sliver start, which has no azimuth",
    ),
    (
        "seen_rectangle",
        "one that fills nearly half of the sky: it starts next to a quarter turn, and heights are next to one; in f32, \
         one that is four roundings wide",
    ),
    (
        "lower_normal",
        "40 standard deviations below: probabilities beyond 39 are smaller than any number, with 31 digits too",
    ),
    ("refracted_ggx", "half vectors on the horizon, which rounding crosses"),
    (
        "renderer: camera, box filter",
        "a pixel of 1e-6 is sixteen roundings of an oblique direction in f32 wide, and what is rounded over its border \
         lies outside; with wider pixels, the last bits before the border",
    ),
    ("renderer: camera, tent filter", COMPOSED),
    ("renderer: diffuse, hit at a distance", "a grazing plane a million units away"),
    (
        "renderer: film, Gaussian filter",
        "the rim of the filter: the radius is a difference from the centre",
    ),
    (
        "renderer: triangle light",
        "in f32, far from the origin: rounding exceeds an eighth of the triangle",
    ),
    ("scattering_vertex", "far from the origin, and a printed cosine that cancels"),
    ("sheen", "alpha of 0.001: a power of 1000, whose base is not taken from z"),
    ("sphere_light", "far away, at the rim and close by: differences of squares"),
    (
        "student_2",
        "in f32, (2 + x²)^(-3/2) far out is smaller than any number, and logarithms are emitted of exponentials alone",
    ),
    ("tetrahedron", "f32 next to a corner"),
    ("triangle_fold", BORDER),
    (
        "student",
        "a quarter and three quarters, where two pieces meet: with the slack of incomplete beta functions a point \
         next to the border counts for both; in f32, nu / (nu + x²) underflows far out",
    ),
    ("triangle_heitz", BORDER),
    ("triangular", "a peak at an end: c - √(c²(1 - u)) cancels"),
    ("truncated exponential", "s d below -709: 1 - u is rounded before it meets exp(-s d)"),
    ("visible_normals", OPPOSITE),
    ("renderer: rough conductor, Beckmann", BACK),
    ("renderer: rough conductor, visible Beckmann", BACK),
    ("renderer: rough conductor, visible GGX", OPPOSITE),
    ("renderer: rough dielectric, refraction", OPPOSITE),
    (
        "renderer: rough dielectric, refraction into air",
        "next to total reflection, and where light is hardly bent: differences of nearly equal numbers",
    ),
    (
        "renderer: rough dielectric, index next to one",
        "light that is hardly bent: its half vector is the difference of nearly equal directions",
    ),
    ("renderer: rough conductor, anisotropic GGX", BACK),
    ("renderer: rough conductor, anisotropic visible GGX", OPPOSITE),
    (
        "renderer: window by direction",
        "next to a side of the window, which the rounding of a direction crosses",
    ),
    (
        "renderer: visible slopes, Beckmann",
        "viewed nearly from above, slopes are small differences from the steepest one that is seen",
    ),
    ("Weibull", "f32 cannot hold x = u², which is subnormal"),
    (
        "height field",
        "in f32, the slope at the top of a hill of 1e8 is the cosine of a rounded quarter turn",
    ),
    ("shell", "f32 cannot hold the cube of a radius of 1e-5 times a tiny uniform"),
    ("triangle", "in f32, far from the origin: rounding exceeds an eighth of the triangle"),
    (
        "renderer: film, tent filter",
        "in f32, far out on the film, the last samples are rounded onto the end of the filter",
    ),
];

const TAIL: &str = "in f32, far out, squares overflow and the density is smaller than any number";

const TINY: &str =
    "the least parameter times the least uniform is a subnormal number, which has few digits";

const BORDER: &str =
    "a point within rounding of a border between pieces counts for both or for none";

const COMPOSED: &str = "a map between rounds the point of the film by more than its sampler knows: the last bits of a pixel";

const OPPOSITE: &str =
    "grazing views, and a half or the last of uniforms: two nearly opposite vectors are added";
const BACK: &str = "light that goes back to where it is seen from, on a facet that is seen edge-on: the half vector \
     is the sum of two nearly opposite directions, and a rounded one has not quite unit length";

/// Why a sampler misses the limit.
pub fn reason(name: &str) -> &'static str {
    REASONS.iter().find(|(n, _)| *n == name).map_or("not explained", |(_, reason)| reason)
}
