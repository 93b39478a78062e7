//! What a call costs: instructions as callgrind counts them, and time.

use core::fmt::Debug;
use core::hint::black_box;
use std::fs;
use std::io;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

use aether_core::Sampler;

use super::ByHand;
use super::pairs::{Numbers, Visitor};
use crate::points::FromCoordinates;

/// The argument with which the program runs itself under valgrind.
pub const COUNTING: &str = "--counting";

/// How many inputs are gone through.
pub const INPUTS: usize = 256;

/// The part of the program whose instructions are counted.
#[inline(never)]
fn measured_part(work: &mut dyn FnMut()) {
    work();
}

/// Where counting begins: callgrind writes what it has counted whenever a function with such a name ends.
#[inline(never)]
fn before_measured_part() {
    black_box(());
}

fn count(work: &mut dyn FnMut()) {
    // The first call of a library function resolves its address.
    work();
    before_measured_part();
    measured_part(work);
}

/// A loop over inputs, to be repeated.
pub type Work<'a> = &'a mut dyn FnMut();

/// What is compared.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// A sampler.
    Sampler,
    /// An integrator, and what the derived and the hand-written one compute in a loop.
    Integrator([integrators::work::Work; 2]),
}

/// Two loops that do the same.
#[derive(Clone, Copy, Debug)]
pub struct Task {
    /// What it is.
    pub kind: Kind,
    /// The row of the catalogue; 0 for what is not in there.
    pub row: u64,
    /// Its name.
    pub name: &'static str,
    /// What is done.
    pub operation: &'static str,
    /// How often, in one loop.
    pub calls: usize,
}

/// What is done with the loops of two programs that do the same.
pub trait Meter {
    /// Measures the derived and the hand-written one.
    fn measure(&mut self, task: Task, works: [Work<'_>; 2]);
}

/// A loop that hides from the compiler what it calls `call` with, and that nobody wants the results.
fn over<'a, S, I, O>(
    sampler: S,
    inputs: &'a [I],
    call: impl Fn(&S, &I) -> O + 'a,
) -> impl FnMut() + 'a
where
    S: 'a,
{
    move || {
        for input in inputs {
            black_box(call(black_box(&sampler), black_box(input)));
        }
    }
}

/// Whether a name has one of some parts; if there are none, each is asked for.
pub fn is_asked(name: &str, parts: &[String]) -> bool {
    let wanted = |part: &String| name.to_lowercase().contains(&part.to_lowercase());
    parts.is_empty() || parts.iter().any(wanted)
}

/// Measures each operation of each pair.
#[derive(Debug)]
pub struct EachOperation<'m, M> {
    /// By what.
    pub meter: &'m mut M,
    /// Only pairs with one of these in their names, if there are any.
    pub names: Vec<String>,
}

impl<M: Meter> Visitor for EachOperation<'_, M> {
    fn visit<S, H>(&mut self, row: u64, name: &'static str, derived: S, by_hand: H)
    where
        S: Sampler<f64>,
        S::Point: FromCoordinates<f64> + Copy + Debug,
        H: ByHand<Uniforms = S::Uniforms, Point = S::Point>,
    {
        if !is_asked(name, &self.names) {
            return;
        }
        let mut numbers = Numbers::new(row);
        let uniforms: Vec<S::Uniforms> = (0..INPUTS).map(|_| numbers.uniforms()).collect();
        // One point in four may lie anywhere, as other techniques make them.
        let points: Vec<S::Point> = uniforms
            .iter()
            .enumerate()
            .map(|(i, u)| if i % 4 == 3 { numbers.stray() } else { derived.forward(*u).0 })
            .collect();
        let task = |operation| Task { kind: Kind::Sampler, row, name, operation, calls: INPUTS };
        let mut ours = over(derived, &uniforms, |s: &S, u| s.sample(*u).value());
        let mut theirs = over(by_hand, &uniforms, |s: &H, u| s.sample(*u));
        self.meter.measure(task("sample"), [&mut ours, &mut theirs]);
        let mut ours = over(derived, &points, |s: &S, x| s.pdf(x).value());
        let mut theirs = over(by_hand, &points, |s: &H, x| s.pdf(x));
        self.meter.measure(task("pdf"), [&mut ours, &mut theirs]);
        let mut ours = over(derived, &uniforms, |s: &S, u| {
            let (point, _, density) = s.forward_with_pdf(*u);
            (point, density.value())
        });
        let mut theirs = over(by_hand, &uniforms, |s: &H, u| s.draw(*u));
        self.meter.measure(task("sample+pdf"), [&mut ours, &mut theirs]);
    }
}

