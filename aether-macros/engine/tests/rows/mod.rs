//! The catalogue's samplers as the compiler sees them, one row of a table each: shared by the example
//! that writes the table and the test that compares it.

mod compare;
#[path = "../threads/mod.rs"]
mod threads;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::Instant;

use aether_engine::expr::{Graph, Id, Node, children};
use aether_engine::interpret::Item;
use proc_macro2::{TokenStream, TokenTree};
use quote::ToTokens;
use serde_json::Value;
use threads::on_all_threads;

/// Where the samplers are, from the root of the repository.
const SOURCES: [&str; 12] = [
    "tests/src/catalogue/easy.rs",
    "tests/src/catalogue/line.rs",
    "tests/src/catalogue/plane.rs",
    "tests/src/catalogue/direction.rs",
    "tests/src/catalogue/space.rs",
    "tests/src/catalogue/algebra.rs",
    "tests/src/catalogue/numeric.rs",
    "tests/src/catalogue/polygons.rs",
    "tests/tests/algebra.rs",
    "tests/optimised/tests/numeric.rs",
    "tests/tests/branches.rs",
    "tests/tests/joint.rs",
];

/// The root of the repository.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// What the compiler made of a sampler.
pub struct Row {
    number: u32,
    name: String,
    numerical: bool,
    pieces: usize,
    preimages: usize,
    /// How many entries were judged, of how many, and the worst error among them.
    judged: (usize, usize, f64),
    characters: usize,
    tokens: usize,
    milliseconds: f64,
}

/// Every sampler whose documentation begins with `Row` and a number, in the order of these.
pub fn rows() -> Vec<Row> {
    let reference = |name: &str| -> Vec<Value> {
        serde_json::from_str(&text(&format!("tests/reference/{name}.json"))).expect("JSON")
    };
    let references = [reference("catalogue-e"), reference("catalogue-mh")];
    let mut rows: Vec<Row> = on_all_threads(|next| {
        let mut rows = Vec::new();
        while let Some(source) = SOURCES.get(next.fetch_add(1, Ordering::Relaxed)) {
            rows.extend(rows_of(source, &references));
        }
        rows
    })
    .into_iter()
    .flatten()
    .collect();
    rows.sort_by(|a, b| (a.number, &a.name).cmp(&(b.number, &b.name)));
    rows
}

/// Those of one file.
fn rows_of(source: &str, [easy, hard]: &[Vec<Value>; 2]) -> Vec<Row> {
    let mut rows = Vec::new();
    for item in syn::parse_file(&text(source)).expect("a Rust file").items {
        let syn::Item::Fn(mut function) = item else { continue };
        let Some((number, attribute)) = numbered(&mut function) else { continue };
        let of_row = |e: &&Value| e["row"] == number;
        let name = function.sig.ident.to_string();
        let named = |e: &&Value| of_row(e) && e["name"] == name.as_str();
        let entries: Vec<&Value> =
            easy.iter().filter(of_row).chain(hard.iter().filter(named)).collect();
        rows.push(row(number, name.clone(), attribute, &function, &entries));
    }
    rows
}

fn text(path: &str) -> String {
    std::fs::read_to_string(root().join(path)).unwrap_or_else(|e| panic!("{path}: {e}"))
}

/// The number in the documentation of a sampler, and its attribute's arguments, which are taken off.
fn numbered(function: &mut syn::ItemFn) -> Option<(u32, TokenStream)> {
    let index = function.attrs.iter().position(|a| a.path().is_ident("sampler"))?;
    let number = function.attrs.iter().find_map(|a| {
        let syn::Meta::NameValue(doc) = &a.meta else { return None };
        let doc = doc.value.to_token_stream().to_string();
        let rest = doc.trim_matches('"').trim().strip_prefix("Row ")?.to_owned();
        rest.split(|c: char| !c.is_ascii_digit()).next()?.parse().ok()
    })?;
    let arguments = match function.attrs.remove(index).meta {
        syn::Meta::List(list) => list.tokens,
        _ => TokenStream::new(),
    };
    Some((number, arguments))
}

