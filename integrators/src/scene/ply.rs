//! Stanford PLY, ascii and binary of either byte order: positions, normals, texture coordinates and
//! polygons. Other
//! properties and elements are skipped.

use std::path::Path;

use glam::{DVec2, DVec3};

use super::error::SceneError;
use super::mesh::{Attribute, Corner, Mesh};

#[derive(Clone, Copy, Debug, PartialEq)]
enum Format {
    Ascii,
    LittleEndian,
    BigEndian,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

struct PropertyHeader {
    name: String,
    /// The type of the number of items, if it is a list.
    count: Option<Scalar>,
    scalar: Scalar,
}

struct ElementHeader {
    name: String,
    count: u64,
    properties: Vec<PropertyHeader>,
}

/// Reads a mesh. `path` only names the file in errors.
pub fn read(bytes: &[u8], path: &Path) -> Result<Mesh, SceneError> {
    let mut cursor = Cursor { bytes, line: 1, format: Format::Ascii };
    let elements = header(&mut cursor)
        .map_err(|e| SceneError::in_file(path, e).at_line(cursor.line.saturating_sub(1).max(1)))?;
    let mut mesh = Mesh::default();
    for element in &elements {
        let mut record = Record::default();
        let groups = element.attributes();
        let first = mesh.attributes.len();
        mesh.attributes.extend(groups.iter().map(|(name, _)| Attribute {
            name: name.clone(),
            of_faces: element.name == "face",
            values: Vec::new(),
        }));
        for index in 0..element.count {
            let result =
                record.read(&mut cursor, element).and_then(|()| record.store(element, &mut mesh));
            let result = result.and_then(|()| {
                // A face with many corners has become several triangles.
                let wanted = if element.name == "face" {
                    mesh.triangles.len()
                } else {
                    mesh.positions.len()
                };
                for (attribute, (_, at)) in mesh.attributes[first..].iter_mut().zip(&groups) {
                    let value =
                        finite(DVec3::from_array(at.map(|i| record.scalars[i])), "attribute")?;
                    attribute.values.resize(wanted, value.as_vec3());
                }
                Ok(())
            });
            if let Err(message) = result {
                let error = SceneError::in_file(path, message);
                let error = error.about(format!("{} {index}", element.name));
                return Err(match cursor.format {
                    Format::Ascii => error.at_line(cursor.line),
                    _ => error,
                });
            }
            if element.properties.is_empty() {
                break;
            }
        }
    }
    let vertices = mesh.positions.len();
    for (index, triangle) in mesh.triangles.iter().enumerate() {
        if let Some(bad) = triangle.iter().find(|v| **v as usize >= vertices) {
            let message = format!("vertex {bad} does not exist; there are {vertices}");
            return Err(SceneError::in_file(path, message).about(format!("triangle {index}")));
        }
    }
    mesh.drop_unused();
    Ok(mesh)
}

fn header(cursor: &mut Cursor) -> Result<Vec<ElementHeader>, String> {
    if cursor.line()? != "ply" {
        return Err("not a PLY file: the first line must be \"ply\"".to_owned());
    }
    let mut elements: Vec<ElementHeader> = Vec::new();
    let mut format = None;
    loop {
        let line = cursor.line()?;
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["format", name, "1.0"] => {
                format = match name {
                    "ascii" => Some(Format::Ascii),
                    "binary_little_endian" => Some(Format::LittleEndian),
                    "binary_big_endian" => Some(Format::BigEndian),
                    _ => return Err(format!("unknown format \"{name}\"")),
                }
            }
            ["element", name, count] => elements.push(ElementHeader {
                name: name.to_owned(),
                count: count.parse().map_err(|_| format!("\"{count}\" is not a count"))?,
                properties: Vec::new(),
            }),
            ["property", ref words @ ..] => {
                let element = elements.last_mut().ok_or("a property before any element")?;
                element.properties.push(property_header(words)?);
            }
            ["end_header"] => break,
            ["comment" | "obj_info", ..] | [] => {}
            _ => return Err(format!("\"{line}\" does not belong in a PLY header")),
        }
    }
    cursor.format = format.ok_or("the header has no \"format\"")?;
    for element in &elements {
        element.check()?;
    }
    Ok(elements)
}

