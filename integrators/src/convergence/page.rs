//! The report as a page that needs nothing but itself, and strips of pictures for papers.

use std::fmt::Write;

use super::chart::{chart, colour, escape};
use super::record::Curve;
use super::report::Measurements;
use super::summary::{SceneSummary, Summary};
use super::table::{cells, legend, remarks};

const STYLE: &str = "body{font:14px/1.45 sans-serif;max-width:960px;margin:2em auto;padding:0 1em}\
table{border-collapse:collapse}td,th{padding:.2em .7em;text-align:right;border-bottom:1px solid #ddd}\
td:first-child,th:first-child{text-align:left}svg{max-width:100%;height:auto}\
.pair{position:relative;display:inline-block;background:#222}.pair img{display:block;width:900px;max-width:100%;\
image-rendering:pixelated}.pair img+img{position:absolute;left:0;top:0}.slide{width:900px;max-width:100%}";

/// Shows the left picture up to where the slider stands, the right one beyond.
const SCRIPT: &str = "document.querySelectorAll('.compare').forEach(function(box){\
var images=box.querySelectorAll('.pair img'),choices=box.querySelectorAll('select'),\
slider=box.querySelector('input');function show(){for(var i=0;i<2;i++){\
images[i].src=document.getElementById(choices[i].value).textContent.trim();}\
images[1].style.clipPath='inset(0 0 0 '+slider.value+'%)';}\
choices.forEach(function(c){c.addEventListener('change',show)});slider.addEventListener('input',show);show();});";

/// The name of a scene in files.
pub fn file_name(scene: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || c == '-' { c } else { '-' };
    scene.chars().map(plain).collect()
}

/// The page: for each scene the chart, the table, and its pictures with a slider. Pictures are part of the file.
pub fn page(scenes: &[SceneSummary], measurements: &Measurements) -> String {
    let mut html = format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>Convergence</title>\
         <style>{STYLE}</style></head><body>\n<h1>Error against time</h1>\n<ul>\n"
    );
    for line in remarks(scenes, &measurements.notes).lines() {
        let _ = writeln!(html, "<li>{}</li>", escape(line.trim_start_matches("- ")));
    }
    html.push_str("</ul>\n");
    for scene in scenes {
        let _ = writeln!(html, "<h2>{}</h2>\n{}", escape(&scene.scene), chart(scene));
        rows(&mut html, scene);
        slider(&mut html, scene, measurements);
    }
    for paragraph in legend(scenes).split("\n\n") {
        let _ = writeln!(html, "<p>{}</p>", escape(paragraph.trim()));
    }
    let _ = writeln!(html, "<script>{SCRIPT}</script></body></html>");
    html
}

fn rows(html: &mut String, scene: &SceneSummary) {
    let heads = [
        "integrator",
        "samples",
        "seconds",
        "error",
        "time to target",
        "efficiency",
        "slope",
        "bias",
        "RMSE",
        "SMAPE",
        "FLIP",
        "variance of a sample",
    ];
    html.push_str("<table><tr>");
    heads.iter().for_each(|head| html.push_str(&format!("<th>{head}</th>")));
    html.push_str("</tr>\n");
    for (index, summary) in scene.curves.iter().enumerate() {
        let _ = write!(html, "<tr style=\"color:{}\">", colour(index));
        let others = summary.points.last().map_or([f64::NAN; 3], |point| point.others);
        let others = others.map(|value| format!("{value:.4}"));
        let estimate = summary.estimate.as_ref().filter(|estimate| !estimate.variance[0].is_nan());
        let variance = estimate.map_or("–".to_owned(), |estimate| {
            let [value, low, high] = estimate.variance;
            format!("{value:.3} ({low:.3} to {high:.3})")
        });
        for cell in cells(summary).iter().chain(&others).chain([&variance]) {
            let _ = write!(html, "<td>{}</td>", escape(cell));
        }
        html.push_str("</tr>\n");
    }
    html.push_str("</table>\n");
}

