//! Mitsuba's compressed meshes: several in one file, each a zlib stream, with a table of where they begin
//! at the end.

use std::io::Read;
use std::path::Path;

use flate2::read::ZlibDecoder;
use glam::{DVec2, DVec3};

use super::error::SceneError;
use super::mesh::{Corner, Mesh};

const MAGIC: u16 = 0x041c;
const HAS_NORMALS: u32 = 0x0001;
const HAS_TEXCOORDS: u32 = 0x0002;
const HAS_COLORS: u32 = 0x0008;
const FACE_NORMALS: u32 = 0x0010;
const DOUBLE: u32 = 0x2000;

/// Reads mesh number `shape` of a file, and whether it is flat. `path` only names the file in errors.
pub fn read(bytes: &[u8], path: &Path, shape: usize) -> Result<(Mesh, bool), SceneError> {
    mesh(bytes, shape)
        .map_err(|message| SceneError::in_file(path, message).about(format!("mesh {shape}")))
}

fn mesh(bytes: &[u8], shape: usize) -> Result<(Mesh, bool), String> {
    let (header, version) = section(bytes, shape)?;
    let mut source = Stream { inner: ZlibDecoder::new(header) };
    let flags = source.u32()?;
    if version >= 4 {
        // A name, ended by a zero.
        let mut length = 0;
        while source.bytes::<1>()?[0] != 0 {
            length += 1;
            if length > 1 << 16 {
                return Err("the name of a mesh has no end".to_owned());
            }
        }
    }
    let (vertices, triangles) = (source.u64()?, source.u64()?);
    if vertices >= u64::from(u32::MAX) || triangles >= u64::from(u32::MAX) {
        return Err(format!("{vertices} vertices and {triangles} triangles are too many"));
    }
    let double = flags & DOUBLE != 0;
    let mut result = Mesh::default();
    // Nothing is reserved: a short file may claim any count.
    for _ in 0..vertices {
        result.positions.push(source.vector(double)?);
    }
    if flags & HAS_NORMALS != 0 {
        for _ in 0..vertices {
            result.normals.push(source.vector(double)?);
        }
    }
    if flags & HAS_TEXCOORDS != 0 {
        for _ in 0..vertices {
            result.texcoords.push(DVec2::new(source.real(double)?, source.real(double)?));
        }
    }
    if flags & HAS_COLORS != 0 {
        for _ in 0..vertices {
            source.vector(double)?;
        }
    }
    for triangle in 0..triangles {
        let mut corner = || -> Result<Corner, String> {
            let vertex = source.u32()?;
            if u64::from(vertex) >= vertices {
                return Err(format!(
                    "triangle {triangle}: vertex {vertex} does not exist; there are {vertices}"
                ));
            }
            Ok(Corner { vertex, normal: vertex, texcoord: vertex })
        };
        let corners = [corner()?, corner()?, corner()?];
        result.push_polygon(&corners);
    }
    result.drop_unused();
    Ok((result, flags & FACE_NORMALS != 0))
}

/// The compressed part of a mesh, and the version of the format.
fn section(bytes: &[u8], shape: usize) -> Result<(&[u8], u16), String> {
    let tail = |back: usize, length: usize| {
        let start = bytes.len().checked_sub(back)?;
        bytes.get(start..start + length)
    };
    let header = |at: usize| -> Result<u16, String> {
        match bytes.get(at..at.saturating_add(4)) {
            Some([a, b, c, d]) if u16::from_le_bytes([*a, *b]) == MAGIC => {
                let version = u16::from_le_bytes([*c, *d]);
                if version == 3 || version == 4 {
                    Ok(version)
                } else {
                    Err(format!("version {version} of the format; supported: 3, 4"))
                }
            }
            _ => Err("not a serialized mesh: the first bytes are wrong".to_owned()),
        }
    };
    let version = header(0)?;
    let count = tail(4, 4).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
    let count = count.ok_or("the file is too short")? as usize;
    if shape >= count {
        return Err(format!("shape_index {shape} does not exist; there are {count} meshes"));
    }
    // The table has entries of 8 bytes, in version 3 of 4.
    let width = if version >= 4 { 8 } else { 4 };
    let entry = |index: usize| -> Option<usize> {
        let back = count.checked_sub(index)?.checked_mul(width)?.checked_add(4)?;
        let bytes = tail(back, width)?;
        let mut wide = [0; 8];
        wide[..width].copy_from_slice(bytes);
        usize::try_from(u64::from_le_bytes(wide)).ok()
    };
    let start = entry(shape).ok_or("the table of meshes is broken")?;
    let version = header(start)?;
    let data = bytes.get(start + 4..).ok_or("the table of meshes is broken")?;
    Ok((data, version))
}

