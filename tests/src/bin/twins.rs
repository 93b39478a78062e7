//! Derived against hand-written: `cargo run --release -p tests --bin twins`.

use std::process::ExitCode;

use serde_json::{Value, json};
use tests::twins::measure::{COUNTING, Counting, EachOperation, Timing, count_instructions};
use tests::twins::pairs::visit_all;

const USAGE: &str = "\
twins [--json] [NAME...]
  --json  print one object for programs to read
  NAME    only samplers with this in their names";

fn main() -> ExitCode {
    let mut names: Vec<String> = std::env::args().skip(1).collect();
    let mut flag = |flag: &str| {
        let before = names.len();
        names.retain(|name| name != flag);
        names.len() < before
    };
    let (json, counting) = (flag("--json"), flag(COUNTING));
    if names.iter().any(|name| name.starts_with('-')) {
        eprintln!("{USAGE}");
        return ExitCode::from(2);
    }
    // Figures of unoptimised code say nothing; and nothing is compiled for builds that only test.
    if cfg!(debug_assertions) {
        eprintln!("figures need an optimised build: cargo run --release -p tests --bin twins");
        return ExitCode::from(2);
    }
    if counting {
        let mut meter = Counting;
        meter.calibrate();
        return exit(visit_all(&mut EachOperation { meter: &mut meter, names }).map_err(|e| e.to_string()));
    }
    exit(report(json, names))
}

fn exit(result: Result<(), String>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("twins: {message}");
            ExitCode::FAILURE
        }
    }
}

fn report(json: bool, names: Vec<String>) -> Result<(), String> {
    let counts = count_instructions(&names).map_err(|e| e.to_string())?;
    let mut meter = Timing::default();
    visit_all(&mut EachOperation { meter: &mut meter, names }).map_err(|e| e.to_string())?;
    if counts.as_ref().is_some_and(|counts| counts.len() != 2 * meter.rows.len()) {
        return Err("callgrind has counted other loops than were timed".to_owned());
    }
    let counted = |i: usize| counts.as_ref().map(|counts| [counts[2 * i], counts[2 * i + 1]]);
    let rows: Vec<Value> = meter
        .rows
        .iter()
        .enumerate()
        .map(|(i, (row, name, operation, time, time_ratio))| {
            json!({
                "kind": "sampler", "row": row, "name": name, "operation": operation,
                "instructions": counted(i).map(|[ours, theirs]| json!({"derived": ours, "by_hand": theirs})),
                "instruction_ratio": counted(i).map(|[ours, theirs]| ours / theirs),
                "nanoseconds": {"derived": time[0], "by_hand": time[1]},
                "time_ratio": time_ratio,
            })
        })
        .collect();
    if json {
        println!("{:#}", json!({ "rows": rows }));
    } else {
        print(&rows);
    }
    Ok(())
}

fn print(rows: &[Value]) {
    println!("{:<24} {:<10} {:>15} {:>6}   {:>15} {:>6}", "", "", "instructions", "ratio", "nanoseconds", "ratio");
    for row in rows {
        let number = |v: &Value, digits: usize| {
            v.as_f64().map_or("-".to_owned(), |v| format!("{v:.digits$}"))
        };
        let pair = |key: &str| {
            format!("{} / {}", number(&row[key]["derived"], 1), number(&row[key]["by_hand"], 1))
        };
        println!(
            "{:<24} {:<10} {:>15} {:>6}   {:>15} {:>6}",
            row["name"].as_str().unwrap_or_default(),
            row["operation"].as_str().unwrap_or_default(),
            pair("instructions"),
            number(&row["instruction_ratio"], 3),
            pair("nanoseconds"),
            number(&row["time_ratio"], 3),
        );
    }
    for (what, key) in [("instructions", "instruction_ratio"), ("time", "time_ratio")] {
        let mut ratios: Vec<f64> = rows.iter().filter_map(|row| row[key].as_f64()).collect();
        ratios.sort_by(f64::total_cmp);
        if let (Some(middle), Some(worst)) = (ratios.get(ratios.len() / 2), ratios.last()) {
            println!("{what}: median ratio {middle:.3}, worst {worst:.3}");
        }
    }
}
