//! Every row of the catalogue against reference values and through the check battery.

use aether_core::battery;
use aether_core::prelude::*;
use tests::batteries;
use tests::catalogue::*;
use tests::checks::{covered, right};
use tests::compare::{IllConditioned, failures, unnoticed, wrong_densities};
use tests::mutation::OnePercentOff;
use tests::reference::Reference;

/// The numbers of the rows that one formula undoes.
const ROWS: [u64; 17] = [1, 2, 3, 4, 5, 18, 19, 23, 42, 57, 60, 61, 62, 63, 64, 93, 107];

/// Where the loss is real all the same, and the full condition number is the limit.
const ILL_CONDITIONED: [IllConditioned; 3] = [
    (1, "sample", "a + (b - a) u next to zero: b - a has been rounded at the size of a"),
    (19, "sample", "a zero of -ln(-ln u): no double represents ln u to more than 53 bits at -1"),
    (57, "pdf(x)", "a nearly singular matrix: its inverse magnifies the rounding of products"),
];

#[test]
fn samples_and_densities_agree_with_the_reference() {
    let failed = failures(&Reference::load(), &ILL_CONDITIONED);
    assert!(failed.is_empty(), "{} failures:\n{}", failed.len(), failed.join("\n"));
}

#[test]
fn queries_have_the_density_of_the_reference() {
    let failed = wrong_densities(&Reference::load());
    assert!(failed.is_empty(), "{} failures:\n{}", failed.len(), failed.join("\n"));
}

#[test]
fn directions_off_the_sphere_cannot_be_made() {
    let queries = Reference::load().queries;
    let directions = queries.iter().filter(|q| (60..=64).contains(&q.inputs.row));
    let mut refused = 0;
    for q in directions {
        let length = q.x.iter().map(|c| c * c).sum::<f64>();
        let made = Direction::try_new(q.x[0], q.x[1], q.x[2]).is_some();
        assert_eq!(made, (length - 1.0).abs() < 1e-14, "{q:?}");
        refused += usize::from(!made);
    }
    assert!(refused > 20);
}

#[test]
fn every_row_has_reference_values() {
    let reference = Reference::load();
    for row in ROWS {
        assert!(reference.points.iter().any(|p| p.inputs.row == row), "row {row}");
        assert!(reference.queries.iter().any(|p| p.inputs.row == row), "row {row}");
    }
    assert!(reference.points.iter().all(|p| ROWS.contains(&p.inputs.row)));
}

#[test]
fn a_density_off_by_one_percent_fails_the_comparison_in_every_row() {
    let reference = Reference::load();
    let missed: Vec<_> = unnoticed(&reference, &ILL_CONDITIONED).collect();
    assert!(missed.is_empty(), "{missed:?}");
}

// The battery in both precisions, for several values of the parameters. Its samplers are the
// catalogue's, its seeds fixed; one seed in a million would make a right sampler fail.
batteries! { [double single]
    row_1_affine: affine(-2.0, 3.0), affine(3.0, -2.0), affine(0.25, 0.5);
    row_2_power: power(1.0), power(2.5), power(7.0), power(0.75);
    row_3_exponential: exponential(1.0), exponential(0.05), exponential(30.0);
    row_4_truncated_exponential: truncated_exponential(1.7, 2.0), truncated_exponential(-3.0, 1.0);
    row_5_linear: right(linear(1.0, 4.0)), right(linear(3.0, 0.5)), right(linear(0.0, 1.0)),
        right(linear(2.0, 2.0));
    row_18_weibull: weibull(2.0, 1.6), weibull(1.0, 2.0), weibull(0.5, 1.0), weibull(1.0, 5.0);
    row_19_gumbel: gumbel(0.0, 1.0), gumbel(-2.0, 0.3);
    row_23_softplus_logistic: softplus_logistic();
    row_42_polar_disk: polar_disk(1.0), polar_disk(20.0), polar_disk(0.125);
    row_57_affine_logistics: affine_logistics(1.0, 0.5, -0.25, 2.0, 0.125, -0.25),
        affine_logistics(0.5, 0.0, 0.75, -1.0, 3.0, 0.0);
    row_60_uniform_sphere: uniform_sphere();
    row_61_equirectangular: equirectangular();
    row_62_uniform_hemisphere: uniform_hemisphere();
    row_63_cosine_hemisphere: cosine_hemisphere();
    row_64_power_cosine: power_cosine(1.0), power_cosine(20.0), power_cosine(0.0),
        power_cosine(3.7);
    row_93_sphere_surface: sphere_surface(Vec3::new(1.0, 2.0, 3.0), 2.5),
        sphere_surface(Vec3::new(-40.0, 0.0, 7.0), 0.5);
    row_107_height_field: height_field(0.75), height_field(-2.0);
}