/// Two pictures one above the other, chosen by lists, with a slider between them.
fn slider(html: &mut String, scene: &SceneSummary, measurements: &Measurements) {
    let mut choices: Vec<(String, String)> = Vec::new();
    let mut offer = |name: String, label: String| {
        if let Some(bytes) = measurements.picture(&name) {
            let _ = writeln!(
                html,
                "<script type=\"text/plain\" id=\"{name}\">data:image/png;base64,{}</script>",
                base64(bytes)
            );
            choices.push((name, label));
        }
    };
    offer(reference_curve(scene).slug(), "reference".to_owned());
    for summary in &scene.curves {
        let (slug, label) = (summary.curve.slug(), summary.curve.label());
        offer(slug.clone(), label.clone());
        offer(format!("{slug}-error"), format!("{label}: error"));
    }
    if choices.len() < 2 {
        return;
    }
    let list = |chosen: usize| -> String {
        let option = |(index, (name, label)): (usize, &(String, String))| {
            let selected = if index == chosen { " selected" } else { "" };
            format!("<option value=\"{name}\"{selected}>{}</option>", escape(label))
        };
        choices.iter().enumerate().map(option).collect()
    };
    let _ = writeln!(
        html,
        "<div class=\"compare\"><p><select>{}</select> | <select>{}</select></p>\
         <input class=\"slide\" type=\"range\" min=\"0\" max=\"100\" value=\"50\">\
         <div class=\"pair\"><img alt=\"left\"><img alt=\"right\"></div></div>",
        list(0),
        list(1)
    );
}

/// The name under which pictures of a reference are kept.
pub fn reference_curve(scene: &SceneSummary) -> Curve {
    let scene = scene.scene.clone();
    Curve { scene, renderer: "reference".to_owned(), integrator: String::new() }
}

/// Crops of all integrators at about equal time, with their errors below, for a figure in a paper; `None`
/// without pictures.
pub fn strip(scene: &SceneSummary, measurements: &Measurements) -> Option<String> {
    const SIDE: f64 = 150.0;
    let reference = reference_curve(scene);
    let first = measurements.picture(&format!("{}-crop", reference.slug()))?;
    let (columns, rows) = png_size(first)?;
    let height = SIDE * rows / columns;
    let step = SIDE + 6.0;
    let mut body = String::new();
    let mut put = |column: usize, row: usize, bytes: &[u8]| {
        let (x, y) = (column as f64 * step, 20.0 + row as f64 * (height + 6.0));
        let _ = writeln!(
            body,
            "<image x=\"{x:.1}\" y=\"{y:.1}\" width=\"{SIDE}\" height=\"{height:.1}\" \
             style=\"image-rendering:pixelated\" href=\"data:image/png;base64,{}\"/>",
            base64(bytes)
        );
    };
    put(0, 0, first);
    let mut texts = vec![(0, "reference".to_owned(), String::new())];
    for (index, summary) in scene.curves.iter().enumerate() {
        let slug = summary.curve.slug();
        for (row, kind) in ["-crop", "-crop-error"].iter().enumerate() {
            if let Some(bytes) = measurements.picture(&format!("{slug}{kind}")) {
                put(index + 1, row, bytes);
            }
        }
        texts.push((index + 1, summary.curve.label(), effort(summary)));
    }
    let foot = 20.0 + 2.0 * height + 22.0;
    for (column, name, effort) in &texts {
        let x = *column as f64 * step + SIDE / 2.0;
        let _ = writeln!(
            body,
            "<text x=\"{x:.1}\" y=\"14\">{}</text><text x=\"{x:.1}\" y=\"{foot:.1}\">{}</text>",
            escape(name),
            escape(effort)
        );
    }
    let (width, height) = (texts.len() as f64 * step - 6.0, foot + 8.0);
    Some(format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.1} {height:.1}\" width=\"{width:.1}\" \
         height=\"{height:.1}\" font-family=\"sans-serif\" font-size=\"11\" text-anchor=\"middle\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n{body}</svg>\n"
    ))
}

fn effort(summary: &Summary) -> String {
    summary.points.last().map_or(String::new(), |point| {
        let error = point.quartiles[1].sqrt();
        format!("{} spp, {:.1} s, error {error:.3}", point.spp, point.seconds)
    })
}

/// Width and height of a PNG file, which its header tells.
fn png_size(bytes: &[u8]) -> Option<(f64, f64)> {
    let number = |at: usize| -> Option<f64> {
        let bytes = bytes.get(at..at + 4)?.try_into().ok()?;
        Some(f64::from(u32::from_be_bytes(bytes)))
    };
    Some((number(16)?, number(20)?))
}

/// Bytes as text (RFC 4648, section 4).
fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for part in bytes.chunks(3) {
        let byte = |k: usize| u32::from(part.get(k).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for k in 0..4 {
            let letter = LETTERS[(bits >> (18 - 6 * k)) as usize & 63];
            text.push(if k <= part.len() { char::from(letter) } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::base64;

    /// The test vectors of RFC 4648, section 10.
    #[test]
    fn bytes_as_text() {
        let vectors = [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("fooba", "Zm9vYmE="),
            ("foobar", "Zm9vYmFy"),
        ];
        for (bytes, text) in vectors {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
    }
}
