//! Two rooms that see each other through a square hole in the slab between them: segments through the
//! hole are sampled by a point of it and a direction, and two rays that find their ends.
//!
//! The lower room has a floor at height 0, the slab is at height 1 and the hole is [0, s]² there; the
//! upper room has a ceiling at height 3, and a wall at x = 5 if it is wanted.

use aether_core::pairs::{on_first, on_second};
use aether_core::prelude::*;
use aether_core::strategy::{Conditional, Drawn, DrawnRun, Reads, Recall, Strategy, Vertex};
use aether_core::{
    Arena, BalanceHeuristic, Estimator, PathIntegrand, PathView, Pcg32, UniformSource, combine,
    strategies,
};

use crate::oracle::{LIMIT, chi_square};
use crate::world::Mean;

/// A plane of the rooms.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Wall {
    point: Vec3,
    normal: Vec3,
    id: SurfaceId,
}

#[derive(Clone, Copy, Debug)]
struct Hit {
    point: SurfacePoint,
    wall: Wall,
}

impl Vertex for Hit {
    type Real = f64;
    type Point = SurfacePoint;
    fn point(&self) -> SurfacePoint {
        self.point
    }
}

impl Recall<Wall> for Hit {
    fn recall(&self) -> Option<Wall> {
        Some(self.wall)
    }
}

/// The rooms: the side of the hole, and where the wall is.
struct Rooms {
    hole: f64,
    wall: f64,
}

const SMALL: Rooms = Rooms { hole: 0.5, wall: 5.0 };
const FLOOR: usize = 0;
const CEILING: usize = 1;

impl Rooms {
    fn walls(&self) -> [Wall; 3] {
        let wall = |point, normal, id| Wall { point, normal, id: SurfaceId(id) };
        let (up, along) = (Vec3::new(0.0, 0.0, 1.0), Vec3::new(1.0, 0.0, 0.0));
        [
            wall(Vec3::new(0.0, 0.0, 0.0), up, 1),
            wall(Vec3::new(0.0, 0.0, 3.0), up, 2),
            wall(self.wall * along, along, 3),
        ]
    }

    /// What a ray from the hole meets in the direction of ±w.
    fn cast(&self, hole: Vec2, w: Vec3) -> Option<Wall> {
        let from = in_space(hole);
        let [floor, ceiling, wall] = self.walls();
        let distance = |wall: &Wall| wall.normal.dot(wall.point - from) / wall.normal.dot(w);
        if w.z < 0.0 {
            return Some(floor);
        }
        let by_wall = distance(&wall) > 0.0 && distance(&wall) < distance(&ceiling);
        Some(if by_wall { wall } else { ceiling })
    }
}

fn in_space(hole: Vec2) -> Vec3 {
    Vec3::new(hole.x, hole.y, 1.0)
}

/// A point of the hole, and a direction through it.
#[sampler(s in 1e-3..=1.0)]
fn ray_through_hole(u: [Uniform; 4], s: f64) -> (Vec2, Direction) {
    let r = u[2].sqrt();
    let phi = TAU * u[3];
    let w = Direction::new(r * phi.cos(), r * phi.sin(), (1.0 - u[2]).sqrt());
    (Vec2::new(s * u[0], s * u[1]), w)
}

/// Where a ray meets a plane.
#[map]
fn hit_plane(w: Direction, origin: Vec3, point: Vec3, normal: Vec3, id: SurfaceId) -> SurfacePoint {
    let t = normal.dot(point - origin) / normal.dot(w);
    require(t > 0.0);
    SurfacePoint::new(origin + t * w, id)
}

/// Where the line from a point through one of the hole meets a plane.
#[map]
fn behind(hole: Vec2, from: Vec3, point: Vec3, normal: Vec3, id: SurfaceId) -> SurfacePoint {
    let through = Vec3::new(hole.x, hole.y, 1.0) - from;
    let t = normal.dot(point - from) / normal.dot(through);
    require(t > 0.0);
    SurfacePoint::new(from + t * through, id)
}

