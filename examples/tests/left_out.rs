//! What a kind of scene leaves out is not in a program for that kind: neither as a function nor inlined
//! into another one. Programs for larger kinds show that the search finds what is there.

use std::collections::BTreeSet;

/// Names of what only some kinds need, with the feature that needs it.
const MARKERS: [(&str, &str); 6] = [
    ("RefractIn", "RoughDielectric"),
    ("RefractOut", "RoughDielectric"),
    ("VisibleGgxNormals", "RoughConductor"),
    ("BeckmannNormals", "RoughConductor"),
    ("UniformDirections", "Constant"),
    ("fresnel9conductor", "Conductor"),
];

/// The markers in the names of functions, inlined ones included, of a program.
fn found(program: &str) -> BTreeSet<&'static str> {
    let bytes = std::fs::read(program).unwrap_or_else(|error| panic!("{program}: {error}"));
    let is_there = |marker: &str| bytes.windows(marker.len()).any(|part| part == marker.as_bytes());
    // A program without names would pass any test.
    assert!(is_there("CosineHemisphere"), "{program} has no names");
    MARKERS.iter().map(|(marker, _)| *marker).filter(|marker| is_there(marker)).collect()
}

#[test]
fn a_program_for_matte_rooms_has_nothing_else() {
    assert_eq!(found(env!("CARGO_BIN_EXE_kind_rooms")), BTreeSet::new());
}

#[test]
fn one_more_feature_is_found() {
    let glass = found(env!("CARGO_BIN_EXE_kind_glass"));
    assert!(glass.contains("RefractIn") && glass.contains("RefractOut"), "{glass:?}");
    assert!(
        !glass.contains("UniformDirections") && !glass.contains("fresnel9conductor"),
        "{glass:?}"
    );
}

#[test]
fn a_program_for_everything_has_it_all() {
    let all: BTreeSet<_> = MARKERS.iter().map(|(marker, _)| *marker).collect();
    assert_eq!(found(env!("CARGO_BIN_EXE_kind_everything")), all);
}
