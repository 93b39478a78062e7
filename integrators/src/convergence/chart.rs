//! Error over seconds and over samples as an SVG, both axes logarithmic.

use std::fmt::Write;

use super::summary::{Point, SceneSummary};

/// Colours of curves that can be told apart, also by most colour-blind people (Okabe and Ito 2008, and darker
/// ones of the same hues).
const COLOURS: [&str; 10] = [
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#004a73", "#8a3d00",
    "#00664a", "#7a4a66",
];
/// Size of a panel, and its margins left, top, right and bottom.
const PANEL: (f64, f64) = (330.0, 300.0);
const LEFT: f64 = 58.0;
const TOP: f64 = 34.0;
const GAP: f64 = 26.0;
const BELOW: f64 = 42.0;
const LEGEND: f64 = 170.0;

/// The colour of the curve with this number.
pub fn colour(index: usize) -> &'static str {
    COLOURS[index % COLOURS.len()]
}

/// One panel: places by logarithms.
struct Panel {
    left: f64,
    x: (f64, f64),
    y: (f64, f64),
}

impl Panel {
    fn across(&self, value: f64) -> f64 {
        self.left + PANEL.0 * (value.log10() - self.x.0) / (self.x.1 - self.x.0)
    }

    fn down(&self, value: f64) -> f64 {
        TOP + PANEL.1 * (self.y.1 - value.log10()) / (self.y.1 - self.y.0)
    }

    fn place(&self, x: f64, y: f64) -> String {
        format!("{:.1},{:.1}", self.across(x), self.down(y))
    }
}

/// The chart of a scene: for each curve the median of the seeds with a band from quartile to quartile, lines of slope
/// -1/2 as a guide, and the error of the reference.
pub fn chart(scene: &SceneSummary) -> String {
    let points = || scene.curves.iter().flat_map(|summary| &summary.points);
    let errors = || points().flat_map(|point| point.quartiles).map(f64::sqrt);
    let floor = scene.floor.map(f64::sqrt).filter(|floor| *floor > 0.0);
    let y = range(errors().chain(floor));
    let seconds = range(points().map(|point| point.seconds));
    let samples = range(points().map(|point| f64::from(point.spp)));
    let width = LEFT + 2.0 * PANEL.0 + GAP + LEGEND;
    let height = TOP + PANEL.1 + BELOW;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" \
         height=\"{height}\" font-family=\"sans-serif\" font-size=\"11\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n\
         <text x=\"{LEFT}\" y=\"18\" font-size=\"14\">{}: error (root of relMSE)</text>\n",
        escape(&scene.scene)
    );
    let by_seconds = |point: &Point| point.seconds;
    let by_samples = |point: &Point| f64::from(point.spp);
    let second = LEFT + PANEL.0 + GAP;
    panel(&mut svg, scene, &Panel { left: LEFT, x: seconds, y }, "seconds", &by_seconds);
    panel(
        &mut svg,
        scene,
        &Panel { left: second, x: samples, y },
        "samples per pixel",
        &by_samples,
    );
    legend(&mut svg, scene, second + PANEL.0 + 14.0);
    svg + "</svg>\n"
}

fn panel(
    svg: &mut String,
    scene: &SceneSummary,
    panel: &Panel,
    title: &str,
    x: &dyn Fn(&Point) -> f64,
) {
    let (left, right, bottom) = (panel.left, panel.left + PANEL.0, TOP + PANEL.1);
    let _ = writeln!(
        svg,
        "<clipPath id=\"c{left}\"><rect x=\"{left}\" y=\"{TOP}\" width=\"{}\" height=\"{}\"/></clipPath>\
         <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{title}</text>",
        PANEL.0,
        PANEL.1,
        (left + right) / 2.0,
        bottom + 34.0
    );
    axes(svg, panel);
    let _ = writeln!(svg, "<g clip-path=\"url(#c{left})\">");
    guides(svg, panel);
    if let Some(floor) = scene.floor.map(f64::sqrt).filter(|floor| *floor > 0.0) {
        let y = panel.down(floor);
        let _ = writeln!(
            svg,
            "<line x1=\"{left}\" x2=\"{right}\" y1=\"{y:.1}\" y2=\"{y:.1}\" stroke=\"black\" \
             stroke-dasharray=\"2 3\"/>"
        );
    }
    for (index, summary) in scene.curves.iter().enumerate() {
        curve(svg, panel, &summary.points, colour(index), x);
    }
    svg.push_str("</g>\n");
    let _ = writeln!(
        svg,
        "<rect x=\"{left}\" y=\"{TOP}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"black\"/>",
        PANEL.0, PANEL.1
    );
}

