//! Which techniques of a bidirectional algorithm are used.

use std::str::FromStr;

/// A choice of techniques by the number of vertices that come from the light, s, and from the camera, t.
///
/// As text, a list of pairs `s:t`, where `*` stands for any number: `0:*,1:*` is a path tracer with
/// next-event estimation, `*:1` a light tracer. The empty list stands for all.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Selection(Vec<(Option<usize>, Option<usize>)>);

impl Selection {
    /// Whether a technique is among them.
    pub fn has(&self, s: usize, t: usize) -> bool {
        let matches = |wanted: Option<usize>, count| wanted.is_none_or(|wanted| wanted == count);
        self.0.is_empty() || self.0.iter().any(|pair| matches(pair.0, s) && matches(pair.1, t))
    }
}

impl FromStr for Selection {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |text: &str| match text.trim() {
            "*" => Some(None),
            digits => digits.parse().ok().map(Some),
        };
        let pair = |text: &str| {
            let (s, t) = text.split_once(':')?;
            Some((number(s)?, number(t)?))
        };
        let pairs = text.split(',').map(|text| {
            pair(text).ok_or_else(|| {
                format!(
                    "`{text}` is no pair of numbers of vertices, from the light and from the camera: \
                     write `1:3`, or `1:*` for any number"
                )
            })
        });
        Ok(Selection(pairs.collect::<Result<_, _>>()?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_and_stars() {
        let some: Selection = "0:*, 2:1".parse().unwrap();
        assert!(some.has(0, 5) && some.has(2, 1) && !some.has(2, 2) && !some.has(1, 1));
        assert!(Selection::default().has(7, 9));
        assert!("2".parse::<Selection>().unwrap_err().contains("`2` is no pair"));
        assert!("a:1".parse::<Selection>().is_err());
    }
}
