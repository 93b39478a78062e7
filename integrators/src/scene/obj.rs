//! Wavefront OBJ: positions, normals, texture coordinates and polygons. Everything else is skipped, as Mitsuba does.

use std::path::Path;

use glam::{DVec2, DVec3};

use super::error::SceneError;
use super::mesh::{Corner, Mesh, NONE};
use super::values::number;

/// Reads a mesh. `path` only names the file in errors.
pub fn read(bytes: &[u8], path: &Path) -> Result<Mesh, SceneError> {
    let mut mesh = Mesh::default();
    for (index, line) in bytes.split(|b| *b == b'\n').enumerate() {
        let line = String::from_utf8_lossy(line);
        statement(&line, &mut mesh)
            .map_err(|e| SceneError::in_file(path, e).at_line(index as u32 + 1))?;
    }
    mesh.drop_unused();
    Ok(mesh)
}

fn statement(line: &str, mesh: &mut Mesh) -> Result<(), String> {
    let mut words = line.split_whitespace();
    match words.next() {
        Some("v") => mesh.positions.push(point(words)?),
        Some("vn") => mesh.normals.push(point(words)?),
        Some("vt") => {
            let mut next = || number(words.next().ok_or("two numbers are needed")?);
            mesh.texcoords.push(DVec2::new(next()?, next()?));
        }
        Some("f") => {
            let corners: Result<Vec<_>, _> = words.map(|word| corner(word, mesh)).collect();
            let corners = corners?;
            if corners.len() < 3 {
                return Err("a face needs at least three corners".to_owned());
            }
            mesh.push_polygon(&corners);
        }
        _ => {}
    }
    Ok(())
}

fn point<'a>(mut words: impl Iterator<Item = &'a str>) -> Result<DVec3, String> {
    let mut next = || number(words.next().ok_or("three numbers are needed")?);
    Ok(DVec3::new(next()?, next()?, next()?))
}

/// `vertex`, `vertex/uv`, `vertex/uv/normal` or `vertex//normal`.
fn corner(word: &str, mesh: &Mesh) -> Result<Corner, String> {
    let mut parts = word.split('/');
    let vertex = index(parts.next().unwrap_or(""), mesh.positions.len(), "vertex")?;
    let mut optional = |count: usize, what| match parts.next() {
        None | Some("") => Ok(NONE),
        Some(text) => index(text, count, what),
    };
    let texcoord = optional(mesh.texcoords.len(), "texture coordinate")?;
    let normal = optional(mesh.normals.len(), "normal")?;
    Ok(Corner { vertex, normal, texcoord })
}

/// Indices count from 1; negative ones count back from the latest.
fn index(text: &str, count: usize, what: &str) -> Result<u32, String> {
    let value: i64 = text.parse().map_err(|_| format!("\"{text}\" is not a {what} index"))?;
    let at = if value < 0 { count as i64 + value } else { value - 1 };
    if at < 0 || at >= count as i64 || at >= i64::from(NONE) {
        return Err(format!("{what} {value} does not exist; there are {count} so far"));
    }
    Ok(at as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Mesh, String> {
        read(text.as_bytes(), Path::new("m.obj")).map_err(|e| e.to_string())
    }

    const SQUARE: &str = "# c\nv 0 0 0\nv 1 0 0\r\nv 1 1 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\n";

    #[test]
    fn corners_of_every_form() {
        let m = parse(&format!("{SQUARE}g a\nf 1 2/1 3/-1/1 -1//-1\n")).unwrap();
        assert_eq!(m.triangles, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(m.normal_triangles, [[NONE, NONE, 0], [NONE, 0, 0]]);
        assert_eq!(m.texcoord_triangles, [[NONE, 0, 0], [NONE, 0, NONE]]);
    }

    #[test]
    fn errors_have_a_line() {
        for (face, message) in [
            ("f 1 2 5", "m.obj:8: vertex 5 does not exist; there are 4 so far"),
            ("f 1 2 0", "m.obj:8: vertex 0 does not exist; there are 4 so far"),
            ("f 1 2 -5", "m.obj:8: vertex -5 does not exist; there are 4 so far"),
            ("f 1//2 2 3", "m.obj:8: normal 2 does not exist; there are 1 so far"),
            ("f 1/2 2 3", "m.obj:8: texture coordinate 2 does not exist; there are 1 so far"),
            ("f 1 2 x", "m.obj:8: \"x\" is not a vertex index"),
            ("f 1 2", "m.obj:8: a face needs at least three corners"),
            ("v 0 nan 0", "m.obj:8: \"nan\" is not a finite number"),
            ("v 0 0", "m.obj:8: three numbers are needed"),
        ] {
            assert_eq!(parse(&format!("{SQUARE}{face}\n")), Err(message.to_owned()));
        }
    }
}