fn curve(
    svg: &mut String,
    panel: &Panel,
    points: &[Point],
    colour: &str,
    x: &dyn Fn(&Point) -> f64,
) {
    let place = |point: &Point, quartile: usize| {
        panel.place(x(point), point.quartiles[quartile].max(1e-300).sqrt())
    };
    let line = |quartile: usize| points.iter().map(move |point| place(point, quartile));
    let band: Vec<String> = line(0).chain(points.iter().rev().map(|p| place(p, 2))).collect();
    let median: Vec<String> = line(1).collect();
    let _ = writeln!(
        svg,
        "<polygon points=\"{}\" fill=\"{colour}\" fill-opacity=\"0.18\"/>\
         <polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.6\"/>",
        band.join(" "),
        median.join(" ")
    );
    for at in median {
        let (cx, cy) = at.split_once(',').unwrap_or(("0", "0"));
        let _ = write!(svg, "<circle cx=\"{cx}\" cy=\"{cy}\" r=\"2\" fill=\"{colour}\"/>");
    }
    svg.push('\n');
}

fn axes(svg: &mut String, panel: &Panel) {
    let (left, right, bottom) = (panel.left, panel.left + PANEL.0, TOP + PANEL.1);
    for (value, is_decade) in ticks(panel.x) {
        let (x, shade) = (panel.across(value), if is_decade { "#ccc" } else { "#eee" });
        let _ = writeln!(
            svg,
            "<line x1=\"{x:.1}\" x2=\"{x:.1}\" y1=\"{TOP}\" y2=\"{bottom}\" stroke=\"{shade}\"/>"
        );
        if is_decade {
            let _ = writeln!(
                svg,
                "<text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
                bottom + 16.0,
                number(value)
            );
        }
    }
    for (value, is_decade) in ticks(panel.y) {
        let (y, shade) = (panel.down(value), if is_decade { "#ccc" } else { "#eee" });
        let _ = writeln!(
            svg,
            "<line x1=\"{left}\" x2=\"{right}\" y1=\"{y:.1}\" y2=\"{y:.1}\" stroke=\"{shade}\"/>"
        );
        if is_decade && left == LEFT {
            let _ = writeln!(
                svg,
                "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                left - 6.0,
                y + 4.0,
                number(value)
            );
        }
    }
}

/// Lines along which the error falls as the inverse root, one a decade.
fn guides(svg: &mut String, panel: &Panel) {
    let reach = (panel.x.1 - panel.x.0) / 2.0;
    let first = panel.y.0.floor() as i32;
    for decade in first..=(panel.y.1 + reach).ceil() as i32 {
        let start = f64::from(decade);
        let from = panel.place(10f64.powf(panel.x.0), 10f64.powf(start));
        let to = panel.place(10f64.powf(panel.x.1), 10f64.powf(start - reach));
        let _ = writeln!(
            svg,
            "<polyline points=\"{from} {to}\" stroke=\"#999\" stroke-dasharray=\"6 4\" stroke-width=\"0.7\"/>"
        );
    }
}

fn legend(svg: &mut String, scene: &SceneSummary, left: f64) {
    let mut y = TOP + 10.0;
    let mut entry = |stroke: &str, text: &str| {
        let _ = writeln!(
            svg,
            "<line x1=\"{left}\" x2=\"{:.1}\" y1=\"{:.1}\" y2=\"{:.1}\" {stroke}/>\
             <text x=\"{:.1}\" y=\"{y:.1}\">{}</text>",
            left + 20.0,
            y - 4.0,
            y - 4.0,
            left + 26.0,
            escape(text)
        );
        y += 17.0;
    };
    for (index, summary) in scene.curves.iter().enumerate() {
        let stroke = format!("stroke=\"{}\" stroke-width=\"2\"", colour(index));
        entry(&stroke, &summary.curve.label());
    }
    entry("stroke=\"#999\" stroke-dasharray=\"6 4\"", "slope -1/2");
    if scene.floor.is_some() {
        entry("stroke=\"black\" stroke-dasharray=\"2 3\"", "error of reference");
    }
}

/// The range of the logarithms of positive values, with a margin.
fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let finite = values.filter(|v| *v > 0.0 && v.is_finite()).map(f64::log10);
    let (low, high) = finite.fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
    if low > high { (-1.0, 1.0) } else { (low - 0.08, high.max(low + 0.1) + 0.08) }
}

/// Values at whole multiples of powers of ten, and whether they get a label.
fn ticks((low, high): (f64, f64)) -> Vec<(f64, bool)> {
    let decades = low.floor() as i32..=high.ceil() as i32;
    let all = decades.flat_map(|d| (1..10).map(move |m| (f64::from(m) * 10f64.powi(d), m)));
    // With few decades, 2 and 5 are labelled too.
    let narrow = high - low < 1.5;
    let labelled = |m: i32| m == 1 || narrow && (m == 2 || m == 5);
    all.filter(|(v, _)| (low..=high).contains(&v.log10())).map(|(v, m)| (v, labelled(m))).collect()
}

fn number(value: f64) -> String {
    if (0.001..100_000.0).contains(&value) {
        let digits = (-value.log10().floor()).max(0.0) as usize;
        format!("{value:.digits$}")
    } else {
        format!("{value:.0e}")
    }
}

/// A text as it stands in SVG and HTML.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
