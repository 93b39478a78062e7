//! All samplers in both precisions, on all threads. What comes out does not depend on how many there are: each part
//! has a random stream of its own, and parts are merged in order.

use std::fs::File;
use std::io::Write;
use std::panic::resume_unwind;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use super::measure::{Row, Settings, chosen, random};
use super::stored;
use crate::reference::{PointEntry, Reference};
use crate::registry::Item;

/// How many random points a thread takes at once, in `f64` and in `f32`.
const PART: [u64; 2] = [1_000, 100_000];

/// Some random points of a sampler in a precision.
#[derive(Clone, Copy)]
struct Part {
    /// Number of the sampler, and that of the precision.
    place: [usize; 2],
    number: u64,
    first: u64,
    count: u64,
}

/// What is found of a sampler in a precision, as it comes in.
struct Open {
    parts: Vec<Option<Row>>,
    missing: usize,
    time: Duration,
}

/// The rows of these samplers, in `f64` and `f32`; `finished` is told of each as soon as it is complete, and how long
/// its random points took all threads together. Rows that are in the file `kept` are not made again, and others are
/// added to it.
///
/// # Errors
/// If the file cannot be written.
pub fn run(
    items: &[Item],
    settings: Settings,
    kept: Option<&Path>,
    finished: &(dyn Fn(&Row, Duration) + Sync),
) -> std::io::Result<Vec<Row>> {
    let counts = [settings.double, settings.single];
    let known = kept.map(|path| stored::read(path, counts)).unwrap_or_default();
    let known = |i: usize| {
        let precision = ["f64", "f32"][i % 2];
        known.iter().find(|row| row.name == items[i / 2].name && row.precision == precision)
    };
    let file = kept.map(|path| File::options().create(true).append(true).open(path)).transpose()?;
    let tried = [Reference::load(), Reference::load_branched()];
    let mut rows = on_all_threads(2 * items.len(), |i| {
        let item = &items[i / 2];
        if let Some(known) = known(i) {
            return known.clone();
        }
        let about = |p: &&PointEntry| p.inputs.row == item.row && p.inputs.name == item.name;
        let entries = tried.iter().flat_map(|r| &r.points).filter(about);
        let entries: Vec<PointEntry> = entries.cloned().collect();
        match i % 2 {
            0 => chosen::<f64>(item, &entries, settings.sweep),
            _ => chosen::<f32>(item, &entries, settings.sweep),
        }
    });
    let parts_of = |p: usize| counts[p].div_ceil(PART[p]);
    let parts = (0..2 * items.len()).filter(|i| known(*i).is_none()).flat_map(|i| {
        (0..parts_of(i % 2)).map(move |number| {
            let [size, all] = [PART[i % 2], counts[i % 2]];
            let first = number * size;
            Part { place: [i / 2, i % 2], number, first, count: size.min(all - first) }
        })
    });
    let parts: Vec<Part> = parts.collect();
    let open = |i: usize| {
        let missing = parts_of(i % 2) as usize;
        Mutex::new(Open { parts: vec![None; missing], missing, time: Duration::ZERO })
    };
    let open: Vec<Mutex<Open>> = (0..rows.len()).map(open).collect();
    let failed = Mutex::new(Vec::new());
    let done: Vec<Option<Row>> = on_all_threads(parts.len(), |k| {
        let Part { place: [item, precision], number, first, count } = parts[k];
        let i = 2 * item + precision;
        let start = Instant::now();
        let row = match precision {
            0 => random::<f64>(&items[item], &rows[i], number, first, count),
            _ => random::<f32>(&items[item], &rows[i], number, first, count),
        };
        let mut open = open[i].lock().ok()?;
        open.parts[number as usize] = Some(row);
        open.missing -= 1;
        open.time += start.elapsed();
        if open.missing > 0 {
            return None;
        }
        let mut all = rows[i].clone();
        core::mem::take(&mut open.parts).iter().flatten().for_each(|part| all.merge(part));
        finished(&all, open.time);
        if let Some(mut file) = file.as_ref() {
            // In one piece, as other threads write too.
            let written = file.write_all(stored::line(&all, counts[precision]).as_bytes());
            failed.lock().ok()?.extend(written.err());
        }
        Some(all)
    });
    if let Some(error) = failed.into_inner().ok().and_then(|mut failed| failed.pop()) {
        return Err(error);
    }
    // Where there are no random points, the row is what was found before.
    for (part, row) in parts.iter().zip(done) {
        if let Some(row) = row {
            rows[2 * part.place[0] + part.place[1]] = row;
        }
    }
    Ok(rows)
}

/// The values of a function of numbers below `count`, computed by all threads, which take the next one when they are
/// done with one.
pub fn on_all_threads<T: Send>(count: usize, value: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let work = || {
        let take = || Some(next.fetch_add(1, Ordering::Relaxed)).filter(|i| *i < count);
        core::iter::from_fn(take).map(|i| (i, value(i))).collect::<Vec<(usize, T)>>()
    };
    let mut all: Vec<(usize, T)> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        threads
            .into_iter()
            .flat_map(|t| t.join().unwrap_or_else(|panic| resume_unwind(panic)))
            .collect()
    });
    all.sort_by_key(|(i, _)| *i);
    all.into_iter().map(|(_, value)| value).collect()
}
