//! Named parameters: `-D name=value`, `<default>`, and `$name` in attribute values.

/// The parameters known so far. What the command line defines is never overwritten.
#[derive(Debug, Default)]
pub struct Parameters {
    list: Vec<Parameter>,
    /// How many names were replaced, and how many bytes put in their places.
    replaced: usize,
    inserted: usize,
}

/// Limits on what a file may ask for: parameters made of parameters grow exponentially.
const MOST_PARAMETERS: usize = 4096;
const MOST_REPLACED: usize = 1 << 17;
const MOST_INSERTED: usize = 1 << 24;

#[derive(Debug)]
struct Parameter {
    name: String,
    value: String,
    used: bool,
    /// Whether it comes from outside the file, and whether something else than a number of samples is made of it.
    outside: bool,
    matters: bool,
}

impl Parameters {
    /// Parameters from outside the file; the last definition of a name wins.
    pub fn new(defines: &[(String, String)]) -> Self {
        let mut list: Vec<Parameter> = Vec::new();
        for (name, value) in defines {
            list.retain(|p| p.name != *name);
            let (name, value) = (name.clone(), value.clone());
            list.push(Parameter { name, value, used: false, outside: true, matters: false });
        }
        Self { list, ..Self::default() }
    }

    /// A `<default>`: takes effect if nothing defined the name before.
    pub fn set_default(&mut self, name: &str, value: &str) -> Result<(), String> {
        if name.is_empty() {
            return Err("a parameter needs a name".to_owned());
        }
        if let Some(known) = self.list.iter_mut().find(|p| p.name == name) {
            known.used = true;
            return Ok(());
        }
        if self.list.len() >= MOST_PARAMETERS {
            return Err(format!("more than {MOST_PARAMETERS} parameters"));
        }
        let (name, value) = (name.to_owned(), value.to_owned());
        self.list.push(Parameter { name, value, used: true, outside: false, matters: false });
        Ok(())
    }

    /// Replaces each `$name` by its value; of several names that fit the longest wins, as in
    /// Mitsuba. What is inserted is not searched again. `counts_samples` if the text says how many samples there are, and
    /// nothing else.
    pub fn substitute(&mut self, text: &str, counts_samples: bool) -> Result<String, String> {
        let mut result = String::with_capacity(text.len());
        let mut rest = text;
        while let Some(dollar) = rest.find('$') {
            result.push_str(&rest[..dollar]);
            rest = &rest[dollar + 1..];
            let fits = self.list.iter_mut().filter(|p| rest.starts_with(&p.name));
            let Some(parameter) = fits.max_by_key(|p| p.name.len()) else {
                let end =
                    rest.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(rest.len());
                return Err(format!(
                    "undefined parameter ${0}; add <default name=\"{0}\" value=\"…\"/> before \
                     its use, or pass -D {0}=…",
                    &rest[..end]
                ));
            };
            parameter.used = true;
            parameter.matters |= !counts_samples;
            self.replaced += 1;
            self.inserted += parameter.value.len();
            if self.replaced > MOST_REPLACED || self.inserted > MOST_INSERTED {
                return Err(format!(
                    "parameters are used more than {MOST_REPLACED} times, or add up to more than \
                     {MOST_INSERTED} bytes"
                ));
            }
            result.push_str(&parameter.value);
            rest = &rest[parameter.name.len()..];
        }
        result.push_str(rest);
        Ok(result)
    }

    /// The parameters from outside that say nothing but how many samples there are.
    pub fn counting_samples(&self) -> Vec<String> {
        let counting = self.list.iter().filter(|p| p.outside && !p.matters);
        counting.map(|p| p.name.clone()).collect()
    }

    /// A parameter that was defined from outside but that no file mentions.
    pub fn unused(&self) -> Option<&str> {
        let unused = self.list.iter().find(|p| !p.used);
        unused.map(|p| p.name.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_name_wins_and_defines_beat_defaults() {
        let mut p = Parameters::new(&[("spp".into(), "4".into()), ("x".into(), "$spp".into())]);
        p.set_default("spp", "64").unwrap();
        p.set_default("spp_max", "128").unwrap();
        assert_eq!(p.substitute("a $spp_max,$spp.", false), Ok("a 128,4.".to_owned()));
        assert_eq!(p.unused(), Some("x"));
        assert_eq!(p.substitute("$x", false), Ok("$spp".to_owned()));
        assert_eq!(p.unused(), None);
        assert!(p.substitute("$nope/a", false).unwrap_err().contains("$nope;"));
    }
}
