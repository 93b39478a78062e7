//! Steps on two coordinates, and the last ones, to a point of a space.

use super::plan::{Finish, Number, Pair, Turn};
use super::range::Range;
use super::scribe::{Scribe, literal};

/// Rational points of the unit circle, cosine and sine.
const CIRCLE: [(f64, f64); 3] = [(0.8, 0.6), (0.6, 0.8), (0.28, 0.96)];
/// Vectors of length one.
const NORMALS: [&str; 3] =
    ["Vec3::new(0.6, 0.0, 0.8)", "Vec3::new(2.0, 1.0, 2.0) / 3.0", "Vec3::new(0.48, 0.64, 0.6)"];
/// Vectors shorter than one.
const OFFSETS: [&str; 3] =
    ["Vec3::new(0.0, 0.0, 0.5)", "Vec3::new(0.3, -0.2, 0.4)", "Vec3::new(-0.4, 0.1, 0.0)"];

impl Scribe {
    pub(super) fn pair(&mut self, i: usize, j: usize, step: &Pair) {
        self.pair_of(i, j, step);
        self.inexact(i);
        self.inexact(j);
    }

    fn pair_of(&mut self, i: usize, j: usize, step: &Pair) {
        match *step {
            Pair::Polar(form) => self.polar(i, j, form),
            Pair::Rotate(k, form) => {
                let (s, c) = self.sine_and_cosine(k, form);
                self.combine(i, j, |x, y| {
                    [format!("{c} * {x} - {s} * {y}"), format!("{s} * {x} + {c} * {y}")]
                });
            }
            Pair::Reflect(0) => {
                self.combine(i, j, |x, y| {
                    [format!("0.28 * {x} + 0.96 * {y}"), format!("0.96 * {x} - 0.28 * {y}")]
                });
            }
            Pair::Reflect(_) => self.reflect_plane(i, j),
            Pair::Shear(k, form) => self.shear(i, j, k, form),
            Pair::Triangle => self.triangle(i, j),
            Pair::Branch(form) => self.cut(i, j, form),
            Pair::Fold => {
                if !self.exact(i) || !self.exact(j) {
                    return;
                }
                self.fit_exactly(i, 0.0, 1.0);
                self.fit_exactly(j, 0.0, 1.0);
                let both = self.hull(i, j);
                let (x, y) = (self.name(i, "x"), self.name(j, "y"));
                self.set_call(i, format!("{x}.max({y})"), both);
                self.set_call(j, format!("{x}.min({y})"), both);
            }
        }
    }

    fn hull(&self, i: usize, j: usize) -> Range {
        let (x, y) = (self.range(i), self.range(j));
        Range::new(x.low.min(y.low), x.high.max(y.high))
    }

    fn sine_and_cosine(&mut self, k: Number, form: u8) -> (String, String) {
        let (s, c) = (self.fresh("s"), self.fresh("c"));
        if form == 0 {
            let place = self.coin() as usize + self.coin() as usize;
            let (cos, sin) = CIRCLE[place];
            self.line(format!("let ({s}, {c}) = ({}, {});", literal(sin), literal(cos)));
        } else {
            let k = self.number(k);
            let angle = if k.range.width() > 0.0 { k.text } else { format!("({} * PI)", k.text) };
            self.line(format!("let ({s}, {c}) = {angle}.sin_cos();"));
        }
        (s, c)
    }

    /// Two linear combinations with coefficients up to one.
    fn combine(&mut self, i: usize, j: usize, texts: impl Fn(&str, &str) -> [String; 2]) {
        let reach = self.range(i).size().high + self.range(j).size().high;
        let (x, y) = (self.name(i, "x"), self.name(j, "y"));
        let [first, second] = texts(&x, &y);
        self.set(i, first, Range::new(-reach, reach));
        self.set(j, second, Range::new(-reach, reach));
    }

