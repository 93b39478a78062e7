//! Which techniques of an algorithm are used.

use std::fmt;
use std::ops::RangeInclusive;
use std::str::FromStr;

use crate::render::Technique;

/// A choice of techniques, by what joins the pieces of a path from the camera and from the light and by the numbers
/// of their vertices. Those that are left out take no samples and no part in weights: what is left is an
/// algorithm of its own, which has the light of all paths that one of its techniques can make.
///
/// As text, a list of names such as `1:3`: one vertex from the light, three from the camera. `*` stands for any
/// number, `2..` for two or more: `0:*,1:*` is a path tracer with next-event estimation, `*:1` a light
/// tracer. What joins the pieces comes first, as in names of layers: `portal-1:2`, or `portal` for all of
/// these. The empty list stands for all.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Selection {
    patterns: &'static [Pattern],
    /// The same for edges between few vertices, which samples ask for all the time: bit S of number T stands for `S:T`.
    edges: &'static [u64; FEW],
}

/// How many vertices are few.
const FEW: usize = u64::BITS as usize;

/// Techniques that are named together.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Pattern {
    joint: &'static str,
    /// The fewest and the most vertices from the light, and from the camera.
    light: (usize, usize),
    camera: (usize, usize),
}

/// Any number.
const ANY: (usize, usize) = (0, usize::MAX);

impl Selection {
    /// All techniques.
    pub const ALL: Selection = Selection { patterns: &[], edges: &[u64::MAX; FEW] };

    /// Whether none is left out.
    #[inline]
    pub fn is_all(&self) -> bool {
        self.patterns.is_empty()
    }

    /// Whether all connect light paths to the eye, as a light tracer does.
    pub fn is_light_tracing(&self) -> bool {
        let is_edge_to_eye = |p: &Pattern| p.joint.is_empty() && p.camera == (1, 1);
        !self.is_all() && self.patterns.iter().all(is_edge_to_eye)
    }

    /// Those of a list that lives as long as the program, as settings do.
    fn listed(patterns: Vec<Pattern>) -> Self {
        let mut edges = [0; FEW];
        for (camera, lights) in edges.iter_mut().enumerate() {
            let has = |light: &usize| patterns.iter().any(|it| it.has("", camera, *light));
            *lights = (0..FEW).filter(has).fold(0, |lights, light| lights | 1 << light);
        }
        Selection { patterns: patterns.leak(), edges: Box::leak(Box::new(edges)) }
    }

    /// Whether a technique is among them.
    #[inline]
    pub fn has(&self, technique: Technique) -> bool {
        let Technique { joint, camera, light, .. } = technique;
        if joint.is_empty() && camera < FEW && light < FEW {
            return self.edges[camera] >> light & 1 == 1;
        }
        self.is_all() || self.lists(joint, camera, light)
    }

    /// Whether a technique is listed. It is not taken as a value, which would have to lie in memory whether this is called
    /// or not.
    #[cold]
    fn lists(&self, joint: &str, camera: usize, light: usize) -> bool {
        self.patterns.iter().any(|pattern| pattern.has(joint, camera, light))
    }

    /// Those of some techniques that are among them.
    pub fn among<'t>(
        &'t self,
        techniques: impl Iterator<Item = Technique> + Clone + 't,
    ) -> impl Iterator<Item = Technique> + Clone + 't {
        techniques.filter(|technique| self.has(*technique))
    }

    /// Whether each name stands for a technique of an algorithm that has those of `own`, for paths with some number of
    /// vertices.
    ///
    /// # Errors
    /// The first name that stands for none, and what there is instead.
    pub fn check(&self, own: &str, vertices: RangeInclusive<usize>) -> Result<(), String> {
        let own: Vec<Pattern> = patterns(own)?;
        for pattern in self.patterns {
            let found = own.iter().filter_map(|own| own.common(pattern));
            let lengths: Vec<_> = found.map(|common| common.vertices()).collect();
            if lengths.is_empty() {
                return Err(format!(
                    "there is no technique `{pattern}`, but `{}`: S:T has S vertices from the light and T from the camera",
                    list(&own)
                ));
            }
            let (shortest, longest) = (vertices.start(), vertices.end());
            if lengths.iter().all(|(fewest, most)| fewest > longest || most < shortest) {
                return Err(format!(
                    "`{pattern}` makes no path of {shortest} to {longest} vertices, and there are no others with \
                     this maximum depth; name other techniques, or change `--max-depth`"
                ));
            }
        }
        Ok(())
    }
}

impl Pattern {
    fn has(&self, joint: &str, camera: usize, light: usize) -> bool {
        let within = |count: usize, (fewest, most)| (fewest..=most).contains(&count);
        self.joint == joint && within(light, self.light) && within(camera, self.camera)
    }

    /// The techniques that two patterns have in common, if there are any.
    fn common(&self, other: &Pattern) -> Option<Pattern> {
        let both = |a: (usize, usize), b: (usize, usize)| (a.0.max(b.0), a.1.min(b.1));
        let light = both(self.light, other.light);
        let camera = both(self.camera, other.camera);
        let exists = self.joint == other.joint && light.0 <= light.1 && camera.0 <= camera.1;
        exists.then_some(Pattern { joint: self.joint, light, camera })
    }

