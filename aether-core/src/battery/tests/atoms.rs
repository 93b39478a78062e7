//! The battery passes samplers with atoms written right by hand, and fails the same with one mistake in each.

use crate::battery::{Report, Verdict, check};
use crate::density::Density;
use crate::mixed::Mixed;
use crate::sampler::{PdfOf, Sampler};

/// A sampler of one uniform with atoms, put together by hand.
#[derive(Clone, Copy)]
struct Hand<const N: usize> {
    forward: fn([f64; N]) -> Option<Mixed>,
    pdf: fn(&Mixed) -> f64,
    /// The only preimage of a point.
    invert: fn(&Mixed) -> Option<[f64; N]>,
    /// What `sample.pdf()` is multiplied with on atoms.
    own_factor: f64,
}

impl<const N: usize> Sampler<f64> for Hand<N> {
    type Uniforms = [f64; N];
    type Point = Mixed;
    fn forward(&self, u: [f64; N]) -> (Mixed, bool) {
        (self.forward)(u).map_or((Mixed::Continuous(0.0), false), |x| (x, true))
    }
    fn pdf(&self, x: &Mixed) -> PdfOf<Self, f64> {
        Density::new((self.pdf)(x))
    }
    fn pdf_of_uniforms(&self, u: [f64; N]) -> PdfOf<Self, f64> {
        let (x, _) = self.forward(u);
        Density::new((self.pdf)(&x) * x.atom().map_or(1.0, |_| self.own_factor))
    }
    fn preimages(&self, x: &Mixed, mut visit: impl FnMut([f64; N], bool)) {
        (self.invert)(x).into_iter().for_each(|u| visit(u, true));
    }
}

/// The probability of the wall: of all flights that get to 1, those that end before 2.
fn wall() -> f64 {
    (-1.0f64).exp() - (-2.0f64).exp()
}

fn density(t: f64) -> f64 {
    if (0.0..1.0).contains(&t) { (-t).exp() } else { 0.0 }
}

/// Free flight to a wall of number 3; what would get through twice is lost.
fn flight() -> Hand<1> {
    Hand {
        forward: |[u]| match -(-u).ln_1p() {
            t if t < 1.0 => Some(Mixed::Continuous(t)),
            t if t < 2.0 => Some(Mixed::Atom(3, 1.0)),
            _ => None,
        },
        pdf: |x| match x {
            Mixed::Continuous(t) => density(*t),
            Mixed::Atom(3, _) => wall(),
            Mixed::Atom(..) => 0.0,
        },
        invert: |x| match x {
            Mixed::Continuous(t) => (density(*t) > 0.0).then(|| [-(-t).exp_m1()]),
            Mixed::Atom(..) => None,
        },
        own_factor: 1.0,
    }
}

/// One uniform picks the atom, together with another one: not by boxes.
fn oblique() -> Hand<2> {
    Hand {
        forward: |[u, v]| {
            Some(if u + v < 0.5 { Mixed::Atom(0, 0.0) } else { Mixed::Continuous(u + v) })
        },
        pdf: |x| match x {
            Mixed::Continuous(t) if (0.5..1.0).contains(t) => *t,
            Mixed::Continuous(t) if (1.0..2.0).contains(t) => 2.0 - t,
            Mixed::Atom(0, _) => 0.125,
            _ => 0.0,
        },
        invert: |_| None,
        own_factor: 1.0,
    }
}

/// The names of the checks that fail.
fn failed(report: &Report) -> Vec<&'static str> {
    report.failures().map(|f| f.check).collect()
}

/// How one of the checks went.
fn verdict(report: &Report, check: &str) -> Option<Verdict> {
    report.findings().iter().find(|f| f.check == check).map(|f| f.verdict)
}

#[test]
fn a_right_sampler_with_atoms_passes() {
    let report = check(&flight());
    report.assert_ok();
    assert_eq!(report.findings().len(), 9, "{report}");
    assert!(report.findings().iter().all(|f| f.verdict == Verdict::Passed), "{report}");
}

