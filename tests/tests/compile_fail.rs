//! What does not compile, and what the compiler says about it.
//!
//! After a change of a text: `TRYBUILD=overwrite cargo test -p tests --test compile_fail`, then read
//! the difference. Every text says what is wrong, why, and the way out.

#[test]
fn mistakes_are_explained_where_they_are() {
    trybuild::TestCases::new().compile_fail("tests/ui/*.rs");
}
