//! Colours that vary over a surface. Conventions are Mitsuba's.

use glam::{Affine2, Vec2, Vec3};

use super::mesh::barycentric;
use crate::image::Picture;

/// A colour, or one that a texture gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Colour {
    /// The colour; of a texture its mean.
    pub value: Vec3,
    /// Index in [`super::Scene::textures`].
    pub texture: Option<u32>,
}

impl From<Vec3> for Colour {
    fn from(value: Vec3) -> Self {
        Colour { value, texture: None }
    }
}

/// A number, or the luminance of what a texture gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grey {
    /// The number; of a texture its mean.
    pub value: f32,
    /// Index in [`super::Scene::textures`].
    pub texture: Option<u32>,
}

impl From<f32> for Grey {
    fn from(value: f32) -> Self {
        Grey { value, texture: None }
    }
}

/// Where a texture is looked up: a point of a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spot {
    /// Its texture coordinates.
    pub uv: Vec2,
    /// The number of its primitive.
    pub primitive: u32,
    /// Where it is.
    pub position: Vec3,
}

/// The values of an attribute over the triangles of one mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Patch {
    /// The number of the first triangle.
    pub first: u32,
    /// The corners of each triangle, and the values there.
    pub triangles: Vec<([Vec3; 3], [Vec3; 3])>,
}

impl Patch {
    /// The value at a point, linear between the corners.
    fn at(&self, spot: &Spot) -> Option<Vec3> {
        let index = spot.primitive.checked_sub(self.first)?;
        let (corners, [a, b, c]) = self.triangles.get(index as usize)?;
        let w = barycentric(corners, spot.position);
        Some(w.x * *a + w.y * *b + w.z * *c)
    }
}

/// The luminance of linear Rec. 709.
pub fn luminance(colour: Vec3) -> f32 {
    colour.dot(Vec3::new(0.212_671, 0.715_160, 0.072_169))
}

/// How texels become a continuous function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// Constant in each texel.
    Nearest,
    /// Bilinear between the centres of texels.
    Bilinear,
}

/// What lies beyond the unit square.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrap {
    /// The same again.
    Repeat,
    /// Its mirror image.
    Mirror,
    /// The border goes on.
    Clamp,
}

/// What a texture shows.
#[derive(Clone, Debug, PartialEq)]
pub enum Pattern {
    /// A picture, its first row at v = 0.
    Picture {
        /// The texels.
        image: Picture,
        /// How they are interpolated.
        interpolation: Interpolation,
        /// What lies beyond the picture.
        wrap: Wrap,
    },
    /// Squares of side one half, of two kinds.
    Checkerboard([Square; 2]),
    /// What a mesh has at its vertices or faces, by name.
    Attribute {
        /// The name, with `vertex_` or `face_` before it.
        name: String,
        /// Each mesh that has it, in the order of their triangles.
        patches: Vec<Patch>,
    },
}

/// What the squares of a checkerboard show.
#[derive(Clone, Debug, PartialEq)]
pub enum Square {
    /// One colour.
    Plain(Vec3),
    /// Part of a texture, which has its own place on the surface.
    Textured(Box<Texture>),
}

impl Square {
    /// The colour at texture coordinates of the surface.
    fn at(&self, uv: Vec2) -> Vec3 {
        match self {
            Square::Plain(colour) => *colour,
            Square::Textured(texture) => texture.at(uv),
        }
    }

    fn mean(&self) -> Vec3 {
        match self {
            Square::Plain(colour) => *colour,
            Square::Textured(texture) => texture.mean(),
        }
    }

    /// The least value of any channel, and the largest.
    fn range(&self) -> (f32, f32) {
        match self {
            Square::Plain(colour) => (colour.min_element(), colour.max_element()),
            Square::Textured(texture) => texture.range(),
        }
    }
}

/// A colour as a function of texture coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// What it shows.
    pub pattern: Pattern,
    /// From the texture coordinates of the surface to those of the pattern.
    pub to_uv: Affine2,
    /// What its values are multiplied by.
    pub scale: f32,
}

impl Texture {
    /// The colour at texture coordinates.
    pub fn at(&self, uv: Vec2) -> Vec3 {
        let here = self.to_uv.transform_point2(uv);
        if !here.is_finite() {
            return self.mean();
        }
        self.scale
            * match &self.pattern {
                Pattern::Checkerboard(squares) => squares[kind_of_square(here)].at(uv),
                Pattern::Attribute { .. } => self.pattern_mean(),
                Pattern::Picture { image, interpolation, wrap } => {
                    picture_at(image, *interpolation, *wrap, here)
                }
            }
    }

    /// The colour at a point of a surface.
    #[inline]
    pub fn on(&self, spot: &Spot) -> Vec3 {
        match &self.pattern {
            Pattern::Attribute { patches, .. } => {
                let next = patches.partition_point(|patch| patch.first <= spot.primitive);
                let value = next.checked_sub(1).and_then(|index| patches[index].at(spot));
                value.map_or(self.mean(), |value| self.scale * value)
            }
            _ => self.at(spot.uv),
        }
    }

