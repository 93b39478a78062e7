//! A scattering medium between two walls: free flight reaches a wall, which is an atom, or ends in the
//! medium, with a density. Everything has an exact answer.
//!
//! A mean that is off by more than four standard errors is a false alarm with probability 6e-5; the
//! seeds are fixed.

use crate::oracle::{LIMIT, chi_square, midpoint};
use aether_core::prelude::*;
use aether_core::strategy::{Conditional, Dirac, Drawn, Reads, Recall, Strategy, Vertex};
use aether_core::{
    Arena, Estimator, Includes, PathIntegrand, PathView, Pcg32, PowerHeuristic, UniformSource,
    coin, combine, strategies,
};

/// The walls, at zero and at the length of the rod.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Wall {
    Left,
    Right,
}

/// Where a vertex is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Place {
    Wall(Wall),
    Medium(f64),
}

impl Includes<f64> for Place {
    fn part(&self) -> Option<f64> {
        if let Place::Medium(x) = self { Some(*x) } else { None }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Spot(Place);

impl Vertex for Spot {
    type Real = f64;
    type Point = Place;
    fn point(&self) -> Place {
        self.0
    }
}

impl Recall<Wall> for Spot {
    fn recall(&self) -> Option<Wall> {
        if let Place::Wall(wall) = self.0 { Some(wall) } else { None }
    }
}

impl Spot {
    fn on(wall: Wall) -> Spot {
        Spot(Place::Wall(wall))
    }
    fn inside(x: f64) -> Spot {
        Spot(Place::Medium(x))
    }
    /// Its coordinate.
    fn x(&self, rod: &Rod) -> f64 {
        match self.0 {
            Place::Wall(Wall::Left) => 0.0,
            Place::Wall(Wall::Right) => rod.length,
            Place::Medium(x) => x,
        }
    }
}

/// A rod in which light travels to the right or to the left, scattered without loss, either way with
/// equal probability. The left wall is a black camera; the right wall emits and reflects; the medium
/// emits too.
#[derive(Clone, Copy, Debug)]
struct Rod {
    length: f64,
    extinction: f64,
    wall_emission: f64,
    reflectance: f64,
    /// Per unit length, into either direction together.
    emission: f64,
    /// A lamp beside the rod lights its points (instead of scattered light): where, and how far away.
    lamp: Option<(f64, f64)>,
}

const ROD: Rod = Rod {
    length: 1.7,
    extinction: 0.8,
    wall_emission: 1.3,
    reflectance: 0.4,
    emission: 0.6,
    lamp: None,
};

impl Rod {
    /// What arrives at the camera: the solution of the two-stream equations, in which the net flux
    /// grows by the emission and the total falls by the extinction times the net flux.
    fn exact(&self) -> f64 {
        let (r, q, d, s) = (self.reflectance, self.emission, self.length, self.extinction);
        let sources =
            2.0 * self.wall_emission + (1.0 - r) * s * q * d * d / 2.0 + (1.0 + r) * q * d;
        sources / ((1.0 - r) * (1.0 + s * d) + 1.0 + r)
    }

    fn transmittance(&self, distance: f64) -> f64 {
        (-self.extinction * distance).exp()
    }

    /// The chance to go on to the right.
    fn chance_of_right(&self, from: &Spot) -> f64 {
        match from.0 {
            Place::Wall(Wall::Left) => 1.0,
            Place::Wall(Wall::Right) => 0.0,
            Place::Medium(_) => 0.5,
        }
    }
}

/// Free flight that is known to end where a fraction `mass` of all flights do.
#[sampler(extinction in 1e-3..=1e3, mass in 1e-6..=1.0)]
fn flight(u: [Uniform; 1], extinction: f64, mass: f64) -> f64 {
    -(-mass * u[0]).ln_1p() / extinction
}

/// From a distance to a coordinate.
#[map]
fn along(t: f64, start: f64, way: f64) -> f64 {
    start + way * t
}

/// Uniform on [0, length).
#[sampler]
fn uniform_on(u: [Uniform; 1], length: f64) -> f64 {
    length * u[0]
}

/// Points of a line that a lamp beside it sees at equal angles, from a before its foot to b beyond it.
#[sampler(a in -1.57..=-0.01, b in 0.01..=1.57)]
fn equiangular(u: [Uniform; 1], foot: f64, height: f64, a: f64, b: f64) -> f64 {
    foot + height * (a + (b - a) * u[0]).tan()
}

/// The camera.
#[strategy]
fn camera(path: &PathView<Spot>) -> Spot {
    let wall = constant(Some(Wall::Left));
    Spot::on(wall)
}

/// Goes on in some direction, to a wall if nothing comes between. Survives with some probability.
#[strategy]
fn fly(path: &PathView<Spot>, rod: &Rod, survival: f64) -> Spot {
    let here = given(path.last());
    let x = here.x(rod);
    if !choose(coin(survival)) {
        return stop();
    }
    let right = choose(coin(rod.chance_of_right(&here)))
        .identified_by(|v: &Spot| Some(usize::from(v.x(rod) > x)));
    let distance = if right { rod.length - x } else { x };
    let transmittance = rod.transmittance(distance);
    let arrives = choose(coin(transmittance))
        .identified_by(|v: &Spot| Some(usize::from(matches!(v.0, Place::Wall(_)))));
    if arrives {
        let wall = constant(Some(if right { Wall::Right } else { Wall::Left }));
        return Spot::on(wall);
    }
    let flight = given(flight(rod.extinction, 1.0 - transmittance).ok());
    let t = draw(flight);
    let y = along(x, if right { 1.0 } else { -1.0 }).apply(&t);
    Spot::inside(y)
}

/// A point of the medium, all equally likely.
#[strategy]
fn uniform_distance(path: &PathView<Spot>, rod: &Rod) -> Spot {
    let x = draw(uniform_on(rod.length));
    Spot::inside(x)
}

/// A point of the medium as the lamp sees it.
#[strategy]
fn seen_by_lamp(path: &PathView<Spot>, rod: &Rod) -> Spot {
    let (foot, height) = given(rod.lamp);
    let a = (-foot / height).atan();
    let b = ((rod.length - foot) / height).atan();
    let points = given(equiangular(foot, height, a, b).ok());
    let x = draw(points);
    Spot::inside(x)
}

/// The right wall.
#[strategy]
fn to_wall(path: &PathView<Spot>) -> Spot {
    let wall = constant(Some(Wall::Right));
    Spot::on(wall)
}

/// A strategy whose probabilities of atoms are wrong by a factor, to see tests fail.
#[derive(Clone, Copy)]
struct Misjudged<S>(S, f64);

impl<S> Misjudged<S> {
    fn factor(&self, dirac: Option<Dirac>) -> f64 {
        if dirac.is_some() { self.1 } else { 1.0 }
    }
}

impl<S: Strategy<Spot>> Strategy<Spot> for Misjudged<S> {
    fn sample<U: UniformSource<f64> + ?Sized>(
        &self,
        path: PathView<'_, Spot>,
        uniforms: &mut U,
    ) -> Option<Drawn<Spot>> {
        let right = self.0.sample(path, uniforms)?;
        Some(Drawn { value: right.value.map(|value| value * self.factor(right.dirac)), ..right })
    }
    fn pdf(&self, path: PathView<'_, Spot>, target: &Spot) -> Conditional<f64> {
        let right = self.0.pdf(path, target);
        Conditional { value: right.value * self.factor(right.dirac), ..right }
    }
    fn reads(&self) -> Reads {
        self.0.reads()
    }
}

strategies! {
    #[derive(Clone)]
    enum Ways<'r> for Spot {
        Camera(Camera),
        Fly(Fly<'r>),
        Misjudged(Misjudged<Fly<'r>>),
        UniformDistance(UniformDistance<'r>),
        SeenByLamp(SeenByLamp<'r>),
        ToWall(ToWall),
    }
}

/// What the camera sees.
struct Seen<'r>(&'r Rod);

impl PathIntegrand for Seen<'_> {
    type Vertex = Spot;
    type Value = f64;
    fn extend(&self, path: PathView<'_, Spot>) -> f64 {
        let (Some(before), Some(last)) = (path.back(1), path.last()) else { return 1.0 };
        let (from, to) = (before.x(self.0), last.x(self.0));
        let scatters = match before.0 {
            Place::Medium(_) => 0.5 * self.0.extinction,
            Place::Wall(Wall::Right) => self.0.reflectance,
            // The camera looks, and reflects nothing.
            Place::Wall(Wall::Left) => f64::from(u8::from(path.len() == 2)),
        };
        let turned_back = from == to;
        if turned_back { 0.0 } else { scatters * self.0.transmittance((from - to).abs()) }
    }
    fn end(&self, path: PathView<'_, Spot>) -> f64 {
        match (path.last().map(|spot| spot.0), self.0.lamp) {
            (Some(Place::Medium(x)), Some((foot, height))) => {
                self.0.extinction / (height * height + (x - foot).powi(2))
            }
            (Some(Place::Medium(_)), None) => 0.5 * self.0.emission,
            (Some(Place::Wall(Wall::Right)), _) => self.0.wall_emission,
            _ => 0.0,
        }
    }
}

/// Distance of the mean of many estimates from the exact value, in standard errors.
fn z<'r>(exact: f64, estimate: impl Fn(&Arena<Spot, Ways<'r>>, &mut Pcg32) -> f64) -> f64 {
    let (mut sum, mut squares, count) = (0.0, 0.0, 100_000);
    let mut arena = Arena::new();
    for sample in 0..count {
        arena.clear();
        let value = estimate(&arena, &mut Pcg32::new(8, 0, sample));
        (sum, squares) = (sum + value, squares + value * value);
    }
    let n = count as f64;
    let mean = sum / n;
    (mean - exact) / ((squares / n - mean * mean) / (n - 1.0)).sqrt()
}

/// One camera path, and each of its prefixes combined with other ways to go on.
fn trace<'r>(
    rod: &'r Rod,
    arena: &Arena<Spot, Ways<'r>>,
    uniforms: &mut Pcg32,
    flight: &Ways<'r>,
    others: &[Ways<'r>],
    longest: usize,
) -> f64 {
    let estimator = Estimator::paths(Seen(rod));
    let mut walk = arena.sequence();
    walk.append(camera()).sample(uniforms);
    while walk.is_complete() && walk.size() < longest {
        walk.append(flight.clone()).sample(uniforms);
    }
    let mut seen = 0.0;
    for length in 1..walk.size() {
        let mut techniques = vec![walk.slice(0..length + 1)];
        for other in others {
            let mut path = walk.slice(0..length);
            path.append(other.clone()).sample(uniforms);
            techniques.push(path);
        }
        seen += estimator.sum(combine::<PowerHeuristic, _>(&techniques));
    }
    seen
}

#[test]
fn multiple_scattering_between_walls_has_the_exact_brightness() {
    let rod = ROD;
    let all = [Ways::from(uniform_distance(&rod)), Ways::from(to_wall())];
    for others in [&all[..], &all[..1], &all[1..], &[]] {
        let z = z(rod.exact(), |arena, uniforms| {
            trace(&rod, arena, uniforms, &fly(&rod, 0.9).into(), others, 200)
        });
        assert!(z.abs() < 4.0, "{} other techniques: {z}", others.len());
    }
}

#[test]
fn a_wrong_probability_of_the_wall_is_found() {
    let rod = ROD;
    let wrong = Ways::from(Misjudged(fly(&rod, 0.9), 1.05));
    let others = [Ways::from(uniform_distance(&rod)), Ways::from(to_wall())];
    let z = z(rod.exact(), |arena, uniforms| trace(&rod, arena, uniforms, &wrong, &others, 200));
    assert!(z.abs() > 4.0, "{z}");
}

/// Light of a lamp that is scattered once, before a wall that glows.
#[test]
fn single_scattering_before_a_wall_has_the_exact_brightness() {
    for (foot, height) in [(0.9, 0.05), (0.3, 1.0)] {
        let rod = Rod { lamp: Some((foot, height)), ..ROD };
        let scattered = midpoint(0.0, rod.length, 1_000_000, |x| {
            rod.transmittance(x) * rod.extinction / (height * height + (x - foot).powi(2))
        });
        let exact = scattered + rod.transmittance(rod.length) * rod.wall_emission;
        let others = [
            Ways::from(uniform_distance(&rod)),
            Ways::from(seen_by_lamp(&rod)),
            Ways::from(to_wall()),
        ];
        let z = z(exact, |arena, uniforms| {
            trace(&rod, arena, uniforms, &fly(&rod, 1.0).into(), &others, 2)
        });
        assert!(z.abs() < 4.0, "lamp at {foot}, {height}: {z}");
    }
}

#[test]
fn flights_have_an_atom_at_the_wall_and_a_density_before_it() {
    let rod = ROD;
    let here = [Spot::inside(0.6)];
    let view = PathView::from_slice(&here);
    let strategy = fly(&rod, 0.9);
    let s = rod.extinction;
    let density = |x: f64| strategy.pdf(view, &Spot::inside(x)).value;
    let atom = |wall| strategy.pdf(view.asking(Some(Dirac::Position)), &Spot::on(wall)).value;
    // In closed form.
    for x in [0.1, 0.5, 0.7, 1.6] {
        let expected = 0.9 * 0.5 * s * (-s * (x - 0.6_f64).abs()).exp();
        assert!((density(x) - expected).abs() < 1e-14, "{x}");
    }
    assert!((atom(Wall::Left) - 0.45 * (-s * 0.6).exp()).abs() < 1e-15);
    assert!((atom(Wall::Right) - 0.45 * (-s * 1.1).exp()).abs() < 1e-15);
    assert_eq!((density(-0.1), density(1.8)), (0.0, 0.0));
    // A wall has no density, a point of the medium no probability.
    assert_eq!(strategy.pdf(view, &Spot::on(Wall::Left)).value, 0.0);
    assert_eq!(strategy.pdf(view.asking(Some(Dirac::Position)), &Spot::inside(0.2)).value, 0.0);
    // All of it together is the probability to survive.
    let mass = midpoint(0.0, 0.6, 10_000, density) + midpoint(0.6, rod.length, 10_000, density);
    assert!((mass + atom(Wall::Left) + atom(Wall::Right) - 0.9).abs() < 1e-8);

    // And samples are where it says: cells of the medium, the walls, and nowhere.
    let (cells, count) = (34, 100_000);
    let width = rod.length / f64::from(cells);
    let mut counts = vec![0.0; cells as usize + 3];
    for k in 0..count {
        let drawn = strategy.sample(view, &mut Pcg32::new(4, 0, k));
        let cell = match drawn.map(|drawn| drawn.vertex.0) {
            None => cells as usize,
            Some(Place::Wall(Wall::Left)) => cells as usize + 1,
            Some(Place::Wall(Wall::Right)) => cells as usize + 2,
            Some(Place::Medium(x)) => (x / width) as usize,
        };
        let atom = matches!(drawn, Some(Drawn { dirac: Some(Dirac::Position), .. }));
        assert_eq!(atom, cell > cells as usize);
        counts[cell] += 1.0;
    }
    let cell = |k: i32| midpoint(width * f64::from(k), width * f64::from(k + 1), 1000, density);
    let mut expected: Vec<f64> = (0..cells).map(cell).collect();
    expected.extend([0.1, atom(Wall::Left), atom(Wall::Right)]);
    let expected: Vec<f64> = expected.iter().map(|p| p * count as f64).collect();
    assert!(chi_square(&counts, &expected) < LIMIT);
    // A wrong atom would be found.
    let mut wrong = expected.clone();
    wrong[cells as usize + 1] *= 1.05;
    wrong[cells as usize + 2] *= 0.95;
    assert!(chi_square(&counts, &wrong) > LIMIT);
}

/// A place in a scene with surfaces and media, which have measures of their own.
#[derive(Clone, Copy, Debug)]
enum SceneSpot {
    Surface(SurfacePoint),
    Medium(Vec3),
}

impl Includes<SurfacePoint> for SceneSpot {
    fn part(&self) -> Option<SurfacePoint> {
        if let SceneSpot::Surface(x) = self { Some(*x) } else { None }
    }
}

impl Includes<Vec3> for SceneSpot {
    fn part(&self) -> Option<Vec3> {
        if let SceneSpot::Medium(x) = self { Some(*x) } else { None }
    }
}

impl Vertex for SceneSpot {
    type Real = f64;
    type Point = SceneSpot;
    fn point(&self) -> SceneSpot {
        *self
    }
}

/// Uniform on the rectangle with sides a and b at the height c.
#[sampler]
fn lid(u: [Uniform; 2], a: f64, b: f64, c: f64, id: SurfaceId) -> SurfacePoint {
    SurfacePoint::new(Vec3::new(a * u[0], b * u[1], c), id)
}

/// Uniform in the box with sides a, b and c.
#[sampler]
fn in_box(u: [Uniform; 3], a: f64, b: f64, c: f64) -> Vec3 {
    Vec3::new(a * u[0], b * u[1], c * u[2])
}

#[strategy]
fn lid_or_box(path: &PathView<SceneSpot>, on_lid: f64) -> SceneSpot {
    if choose(coin(on_lid)) {
        let x = draw(lid(2.0, 3.0, 4.0, SurfaceId(7)));
        SceneSpot::Surface(x)
    } else {
        let x = draw(in_box(2.0, 3.0, 4.0));
        SceneSpot::Medium(x)
    }
}

#[test]
fn surfaces_and_media_have_densities_of_their_own() {
    let strategy = lid_or_box(0.25);
    let p = |v| strategy.pdf(PathView::from_slice(&[]), &v).value;
    let (on, inside) = (Vec3::new(1.0, 1.0, 4.0), Vec3::new(1.0, 1.0, 2.0));
    let surface = |id| SceneSpot::Surface(SurfacePoint::new(on, SurfaceId(id)));
    assert!((p(surface(7)) - 0.25 / 6.0).abs() < 1e-15);
    assert!((p(SceneSpot::Medium(inside)) - 0.75 / 24.0).abs() < 1e-15);
    // Another surface, and the place of the lid but in the medium's air above it.
    assert_eq!((p(surface(8)), p(SceneSpot::Medium(Vec3::new(1.0, 1.0, 4.5)))), (0.0, 0.0));
    for k in 0..100 {
        let drawn = strategy.sample(PathView::from_slice(&[]), &mut Pcg32::new(1, 0, k)).unwrap();
        assert!(p(drawn.vertex) > 0.0 && drawn.dirac.is_none());
    }
}