#[test]
fn row_93_covers_its_sphere() {
    covered(
        sphere_surface(Vec3::new(1.0, 2.0, 3.0), 2.5),
        |t| {
            let (theta, phi) = (PI * t[0], TAU * t[1]);
            let r = 2.5 * theta.sin();
            Surface::new(1.0 + r * phi.cos(), 2.0 + r * phi.sin(), 3.0 + 2.5 * theta.cos())
        },
        |x| {
            let (x, y, z) = (x[0] - 1.0, x[1] - 2.0, x[2] - 3.0);
            vec![x.hypot(y).atan2(z) / PI, y.atan2(x).rem_euclid(TAU) / TAU]
        },
    );
}

#[test]
fn row_107_covers_its_field() {
    covered(
        height_field(0.75),
        |t| Surface::new(t[0], t[1], 0.75 * (PI * t[0]).sin() * (PI * t[1]).sin()),
        |x| vec![x[0], x[1]],
    );
}

#[test]
fn a_density_off_by_one_percent_fails_the_battery() {
    let fails = |report: battery::Report| assert!(!report.is_ok(), "{report}");
    fails(battery::check(&OnePercentOff(affine(-2.0, 3.0))));
    fails(battery::check(&OnePercentOff(power(2.5))));
    fails(battery::check(&OnePercentOff(exponential(1.0))));
    fails(battery::check(&OnePercentOff(truncated_exponential(1.7, 2.0))));
    fails(battery::check(&OnePercentOff(right(linear(1.0, 4.0)))));
    fails(battery::check(&OnePercentOff(weibull(2.0, 1.6))));
    fails(battery::check(&OnePercentOff(gumbel(0.0, 1.0))));
    fails(battery::check(&OnePercentOff(softplus_logistic())));
    fails(battery::check(&OnePercentOff(polar_disk(1.0))));
    fails(battery::check(&OnePercentOff(affine_logistics(1.0, 0.5, -0.25, 2.0, 0.125, -0.25))));
    fails(battery::check(&OnePercentOff(uniform_sphere())));
    fails(battery::check(&OnePercentOff(equirectangular())));
    fails(battery::check(&OnePercentOff(uniform_hemisphere())));
    fails(battery::check(&OnePercentOff(cosine_hemisphere())));
    fails(battery::check(&OnePercentOff(power_cosine(20.0))));
    fails(battery::check_f32(&OnePercentOff(cosine_hemisphere())));
}

/// Compares a derived sampler with its twin.
struct Same(Vec<String>);

impl Same {
    fn expect(
        &mut self,
        name: &str,
        what: &str,
        at: impl std::fmt::Debug,
        [ours, theirs]: [f64; 2],
    ) {
        // Usual forms lose digits next to ends of uniforms. Derived ones do in the density of a sample with a
        // second preimage, which is that of the rounded point.
        let tolerance = match name {
            "cosine of an angle" => 1e-4,
            _ => 1e-8,
        };
        let same = (ours - theirs).abs() <= tolerance * theirs.abs().max(ours.abs());
        let poles = ours.is_infinite() && theirs.is_infinite();
        if !(same || poles) {
            self.0.push(format!("{name}, {what} at {at:?}: {ours}, by hand {theirs}"));
        }
    }
}

