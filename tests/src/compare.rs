//! Samplers of the catalogue against their reference values: what fails, and whether a mistake of
//! one percent would.

use crate::errors::{Errors, errors, errors_off_by, values};
use crate::reference::{PointEntry, Query, Reference};

/// Relative error that a well-conditioned value may have in `f64`.
pub const TOLERANCE: f64 = 1e-12;
/// A condition number says what rounding of the inputs may cost, and an implementation that does
/// not round them loses less: more than this is never excused by it.
const WORST_CONDITION: f64 = 1e3;

/// Where the loss is real all the same, and the full condition number is the limit: the row, what of
/// it (`sample`, `pdf(x)` or `sample.pdf()`), and the reason.
pub type IllConditioned = (u64, &'static str, &'static str);

/// All that fails at the points of the reference data.
pub fn failures(reference: &Reference, exceptions: &[IllConditioned]) -> Vec<String> {
    reference.points.iter().flat_map(|p| failures_at(p, errors::<f64>(p), exceptions)).collect()
}

fn failures_at(entry: &PointEntry, e: Errors, exceptions: &[IllConditioned]) -> Vec<String> {
    let row = entry.inputs.row;
    let limit = |what: &str, condition: f64| {
        let excused = exceptions.iter().any(|(r, w, _)| *r == row && *w == what);
        TOLERANCE * condition.clamp(1.0, if excused { f64::INFINITY } else { WORST_CONDITION })
    };
    let cases = [
        ("sample", e.sample, limit("sample", entry.condition_sample)),
        ("pdf(x)", e.pdf, limit("pdf(x)", entry.condition_pdf)),
        ("sample.pdf()", e.own, limit("sample.pdf()", entry.condition_pdf)),
    ];
    let failed = cases.into_iter().filter(|(_, error, limit)| error > limit);
    failed
        .map(|(what, error, limit)| {
            format!("{row} ({}) {what}: {error:.2e} > {limit:.1e} at {entry:?}", entry.inputs.name)
        })
        .collect()
}

/// The queries whose density is wrong.
pub fn wrong_densities(reference: &Reference) -> Vec<String> {
    let wrong = |query: &Query| {
        // A direction off the unit sphere cannot even be written down.
        let found = values::<f64>(&query.inputs, &[], &query.x).pdf;
        let right = match found {
            None => query.pdf == 0.0,
            Some(p) if query.pdf.is_infinite() => p == query.pdf,
            Some(p) if query.pdf == 0.0 => p == 0.0,
            Some(p) => (p - query.pdf).abs() <= TOLERANCE * query.pdf,
        };
        (!right).then(|| format!("density {found:?} at {query:?}"))
    };
    reference.queries.iter().filter_map(wrong).collect()
}

/// Points at which the comparison does not notice that densities are one percent too large.
pub fn unnoticed<'a>(
    reference: &'a Reference,
    exceptions: &'a [IllConditioned],
) -> impl Iterator<Item = &'a PointEntry> {
    let positive = |p: &&PointEntry| p.pdf > f64::MIN_POSITIVE && p.pdf.is_finite();
    reference.points.iter().filter(positive).filter(|entry| {
        let found = failures_at(entry, errors_off_by::<f64>(entry, 1.01), exceptions);
        let noticed = |what: &str| found.iter().any(|f| f.contains(what));
        !(noticed(" pdf(x)") && noticed("sample.pdf()"))
    })
}
