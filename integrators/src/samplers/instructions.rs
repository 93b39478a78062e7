//! Derived samplers beside code by hand, by the instructions that callgrind counts: loosely, so that a
//! regression shows. The binary `twins` of the crate `tests` measures closely, and many more.

use std::f64::consts::{FRAC_1_PI, PI, TAU};
use std::fs;
use std::hint::black_box;
use std::process::{Command, Stdio};

use aether_core::prelude::*;

use super::{cosine_hemisphere, uniform_cone, uniform_directions, uniform_triangle};

/// Set where this program runs under callgrind.
const COUNTING: &str = "AETHER_COUNTS_INSTRUCTIONS";
/// How many points each loop goes through.
const POINTS: usize = 64;
/// The most that a derived sample may take, over what code by hand does.
const MOST: f64 = 1.25;
/// The same of densities, which are shorter, so that calls count, which a development build does not all inline.
const MOST_OF_DENSITIES: f64 = 1.4;

/// What is counted: callgrind starts where this begins, and writes what it has counted where it ends.
#[inline(never)]
fn counted_loop(inputs: &[[f64; 3]; POINTS], call: &mut dyn FnMut(&[f64; 3])) {
    for input in inputs {
        call(black_box(input));
    }
}

fn by_hand_around(r: f64, z: f64, u: f64) -> [f64; 3] {
    let (s, c) = ((TAU * u).sin(), (TAU * u).cos());
    [r * c, r * s, z]
}

fn finite(w: &[f64; 3]) -> bool {
    w.iter().all(|x| x.is_finite())
}

/// Each row twice, derived and by hand: its name, and what is done with three numbers in [0, 1) or a direction.
fn each(mut count: impl FnMut(&'static str, [&mut dyn FnMut(&[f64; 3]); 2])) {
    let direction = |w: &[f64; 3]| Direction::new(w[0], w[1], w[2]);
    count(
        "cosine_hemisphere, sample",
        [
            &mut |u| {
                black_box(cosine_hemisphere().sample([u[0], u[1]]).value());
            },
            &mut |u| {
                black_box(by_hand_around(u[0].sqrt(), (1.0 - u[0]).sqrt(), u[1]));
            },
        ],
    );
    count(
        "cosine_hemisphere, density",
        [
            &mut |w| {
                black_box(cosine_hemisphere().pdf(&direction(w)).value());
            },
            &mut |w| {
                black_box(if w[2] >= 0.0 && finite(w) { w[2] * FRAC_1_PI } else { 0.0 });
            },
        ],
    );
    count(
        "uniform_directions, sample",
        [
            &mut |u| {
                black_box(uniform_directions().sample([u[0], u[1]]).value());
            },
            &mut |u| {
                let z = 1.0 - 2.0 * u[0];
                black_box(by_hand_around((1.0 - z * z).sqrt(), z, u[1]));
            },
        ],
    );
    count(
        "uniform_directions, density",
        [
            &mut |w| {
                black_box(uniform_directions().pdf(&direction(w)).value());
            },
            &mut |w| {
                black_box(if finite(w) { 0.25 / PI } else { 0.0 });
            },
        ],
    );
    let cone = uniform_cone(black_box(0.25)).expect("a depth between 0 and 1");
    count(
        "uniform_cone, sample",
        [
            &mut |u| {
                black_box(cone.sample([u[0], u[1]]).value());
            },
            &mut |u| {
                let h = black_box(0.25) * u[0];
                black_box(by_hand_around((h * (2.0 - h)).sqrt(), 1.0 - h, u[1]));
            },
        ],
    );
    let corners = [Vec3::new(0.0, 0.1, 0.0), Vec3::new(1.0, 0.0, 0.3), Vec3::new(0.2, 1.0, 0.0)];
    let [a, b, c] = corners;
    let triangle = uniform_triangle(a, b, c, SurfaceId(1));
    count(
        "uniform_triangle, sample",
        [
            &mut |u| {
                black_box(black_box(&triangle).sample([u[0], u[1]]).value());
            },
            &mut |u| {
                let [a, b, c] = *black_box(&corners);
                let s = u[0].sqrt();
                let point = a + s * (1.0 - u[1]) * (b - a) + s * u[1] * (c - a);
                black_box(SurfacePoint::new(point, SurfaceId(1)));
            },
        ],
    );
}

fn inputs() -> [[f64; 3]; POINTS] {
    // A direction of the upper hemisphere, of which the first two coordinates are uniforms too.
    std::array::from_fn(|i| {
        let (x, y) = (0.05 + 0.01 * i as f64, 0.7 - 0.01 * i as f64);
        [x, y, (1.0 - x * x - y * y).sqrt()]
    })
}

/// Instructions of each loop, in order; `None` without valgrind.
fn counts() -> Option<Vec<f64>> {
    let there = Command::new("valgrind").arg("--version").stdout(Stdio::null()).status();
    if !there.is_ok_and(|status| status.success()) {
        return None;
    }
    let directory = std::env::temp_dir().join(format!("aether-counts-{}", std::process::id()));
    fs::create_dir_all(&directory).expect("a directory for counts");
    let status = Command::new("valgrind")
        .args(["--tool=callgrind", "--collect-atstart=no"])
        // Of options with the same pattern only one would count.
        .args(["--toggle-collect=*counted_loop*", "--dump-after=*instructions*counted_loop*"])
        .arg(format!("--callgrind-out-file={}", directory.join("out").display()))
        .arg(std::env::current_exe().expect("this program"))
        .args(["--exact", "samplers::instructions::derived_code_takes_hardly_more_instructions"])
        .env(COUNTING, "1")
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status();
    let totals = (1..).map_while(|i| {
        let text = fs::read_to_string(directory.join(format!("out.{i}"))).ok()?;
        text.lines().find_map(|line| line.strip_prefix("summary: ")?.trim().parse().ok())
    });
    let totals = totals.collect();
    fs::remove_dir_all(&directory).expect("the directory is removed");
    assert!(status.is_ok_and(|status| status.success()), "callgrind failed");
    Some(totals)
}

#[test]
fn derived_code_takes_hardly_more_instructions() {
    let inputs = inputs();
    if std::env::var_os(COUNTING).is_some() {
        each(|_, calls| {
            for call in calls {
                // The first call of a library function resolves its address.
                call(&inputs[0]);
                counted_loop(&inputs, call);
            }
        });
        return;
    }
    let Some(counts) = counts() else {
        eprintln!("skipped: there is no valgrind");
        return;
    };
    let mut names = Vec::new();
    each(|name, _| names.push(name));
    assert_eq!(counts.len(), 2 * names.len(), "{counts:?}");
    let most = |name: &str| if name.ends_with("density") { MOST_OF_DENSITIES } else { MOST };
    let ratios: Vec<_> =
        names.iter().zip(counts.chunks(2)).map(|(n, c)| (n, c[0] / c[1])).collect();
    assert!(ratios.iter().all(|(name, ratio)| *ratio <= most(name)), "{ratios:?} of {counts:?}");
}