fn property_header(words: &[&str]) -> Result<PropertyHeader, String> {
    let scalar = |name: &str| Scalar::named(name).ok_or(format!("unknown type \"{name}\""));
    match *words {
        ["list", count, item, name] => Ok(PropertyHeader {
            name: name.to_owned(),
            count: Some(scalar(count)?),
            scalar: scalar(item)?,
        }),
        [item, name] => {
            Ok(PropertyHeader { name: name.to_owned(), count: None, scalar: scalar(item)? })
        }
        _ => Err("a property needs a type and a name".to_owned()),
    }
}

impl ElementHeader {
    fn find(&self, name: &str, list: bool) -> Option<usize> {
        let mut properties = self.properties.iter();
        properties.position(|p| p.name == name && p.count.is_some() == list)
    }

    fn triple(&self, names: [&str; 3]) -> Option<[usize; 3]> {
        let [x, y, z] = names.map(|name| self.find(name, false));
        Some([x?, y?, z?])
    }

    /// The properties that are texture coordinates, by the names in use.
    fn texcoords(&self) -> Option<[usize; 2]> {
        [["u", "v"], ["s", "t"], ["texture_u", "texture_v"], ["texture_s", "texture_t"]]
            .into_iter()
            .find_map(|[u, v]| Some([self.find(u, false)?, self.find(v, false)?]))
    }

    /// What else there is, by Mitsuba's rules for names: `r`, `g`, `b` are the colour; neighbours with a common
    /// prefix and endings such as `_x`, `_y`, `_z` belong together, and one such ending alone is a number.
    fn attributes(&self) -> Vec<(String, [usize; 3])> {
        if !["vertex", "face"].contains(&self.name.as_str()) {
            return Vec::new();
        }
        let named = |rest: &str| format!("{}_{rest}", self.name);
        let colours = [["r", "g", "b"], ["red", "green", "blue"]];
        let colour = colours.into_iter().find_map(|names| self.triple(names));
        let mut found: Vec<_> = colour.into_iter().map(|at| (named("color"), at)).collect();
        let split = |index: usize| {
            let property = self.properties.get(index).filter(|p| p.count.is_none())?;
            let (prefix, ending) = property.name.rsplit_once('_')?;
            let reserved = ["texture_u", "texture_v", "texture_s", "texture_t"];
            (!reserved.contains(&&*property.name)).then_some((prefix, ending))
        };
        let mut index = 0;
        while index < self.properties.len() {
            let schemes = [["x", "y", "z"], ["r", "g", "b"], ["0", "1", "2"], ["1", "2", "3"]];
            let begun = split(index).and_then(|(prefix, ending)| {
                let scheme = schemes.into_iter().find(|scheme| scheme[0] == ending)?;
                let len = (0..3).take_while(|k| split(index + k) == Some((prefix, scheme[*k])));
                Some((prefix, ending, len.count()))
            });
            let Some((prefix, ending, len)) = begun else {
                index += 1;
                continue;
            };
            let name = if ending == "r" { format!("{prefix}_color") } else { prefix.to_owned() };
            match len {
                1 => found.push((named(&name), [index; 3])),
                3 => found.push((named(&name), [index, index + 1, index + 2])),
                // Mitsuba ignores pairs.
                _ => {}
            }
            index += len;
        }
        found
    }

    fn indices(&self) -> Option<usize> {
        let plural = self.find("vertex_indices", true);
        plural.or_else(|| self.find("vertex_index", true))
    }

    fn check(&self) -> Result<(), String> {
        match self.name.as_str() {
            "vertex" if self.triple(["x", "y", "z"]).is_none() => {
                Err("the element \"vertex\" needs the properties x, y and z".to_owned())
            }
            "face" if self.indices().is_none() => {
                Err("the element \"face\" needs the list vertex_indices".to_owned())
            }
            _ => Ok(()),
        }
    }
}

/// One vertex or face: the scalars by property, and the items of the list of indices.
#[derive(Default)]
struct Record {
    scalars: Vec<f64>,
    indices: Vec<f64>,
}

