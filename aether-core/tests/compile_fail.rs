//! A manual of mistakes: what does not compile, and what the compiler says about it.
//!
//! Each file of `tests/ui` begins with the mistake that it makes; beside it is the message. Every text
//! says what is wrong, why, and what to write instead. After a change of a text:
//! `UPDATE=1 cargo test -p aether-core --test compile_fail`, then read the difference.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;
use std::time::SystemTime;
use std::{env, fs, thread};

#[test]
fn mistakes_are_explained_where_they_are() {
    let compiler = Compiler::of_this_build();
    let left = Mutex::new(mistakes());
    let wrong = Mutex::new(Vec::new());
    thread::scope(|scope| {
        for _ in 0..thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                while let Some(file) = { left.lock().unwrap().pop() } {
                    if let Err(why) = check(&compiler, &file) {
                        wrong.lock().unwrap().push(why);
                    }
                }
            });
        }
    });
    let wrong = wrong.into_inner().unwrap();
    assert!(wrong.is_empty(), "{} files:\n\n{}", wrong.len(), wrong.join("\n\n"));
}

#[test]
fn every_file_says_what_its_mistake_is() {
    let files = mistakes();
    assert!(files.len() >= 40, "only {} mistakes", files.len());
    for file in files {
        let text = fs::read_to_string(&file).expect("is text");
        assert!(text.starts_with("// "), "{} does not begin with its mistake", file.display());
        assert!(file.with_extension("stderr").exists(), "{} has no message", file.display());
    }
}

/// A crate may depend on this one under another name, if it says at its root what emitted code calls it.
#[test]
fn a_renamed_dependency_is_known_to_emitted_code() {
    let compiler = Compiler::of_this_build();
    let program = "use ae::prelude::*;
        #[sampler]
        fn twice(u: [Uniform; 1]) -> f64 { 2.0 * u[0] }
        fn main() { assert_eq!(twice().pdf(&0.5f64).value(), 0.5); }";
    let file = compiler.scratch.join("renamed.rs");
    let message = |root: &str| {
        fs::write(&file, root.to_owned() + program).expect("can be written");
        compiler.message_as(&file, "ae")
    };
    assert!(message("").is_some_and(|text| text.contains("aether_core")));
    assert_eq!(message("extern crate ae as aether_core;\n"), None);
}

/// The programs that do not compile.
fn mistakes() -> Vec<PathBuf> {
    let folder = fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/ui"));
    let files = folder.expect("the folder exists").map(|file| file.expect("is readable").path());
    let mut programs: Vec<_> =
        files.filter(|file| file.extension().is_some_and(|e| e == "rs")).collect();
    programs.sort_unstable();
    programs
}

/// That a program does not compile, with the message beside it.
fn check(compiler: &Compiler, file: &Path) -> Result<(), String> {
    let found = compiler.message(file).ok_or_else(|| format!("{} compiles", file.display()))?;
    let beside = file.with_extension("stderr");
    if env::var_os("UPDATE").is_some() {
        fs::write(&beside, &found).expect("can be written");
        return Ok(());
    }
    let expected = fs::read_to_string(&beside).unwrap_or_default();
    if found == expected {
        return Ok(());
    }
    Err(format!("{}\n--- expected\n{expected}\n--- found\n{found}", file.display()))
}

/// rustc with the crate as this test run has built it, so that nothing is built once more.
struct Compiler {
    /// Where cargo puts libraries.
    libraries: PathBuf,
    /// The library of this crate.
    library: PathBuf,
    /// Where what rustc makes goes.
    scratch: PathBuf,
}

impl Compiler {
    fn of_this_build() -> Self {
        let test = env::current_exe().expect("a test has a path");
        let libraries = test.parent().expect("it is in a folder").to_owned();
        let age = |file: &PathBuf| {
            fs::metadata(file).and_then(|m| m.modified()).unwrap_or(SystemTime::UNIX_EPOCH)
        };
        // There is one for each set of features that was ever built; the newest is of today's sources.
        let files = fs::read_dir(&libraries).expect("is readable").flatten().map(|f| f.path());
        let library = files.filter(|file| {
            let name = file.file_name().unwrap_or_default().to_string_lossy();
            name.starts_with("libaether_core-") && name.ends_with(".rlib")
        });
        let library = library.max_by_key(age).expect("cargo builds the library before its tests");
        let scratch = Path::new(env!("CARGO_TARGET_TMPDIR")).to_owned();
        Compiler { libraries, library, scratch }
    }

