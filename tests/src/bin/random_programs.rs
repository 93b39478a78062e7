//! Writes `tests/random_programs/programs.rs`: the programs that the test of the same name compiles.
//!
//! `cargo run -p tests --bin random_programs`

fn main() -> std::io::Result<()> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/random_programs/programs.rs");
    let text = tests::programs::file();
    let refused = text.matches(" is refused: ").count();
    let all = tests::programs::CORE + tests::programs::WIDE;
    println!("{path}: {} programs, {refused} of {all} refused", all - refused);
    std::fs::write(path, text)
}
