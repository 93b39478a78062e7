//! Writes a plan as a function: the coordinates so far, their ranges, and the statements.

use std::fmt::Write;

use super::plan::{Finish, Number, Plan, Step};
use super::range::Range;

/// A program of the language.
#[derive(Clone, Debug, PartialEq)]
pub struct Program {
    /// What stands in the attribute: `a in 0.5..=2.0`.
    pub attribute: String,
    /// The signature after the name and the body.
    pub text: String,
    /// Which of the parameters `a`, `b` and `frame` it has.
    pub parameters: Vec<&'static str>,
    /// How many uniforms.
    pub uniforms: usize,
    /// The type of the result.
    pub space: &'static str,
}

impl Program {
    /// The item with its attribute.
    pub fn item(&self, name: &str) -> String {
        let attribute = match self.attribute.as_str() {
            "" => "#[sampler]".to_owned(),
            domains => format!("#[sampler({domains})]"),
        };
        format!("{attribute}\npub fn {name}{}", self.text)
    }
}

/// A coordinate: how it is written, and what values it has.
#[derive(Clone, Debug)]
pub(super) struct Coordinate {
    pub(super) text: String,
    /// Whether the text can be an operand without parentheses.
    pub(super) atomic: bool,
    pub(super) range: Range,
    /// Whether values come close to both ends, whatever the parameters and other coordinates are.
    pub(super) exact: bool,
}

/// A number in a program, with its possible values.
#[derive(Clone, Debug)]
pub(super) struct Written {
    pub(super) text: String,
    pub(super) range: Range,
}

/// The program so far.
pub(super) struct Scribe {
    pub(super) coordinates: Vec<Coordinate>,
    lines: Vec<String>,
    used: Vec<(String, usize)>,
    parameters: [bool; 3],
    names: u32,
    /// Whether the point of space that is being made lies on both sides of the plane z = 0.
    pub(super) straddles: bool,
}

/// Where the parameters `a` and `b` lie.
pub(super) const PARAMETER: Range = Range::new(0.5, 2.0);
const PARAMETERS: [&str; 3] = ["a", "b", "frame"];

/// A number as Rust writes it.
pub(super) fn literal(x: f64) -> String {
    format!("{x:?}")
}

impl Scribe {
    fn new(uniforms: usize, names: u32) -> Self {
        let coordinates = (0..uniforms)
            .map(|i| Coordinate {
                text: format!("u[{i}]"),
                atomic: true,
                range: Range::new(0.0, 1.0),
                exact: true,
            })
            .collect();
        Scribe {
            coordinates,
            lines: vec![],
            used: vec![],
            parameters: [false; 3],
            names,
            straddles: false,
        }
    }

    /// The next of the plan's coin flips.
    pub(super) fn coin(&mut self) -> bool {
        let heads = self.names & 1 == 1;
        self.names = self.names.rotate_right(1);
        heads
    }

    /// A number that changes coordinate i.
    pub(super) fn number_for(&mut self, i: usize, number: Number) -> Written {
        if matches!(number, Number::Parameter(_)) {
            self.inexact(i);
        }
        self.number(number)
    }

    pub(super) fn number(&mut self, number: Number) -> Written {
        match number {
            Number::Constant(x) => Written { text: literal(x), range: Range::new(x, x) },
            Number::Parameter(i) => {
                self.parameters[i] = true;
                Written { text: PARAMETERS[i].to_owned(), range: PARAMETER }
            }
        }
    }

