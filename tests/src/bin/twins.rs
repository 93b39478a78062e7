//! Derived against hand-written: `cargo run --release -p tests --bin twins`.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::process::ExitCode;

use integrators::work::Work;
use serde_json::{Value, json};
use tests::twins::accuracy::EachPair;
use tests::twins::measure::{
    COUNTING, Counting, EachOperation, INPUTS, Kind, Meter, Timed, Timing, count_instructions,
};
use tests::twins::pairs::visit_all;
use tests::twins::renderers::visit_integrators;

const USAGE: &str = "\
twins [--json] [NAME...]
  --json  print one object for programs to read
  NAME    only samplers with this in their names";

/// The system's allocator, counting what this thread asks for.
struct CountingAllocator;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

// SAFETY: every call is passed on unchanged to the system's allocator.
unsafe impl GlobalAlloc for CountingAllocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        // SAFETY: the caller's promises are those that the system asks for.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

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
        return exit(measure_all(&mut meter, &names));
    }
    exit(report(json, &names))
}

fn measure_all<M: Meter>(meter: &mut M, names: &[String]) -> Result<(), String> {
    let mut each = EachOperation { meter, names: names.to_vec() };
    visit_all(&mut each).map_err(|e| e.to_string())?;
    visit_integrators(meter, names)
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

fn report(json: bool, names: &[String]) -> Result<(), String> {
    let counts = count_instructions(names).map_err(|e| e.to_string())?;
    let mut meter = Timing { rows: Vec::new(), allocations: || ALLOCATIONS.get() };
    measure_all(&mut meter, names)?;
    if counts.as_ref().is_some_and(|counts| counts.len() != 2 * meter.rows.len() + 1) {
        return Err("callgrind has counted other loops than were timed".to_owned());
    }
    let mut pairs = EachPair::new(names);
    visit_all(&mut pairs).map_err(|e| e.to_string())?;
    let rows: Vec<Value> = meter
        .rows
        .iter()
        .enumerate()
        .map(|(i, row)| {
            let counted = counts.as_ref().map(|counts| {
                let empty = counts[0] * row.task.calls as f64 / INPUTS as f64;
                [1, 2].map(|k| (counts[2 * i + k] - empty) / row.task.calls as f64)
            });
            let place = OPERATIONS.iter().position(|operation| *operation == row.task.operation);
            let errors = pairs.errors.get(&row.task.row).zip(place);
            let errors = errors.map(|(all, place)| [all.derived[place], all.by_hand[place]]);
            object(row, counted, errors)
        })
        .collect();
    if json {
        println!("{:#}", json!({ "rows": rows }));
    } else {
        print(&rows);
    }
    Ok(())
}

/// The figures of a pair; instructions are per call, errors in units over condition numbers.
fn object(row: &Timed, counted: Option<[f64; 2]>, errors: Option<[f64; 2]>) -> Value {
    let pair = |[derived, by_hand]: [f64; 2]| json!({"derived": derived, "by_hand": by_hand});
    let mut object = json!({
        "kind": "sampler", "row": row.task.row, "name": row.task.name, "operation": row.task.operation,
        "instructions": counted.map(pair),
        "instruction_ratio": counted.map(|[ours, theirs]| ours / theirs),
        "nanoseconds": pair(row.nanoseconds),
        "time_ratio": row.ratio,
        "error": errors.map(pair),
    });
    if let Kind::Integrator(works) = row.task.kind {
        let each = |count: fn(&Work) -> u64| {
            pair([0, 1].map(|k| count(&works[k]) as f64 / row.task.calls as f64))
        };
        object["kind"] = json!("integrator");
        object["rays"] = each(Work::rays);
        object["densities"] = each(|work| work.densities);
        object["allocations"] = pair(row.allocations.map(|n| n as f64 / row.task.calls as f64));
    }
    object
}

/// The operations of samplers, in the order of their errors.
const OPERATIONS: [&str; 3] = ["sample", "pdf", "sample+pdf"];

/// How large errors over condition numbers may be, in units, of what keeps its digits.
const SOUND: f64 = 64.0;

/// The errors of a pair, as they are read.
fn errors(pair: &Value) -> String {
    let error = |key: &str| match pair[key].as_f64() {
        Some(error) if error < 1e4 => format!("{error:.1}"),
        Some(error) => format!("{error:.0e}"),
        None => "-".to_owned(),
    };
    format!("{} / {}", error("derived"), error("by_hand"))
}

/// The median ratios of some rows, and the worst.
fn summary<'r>(what: &str, rows: impl Iterator<Item = &'r Value> + Clone) {
    for (figure, key) in [("instructions", "instruction_ratio"), ("time", "time_ratio")] {
        let mut ratios: Vec<f64> = rows.clone().filter_map(|row| row[key].as_f64()).collect();
        ratios.sort_by(f64::total_cmp);
        if let (Some(middle), Some(worst)) = (ratios.get(ratios.len() / 2), ratios.last()) {
            println!("{what}, {figure}: median ratio {middle:.3}, worst {worst:.3}");
        }
    }
}

fn print(rows: &[Value]) {
    println!(
        "{:<24} {:<10} {:>15} {:>6}   {:>15} {:>6}   {:>15}",
        "", "", "instructions", "ratio", "nanoseconds", "ratio", "error"
    );
    for row in rows {
        let number = |v: &Value, digits: usize| {
            v.as_f64().map_or("-".to_owned(), |v| format!("{v:.digits$}"))
        };
        let pair = |key: &str| {
            format!("{} / {}", number(&row[key]["derived"], 1), number(&row[key]["by_hand"], 1))
        };
        println!(
            "{:<24} {:<10} {:>15} {:>6}   {:>15} {:>6}   {:>15}",
            row["name"].as_str().unwrap_or_default(),
            row["operation"].as_str().unwrap_or_default(),
            pair("instructions"),
            number(&row["instruction_ratio"], 3),
            pair("nanoseconds"),
            number(&row["time_ratio"], 3),
            errors(&row["error"]),
        );
    }
    let of_kind = |kind: &'static str| rows.iter().filter(move |row| row["kind"] == kind);
    for kind in ["sampler", "integrator"] {
        summary(kind, of_kind(kind));
    }
    for operation in OPERATIONS {
        let alike = of_kind("sampler").filter(|row| row["operation"] == operation);
        let keeps = |row: &Value, which: &str| {
            row["error"][which].as_f64().is_some_and(|error| error <= SOUND)
        };
        let [all, derived, by_hand] = [
            alike.clone().count(),
            alike.clone().filter(|row| keeps(row, "derived")).count(),
            alike.clone().filter(|row| keeps(row, "by_hand")).count(),
        ];
        println!("{operation}: of {all}, {derived} keep their digits, and {by_hand} by hand");
        summary("  all", alike.clone());
        summary(
            "  where the one by hand keeps its digits",
            alike.filter(|row| keeps(row, "by_hand")),
        );
    }
    for row in rows.iter().filter(|row| row["kind"] == "integrator") {
        println!(
            "{}: rays {}, densities {}, allocations {}",
            row["name"], row["rays"], row["densities"], row["allocations"]
        );
    }
}
