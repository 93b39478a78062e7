//! Files that keep the state of a render, so that it can go on after a break as if there had been none.
//!
//! A file begins with a name and a version of its format. The rest is a stream with a checksum (RFC 1952,
//! without compression): the settings that a render which goes on has to have too, by name, and the state of the engine. Each
//! new state is written to a file of its own, which then takes the place of the one before: whenever a program
//! ends, one of the two is there.

use std::fmt;
use std::fs::{self, File, TryLockError};
use std::io::{self, BufReader, BufWriter, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

use flate2::Compression;
use flate2::read::GzDecoder;
use flate2::write::GzEncoder;

use super::progress::StateWriter;
use super::{AnyKernel, Observer, RenderSettings, Rendered, render, resume};
use crate::image::atomic_write::write_as;
use crate::stored::Stored;

/// What a file begins with.
const NAME: &[u8; 16] = b"AetherCheckpoint";
/// Of the format, the state of integrators included.
const VERSION: u32 = 5;

/// A file for the state of a render.
#[derive(Clone, Debug)]
pub struct Checkpoint {
    path: PathBuf,
    settings: Vec<(String, String)>,
}

/// Why a render cannot go on from a file.
#[derive(Debug)]
pub struct CheckpointError {
    path: PathBuf,
    why: String,
    /// What to do.
    remedy: &'static str,
}

const OTHER_FILE: &str = "name another file, or remove this one to begin anew";

impl fmt::Display for CheckpointError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (path, why, remedy) = (self.path.display(), &self.why, self.remedy);
        write!(f, "cannot go on from `{path}`: {why}; {remedy}")
    }
}

impl std::error::Error for CheckpointError {}

impl Checkpoint {
    /// A file, which need not exist, and the names and values of all settings that samples depend on.
    pub fn new(path: &Path, settings: Vec<(String, String)>) -> Self {
        Checkpoint { path: path.to_owned(), settings }
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes the state that an observer is given.
    ///
    /// # Errors
    /// If the file cannot be written; the one before is still there.
    pub fn write(&self, state: StateWriter<'_>) -> io::Result<()> {
        write_as(&self.path, "checkpoint", &|file: &mut File| {
            file.write_all(NAME)?;
            VERSION.store(file)?;
            // Sums and noise hardly get smaller.
            let mut to =
                BufWriter::with_capacity(1 << 16, GzEncoder::new(file, Compression::none()));
            self.settings.store(&mut to)?;
            state(&mut to)?;
            to.into_inner().map_err(io::IntoInnerError::into_error)?.finish()?;
            Ok(())
        })
    }

    /// Goes on from the file if it exists, else renders from the beginning. Nobody else does meanwhile.
    ///
    /// # Errors
    /// If the file is no checkpoint, is damaged, is one of a render with other settings, or if another process is at
    /// it.
    pub fn render(
        &self,
        kernel: &dyn AnyKernel,
        settings: &RenderSettings,
        observer: &dyn Observer,
    ) -> Result<Rendered, CheckpointError> {
        let error = |why| CheckpointError { path: self.path.clone(), why, remedy: OTHER_FILE };
        let _lock = self.lock()?;
        match File::open(&self.path) {
            Ok(file) => {
                let mut state = self.state(BufReader::new(file)).map_err(error)?;
                let rendered = resume(kernel, settings, observer, &mut state);
                rendered.map_err(|e| error(damage(e)))
            }
            Err(e) if e.kind() == ErrorKind::NotFound => Ok(render(kernel, settings, observer)),
            Err(e) => Err(error(e.to_string())),
        }
    }

    /// Keeps other processes from the file as long as the outcome lives; a process that ends in whatever way lets go.
    /// Where files cannot be locked there is no lock.
    fn lock(&self) -> Result<Option<Lock>, CheckpointError> {
        let mut path = self.path.clone().into_os_string();
        path.push(".lock");
        let path = PathBuf::from(path);
        let opened = File::options().write(true).create(true).truncate(false).open(&path);
        let Ok(file) = opened else { return Ok(None) };
        // A lock is empty. What is not was there before, and is somebody's.
        if file.metadata().is_ok_and(|found| found.len() > 0) {
            return Err(CheckpointError {
                path: self.path.clone(),
                why: format!("its lock would be `{}`, which is another file", path.display()),
                remedy: OTHER_FILE,
            });
        }
        match file.try_lock() {
            Ok(()) => Ok(Some(Lock { path, _file: file })),
            Err(TryLockError::Error(_)) => Ok(None),
            Err(TryLockError::WouldBlock) => Err(CheckpointError {
                path: self.path.clone(),
                why: "another process renders from it and to it".to_owned(),
                remedy: "wait for its end, or name another file",
            }),
        }
    }

    /// What follows the settings in a file, if these are the same.
    fn state(&self, mut file: impl Read) -> Result<impl Read, String> {
        let mut name = [0; NAME.len()];
        let read = file.read_exact(&mut name);
        if read.is_err() || name != *NAME {
            return Err("it is no checkpoint".to_owned());
        }
        let version = u32::load(&mut file).map_err(damage)?;
        if version != VERSION {
            return Err(format!(
                "it has version {version} of the format, and this program knows version {VERSION}"
            ));
        }
        let mut file = BufReader::with_capacity(1 << 16, GzDecoder::new(file));
        let made: Vec<(String, String)> = Stored::load(&mut file).map_err(damage)?;
        let value = |settings: &[(String, String)], name: &str| {
            let found = settings.iter().find(|setting| setting.0 == name);
            found.map_or("nothing".to_owned(), |setting| format!("`{}`", setting.1))
        };
        let names = made.iter().chain(&self.settings).map(|setting| &setting.0);
        let mut differences = Vec::new();
        for name in names {
            let (was, is) = (value(&made, name), value(&self.settings, name));
            let difference = format!("its {name} is {was}, and that of this render {is}");
            if was != is && !differences.contains(&difference) {
                differences.push(difference);
            }
        }
        if differences.is_empty() { Ok(file) } else { Err(differences.join("; ")) }
    }
}

/// A file that is locked until it is removed.
struct Lock {
    path: PathBuf,
    _file: File,
}

impl Drop for Lock {
    fn drop(&mut self) {
        // If it stays, it is locked by nobody.
        let _ = fs::remove_file(&self.path);
    }
}

/// What an error says of a file that begins well.
fn damage(error: io::Error) -> String {
    match error.kind() {
        ErrorKind::UnexpectedEof => "it is cut short".to_owned(),
        ErrorKind::InvalidData | ErrorKind::InvalidInput => format!("it is damaged: {error}"),
        _ => error.to_string(),
    }
}