impl Record {
    fn read(&mut self, cursor: &mut Cursor, element: &ElementHeader) -> Result<(), String> {
        self.scalars.clear();
        self.indices.clear();
        let wanted = (element.name == "face").then(|| element.indices()).flatten();
        for (index, property) in element.properties.iter().enumerate() {
            let Some(count) = property.count else {
                self.scalars.push(cursor.scalar(property.scalar)?);
                continue;
            };
            self.scalars.push(0.0);
            let count = cursor.scalar(count)?;
            if count < 0.0 || count.fract() != 0.0 {
                return Err(format!("a list of {count} items"));
            }
            for _ in 0..count as u64 {
                let item = cursor.scalar(property.scalar)?;
                if wanted == Some(index) {
                    self.indices.push(item);
                }
            }
        }
        Ok(())
    }

    fn store(&self, element: &ElementHeader, mesh: &mut Mesh) -> Result<(), String> {
        let vector = |at: [usize; 3]| DVec3::from_array(at.map(|i| self.scalars[i]));
        match element.name.as_str() {
            "vertex" => {
                if let Some(at) = element.triple(["x", "y", "z"]) {
                    mesh.positions.push(finite(vector(at), "position")?);
                }
                if let Some(at) = element.triple(["nx", "ny", "nz"]) {
                    mesh.normals.push(finite(vector(at), "normal")?);
                }
                if let Some(at) = element.texcoords() {
                    let uv = DVec2::from_array(at.map(|i| self.scalars[i]));
                    if !uv.is_finite() {
                        return Err("the texture coordinates are not finite".to_owned());
                    }
                    mesh.texcoords.push(uv);
                }
            }
            "face" => {
                let corner = |x: &f64| {
                    let valid = x.fract() == 0.0 && (0.0..f64::from(u32::MAX)).contains(x);
                    let vertex = *x as u32;
                    // All lists have the order of the vertices.
                    valid.then_some(Corner { vertex, normal: vertex, texcoord: vertex })
                };
                let corners: Option<Vec<_>> = self.indices.iter().map(corner).collect();
                let corners = corners.ok_or("a vertex index is negative or not an integer")?;
                if corners.len() < 3 {
                    return Err("a face needs at least three corners".to_owned());
                }
                mesh.push_polygon(&corners);
            }
            _ => {}
        }
        Ok(())
    }
}

fn finite(v: DVec3, what: &str) -> Result<DVec3, String> {
    v.is_finite().then_some(v).ok_or_else(|| format!("the {what} is not finite"))
}

/// What is left of the file.
struct Cursor<'a> {
    bytes: &'a [u8],
    /// The number of the current line; only kept in the header and in ascii files.
    line: u32,
    format: Format,
}