    /// The luminance at a point of a surface, as of [`Texture::number`].
    #[inline]
    pub fn number_on(&self, spot: &Spot) -> f32 {
        match &self.pattern {
            Pattern::Attribute { .. } => luminance(self.on(spot)),
            _ => self.number(spot.uv),
        }
    }

    /// The luminance at texture coordinates. As in Mitsuba 3, a checkerboard that is asked for numbers
    /// exchanges its two.
    pub fn number(&self, uv: Vec2) -> f32 {
        let here = self.to_uv.transform_point2(uv);
        match &self.pattern {
            Pattern::Checkerboard(squares) if here.is_finite() => {
                self.scale
                    * match &squares[1 - kind_of_square(here)] {
                        Square::Plain(colour) => luminance(*colour),
                        Square::Textured(texture) => texture.number(uv),
                    }
            }
            _ => luminance(self.at(uv)),
        }
    }

    /// How the luminance changes with the two texture coordinates; zero where it jumps.
    pub fn gradient(&self, uv: Vec2) -> Vec2 {
        let uv = self.to_uv.transform_point2(uv);
        let Pattern::Picture { image, interpolation: Interpolation::Bilinear, wrap } =
            &self.pattern
        else {
            return Vec2::ZERO;
        };
        if !uv.is_finite() {
            return Vec2::ZERO;
        }
        let size = Vec2::new(image.width() as f32, image.height() as f32);
        let (texels, t) = around(image, *wrap, in_texels(image, *wrap, uv));
        let [[a, b], [c, d]] = texels.map(|row| row.map(luminance));
        let mix = |p: f32, q: f32, t: f32| p + t * (q - p);
        let slope = Vec2::new(mix(b - a, d - c, t.y), mix(c - a, d - b, t.x)) * size;
        self.scale * (self.to_uv.matrix2.transpose() * slope)
    }

    /// The mean over the unit square.
    pub fn mean(&self) -> Vec3 {
        self.scale * self.pattern_mean()
    }

    fn pattern_mean(&self) -> Vec3 {
        match &self.pattern {
            // Not known before the meshes are; it only matters to how well light is sampled.
            Pattern::Attribute { .. } => Vec3::splat(0.5),
            Pattern::Checkerboard([a, b]) => 0.5 * (a.mean() + b.mean()),
            Pattern::Picture { image, .. } => {
                let sum: glam::DVec3 = image.texels().map(|p| Vec3::from(p).as_dvec3()).sum();
                (sum / image.texels().len() as f64).as_vec3()
            }
        }
    }

    /// The largest value of any channel, and the least.
    pub fn range(&self) -> (f32, f32) {
        let all = |least: f32, largest: f32, v: Vec3| {
            (least.min(v.min_element()), largest.max(v.max_element()))
        };
        let start = (f32::INFINITY, f32::NEG_INFINITY);
        let (least, largest) = match &self.pattern {
            Pattern::Checkerboard(squares) => squares.iter().fold(start, |(a, b), square| {
                let (least, largest) = square.range();
                (a.min(least), b.max(largest))
            }),
            Pattern::Attribute { patches, .. } => {
                let triangles = patches.iter().flat_map(|patch| &patch.triangles);
                let values = triangles.flat_map(|(_, values)| values);
                values.fold(start, |(a, b), value| all(a, b, *value))
            }
            Pattern::Picture { image, .. } => {
                image.texels().fold(start, |(a, b), p| all(a, b, Vec3::from(p)))
            }
        };
        let (a, b) = (self.scale * least, self.scale * largest);
        (a.min(b), a.max(b))
    }
}

/// Which of its two kinds of squares a checkerboard has at a point.
fn kind_of_square(uv: Vec2) -> usize {
    let within = uv - uv.floor();
    usize::from((within.x > 0.5) != (within.y > 0.5))
}

/// The colour of a picture at a point.
fn picture_at(image: &Picture, interpolation: Interpolation, wrap: Wrap, uv: Vec2) -> Vec3 {
    let at = in_texels(image, wrap, uv);
    if interpolation == Interpolation::Nearest {
        let [(x, _), (y, _)] = at.to_array().map(whole);
        let (x, y) = (wrapped(x, image.width(), wrap), wrapped(y, image.height(), wrap));
        return Vec3::from(image.texel(x, y));
    }
    let (texels, t) = around(image, wrap, at);
    let [upper, lower] = texels.map(|[left, right]| left.lerp(right, t.x));
    upper.lerp(lower, t.y)
}

/// A point in texels, of a picture that is repeated in the first one.
#[inline]
fn in_texels(image: &Picture, wrap: Wrap, uv: Vec2) -> Vec2 {
    // There indices mostly lie inside, and need no division.
    let uv = if wrap == Wrap::Repeat { Vec2::from(uv.to_array().map(|x| whole(x).1)) } else { uv };
    uv * Vec2::new(image.width() as f32, image.height() as f32)
}

