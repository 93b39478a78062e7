//! The stability report as text: for people, for tables and for programs.

use serde_json::{Value, json};

use super::measure::{Row, Settings};
use super::reasons::reason;
use super::tally::Tally;
use crate::leaks::Leaks;

/// All that is reported.
pub struct Report {
    /// How much was tried.
    pub settings: Settings,
    /// A sampler in a precision each.
    pub rows: Vec<Row>,
    /// Rays that left closed rooms.
    pub leaks: Leaks,
}

/// One object, with a list of `rows`, for programs to read.
pub fn json(report: &Report) -> Value {
    let Leaks { aimed, rays, lost, .. } = report.leaks;
    let leaks = json!({ "aimed": aimed, "rays": rays, "lost": lost });
    json!({ "rows": report.rows.iter().map(as_json).collect::<Vec<_>>(), "leaks": leaks })
}

fn as_json(row: &Row) -> Value {
    let tally = |t: &Tally| {
        let median = if t.count() > 0 { Some(t.median()) } else { None };
        json!({ "worst": t.worst, "worst_over_condition": t.worst_over, "median": median, "at": t.at })
    };
    json!({
        "name": row.name,
        "precision": row.precision,
        "worst_ulp": row.worst(),
        "worst_ulp_over_condition": row.worst_over(),
        "false_zeros": row.false_zeros,
        "nan": row.nan,
        "infinite": row.infinite,
        "excused": row.excused,
        "not_judged": row.unjudged,
        "samples": row.samples,
        "sample": tally(&row.sample),
        "inverse": tally(&row.inverse),
        "pdf": tally(&row.pdf),
        "own_pdf": tally(&row.own),
        "extremes": tally(&row.extremes),
        "textbook": tally(&row.textbook),
        "oracle": tally(&row.oracle),
        "mitsuba": tally(&row.mitsuba),
        "pdf_beside_mitsuba": tally(&row.beside_mitsuba),
        "dropped": row.dropped,
        "examples": row.examples,
    })
}

/// All figures, a line a row.
pub fn csv(rows: &[Row]) -> String {
    let mut text =
        String::from("name,precision,samples,false zeros,nan,infinite,excused,not judged");
    let columns = ["sample", "inverse", "pdf", "own pdf", "extremes", "textbook"];
    for what in columns.iter().chain(&["Mitsuba", "pdf beside Mitsuba"]) {
        text += &format!(",{what} worst,{what} over condition,{what} median");
    }
    text.push('\n');
    text + &rows.iter().map(csv_row).collect::<String>()
}

/// The line of a row.
pub fn csv_row(row: &Row) -> String {
    let mut text = format!(
        "\"{}\",{},{},{},{},{},{},{}",
        row.name,
        row.precision,
        row.samples,
        row.false_zeros,
        row.nan,
        row.infinite,
        row.excused,
        row.unjudged
    );
    let tallies = [&row.sample, &row.inverse, &row.pdf, &row.own, &row.extremes, &row.textbook];
    for t in tallies.into_iter().chain([&row.mitsuba, &row.beside_mitsuba]) {
        if t.count() == 0 {
            text += ",,,";
        } else {
            text += &format!(",{:.3e},{:.3e},{:.2e}", t.worst, t.worst_over, t.median());
        }
    }
    text + "\n"
}

/// A figure in few characters.
fn short(x: f64) -> String {
    if x < 1000.0 { format!("{x:.1}") } else { format!("{x:.0e}") }
}

/// Worst over condition, worst and median.
fn triple(t: &Tally) -> String {
    if t.count() == 0 {
        return "-".into();
    }
    format!("{} ({}, {})", short(t.worst_over), short(t.worst), short(t.median()))
}

