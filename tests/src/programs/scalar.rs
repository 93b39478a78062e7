//! Steps on one coordinate.

use super::plan::{Number, Scalar};
use super::range::Range;
use super::scribe::{Scribe, literal};

impl Scribe {
    pub(super) fn scalar(&mut self, i: usize, step: &Scalar) {
        match *step {
            Scalar::Affine(k, c, form) => self.affine(i, k, c, form),
            Scalar::Power(k, form) => self.power(i, k, form),
            Scalar::Exponential(k, form) => self.exponential(i, k, form),
            Scalar::Wave(form) => self.wave(i, form),
            Scalar::Fold(form) => self.fold(i, form),
            Scalar::Branch(at, form) => self.branch(i, at, form),
        }
    }

    fn affine(&mut self, i: usize, k: Number, c: f64, form: u8) {
        let k = self.number_for(i, k);
        let range = self.range(i);
        let shift = Range::new(c, c);
        let minus_c = Range::new(-c, -c);
        let plus = |x: &str| match c {
            0.0 => x.to_owned(),
            c if c < 0.0 => format!("{x} - {}", literal(-c)),
            c => format!("{x} + {}", literal(c)),
        };
        let group = |text: String| if c == 0.0 { text } else { format!("({text})") };
        let lead = if c == 0.0 { String::new() } else { format!("{} + ", literal(c)) };
        let product = range.times(k.range);
        let x = self.operand(i);
        let (text, new) = match form {
            0 => (format!("{lead}{} * {x}", k.text), product.plus(shift)),
            1 if c != 0.0 => {
                (format!("{} - {} * {x}", literal(c), k.text), product.affine(-1.0, c))
            }
            2 => {
                let minus = if c == 0.0 { x } else { format!("{x} - {}", literal(c)) };
                let text = format!("{} / {}", group(minus.replace("- -", "+ ")), k.text);
                (text, range.plus(minus_c).times(k.range.monotone(f64::recip)))
            }
            3 => (format!("{} * {}", k.text, group(plus(&x))), range.plus(shift).times(k.range)),
            4 if range.within(0.0, 1.0) => {
                let x = self.name(i, "t");
                let low = literal(-c.abs());
                let text = if c == 0.0 {
                    format!("{x} * {}", k.text)
                } else {
                    format!("(1.0 - {x}) * {low} + {x} * {}", k.text)
                };
                (text, Range::new(-c.abs(), k.range.high))
            }
            _ => (plus(&format!("{} * {x}", k.text)), product.plus(shift)),
        };
        self.set(i, text, new);
    }

    fn power(&mut self, i: usize, k: Number, form: u8) {
        if self.range(i).low < 0.0 && !matches!(form, 1 | 2) && !self.fit(i, 0.0, 2.0) {
            return;
        }
        if self.range(i).size().high > 12.0 && form != 0 && !self.fit(i, 0.0, 2.0) {
            return;
        }
        let k = self.number_for(i, k);
        let range = self.range(i);
        let x = self.operand(i);
        match form {
            0 => self.set_call(i, format!("{x}.sqrt()"), range.monotone(f64::sqrt)),
            1 => self.set_call(i, format!("{x}.cbrt()"), range.monotone(f64::cbrt)),
            2 => self.set_call(i, format!("{x}.powi(3)"), range.monotone(|x| x.powi(3))),
            3 => {
                let x = self.name(i, "s");
                self.set(i, format!("{x} * {x}"), range.monotone(|x| x * x));
            }
            4 => {
                let k_high = k.range.high;
                let low = range.low.powf(k.range.low).min(range.low.powf(k_high));
                let high = range.high.powf(k.range.low).max(range.high.powf(k_high));
                self.set_call(i, format!("{x}.powf({})", k.text), Range::new(low, high));
            }
            5 => {
                let reciprocal = k.range.monotone(f64::recip);
                let powers = [range.low, range.high].map(|x| {
                    let (a, b) = (x.powf(reciprocal.low), x.powf(reciprocal.high));
                    (a.min(b), a.max(b))
                });
                let new = Range::new(powers[0].0, powers[1].1);
                self.set_call(i, format!("{x}.powf(1.0 / {})", k.text), new);
            }
            _ => {
                let one = Range::new(1.0, 1.0);
                self.set(
                    i,
                    format!("{} / (1.0 + {x})", k.text),
                    range.plus(one).monotone(f64::recip).times(k.range),
                );
            }
        }
    }

    fn exponential(&mut self, i: usize, k: Number, form: u8) {
        let k = self.number_for(i, k);
        // The argument of each function, from what is there.
        let fits = match form {
            0 | 1 | 7 => self.fit(i, -2.0, 2.0),
            2 | 3 | 5 | 8 => self.fit(i, 0.0, 1.0),
            4 => self.range(i).low >= 0.0 || self.fit(i, 0.0, 2.0),
            _ => true,
        };
        if !fits {
            return;
        }
        let range = self.range(i);
        let x = self.operand(i);
        match form {
            0 => self.set_call(i, format!("{x}.exp()"), range.monotone(f64::exp)),
            1 => self.set(
                i,
                format!("{x}.exp_m1() / {}", k.text),
                range.monotone(f64::exp_m1).times(k.range.monotone(f64::recip)),
            ),
            2 => self.set(
                i,
                format!("-(-{x}).ln_1p() / {}", k.text),
                range.monotone(|x| -(-x).ln_1p()).times(k.range.monotone(f64::recip)),
            ),
            3 => self.set(
                i,
                format!("-{} * (1.0 - {x}).ln()", k.text),
                range.monotone(|x| -(-x).ln_1p()).times(k.range),
            ),
            4 => self.set(
                i,
                format!("{} * {x}.ln_1p()", k.text),
                range.monotone(f64::ln_1p).times(k.range),
            ),
            5 => {
                let x = self.name(i, "t");
                self.set_call(
                    i,
                    format!("({x} / (1.0 - {x})).ln()"),
                    range.monotone(|x| (x / (1.0 - x)).ln()),
                );
            }
            6 => self.set_call(i, format!("{x}.tanh()"), range.monotone(f64::tanh)),
            7 => self.set_call(
                i,
                format!("({} * {x}).sinh()", k.text),
                range.times(k.range).monotone(f64::sinh),
            ),
            8 => {
                // The exponential distribution cut at k.
                let end = Range::new(0.0, k.range.high);
                self.set(i, format!("-({x} * (-{}).exp_m1()).ln_1p()", k.text), end);
            }
            _ => self.set_call(i, format!("{x}.atan()"), range.monotone(f64::atan)),
        }
    }

