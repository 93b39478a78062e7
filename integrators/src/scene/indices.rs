//! Indices of refraction by the names that scene files use, in linear Rec. 709 as Mitsuba 3 resolves them
//! (`tests/reference/make_indices.py` writes the table).

use glam::DVec3;

const TABLE: &str = include_str!("indices.txt");

/// The index of refraction of a dielectric.
pub fn dielectric(name: &str) -> Result<f64, String> {
    let mut names = Vec::new();
    for line in TABLE.lines() {
        let Some((value, known)) =
            line.strip_prefix("dielectric ").and_then(|rest| rest.split_once(' '))
        else {
            continue;
        };
        if known == name {
            return value.parse().map_err(|_| format!("no index of refraction for {name}"));
        }
        names.push(known);
    }
    Err(format!(
        "\"{name}\" is no known material; there are {}, or give a number",
        names.join(", ")
    ))
}

/// Real and imaginary part of the index of refraction of a metal.
pub fn metal(name: &str) -> Result<(DVec3, DVec3), String> {
    let mut names = Vec::new();
    for line in TABLE.lines() {
        let mut words = line.split(' ');
        let (Some("metal"), Some(known)) = (words.next(), words.next()) else { continue };
        if known == name {
            let numbers: Vec<f64> = words.filter_map(|word| word.parse().ok()).collect();
            if let [a, b, c, d, e, f] = numbers[..] {
                return Ok((DVec3::new(a, b, c), DVec3::new(d, e, f)));
            }
        }
        names.push(known);
    }
    Err(format!("\"{name}\" is no known metal; there are none, {}", names.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_has_numbers() {
        for line in TABLE.lines() {
            if let Some((_, name)) =
                line.strip_prefix("dielectric ").and_then(|r| r.split_once(' '))
            {
                assert!(dielectric(name).is_ok_and(|eta| (1.0..=3.0).contains(&eta)), "{line}");
            } else {
                let name = line.split(' ').nth(1).unwrap_or("");
                let (eta, k) = metal(name).unwrap();
                assert!(eta.min_element() >= 0.0 && k.min_element() >= 0.0, "{line}");
            }
        }
        assert_eq!(dielectric("diamond"), Ok(2.419));
        assert!(dielectric("Au").unwrap_err().contains("water ice, fused quartz"));
        assert!(metal("gold").unwrap_err().contains("Au"));
    }
}