/// The report for people.
pub fn markdown(report: &Report) -> String {
    let rows = &report.rows[..];
    let mut text = introduction(report.settings) + &summary(rows);
    for precision in ["f64", "f32"] {
        text += &format!("\n## {precision}\n\n");
        text += "| sampler | sample | inverse | pdf(x) | sample.pdf() | extreme points | textbook | zeros | NaN | infinite | excused | not judged | points |\n";
        text += &format!("|{}\n", " --- |".repeat(13));
        for row in rows.iter().filter(|r| r.precision == precision) {
            let all = [&row.sample, &row.inverse, &row.pdf, &row.own, &row.extremes, &row.textbook];
            text += &format!(
                "| {} | {} | {} | {} | {} | {} | {} | {} |\n",
                row.name,
                all.map(triple).join(" | "),
                row.false_zeros,
                row.nan,
                row.infinite,
                row.excused,
                row.unjudged,
                row.samples
            );
        }
        let of_precision = |r: &&Row| r.precision == precision;
        text += &format!(
            "\nNot known to be within {LIMIT} units over the condition number at extreme points of the reference data:\n\n"
        );
        for row in rows.iter().filter(of_precision).filter(|r| r.extremes.worst_over > KNOWN) {
            let (over, at) = (short(row.extremes.worst_over), &row.extremes.at);
            text += &format!("- {}: {over}, {at}; {}\n", row.name, reason(&row.name, precision));
        }
        text += &format!(
            "\nNot known to be within {LIMIT} units over the condition number anywhere:\n\n"
        );
        for row in rows.iter().filter(of_precision).filter(|r| r.worst_over() > KNOWN) {
            let over = short(row.worst_over());
            text += &format!(
                "- {}: {over}, {}; {}\n",
                row.name,
                row.at(),
                reason(&row.name, precision)
            );
        }
        text += &inverses(rows, precision);
        let with_examples = rows.iter().filter(|r| r.precision == precision);
        let examples: Vec<String> = with_examples
            .flat_map(|r| {
                r.examples
                    .iter()
                    .map(|e| format!("- {}: {e}; {}\n", r.name, reason(&r.name, precision)))
            })
            .collect();
        if !examples.is_empty() {
            text += &format!("\nFalse zeros, NaN and infinities:\n\n{}", examples.concat());
        }
        let mut dropped: Vec<String> = rows
            .iter()
            .filter(|r| r.precision == precision)
            .flat_map(|r| r.dropped.iter().map(|d| format!("- {}: {d}\n", r.name)))
            .collect();
        dropped.dedup();
        if !dropped.is_empty() {
            text +=
                &format!("\nLeft out, because rounding leaves the domain:\n\n{}", dropped.concat());
        }
    }
    text + &oracle(rows)
        + &beside_mitsuba(rows)
        + "\n## Rays at edges and corners\n\n"
        + &rays(&report.leaks)
        + "\n"
}

/// Inverses that are far off, the worst first.
fn inverses(rows: &[Row], precision: &str) -> String {
    let off = |r: &&Row| r.precision == precision && r.inverse.worst_over > KNOWN;
    let mut rows: Vec<&Row> = rows.iter().filter(off).collect();
    rows.sort_by(|a, b| b.inverse.worst_over.total_cmp(&a.inverse.worst_over));
    let line = |row: &&Row| {
        let Tally { worst_over, worst, at, .. } = &row.inverse;
        format!("- {}: {} ({}), {at}\n", row.name, short(*worst_over), short(*worst))
    };
    let lines: String = rows.iter().map(line).collect();
    format!(
        "\nInverses not known to be within {LIMIT} units over the condition number anywhere:\n\n{lines}"
    )
}

/// How many rays left a closed room.
pub fn rays(leaks: &Leaks) -> String {
    let Leaks { aimed, rays, lost, first } = leaks;
    let onward = rays - aimed;
    let first: String = first.iter().map(|from| format!("\n- {from}")).collect();
    format!(
        "Of {aimed} rays aimed at edges and corners of closed rooms, some of them shared by hundreds of triangles, and \
         {onward} that went on from there in directions that often graze the walls, {lost} left.{first}"
    )
}

/// Both precisions side by side.
fn summary(rows: &[Row]) -> String {
    let line = |what: &str, figure: &dyn Fn(&[&Row]) -> String| {
        let of = |precision| rows.iter().filter(move |r| r.precision == precision).collect();
        let both: [Vec<&Row>; 2] = ["f64", "f32"].map(of);
        format!("| {what} | {} |\n", both.map(|rows| figure(&rows)).join(" | "))
    };
    let counted = |of: fn(&Row) -> u64| {
        move |rows: &[&Row]| {
            let with = rows.iter().filter(|r| of(r) > 0).count();
            format!("{with}, {}", rows.iter().map(|r| of(r)).sum::<u64>())
        }
    };
    let within = |over: fn(&Row) -> f64, asked: fn(&Row) -> bool| {
        move |rows: &[&Row]| {
            let asked: Vec<&&Row> = rows.iter().filter(|r| asked(r)).collect();
            format!("{} of {}", asked.iter().filter(|r| over(r) <= KNOWN).count(), asked.len())
        }
    };
    let extremes = within(|r| r.extremes.worst_over, |r| r.extremes.count() > 0);
    let medians = |rows: &[&Row]| {
        let median = |tally: fn(&Row) -> &Tally| {
            let mut all: Vec<f64> = rows.iter().map(|r| tally(r).median()).collect();
            all.retain(|m| !m.is_nan());
            all.sort_by(f64::total_cmp);
            all.get(all.len() / 2).map_or("-".into(), |m| format!("{m:.2}"))
        };
        [median(|r| &r.sample), median(|r| &r.pdf), median(|r| &r.own)].join(", ")
    };
    let limit = format!("samplers within {LIMIT} units over the condition number at");
    [
        String::from("\n## Summary\n\n| | f64 | f32 |\n| --- | --- | --- |\n"),
        line("samplers", &|rows| rows.len().to_string()),
        line("points tried", &|rows| rows.iter().map(|r| r.samples).sum::<u64>().to_string()),
        line(&format!("{limit} the extreme points of the reference data"), &extremes),
        line(&format!("{limit} all points"), &within(|r| r.worst_over(), |_| true)),
        line("samplers with a false zero, of these points", &counted(|r| r.false_zeros)),
        line("samplers with NaN, of these points", &counted(|r| r.nan)),
        line("samplers with a false infinity, of these points", &counted(|r| r.infinite)),
        line("samplers with points where rounding explains a zero, an infinity or a lost sample, of these points", &counted(|r| r.excused)),
        line("samplers with points that are not judged, of these points", &counted(|r| r.unjudged)),
        line(&format!("inverses {} all points", &limit["samplers ".len()..]) , &within(|r| r.inverse.worst_over, |r| r.inverse.count() > 0)),
        line("median error of samples, pdf(x) and sample.pdf() (median over samplers)", &medians),
    ]
    .concat()
}

