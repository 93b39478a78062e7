//! Files with every mistake that we could think of: each is an error that says where and what, in bounded
//! time and memory, and never a panic.

use std::io::Write;
use std::path::{Path, PathBuf};

use super::Scene;

const SENSOR: &str = "<sensor type=\"perspective\"/>";

/// A folder for the files of one test, removed when it ends.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("aether-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Folder(path)
    }

    fn write(&self, name: &str, bytes: &[u8]) {
        std::fs::write(self.0.join(name), bytes).unwrap();
    }

    /// The error of a scene.
    fn error(&self, xml: &str) -> String {
        let start: String = xml.chars().take(200).collect();
        match Scene::from_str(xml, &self.0, &[]) {
            Ok(_) => format!("is loaded: {start}"),
            Err(error) => {
                let file = error.file.file_name().map(|name| name.to_string_lossy().into_owned());
                let at = |n: Option<u32>| n.map_or(String::new(), |n| format!(":{n}"));
                let element = error.element.map_or(String::new(), |e| format!(" {e}"));
                let file = file.unwrap_or_default();
                format!("{file}{}{}{element}: {}", at(error.line), at(error.column), error.message)
            }
        }
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Each body is line 2 of a scene with a camera. What the error must begin with (file, line and, where the
/// mistake is not in the body's first element, column), and what it must say.
fn check(folder: &Folder, rows: &[(&str, &str, &str)]) {
    let mut complaints = Vec::new();
    for (body, place, message) in rows {
        let xml = format!("<scene version=\"3.0.0\">{SENSOR}\n{body}</scene>");
        let error = folder.error(&xml);
        if !error.starts_with(place) || !error.contains(message) || error.len() > 1000 {
            let [begin, error] =
                [*body, &error].map(|text| text.chars().take(300).collect::<String>());
            complaints.push(format!("{begin}\n  {error}\n  not: {place} … {message}"));
        }
    }
    println!("{} files", rows.len());
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

#[test]
fn broken_xml() {
    let folder = Folder::new("broken-xml");
    let bomb = "<!DOCTYPE s [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b \"&a;&a;&a;&a;&a;&a;&a;&a;\">\
                <!ENTITY c \"&b;&b;&b;&b;&b;&b;&b;&b;\">]><scene version=\"3.0.0\">&c;</scene>";
    let external = "<!DOCTYPE s [<!ENTITY x SYSTEM \"file:///etc/passwd\">]>\
                    <scene version=\"3.0.0\"><string name=\"a\" value=\"&x;\"/></scene>";
    let deep = format!("{}{}", "<a>".repeat(100_000), "</a>".repeat(100_000));
    let deep = format!("<scene version=\"3.0.0\">{deep}</scene>");
    for (xml, place, message) in [
        ("", "scene.xml:1:1", "not well-formed"),
        ("   \n", "scene.xml:", "not well-formed"),
        ("<scene", "scene.xml:1:", "not well-formed"),
        ("<scene version=\"3.0.0\">\n", "scene.xml:", "not well-formed"),
        ("<scene version=\"3.0.0\">\n<shape></scene>", "scene.xml:2:", "not well-formed"),
        ("<scene version=\"3.0.0\"/><scene version=\"3.0.0\"/>", "scene.xml:1:", "not well-formed"),
        ("<scene version=\"3.0.0\" version=\"2.0\"/>", "scene.xml:1:", "not well-formed"),
        ("<scene version=\"3.0.0\">&what;</scene>", "scene.xml:1:", "not well-formed"),
        ("<scene version=\"3.0.0\">\u{0}</scene>", "scene.xml:1:", "not well-formed"),
        ("<scene version=\"3.0.0\"><!-- ", "scene.xml:1:", "not well-formed"),
        (bomb, "scene.xml:1:", "not well-formed"),
        (external, "scene.xml:1:", "not well-formed"),
        (&deep, "scene.xml:1:", ""),
        ("<scene/>", "scene.xml:1:1", "needs version="),
        ("<scene version=\"4.0.0\"/>", "scene.xml:1:1", "version \"4.0.0\" is not supported"),
        ("<scene version=\"\"/>", "scene.xml:1:1", "is not supported"),
        ("<scene version=\"-1\"/>", "scene.xml:1:1", "is not supported"),
        ("<bsdf type=\"diffuse\" version=\"3.0.0\"/>", "scene.xml:1:1", "must be <scene>"),
        ("<scene version=\"3.0.0\"/>", "scene.xml:1:1", "has no <sensor>"),
    ] {
        let error = folder.error(xml);
        let begin: String = xml.chars().take(100).collect();
        assert!(error.starts_with(place) && error.contains(message), "{begin}: {error}");
    }
}

#[test]
fn broken_values() {
    let folder = Folder::new("broken-values");
    let sphere = |inside: &str| format!("<shape type=\"sphere\">{inside}</shape>");
    let float = |value: &str| sphere(&format!("<float name=\"radius\" value=\"{value}\"/>"));
    let point = |attributes: &str| sphere(&format!("<point name=\"center\" {attributes}/>"));
    let moved = |step: &str| sphere(&format!("<transform name=\"to_world\">{step}</transform>"));
    let color = |value: &str| {
        format!("<bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"{value}\"/></bsdf>")
    };
    let laughs: String = (0..9)
        .map(|i| {
            let [a, b] = [i, i + 1].map(|i| format!("lol{i}"));
            let value = format!("${a}").repeat(10);
            format!("<default name=\"{b}\" value=\"{value}\"/>")
        })
        .collect();
    let laughs = format!("<default name=\"lol0\" value=\"lololololol\"/>{laughs}");
    let many: String = (0..5000).map(|i| format!("<default name=\"p{i}\" value=\"\"/>")).collect();
    let dollars = format!(
        "<default name=\"e\" value=\"\"/><string name=\"a\" value=\"{}\"/>",
        "$e".repeat(200_000)
    );
    let nested = "<bsdf type=\"twosided\">".repeat(40) + &"</bsdf>".repeat(40);
    let at = "scene.xml:2:22 ";
    let step = "scene.xml:2:49 ";
    let rows: Vec<(String, &str, &str)> = vec![
        (float("abc"), at, "\"abc\" is not a number"),
        (float(""), at, "is not a number"),
        (float("1e999"), at, "is not a finite number"),
        (float("nan"), at, "is not a finite number"),
        (float("-inf"), at, "is not a finite number"),
        (float("1 2"), at, "is not a number"),
        (float("0"), at, "must be positive"),
        (float("-1"), at, "must be positive"),
        (float("1e30"), "scene.xml:2:1 ", "too small or too large"),
        (float("1e-30"), "scene.xml:2:1 ", "too small or too large"),
        (float(&"9".repeat(100_000)), at, "is not a finite number"),
        (sphere("<integer name=\"radius\" value=\"1.5\"/>"), at, "is not an integer"),
        (sphere("<integer name=\"radius\" value=\"99999999999999999999\"/>"), at, "integer"),
        (sphere("<string name=\"radius\" value=\"1\"/>"), at, "must be a <float>"),
        (sphere("<boolean name=\"flip_normals\" value=\"maybe\"/>"), at, "neither true nor false"),
        (sphere("<float name=\"flip_normals\" value=\"1\"/>"), at, "must be a <boolean>"),
        (sphere("<float name=\"radius\"/>"), at, "\"value\" is missing"),
        (sphere("<float value=\"1\"/>"), at, "\"name\" is missing"),
        (
            sphere("<float name=\"radius\" value=\"1\" unit=\"m\"/>"),
            at,
            "unknown attribute \"unit\"",
        ),
        (sphere("<float name=\"radius\" value=\"1\"><a/></float>"), at, "cannot have children"),
        (sphere("<float name=\"size\" value=\"1\"/>"), at, "unreferenced property \"size\""),
        (
            sphere("<float name=\"radius\" value=\"1\"/><float name=\"radius\" value=\"2\"/>"),
            "scene.xml:2:54 ",
            "a second property named \"radius\"",
        ),
        (point("x=\"1\" y=\"2\""), at, "\"x\", \"y\" and \"z\""),
        (point("value=\"1 2\""), at, "one or three numbers"),
        (point("value=\"1 2 3\" x=\"1\""), at, "exclude each other"),
        (point("value=\"1 nan 3\""), at, "is not a finite number"),
        (point(&format!("value=\"{}\"", "1 ".repeat(1_000_000))), at, "more than 16 numbers"),
        (moved("<matrix value=\"1 2 3 4 5\"/>"), step, "9 or 16 numbers"),
        (moved(&format!("<matrix value=\"{}\"/>", "1 ".repeat(16))), step, "last row"),
        (moved("<rotate angle=\"10\"/>"), step, "axis must not be zero"),
        (moved("<rotate y=\"1\"/>"), step, "\"angle\" is missing"),
        (moved("<lookat origin=\"1,1,1\" target=\"1,1,1\"/>"), step, "must differ"),
        (moved("<lookat origin=\"0,0,0\" target=\"0,1,0\" up=\"0,1,0\"/>"), step, "parallel"),
        (moved("<spin y=\"1\"/>"), step, "not supported inside <transform>"),
        (moved("<scale value=\"0\"/>"), at, "flattens space"),
        (moved("<scale x=\"2\"/>"), at, "scaled evenly"),
        (moved("<scale value=\"1e200\"/><scale value=\"1e200\"/>"), "scene.xml:2:71 ", "overflows"),
        (moved("<translate x=\"1e200\"/>"), "scene.xml:2:1 ", "too small or too large"),
        (color("1 2"), at, "one or three numbers"),
        (color("#12"), at, "#rrggbb"),
        (color("#gggggg"), at, "#rrggbb"),
        (color("#ünïöd"), at, "#rrggbb"),
        (color("2"), at, "must lie in [0, 1]"),
        (color("-0.1"), at, "must lie in [0, 1]"),
        (float("$r"), at, "undefined parameter $r"),
        (laughs, "scene.xml:2:", "add up to more than"),
        (many, "scene.xml:2:", "more than 4096 parameters"),
        (dollars, "scene.xml:2:", "are used more than"),
        ("<default name=\"\" value=\"1\"/>".to_owned(), "scene.xml:2:1 ", "needs a name"),
        ("<foo/>".to_owned(), "scene.xml:2:1 ", "not supported; supported: sensor"),
        ("<shape/>".to_owned(), "scene.xml:2:1 ", "\"type\" is missing"),
        ("<shape type=\"\"/>".to_owned(), "scene.xml:2:1 ", "not supported"),
        (nested, "scene.xml:2:", "nested too deeply"),
    ];
    let rows: Vec<_> =
        rows.iter().map(|(body, place, what)| (body.as_str(), *place, *what)).collect();
    check(&folder, &rows);
}

#[test]
fn broken_references_and_groups() {
    let folder = Folder::new("broken-references");
    let faces = "v 0 0 0\nv 1 0 0\nv 0 1 0\n".to_owned() + &"f 1 2 3\n".repeat(100_000);
    folder.write("many.obj", faces.as_bytes());
    let many = "<shape type=\"shapegroup\" id=\"g\"><shape type=\"obj\">\
                <string name=\"filename\" value=\"many.obj\"/></shape></shape>"
        .to_owned()
        + &"<shape type=\"instance\"><ref id=\"g\"/></shape>".repeat(100);
    let chain: String = (1..5000)
        .map(|i| format!("<bsdf type=\"twosided\" id=\"b{i}\"><ref id=\"b{}\"/></bsdf>", i - 1))
        .collect();
    let chain = format!("<bsdf type=\"diffuse\" id=\"b0\"/>{chain}");
    // Each is a mixture of the last one with itself.
    let doubled: String = (1..40)
        .map(|i| {
            let last = format!("<ref id=\"b{}\"/>", i - 1);
            format!(
                "<bsdf type=\"blendbsdf\" id=\"b{i}\"><float name=\"weight\" value=\"0.5\"/>\
                 {last}{last}</bsdf>"
            )
        })
        .collect();
    let doubled = format!("<bsdf type=\"diffuse\" id=\"b0\"/>{doubled}");
    let group = |inside: &str| format!("<shape type=\"shapegroup\" id=\"g\">{inside}</shape>");
    let lamp = group("<shape type=\"cube\"><emitter type=\"area\"/></shape>");
    let uneven = group("<shape type=\"sphere\"/>")
        + "<shape type=\"instance\"><ref id=\"g\"/><transform name=\"to_world\"><scale x=\"2\"/>\
           </transform></shape>";
    check(
        &folder,
        &[
            (
                "<shape type=\"cube\"><ref id=\"x\"/></shape>",
                "scene.xml:2:20 ",
                "no object has the id \"x\"",
            ),
            ("<shape type=\"cube\"><ref/></shape>", "scene.xml:2:20 ", "\"id\" is missing"),
            ("<ref id=\"\"/>", "scene.xml:2:1 ", "no object has the id \"\""),
            (
                "<bsdf type=\"diffuse\" id=\"a\"/><shape type=\"cube\" id=\"a\"/>",
                "scene.xml:2:30 ",
                "already in use",
            ),
            (
                "<bsdf type=\"twosided\" id=\"a\"><ref id=\"a\"/></bsdf>",
                "scene.xml:2:30 ",
                "closes a circle",
            ),
            (
                "<bsdf type=\"twosided\" id=\"a\"><ref id=\"b\"/></bsdf>\
                 <bsdf type=\"twosided\" id=\"b\"><ref id=\"a\"/></bsdf>",
                "scene.xml:2:",
                "closes a circle",
            ),
            (&group("<ref id=\"g\"/>"), "scene.xml:2:", "closes a circle"),
            ("<alias id=\"no\" as=\"yes\"/>", "scene.xml:2:1 ", "no object has the id \"no\""),
            (
                "<bsdf type=\"diffuse\" id=\"a\"/><alias id=\"a\" as=\"a\"/>",
                "scene.xml:2:30 ",
                "already in use",
            ),
            (
                "<shape type=\"cube\"><ref id=\"c\"/></shape><shape type=\"cube\" id=\"c\"/>",
                "scene.xml:2:20 ",
                "is not supported inside",
            ),
            (&chain, "scene.xml:2:", "nested too deeply"),
            (&doubled, "scene.xml:2:", "a mixture of 16 materials; at most 15 are supported"),
            ("<shape type=\"instance\"/>", "scene.xml:2:1 ", "needs a <ref> to a shapegroup"),
            (
                "<shape type=\"cube\" id=\"c\"/><shape type=\"instance\"><ref id=\"c\"/></shape>",
                "scene.xml:2:28 ",
                "needs a <ref> to a shapegroup",
            ),
            (
                &(group("") + "<shape type=\"instance\"><ref id=\"g\"/><ref id=\"g\"/></shape>"),
                "scene.xml:2:",
                "a second <shape>",
            ),
            (
                &group("<shape type=\"shapegroup\"/>"),
                "scene.xml:2:33 ",
                "neither groups nor instances",
            ),
            (
                &group("<shape type=\"instance\"/>"),
                "scene.xml:2:33 ",
                "neither groups nor instances",
            ),
            (&group("<bsdf type=\"diffuse\"/>"), "scene.xml:2:33 ", "is not supported inside"),
            (&group("<float name=\"a\" value=\"1\"/>"), "scene.xml:2:33 ", "unreferenced property"),
            (&lamp, "scene.xml:2:33 ", "may not emit"),
            (&uneven, "scene.xml:2:", "scaled evenly"),
            (&many, "scene.xml:2:", "add up to more than"),
        ],
    );
}

#[test]
fn broken_includes() {
    let folder = Folder::new("broken-includes");
    std::fs::create_dir_all(folder.0.join("sub")).unwrap();
    for (name, text) in [
        ("self.xml", "<scene version=\"3.0.0\">\n<include filename=\"self.xml\"/></scene>"),
        ("a.xml", "<scene version=\"3.0.0\"><include filename=\"b.xml\"/></scene>"),
        ("b.xml", "<scene version=\"3.0.0\"><include filename=\"a.xml\"/></scene>"),
        ("cut.xml", "<scene version=\"3.0.0\">\n<shape type=\"cube\">"),
        ("bare.xml", "<scene><shape type=\"cube\"/></scene>"),
        ("wrong.xml", "<scene version=\"3.0.0\">\n\n<shape type=\"egg\"/></scene>"),
        // Every file includes the next one twice.
        (
            "twice.xml",
            "<scene version=\"3.0.0\"><include filename=\"twice.xml\"/><include filename=\"twice.xml\"/></scene>",
        ),
    ] {
        folder.write(name, text.as_bytes());
    }
    folder.write("binary.xml", &[0xff, 0xfe, 0, 1, 2]);
    let include = |name: &str| format!("<include filename=\"{name}\"/>");
    check(
        &folder,
        &[
            (&include("self.xml"), "self.xml:2:1 ", "does a file include itself?"),
            (&include("a.xml"), "", "does a file include itself?"),
            (&include("twice.xml"), "twice.xml:1:", "does a file include itself?"),
            (&include("no.xml"), "scene.xml:2:1 ", "file \"no.xml\" not found; tried "),
            (&include("../../../../../no/such.xml"), "scene.xml:2:1 ", "not found"),
            (&include("/no/such.xml"), "scene.xml:2:1 ", "not found"),
            (&include(""), "scene.xml:2:1 ", "the name of the file is empty"),
            (&include("sub"), "scene.xml:2:1 ", "it is a folder"),
            (&include("binary.xml"), "scene.xml:2:1 ", "is not UTF-8 text"),
            (&include("cut.xml"), "cut.xml:", "not well-formed"),
            (&include("bare.xml"), "bare.xml:1:1 ", "needs version="),
            (&include("wrong.xml"), "wrong.xml:3:1 ", "not supported"),
            ("<include/>", "scene.xml:2:1 ", "\"filename\" is missing"),
            ("<path value=\"no\"/>", "scene.xml:2:1 ", "not found"),
            ("<path value=\"a.xml\"/>", "scene.xml:2:1 ", "is not a folder"),
            (
                "<shape type=\"cube\"><path value=\"sub\"/></shape>",
                "scene.xml:2:20 ",
                "only allowed directly",
            ),
        ],
    );
    // A device that never ends.
    if Path::new("/dev/zero").exists() {
        check(&folder, &[(&include("/dev/zero"), "scene.xml:2:1 ", "no regular file")]);
    }
    // Another place is allowed, as in Mitsuba.
    folder.write("cube.xml", b"<scene version=\"3.0.0\"><shape type=\"cube\"/></scene>");
    let above =
        format!("<scene version=\"3.0.0\">{SENSOR}<include filename=\"sub/../cube.xml\"/></scene>");
    assert_eq!(Scene::from_str(&above, &folder.0, &[]).unwrap().shapes.len(), 1);
}

#[test]
fn broken_shapes_sensors_and_lights() {
    let folder = Folder::new("broken-elements");
    let cylinder = |inside: &str| format!("<shape type=\"cylinder\">{inside}</shape>");
    let sensor = |kind: &str, inside: &str| format!("<sensor type=\"{kind}\">{inside}</sensor>");
    let film =
        |inside: &str| sensor("perspective", &format!("<film type=\"hdrfilm\">{inside}</film>"));
    let integer = |name: &str, value: i64| format!("<integer name=\"{name}\" value=\"{value}\"/>");
    let float = |name: &str, value: f64| format!("<float name=\"{name}\" value=\"{value}\"/>");
    let scaled = "<transform name=\"to_world\"><scale x=\"2\" y=\"2\"/></transform>";
    let flat = "<transform name=\"to_world\"><scale y=\"0\"/></transform>";
    let wide = "<transform name=\"to_world\"><scale x=\"1e30\" y=\"1e30\"/></transform>";
    let far = "<transform name=\"to_world\"><translate x=\"1e20\"/></transform>";
    let sheared = "<transform name=\"to_world\"><matrix value=\"1 1 0 0 1 0 0 0 1\"/></transform>";
    let place = "scene.xml:2:";
    check(
        &folder,
        &[
            ("<shape type=\"egg\"/>", "scene.xml:2:1 ", "not supported; supported: rectangle"),
            (&cylinder(&float("radius", -1.0)), place, "must be positive"),
            (&cylinder("<point name=\"p1\" x=\"0\" y=\"0\" z=\"0\"/>"), place, "must differ"),
            (&cylinder(sheared), place, "evenly across its axis"),
            (&cylinder(&float("length", 1.0)), place, "unreferenced property"),
            (
                "<shape type=\"cube\"><bsdf type=\"diffuse\"/><bsdf type=\"diffuse\"/></shape>",
                place,
                "a second <bsdf>",
            ),
            (
                "<shape type=\"cube\"><medium type=\"homogeneous\"/></shape>",
                place,
                "not supported inside",
            ),
            (
                "<shape type=\"cube\"><emitter type=\"point\"/></shape>",
                place,
                "not supported; supported: area",
            ),
            (
                "<shape type=\"cube\"><emitter type=\"area\"><rgb name=\"radiance\" value=\"-1\"/></emitter></shape>",
                place,
                "must lie in",
            ),
            ("<emitter type=\"area\"/>", place, "must stand inside a <shape>"),
            ("<emitter type=\"moon\"/>", place, "not supported"),
            (
                "<emitter type=\"constant\"/><emitter type=\"constant\"/>",
                place,
                "only one is allowed",
            ),
            (
                "<emitter type=\"spot\"><float name=\"cutoff_angle\" value=\"200\"/></emitter>",
                place,
                "180 degrees",
            ),
            (
                "<emitter type=\"spot\"><texture type=\"checkerboard\" name=\"glass\"/></emitter>",
                place,
                "has no texture but \"texture\"",
            ),
            (
                "<emitter type=\"point\"><texture type=\"checkerboard\" name=\"texture\"/></emitter>",
                place,
                "not supported inside <emitter",
            ),
            (
                "<bsdf type=\"diffuse\"><texture type=\"checkerboard\" name=\"reflectance\">\
                 <texture type=\"checkerboard\" name=\"color2\"/></texture></bsdf>",
                place,
                "supported: color0, color1",
            ),
            (
                "<bsdf type=\"diffuse\"><texture type=\"checkerboard\" name=\"reflectance\">\
                 <texture type=\"mesh_attribute\" name=\"color0\">\
                 <string name=\"name\" value=\"vertex_a\"/></texture></texture></bsdf>",
                place,
                "not supported within a checkerboard",
            ),
            (
                "<emitter type=\"directional\"><vector name=\"direction\" x=\"0\" y=\"0\" z=\"0\"/></emitter>",
                place,
                "must not be zero",
            ),
            ("<bsdf type=\"velvet\"/>", place, "not supported; supported: diffuse"),
            (
                "<integrator type=\"path\"><integer name=\"max_depth\" value=\"-2\"/></integrator>",
                place,
                "must be in -1",
            ),
            (
                "<integrator type=\"path\"/><integrator type=\"path\"/>",
                place,
                "a second <integrator>",
            ),
            (&sensor("fisheye", ""), place, "not supported; supported: perspective"),
            (&sensor("perspective", &float("fov", 0.0)), place, "between 0 and 180"),
            (&sensor("perspective", &float("fov", 180.0)), place, "between 0 and 180"),
            (&sensor("perspective", &float("fov", 1e-15)), place, "at least 1e-12 degrees"),
            (
                &sensor("perspective", &float("principal_point_offset_x", 1e20)),
                place,
                "1e20 must lie within 1000 images",
            ),
            (
                &sensor(
                    "perspective",
                    &(float("fov", 40.0) + "<string name=\"focal_length\" value=\"50mm\"/>"),
                ),
                place,
                "not both",
            ),
            (
                &sensor("perspective", "<string name=\"focal_length\" value=\"long\"/>"),
                place,
                "is not a number",
            ),
            (
                &sensor(
                    "perspective",
                    &(float("fov", 40.0) + "<string name=\"fov_axis\" value=\"w\"/>"),
                ),
                place,
                "is no axis",
            ),
            (&sensor("perspective", scaled), place, "may not scale or shear"),
            (&sensor("perspective", far), place, "too far away"),
            (&sensor("thinlens", ""), place, "needs the float \"aperture_radius\""),
            (&sensor("thinlens", &float("aperture_radius", -1.0)), place, "must be in 0"),
            (
                &sensor(
                    "thinlens",
                    &(float("aperture_radius", 1.0) + &float("focus_distance", 0.0)),
                ),
                place,
                "must be in 1e-15",
            ),
            (&sensor("orthographic", flat), place, "flattens space"),
            (&sensor("orthographic", wide), place, "too small or too large"),
            (&sensor("orthographic", far), place, "too far away"),
            (&film(&integer("width", 0)), place, "must be in 1..=65536"),
            (&film(&integer("height", 1 << 40)), place, "must be in 1..=65536"),
            (&film(&integer("crop_offset_x", 800)), place, "must be in 0..=767"),
            (
                &film(&(integer("crop_offset_y", 500) + &integer("crop_height", 100))),
                place,
                "must be in 1..=76",
            ),
            (&film("<rfilter type=\"sharp\"/>"), place, "not supported; supported: box"),
            (
                &film("<rfilter type=\"mitchell\"><float name=\"C\" value=\"7\"/></rfilter>"),
                place,
                "must be in 0..=1",
            ),
            (
                &film(
                    "<rfilter type=\"lanczos\"><integer name=\"lobes\" value=\"1000\"/></rfilter>",
                ),
                place,
                "must be in 1..=16",
            ),
            (
                &film("<rfilter type=\"tent\"><float name=\"radius\" value=\"0\"/></rfilter>"),
                place,
                "must be in 0.001",
            ),
            (
                &sensor("perspective", "<film type=\"tape\"/>"),
                place,
                "not supported; supported: hdrfilm",
            ),
            (
                &sensor(
                    "perspective",
                    "<sampler type=\"independent\"><integer name=\"sample_count\" value=\"0\"/></sampler>",
                ),
                place,
                "must be in 1",
            ),
            (
                &sensor("perspective", "<sampler type=\"dice\"/>"),
                place,
                "not supported; supported: independent",
            ),
        ],
    );
}

#[test]
fn broken_meshes() {
    let folder = Folder::new("broken-meshes");
    let mut rows: Vec<(String, String, &str)> = Vec::new();
    let mut mesh = |kind: &str, bytes: &[u8], place: &str, what: &'static str, extra: &str| {
        let name = format!("{}.{kind}", rows.len());
        folder.write(&name, bytes);
        let body = format!(
            "<shape type=\"{kind}\"><string name=\"filename\" value=\"{name}\"/>{extra}</shape>"
        );
        let place = if place.starts_with("scene") { place.to_owned() } else { name + place };
        rows.push((body, place, what));
    };
    let square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nvn 0 0 1\nvt 0 0\n";
    for (line, what) in [
        ("f 1 2 4", "vertex 4 does not exist; there are 3 so far"),
        ("f 0 1 2", "vertex 0 does not exist"),
        ("f -4 1 2", "vertex -4 does not exist"),
        ("f 1 2", "at least three corners"),
        ("f", "at least three corners"),
        ("f a b c", "\"a\" is not a vertex index"),
        ("f 1 2 99999999999999999999", "is not a vertex index"),
        ("f 1//2 2 3", "normal 2 does not exist"),
        ("f 1/7 2 3", "texture coordinate 7 does not exist"),
        ("f / / /", "is not a vertex index"),
        ("v 0 nan 0", "is not a finite number"),
        ("v 0 1e999 0", "is not a finite number"),
        ("v 0 0", "three numbers are needed"),
        ("vt 1", "two numbers are needed"),
        ("vn 1 2 z", "is not a number"),
    ] {
        mesh("obj", format!("{square}{line}\n").as_bytes(), ":6", what, "");
    }
    mesh("obj", b"", ":", "no triangles", "");
    mesh("obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 1e150 0\nf 1/1 2 3\n", ":", "at most 1e15", "");
    mesh("obj", square.as_bytes(), ":", "no triangles", "");
    mesh(
        "obj",
        b"v 0 0 0\nv 1e30 0 0\nv 0 1e30 0\nf 1 2 3\n",
        "scene.xml:2:1 ",
        "too small or too large",
        "",
    );

    let header = |format: &str, rest: &str| {
        format!(
            "ply\nformat {format} 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
             property float z\n{rest}end_header\n"
        )
    };
    let faces = "element face 1\nproperty list uchar int vertex_indices\n";
    let ascii = |rest: &str| header("ascii", faces) + "0 0 0\n1 0 0\n0 1 0\n" + rest;
    for (text, place, what) in [
        (String::new(), ":1", "the header has no end"),
        ("solid\n".to_owned(), ":1", "not a PLY file"),
        ("ply\n".to_owned(), ":1", "the header has no end"),
        ("ply\nformat ascii 2.0\n".to_owned(), ":2", "does not belong in a PLY header"),
        ("ply\nformat base64 1.0\n".to_owned(), ":2", "unknown format"),
        ("ply\nend_header\n".to_owned(), ":2", "has no \"format\""),
        ("ply\nformat ascii 1.0\nelement vertex -1\n".to_owned(), ":3", "is not a count"),
        ("ply\nformat ascii 1.0\nelement vertex many\n".to_owned(), ":3", "is not a count"),
        (
            "ply\nformat ascii 1.0\nproperty float x\n".to_owned(),
            ":3",
            "a property before any element",
        ),
        (
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty half x\n".to_owned(),
            ":4",
            "unknown type",
        ),
        (
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty x\n".to_owned(),
            ":4",
            "needs a type and a name",
        ),
        (
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n".to_owned(),
            ":5",
            "needs the properties x, y and z",
        ),
        (header("ascii", "element face 1\nproperty int a\n"), ":", "needs the list vertex_indices"),
        (ascii("3 0 1 3\n"), " triangle 0", "vertex 3 does not exist; there are 3"),
        (ascii("3 0 1 -1\n"), ":13 face 0", "negative or not an integer"),
        (ascii("3 0 1 0.5\n"), ":13 face 0", "negative or not an integer"),
        (ascii("2 0 1\n"), ":13 face 0", "at least three corners"),
        (ascii("-3 0 1 2\n"), ":13 face 0", "a list of -3 items"),
        (ascii("nan 0 1 2\n"), ":13 face 0", "a list of NaN items"),
        (ascii("4000000000 0 1 2\n"), ":", "the file ends here"),
        (ascii("3 0 1\n"), ":", "the file ends here"),
        (ascii(""), ":", "the file ends here"),
        (header("ascii", faces) + "0 nan 0\n", ":10 vertex 0", "is not finite"),
        (header("ascii", faces) + "0 inf 0\n", ":10 vertex 0", "is not finite"),
        (header("ascii", faces) + "0 zero 0\n", ":10 vertex 0", "is not a number"),
        (header("ascii", "") + "0 0 0\n1 0 0\n0 1 0\n", ":", "no triangles"),
        (
            header("ascii", faces).replace("vertex 3", "vertex 99999999999999"),
            ":",
            "the file ends here",
        ),
        (
            header("binary_little_endian", faces).replace("vertex 3", "vertex 178956970"),
            " vertex 0",
            "the file ends here",
        ),
        (
            header("binary_big_endian", faces).replace("face 1", "face 18446744073709551615"),
            " vertex 0",
            "the file ends here",
        ),
        (header("ascii", "element nothing 18446744073709551615\n"), ":", "the file ends here"),
    ] {
        mesh("ply", text.as_bytes(), place, what, "");
    }
    let mut cut = header("binary_little_endian", faces).into_bytes();
    cut.extend([0; 37]);
    mesh("ply", &cut, " face 0", "at least three corners", "");
    cut.truncate(cut.len() - 10);
    mesh("ply", &cut, " vertex 2", "the file ends here", "");
    mesh("ply", b"ply\nformat ascii 1.0\ncomment \xff\xfe\nend_header\n", ":", "not text", "");

    let good = serialized(3, 1, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0], &[0, 1, 2]);
    let index = |i: i64| format!("<integer name=\"shape_index\" value=\"{i}\"/>");
    mesh("serialized", b"", " mesh 0", "the first bytes are wrong", "");
    mesh("serialized", &good, " mesh 1", "there are 1 meshes", &index(1));
    mesh("serialized", &good, "scene.xml:2:", "must be in 0", &index(-1));
    mesh("serialized", &good, "scene.xml:2:", "must be in 0", &index(1 << 40));
    let changed = |at: usize, bytes: &[u8]| {
        let mut file = good.clone();
        file[at..at + bytes.len()].copy_from_slice(bytes);
        file
    };
    let end = good.len();
    mesh("serialized", &changed(0, &[9]), " mesh 0", "the first bytes are wrong", "");
    mesh("serialized", &changed(2, &[9]), " mesh 0", "version 9 of the format", "");
    // The table: one offset of eight bytes, and the number of meshes.
    mesh("serialized", &changed(end - 12, &[0xff; 8]), " mesh 0", "the first bytes are wrong", "");
    mesh(
        "serialized",
        &changed(end - 12, &[end as u8]),
        " mesh 0",
        "the first bytes are wrong",
        "",
    );
    mesh(
        "serialized",
        &changed(end - 4, &[0xff; 4]),
        " mesh 0",
        "the table of meshes is broken",
        "",
    );
    mesh("serialized", &changed(end - 4, &[0; 4]), " mesh 0", "there are 0 meshes", "");
    mesh("serialized", &changed(4, &[0; 8]), " mesh 0", "the compressed data are broken", "");
    mesh("serialized", &good[..3], " mesh 0", "the first bytes are wrong", "");
    mesh("serialized", &good[..20], " mesh 0", "", "");
    let corners = [0.0; 9];
    for (vertices, triangles, positions, indices, what) in [
        (u64::MAX, 1, &corners[..], &[0, 1, 2][..], "are too many"),
        (3, 1 << 40, &corners, &[0, 1, 2], "are too many"),
        // Two gigabytes in less than a kilobyte.
        (178_956_970, 1, &corners, &[0, 1, 2], "ends before its last triangle"),
        (3, 178_956_970, &corners, &[0, 1, 2], "ends before its last triangle"),
        (3, 1, &corners, &[0, 1, 3], "vertex 3 does not exist"),
        (3, 1, &[0.0, f32::NAN, 0.0], &[], "not finite"),
        (3, 1, &[0.0, f32::INFINITY, 0.0], &[], "not finite"),
        (0, 0, &[], &[], "no triangles"),
        (3, 1, &corners[..5], &[], "ends before its last triangle"),
    ] {
        let file = serialized(vertices, triangles, positions, indices);
        assert!(file.len() < 1000);
        mesh("serialized", &file, " mesh 0", what, "");
    }
    let rows: Vec<_> = rows.iter().map(|(a, b, c)| (a.as_str(), b.as_str(), *c)).collect();
    check(&folder, &rows);
    check(
        &folder,
        &[
            ("<shape type=\"obj\"/>", "scene.xml:2:1 ", "\"filename\" is missing"),
            (
                "<shape type=\"ply\"><string name=\"filename\" value=\"no.ply\"/></shape>",
                "scene.xml:2:19 ",
                "not found",
            ),
            (
                "<shape type=\"obj\"><string name=\"filename\" value=\".\"/></shape>",
                "scene.xml:2:19 ",
                "it is a folder",
            ),
            (
                "<shape type=\"obj\"><float name=\"filename\" value=\"1\"/></shape>",
                "scene.xml:2:19 ",
                "must be a <string>",
            ),
        ],
    );
}

/// A compressed file of one mesh that claims these counts, without normals or texture coordinates.
fn serialized(vertices: u64, triangles: u64, positions: &[f32], indices: &[u32]) -> Vec<u8> {
    let mut data = 0x1000u32.to_le_bytes().to_vec();
    data.extend(b"\0");
    data.extend(vertices.to_le_bytes());
    data.extend(triangles.to_le_bytes());
    data.extend(positions.iter().flat_map(|x| x.to_le_bytes()));
    data.extend(indices.iter().flat_map(|i| i.to_le_bytes()));
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
    encoder.write_all(&data).unwrap();
    let mut file = vec![0x1c, 0x04, 4, 0];
    file.extend(encoder.finish().unwrap());
    file.extend(0u64.to_le_bytes());
    file.extend(1u32.to_le_bytes());
    file
}

#[test]
fn broken_pictures() {
    let folder = Folder::new("broken-pictures");
    let image = crate::image::RgbImage::from_fn(3, 2, |x, y| [x as f32, y as f32, 0.5]);
    let png = folder.0.join("good.png");
    crate::image::png::write(&image, &png).unwrap();
    let good = std::fs::read(&png).unwrap();
    let mut huge = good.clone();
    // Width and height in the header, and its checksum.
    huge[16..24].copy_from_slice(&[0, 0, 0x40, 0, 0, 0, 0x40, 0]);
    let mut crc = flate2::Crc::new();
    crc.update(&huge[12..29]);
    huge[29..33].copy_from_slice(&crc.sum().to_be_bytes());
    let exr = folder.0.join("good.exr");
    let file = crate::image::exr::Exr {
        rgb: image,
        variance: None,
        layers: Default::default(),
        attributes: Default::default(),
    };
    file.write(&exr).unwrap();
    let exr = std::fs::read(&exr).unwrap();
    let mut wide = exr.clone();
    // The data window: four integers, the last of which are the largest column and row.
    let at = exr.windows(10).position(|w| w == b"dataWindow").unwrap() + 10 + 1 + 6 + 4 + 8;
    wide[at..at + 8].copy_from_slice(&[0xff, 0x3f, 0, 0, 0xff, 0x3f, 0, 0]);
    let mut rows: Vec<(String, &str)> = Vec::new();
    for (index, (bytes, what)) in [
        (&b""[..], "is no EXR, PNG, JPEG or Radiance HDR file"),
        (b"GIF89a", "is no EXR, PNG, JPEG or Radiance HDR file"),
        (&good[..8], ""),
        (&good[..40], ""),
        (&good[..good.len() / 2], ""),
        (&huge, "bytes cannot hold 16384 x 16384 pixels"),
        (b"\xff\xd8\xff\xe0\0\x10JFIF", ""),
        (
            b"\xff\xd8\xff\xc0\0\x11\x08\x40\0\x40\0\x03\x01\x11\0\x02\x11\x01\x03\x11\x01\xff\xd9",
            "",
        ),
        (b"#?RADIANCE\n\n-Y 9999999 +X 9999999\n", ""),
        (b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 16000 +X 16000\n", ""),
        (&exr[..4], ""),
        (&exr[..exr.len() / 2], ""),
        (&exr[..exr.len() - 5], ""),
        (&wide, ""),
    ]
    .into_iter()
    .enumerate()
    {
        let name = format!("{index}.image");
        folder.write(&name, bytes);
        rows.push((name, what));
    }
    rows.push(("no.png".to_owned(), "not found"));
    rows.push((".".to_owned(), "is no regular file"));
    let rows: Vec<_> = rows
        .into_iter()
        .map(|(name, what)| {
            let body = format!(
                "<bsdf type=\"diffuse\"><texture type=\"bitmap\" name=\"reflectance\">\
                 <string name=\"filename\" value=\"{name}\"/></texture></bsdf>"
            );
            (body, what)
        })
        .collect();
    let rows: Vec<_> =
        rows.iter().map(|(body, what)| (body.as_str(), "scene.xml:2:64 ", *what)).collect();
    check(&folder, &rows);
}
