//! The samplers of the catalogue and of the tests in other spellings, produced mechanically: whatever
//! compiles as it is written must compile in every spelling, with the same images, densities and
//! preimages up to what the spelling changed.

#[path = "spellings/bindings.rs"]
mod bindings;
#[path = "spellings/compare.rs"]
mod compare;
#[path = "spellings/operands.rs"]
mod operands;
#[path = "spellings/results.rs"]
mod results;
#[path = "spellings/samplers.rs"]
mod samplers;
mod threads;

use std::path::Path;
use std::sync::atomic::Ordering;

use aether_engine::interpret::Item;
use aether_engine::parse::Signature;
use quote::ToTokens;
use samplers::{Affine, Sampler, Spelling, samplers};
use threads::on_all_threads;

const FILES: [&str; 12] = [
    "src/catalogue/easy.rs",
    "src/catalogue/line.rs",
    "src/catalogue/plane.rs",
    "src/catalogue/direction.rs",
    "src/catalogue/space.rs",
    "src/catalogue/algebra.rs",
    "src/catalogue/numeric.rs",
    "src/catalogue/polygons.rs",
    "tests/algebra.rs",
    "optimised/tests/numeric.rs",
    "tests/branches.rs",
    "tests/joint.rs",
];

/// The spellings of a sampler.
fn spellings(function: &syn::ItemFn, signature: &Signature) -> Vec<Spelling> {
    let space = &signature.space;
    let same = |name, function| Spelling {
        name,
        function,
        uniforms: |_| {},
        image: Affine::identity(space),
    };
    let moved = |name, made: Option<_>| {
        made.map(|(function, image)| Spelling { name, function, uniforms: |_| {}, image })
    };
    let f = || function.clone();
    let mirror: fn(&mut Vec<f64>) = |u| u.iter_mut().for_each(|u| *u = 1.0 - *u);
    let exchange: fn(&mut Vec<f64>) = |u| u.reverse();
    let mut all = vec![
        Spelling { uniforms: mirror, ..same("mirrored", operands::mirrored(f(), signature)) },
        same("reordered", operands::reordered(f(), signature)),
        same("renamed", operands::renamed(f())),
        same("inlined", bindings::inlined(f())),
        same("named", bindings::named(f())),
    ];
    let other = operands::mirrored(operands::reordered(f(), signature), signature);
    let other = bindings::named(operands::renamed(bindings::inlined(other)));
    all.push(Spelling { uniforms: mirror, ..same("all of these", other) });
    let both = operands::renamed(operands::mirrored(f(), signature));
    let scaled = moved("mirrored and scaled", results::scaled(both.clone(), space));
    let permuted = moved("mirrored and permuted", results::permuted(both, space));
    let twice = scaled.into_iter().chain(permuted);
    all.extend(twice.map(|s| Spelling { uniforms: mirror, ..s }));
    all.extend(moved("scaled", results::scaled(f(), space)));
    all.extend(moved("permuted", results::permuted(f(), space)));
    let exchanged = operands::exchanged(f(), signature);
    let text = |function: &syn::ItemFn| function.to_token_stream().to_string();
    if text(&exchanged) != text(function) {
        all.push(Spelling { uniforms: exchange, ..same("exchanged", exchanged) });
    }
    all
}

/// A spelling that failed: sampler, spelling, what went wrong.
type Failure = (String, &'static str, String);

/// Judges the spellings of a sampler that `asked` asks for by their numbers.
fn judge(sampler: &Sampler, asked: impl Fn(usize) -> bool) -> (usize, Vec<Failure>) {
    let compile = |tokens| Item::new(sampler.attribute.clone(), tokens, true);
    let plain = compile(sampler.function.to_token_stream())
        .unwrap_or_else(|why| panic!("{} does not compile as it is: {why}", sampler.name));
    let all = spellings(&sampler.function, &plain.parsed.signature);
    assert!(all.len() >= 4, "{} has {} spellings only", sampler.name, all.len());
    let failure = |spelling: &Spelling| {
        let what = match compile(spelling.tokens()) {
            Ok(other) => compare::difference(&plain, &other, spelling)?,
            Err(why) => format!("refused: {why}"),
        };
        Some((sampler.name.clone(), spelling.name, what))
    };
    let stray = compare::stray(&plain).map(|what| (sampler.name.clone(), "as it is", what));
    let all: Vec<&Spelling> =
        all.iter().enumerate().filter(|(k, _)| asked(*k)).map(|(_, s)| s).collect();
    (all.len(), all.into_iter().filter_map(failure).chain(stray).collect())
}

/// Each sampler in each second spelling, and the next one in the others.
#[test]
fn spellings_of_every_sampler_are_the_same() {
    compare_spellings(|sampler, spelling| (sampler + spelling).is_multiple_of(2));
}

#[test]
#[ignore = "the other half as well takes twice as long"]
fn every_spelling_of_every_sampler_is_the_same() {
    compare_spellings(|_, _| true);
}

/// Compares the spellings that `asked` asks for by the numbers of sampler and spelling.
fn compare_spellings(asked: impl Fn(usize, usize) -> bool + Sync) {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests");
    let all: Vec<Sampler> = FILES.iter().flat_map(|f| samplers(&tests.join(f))).collect();
    assert!(all.len() >= 100, "{} samplers only", all.len());
    let results = on_all_threads(|next| {
        // Tokens do not cross threads, so each reads the files.
        let all: Vec<Sampler> = FILES.iter().flat_map(|f| samplers(&tests.join(f))).collect();
        let (mut count, mut failures) = (0, Vec::new());
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            let Some(sampler) = all.get(number) else { break };
            let (spellings, failed) = judge(sampler, |spelling| asked(number, spelling));
            count += spellings;
            failures.extend(failed);
        }
        (count, failures)
    });
    let count: usize = results.iter().map(|(count, _)| count).sum();
    let mut failures: Vec<Failure> = results.into_iter().flat_map(|(_, failed)| failed).collect();
    failures.sort();
    println!("{} samplers, {count} spellings, {} failures", all.len(), failures.len());
    let wrong: Vec<String> = failures.iter().map(|f| format!("{} {}: {}", f.0, f.1, f.2)).collect();
    assert!(wrong.is_empty(), "{} differences:\n{}", wrong.len(), wrong.join("\n"));
}

/// The comparison sees a density that is off by one percent, and uniforms that are not those meant.
#[test]
fn what_is_not_the_same_is_noticed() {
    let function: syn::ItemFn =
        syn::parse_quote! { fn cube(u: [Uniform; 1]) -> f64 { u[0].powi(3) } };
    let item = Item::new(Default::default(), function.to_token_stream(), true).expect("a sampler");
    let same = || Spelling {
        name: "plain",
        function: function.clone(),
        uniforms: |_| {},
        image: Affine::identity(&item.parsed.signature.space),
    };
    assert_eq!(compare::difference(&item, &item, &same()), None);
    let image = Affine { stretch: 1.01, ..same().image };
    assert!(compare::difference(&item, &item, &Spelling { image, ..same() }).is_some());
    let uniforms: fn(&mut Vec<f64>) = |u| u[0] = 1.0 - u[0];
    assert!(compare::difference(&item, &item, &Spelling { uniforms, ..same() }).is_some());
}
