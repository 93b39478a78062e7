//! The report as text, and the command line of its binary.

use std::process::{Command, Output};

use serde_json::Value;
use tests::leaks::Leaks;
use tests::registry::{Item, items};
use tests::stability::report::{Report, csv, json, markdown};
use tests::stability::{Settings, run};

fn report() -> Report {
    let names = ["exponential", "cosine hemisphere"];
    let items: Vec<Item> = items().into_iter().filter(|item| names.contains(&item.name)).collect();
    assert_eq!(items.len(), names.len());
    let settings = Settings { single: 100, double: 10, sweep: false };
    let rows = run(&items, settings, None, &|_, _| ()).expect("nothing is written");
    let leaks = Leaks { aimed: 5, rays: 7, lost: 0, first: vec![] };
    Report { settings, rows, leaks }
}

#[test]
fn the_report_is_the_same_for_people_and_for_programs() {
    let mut report = report();
    (report.rows[0].excused, report.rows[0].unjudged) = (4, 5);
    report.rows[1].inverse.add(1e9, |_| 2.0, || "there".into());
    let object = json(&report);
    let rows = object["rows"].as_array().expect("a list");
    assert_eq!(rows.len(), 4);
    for (row, of) in rows.iter().zip(&report.rows) {
        assert_eq!(
            (&row["name"], &row["precision"]),
            (&of.name.as_str().into(), &of.precision.into())
        );
        let samples = row["samples"].as_u64().expect("a count");
        assert!(samples > 100 && samples == of.samples);
        for count in ["false_zeros", "nan", "infinite", "excused", "not_judged"] {
            assert!(row[count].is_u64(), "{count} of {row}");
        }
        for figure in ["worst_ulp", "worst_ulp_over_condition"] {
            assert!(row[figure].as_f64().is_some_and(|x| (0.0..64.0).contains(&x)), "{figure}");
        }
        assert!(row["pdf"]["median"].is_f64() && row["inverse"]["at"].is_string());
    }
    assert_eq!((&rows[0]["excused"], &rows[0]["not_judged"]), (&4.into(), &5.into()));
    assert_eq!(object["leaks"], serde_json::json!({ "aimed": 5, "rays": 7, "lost": 0 }));
    // It is one line, and comes back as it was.
    assert_eq!(serde_json::from_str::<Value>(&object.to_string()).ok(), Some(object));

    let table = csv(&report.rows);
    let widths: Vec<usize> = table.lines().map(|line| line.split(',').count()).collect();
    assert!(widths.len() == 5 && widths.iter().all(|n| *n == widths[0]), "{widths:?}");
    let text = markdown(&report);
    let listed = text.lines().filter(|line| line.ends_with(", there"));
    assert_eq!(listed.count(), 1);
    assert!(text.contains("that went on from there"));
}

fn stability(arguments: &[&str]) -> (Option<i32>, String) {
    let Output { status, stdout, stderr } =
        Command::new(env!("CARGO_BIN_EXE_stability")).args(arguments).output().expect("it starts");
    assert!(stdout.is_empty());
    (status.code(), String::from_utf8(stderr).expect("text"))
}

#[test]
fn a_wrong_command_line_is_told_what_is_wrong() {
    for (arguments, error) in [
        (&["--jsn"][..], "there is no option --jsn"),
        (&["--samples"], "--samples needs a value"),
        (&["--samples", "many"], "--samples needs a whole number, not many"),
        (&["--precise", "-1"], "--precise needs a whole number, not -1"),
        (&["--json", "exponental"], "no sampler has exponental in its name"),
    ] {
        let (code, told) = stability(arguments);
        assert_eq!((code, told.lines().next()), (Some(2), Some(error)));
        assert!(told.contains("--markdown FILE"));
    }
    // A build that only tests has no report in it.
    if cfg!(debug_assertions) {
        let (code, told) = stability(&["--json", "exponential"]);
        assert_eq!(code, Some(2));
        assert!(told.starts_with("the report needs an optimised build"), "{told}");
    }
}
