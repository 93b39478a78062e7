//! The documentation of a strategy.

use quote::ToTokens;

use crate::strategy::tree::{Body, Form, Step};

/// What the density sums over, as Markdown.
pub fn documentation(body: &Body) -> String {
    let mut lines = Vec::new();
    let mut add = |line: String| {
        if !lines.contains(&line) {
            lines.push(line);
        }
    };
    let mut ends = 0;
    body.walk(
        &mut |step| {
            if let Step::Bind { pat, form } = step {
                add(describe(&source(pat), form));
            }
        },
        &mut |_| ends += 1,
    );
    body.delegates(&mut |strategy| {
        ends += 1;
        lines.push(format!("the vertex of `{}`", source(strategy)));
    });
    let lines: String = lines.iter().map(|line| format!("\n- {line}")).collect();
    let ways = if ends == 1 { "one way".to_owned() } else { format!("{ends} ways") };
    format!(
        "\n\n# Distribution\n\nDerived: the density sums over all outcomes of the discrete choices, \
         and {ways} to make the vertex.\n{lines}"
    )
}

fn describe(name: &str, form: &Form) -> String {
    match form {
        Form::Choose { distribution, rule: None } => {
            format!("choice `{name}` of `{}`, enumerated", source(distribution))
        }
        Form::Choose { distribution, rule: Some(_) } => {
            format!("choice `{name}` of `{}`, identified from the vertex", source(distribution))
        }
        Form::Draw(sampler) => format!("random variable `{name}` of `{}`", source(sampler)),
        Form::Constant(call) => {
            format!("locally constant `{name}` of `{}`, read from the vertex", source(call))
        }
        Form::Atom(atom) => format!("draws `{name}`, always the same: `{}`", source(atom)),
        Form::Given(value) => format!("given `{name}`, `{}`", source(value)),
    }
}

/// Tokens as they are usually written.
fn source(tokens: &impl ToTokens) -> String {
    const TIGHT: [(&str, &str); 9] = [
        (" . ", "."),
        (" (", "("),
        ("( ", "("),
        (" )", ")"),
        (" ,", ","),
        (" :: ", "::"),
        ("& ", "&"),
        (":: ", "::"),
        (" ::", "::"),
    ];
    let text = tokens.to_token_stream().to_string().replace(['\n', '`'], " ");
    TIGHT.iter().fold(text, |text, (loose, tight)| text.replace(loose, tight))
}
