//! Parameters drawn from declared domains: legal, with their extremes, and simplified.

use aether_core::legal::{Parameter, ParameterKind};
use aether_core::prelude::*;
use aether_core::proptest::{parameters, samplers};
use aether_core::{DomainError, Legal, battery};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{Config, TestError, TestRunner};

/// Free flight up to a distance.
#[sampler(s in 1e-3..=1e3, d in 1e-3..=1e3)]
fn flight_below(u: [Uniform; 1], s: f64, d: f64) -> f64 {
    -((-s * d).exp_m1() * u[0]).ln_1p() / s
}

/// Uniform between two numbers.
#[sampler(a in -2.0..1.0, b in 0.0.., where a < b)]
fn between(u: [Uniform; 1], a: f64, b: f64) -> f64 {
    a + (b - a) * u[0]
}

/// Something that nothing is legal for.
#[derive(Debug)]
struct Impossible;

impl Legal for Impossible {
    type Real = f64;
    const ITEM: &'static str = "impossible";
    const PARAMETERS: &'static [Parameter] =
        &[Parameter { name: "a", kind: ParameterKind::Number, domain: None }];
    const RELATIONS: &'static [&'static str] = &["a < a"];
    fn from_parameters(numbers: &[f64]) -> Result<Self, DomainError> {
        Err(DomainError { item: Self::ITEM, requirement: "a < a", value: numbers[0] })
    }
}

/// Above a plane, every kind of parameter.
#[sampler(height in 0.0..=1.0, where normal.z > 0.0, where shift.x < shift.y)]
#[allow(clippy::too_many_arguments)]
fn every_kind(
    u: [Uniform; 2],
    height: f64,
    shift: Vec2,
    corner: Vec3,
    normal: Direction,
    turn: Mat3,
    frame: Frame,
    id: SurfaceId,
) -> SurfacePoint {
    let local = Vec3::new(u[0] + shift.x, u[1] + shift.y, height + normal.z);
    SurfacePoint::new(corner + frame.to_world(local) + turn.x, id)
}

/// Only rotated; has no domain.
#[map]
fn rotated(w: Direction, frame: Frame) -> Direction {
    Direction::from_vec(frame.to_world(w))
}

/// No parameter at all.
#[sampler]
fn unit(u: [Uniform; 1]) -> f64 {
    u[0]
}

/// A composition has domains too.
#[sampler(k in 1.0..=2.0)]
fn doubled(u: [Uniform; 1], k: f64) -> f64 {
    let x = unit().sample(u);
    stretched(k).apply(&x)
}

#[map]
fn stretched(x: f64, k: f64) -> f64 {
    k * x
}

fn drawn<S: Legal>(count: usize) -> Vec<Vec<S::Real>> {
    let mut runner = TestRunner::deterministic();
    let tree = |_| parameters::<S>().new_tree(&mut runner).expect("there are legal parameters");
    (0..count).map(tree).map(|tree| tree.current()).collect()
}

#[test]
fn domains_and_kinds_are_told() {
    let [s, _] = FlightBelow::<f64>::PARAMETERS else { panic!("two parameters") };
    let domain = s.domain.expect("it is declared");
    assert_eq!((s.name, domain.low, domain.high, domain.closed), ("s", 1e-3, 1e3, true));
    let kinds: Vec<ParameterKind> = EveryKind::<f32>::PARAMETERS.iter().map(|p| p.kind).collect();
    use ParameterKind::{Direction, Frame, Mat3, Number, SurfaceId, Vec2, Vec3};
    assert_eq!(kinds, [Number, Vec2, Vec3, Direction, Mat3, Frame, SurfaceId]);
    assert_eq!(EveryKind::<f32>::RELATIONS, ["normal.z > 0.0", "shift.x < shift.y"]);
    assert_eq!((Unit::PARAMETERS.len(), Doubled::<f64>::PARAMETERS.len()), (0, 1));
    let short = FlightBelow::from_parameters(&[1.0]).unwrap_err();
    assert_eq!((short.item, short.value), ("flight_below", 1.0));
    let mut bent = [0.0; 9];
    bent[0] = 1.0;
    assert!(Rotated::from_parameters(&bent).is_err());
}

