//! Fuzzing of everything that reads files: `cargo run --release -p integrators --example fuzz_loader --
//! --seconds 300`.
//!
//! Damages the files of `tests/scenes` at random and loads them. No panic, no case that takes long, none that
//! takes much memory; what fails can be repeated, and seen, by its number with
//! `--case`.

mod mutate;

use std::alloc::{GlobalAlloc, Layout, System};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::time::Instant;

use mutate::{Outcome, damaged_file, seeds, try_case};

const USAGE: &str =
    "fuzz_loader [--seconds N] [--first CASE] [--case CASE]   (60 seconds from case 0)";

/// Files here have at most 200 kilobytes.
const MOST_BYTES: usize = 1 << 29;
const MOST_SECONDS: f64 = 5.0;

/// The system's allocator, counting bytes.
struct Counting;

static NOW: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

// SAFETY: every call is passed on unchanged to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let now = NOW.fetch_add(layout.size(), Relaxed) + layout.size();
        PEAK.fetch_max(now, Relaxed);
        // SAFETY: the caller's promises are those that the system asks for.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        NOW.fetch_sub(layout.size(), Relaxed);
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

fn main() -> ExitCode {
    let (mut seconds, mut first, mut only) = (60, 0, None);
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let number = words.next().and_then(|n| n.parse::<u64>().ok());
        match (word.as_str(), number) {
            ("--seconds", Some(n)) => seconds = n,
            ("--first", Some(n)) => first = n,
            ("--case", Some(n)) => only = Some(n),
            _ => {
                eprintln!("{USAGE}");
                return ExitCode::from(2);
            }
        }
    }
    let seeds = seeds(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenes"));
    let scratch = std::env::temp_dir().join(format!("aether-fuzz-{}", std::process::id()));
    std::fs::create_dir_all(&scratch).expect("a scratch folder");
    if let Some(case) = only {
        let (name, bytes) = damaged_file(&seeds, case);
        let kept = std::env::temp_dir().join(format!("damaged-{case}-{name}"));
        std::fs::write(&kept, bytes).expect("a file");
        println!("{}", kept.display());
    }
    let start = Instant::now();
    let (mut cases, mut loaded, mut failures) = (0u64, 0u64, 0u64);
    let (mut slowest, mut largest) = (0.0f64, 0);
    for case in only.unwrap_or(first).. {
        let base = NOW.load(Relaxed);
        PEAK.store(base, Relaxed);
        let began = Instant::now();
        let result = catch_unwind(AssertUnwindSafe(|| try_case(&seeds, case, &scratch)));
        let took = began.elapsed().as_secs_f64();
        let bytes = PEAK.load(Relaxed) - base;
        cases += 1;
        slowest = slowest.max(took);
        largest = largest.max(bytes);
        let fine = result.is_ok() && took < MOST_SECONDS && bytes < MOST_BYTES;
        if !fine || only.is_some() {
            println!("case {case}: {took:.2} s, {bytes} bytes, {result:?}");
        }
        failures += u64::from(!fine);
        loaded += u64::from(matches!(result, Ok((_, Outcome::Loaded))));
        if only.is_some() || start.elapsed().as_secs() >= seconds {
            break;
        }
    }
    let _ = std::fs::remove_dir_all(&scratch);
    println!(
        "{cases} files, {loaded} of them loaded, {failures} failures; the slowest took {slowest:.2} s, the \
         largest {largest} bytes"
    );
    if failures == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