struct Stream<'a> {
    inner: ZlibDecoder<&'a [u8]>,
}

impl Stream<'_> {
    fn bytes<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let mut bytes = [0; N];
        self.inner.read_exact(&mut bytes).map_err(|error| match error.kind() {
            std::io::ErrorKind::UnexpectedEof => {
                "the mesh ends before its last triangle".to_owned()
            }
            _ => format!("the compressed data are broken: {error}"),
        })?;
        Ok(bytes)
    }

    fn u32(&mut self) -> Result<u32, String> {
        self.bytes().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Result<u64, String> {
        self.bytes().map(u64::from_le_bytes)
    }

    fn real(&mut self, double: bool) -> Result<f64, String> {
        let value = if double {
            f64::from_le_bytes(self.bytes()?)
        } else {
            f64::from(f32::from_le_bytes(self.bytes()?))
        };
        value.is_finite().then_some(value).ok_or_else(|| "a number is not finite".to_owned())
    }

    fn vector(&mut self, double: bool) -> Result<DVec3, String> {
        Ok(DVec3::new(self.real(double)?, self.real(double)?, self.real(double)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    /// A file of meshes, each a triangle `x` wide.
    fn file(widths: &[f32]) -> Vec<u8> {
        let (mut bytes, mut starts) = (Vec::new(), Vec::new());
        for width in widths {
            starts.push(bytes.len() as u64);
            bytes.extend(MAGIC.to_le_bytes());
            bytes.extend(4u16.to_le_bytes());
            let mut data = HAS_TEXCOORDS.to_le_bytes().to_vec();
            data.extend(b"name\0");
            data.extend(3u64.to_le_bytes());
            data.extend(1u64.to_le_bytes());
            for x in [0.0, 0.0, 0.0, *width, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0]
            {
                data.extend(x.to_le_bytes());
            }
            for i in 0..3u32 {
                data.extend(i.to_le_bytes());
            }
            let mut encoder =
                flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
            encoder.write_all(&data).unwrap();
            bytes.extend(encoder.finish().unwrap());
        }
        for start in &starts {
            bytes.extend(start.to_le_bytes());
        }
        bytes.extend((starts.len() as u32).to_le_bytes());
        bytes
    }

    #[test]
    fn meshes_are_found_by_their_index() {
        let bytes = file(&[2.0, 3.0]);
        for (index, width) in [(0, 2.0), (1, 3.0)] {
            let (mesh, flat) = mesh(&bytes, index).unwrap();
            assert_eq!(mesh.positions[1], DVec3::new(width, 0.0, 0.0));
            assert_eq!((mesh.triangles.len(), mesh.texcoords.len(), flat), (1, 3, false));
        }
        assert!(mesh(&bytes, 2).unwrap_err().contains("there are 2 meshes"));
    }

    #[test]
    fn no_damage_panics() {
        let bytes = file(&[2.0]);
        for length in 0..bytes.len() {
            let _ = mesh(&bytes[..length], 0);
        }
        for at in 0..bytes.len() {
            for bits in [0xff, 0x80, 0x01] {
                let mut broken = bytes.clone();
                broken[at] ^= bits;
                let _ = mesh(&broken, 0);
            }
        }
    }
}
