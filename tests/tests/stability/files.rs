//! What is read from files comes as it was written.

use tests::reference::{Reference, hexadecimal};
use tests::stability::stored::{line, read};
use tests::stability::{REASONS, Row};

#[test]
fn rows_come_back_as_they_were() {
    let mut row = Row::default();
    row.name = "a \"name\"".into();
    row.precision = "f32";
    row.sample.add(3.25, |_| 0.1, || "here".into());
    row.pdf.add(0.0, |_| 1.0, || "there".into());
    row.own.add(f64::MAX, |_| f64::INFINITY, || "nowhere".into());
    row.examples.push("NaN at 0".into());
    (row.samples, row.excused, row.unjudged) = (3, 2, 1);
    let text = line(&row, 7) + "{\"name\": \"cut sh";
    let path = std::env::temp_dir().join(format!("aether-rows-{}", std::process::id()));
    std::fs::write(&path, text).expect("a temporary file");
    let found = read(&path, [5, 7]);
    assert_eq!(read(&path, [7, 5]).len(), 0);
    std::fs::remove_file(&path).expect("it is there");
    assert_eq!(found.len(), 1);
    assert_eq!(line(&found[0], 7), line(&row, 7));
    assert_eq!(format!("{:?}", found[0]), format!("{row:?}"));
}

/// The stored report tells why whatever is in its lists falls short, and a reason is that of one of its rows.
#[test]
fn every_shortfall_has_a_reason_and_every_reason_a_row() {
    let report = include_str!("../../reference/stability-quick.md");
    assert!(!report.contains("not explained"));
    for precision in ["f64", "f32"] {
        let section = report.split(&format!("\n## {precision}\n")).nth(1).expect("there is one");
        let section = section.split("\n## ").next().unwrap_or_default();
        for (name, _, _) in REASONS.iter().filter(|r| r.1.has(precision)) {
            let row = format!("| {name} | ");
            assert!(section.lines().any(|l| l.starts_with(&row)), "{name} is no row");
        }
    }
}

#[test]
fn hexadecimal_numbers_are_read_exactly() {
    assert_eq!(hexadecimal("0x1.8p+1"), 3.0);
    assert_eq!(hexadecimal("-0x1.3333333333333p-2"), -0.3);
    assert_eq!(hexadecimal("0x1.56e1fc2f8f359p-997"), 1e-300);
    assert_eq!(hexadecimal("0x0.0p+0"), 0.0);
    assert_eq!(hexadecimal("-0x1.e848000000000p+19"), -1e6);
    assert_eq!(hexadecimal("inf"), f64::INFINITY);
    assert!(hexadecimal("nan").is_nan());
}

#[test]
fn the_file_is_complete() {
    let all = Reference::load();
    assert_eq!(all.points.len() + all.queries.len(), 325);
    assert!(all.points32.len() > 150);
    for p in &all.points {
        let near = |(x, r): (&f64, &f64)| x == r || (x - r).abs() <= f64::EPSILON * x.abs();
        assert!(p.x.iter().zip(&p.rounded).all(near), "{p:?}");
    }
}
