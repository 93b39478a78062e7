//! What is known of a coordinate's values.

/// The interval of the values of a coordinate; its ends may be infinite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The infimum.
    pub low: f64,
    /// The supremum.
    pub high: f64,
}

impl Range {
    /// Values from `low` to `high`.
    pub const fn new(low: f64, high: f64) -> Self {
        Range { low, high }
    }

    /// The interval between two values in either order.
    pub fn between(a: f64, b: f64) -> Self {
        Range { low: a.min(b), high: a.max(b) }
    }

    /// Whether both ends are finite.
    pub fn is_finite(self) -> bool {
        self.low.is_finite() && self.high.is_finite()
    }

    /// The distance of the ends.
    pub fn width(self) -> f64 {
        self.high - self.low
    }

    /// Whether all values lie in [`low`, `high`].
    pub fn within(self, low: f64, high: f64) -> bool {
        self.low >= low && self.high <= high
    }

    /// Values of k · x + c.
    pub fn affine(self, k: f64, c: f64) -> Self {
        Range::between(k * self.low + c, k * self.high + c)
    }

    /// Values of x + y.
    pub fn plus(self, other: Range) -> Self {
        Range::new(self.low + other.low, self.high + other.high)
    }

    /// Values of x · y; an infinite end times zero is zero.
    pub fn times(self, other: Range) -> Self {
        let product = |a: f64, b: f64| if a == 0.0 || b == 0.0 { 0.0 } else { a * b };
        let all = [
            product(self.low, other.low),
            product(self.low, other.high),
            product(self.high, other.low),
            product(self.high, other.high),
        ];
        all.into_iter()
            .skip(1)
            .fold(Range::new(all[0], all[0]), |r, x| Range::new(r.low.min(x), r.high.max(x)))
    }

    /// Values of a monotone function.
    pub fn monotone(self, f: impl Fn(f64) -> f64) -> Self {
        Range::between(f(self.low), f(self.high))
    }

    /// Values of |x|.
    pub fn size(self) -> Self {
        let (a, b) = (self.low.abs(), self.high.abs());
        let low = if self.low <= 0.0 && self.high >= 0.0 { 0.0 } else { a.min(b) };
        Range::new(low, a.max(b))
    }
}