/// The two rows of two texels between whose centres a point lies, which is given in texels, and how far it is from the
/// first to the last.
#[inline]
fn around(image: &Picture, wrap: Wrap, at: Vec2) -> ([[Vec3; 2]; 2], Vec2) {
    let [(x, right), (y, below)] = (at - 0.5).to_array().map(whole);
    let columns = neighbours(x, image.width(), wrap);
    let [[a, b], [c, d]] = image.square(columns, neighbours(y, image.height(), wrap));
    ([[a.into(), b.into()], [c.into(), d.into()]], Vec2::new(right, below))
}

/// The indices of two texels next to each other, given that of the first, which may lie outside.
#[inline]
fn neighbours(i: i32, count: usize, wrap: Wrap) -> [usize; 2] {
    let next = i + 1;
    if i >= 0 && (next as usize) < count {
        return [i as usize, next as usize];
    }
    [wrapped(i, count, wrap), wrapped(next, count, wrap)]
}

/// The whole number below, and what is above it; far away, where there is nothing to interpolate, some number.
#[inline]
fn whole(x: f32) -> (i32, f32) {
    const FAR: f32 = (1 << 30) as f32;
    let x = x.clamp(-FAR, FAR);
    let toward_zero = x as i32;
    let below = toward_zero - i32::from(toward_zero as f32 > x);
    (below, x - below as f32)
}

/// The index of a texel, given one that may lie outside. No picture is as large as such numbers can be.
fn wrapped(i: i32, count: usize, wrap: Wrap) -> usize {
    if (i as usize) < count {
        return i as usize;
    }
    let n = count as i32;
    let index = match wrap {
        Wrap::Clamp => i.clamp(0, n - 1),
        Wrap::Repeat => i.rem_euclid(n),
        Wrap::Mirror => {
            let j = i.rem_euclid(2 * n);
            if j < n { j } else { 2 * n - 1 - j }
        }
    };
    index as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(interpolation: Interpolation, wrap: Wrap) -> Texture {
        let image = crate::image::RgbImage::from_fn(2, 2, |x, y| [x as f32, y as f32, 1.0]);
        let image = image.into();
        Texture {
            pattern: Pattern::Picture { image, interpolation, wrap },
            to_uv: Affine2::IDENTITY,
            scale: 1.0,
        }
    }

    #[test]
    fn numbers_are_split_at_the_whole_number_below() {
        assert_eq!(
            [1.75, 2.0, -0.25, -3.0].map(whole),
            [(1, 0.75), (2, 0.0), (-1, 0.75), (-3, 0.0)]
        );
        for far in [f32::MAX, -f32::MAX, 3e9] {
            let (index, rest) = whole(far);
            assert!(rest == 0.0 && index.checked_add(1).is_some());
        }
    }

    #[test]
    fn texels_outside_are_wrapped() {
        let indices = |wrap| [-5, -1, 0, 2, 3, 7].map(|i| wrapped(i, 3, wrap));
        assert_eq!(indices(Wrap::Clamp), [0, 0, 0, 2, 2, 2]);
        assert_eq!(indices(Wrap::Repeat), [1, 2, 0, 2, 0, 1]);
        assert_eq!(indices(Wrap::Mirror), [1, 0, 0, 2, 2, 1]);
    }

    #[test]
    fn texels_are_where_they_should_be() {
        let nearest = picture(Interpolation::Nearest, Wrap::Repeat);
        assert_eq!(nearest.at(Vec2::new(0.2, 0.8)), Vec3::new(0.0, 1.0, 1.0));
        assert_eq!(nearest.at(Vec2::new(1.2, -0.8)), Vec3::new(0.0, 0.0, 1.0));
        let bilinear = picture(Interpolation::Bilinear, Wrap::Clamp);
        assert_eq!(bilinear.at(Vec2::new(0.25, 0.25)), Vec3::new(0.0, 0.0, 1.0));
        assert_eq!(bilinear.at(Vec2::new(0.5, 0.5)), Vec3::new(0.5, 0.5, 1.0));
        assert_eq!(bilinear.at(Vec2::new(-3.0, 9.0)), Vec3::new(0.0, 1.0, 1.0));
        let mirror = picture(Interpolation::Nearest, Wrap::Mirror);
        assert_eq!(mirror.at(Vec2::new(1.2, 0.2)), Vec3::new(1.0, 0.0, 1.0));
        assert_eq!(nearest.at(Vec2::NAN), Vec3::new(0.5, 0.5, 1.0));
        assert_eq!(nearest.range(), (0.0, 1.0));
        // Repeated pictures are continuous at their border.
        let repeated = picture(Interpolation::Bilinear, Wrap::Repeat);
        assert_eq!(repeated.at(Vec2::new(0.0, 0.25)), Vec3::new(0.5, 0.0, 1.0));
    }
}
