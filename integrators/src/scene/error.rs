//! What went wrong while a scene was read, and where.

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A scene file as it was read.
#[derive(Debug, PartialEq, Eq)]
pub struct Source {
    /// Where it was found.
    pub path: PathBuf,
    /// What it says.
    pub text: String,
}

/// A position in a scene file: the element that a property or an object came from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file.
    pub source: Arc<Source>,
    /// Where the element begins, in bytes.
    pub offset: usize,
    /// The element in short, for example `<bsdf type="diffuse">`.
    pub element: Arc<str>,
}

impl Place {
    /// An error about this element.
    pub fn error(&self, message: impl Into<String>) -> SceneError {
        // Only counted now: counting for every element would take quadratic time.
        let before = self.source.text.get(..self.offset).unwrap_or("");
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
        SceneError {
            file: self.source.path.clone(),
            line: Some(line as u32),
            column: Some(column as u32),
            element: Some(self.element.to_string()),
            message: message.into(),
        }
    }
}

/// The first reason why a scene cannot be rendered as its file says.
///
/// It prints as `cbox.xml:12:5: <bsdf type="foo">: not supported; supported: diffuse, twosided`,
/// with the parts that are known.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneError {
    /// The file that the error is in.
    pub file: PathBuf,
    /// Line, counted from 1.
    pub line: Option<u32>,
    /// Column in characters, counted from 1.
    pub column: Option<u32>,
    /// The element, or for a mesh file the item, that the error is about.
    pub element: Option<String>,
    /// What is wrong and what to do about it.
    pub message: String,
}

impl SceneError {
    /// An error about a file as a whole.
    pub fn in_file(file: &Path, message: impl Into<String>) -> Self {
        Self {
            file: file.to_path_buf(),
            line: None,
            column: None,
            element: None,
            message: message.into(),
        }
    }

    /// The same error at a line of its file.
    #[must_use]
    pub fn at_line(mut self, line: u32) -> Self {
        self.line = Some(line);
        self
    }

    /// The same error about an item of its file, such as `vertex 17`.
    #[must_use]
    pub fn about(mut self, element: impl Into<String>) -> Self {
        self.element = Some(element.into());
        self
    }
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        if let Some(column) = self.column {
            write!(f, ":{column}")?;
        }
        if let Some(element) = &self.element {
            write!(f, ": {element}")?;
        }
        write!(f, ": {}", self.message)
    }
}

impl std::error::Error for SceneError {}