    /// What rustc says of a program that does not compile, without what differs between machines.
    fn message(&self, file: &Path) -> Option<String> {
        self.message_as(file, "aether_core")
    }

    /// The same of a program that knows this crate by a name.
    fn message_as(&self, file: &Path, name: &str) -> Option<String> {
        // Where rustc finds the lines of this crate that a message shows.
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("a workspace is around");
        let mut library = OsString::from(format!("{name}="));
        library.push(&self.library);
        let mut dependencies = OsString::from("dependency=");
        dependencies.push(&self.libraries);
        let output = Command::new(env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()))
            .current_dir(root)
            .args(["--edition", "2024", "--color", "never", "--emit", "metadata", "--extern"])
            .arg(library)
            .arg("-L")
            .arg(dependencies)
            .arg("--out-dir")
            .arg(&self.scratch)
            .arg(file.strip_prefix(root).unwrap_or(file))
            .output()
            .expect("rustc can be started");
        if output.status.success() {
            return None;
        }
        Some(normalised(&String::from_utf8_lossy(&output.stderr)))
    }
}

/// A message without what differs between machines and versions: folders, how many errors there are, and numbers of
/// lines other than the program's.
fn normalised(message: &str) -> String {
    const SUMMARIES: [&str; 3] =
        ["error: aborting due to", "For more information about", "Some errors have detailed"];
    let is_summary = |line: &str| {
        let is_count = line.contains(" warning emitted") || line.contains(" warnings emitted");
        is_count || SUMMARIES.iter().any(|start| line.starts_with(start))
    };
    let diagnostics = message.split("\n\n").map(|diagnostic| {
        let lines: Vec<_> = diagnostic.lines().filter(|line| !is_summary(line)).collect();
        of_one_width(&lines)
    });
    let diagnostics: Vec<String> = diagnostics.filter(|text| !text.is_empty()).collect();
    diagnostics.join("\n\n") + "\n"
}

/// The lines of one diagnostic, with a margin that is as wide as the line numbers of the program need.
fn of_one_width(lines: &[&str]) -> String {
    let sign = |line: &str| ["--> ", "::: "].iter().find_map(|sign| line.find(sign));
    let margin = lines.iter().find_map(|line| sign(line)).unwrap_or(0);
    let (mut elsewhere, mut needed) = (false, 1);
    // What stands in the margin, and what right of it.
    let mut parts = Vec::new();
    for line in lines {
        if let Some((before, path)) = sign(line).map(|at| line.split_at(at + 4)) {
            elsewhere = !path.starts_with("aether-core/tests/ui/");
            parts.push((Some(""), before[margin..].to_owned() + &place(path, elsewhere)));
            continue;
        }
        let left = line.get(..margin).unwrap_or_default().trim();
        // Text without a margin: what the diagnostic says next, or lines that are left out.
        if !left.bytes().all(|c| c.is_ascii_digit()) {
            elsewhere &= line.starts_with("...");
            parts.push((None, (*line).to_owned()));
            continue;
        }
        let number = if elsewhere { "" } else { left };
        needed = needed.max(number.len());
        parts.push((Some(number), line.get(margin..).unwrap_or_default().to_owned()));
    }
    let lines = parts.iter().map(|(number, rest)| match number {
        Some(number) => format!("{number:>needed$}{rest}"),
        None => rest.clone(),
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// A place in a source, as its package sees it; of other sources than the program without the line.
fn place(path: &str, elsewhere: bool) -> String {
    let path = if elsewhere { path.split(':').next().unwrap_or(path) } else { path };
    if let Some((_, package)) = path.split_once("/registry/src/")
        && let Some((package, file)) = package.split_once('/').and_then(|(_, p)| p.split_once('/'))
    {
        let name = package.rsplit_once('-').map_or(package, |(name, _)| name);
        return format!("$CARGO/{name}-$VERSION/{file}");
    }
    path.strip_prefix("aether-core/").unwrap_or(path).to_owned()
}
