//! The order of attributes in the header of an OpenEXR file.

/// Sorts the attributes of a file of one part by name, so that equal contents are equal files: who encodes it may
/// have them in any order. Positions of pixels in the file stay what they are. What is not such a file stays as it
/// is.
///
/// Behind the magic number and the version, four bytes each, an attribute is a name and a type, which a zero ends,
/// the number of bytes of its value, and these; a zero ends the header (OpenEXR 2013, "OpenEXR File Layout").
pub(super) fn sort_attributes(file: &mut [u8]) {
    const START: usize = 8;
    let (mut attributes, mut at) = (Vec::new(), START);
    while file.get(at).is_some_and(|byte| *byte != 0) {
        let Some(end) = attribute_end(file, at) else { return };
        attributes.push(file[at..end].to_vec());
        at = end;
    }
    attributes.sort();
    if at > START {
        file[START..at].copy_from_slice(&attributes.concat());
    }
}

/// Where the attribute that begins at a position ends.
fn attribute_end(file: &[u8], start: usize) -> Option<usize> {
    let text_end =
        |from: usize| Some(from + file.get(from..)?.iter().position(|byte| *byte == 0)? + 1);
    let size_at = text_end(text_end(start)?)?;
    let size = u32::from_le_bytes(file.get(size_at..size_at + 4)?.try_into().ok()?);
    let end = (size_at + 4).checked_add(size as usize)?;
    (end < file.len()).then_some(end)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sorts_whole_attributes_and_nothing_else() {
        let mut file = b"magicver".to_vec();
        let attributes: [&[u8]; 3] =
            [b"seed\0string\0\x02\0\0\0xy", b"crop\0box\0\x03\0\0\0\0z\0", b"a\0int\0\0\0\0\0"];
        attributes.iter().for_each(|attribute| file.extend(*attribute));
        file.extend(b"\0z\0a\0 pixels");
        let mut sorted = file.clone();
        sort_attributes(&mut sorted);
        let [seed, crop, a] = attributes;
        assert_eq!(sorted, [b"magicver", a, crop, seed, b"\0z\0a\0 pixels"].concat());
        for length in 0..file.len() - 12 {
            let mut part = file[..length].to_vec();
            sort_attributes(&mut part);
            assert_eq!(part, file[..length], "{length} bytes");
        }
    }
}
