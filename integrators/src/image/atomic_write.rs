//! Writing a file so that a crash leaves the old file or the new one, never half of one.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Writes `bytes` to `path`: first to a temporary file in the same directory, which is then
/// renamed. A symbolic link is followed; a device or pipe is written to directly.
pub(crate) fn write_file(path: &Path, bytes: &[u8]) -> io::Result<()> {
    write_as(path, &std::process::id().to_string(), &|file| file.write_all(bytes))
}

/// [`write_file`] for what `write` writes. The name of the temporary file has `tag` in it: what is left by a program
/// that was killed is overwritten by the next one with the same tag.
pub(crate) fn write_as(
    path: &Path,
    tag: &str,
    write: &dyn Fn(&mut File) -> io::Result<()>,
) -> io::Result<()> {
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    match fs::metadata(&target) {
        Ok(existing) if existing.is_dir() => return Err(is_a_directory()),
        Ok(existing) if !existing.is_file() => return write(&mut File::create(&target)?),
        _ => {}
    }
    let temporary = temporary_path(&target, tag)?;
    let result = write_and_sync(&temporary, write).and_then(|()| fs::rename(&temporary, &target));
    if result.is_err() {
        // The first error is the one to report; a file that was never created cannot be removed.
        let _ = fs::remove_file(&temporary);
    }
    result
}

/// An error if [`write_file`] would fail on `path` now: asked before hours of work.
pub(crate) fn check(path: &Path) -> io::Result<()> {
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    match fs::metadata(&target) {
        Ok(existing) if existing.is_dir() => Err(is_a_directory()),
        Ok(existing) if !existing.is_file() => Ok(()),
        _ => {
            let temporary = temporary_path(&target, &std::process::id().to_string())?;
            File::create(&temporary)?;
            fs::remove_file(&temporary)
        }
    }
}

fn is_a_directory() -> io::Error {
    io::Error::new(io::ErrorKind::IsADirectory, "it is a directory")
}

/// A hidden name beside `target`, which no other running process uses if the tag is that of the process.
fn temporary_path(target: &Path, tag: &str) -> io::Result<PathBuf> {
    let name = target
        .file_name()
        .ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, "it is not a file name"))?;
    let mut hidden = std::ffi::OsString::from(".");
    hidden.push(name);
    hidden.push(format!(".{tag}.tmp"));
    Ok(target.with_file_name(hidden))
}

fn write_and_sync(path: &Path, write: &dyn Fn(&mut File) -> io::Result<()>) -> io::Result<()> {
    let mut file = File::create(path)?;
    write(&mut file)?;
    file.sync_all()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn replaces_a_file_and_leaves_no_temporary() {
        let directory = std::env::temp_dir().join(format!("aether-write-{}", std::process::id()));
        fs::create_dir_all(&directory).unwrap();
        let path = directory.join("a.bin");
        write_file(&path, b"old").unwrap();
        write_file(&path, b"new").unwrap();
        check(&path).unwrap();
        check(&directory.join("b.bin")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(fs::read_dir(&directory).unwrap().count(), 1);
        assert_eq!(write_file(&directory, b"x").unwrap_err().kind(), io::ErrorKind::IsADirectory);
        assert!(write_file(&directory.join("missing/a.bin"), b"x").is_err());
        assert!(check(&directory).is_err() && check(&directory.join("missing/a.bin")).is_err());
        fs::remove_dir_all(&directory).unwrap();
    }
}
