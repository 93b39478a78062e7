//! Emitted code as text with line breaks, for people to read.

use proc_macro2::{Delimiter, Spacing, TokenStream, TokenTree};

/// The code, a line for each statement, item, field and attribute.
pub fn source(tokens: &TokenStream) -> String {
    let mut text = Text { out: String::new(), depth: 0 };
    text.stream(tokens.clone(), true);
    let lines = text.out.lines().map(str::trim_end).filter(|line| !line.is_empty());
    lines.map(|line| format!("{line}\n")).collect()
}

struct Text {
    out: String,
    depth: usize,
}

impl Text {
    fn line(&mut self) {
        self.out.push('\n');
        self.out.push_str(&"    ".repeat(self.depth));
    }

    /// Tokens; in a block, commas end lines too.
    fn stream(&mut self, tokens: TokenStream, block: bool) {
        let mut tokens = tokens.into_iter().peekable();
        let mut attribute = false;
        // Whether the last token was the first colon of two.
        let mut colon = false;
        while let Some(token) = tokens.next() {
            match &token {
                TokenTree::Group(group) => {
                    self.group(group.delimiter(), group.stream());
                    let continues = |t: &TokenTree| match t {
                        TokenTree::Punct(p) => matches!(p.as_char(), ',' | ';' | '.' | '?' | ')'),
                        TokenTree::Ident(i) => i == "else",
                        _ => false,
                    };
                    let ends = group.delimiter() == Delimiter::Brace && block
                        || attribute && group.delimiter() == Delimiter::Bracket;
                    if ends && !tokens.peek().is_some_and(continues) {
                        self.line();
                    } else if tokens.peek().is_some_and(spaced_after_group) {
                        self.out.push(' ');
                    }
                    attribute = false;
                    continue;
                }
                TokenTree::Punct(p) => {
                    self.out.push(p.as_char());
                    let separator = std::mem::replace(
                        &mut colon,
                        p.as_char() == ':' && p.spacing() == Spacing::Joint,
                    );
                    if separator && p.as_char() == ':' {
                        continue;
                    }
                    attribute = p.as_char() == '#' || attribute && p.as_char() == '!';
                    if p.as_char() == ';' && block || p.as_char() == ',' && block && self.depth > 0
                    {
                        self.line();
                        continue;
                    }
                    if attribute || p.spacing() == Spacing::Joint {
                        continue;
                    }
                }
                other => self.out.push_str(&other.to_string()),
            }
            if tokens.peek().is_some_and(|next| spaced(&token, next)) {
                self.out.push(' ');
            }
        }
    }

    fn group(&mut self, delimiter: Delimiter, tokens: TokenStream) {
        let (open, close) = match delimiter {
            Delimiter::Brace if tokens.is_empty() => ("{", "}"),
            Delimiter::Brace => {
                self.out.push('{');
                self.depth += 1;
                self.line();
                self.stream(tokens, true);
                self.depth -= 1;
                self.line();
                self.out.push('}');
                return;
            }
            Delimiter::Parenthesis => ("(", ")"),
            Delimiter::Bracket => ("[", "]"),
            Delimiter::None => ("", ""),
        };
        self.out.push_str(open);
        self.stream(tokens, false);
        self.out.push_str(close);
    }
}

/// Whether a space looks right between two tokens.
fn spaced(token: &TokenTree, next: &TokenTree) -> bool {
    let tight_before = |c: char| matches!(c, ',' | ';' | '.' | '?' | ':');
    let tight_after = |c: char| matches!(c, '.' | '&' | '!');
    match (token, next) {
        (_, TokenTree::Punct(n)) if n.as_char() == ':' && n.spacing() == Spacing::Joint => {
            begins_path(token)
        }
        (TokenTree::Punct(p), _) if tight_after(p.as_char()) => false,
        (_, TokenTree::Punct(p)) => !tight_before(p.as_char()),
        (TokenTree::Ident(_), TokenTree::Group(g)) => g.delimiter() == Delimiter::Brace,
        _ => true,
    }
}

/// Whether two colons after this token are the first of a path, `= ::core::fmt`.
fn begins_path(before: &TokenTree) -> bool {
    match before {
        TokenTree::Ident(i) => {
            let keywords = ["use", "impl", "for", "in", "as", "return", "dyn", "mut", "where"];
            keywords.iter().any(|word| i == word)
        }
        TokenTree::Punct(p) => !matches!(p.as_char(), '<' | '&' | '!'),
        _ => false,
    }
}

/// Whether a space follows a group before this token.
fn spaced_after_group(next: &TokenTree) -> bool {
    match next {
        TokenTree::Punct(p) => !matches!(p.as_char(), ',' | ';' | '.' | '?'),
        TokenTree::Group(g) => g.delimiter() == Delimiter::Brace,
        _ => true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quote::quote;

    #[test]
    fn statements_have_lines_of_their_own_and_nothing_is_lost() {
        let tokens = quote! {
            #[doc = "A; b { c }"]
            pub struct Flight<R: ::core::Real = f64> { s: R, d: R }
            impl<R> Flight<R> {
                fn half(&self) -> R { use ::core::fmt::Debug as _; let a = self.s / (2.0 * self.d); if a <= -1.0 { return a; } else { a.abs() } }
            }
        };
        let text = source(&tokens);
        let again: TokenStream = text.parse().expect("the text is Rust");
        assert_eq!(again.to_string(), tokens.to_string());
        let lines: Vec<&str> = text.lines().map(str::trim).collect();
        for line in [
            r#"#[doc = "A; b { c }"]"#,
            "s: R,",
            "let a = self.s / (2.0 * self.d);",
            "use ::core::fmt::Debug as _;",
            "return a;",
        ] {
            assert!(lines.contains(&line), "{line}\nis no line of\n{text}");
        }
        assert!(text.lines().all(|line| line.len() < 60), "{text}");
    }
}
