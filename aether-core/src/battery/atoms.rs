//! The checks of atoms: their probabilities against samples, and against the uniforms that lead to them.

use std::collections::BTreeMap;

use super::Settings;
use super::pearson::Pearson;
use super::pointwise::tolerance;
use super::regions::{End, Led, measures};
use super::report::{Report, Verdict};
use super::subject::{AnySpot, Subject};
use crate::uniform::{Pcg32, UniformSource};

/// How many samples of each atom are looked at one by one.
const EACH: usize = 32;
/// Up to here numbers are tried for atoms that no sample was on.
const NUMBERS: usize = 64;
/// How many of the uniforms vouch for the borders of regions.
const KNOWN: usize = 16_384;
/// An atom that less often than this is expected among the samples may have been missed.
const MISSED: f64 = 25.0;

/// What is known of a sampler with atoms.
struct Atoms<'a> {
    sampler: &'a dyn Subject,
    /// Uniforms at random, and where they lead.
    led: Vec<Led>,
    /// The first samples that are on each atom, with their uniforms.
    met: BTreeMap<usize, Vec<(Vec<f64>, AnySpot<'a>)>>,
    /// The probability of each atom that there is, as the sampler tells it.
    probabilities: BTreeMap<usize, f64>,
}

/// Where uniforms lead.
fn end(sampler: &dyn Subject, u: &[f64]) -> End {
    match sampler.forward(u) {
        None => End::Nothing,
        Some(x) => x.atom().map_or(End::Continuous, End::Atom),
    }
}

/// Checks the atoms of a sampler, if its space has any. Returns the measure of the uniforms that lead to its continuous part,
/// if it can be told exactly.
pub(super) fn check(
    sampler: &dyn Subject,
    settings: &Settings,
    report: &mut Report,
) -> Option<f64> {
    if !sampler.has_atoms() {
        return None;
    }
    let mut source = Pcg32::new(settings.seed, 5, 0);
    let led: Vec<Led> = (0..settings.samples)
        .map(|_| sampler.draw(&mut source))
        .map(|u| (u.clone(), end(sampler, &u)))
        .collect();
    let mut met = BTreeMap::<usize, Vec<_>>::new();
    for (u, end) in &led {
        if let End::Atom(number) = end {
            let samples = met.entry(*number).or_default();
            if samples.len() < EACH {
                samples.extend(sampler.forward(u).map(|x| (u.clone(), x)));
            }
        }
    }
    let mut atoms = Atoms { sampler, led, met, probabilities: BTreeMap::new() };
    let failure = atoms.ask().or_else(|| atoms.at_samples());
    let success = format!("{} atoms with samples on them", atoms.met.len());
    report.conclude("atoms", failure, success);
    atoms.shares(settings.false_alarm_rate, report);
    atoms.masses(report)
}

