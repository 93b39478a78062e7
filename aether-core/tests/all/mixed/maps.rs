//! Maps that follow samplers with atoms. Expected values are closed forms written by hand, as in the main file.

use aether_core::battery::{self, Battery};
use aether_core::mixture::ComponentsWithAtoms;

use super::*;

/// Another scale and another origin.
#[map(scale in 0.01..=100.0)]
fn stretch(x: f64, scale: f64, offset: f64) -> f64 {
    offset + scale * x
}

/// Two preimages.
#[map]
fn squared(x: f64) -> f64 {
    x * x
}

/// What lies beyond has no image.
#[map]
fn below(x: f64, end: f64) -> f64 {
    require(x < end);
    x
}

/// A direction given in a frame, in world coordinates.
#[map]
fn rotate(w: Direction, frame: Frame) -> Direction {
    Direction::from_vec(frame.to_world(w))
}

/// Where a direction meets the plane at height zero, from above.
#[map]
fn to_floor(w: Direction, eye: Vec3) -> Vec2 {
    let t = -eye.z / w.z;
    require(t > 0.0);
    Vec2::new(eye.x + t * w.x, eye.y + t * w.y)
}

fn stretch_of(scale: f64, offset: f64) -> Stretch<f64> {
    stretch(scale, offset).expect("legal parameters")
}

/// A frame that looks down, and the direction that `mirror` is in the world.
fn downwards(mirror: Direction) -> (Frame, Direction) {
    let frame = Frame::around(Direction::new(0.6, 0.0, -0.8));
    (frame, Direction::from_vec(frame.to_world(mirror)))
}

#[test]
fn an_atom_goes_where_the_map_leads_with_its_probability() {
    let heights = flight_of(2.0, 0.75).then(stretch_of(4.0, 10.0));
    let p = (-1.5f64).exp();
    let wall = heights.sample([0.99]);
    assert_eq!(wall.value(), Mixed::Atom(0, 13.0));
    close(wall.pdf().value(), p, 2.0);
    close(heights.pdf(&wall).value(), p, 2.0);
    close(heights.probability(0), p, 2.0);
    close(heights.log_pdf(&wall), -1.5, 4.0);
    assert_eq!((heights.place(0), heights.place(1)), (Some(13.0), None));
    assert!(heights.invert(&wall).is_empty());
    let (x, valid, density) = heights.forward_with_pdf([0.99]);
    assert!(valid && x == wall.value() && density.value() == wall.pdf().value());

    let near = heights.sample([0.5]);
    let t = 0.5 * 2f64.ln();
    close(near.point(), 10.0 + 4.0 * t, 4.0);
    // Half of the uniforms, at the rate of 2 a distance, or 1/2 a height: no change of measure on the atom, one beside it.
    for found in [near.pdf(), heights.pdf(&near), heights.forward_with_pdf([0.5]).2] {
        close(found.value(), 0.5 * 0.5, 8.0);
    }
    close(heights.log_pdf(&near), 0.25f64.ln(), 8.0);
    close(heights.invert(&near).iter().next().expect("one")[0], 0.5, 8.0);
    // A point at the place of the atom is not on it.
    close(heights.pdf(&Mixed::Continuous(12.0)).value(), 0.5 * (-1.0f64).exp(), 8.0);
    assert_eq!(heights.pdf(&Mixed::Continuous(13.5)).value(), 0.0);
    // Its number tells an atom, not where it is said to lie.
    close(heights.pdf(&Mixed::Atom(0, -7.0)).value(), p, 2.0);
    assert_eq!(heights.pdf(&Mixed::Atom(1, 13.0)).value(), 0.0);
    assert_eq!(heights.log_pdf(&Mixed::Atom(1, 13.0)), f64::NEG_INFINITY);
    drawn(heights);
}

