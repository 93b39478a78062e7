//! Writes what the compiler makes of each row of the catalogue as a Markdown table.
//!
//! `cargo run --release -p aether-engine --example table > tests/reference/rows.md` from the root of the
//! repository; with the argument `times`, a column with the time of each expansion is added.

#[path = "../tests/rows/mod.rs"]
mod rows;

fn main() {
    let times = std::env::args().any(|a| a == "times");
    print!("{}", rows::table(&rows::rows(), times));
}