    /// The fewest and the most vertices of their paths.
    fn vertices(&self) -> (usize, usize) {
        let of = |camera, light| match self.joint {
            Technique::MERGE => Technique::merge(camera, light),
            Technique::PORTAL => Technique::portal(camera, light),
            _ => Technique::edge(camera, light),
        };
        // Far beyond all paths, and sums of these are numbers still.
        let most = |count: usize| count.min(usize::MAX / 4);
        (
            of(self.camera.0, self.light.0).vertices,
            of(most(self.camera.1), most(self.light.1)).vertices,
        )
    }
}

impl fmt::Display for Pattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let number = |(fewest, most): (usize, usize)| match most {
            usize::MAX if fewest == 0 => "*".to_owned(),
            usize::MAX => format!("{fewest}.."),
            _ => fewest.to_string(),
        };
        let dash = if self.joint.is_empty() { "" } else { "-" };
        write!(f, "{}{dash}{}:{}", self.joint, number(self.light), number(self.camera))
    }
}

impl fmt::Display for Selection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = list(self.patterns);
        write!(f, "{}", if names.is_empty() { "all" } else { &names })
    }
}

impl Default for Selection {
    fn default() -> Self {
        Selection::ALL
    }
}

impl fmt::Debug for Selection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Selection({self})")
    }
}

impl FromStr for Pattern {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |text: &str| match (text.trim(), text.trim().strip_suffix("..")) {
            ("*", _) => Some(ANY),
            (_, Some(digits)) => digits.parse().ok().map(|fewest| (fewest, usize::MAX)),
            (digits, None) => digits.parse().ok().map(|count| (count, count)),
        };
        let pair = |text: &str| {
            let (light, camera) = text.split_once(':')?;
            Some((number(light)?, number(camera)?))
        };
        let text = text.trim();
        let is_name = |text: &str| text.starts_with(|c: char| c.is_ascii_alphabetic());
        let (joint, counts) = match text.split_once('-') {
            Some((joint, counts)) if is_name(joint) => (joint, pair(counts)),
            None if is_name(text) && !text.contains(':') => (text, Some((ANY, ANY))),
            _ => ("", pair(text)),
        };
        let (light, camera) = counts.ok_or_else(|| {
            format!(
                "`{text}` is no technique: write the numbers of vertices from the light and from the camera, \
                 such as `1:3`, `1:*` for any number, `portal-1:3` or `merge`"
            )
        })?;
        Ok(Pattern { joint: Technique::joint_called(joint), light, camera })
    }
}

impl FromStr for Selection {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        patterns(text).map(Selection::listed)
    }
}

/// Patterns with commas between them.
fn list(patterns: &[Pattern]) -> String {
    patterns.iter().map(Pattern::to_string).collect::<Vec<_>>().join(",")
}

/// Reads patterns with commas between them.
fn patterns(text: &str) -> Result<Vec<Pattern>, String> {
    text.split(',').map(Pattern::from_str).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn selection(text: &str) -> Selection {
        text.parse().unwrap()
    }

    #[test]
    fn numbers_and_names() {
        let edge = |s, t| Technique::edge(t, s);
        let some = selection("0:*, 2:1,merge,portal-1:2..");
        assert!(some.has(edge(0, 5)) && some.has(edge(2, 1)));
        assert!(!some.has(edge(2, 2)) && !some.has(edge(1, 1)));
        assert!(some.has(edge(0, 100)) && !some.has(edge(1, 100)) && !some.has(edge(64, 1)));
        assert!(some.has(Technique::merge(3, 4)));
        assert!(some.has(Technique::portal(2, 1)) && !some.has(Technique::portal(1, 1)));
        assert!(Selection::ALL.has(edge(7, 9)) && Selection::ALL.has(edge(99, 99)));
        assert!(Selection::ALL.has(Technique::portal(1, 1)));
        assert_eq!(some.to_string(), "0:*,2:1,merge-*:*,portal-1:2..");
    }

    #[test]
    fn what_is_no_technique_is_refused() {
        for text in ["2", "a:1", "1:-3", "", "0:*,", "merge-2", "1..3:2"] {
            let error = text.parse::<Selection>().unwrap_err();
            assert!(error.contains("is no technique"), "{text}: {error}");
        }
    }

    #[test]
    fn a_selection_that_leaves_nothing_is_refused() {
        let own = "0:2..,1:2..,merge-2..:2..";
        for (text, says) in [
            ("1:3", Ok(())),
            ("*:*", Ok(())),
            ("merge", Ok(())),
            ("0:*,merge-3:2", Ok(())),
            ("2:*", Err("no technique `2:*`, but `0:2..,1:2..,merge-2..:2..`")),
            ("0:*,portal", Err("no technique `portal-*:*`")),
            ("merge-1:4", Err("no technique `merge-1:4`")),
            ("1:5", Err("`1:5` makes no path of 3 to 5 vertices")),
            ("merge-3:4", Err("`merge-3:4` makes no path")),
            ("0:2", Err("`0:2` makes no path")),
        ] {
            let found = selection(text).check(own, 3..=5);
            match says {
                Ok(()) => assert_eq!(found, Ok(()), "{text}"),
                Err(says) => assert!(found.as_ref().unwrap_err().contains(says), "{found:?}"),
            }
        }
    }
}