#[test]
fn maps_follow_each_other() {
    let once = slab(0.7, 0.5, 2.0).expect("legal").then(stretch_of(2.0, 1.0));
    let thrice = once.then(stretch_of(0.5, -3.0)).then(stretch_of(8.0, 0.0));
    // As one map: 8 (0.5 (1 + 2 x) - 3).
    assert_eq!(thrice.place(2), Some(8.0 * (0.5 * 2.0 - 3.0)));
    let p = (-0.35f64).exp() - (-1.4f64).exp();
    close(thrice.probability(2), p, 16.0);
    close(
        thrice.pdf(&Mixed::Continuous(8.0 * (0.3 - 2.5))).value(),
        0.7 / 8.0 * (-0.21f64).exp(),
        64.0,
    );
    let together = slab(0.7, 0.5, 2.0).expect("legal").then(Map::then(
        Map::then(stretch_of(2.0, 1.0), stretch_of(0.5, -3.0)),
        stretch_of(8.0, 0.0),
    ));
    for k in 0..1000 {
        let u = uniforms::<Slab>(2, k);
        let (a, b) = (thrice.sample(u), together.sample(u));
        assert_eq!((a.value(), a.is_valid()), (b.value(), b.is_valid()));
        close(a.pdf().value(), b.pdf().value(), 8.0);
    }
    drawn(once);
    drawn(thrice);
}

#[test]
fn an_atom_counts_once_where_a_map_has_several_preimages() {
    let squares = two_walls(-1.0, 2.0).expect("legal").then(squared());
    let (left, right) = (normal_cdf(-1.0f64), normal_cdf(-2.0f64));
    close(squares.probability(0), left, 16.0);
    close(squares.probability(1), right, 16.0);
    assert_eq!((squares.place(0), squares.place(1)), (Some(1.0), Some(4.0)));
    // Below one there are two preimages, above only the positive one.
    let normal = |x: f64| (-0.5 * x * x).exp() / TAU.sqrt();
    close(squares.pdf(&Mixed::Continuous(0.25)).value(), 2.0 * normal(0.5), 16.0);
    close(squares.pdf(&Mixed::Continuous(2.25)).value(), normal(1.5) / 3.0, 16.0);
    let root = |x: f64| x * squares.continuous().pdf(&(x * x)).value() * 2.0;
    let mass = integral(0.0, 1.0, root) + integral(1.0, 2.0, root);
    close(mass + left + right, 1.0, 4096.0);
}

#[test]
fn an_atom_without_an_image_is_gone() {
    let near = flight_of(2.0, 0.75).then(below(0.5));
    assert_eq!((near.place(0), near.probability(0)), (None, 0.0));
    assert_eq!(near.log_probability(0), f64::NEG_INFINITY);
    assert_eq!(near.pdf(&Mixed::Atom(0, 0.75)).value(), 0.0);
    assert_eq!(near.log_pdf(&Mixed::Atom(0, 0.75)), f64::NEG_INFINITY);
    // Neither the wall nor what lies before it, but beyond the end, is a sample.
    for u in [0.7, 0.999] {
        let x = near.sample([u]);
        assert!(!x.is_valid() && x.pdf().value() == 0.0);
        assert!(!near.forward_with_pdf([u]).1);
    }
    assert!(near.sample([0.6]).is_valid());
    let (continuous, atoms) = mass(&near, 0.0, 0.5);
    close(continuous, -(-1.0f64).exp_m1(), 4096.0);
    assert_eq!(atoms, 0.0);
    // And no map brings it back.
    let later = near.then(stretch_of(1.0, 0.0));
    assert_eq!((later.place(0), later.probability(0)), (None, 0.0));
    drawn(later);
    // A wall that has an image remains.
    let all = flight_of(2.0, 0.75).then(below(0.8));
    close(all.probability(0), (-1.5f64).exp(), 2.0);
    drawn(all);
}