/// The ends of a segment through the hole, the lower one first.
#[strategy(connected = true)]
fn portal(path: &PathView<Hit>, rooms: &Rooms) -> [Hit; 2] {
    let rays = given(ray_through_hole(rooms.hole).ok());
    let ray = draw(rays);
    let up: Wall = constant(rooms.cast(ray.0, ray.1.vec()));
    let down: Wall = constant(rooms.cast(ray.0, -ray.1.vec()));
    let above = on_second(|hole: &Vec2| hit_plane(in_space(*hole), up.point, up.normal, up.id));
    let below = on_first(|x: &SurfacePoint| behind(x.position, down.point, down.normal, down.id));
    let ends = below.apply(&above.apply(&ray));
    [Hit { point: ends.0, wall: down }, Hit { point: ends.1, wall: up }]
}

/// A square of a horizontal plane.
#[sampler(side in 1e-3..=1e3)]
fn square(u: [Uniform; 2], corner: Vec3, side: f64, id: SurfaceId) -> SurfacePoint {
    SurfacePoint::new(corner + Vec3::new(side * u[0], side * u[1], 0.0), id)
}

/// A point of the hole.
#[sampler(s in 1e-3..=1.0)]
fn in_hole(u: [Uniform; 2], s: f64) -> Vec2 {
    Vec2::new(s * u[0], s * u[1])
}

/// Anywhere in a square of the floor or the ceiling.
#[strategy]
fn anywhere(path: &PathView<Hit>, rooms: &Rooms, wall: usize, corner: f64, side: f64) -> Hit {
    let wall = constant(Some(rooms.walls()[wall]));
    let from = Vec3::new(corner, corner, wall.point.z);
    let square = given(square(from, side, wall.id).ok());
    let x = draw(square);
    Hit { point: x, wall }
}

/// Through the hole, to the floor or the ceiling.
#[strategy]
fn onwards(path: &PathView<Hit>, rooms: &Rooms, wall: usize) -> Hit {
    let here = given(path.last());
    let wall = constant(Some(rooms.walls()[wall]));
    let hole = given(in_hole(rooms.hole).ok());
    let q = draw(hole);
    let x = behind(here.point.position, wall.point, wall.normal, wall.id).apply(&q);
    Hit { point: x, wall }
}

/// A joint strategy with a density that is wrong by one percent.
#[derive(Clone)]
struct Misjudged<S>(S);