    fn wave(&mut self, i: usize, form: u8) {
        let unit = if matches!(form, 0 | 3) { (-0.5, 0.5) } else { (0.0, 1.0) };
        if !self.fit(i, unit.0, unit.1) {
            return;
        }
        let x = self.operand(i);
        let pi = std::f64::consts::PI;
        let range = self.range(i);
        match form {
            0 => self.set_call(i, format!("(PI * {x}).sin()"), range.monotone(|x| (pi * x).sin())),
            1 => self.set_call(i, format!("(PI * {x}).cos()"), range.monotone(|x| (pi * x).cos())),
            2 => self.set_call(i, format!("(PI * {x}).sin()"), Range::new(0.0, 1.0)),
            3 => self.set_call(
                i,
                format!("(0.75 * PI * {x}).tan()"),
                range.monotone(|x| (0.75 * pi * x).tan()),
            ),
            4 => self.set_call(i, format!("(TAU * {x}).cos()"), Range::new(-1.0, 1.0)),
            _ => self.set_call(
                i,
                format!("(2.0 * {x} - 1.0).asin()"),
                range.monotone(|x| (2.0 * x - 1.0).asin()),
            ),
        }
    }

    fn fold(&mut self, i: usize, form: u8) {
        if !self.exact(i) {
            return;
        }
        let range = self.range(i);
        if !range.is_finite() {
            if range.low < 0.0 && range.high > 0.0 {
                let x = self.operand(i);
                self.set_call(i, format!("{x}.abs()"), range.size());
            }
            return;
        }
        let middle = literal(((range.low + 0.4 * range.width()) * 10.0).round() / 10.0);
        let moved = range.affine(1.0, -middle.parse().unwrap_or(0.0));
        let x = self.operand(i);
        let shifted = format!("({x} - {middle})").replace("- -", "+ ");
        match form {
            0 => self.set_call(i, format!("{shifted}.abs()"), moved.size()),
            1 => {
                let x = self.bind("d", &shifted[1..shifted.len() - 1]);
                self.set(i, format!("{x} * {x}"), Range::new(0.0, moved.size().high.powi(2)));
            }
            2 if self.fit_exactly(i, 0.0, 1.0) => {
                let x = self.operand(i);
                self.set_call(i, format!("(3.0 * {x}).fract()"), Range::new(0.0, 1.0));
            }
            3 if self.fit_exactly(i, 0.0, 1.0) => {
                let x = self.name(i, "t");
                self.set_call(i, format!("{x}.max(1.0 - {x})"), Range::new(0.5, 1.0));
            }
            _ => {
                let x = self.operand(i);
                let shifted = format!("({x} - {middle})").replace("- -", "+ ");
                self.set_call(
                    i,
                    format!("{shifted}.cosh()"),
                    Range::new(1.0, moved.size().high.cosh()),
                );
            }
        }
    }

    /// Below and above a threshold.
    fn branch(&mut self, i: usize, at: f64, form: u8) {
        let straddled = self.range(i).low < at - 0.1 && self.range(i).high > at + 0.1;
        if !self.exact(i)
            || (!straddled || self.range(i).low < 0.0 || self.range(i).high > 1.0)
                && !self.fit_exactly(i, 0.0, 1.0)
        {
            return;
        }
        let x = self.name(i, "t");
        let c = literal(at);
        let rest = literal(1.0 - at);
        let (low, high, ends) = match form {
            0 => (
                format!("({x} / {c}).sqrt() - 1.0"),
                format!("(({x} - {c}) / {rest}).sqrt()"),
                (-1.0, 1.0),
            ),
            1 => (format!("2.0 * {x}"), format!("0.5 - {x}"), (-0.5, 2.0 * at)),
            2 => (format!("({x} / {c}).powi(2)"), format!("1.0 + {x}"), (0.0, 2.0)),
            3 => (format!("-(1.0 - {x} / {c}).ln_1p()"), format!("{x} - {c}"), (-1.0, 1.0)),
            4 => (format!("-{x}"), format!("{x}.exp()"), (-at, 1.0_f64.exp())),
            _ => (format!("0.5 * {x}"), format!("3.0 * {x} - 0.25"), (0.0, 2.75)),
        };
        let text = if self.coin() {
            format!("if {x} < {c} {{ {low} }} else {{ {high} }}")
        } else {
            format!("match {x} < {c} {{ true => {low}, false => {high} }}")
        };
        self.set(i, text, Range::new(ends.0, ends.1));
    }
}