    fn reflect_plane(&mut self, i: usize, j: usize) {
        let reach = self.range(i).size().high + self.range(j).size().high;
        let (x, y) = (self.text(i), self.text(j));
        let n = self.bind("n", "Vec2::new(0.6, 0.8)");
        let v = self.bind("v", &format!("Vec2::new({x}, {y})"));
        let w = self.bind("w", &format!("{v} - 2.0 * {v}.dot({n}) * {n}"));
        self.set_call(i, format!("{w}.x"), Range::new(-reach, reach));
        self.set_call(j, format!("{w}.y"), Range::new(-reach, reach));
    }

    fn polar(&mut self, i: usize, j: usize, form: u8) {
        if self.range(i).low < 0.0 && !self.fit(i, 0.0, 2.0) {
            return;
        }
        let tau = std::f64::consts::TAU;
        if !self.range(j).is_finite() || self.range(j).width() > tau {
            self.fit(j, 0.0, 1.0);
        }
        let r = if form == 1 && self.range(i).within(0.0, 1.0) {
            let x = self.operand(i);
            self.bind("r", &format!("{x}.sqrt()"))
        } else {
            let x = self.text(i);
            self.bind("r", &x)
        };
        let t = self.operand(j);
        let phi = match self.range(j) {
            range if range.within(0.0, 1.0) => format!("TAU * {t}"),
            range if range.within(-1.0, 1.0) => format!("PI * {t}"),
            _ => t,
        };
        let phi = self.bind("phi", &phi);
        let reach = self.range(i).high.max(1.0);
        let full = Range::new(-reach, reach);
        if form == 2 {
            let (s, c) = (self.fresh("sin"), self.fresh("cos"));
            self.line(format!("let ({s}, {c}) = {phi}.sin_cos();"));
            self.set(i, format!("{r} * {c}"), full);
            self.set(j, format!("{r} * {s}"), full);
        } else {
            self.set(i, format!("{r} * {phi}.cos()"), full);
            self.set(j, format!("{r} * {phi}.sin()"), full);
        }
    }

    fn shear(&mut self, i: usize, j: usize, k: Number, form: u8) {
        let k = self.number(k);
        let (ri, rj) = (self.range(i), self.range(j));
        let x = self.name(i, "x");
        let y = self.operand(j);
        match form {
            0 => self.set(j, format!("{y} + {} * {x}", k.text), rj.plus(ri.times(k.range))),
            1 if ri.is_finite() => {
                let size = ri.size();
                let square = Range::new(size.low * size.low, size.high * size.high);
                self.set(
                    j,
                    format!("{y} + {} * {x} * {x}", k.text),
                    rj.plus(square.times(k.range)),
                );
            }
            2 if ri.low >= 0.0 => {
                let stretch = ri.plus(Range::new(1.0, 1.0));
                self.set(j, format!("{y} * (1.0 + {x})"), rj.times(stretch));
            }
            3 if ri.low >= 0.0 => {
                let stretch = ri.plus(k.range);
                self.set(
                    j,
                    format!("{y} / ({} + {x})", k.text),
                    rj.times(stretch.monotone(f64::recip)),
                );
            }
            _ if ri.is_finite() => {
                self.set(j, format!("{y} - (2.0 * {x}).sin()"), rj.plus(Range::new(-1.0, 1.0)));
            }
            _ => self.set(j, format!("{y} - {x}"), rj.plus(ri.affine(-1.0, 0.0))),
        }
    }

    fn triangle(&mut self, i: usize, j: usize) {
        if !self.fit(i, 0.0, 1.0) || !self.fit(j, 0.0, 1.0) {
            return;
        }
        let (x, y) = (self.operand(i), self.operand(j));
        let root = self.bind("root", &format!("{x}.sqrt()"));
        let unit = Range::new(0.0, 1.0);
        self.set(i, format!("1.0 - {root}"), unit);
        self.set(j, format!("{y} * {root}"), unit);
    }