#[test]
fn mirrors_are_turned_and_seen_on_the_floor() {
    let (frame, mirror) = downwards(Direction::new(0.0, 0.6, 0.8));
    let turned =
        mirror_and_lobe(0.25, Direction::new(0.0, 0.6, 0.8)).expect("legal").then(rotate(frame));
    assert_eq!(turned.sample([0.1, 0.3]).value(), Mixed::Atom(0, mirror));
    let beside = Direction::new(0.0, 0.0, -1.0);
    let density: Density<WithAtoms<SolidAngle>> = turned.pdf(&Mixed::Continuous(beside));
    close(density.value(), 0.75 * 0.8 / PI, 8.0);
    // Along the surface, a rounding of the direction is large beside its height, down to 2e-3.
    drawn_within(turned, 4096.0);

    let eye = Vec3::new(0.5, -1.0, 2.0);
    let floor = turned.then(to_floor(eye));
    let t = -2.0 / mirror.z;
    assert!(t > 0.0, "the mirror looks down");
    let (seen, place) = (floor.place(0).expect("seen"), eye + t * mirror.vec());
    assert!((seen - Vec2::new(place.x, place.y)).length() < 1e-14);
    assert_eq!(floor.probability(0), 0.25);
    // Straight below: the cosine to the frame, over the squared distance.
    let below = floor.pdf(&Mixed::Continuous(Vec2::new(0.5, -1.0)));
    close(below.value(), 0.75 * 0.8 / PI / 4.0, 32.0);
    drawn_within(floor, 65536.0);
    // From below there is no floor to be seen in the mirror.
    let never = turned.then(to_floor(Vec3::new(0.0, 0.0, -2.0)));
    assert_eq!((never.place(0), never.probability(0)), (None, 0.0));
}

#[test]
fn mapped_techniques_combine_and_mix_without_bias() {
    // The integrand of the main file, over distances in other units.
    let (scale, wall) = (4.0, 2.0);
    let units = stretch_of(scale, 0.0);
    let a = flight_of(1.5, wall).then(units);
    let b = uniform_flight(0.125, wall).expect("legal").then(units);
    let value = |x: &Mixed| match x {
        Mixed::Continuous(t) => integrand(&Mixed::Continuous(t / scale)) / scale,
        Mixed::Atom(number, t) => integrand(&Mixed::Atom(*number, t / scale)),
    };
    unbiased(expected(wall), |k| {
        let (x, y) = (a.sample(uniforms::<Flight>(3, k)), b.sample(uniforms::<Flight>(4, k)));
        let weighted = combine::<PowerHeuristic, _>((&x, &y));
        weighted.iter().map(|w| w.weight * value(w) / w.pdf).sum()
    });
    let both = mixture((a, b), shares([0.25, 0.75])).expect("two of both");
    close(both.pdf(&Mixed::Atom(0, 8.0)).value(), 0.25 * (-3.0f64).exp() + 0.75 * 0.125, 8.0);
    unbiased(expected(wall), |k| {
        let x = both.sample(uniforms::<Flight>(5, k));
        close(x.pdf().value(), both.pdf(&x).value(), 64.0);
        value(&x) / x.pdf().value()
    });
}

#[test]
fn a_map_follows_a_mixture_of_samplers_with_atoms() {
    let walls = (two_walls(-1.0, 0.5).expect("legal"), ends());
    let both =
        mixture(walls, shares([0.25, 0.75])).expect("two of both").then(stretch_of(4.0, 1.0));
    // The left wall is one of both; 7 is a place of the second alone, 1 of the first.
    assert_eq!(ATOMS_OF_BOTH, [0, 1, 7]);
    assert_eq!([0, 1, 7, 2].map(|k| both.place(k)), [Some(-3.0), Some(3.0), Some(9.0), None]);
    close(both.probability(0), 0.25 * normal_cdf(-1.0f64) + 0.75 * 0.25, 8.0);
    close(both.probability(1), 0.25 * normal_cdf(-0.5f64), 8.0);
    close(both.probability(7), 0.75 * 0.125, 8.0);
    close(both.log_probability(7), (0.75f64 * 0.125).ln(), 8.0);
    assert_eq!((both.probability(2), both.log_probability(2)), (0.0, f64::NEG_INFINITY));
    // 1 + 4 x = 2.2: x = 0.3, in the reach of both.
    let normal = (-0.045f64).exp() / TAU.sqrt();
    close(both.pdf(&Mixed::Continuous(2.2)).value(), (0.25 * normal + 0.75) / 4.0, 64.0);
    drawn(both);
    // Of the continuous part alone, the uniforms of atoms have no sample.
    for k in 0..1000 {
        let u = uniforms::<Ends>(8, k);
        let (x, part) = (both.sample(u), both.continuous().sample(u));
        assert_eq!(part.is_valid(), x.atom().is_none());
        let density = if part.is_valid() { x.pdf().value() } else { 0.0 };
        assert_eq!(both.continuous().pdf_of_uniforms(u).value(), density);
    }
    Battery::<_, f64>::new(&both).jumps(0, [2.0, 4.5]).run().assert_ok();
}

