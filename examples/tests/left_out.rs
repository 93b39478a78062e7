//! What a kind of scene leaves out is not in a program for that kind: neither as a function nor inlined
//! into another one, as its debug information tells. A program for a larger kind shows that the search
//! finds what is there.

use std::collections::BTreeSet;
use std::path::Path;

use gimli::{AttributeValue, DebuggingInformationEntry, Dwarf, EndianSlice, LittleEndian, Unit};
use object::{Object, ObjectSection};

type Slice<'a> = EndianSlice<'a, LittleEndian>;

/// Parts of the names of functions that only some kinds need; of a function without type parameters the name alone is
/// known.
const GLASS: [&str; 3] = ["RefractIn", "RefractOut", "VisibleGgxNormals"];
const OTHERS: [&str; 7] = [
    "UniformDirections",
    "LatitudeLongitude",
    "scattering::metal",
    "intensity_towards",
    "rough_plastic",
    "ParallelHit",
    "film_filter::{impl#0}::new",
];

/// The linkage names of all functions whose code is in a program, inlined ones included.
fn functions(program: &str) -> BTreeSet<String> {
    let bytes = std::fs::read(program).unwrap_or_else(|error| panic!("{program}: {error}"));
    let file = object::File::parse(&*bytes).expect("an object file");
    let section = |id: gimli::SectionId| -> Result<_, gimli::Error> {
        Ok(file
            .section_by_name(id.name())
            .and_then(|s| s.uncompressed_data().ok())
            .unwrap_or_default())
    };
    let sections = gimli::DwarfSections::load(section).expect("sections");
    let dwarf = sections.borrow(|data| EndianSlice::new(data, LittleEndian));
    let mut names = BTreeSet::new();
    let mut units = dwarf.units();
    while let Some(header) = units.next().expect("units") {
        let unit = dwarf.unit(header).expect("a unit");
        let mut entries = unit.entries();
        while let Some((_, entry)) = entries.next_dfs().expect("entries") {
            let function =
                matches!(entry.tag(), gimli::DW_TAG_subprogram | gimli::DW_TAG_inlined_subroutine);
            if function && has_code(&dwarf, &unit, entry) {
                names.extend(linkage_name(&dwarf, &unit, entry, 4));
            }
        }
    }
    names
}

/// Whether code belongs to an entry: the linker moves what it drops to address zero.
fn has_code(
    dwarf: &Dwarf<Slice>,
    unit: &Unit<Slice>,
    entry: &DebuggingInformationEntry<Slice>,
) -> bool {
    let mut ranges = dwarf.die_ranges(unit, entry).expect("ranges");
    while let Some(range) = ranges.next().expect("a range") {
        // Nothing of a program is linked to the first page.
        if range.begin >= 0x1000 && range.begin < range.end {
            return true;
        }
    }
    false
}

/// The name of a function, which may be that of the entry which it is an instance of.
fn linkage_name(
    dwarf: &Dwarf<Slice>,
    unit: &Unit<Slice>,
    entry: &DebuggingInformationEntry<Slice>,
    depth: usize,
) -> Option<String> {
    let value = |name| entry.attr_value(name).ok().flatten();
    if let Some(name) = value(gimli::DW_AT_linkage_name).or_else(|| value(gimli::DW_AT_name)) {
        return dwarf.attr_string(unit, name).ok().map(|name| name.to_string_lossy().into_owned());
    }
    let origin =
        value(gimli::DW_AT_abstract_origin).or_else(|| value(gimli::DW_AT_specification))?;
    match origin {
        AttributeValue::UnitRef(offset) if depth > 0 => {
            linkage_name(dwarf, unit, &unit.entry(offset).ok()?, depth - 1)
        }
        _ => None,
    }
}

/// Which of the markers are parts of names.
fn found<'m>(names: &BTreeSet<String>, markers: &[&'m str]) -> Vec<&'m str> {
    let is_there = |marker: &&&str| names.iter().any(|name| name.contains(**marker));
    markers.iter().filter(is_there).copied().collect()
}

#[test]
fn a_program_for_matte_rooms_has_nothing_else() {
    let names = functions(env!("CARGO_BIN_EXE_custom_strategy"));
    // A program without names would pass.
    assert_eq!(found(&names, &["CosineHemisphere", "UniformTriangle"]).len(), 2);
    assert_eq!(found(&names, &GLASS), [""; 0]);
    assert_eq!(found(&names, &OTHERS), [""; 0]);
}

#[test]
fn the_general_program_has_everything() {
    let general = Path::new(env!("CARGO_BIN_EXE_custom_strategy")).with_file_name("aether");
    // It belongs to another crate: built with the workspace, not with these examples alone.
    let Some(general) = general.to_str().filter(|_| general.exists()) else {
        println!("{} is not built", general.display());
        return;
    };
    let names = functions(general);
    assert_eq!(found(&names, &GLASS), GLASS);
    assert_eq!(found(&names, &OTHERS), OTHERS);
}

#[test]
fn one_more_material_is_found_and_no_other() {
    let names = functions(env!("CARGO_BIN_EXE_rough_glass"));
    assert_eq!(found(&names, &GLASS), GLASS);
    assert_eq!(found(&names, &OTHERS), [""; 0]);
}