#[test]
fn a_probability_off_by_one_percent_or_one_in_a_million_fails() {
    let mut wrong = flight();
    wrong.pdf = |x| if *x == Mixed::Atom(3, x.point()) { 1.01 * wall() } else { (flight().pdf)(x) };
    assert_eq!(failed(&check(&wrong)), ["atom mass"]);
    wrong.pdf = |x| if *x == Mixed::Atom(3, x.point()) { wall() + 1e-6 } else { (flight().pdf)(x) };
    assert_eq!(failed(&check(&wrong)), ["atom mass"]);
    wrong.pdf = |x| if *x == Mixed::Atom(3, x.point()) { 1.1 * wall() } else { (flight().pdf)(x) };
    assert_eq!(failed(&check(&wrong)), ["atom shares", "atom mass"]);
    wrong = flight();
    wrong.own_factor = 1.01;
    assert_eq!(failed(&check(&wrong)), ["atoms"]);
}

#[test]
fn what_is_lost_is_no_part_of_an_atom() {
    let mut wrong = flight();
    wrong.pdf = |x| match x {
        Mixed::Atom(3, _) => (-1.0f64).exp(),
        x => (flight().pdf)(x),
    };
    assert_eq!(failed(&check(&wrong)), ["atom shares", "atom mass"]);
    // Nor of the continuous part.
    let mut wrong = flight();
    wrong.pdf = |x| match x {
        Mixed::Continuous(t) => density(*t) / (1.0 - (-2.0f64).exp()),
        x => (flight().pdf)(x),
    };
    assert_eq!(failed(&check(&wrong)), ["jacobian", "mass", "chi-square"]);
}

#[test]
fn an_atom_that_is_none_fails() {
    let mut wrong = flight();
    wrong.pdf = |x| if x.atom().is_some() { wall() } else { (flight().pdf)(x) };
    assert_eq!(failed(&check(&wrong)), ["atoms", "atom shares", "atom mass"]);
    wrong.pdf = |x| if x.atom() == Some(5) { 0.01 } else { (flight().pdf)(x) };
    assert_eq!(failed(&check(&wrong)), ["atom shares", "atom mass"]);
    wrong.pdf = |x| if x.atom() == Some(5) { f64::NAN } else { (flight().pdf)(x) };
    assert_eq!(failed(&check(&wrong)), ["atoms"]);
    // One that samples are on, and which is not told.
    wrong.pdf = |x| if x.atom().is_some() { 0.0 } else { (flight().pdf)(x) };
    assert_eq!(failed(&check(&wrong)), ["atoms", "atom shares", "atom mass"]);
}

#[test]
fn an_atom_told_by_its_place_fails() {
    let mut wrong = flight();
    wrong.pdf = |x| match x {
        Mixed::Atom(3, at) if *at != 1.0 => 0.0,
        x => (flight().pdf)(x),
    };
    assert!(failed(&check(&wrong)).contains(&"atoms"));
}

#[test]
fn an_atom_with_a_preimage_fails() {
    let mut wrong = flight();
    wrong.invert = |x| if x.atom() == Some(3) { Some([0.7]) } else { (flight().invert)(x) };
    assert_eq!(failed(&check(&wrong)), ["atoms"]);
}

#[test]
fn a_wrong_continuous_part_fails() {
    let mut wrong = flight();
    wrong.pdf = |x| match x {
        Mixed::Continuous(t) => 1.01 * density(*t),
        x => (flight().pdf)(x),
    };
    assert_eq!(failed(&check(&wrong)), ["jacobian", "mass"]);
}

#[test]
fn shares_are_compared_where_regions_are_no_boxes() {
    let report = check(&oblique());
    let passed = Some(Verdict::Passed);
    assert_eq!(verdict(&report, "atom mass"), Some(Verdict::NotApplicable), "{report}");
    assert_eq!(["atoms", "atom shares", "mass"].map(|c| verdict(&report, c)), [passed; 3]);
    let mut wrong = oblique();
    wrong.pdf = |x| if x.atom() == Some(0) { 0.125 * 1.05 } else { (oblique().pdf)(x) };
    assert_eq!(verdict(&check(&wrong), "atom shares"), Some(Verdict::Failed));
}

#[test]
fn atoms_alone_need_no_density() {
    let coin = Hand {
        forward: |[u]: [f64; 1]| Some(Mixed::Atom(usize::from(u < 0.3), 0.0)),
        pdf: |x| match x {
            Mixed::Atom(0, _) => 0.7,
            Mixed::Atom(1, _) => 0.3,
            _ => 0.0,
        },
        invert: |_| None,
        own_factor: 1.0,
    };
    let report = check(&coin);
    report.assert_ok();
    assert_eq!(verdict(&report, "density"), Some(Verdict::NotApplicable), "{report}");
}