/// Where the oracle itself differs from the reference data.
fn oracle(rows: &[Row]) -> String {
    let points: u64 = rows.iter().map(|r| r.oracle.count()).sum();
    let off = rows.iter().filter(|r| r.oracle.worst > 2.0);
    let off: Vec<String> = off
        .map(|r| format!("- {}: {} units, {}\n", r.name, short(r.oracle.worst), r.oracle.at))
        .collect();
    format!(
        "\n## The oracle\n\nAgainst {points} samples and densities of the reference data, computed with 50 \
         digits and more, it is off by more than two units at these:\n\n{}",
        off.concat()
    )
}

/// Densities of Mitsuba and ours at the same points.
fn beside_mitsuba(rows: &[Row]) -> String {
    let mut text = String::from(
        "\n## Beside Mitsuba 3, f32\n\n`mitsuba.warp` and `pdf(x)` at the points of \
         `mitsuba-warp.csv`, both in single precision.\n\n| sampler | Mitsuba | pdf(x) | points |\n\
         | --- | --- | --- | --- |\n",
    );
    for row in rows.iter().filter(|r| r.mitsuba.count() > 0) {
        let [theirs, ours] = [&row.mitsuba, &row.beside_mitsuba].map(triple);
        text += &format!("| {} | {theirs} | {ours} | {} |\n", row.name, row.mitsuba.count());
    }
    text
}

/// Units over the condition number that a value may be off.
const LIMIT: f64 = 64.0;
/// What is within the limit whatever was not looked at.
const KNOWN: f64 = LIMIT / Tally::MORE;

/// What `--full` takes.
pub const FULL: Settings = Settings { single: 10_000_000, double: 100_000, sweep: true };

/// How the report is made, and what its figures mean.
fn introduction(settings: Settings) -> String {
    let Settings { single, double, .. } = settings;
    let (full, file) =
        if settings == FULL { (" --full", "stability") } else { ("", "stability-quick") };
    format!(
        "# Stability\n\nMade by `cargo run --release -p tests --bin stability --{full} --markdown \
         tests/reference/{file}.md --csv tests/reference/{file}.csv`: {single} random samples of each sampler in \
         f32 and {double} in f64.\n\n{MEANING}"
    )
}

const MEANING: &str = "\
Errors in units of 2⁻⁵² (f64) or 2⁻²³ (f32) of the value: the worst over its condition number (at least
one), and in brackets the worst and the median. Points: the extreme points of the reference data, uniforms
up to the last bit before an end with parameters over their declared domains, and random samples; in f32,
parameters and uniforms are rounded first. The condition number of `sample.pdf()` is that of `pdf(x)` or,
where that is larger, what half a unit in each uniform and parameter does to it. Zeros: own samples with
density zero. Infinite: densities that are not. Excused: zeros, infinities and lost samples that rounding an
ill-conditioned point explains. Not judged: points without a sample, or at which 31 digits do not tell the density. The textbook form is the density as it is usually written,
at the same points, but of the random ones at the first 1000 in f64 and 20000 in f32 alone.
Errors over condition numbers may be four percent more than stated; within the limit counts
what is so nevertheless. The limit is on samples and densities. Where a density leaves the range of numbers, its
logarithm is compared, and the density must be the zero or the infinity that it rounds to. Errors of inverses are
relative to the uniform: next to zero, or where rounding the point moves it far, all of its digits may be lost.
";
