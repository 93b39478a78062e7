//! Pictures in as few bits as their files have.

use super::RgbImage;

/// A picture of linear Rec. 709 colours, row by row from the top left corner. What has eight bits a channel in
/// its file keeps them: textures are larger than caches, and reading them takes longer than decoding.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    width: usize,
    height: usize,
    texels: Texels,
}

/// What the texels of a [`Picture`] are.
#[derive(Clone, Debug, PartialEq)]
pub enum Texels {
    /// Codes, and the value of each.
    Codes(Vec<[u8; 3]>, Box<[f32; 256]>),
    /// The colours themselves.
    Numbers(Vec<[f32; 3]>),
}

impl Picture {
    /// A picture of some columns and rows; `None` if texels are not as many.
    pub fn new((width, height): (usize, usize), texels: Texels) -> Option<Self> {
        let count = match &texels {
            Texels::Codes(codes, _) => codes.len(),
            Texels::Numbers(numbers) => numbers.len(),
        };
        (count == width * height).then_some(Picture { width, height, texels })
    }

    /// Number of columns.
    #[inline]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Number of rows.
    #[inline]
    pub fn height(&self) -> usize {
        self.height
    }

    /// The colour in column `x` and row `y`.
    ///
    /// # Panics
    /// If the position is outside the picture.
    #[inline]
    pub fn texel(&self, x: usize, y: usize) -> [f32; 3] {
        assert!(x < self.width, "column {x} of a picture {} texels wide", self.width);
        self.nth(y * self.width + x)
    }

    /// The colours in two columns of two rows, from left to right and from top to bottom.
    ///
    /// # Panics
    /// If one of them is outside the picture.
    #[inline]
    pub fn square(&self, [left, right]: [usize; 2], rows: [usize; 2]) -> [[[f32; 3]; 2]; 2] {
        assert!(left.max(right) < self.width, "columns of a picture {} texels wide", self.width);
        let [upper, lower] = rows.map(|y| y * self.width);
        // What texels are is asked once.
        match &self.texels {
            Texels::Codes(codes, values) => {
                let at = |index: usize| decoded(codes[index], values);
                let row = |first: usize| [at(first + left), at(first + right)];
                [row(upper), row(lower)]
            }
            Texels::Numbers(numbers) => {
                let row = |first: usize| [numbers[first + left], numbers[first + right]];
                [row(upper), row(lower)]
            }
        }
    }

    #[inline]
    fn nth(&self, index: usize) -> [f32; 3] {
        match &self.texels {
            Texels::Codes(codes, values) => decoded(codes[index], values),
            Texels::Numbers(numbers) => numbers[index],
        }
    }

    /// All colours, row by row from the top.
    pub fn texels(&self) -> impl ExactSizeIterator<Item = [f32; 3]> {
        (0..self.width * self.height).map(|index| self.nth(index))
    }

    /// The same as an image.
    pub fn into_image(self) -> RgbImage {
        let Picture { width, height, .. } = self;
        let pixels = match self.texels {
            Texels::Numbers(numbers) => numbers,
            Texels::Codes(..) => self.texels().collect(),
        };
        RgbImage { width, height, pixels }
    }
}

/// The values of codes.
#[inline(always)]
fn decoded(codes: [u8; 3], values: &[f32; 256]) -> [f32; 3] {
    let [r, g, b] = codes.map(usize::from);
    [values[r], values[g], values[b]]
}

impl From<RgbImage> for Picture {
    fn from(RgbImage { width, height, pixels }: RgbImage) -> Self {
        Picture { width, height, texels: Texels::Numbers(pixels) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_have_their_values() {
        let values = Box::new(std::array::from_fn(|code| code as f32 / 255.0));
        let codes = Texels::Codes(vec![[0, 51, 255], [255, 0, 0]], values);
        assert_eq!(Picture::new((2, 2), codes.clone()), None);
        let picture = Picture::new((2, 1), codes).unwrap();
        assert_eq!((picture.texel(0, 0), picture.texel(1, 0)), ([0.0, 0.2, 1.0], [1.0, 0.0, 0.0]));
        assert_eq!(picture.square([1, 0], [0, 0]), [[picture.texel(1, 0), picture.texel(0, 0)]; 2]);
        let image = picture.clone().into_image();
        assert_eq!(image.pixels(), picture.texels().collect::<Vec<_>>());
        assert_eq!(Picture::from(image.clone()).into_image(), image);
    }
}