impl tests::twins::pairs::Visitor for Same {
    fn visit<S, H>(&mut self, row: u64, name: &'static str, derived: S, by_hand: H)
    where
        S: Sampler<f64>,
        S::Point: tests::points::FromCoordinates<f64> + Copy + std::fmt::Debug,
        H: tests::twins::ByHand<Uniforms = S::Uniforms, Point = S::Point>,
    {
        use aether_core::Uniforms as _;
        let mut numbers = tests::twins::pairs::Numbers::new(1000 + row);
        for i in 0..400 {
            // Every eighth uniform lies next to an end: forms that lose digits there show.
            let u = S::Uniforms::from_fn(|_| match (numbers.number(), numbers.number()) {
                (choice, u) if choice < 0.0625 => 1e-5 * u,
                (choice, u) if choice < 0.125 => 1.0 - 1e-5 * u,
                (_, u) => u,
            });
            let (x, valid, density) = derived.forward_with_pdf(u);
            let (y, by_hand_density) = by_hand.draw(u);
            let (ours, theirs, alone) =
                (x.coordinates(), y.coordinates(), by_hand.sample(u).coordinates());
            let length = theirs.as_ref().iter().map(|c| c * c).sum::<f64>().sqrt();
            for k in 0..ours.as_ref().len() {
                let pair = [ours.as_ref()[k] + 2.0 * length, theirs.as_ref()[k] + 2.0 * length];
                self.expect(name, "point", (u, k), pair);
                let pair = [alone.as_ref()[k] + 2.0 * length, theirs.as_ref()[k] + 2.0 * length];
                self.expect(name, "point without density", (u, k), pair);
            }
            assert!(valid, "{name} at {u:?}");
            self.expect(name, "density of the sample", u, [density.value(), by_hand_density]);
            self.expect(name, "density", x, [derived.pdf(&x).value(), by_hand.pdf(&x)]);
            let stray: S::Point = numbers.stray();
            self.expect(name, "density", stray, [derived.pdf(&stray).value(), by_hand.pdf(&stray)]);
            for point in [x, stray] {
                let told = [derived.pdf_of_finite(&point), derived.pdf_as_is(&point)];
                self.expect(name, "density of what is finite", point, told.map(|p| p.value()));
            }
            let mut broken: Vec<f64> = ours.as_ref().to_vec();
            let place = i % broken.len();
            broken[place] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY][i % 3];
            let broken = aether_core::battery::Space::moved_to(&x, &broken);
            self.expect(
                name,
                "density",
                broken,
                [derived.pdf(&broken).value(), by_hand.pdf(&broken)],
            );
        }
    }
}

#[test]
fn twins_written_by_hand_have_the_same_values() -> Result<(), aether_core::DomainError> {
    let mut same = Same(Vec::new());
    tests::twins::pairs::visit_all(&mut same)?;
    assert!(same.0.is_empty(), "{} differences:\n{}", same.0.len(), same.0.join("\n"));
    // The comparison can fail.
    use tests::twins::pairs::Visitor as _;
    let other = tests::twins::line::Exponential { s: 0.7000001 };
    same.visit(3, "another rate", tests::catalogue::exponential(0.7), other);
    assert!(same.0.len() > 300);
    Ok(())
}

/// Finds twins that are none of an item with the same numbers as parameters.
struct Strangers {
    items: Vec<tests::registry::Item>,
    found: Vec<&'static str>,
}

