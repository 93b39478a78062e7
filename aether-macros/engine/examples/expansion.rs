//! What the compiler of samplers does with a source file: time and size of each item's expansion.
//!
//! `cargo run -p aether-engine --example expansion FILE.rs…`; in the `dev` profile the compiler is
//! built as it is in a user's debug build.

use std::process::ExitCode;
use std::time::Instant;

use proc_macro2::TokenStream;
use quote::ToTokens;

fn main() -> ExitCode {
    let mut total = 0.0;
    for file in std::env::args().skip(1) {
        let parsed = match std::fs::read_to_string(&file).map(|text| syn::parse_file(&text)) {
            Ok(Ok(parsed)) => parsed,
            Ok(Err(e)) => {
                eprintln!("{file}: not Rust: {e}");
                return ExitCode::FAILURE;
            }
            Err(e) => {
                eprintln!("{file}: {e}; give the path of a Rust source file");
                return ExitCode::FAILURE;
            }
        };
        for item in parsed.items {
            if let syn::Item::Fn(function) = item {
                total += expand(function);
            }
        }
    }
    println!("{:>9.1} ms in all", 1e3 * total);
    ExitCode::SUCCESS
}

/// Expands one function and tells of it; the time in seconds, zero if it is no item of the language.
fn expand(mut function: syn::ItemFn) -> f64 {
    let names = ["sampler", "map"];
    let kind = |a: &syn::Attribute| names.iter().find(|n| a.path().is_ident(n)).copied();
    let Some((index, kind)) =
        function.attrs.iter().enumerate().find_map(|(i, a)| kind(a).map(|k| (i, k)))
    else {
        return 0.0;
    };
    let attribute = function.attrs.remove(index);
    let arguments = match attribute.meta {
        syn::Meta::List(list) => list.tokens,
        _ => TokenStream::new(),
    };
    let tokens = function.to_token_stream();
    let started = Instant::now();
    let output = match kind {
        "sampler" => aether_engine::sampler(arguments, tokens),
        _ => aether_engine::map(arguments, tokens),
    };
    let seconds = started.elapsed().as_secs_f64();
    let text = output.to_string();
    let refused = if text.contains("compile_error") { "  refused" } else { "" };
    println!(
        "{:>9.1} ms {:>8} characters  {}{refused}",
        1e3 * seconds,
        text.len(),
        function.sig.ident
    );
    for message in text.split("compile_error").skip(1) {
        println!("    {}", message.split('"').nth(1).unwrap_or_default().replace("\\n", "\n    "));
    }
    seconds
}
