//! The committed table of the catalogue is what the compiler makes now.

mod rows;

#[test]
fn the_table_of_rows_is_up_to_date() {
    let committed = std::fs::read_to_string(rows::root().join("tests/reference/rows.md"))
        .expect("tests/reference/rows.md");
    let now = rows::table(&rows::rows(), false);
    let stale = committed.lines().zip(now.lines()).find(|(old, new)| old != new);
    assert!(
        committed == now,
        "tests/reference/rows.md is out of date (first difference {stale:?}); run `cargo run --release -p \
         aether-engine --example table > tests/reference/rows.md`"
    );
}
