//! Fuzzing of all samplers: `cargo run --release -p tests --bin fuzz -- --evaluations N`.

use std::process::ExitCode;

use tests::fuzz::{Outcome, fuzz};
use tests::registry::items;

const USAGE: &str = "fuzz [--evaluations N] [--seed N] [NAME...]   (a million evaluations, seed 1)";

fn main() -> ExitCode {
    let (mut evaluations, mut seed, mut names) = (1_000_000u64, 1u64, Vec::new());
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let number = match word.as_str() {
            "--evaluations" => &mut evaluations,
            "--seed" => &mut seed,
            name if !name.starts_with('-') => {
                names.push(word);
                continue;
            }
            _ => return usage(),
        };
        match words.next().and_then(|n| n.parse().ok()) {
            Some(n) => *number = n,
            None => return usage(),
        }
    }
    // Unoptimised it would be slow; and nothing is compiled for builds that only test.
    if cfg!(debug_assertions) {
        eprintln!("cargo run --release -p tests --bin fuzz, please: this build is not optimised");
        return ExitCode::from(2);
    }
    let mut items = items();
    items.retain(|i| names.is_empty() || names.iter().any(|n| i.name.contains(n.as_str())));
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get() as u64);
    let each = evaluations.div_ceil(2 * threads);
    let mut all = Outcome::default();
    std::thread::scope(|scope| {
        let run = |k| {
            let items = &items;
            scope.spawn(move || {
                let mut found = fuzz::<f64>(items, each, seed + 2 * k);
                found.merge(fuzz::<f32>(items, each, seed + 2 * k + 1));
                found
            })
        };
        let running: Vec<_> = (0..threads).map(run).collect();
        running.into_iter().filter_map(|t| t.join().ok()).for_each(|found| all.merge(found));
    });
    println!("{} evaluations, {} failures", all.evaluations, all.failures);
    all.examples.iter().for_each(|example| println!("{example}"));
    if all.failures == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn usage() -> ExitCode {
    eprintln!("{USAGE}");
    ExitCode::from(2)
}
