//! A manual of mistakes: what does not compile, and what the compiler says about it.
//!
//! Each file of `tests/ui` begins with the mistake that it makes; beside it is the message. Every text
//! says what is wrong, why, and what to write instead. After a change of a text:
//! `TRYBUILD=overwrite cargo test -p aether-core --test compile_fail`, then read the difference.

use std::path::Path;

#[test]
fn mistakes_are_explained_where_they_are() {
    trybuild::TestCases::new().compile_fail("tests/ui/*.rs");
}

#[test]
fn every_file_says_what_its_mistake_is() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/ui");
    let files = std::fs::read_dir(folder)
        .expect("the folder exists")
        .map(|f| f.expect("is readable").path());
    let mut count = 0;
    for file in files.filter(|f| f.extension().is_some_and(|e| e == "rs")) {
        let text = std::fs::read_to_string(&file).expect("is text");
        assert!(text.starts_with("// "), "{} does not begin with its mistake", file.display());
        assert!(file.with_extension("stderr").exists(), "{} has no message", file.display());
        count += 1;
    }
    assert!(count >= 40, "only {count} mistakes");
}