fn row(
    number: u32,
    name: String,
    attribute: TokenStream,
    function: &syn::ItemFn,
    entries: &[&Value],
) -> Row {
    let tokens = function.to_token_stream();
    let (started, worked) = (Instant::now(), processor_time());
    let emitted = aether_engine::sampler(attribute.clone(), tokens.clone());
    let worked = processor_time().zip(worked).map(|(after, before)| after - before);
    let milliseconds = worked.unwrap_or(1e3 * started.elapsed().as_secs_f64());
    let item = Item::new(attribute, tokens, true).unwrap_or_else(|why| panic!("{name}: {why}"));
    let errors: Vec<f64> = entries.iter().filter_map(|e| compare::worst_error(&item, e)).collect();
    let pieces = item.parsed.pieces.iter().zip(&item.derived);
    Row {
        number,
        name,
        numerical: pieces.clone().any(|(piece, derived)| {
            let values = derived.preimages.iter().flat_map(|p| &p.unknowns);
            let values = values.chain(&derived.forward);
            has_root(&piece.problem.graph, values.copied().collect())
        }),
        pieces: item.derived.len(),
        preimages: item.derived.iter().map(|d| d.preimages.len()).sum(),
        judged: (errors.len(), entries.len(), errors.iter().fold(0.0, |m, e| m.max(*e))),
        characters: emitted.to_string().len(),
        tokens: count(emitted),
        milliseconds,
    }
}

/// How many milliseconds this thread has kept a processor busy, where the system tells (Linux): other programs do not
/// matter then.
fn processor_time() -> Option<f64> {
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    Some(1e-6 * told.split_whitespace().next()?.parse::<f64>().ok()?)
}

/// Whether one of the expressions contains a root that is found numerically.
fn has_root(g: &Graph, mut open: Vec<Id>) -> bool {
    let mut seen = BTreeSet::new();
    while let Some(id) = open.pop() {
        if matches!(g.node(id), Node::Root(_)) {
            return true;
        }
        if seen.insert(id) {
            open.extend(children(g.node(id)));
        }
    }
    false
}

/// How many tokens, a pair of brackets counted as two.
fn count(stream: TokenStream) -> usize {
    stream
        .into_iter()
        .map(|tree| match tree {
            TokenTree::Group(group) => 2 + count(group.stream()),
            _ => 1,
        })
        .sum()
}

/// What stands above the table.
const ABOUT: &str = "\
# The catalogue as it is compiled

Generated by

    cargo run --release -p aether-engine --example table > tests/reference/rows.md

and compared by `cargo test -p aether-engine --test table`. With the argument `times` (after `--`) there is a
column with the processor's time for each expansion on your machine.

- `inverse`: in closed form; numerical where it, or the sample itself, is a root that is found numerically.
- `pieces`: ways through the branches of the body; `preimages`: those of all pieces, each with its own code.
- `worst`: the largest error of sample and density over the reference points, as a multiple of 1e-12 times the
  condition number (at least one). `points`: how many of the reference entries were judged here. What lies on a
  border, has a condition number above 1000 or parameters whose squares leave the range, needs the runtime:
  `cargo test -p tests --test catalogue`. Rows with 0 of 0 have their reference values in the test file that
  defines them.
- `characters`, `tokens`: size of the emitted code.

Each sampler is also compiled in at least seven other spellings (`cargo test -p aether-engine --test spellings`).
Rows that are composed (70, 71 and 85 in frames that plain code makes) are here by the items that they are composed of.
Rows 30, 31 and 55, densities that are constant or linear between the entries of tables, are no functions of the
uniforms alone: `aether_core::tables` has them, with tests of its own. Row 101, two points that are seen through a
portal, is here between planes parallel to the portal and between tilted ones.

";

/// The table as Markdown, with the times of this machine if `times`.
pub fn table(rows: &[Row], times: bool) -> String {
    let mut lines: Vec<String> = ABOUT.lines().map(str::to_owned).collect();
    let (title, rule) = if times { (" ms |", " ---: |") } else { ("", "") };
    lines.push(format!(
        "| row | sampler | inverse | pieces | preimages | worst | points | characters | tokens |{title}"
    ));
    lines.push(format!("| ---: | --- | --- | ---: | ---: | ---: | ---: | ---: | ---: |{rule}"));
    for r in rows {
        let (judged, all, worst) = r.judged;
        let worst = if judged == 0 { "-".to_owned() } else { format!("{worst:.0e}") };
        let inverse = if r.numerical { "numerical" } else { "closed form" };
        let time = if times { format!(" {:.1} |", r.milliseconds) } else { String::new() };
        lines.push(format!(
            "| {} | {} | {inverse} | {} | {} | {worst} | {judged} of {all} | {} | {} |{time}",
            r.number, r.name, r.pieces, r.preimages, r.characters, r.tokens
        ));
    }
    if times {
        let total: f64 = rows.iter().map(|r| r.milliseconds).sum();
        lines.push(format!("\n{total:.0} ms in all"));
    }
    lines.join("\n") + "\n"
}
