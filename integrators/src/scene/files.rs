//! Files that a scene names.

use std::path::{Path, PathBuf};

/// The whole of a text file, or why it cannot be had.
pub fn read_text(path: &Path) -> Result<String, String> {
    let bytes = std::fs::read(path).map_err(|e| format!("cannot be read: {e}"))?;
    String::from_utf8(bytes).map_err(|_| "is not UTF-8 text".to_owned())
}

/// Finds a file: absolute as it is, else in the first of the folders that has it.
pub fn find_file(name: &str, folders: &[PathBuf]) -> Result<PathBuf, String> {
    let found = folders.iter().map(|folder| folder.join(name));
    found.clone().find(|path| path.exists()).ok_or_else(|| {
        let tried: Vec<String> = found.map(|path| path.display().to_string()).collect();
        format!("file \"{name}\" not found; tried {}", tried.join(", "))
    })
}
