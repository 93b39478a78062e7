//! Maps between spaces of different kinds, and samplers composed of others.

use aether_core::battery;
use aether_core::prelude::*;
use tests::catalogue::{cosine_hemisphere, power_cosine};

/// Where a direction meets the plane at height zero, from above.
#[map]
fn to_floor(w: Direction, eye: Vec3) -> Vec2 {
    let t = -eye.z / w.z;
    require(t > 0.0);
    Vec2::new(eye.x + t * w.x, eye.y + t * w.y)
}

/// A direction given in a frame, in world coordinates.
#[map]
fn rotate(w: Direction, frame: Frame) -> Direction {
    Direction::from_vec(frame.to_world(w))
}

/// A cosine lobe about any axis, in one piece.
#[sampler]
fn framed_cosine(u: [Uniform; 2], frame: Frame) -> Direction {
    let r = u[0].sqrt();
    let phi = TAU * u[1];
    let local = Vec3::new(r * phi.cos(), r * phi.sin(), (1.0 - u[0]).sqrt());
    Direction::from_vec(frame.to_world(local))
}

/// A power lobe about any axis, as a composition.
#[sampler]
fn framed_lobe(u: [Uniform; 2], n: f64, frame: Frame) -> Direction {
    let local = power_cosine(n).sample(u);
    rotate(frame).apply(&local)
}

/// Both ends of an interval onto one.
#[map]
fn folded(x: f64) -> f64 {
    (2.0 * x - 1.0).abs()
}

/// Two directions onto each.
#[map]
fn doubled(w: Direction) -> Direction {
    Direction::new(w.x, w.y, w.z.abs())
}

/// A direction sheared by three vectors: more parameters than simplification can multiply out.
#[map]
fn skew(w: Direction, x: Vec3, y: Vec3, z: Vec3) -> Direction {
    Direction::from_vec((w.x * x + w.y * y + w.z * z).normalize())
}

fn frame(x: f64, y: f64, z: f64) -> Frame {
    Frame::around(Direction::new(x, y, z))
}

#[test]
fn from_a_direction_to_the_plane() {
    let down = rotate(frame(0.2, -0.3, -1.0));
    let lobe = power_cosine(4.0).then(down);
    let floor = to_floor(Vec3::new(1.0, 2.0, 3.0));
    battery::check_map(&floor, &lobe).assert_ok();
    // The change of measure by hand: distance squared over the cosine.
    let w = Direction::new(0.3, 0.1, -0.8);
    let t = -3.0 / w.z;
    let expected = t * t / w.z.abs();
    assert!((Map::<f64>::jacobian(&floor, &w) / expected - 1.0).abs() < 1e-14);
}

#[test]
fn nothing_behind() {
    let floor = to_floor(Vec3::new(0.0, 0.0, 3.0));
    let up = cosine_hemisphere().then(floor);
    assert_eq!(up.pdf(&Vec2::new(0.5, 0.5)).value(), 0.0);
}

#[test]
fn a_composition_is_a_sampler() {
    // The rim of the lobe belongs to the support as long as no rotation rounds it below the horizon.
    battery::check(&framed_lobe(7.0, frame(0.0, 0.0, 1.0))).assert_ok();
}

#[test]
fn a_lobe_in_a_frame() {
    for f in [frame(0.0, 0.0, 1.0), frame(0.3, -0.5, 0.2), frame(-0.1, 0.7, -0.9)] {
        battery::check(&framed_cosine(f)).assert_ok();
        let w = framed_lobe(7.0, f).sample([0.3, 0.6]);
        let same = power_cosine(7.0).then(rotate(f)).pdf(&w).value();
        assert_eq!(framed_lobe(7.0, f).pdf(&w).value(), same);
    }
}

#[test]
fn a_sheared_lobe() {
    let (x, y) = (Vec3::new(1.0, 0.2, 0.0), Vec3::new(0.0, 1.0, 0.1));
    let lobe = power_cosine(1.0).then(skew(x, y, Vec3::new(0.3, -0.2, 1.0)));
    battery::check(&lobe).assert_ok();
}

#[test]
fn maps_know_whether_they_are_injective() {
    fn is_injective<M: Map<f64>>(_: M) -> bool {
        M::INJECTIVE
    }
    let turned = rotate(frame(0.3, -0.5, 0.2));
    assert!(is_injective(turned) && is_injective(turned.then(turned)));
    assert!(!is_injective(folded()) && !is_injective(turned.then(doubled())));
}