#[test]
fn an_atom_of_a_mixture_without_an_image_is_gone() {
    let walls = (two_walls(-1.0, 0.5).expect("legal"), ends());
    let both = mixture(walls, shares([0.25, 0.75])).expect("two of both").then(below(0.5));
    assert_eq!([0, 1, 7].map(|k| both.place(k)), [Some(-1.0), None, None]);
    drawn(both);
    Battery::<_, f64>::new(&both).jumps(0, [0.25]).run().assert_ok();
}

const ATOMS_OF_BOTH: &[usize] = <(TwoWalls<f64>, Ends) as ComponentsWithAtoms<f64>>::ATOMS;

/// Draws a vertex where a mapped flight ends.
#[strategy]
fn fly_back(path: &PathView<Stop>, extinction: f64, wall: f64) -> Stop {
    let x = draw(flight_of(extinction, 4.0 * wall).then(stretch_of(0.25, 0.0)));
    Stop(x)
}

#[test]
fn a_strategy_draws_from_a_mapped_sampler() {
    let estimator = Estimator::paths(AtTheEnd);
    unbiased(expected(2.0), |k| {
        let arena: Arena<Stop, FlyBack> = Arena::new();
        let mut random = Pcg32::new(6, 0, k);
        let techniques = [0.125, 0.625].map(|extinction| {
            let mut path = arena.sequence();
            path.append(fly_back(extinction, 2.0)).sample(&mut random);
            path
        });
        estimator.sum(combine::<PowerHeuristic, _>(&techniques))
    });
}

#[test]
fn single_precision_is_mapped_alike() {
    let heights = flight::<f32>(2.0, 0.75).expect("legal").then(stretch(4.0, 10.0).expect("legal"));
    assert_eq!(heights.sample([0.99f32]).value(), Mixed::Atom(0, 13.0));
    assert!((heights.probability(0) - (-1.5f32).exp()).abs() < 1e-7);
    battery::check_f32(&heights).assert_ok();
}

#[test]
fn the_battery_checks_samplers_with_atoms_as_a_whole() {
    battery::check(&flight_of(2.0, 0.7)).assert_ok();
    battery::check(&flight_of(2.0, 0.0)).assert_ok();
    battery::check(&uniform_flight(0.95, 2.0).expect("legal")).assert_ok();
    battery::check(&cauchy_walls(-2.0, 0.5).expect("legal")).assert_ok();
    let slab = slab(0.7, 0.5, 2.0).expect("legal");
    Battery::<_, f64>::new(&slab).jumps(0, [0.5, 2.0]).run().assert_ok();
    battery::check(&ends()).assert_ok();
    battery::check(&maybe_a_wall(2.0, 0.5).expect("legal")).assert_ok();
    battery::check(&corner(0.25, 0.5).expect("legal")).assert_ok();
    let mirror = mirror_and_lobe(0.25, Direction::new(0.0, 0.6, 0.8)).expect("legal");
    battery::check(&mirror).assert_ok();
    let both = mixture(
        (flight_of(1.5, 2.0), uniform_flight(0.125, 2.0).expect("legal")),
        shares([0.25, 0.75]),
    );
    let report = battery::check(&both.expect("two of both"));
    report.assert_ok();
    assert!(report.to_string().contains("atom mass    ok"), "{report}");
}

#[test]
fn the_battery_checks_what_maps_make_of_samplers_with_atoms() {
    battery::check(&flight_of(2.0, 0.7).then(stretch_of(4.0, 10.0))).assert_ok();
    battery::check(&flight_of(2.0, 0.7).then(below(0.5))).assert_ok();
    battery::check(&two_walls(-1.0, 2.0).expect("legal").then(squared())).assert_ok();
    let (frame, _) = downwards(Direction::new(0.0, 0.6, 0.8));
    let turned =
        mirror_and_lobe(0.25, Direction::new(0.0, 0.6, 0.8)).expect("legal").then(rotate(frame));
    battery::check(&turned).assert_ok();
    // Only some of the lobe meets the floor: uniforms without a sample are of no simple shape.
    let floor = turned.then(to_floor(Vec3::new(0.5, -1.0, 2.0)));
    battery::check(&floor).assert_ok();
}