impl<S: Strategy<Hit>> Strategy<Hit> for Misjudged<S> {
    const VERTICES: usize = S::VERTICES;
    fn sample<U>(&self, _: PathView<'_, Hit>, _: &mut U) -> Option<Drawn<Hit>>
    where
        U: UniformSource<f64> + ?Sized,
    {
        None
    }
    fn pdf(&self, _: PathView<'_, Hit>, _: &Hit) -> Conditional<f64> {
        Conditional::ZERO
    }
    fn sample_joint<U>(&self, path: PathView<'_, Hit>, uniforms: &mut U) -> Option<DrawnRun<Hit>>
    where
        U: UniformSource<f64> + ?Sized,
    {
        let mut drawn = self.0.sample_joint(path, uniforms)?;
        drawn.value = None;
        Some(drawn)
    }
    fn pdf_joint(&self, path: PathView<'_, Hit>, targets: &[Hit]) -> f64 {
        1.01 * self.0.pdf_joint(path, targets)
    }
    fn reads(&self) -> Reads {
        self.0.reads()
    }
}

strategies! {
    #[derive(Clone)]
    enum Ways<'r> for Hit {
        Anywhere(Anywhere<'r>),
        Onwards(Onwards<'r>),
        Portal(Portal<'r>),
        Wrong(Misjudged<Portal<'r>>),
    }
}

const NOWHERE: PathView<'_, Hit> = PathView::from_slice(&[]);

fn segment(rooms: &Rooms, sample: u64) -> Option<DrawnRun<Hit>> {
    portal(rooms).sample_joint(NOWHERE, &mut Pcg32::new(7, 0, sample))
}

#[test]
fn the_density_is_that_of_the_textbook() {
    let mut hits = [0; 4];
    for sample in 0..2000 {
        // Whatever the direction, it meets something below and above.
        let rooms = Rooms { wall: 2.0, ..SMALL };
        let drawn = segment(&rooms, sample).expect("a segment");
        let &[below, above] = drawn.vertices() else { panic!("{drawn:?}") };
        hits[above.wall.id.0 as usize] += 1;
        let (y, z) = (below.point.position, above.point.position);
        // p(x) p(w) cos_y cos_z / (cos_x |y - z|²), with p(w) = cos_x / π and all surfaces but the wall
        // at right angles to the axis.
        let (edge, distance) = (z - y, (z - y).length());
        let cosine = |wall: Wall| (wall.normal.dot(edge) / distance).abs();
        let expected = cosine(below.wall) * cosine(above.wall) / (PI * 0.25 * distance * distance);
        let p = portal(&rooms).pdf_joint(NOWHERE, &[below, above]);
        assert!((p / expected - 1.0).abs() < 1e-11, "{p} {expected}");
        assert!((drawn.value.expect("told from what was drawn") / p - 1.0).abs() < 1e-11);
        // The other way round, and beside the hole.
        assert_eq!(portal(&rooms).pdf_joint(NOWHERE, &[above, below]), 0.0);
        if above.wall.id == SurfaceId(2) {
            let mut aside = below;
            aside.point.position.x += 2.0;
            assert_eq!(portal(&rooms).pdf_joint(NOWHERE, &[aside, above]), 0.0);
        }
        assert_eq!(portal(&rooms).pdf_joint(NOWHERE, &[below]), 0.0);
    }
    assert!(hits[2] > 200 && hits[3] > 200, "{hits:?}");
}

/// Which quarter of the hole a segment passes, and in which ninth of the unit square of the floor it
/// begins; none if it begins elsewhere or ends on the wall.
fn cell(below: &Hit, above: &Hit) -> Option<usize> {
    let hole = below.point.position + (above.point.position - below.point.position) / 3.0;
    let place = |x: f64, parts: f64| (0.0..1.0).contains(&x).then_some((x * parts) as usize);
    let (i, j) = (place(below.point.position.x, 3.0)?, place(below.point.position.y, 3.0)?);
    let (k, l) = (place(hole.x / SMALL.hole, 2.0)?, place(hole.y / SMALL.hole, 2.0)?);
    (above.wall.id == SurfaceId(2)).then_some(((i * 3 + j) * 2 + k) * 2 + l)
}

#[test]
fn samples_fall_where_the_density_says() {
    const N: usize = 12;
    let (strategy, [floor, ceiling, _]) = (portal(&SMALL), SMALL.walls());
    let mut expected = [0.0; 37];
    let grid = || (0..N * N).map(|k| ((k / N) as f64 + 0.5, (k % N) as f64 + 0.5));
    for (x, y) in grid() {
        for (p, q) in grid() {
            let n = N as f64;
            let a = Vec3::new(x / n, y / n, 0.0);
            let hole = Vec3::new(SMALL.hole * p / n, SMALL.hole * q / n, 1.0);
            let b = a + 3.0 * (hole - a);
            let below = Hit { point: SurfacePoint::new(a, floor.id), wall: floor };
            let above = Hit { point: SurfacePoint::new(b, ceiling.id), wall: ceiling };
            let area = 9.0 * SMALL.hole.powi(2) / n.powi(4);
            let k = cell(&below, &above).expect("inside");
            expected[k] += area * strategy.pdf_joint(NOWHERE, &[below, above]);
        }
    }
    expected[36] = 1.0 - expected.iter().sum::<f64>();
    const COUNT: u64 = 60_000;
    let mut counts = [0.0; 37];
    for sample in 0..COUNT {
        let drawn = segment(&SMALL, sample).expect("a segment");
        let &[below, above] = drawn.vertices() else { panic!("{drawn:?}") };
        counts[cell(&below, &above).unwrap_or(36)] += 1.0;
    }
    let score = |scale: f64| chi_square(&counts, &expected.map(|p| scale * p * COUNT as f64));
    assert!(expected[36] > 0.1 && expected[36] < 0.9, "{expected:?}");
    assert!(score(1.0) < LIMIT, "{}", score(1.0));
    assert!(score(1.1) > LIMIT, "an error of a tenth would be found: {}", score(1.1));
}

/// (1 + a_x)(2 + b_x / 2) for segments from the unit square of the floor through the hole to the
/// ceiling; it counts shadow rays by the sign of what is not known to be visible.
struct Light;

impl PathIntegrand for Light {
    type Vertex = Hit;
    type Value = f64;
    fn extend(&self, path: PathView<'_, Hit>) -> f64 {
        let (Some(a), Some(b)) = (path.back(1), path.last()) else { return 1.0 };
        let (x, y) = (a.point.position, b.point.position);
        let on_floor = (0.0..1.0).contains(&x.x) && (0.0..1.0).contains(&x.y);
        let hole = x + (y - x) / 3.0;
        let inside = |x: f64| (0.0..SMALL.hole).contains(&x);
        let sees = path.visible(1) || (inside(hole.x) && inside(hole.y));
        if on_floor && sees && b.wall.id == SurfaceId(2) {
            (1.0 + x.x) * (2.0 + y.x / 2.0)
        } else {
            0.0
        }
    }
    fn end(&self, _: PathView<'_, Hit>) -> f64 {
        1.0
    }
}

/// The integral: b = 3 h - 2 a with h in the hole, and the area of the hole's shadow is nine times
/// that of the hole.
fn exact() -> f64 {
    let s = SMALL.hole;
    // The mean of (1 + a)(2 + 3 h / 2 - a) over a in [0, 1] and h in [0, s].
    9.0 * s * s * (1.5 * (2.0 + 0.75 * s) - (0.5 + 1.0 / 3.0))
}

/// How many standard errors the estimate by some techniques is off; |z| > 5 is a false alarm with
/// probability 6e-7, and the seed is fixed.
fn z(count: u64, techniques: &[usize]) -> f64 {
    let estimator = Estimator::paths(Light);
    let mut arena: Arena<Hit, Ways<'_>> = Arena::new();
    let mut mean = Mean::default();
    for sample in 0..count {
        arena.clear();
        let mut uniforms = Pcg32::new(11, 0, sample);
        let paths = arena.collect(techniques.iter().map(|technique| {
            let mut path = arena.sequence();
            match technique {
                0 => path.append(portal(&SMALL)),
                1 => path
                    .append(anywhere(&SMALL, FLOOR, 0.0, 1.0))
                    .append(anywhere(&SMALL, CEILING, -2.0, 3.5)),
                2 => {
                    path.append(anywhere(&SMALL, FLOOR, 0.0, 1.0)).append(onwards(&SMALL, CEILING))
                }
                3 => {
                    path.append(anywhere(&SMALL, CEILING, -2.0, 3.5)).append(onwards(&SMALL, FLOOR))
                }
                _ => path.append(Misjudged(portal(&SMALL))),
            };
            path.sample(&mut uniforms);
            if *technique == 3 { path.reverse() } else { path }
        }));
        mean.add(estimator.sum(combine::<BalanceHeuristic, _>(paths)));
    }
    mean.z(exact())
}

#[test]
fn alone_and_with_one_vertex_at_a_time_it_is_unbiased() {
    for techniques in [&[0][..], &[1], &[0, 1], &[0, 2], &[0, 1, 2, 3]] {
        let z = z(50_000, techniques);
        assert!(z.abs() < 5.0, "{techniques:?}: {z}");
    }
}

#[test]
fn one_percent_in_its_density_would_be_found() {
    let (right, wrong) = (z(1_200_000, &[0, 2]), z(1_200_000, &[4, 2]));
    assert!(right.abs() < 5.0 && wrong.abs() > 5.0, "{right} {wrong}");
}