impl tests::twins::pairs::Visitor for Strangers {
    fn visit<S, H>(&mut self, row: u64, name: &'static str, _: S, _: H)
    where
        S: Sampler<f64>,
        S::Point: tests::points::FromCoordinates<f64> + Copy + std::fmt::Debug,
        H: tests::twins::ByHand<Uniforms = S::Uniforms, Point = S::Point>,
    {
        let item = self.items.iter().find(|item| item.row == row).expect("the item");
        let u = [0.3, 0.65, 0.45];
        // With extreme parameters, twins may lose their digits, and where a limit is asked for, all.
        let usual = |x: &f64| *x == 0.0 || (1e-2..=1e2).contains(&x.abs());
        let mut sets = item.sets.iter().filter(|set| set.iter().all(usual)).peekable();
        assert!(sets.peek().is_some(), "{name}");
        let agree = sets.all(|set| {
            let question =
                tests::stability::Question { u: u.into_iter().collect(), ..Default::default() };
            let answers = tests::stability::ask::<f64>(item, set, &[question]);
            let twin = H::with(set).sample(tests::points::uniforms(&u)).coordinates();
            answers[0]
                .sample
                .iter()
                .zip(twin.as_ref())
                .all(|(x, y)| y.is_nan() || (x - y).abs() < 1e-9 * (1.0 + x.abs()))
        });
        if !agree {
            self.found.push(name);
        }
    }
}

#[test]
fn twins_take_the_parameters_of_their_items() -> Result<(), aether_core::DomainError> {
    use tests::twins::pairs::Visitor as _;

    let mut strangers = Strangers { items: tests::registry::items(), found: vec![] };
    tests::twins::pairs::visit_all(&mut strangers)?;
    assert!(strangers.found.is_empty(), "{:?}", strangers.found);
    let (linear, power) =
        (tests::catalogue::linear(0.4, 1.7)?, tests::twins::line::Power { k: 3.5 });
    strangers.visit(5, "no twin", linear, power);
    assert_eq!(strangers.found, ["no twin"]);
    Ok(())
}

/// The usual form of a height on the sphere loses the digits of the distance from the axis next to the poles; forms that care for
/// the ends of their uniforms and domains keep them.
#[test]
fn digits_that_twins_lose_are_seen() -> Result<(), aether_core::DomainError> {
    let names = ["exponential", "linear", "uniform sphere"].map(str::to_owned);
    let mut pairs = tests::twins::accuracy::EachPair::new(&names);
    tests::twins::pairs::visit_all(&mut pairs)?;
    let rows: Vec<u64> = pairs.errors.keys().copied().collect();
    assert!(rows.starts_with(&[3, 4, 5]), "{rows:?}");
    for (row, loses) in [(3, false), (4, false), (5, false), (60, true)] {
        let errors = &pairs.errors[&row];
        assert!(errors.derived.iter().all(|error| *error < 4.0), "row {row}: {errors:?}");
        assert_eq!(errors.by_hand[0] > 1e3, loses, "row {row}: {errors:?}");
        assert!(loses || errors.by_hand.iter().all(|error| *error < 4.0), "{errors:?}");
    }
    Ok(())
}

/// Both draw the same numbers and make the same connections, so that each sample is compared with itself: any
/// wrong weight shows. The piece by hand needs, for each vertex, its density and the reverse one of the vertex
/// before, and for each connection that carries light both of both ends. The other counts every conditional
/// density that it evaluates, and needs no more.
#[test]
fn bidirectional_paths_carry_what_those_by_hand_do_with_as_many_rays_and_densities() {
    use tests::twins::renderers::{Loop, bidirectional, cornell_box};

    let scene = integrators::scene::Scene::load(&cornell_box(), &[]).expect("the scene");
    let kernels = bidirectional::<integrators::kind::DiffuseRooms>(&scene).expect("kernels");
    let [mut derived, mut by_hand] = kernels.each_ref().map(|kernel| Loop::new(&**kernel, &scene));
    let works = [derived.work(), by_hand.work()];
    // Rounding may let a ray pass by what it otherwise hits.
    assert!(1000 * works[0].rays().abs_diff(works[1].rays()) <= works[1].rays(), "{works:?}");
    assert!(works[0].densities <= works[1].densities, "{works:?}");
    let mut samples = [Vec::new(), Vec::new()];
    derived.each(|_, value| samples[0].extend(value.map(f64::from)));
    by_hand.each(|_, value| samples[1].extend(value.map(f64::from)));
    let pixels = scene.film.width as usize * scene.film.height as usize;
    samples[0].extend((0..pixels).flat_map(|pixel| derived.splat(pixel)));
    samples[1].extend((0..pixels).flat_map(|pixel| by_hand.splat(pixel)));
    let all: f64 = samples[1].iter().sum();
    let differences: f64 = samples[0].iter().zip(&samples[1]).map(|(a, b)| (a - b).abs()).sum();
    assert!(all > 0.0 && differences < 1e-3 * all, "{differences} of {all}");
}

/// Next to a corner the second uniform may be any as far as rounding tells, and the point is one of the triangle.
#[test]
fn next_to_a_corner_far_from_the_origin_a_point_is_of_its_triangle() {
    let v = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
    let far = triangle(v(1000.0, 0.0, 0.0), v(1001.0, 0.0, 0.0), v(1000.5, 1.0, 1.0));
    for k in 0..1000 {
        let u = [1.0 - f32::EPSILON / 2.0, k as f32 / 1000.0];
        let x = far.sample(u).value();
        assert!(far.pdf(&x).value() > 0.0, "{u:?}: {x:?}");
        let off = Surface::new(x.0[0], x.0[1] - 0.1, x.0[2] + 0.1);
        assert_eq!(far.pdf(&off).value(), 0.0, "{u:?}: {off:?}");
    }
}