    /// Pieces that are moved and stretched differently; some of them overlap.
    fn cut(&mut self, i: usize, j: usize, form: u8) {
        if !self.exact(i) || !self.exact(j) {
            return;
        }
        let low = if form == 3 { -1.0 } else { 0.0 };
        self.fit_exactly(i, low, 1.0);
        self.fit_exactly(j, low, 1.0);
        let (x, y) = (self.name(i, "x"), self.name(j, "y"));
        let (test, low, high) = match form {
            0 => (format!("{x} < {y}"), format!("({x}, {y})"), format!("({x} + 1.0, 2.0 * {y})")),
            1 => (
                format!("{x} + {y} < 0.6"),
                format!("({x}, {y})"),
                format!("(0.6 - {y}, 0.6 - {x})"),
            ),
            2 => (
                format!("{y} > 0.3"),
                format!("({x} + {y}, {y})"),
                format!("({x} - {y}, 1.5 * {y})"),
            ),
            _ => (
                format!("{x} < 0.5 && {y} < 0.5"),
                format!("(2.0 * {x}, {y})"),
                format!("({y}, {x} + 2.0)"),
            ),
        };
        let (p, q) = (self.fresh("p"), self.fresh("q"));
        self.line(format!("let ({p}, {q}) = if {test} {{ {low} }} else {{ {high} }};"));
        self.set_call(i, p, Range::new(-2.0, 2.0));
        self.set_call(j, q, Range::new(-2.0, 3.0));
    }

    /// The result as an expression.
    pub(super) fn finish(&mut self, finish: &Finish) -> String {
        match finish {
            Finish::Flat(1, _) => self.text(0),
            Finish::Flat(2, _) => format!("Vec2::new({}, {})", self.text(0), self.text(1)),
            Finish::Flat(_, turns) => {
                let v = format!("Vec3::new({}, {}, {})", self.text(0), self.text(1), self.text(2));
                self.turns(v, turns, false)
            }
            Finish::Direction(form, turns) => {
                let v = self.on_sphere(*form);
                let w = self.turns(v, turns, true);
                match w.strip_prefix("Vec3::new") {
                    Some(arguments) if !w.ends_with("normalize()") => {
                        format!("Direction::new{arguments}")
                    }
                    _ => format!("Direction::from_vec({w})"),
                }
            }
            Finish::Surface(form, turns) => {
                let v = self.on_surface(*form);
                let w = self.turns(v, turns, false);
                format!("Surface::from_vec({w})")
            }
        }
    }

    /// The sine and the cosine of the second coordinate, as an angle of up to one turn.
    fn angle(&mut self, i: usize) -> String {
        if self.range(i).is_finite()
            && self.range(i).width() <= 6.25
            && !self.range(i).within(0.0, 1.0)
        {
            return self.name(i, "phi");
        }
        self.fit(i, 0.0, 1.0);
        let t = self.operand(i);
        self.bind("phi", &format!("TAU * {t}"))
    }

    /// A unit vector.
    fn on_sphere(&mut self, form: u8) -> String {
        match form {
            0 => {
                if self.exact(0) && self.coin() {
                    self.fit_exactly(0, -1.0, 1.0);
                }
                self.fit(0, -1.0, 1.0);
                self.straddles = self.exact(0) && self.range(0).low < -0.1;
                let z = self.name(0, "z");
                let r = self.bind("r", &format!("(1.0 - {z} * {z}).sqrt()"));
                let phi = self.angle(1);
                format!("Vec3::new({r} * {phi}.cos(), {r} * {phi}.sin(), {z})")
            }
            1 => {
                self.fit(0, 0.0, 1.0);
                self.straddles =
                    self.exact(0) && self.range(0).low < 0.4 && self.range(0).high > 0.6;
                let t = self.operand(0);
                let theta = self.bind("theta", &format!("PI * {t}"));
                let phi = self.angle(1);
                format!(
                    "Vec3::new({theta}.sin() * {phi}.cos(), {theta}.sin() * {phi}.sin(), {theta}.cos())"
                )
            }
            2 => format!("Vec3::new({}, {}, 1.0).normalize()", self.text(0), self.text(1)),
            _ => {
                let (x, y) = (self.text(0), self.text(1));
                format!("Vec3::new({x}, 1.5, {y}).normalize()")
            }
        }
    }

