//! Files that a scene names.
//!
//! A scene may name any file that its user can read, by an absolute path or through `..`, as in Mitsuba: it is
//! as trusted as a document that shows pictures. Nothing is written, and only regular files are read: no
//! device that never ends, no pipe that never begins.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// The most bytes of a scene file.
pub const MOST_TEXT: u64 = 1 << 28;
/// The most bytes of a mesh.
const MOST_BYTES: u64 = 1 << 34;

/// The whole of a text file, or why it cannot be had.
pub fn read_text(path: &Path) -> Result<String, String> {
    let bytes = read_at_most(path, MOST_TEXT)?;
    String::from_utf8(bytes).map_err(|_| "is not UTF-8 text".to_owned())
}

/// The whole of a file, or why it cannot be had.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>, String> {
    read_at_most(path, MOST_BYTES)
}

fn read_at_most(path: &Path, most: u64) -> Result<Vec<u8>, String> {
    let fail = |error: std::io::Error| format!("cannot be read: {error}");
    // Asked before it is opened: opening a pipe waits for its other end.
    let metadata = std::fs::metadata(path).map_err(fail)?;
    if metadata.is_dir() {
        return Err("cannot be read: it is a folder".to_owned());
    }
    if !metadata.is_file() {
        return Err("cannot be read: it is no regular file".to_owned());
    }
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(fail)?;
    // A file may be longer than it says.
    file.take(most + 1).read_to_end(&mut bytes).map_err(fail)?;
    if bytes.len() as u64 > most {
        return Err(format!("is larger than {most} bytes"));
    }
    Ok(bytes)
}

/// Finds a file: absolute as it is, else in the first of the folders that has it.
pub fn find_file(name: &str, folders: &[PathBuf]) -> Result<PathBuf, String> {
    if name.is_empty() {
        return Err("the name of the file is empty".to_owned());
    }
    let found = folders.iter().map(|folder| folder.join(name));
    found.clone().find(|path| path.exists()).ok_or_else(|| {
        let tried: Vec<String> = found.map(|path| path.display().to_string()).collect();
        format!("file \"{name}\" not found; tried {}", tried.join(", "))
    })
}