impl Atoms<'_> {
    /// Asks for the probabilities of all atoms, those without samples included. What is wrong with one, if anything.
    fn ask(&mut self) -> Option<String> {
        let (_, model) = self.led.iter().find_map(|(u, _)| Some((u, self.sampler.forward(u)?)))?;
        let mut source = Pcg32::new(0, 6, 0);
        let mut anywhere = || (UniformSource::<f64>::next(&mut source) * 2f64.powi(60)) as usize;
        let unknown: Vec<usize> = (0..8).map(|_| NUMBERS + anywhere()).collect();
        let numbers = (0..NUMBERS).chain(self.met.keys().copied()).chain(unknown.iter().copied());
        let mut wrong = None;
        for number in numbers {
            let p = model.on_atom(number).map_or(f64::NAN, |x| x.pdf());
            let out = !(0.0..=1.0 + tolerance(self.sampler.epsilon())).contains(&p);
            let stray = unknown.contains(&number) && !self.met.contains_key(&number) && p != 0.0;
            if out || stray {
                wrong.get_or_insert(format!("the probability of atom {number} is {p:e}"));
            }
            if p > 0.0 {
                self.probabilities.insert(number, p);
            }
        }
        wrong
    }

    /// What is wrong with a sample that is on an atom, if anything.
    fn at_samples(&self) -> Option<String> {
        let elsewhere = self.led.iter().find_map(|(u, _)| self.sampler.forward(u))?.coordinates();
        let mut samples = self.met.iter().flat_map(|(n, all)| all.iter().map(move |s| (n, s)));
        samples.find_map(|(number, (u, x))| {
            let (own, p) = (self.sampler.own_density(u), x.pdf());
            if !(p > 0.0 && (own - p).abs() <= tolerance(self.sampler.epsilon()) * p) {
                let detail = format!("sample.pdf() is {own:e}, sampler.pdf {p:e}");
                return Some(format!("at {x:?} (uniforms {u:?}): {detail}"));
            }
            let found = x.preimages();
            if !found.is_empty() {
                return Some(format!("{x:?} is an atom, but has preimages {found:?}"));
            }
            // The number tells an atom, never its coordinates.
            let moved = x.moved_to(&elsewhere).on_atom(*number)?;
            let q = moved.pdf();
            (q != p).then(|| format!("{x:?} has probability {p:e}, but {moved:?} has {q:e}"))
        })
    }

    /// Pearson's test of the samples on each atom, and on none, against the probabilities. What has fewer than five samples
    /// expected is pooled, and cannot have many.
    fn shares(&self, false_alarm_rate: f64, report: &mut Report) {
        let mut pearson = Pearson::default();
        for (end, count, expected) in self.counts() {
            pearson.add(&format!("{end:?}"), count, (expected, 0.0));
        }
        let subject = format!("{} samples, {} atoms", self.led.len(), self.probabilities.len());
        pearson.conclude(("atom shares", &subject), false_alarm_rate, report);
    }

    /// How many samples are on each atom, and how many are expected there; those without an atom, or none at all, count as
    /// continuous.
    fn counts(&self) -> Vec<(End, f64, f64)> {
        let n = self.led.len() as f64;
        let mut counts: BTreeMap<usize, (f64, f64)> =
            self.probabilities.iter().map(|(number, p)| (*number, (0.0, p * n))).collect();
        let mut others = n;
        for (_, end) in &self.led {
            if let End::Atom(number) = end {
                counts.entry(*number).or_default().0 += 1.0;
                others -= 1.0;
            }
        }
        let expected: f64 = counts.values().map(|(_, expected)| expected).sum();
        let atoms = counts.into_iter().map(|(k, (count, p))| (End::Atom(k), count, p));
        atoms.chain([(End::Continuous, others, n - expected)]).collect()
    }

    /// Compares probabilities with the measure of the uniforms that lead to each atom. Returns that of the uniforms that
    /// lead to none, but to a sample.
    fn masses(&self, report: &mut Report) -> Option<f64> {
        let known: Vec<Led> = self.led.iter().take(KNOWN).cloned().collect();
        let lead = |u: &[f64]| end(self.sampler, u);
        let all = measures(&lead, &known, self.sampler.epsilon());
        // Where there is no sample may be of any shape, and atoms of boxes nevertheless.
        let any = |end: End| if end == End::Nothing { End::Continuous } else { end };
        let merged: Vec<Led> = known.into_iter().map(|(u, end)| (u, any(end))).collect();
        let of_atoms =
            all.clone().or_else(|| measures(&|u| any(lead(u)), &merged, self.sampler.epsilon()));
        let Some(measured) = of_atoms else {
            let detail = "the uniforms that lead to atoms are no boxes".to_owned();
            report.add("atom mass", Verdict::NotApplicable, detail);
            return None;
        };
        self.compare_masses(&measured, all.is_some(), report);
        let continuous =
            |all: BTreeMap<End, f64>| all.get(&End::Continuous).copied().unwrap_or(0.0);
        all.map(continuous)
    }

    /// Reports how the probabilities differ from what was measured: with uniforms that lead nowhere apart (`all`), or together
    /// with the continuous part.
    fn compare_masses(&self, measured: &BTreeMap<End, f64>, all: bool, report: &mut Report) {
        let bound = tolerance(self.sampler.epsilon());
        let of = |end| measured.get(&end).copied().unwrap_or(0.0);
        let missed = |number: &usize, p: f64| {
            !self.met.contains_key(number) && p * self.led.len() as f64 <= MISSED
        };
        let met = self.met.keys().map(|n| (n, self.probabilities.get(n).copied().unwrap_or(0.0)));
        let unmet = self.probabilities.iter().map(|(n, p)| (n, *p));
        let mut worst = 0.0_f64;
        let failure = met.chain(unmet).filter(|(n, p)| !missed(n, *p)).find_map(|(number, p)| {
            let measure = of(End::Atom(*number));
            worst = worst.max((p - measure).abs());
            // A NaN is not right.
            let right = (p - measure).abs() <= bound;
            (!right).then(|| {
                format!("atom {number} has probability {p}, the uniforms that lead there {measure}")
            })
        });
        let atoms: f64 = self.probabilities.values().sum();
        let rest = if all {
            format!(
                "{:.6} continuous, {:.6} without a sample",
                of(End::Continuous),
                of(End::Nothing)
            )
        } else {
            format!("{:.6} continuous or without a sample", of(End::Continuous))
        };
        let figures = format!(
            "probabilities and measures of uniforms differ by {worst:.1e}: {atoms:.6} on atoms, {rest}"
        );
        let total = atoms + of(End::Continuous) + of(End::Nothing);
        let sum = ((total - 1.0).abs() > bound + MISSED / self.led.len() as f64)
            .then(|| format!("all adds up to {total}; {figures}"));
        report.conclude("atom mass", failure.or(sum), figures);
    }
}
