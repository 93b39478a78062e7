//! Values of one expression at several points, and arithmetic on them.
//!
//! This is where most of the compiler's time goes, and it runs unoptimised: loops are by index, and do as little as can
//! be for each point.

use crate::number::Number;
use crate::rational::Q;

/// A column of values: a vector, or an array of one where there is a single point.
pub trait Column<T>: AsRef<[T]> + AsMut<[T]> + Clone {}

impl<T, C: AsRef<[T]> + AsMut<[T]> + Clone> Column<T> for C {}

/// Sets all values.
pub fn set<T: Copy>(out: &mut [T], value: impl Fn(usize) -> T) {
    let mut k = 0;
    while k < out.len() {
        out[k] = value(k);
        k += 1;
    }
}

/// Adds a multiple.
pub fn add<T: Number>(out: &mut [T], coefficient: Q, term: &[T]) {
    let mut k = 0;
    if coefficient == Q::ONE {
        while k < out.len() {
            out[k] = out[k] + term[k];
            k += 1;
        }
        return;
    }
    let factor = T::from_ratio(coefficient.num(), coefficient.den());
    while k < out.len() {
        out[k] = out[k] + factor * term[k];
        k += 1;
    }
}

/// Multiplies by factors.
fn multiply<T: Number>(out: &mut [T], factor: &[T]) {
    let mut k = 0;
    while k < out.len() {
        out[k] = out[k] * factor[k];
        k += 1;
    }
}

/// What is multiplied, and what that is divided by: as in emitted code the latter is multiplied first, and may
/// underflow. Nothing stands for one.
pub struct Quotient<C> {
    top: Option<C>,
    bottom: Option<C>,
}

impl<C> Default for Quotient<C> {
    fn default() -> Self {
        Quotient { top: None, bottom: None }
    }
}

impl<C> Quotient<C> {
    /// Multiplies by b to the power q. `like` is any column of this length.
    pub fn push<T: Number>(&mut self, b: &[T], q: Q, like: &C)
    where
        C: Column<T>,
    {
        let times = q.num().abs();
        match q.den() {
            1 if times == 1 => return put(self.side(q), b, like),
            1 => {}
            2 | 3 if times < 64 => {}
            _ => {
                let exponent = T::from_ratio(q.num(), q.den());
                return self.raise(b, |_| exponent, like);
            }
        }
        let exponent = q.to_i32().map_or(i32::MAX, i32::abs);
        let mut power = like.clone();
        let out = power.as_mut();
        match q.den() {
            1 => set(out, |k| b[k].powi(exponent)),
            2 => set(out, |k| b[k].sqrt().powi(times as i32)),
            _ => set(out, |k| b[k].cbrt().powi(times as i32)),
        }
        put(self.side(q), power.as_ref(), like);
    }

    /// Multiplies by b to powers that differ from point to point.
    pub fn push_general<T: Number>(&mut self, b: &[T], exponents: &[T], like: &C)
    where
        C: Column<T>,
    {
        self.raise(b, |k| exponents[k], like);
    }

    fn raise<T: Number>(&mut self, b: &[T], exponent: impl Fn(usize) -> T, like: &C)
    where
        C: Column<T>,
    {
        let mut power = like.clone();
        set(power.as_mut(), |k| b[k].powf(exponent(k)));
        put(&mut self.top, power.as_ref(), like);
    }

    fn side(&mut self, q: Q) -> &mut Option<C> {
        if q.is_negative() { &mut self.bottom } else { &mut self.top }
    }

    /// The quotients.
    pub fn value<T: Number>(self, like: &C) -> C
    where
        C: Column<T>,
    {
        let mut top = self.top.unwrap_or_else(|| {
            let mut ones = like.clone();
            ones.as_mut().fill(T::from_f64(1.0));
            ones
        });
        if let Some(bottom) = self.bottom {
            let (out, by) = (top.as_mut(), bottom.as_ref());
            let mut k = 0;
            while k < out.len() {
                out[k] = out[k] / by[k];
                k += 1;
            }
        }
        top
    }
}

/// One more factor.
fn put<T: Number, C: Column<T>>(product: &mut Option<C>, factor: &[T], like: &C) {
    match product {
        Some(product) => multiply(product.as_mut(), factor),
        None => {
            let mut first = like.clone();
            first.as_mut().copy_from_slice(factor);
            *product = Some(first);
        }
    }
}