proptest! {
    #[test]
    fn every_case_is_legal_in_both_precisions(
        a in parameters::<FlightBelow<f64>>(),
        b in parameters::<FlightBelow<f32>>(),
        c in samplers::<Between<f64>>(),
        d in samplers::<Between<f32>>(),
        e in samplers::<EveryKind<f64>>(),
        f in samplers::<EveryKind<f32>>(),
        g in samplers::<Rotated<f64>>(),
        _ in samplers::<Unit>(),
        h in samplers::<Doubled<f64>>(),
    ) {
        let inside = |x: f64| (1e-3..=1e3).contains(&x);
        prop_assert!(a.iter().all(|x| inside(*x)) && b.iter().all(|x| inside(f64::from(*x))));
        // In range and in order: both ends of the interval follow from its samples.
        let (low, high) = (c.sample([0.0]).value(), c.sample([1.0 - 1e-16]).value());
        prop_assert!((-2.0..1.0).contains(&low) && low < high);
        prop_assert!(d.sample([0.0]).value() < 1.0);
        let (x, y) = (e.sample([0.25, 0.5]), f.sample([0.25, 0.5]));
        prop_assert!(e.pdf(&x).value() > 0.0 && f.pdf(&y).value() > 0.0);
        // The frame is orthonormal, so lengths remain.
        let w = g.apply(&Direction::new(0.6, 0.0, 0.8));
        prop_assert!((w.length() - 1.0).abs() < 1e-14);
        prop_assert!((1.0..=2.0).contains(&h.sample([1.0 - 1e-16]).value()) || h.sample([0.5]).value() >= 0.5);
    }
}

#[test]
fn extremes_occur_and_scales_are_covered() {
    let cases = drawn::<FlightBelow<f64>>(2000);
    let count = |test: &dyn Fn(f64) -> bool| cases.iter().filter(|c| test(c[0])).count();
    for x in [1e-3, 1e-3f64.next_up(), 1e3, 1e3f64.next_down(), 1.0] {
        assert!(count(&|y| y == x) > 20, "{x:e}");
    }
    // Of the ordinary ones a third in each pair of powers of ten: 500 of 2000, less than 5 standard
    // deviations (of 19) away.
    for low in [1e-3, 1e-1, 1e1] {
        let n = count(&|y| y > 1.001 * low && y < 99.9 * low && y != 1.0);
        assert!((405..595).contains(&n), "{n} from {low:e}");
    }
    // Single precision has neighbours of its own.
    let cases = drawn::<FlightBelow<f32>>(2000);
    assert!(cases.iter().any(|c| c[0] == 1e3f32.next_down()));
}

#[test]
fn a_sampler_that_breaks_at_an_end_is_found() {
    // Breaks only where s is the lower end of its domain.
    let property = |numbers: Vec<f64>| {
        prop_assert!(numbers[0] > 1e-3);
        Ok(())
    };
    let found = TestRunner::deterministic().run(&parameters::<FlightBelow<f64>>(), property);
    let Err(TestError::Fail(_, numbers)) = found else { panic!("{found:?}") };
    // The other parameter has been simplified to one.
    assert_eq!(numbers, [1e-3, 1.0]);
}

#[test]
fn a_failing_case_is_simplified() {
    let property = |numbers: Vec<f64>| {
        prop_assert!(numbers[0] < 20.0 || numbers[1] < 0.5);
        Ok(())
    };
    let config = Config { failure_persistence: None, ..Config::default() };
    let found = TestRunner::new(config).run(&parameters::<FlightBelow<f64>>(), property);
    let Err(TestError::Fail(_, numbers)) = found else { panic!("{found:?}") };
    assert_eq!(numbers[1], 1.0);
    let digits = format!("{:e}", numbers[0]);
    assert!(numbers[0] >= 20.0 && digits.len() <= 5, "{digits}");
    // Relations hold while it is simplified.
    let mut runner = TestRunner::deterministic();
    for _ in 0..200 {
        let mut tree = parameters::<Between<f64>>().new_tree(&mut runner).unwrap();
        let mut steps = 0;
        while tree.simplify() || tree.complicate() {
            assert!(Between::from_parameters(&tree.current()).is_ok());
            steps += 1;
            assert!(steps < 50);
        }
        let mut tree = parameters::<EveryKind<f64>>().new_tree(&mut runner).unwrap();
        while tree.simplify() {}
        assert!(EveryKind::from_parameters(&tree.current()).is_ok());
    }
}

#[test]
fn relations_that_cannot_hold_are_an_error() {
    let error = samplers::<Impossible>().new_tree(&mut TestRunner::deterministic());
    let text = error.expect_err("nothing is legal").to_string();
    for part in ["`impossible`", "`a < a`", "Declare domains"] {
        assert!(text.contains(part), "{part} is not in: {text}");
    }
}

#[test]
fn drawn_samplers_pass_the_battery() {
    let mut runner = TestRunner::deterministic();
    for _ in 0..5 {
        let flight = samplers::<Doubled<f64>>().new_tree(&mut runner).unwrap().current();
        battery::check(&flight).assert_ok();
    }
}