impl<'a> Cursor<'a> {
    /// The next line of the header.
    fn line(&mut self) -> Result<&'a str, String> {
        let end = self.bytes.iter().position(|b| *b == b'\n');
        let end = end.ok_or("the header has no end")?;
        let line = std::str::from_utf8(&self.bytes[..end]).map_err(|_| "the header is not text")?;
        self.bytes = &self.bytes[end + 1..];
        self.line += 1;
        Ok(line.trim())
    }

    fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let (taken, rest) = self.bytes.split_at_checked(count).ok_or("the file ends here")?;
        self.bytes = rest;
        Ok(taken)
    }

    fn word(&mut self) -> Result<&'a str, String> {
        let blanks = self.bytes.iter().take_while(|b| b.is_ascii_whitespace());
        let blanks = blanks.count();
        let skipped = self.take(blanks)?;
        let letters = self.bytes.iter().take_while(|b| !b.is_ascii_whitespace());
        let letters = letters.count();
        if letters == 0 {
            return Err("the file ends here".to_owned());
        }
        self.line += skipped.iter().filter(|b| **b == b'\n').count() as u32;
        let word = self.take(letters)?;
        std::str::from_utf8(word).map_err(|_| "not text".to_owned())
    }

    fn scalar(&mut self, scalar: Scalar) -> Result<f64, String> {
        if self.format == Format::Ascii {
            let word = self.word()?;
            return word.parse().map_err(|_| format!("\"{word}\" is not a number"));
        }
        let mut raw = [0; 8];
        let size = scalar.size();
        raw[..size].copy_from_slice(self.take(size)?);
        if self.format == Format::BigEndian {
            raw[..size].reverse();
        }
        let [a, b, c, d, ..] = raw;
        Ok(match scalar {
            Scalar::I8 => f64::from(a as i8),
            Scalar::U8 => f64::from(a),
            Scalar::I16 => f64::from(i16::from_le_bytes([a, b])),
            Scalar::U16 => f64::from(u16::from_le_bytes([a, b])),
            Scalar::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            Scalar::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
            Scalar::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Scalar::F64 => f64::from_le_bytes(raw),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "comment c\nelement vertex 4\nproperty float x\nproperty double y\n\
        property float z\nproperty uchar red\nelement face 1\nproperty short flags\n\
        property list uchar int vertex_indices\nend_header\n";
    const VERTICES: [[f64; 3]; 4] = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.5]];

    fn binary(big: bool) -> Vec<u8> {
        let name = if big { "big" } else { "little" };
        let mut file = format!("ply\nformat binary_{name}_endian 1.0\n{HEADER}").into_bytes();
        let mut put = |mut little: Vec<u8>| {
            if big {
                little.reverse();
            }
            file.extend(little);
        };
        for [x, y, z] in VERTICES {
            put((x as f32).to_le_bytes().to_vec());
            put(y.to_le_bytes().to_vec());
            put((z as f32).to_le_bytes().to_vec());
            put(vec![7]);
        }
        put((-2i16).to_le_bytes().to_vec());
        put(vec![4]);
        for i in 0..4i32 {
            put(i.to_le_bytes().to_vec());
        }
        file
    }

    fn ascii(faces: &str) -> Vec<u8> {
        let rows: String = VERTICES.iter().map(|[x, y, z]| format!("{x} {y} {z} 7\n")).collect();
        format!("ply\nformat ascii 1.0\n{HEADER}{rows}{faces}").into_bytes()
    }

    #[test]
    fn all_formats_agree() {
        let path = Path::new("m.ply");
        let mesh = read(&ascii("-2 4 0 1 2 3\n"), path).unwrap();
        assert_eq!(mesh.positions, VERTICES.map(DVec3::from_array));
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
        assert!(mesh.normal_triangles.is_empty());
        assert_eq!(read(&binary(false), path).unwrap(), mesh);
        assert_eq!(read(&binary(true), path).unwrap(), mesh);
    }

    #[test]
    fn normals_are_read() {
        let file = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
            property float z\nproperty float nx\nproperty float ny\nproperty float nz\n\
            element face 1\nproperty list uchar int vertex_index\nend_header\n\
            0 0 0 0 0 1\n1 0 0 0 0 2\n0 1 0 0 1 0\n3 0 1 2\n";
        let mesh = read(file, Path::new("m.ply")).unwrap();
        assert_eq!(mesh.normals, [DVec3::Z, 2.0 * DVec3::Z, DVec3::Y]);
        assert_eq!(mesh.normal_triangles, [[0, 1, 2]]);
    }

    #[test]
    fn errors_name_the_item() {
        let error = |file: &[u8]| read(file, Path::new("m.ply")).unwrap_err().to_string();
        assert_eq!(error(b"obj\n"), "m.ply:1: not a PLY file: the first line must be \"ply\"");
        let bad = ascii("-2 4 0 1 2 9\n");
        assert_eq!(error(&bad), "m.ply: triangle 1: vertex 9 does not exist; there are 4");
        let bad = ascii("-2 3 0 1 -2\n");
        assert_eq!(error(&bad), "m.ply:17: face 0: a vertex index is negative or not an integer");
        assert_eq!(error(&ascii("-2 4 0 1\n")), "m.ply:17: face 0: the file ends here");
        let mut cut = binary(false);
        cut.truncate(cut.len() - 30);
        assert_eq!(error(&cut), "m.ply: vertex 3: the file ends here");
        let mut nan = binary(true);
        // Before the end: the face, and of the last vertex its colour and z.
        let at = nan.len() - 19 - 5;
        nan[at..at + 4].copy_from_slice(&f32::NAN.to_be_bytes());
        assert_eq!(error(&nan), "m.ply: vertex 3: the position is not finite");
        let huge = b"ply\nformat ascii 1.0\nelement face 99999999999999\n\
            property list uchar int vertex_indices\nend_header\n";
        assert_eq!(error(huge), "m.ply:6: face 0: the file ends here");
    }

    #[test]
    fn no_prefix_of_a_file_panics() {
        for file in [ascii("-2 4 0 1 2 3\n"), binary(true)] {
            for length in 0..file.len() {
                let _ = read(&file[..length], Path::new("m.ply"));
            }
        }
    }
}