/// Runs each loop once, for callgrind: an empty one, then all in order.
#[derive(Debug, Default)]
pub struct Counting;

impl Counting {
    /// The loop alone.
    pub fn calibrate(&mut self) {
        let inputs = [0.0; INPUTS];
        count(&mut over((), &inputs, |_, _: &f64| ()));
    }
}

impl Meter for Counting {
    fn measure(&mut self, _: Task, works: [Work<'_>; 2]) {
        works.into_iter().for_each(count);
    }
}

/// What a pair has cost.
#[derive(Clone, Copy, Debug)]
pub struct Timed {
    /// What was done.
    pub task: Task,
    /// Nanoseconds a call of the derived and of the hand-written one: the least of several runs.
    pub nanoseconds: [f64; 2],
    /// The median of the ratios of neighbouring runs.
    pub ratio: f64,
    /// How often each asks for memory in a loop.
    pub allocations: [u64; 2],
}

/// Times loops in turns, so that both see the same machine.
#[derive(Debug)]
pub struct Timing {
    /// What was measured.
    pub rows: Vec<Timed>,
    /// How often the program has asked for memory.
    pub allocations: fn() -> u64,
}

/// How many runs of each, and how long one takes at least.
const RUNS: usize = 41;
const SECONDS: f64 = 4e-4;

impl Meter for Timing {
    fn measure(&mut self, task: Task, [ours, theirs]: [Work<'_>; 2]) {
        let rounds = (SECONDS / seconds(theirs, 1).max(1e-9)).ceil() as usize;
        let mut least = [f64::INFINITY; 2];
        let mut ratios = Vec::with_capacity(RUNS);
        for _ in 0..RUNS {
            let times = [seconds(ours, rounds), seconds(theirs, rounds)];
            for k in 0..2 {
                least[k] = least[k].min(times[k] * 1e9 / (rounds * task.calls) as f64);
            }
            ratios.push(times[0] / times[1]);
        }
        ratios.sort_by(f64::total_cmp);
        let asked = |work: Work<'_>| {
            let before = (self.allocations)();
            work();
            (self.allocations)() - before
        };
        let allocations = [asked(ours), asked(theirs)];
        let (nanoseconds, ratio) = (least, ratios[RUNS / 2]);
        self.rows.push(Timed { task, nanoseconds, ratio, allocations });
    }
}

fn seconds(work: Work<'_>, rounds: usize) -> f64 {
    let start = Instant::now();
    for _ in 0..rounds {
        work();
    }
    start.elapsed().as_secs_f64()
}

/// Instructions of each loop, in order, as callgrind counts them: this program runs itself again with
/// [`COUNTING`] and these arguments. The first loop is empty. `None` if there is no valgrind.
///
/// # Errors
/// If it cannot be run, or does not write what it should.
pub fn count_instructions(arguments: &[String]) -> io::Result<Option<Vec<f64>>> {
    let there = Command::new("valgrind").arg("--version").stdout(Stdio::null()).status();
    if !there.is_ok_and(|status| status.success()) {
        return Ok(None);
    }
    let directory = std::env::temp_dir().join(format!("aether-twins-{}", std::process::id()));
    fs::create_dir_all(&directory)?;
    let totals = run_counting(&directory, arguments);
    fs::remove_dir_all(&directory)?;
    let totals = totals?;
    if totals.is_empty() {
        return Err(io::Error::other("callgrind has counted nothing"));
    }
    Ok(Some(totals))
}

/// The instructions of each call of [`measured_part`].
fn run_counting(directory: &Path, arguments: &[String]) -> io::Result<Vec<f64>> {
    let out = directory.join("out");
    let status = Command::new("valgrind")
        .args(["--tool=callgrind", "--dump-after=*measured_part*"])
        .arg(format!("--callgrind-out-file={}", out.display()))
        .arg(std::env::current_exe()?)
        .arg(COUNTING)
        .args(arguments)
        .stderr(Stdio::null())
        .stdout(Stdio::null())
        .status()?;
    if !status.success() {
        return Err(io::Error::other(format!("valgrind ended with {status}")));
    }
    let mut totals = Vec::new();
    loop {
        let path = directory.join(format!("out.{}", 2 * totals.len() + 2));
        let Ok(text) = fs::read_to_string(&path) else { return Ok(totals) };
        let total =
            text.lines().find_map(|line| line.strip_prefix("summary: ")?.trim().parse().ok());
        totals.push(
            total.ok_or_else(|| io::Error::other(format!("{}: no summary", path.display())))?,
        );
    }
}