    /// A point of a surface.
    fn on_surface(&mut self, form: u8) -> String {
        match form {
            0 => {
                self.fit(0, -2.0, 2.0);
                self.fit(1, -2.0, 2.0);
                let (x, y) = (self.name(0, "x"), self.name(1, "y"));
                format!("Vec3::new({x}, {y}, 0.5 * ({x} * {x} + {y} * {y}))")
            }
            1 => {
                let phi = self.angle(0);
                let z = self.text(1);
                format!("Vec3::new(1.5 * {phi}.cos(), 1.5 * {phi}.sin(), {z})")
            }
            2 => {
                let v = self.on_sphere(0);
                format!("2.0 * {v}")
            }
            3 => {
                let (x, y) = (self.name(0, "x"), self.name(1, "y"));
                format!("Vec3::new({x}, {y}, 1.0 - {x} - 0.5 * {y})")
            }
            4 => {
                let phi = self.angle(0);
                let psi = self.angle(1);
                let r = self.bind("r", &format!("2.0 + 0.5 * {psi}.cos()"));
                format!("Vec3::new({r} * {phi}.cos(), {r} * {phi}.sin(), 0.5 * {psi}.sin())")
            }
            _ => {
                self.fit(0, -2.0, 2.0);
                let (x, y) = (self.name(0, "x"), self.text(1));
                format!("Vec3::new({x}, {y}, (2.0 * {x}).sin())")
            }
        }
    }

    /// Turns a vector; one of length one is normalised where it would lose that.
    fn turns(&mut self, vector: String, turns: &[Turn], unit: bool) -> String {
        let mut v = vector;
        for (place, turn) in turns.iter().enumerate() {
            // Both halves have to be reached.
            let straddles = place == 0 && self.straddles;
            if *turn != Turn::Fold || straddles {
                v = self.turn(v, turn, unit);
            }
        }
        v
    }

    fn turn(&mut self, vector: String, turn: &Turn, unit: bool) -> String {
        let v = self.bind("v", &vector);
        let end = |text: String| if unit { format!("({text}).normalize()") } else { text };
        match *turn {
            Turn::Rotate(axis, k, form) => {
                let (s, c) = self.sine_and_cosine(k, form);
                let [i, j] = [["y", "z"], ["z", "x"], ["x", "y"]][axis];
                let turned = |name: &str| match name {
                    n if n == i => format!("{c} * {v}.{i} - {s} * {v}.{j}"),
                    n if n == j => format!("{s} * {v}.{i} + {c} * {v}.{j}"),
                    n => format!("{v}.{n}"),
                };
                format!("Vec3::new({}, {}, {})", turned("x"), turned("y"), turned("z"))
            }
            Turn::Reflect(i) => {
                let n = self.bind("n", NORMALS[i]);
                format!("{v} - 2.0 * {v}.dot({n}) * {n}")
            }
            Turn::Frame => format!("{}.to_world({v})", self.frame()),
            Turn::Stretch(a, b) => {
                let (a, b) = (self.number(a), self.number(b));
                let stretched = format!("Vec3::new({} * {v}.x, {} * {v}.y, {v}.z)", a.text, b.text);
                if unit { format!("{stretched}.normalize()") } else { stretched }
            }
            Turn::Shift(i) => end(format!("{v} + {}", OFFSETS[i])),
            Turn::Fold => format!("Vec3::new({v}.x, {v}.y, {v}.z.abs())"),
            Turn::Half(i) => {
                let o = self.bind("o", NORMALS[i]);
                if unit {
                    format!("2.0 * {o}.dot({v}) * {v} - {o}")
                } else {
                    format!("{o}.cross({v}) + 2.0 * {v}")
                }
            }
        }
    }
}