    /// The parameter `frame`.
    pub(super) fn frame(&mut self) -> &'static str {
        self.parameters[2] = true;
        PARAMETERS[2]
    }

    /// A name that nothing has yet.
    pub(super) fn fresh(&mut self, hint: &str) -> String {
        match self.used.iter_mut().find(|(name, _)| name == hint) {
            Some((_, count)) => {
                *count += 1;
                format!("{hint}{count}")
            }
            None => {
                self.used.push((hint.to_owned(), 0));
                hint.to_owned()
            }
        }
    }

    pub(super) fn line(&mut self, line: String) {
        self.lines.push(line);
    }

    /// `let hint = text;`: the name that was given.
    pub(super) fn bind(&mut self, hint: &str, text: &str) -> String {
        let name = self.fresh(hint);
        self.line(format!("let {name} = {text};"));
        name
    }

    /// Notes that the values of coordinate i need not reach the ends of its range.
    pub(super) fn inexact(&mut self, i: usize) {
        self.coordinates[i].exact = false;
    }

    /// Whether the values of coordinate i reach the ends of its range.
    pub(super) fn exact(&self, i: usize) -> bool {
        self.coordinates[i].exact
    }

    pub(super) fn range(&self, i: usize) -> Range {
        self.coordinates[i].range
    }

    /// Coordinate i as an operand.
    pub(super) fn operand(&self, i: usize) -> String {
        let Coordinate { text, atomic, .. } = &self.coordinates[i];
        if *atomic { text.clone() } else { format!("({text})") }
    }

    /// Coordinate i where a whole expression may stand.
    pub(super) fn text(&self, i: usize) -> String {
        self.coordinates[i].text.clone()
    }

    /// Coordinate i by a name, to be used more than once.
    pub(super) fn name(&mut self, i: usize, hint: &str) -> String {
        let text = self.text(i);
        if self.coordinates[i].atomic && !text.contains(['(', '.']) {
            return text;
        }
        let name = self.bind(hint, &text);
        self.coordinates[i].text.clone_from(&name);
        self.coordinates[i].atomic = true;
        name
    }

    /// Coordinate i becomes a sum, product or branch.
    pub(super) fn set(&mut self, i: usize, text: String, range: Range) {
        self.put(i, text, false, range);
    }

    /// Coordinate i becomes the value of a call.
    pub(super) fn set_call(&mut self, i: usize, text: String, range: Range) {
        self.put(i, text, true, range);
    }

    fn put(&mut self, i: usize, text: String, atomic: bool, range: Range) {
        let long = text.len() > 48 || text.contains('{');
        let exact = self.coordinates[i].exact;
        self.coordinates[i] = Coordinate { text, atomic, range, exact };
        if long || self.coin() {
            self.name(i, ["x", "y", "z"][i]);
        }
    }

    /// Moves a finite range into [low, high] unless it lies there already.
    pub(super) fn fit(&mut self, i: usize, low: f64, high: f64) -> bool {
        let range = self.range(i);
        if range.within(low, high) {
            return true;
        }
        if !range.is_finite() {
            return self.squash(i) && self.fit(i, low, high);
        }
        let digits = |x: f64| (x * 100.0).floor() / 100.0;
        let scale = digits((high - low) / range.width()).max(0.01);
        let shift = ((low - scale * range.low) * 100.0).ceil() / 100.0;
        if scale * range.high + shift > high + 1e-12 {
            return self.fit_exactly(i, low, high);
        }
        let x = self.operand(i);
        let text = match (scale == 1.0, shift) {
            (true, s) if s < 0.0 => format!("{x} - {}", literal(-s)),
            (true, s) => format!("{} + {x}", literal(s)),
            (false, 0.0) => format!("{} * {x}", literal(scale)),
            (false, s) => format!("{} * {x} + {}", literal(scale), literal(s)),
        };
        self.set(i, text.replace("+ -", "- "), range.affine(scale, shift));
        true
    }

    /// Maps a range to [low, high].
    pub(super) fn fit_exactly(&mut self, i: usize, low: f64, high: f64) -> bool {
        let range = self.range(i);
        if !range.is_finite() {
            return self.squash(i) && self.fit_exactly(i, low, high);
        }
        if range == Range::new(low, high) {
            return true;
        }
        let x = self.operand(i);
        let from = match range.low {
            0.0 => x,
            low if low < 0.0 => format!("({x} + {})", literal(-low)),
            low => format!("({x} - {})", literal(low)),
        };
        let width = literal(range.width());
        let text = match (low, high - low) {
            (0.0, 1.0) => format!("{from} / {width}"),
            (0.0, wide) => format!("{} * {from} / {width}", literal(wide)),
            (low, wide) => format!("{} * {from} / {width} + {}", literal(wide), literal(low)),
        };
        let text = text.replace("+ -", "- ");
        self.set(i, text, Range::new(low, high));
        true
    }

    /// Makes an infinite range finite.
    fn squash(&mut self, i: usize) -> bool {
        let range = self.range(i);
        if range.low >= 0.0 {
            let x = self.name(i, "t");
            self.set(
                i,
                format!("{x} / (1.0 + {x})"),
                range.monotone(|x| if x.is_infinite() { 1.0 } else { x / (1.0 + x) }),
            );
        } else if range.high <= 0.0 {
            let x = self.operand(i);
            self.set_call(i, format!("{x}.exp()"), range.monotone(f64::exp));
        } else {
            let x = self.operand(i);
            self.set_call(i, format!("{x}.atan()"), range.monotone(f64::atan));
        }
        true
    }

    /// Keeps values of moderate size.
    fn tame(&mut self, i: usize) {
        let range = self.range(i);
        let large = range.is_finite() && range.size().high > 12.0;
        if large {
            self.fit(i, if range.low >= 0.0 { 0.0 } else { -2.0 }, 2.0);
        } else if range.width() < 0.2 {
            self.fit_exactly(i, 0.0, 1.0);
        }
    }
}

/// The program of a plan.
pub fn write(plan: &Plan) -> Program {
    let (uniforms, space) = match &plan.finish {
        Finish::Flat(n, _) => (*n, ["f64", "Vec2", "Vec3"][n - 1]),
        Finish::Direction(..) => (2, "Direction"),
        Finish::Surface(..) => (2, "Surface"),
    };
    let mut scribe = Scribe::new(uniforms, plan.names);
    for step in &plan.steps {
        match step {
            Step::One(i, scalar) => scribe.scalar(i % uniforms, scalar),
            Step::Two(i, pair) => scribe.pair(i % uniforms, (i + 1) % uniforms, pair),
        }
        (0..uniforms).for_each(|i| scribe.tame(i));
    }
    let result = scribe.finish(&plan.finish);
    let parameters: Vec<&str> =
        (0..3).filter(|&i| scribe.parameters[i]).map(|i| PARAMETERS[i]).collect();
    let mut text = format!("(u: [Uniform; {uniforms}]");
    let mut domains = Vec::new();
    for name in &parameters {
        let kind = if *name == "frame" { "Frame" } else { "f64" };
        let _ = write!(text, ", {name}: {kind}");
        if plan.declared && kind == "f64" {
            domains.push(format!("{name} in {:?}..={:?}", PARAMETER.low, PARAMETER.high));
        }
    }
    let _ = writeln!(text, ") -> {space} {{");
    scribe.lines.iter().for_each(|line| {
        let _ = writeln!(text, "    {line}");
    });
    let _ = write!(text, "    {result}\n}}");
    Program { attribute: domains.join(", "), text, parameters, uniforms, space }
}
