//! The `aether` program as a user meets it: output, messages and exit codes.

#[path = "../examples/fuzz_loader/mutate.rs"]
mod mutate;

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use integrators::image::RgbImage;
use integrators::image::exr::Exr;

/// A directory that is removed at the end of a test.
struct Directory(PathBuf);

impl Directory {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("aether-cli-{}-{name}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    /// Writes an image with unit-free noise variance beside it, if given.
    fn exr(&self, name: &str, rgb: RgbImage, variance: Option<f32>) -> PathBuf {
        let path = self.0.join(name);
        let variance = variance.map(|v| RgbImage::filled(rgb.width(), rgb.height(), [v; 3]));
        Exr { rgb, variance, layers: Default::default(), attributes: Default::default() }
            .write(&path)
            .unwrap();
        path
    }
}

impl Drop for Directory {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn aether(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_aether")).args(arguments).output().unwrap()
}

fn compare(image: &Path, reference: &Path, options: &[&str]) -> Output {
    let paths = [image.to_str().unwrap(), reference.to_str().unwrap()];
    aether(&[&["compare"], &paths[..], options].concat())
}

fn stdout(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// The message of a run that must fail with exit code 2 and say nothing on stdout.
fn failure(output: Output) -> String {
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(output.stdout.is_empty());
    assert!(message.starts_with("error: "), "{message}");
    assert!(!message.contains("panicked"), "{message}");
    message
}

#[test]
fn compare_prints_all_measures() {
    let directory = Directory::new("measures");
    let image = directory.exr("a.exr", RgbImage::filled(16, 24, [0.75; 3]), Some(1e-4));
    let reference = directory.exr("b.exr", RgbImage::filled(16, 24, [0.5; 3]), Some(1e-4));
    let text = stdout(&compare(&image, &reference, &[]));
    for line in [
        "size          16x24",
        "RMSE          2.500000e-1",
        "relMSE        2.403846e-1",
        "PSNR          12.04 dB",
        "mean ratio    1.500000",
        "block z-test  6 of 6 blocks differ, max |z| 141.42",
    ] {
        assert!(text.contains(line), "`{line}` in\n{text}");
    }
    assert!(text.contains("FLIP          0."), "{text}");
}

#[test]
fn compare_prints_json() {
    let directory = Directory::new("json");
    let image = directory.exr("a.exr", RgbImage::filled(16, 16, [0.75; 3]), Some(1e-4));
    let plain = directory.exr("b.exr", RgbImage::filled(16, 16, [0.75; 3]), None);
    let parse = |text: String| serde_json::from_str::<serde_json::Value>(&text).unwrap();

    let same = parse(stdout(&compare(&image, &image, &["--json"])));
    assert_eq!(same["rmse"], 0.0);
    assert_eq!(same["flip"], 0.0);
    assert_eq!(same["mean_ratio"], 1.0);
    assert_eq!(same["psnr_db"], serde_json::Value::Null);
    assert_eq!(same["block_test"]["blocks"], 4);
    assert_eq!(same["block_test"]["failing_blocks"], 0);

    let untested = parse(stdout(&compare(&image, &plain, &["--json"])));
    assert_eq!(untested["block_test"], serde_json::Value::Null);
    assert!(stdout(&compare(&image, &plain, &[])).contains("needs variance.R"));
}

#[test]
fn compare_warns_of_broken_pixels() {
    let directory = Directory::new("broken");
    let mut broken = RgbImage::filled(8, 8, [0.5; 3]);
    broken.pixels_mut()[5][2] = f32::NAN;
    let image = directory.exr("a.exr", broken, None);
    let reference = directory.exr("b.exr", RgbImage::filled(8, 8, [0.5; 3]), None);
    let output = compare(&image, &reference, &[]);
    assert!(stdout(&output).contains("RMSE          0.000000e0"));
    let warning = String::from_utf8(output.stderr).unwrap();
    assert!(warning.contains("a.exr` has 1 NaN or infinite pixels"), "{warning}");
}

#[test]
fn compare_rejects_what_it_cannot_compare() {
    let directory = Directory::new("reject");
    let image = directory.exr("a.exr", RgbImage::filled(8, 8, [0.5; 3]), None);
    let wide = directory.exr("b.exr", RgbImage::filled(9, 8, [0.5; 3]), None);
    let text = directory.0.join("c.exr");
    std::fs::write(&text, "<scene/>").unwrap();

    assert!(failure(compare(&image, &wide, &[])).contains("8x8 against 9x8"));
    assert!(failure(compare(&image, &text, &[])).contains("c.exr` is not an EXR file"));
    let missing = failure(compare(&image, &directory.0.join("d.exr"), &[]));
    assert!(missing.contains("cannot read") && missing.contains("d.exr"), "{missing}");
    assert!(failure(compare(&image, &directory.0, &[])).contains("is a directory"));
    assert!(failure(aether(&["compare", "a.exr"])).contains("REFERENCE.exr"));
}

#[test]
fn render_rejects_impossible_values() {
    for (options, expected) in [
        (&["--spp", "0"][..], "whole number from 1"),
        (&["--spp", "-4"], "whole number from 1"),
        (&["--spp", "99999999999"], "whole number from 1"),
        (&["--time", "-1"], "seconds above 0"),
        (&["--time", "0"], "seconds above 0"),
        (&["--time", "NaN"], "seconds above 0"),
        (&["--spp", "4", "--time", "1"], "cannot be used with"),
        (&["--size", "0x0"], "width and height must be from 1"),
        (&["--size", "99999x99999"], "width and height must be from 1"),
        (&["--size", "640"], "expected WIDTHxHEIGHT"),
        (&["--threads", "0"], "whole number from 1"),
        (&["--max-depth", "-2"], "-1 for no limit"),
        (&["--seed", "-1"], "invalid"),
        (&["--sampler", "sobol"], "expected one of independent, stratified, multijitter"),
        (&["--techniques", "2"], "`2` is no technique"),
        (&["-D", "x"], "expected NAME=VALUE"),
        (&["-o", "out.png"], "must end in .exr"),
        (&["-o", "/nowhere/at/all/out.exr"], "cannot write"),
    ] {
        let message = failure(aether(&[&["render", "scene.xml"], options].concat()));
        assert!(message.contains(expected), "{options:?}: {message}");
    }
}

#[test]
fn a_missing_scene_is_named() {
    let directory = Directory::new("missing");
    let output = directory.0.join("out.exr");
    let options = ["render", "no-such-scene.xml", "-o", output.to_str().unwrap()];
    assert!(failure(aether(&options)).contains("no-such-scene.xml"));
    assert!(!output.exists());
    assert!(failure(aether(&["inspect", "no-such-scene.xml"])).contains("no-such-scene.xml"));
}

#[test]
fn inspect_lists_the_scene() {
    let directory = Directory::new("inspect");
    let scene = directory.0.join("ball.xml");
    let text = r#"<scene version="3.0.0">
        <default name="resx" value="64"/>
        <sensor type="perspective">
            <float name="fov" value="40"/>
            <film type="hdrfilm">
                <integer name="width" value="$resx"/><integer name="height" value="32"/>
            </film>
        </sensor>
        <shape type="sphere"><bsdf type="diffuse"/></shape>
    </scene>"#;
    std::fs::write(&scene, text).unwrap();
    let path = scene.to_str().unwrap();
    assert!(stdout(&aether(&["inspect", path])).contains("64 x 32"));
    let json = stdout(&aether(&["inspect", path, "--json", "-D", "resx=128"]));
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["film"]["width"], 128);
    assert_eq!(json["shapes"]["sphere"], 1);

    std::fs::write(&scene, text.replace("sphere", "teapot")).unwrap();
    let message = failure(aether(&["inspect", path]));
    assert!(message.contains("ball.xml:9") && message.contains("teapot"), "{message}");
}

/// A small closed room with a lamp.
const ROOM: &str = r#"<scene version="3.0.0">
    <integrator type="path"><integer name="max_depth" value="4"/></integrator>
    <sensor type="perspective">
        <float name="fov" value="60"/>
        <film type="hdrfilm">
            <integer name="width" value="16"/><integer name="height" value="12"/>
            <rfilter type="box"/>
        </film>
    </sensor>
    <shape type="sphere"><float name="radius" value="3"/><boolean name="flip_normals" value="true"/>
        <bsdf type="diffuse"/></shape>
    <shape type="sphere"><float name="radius" value="0.5"/><point name="center" x="1" y="1" z="1"/>
        <emitter type="area"><rgb name="radiance" value="5"/></emitter></shape>
</scene>"#;

#[test]
fn convergence_measures_and_reports() {
    let directory = Directory::new("convergence");
    let scene = directory.0.join("room.xml");
    std::fs::write(&scene, ROOM).unwrap();
    let path = |name: &str| directory.0.join(name).to_str().unwrap().to_owned();
    let options = [
        "--integrators=path",
        "--variant=camera only=bdpt --techniques 0:*",
        "--budget=0.05",
        "--repeats=3",
        "--reference-time=0.2",
        "--threads=1",
    ];
    let run = |more: &[&str]| {
        let scene = scene.to_str().unwrap();
        aether(&[&["convergence", scene], &options[..], more].concat())
    };
    let out = path("out");
    let text = stdout(&run(&["-o", &out]));
    assert!(text.contains("| room | path |") && text.contains("| room | camera only |"), "{text}");
    let read = |name: &str| std::fs::read_to_string(directory.0.join(name)).unwrap();
    let columns =
        "scene,renderer,integrator,seed,spp,seconds,rays,densities,rmse,relmse,smape,flip\n";
    let errors = read("out/errors.csv");
    assert!(errors.starts_with(columns) && errors.contains("\nroom,aether,camera only,2,"));
    assert!(read("out/room.svg").contains("<svg") && read("out/room-strip.svg").contains("<svg"));

    // Measured again with the reference that was made, and joined.
    let (again, joined) = (path("again"), path("joined"));
    let reference = path("out/reference.exr");
    let rest = ["--reference", &reference, "--name", "hall", "-o", &again];
    let scene = scene.to_str().unwrap();
    let once = ["convergence", scene, "--budget=0.02", "--repeats=1", "--integrators=mlt"];
    assert!(stdout(&aether(&[&once[..], &rest].concat())).contains("need three seeds"));
    let text = stdout(&aether(&["report", &out, &again, "-o", &joined]));
    assert!(text.contains("| room | path |") && text.contains("| hall | mlt |"), "{text}");
    assert!(read("joined/report.html").contains("data:image/png;base64,"));

    let small = ["convergence", scene, "--budget=1", "--size=8x8", "--reference", &reference];
    assert!(failure(aether(&small)).contains("has 16x12 pixels, the render 8x8"));
    for (more, expected) in [
        (&["--variant=x=teapot"][..], "integrator `teapot` is not supported"),
        (&["--variant=x=path --paint"], "--paint is no option of a single integrator here"),
        (&["--variant=path=bdpt"], "two integrators are called `path`"),
        (&["--variant=x=path --spp 3"], "--spp is no option of a single integrator here"),
        (&["--variant=x=path -Dgrey=1"], "-Dgrey is no option of a single integrator here"),
        (&["--images", "none.csv"], "none.csv"),
        // Before anything is measured or rendered.
        (
            &["--reference-by=path,mlt"],
            "cannot be made by `mlt`, whose samples depend on each other",
        ),
        (&["--reference-by=path,teapot"], "integrator `teapot` is not supported"),
        (&["--reference-by=path,tridir"], "the scene has no portal"),
        (&["--seed=18446744073709551613"], "give a --seed of at most 18446744073709551612"),
        (&["--crop=9,9,9"], "such as 10,20,64,48"),
        (&["--crop=9,9,9,9"], "does not lie in the image of 16x12 pixels"),
    ] {
        let message = failure(run(&[&["-o", &out], more].concat()));
        assert!(message.contains(expected), "{more:?}: {message}");
    }
    let none = ["convergence", scene, "--budget=1", "--repeats=0"];
    assert!(failure(aether(&none)).contains("1..=1000"));
    assert!(failure(aether(&["report", &out, &out])).contains("measured twice"));
    assert!(
        failure(aether(&["report", &path("none")])).contains("`aether convergence` has written")
    );
}

#[cfg(unix)]
#[test]
fn ctrl_c_keeps_the_seeds_that_have_been_measured() {
    let directory = Directory::new("seeds");
    let path = |name: &str| directory.0.join(name).to_str().unwrap().to_owned();
    let [scene, out] = ["room.xml", "out"].map(path);
    std::fs::write(&scene, ROOM).unwrap();
    let reference = directory.exr("reference.exr", RgbImage::filled(16, 12, [0.3; 3]), None);
    let line = ["convergence", &scene, "--budget=0.2", "--repeats=1000", "--integrators=path,bdpt"];
    let more = ["-o", &out, "--reference", reference.to_str().unwrap()];
    // On a busy machine no seed may be complete: then once more, with more patience.
    let run = [2000, 8000, 32_000, 60_000].into_iter().find_map(|patience| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_aether"));
        command.args(line).args(more).stdout(Stdio::piped()).stderr(Stdio::piped());
        let child = command.spawn().unwrap();
        std::thread::sleep(std::time::Duration::from_millis(patience));
        let kill = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
        assert!(kill.unwrap().success());
        let run = child.wait_with_output().unwrap();
        directory.0.join("out/errors.csv").exists().then_some(run)
    });
    let run = run.expect("a seed after a minute");
    let (text, message) =
        [run.stdout, run.stderr].map(|bytes| String::from_utf8(bytes).unwrap()).into();
    assert_eq!(run.status.code(), Some(130), "{message}");
    let errors = std::fs::read_to_string(directory.0.join("out/errors.csv")).unwrap();
    let seeds = |name: &str| {
        let rows = errors.lines().map(|row| row.split(',').collect::<Vec<_>>());
        let mut seeds: Vec<u64> =
            rows.filter(|row| row[2] == name).map(|row| row[3].parse().unwrap()).collect();
        seeds.dedup();
        seeds
    };
    // The same seeds of both, without gaps.
    let complete = seeds("path").len() as u64;
    assert!((1..1000).contains(&complete), "{complete}");
    assert_eq!(seeds("path"), (0..complete).collect::<Vec<_>>());
    assert_eq!(seeds("path"), seeds("bdpt"));
    assert!(text.contains(&format!("interrupted after {complete} of 1000 seeds")), "{text}");
}

#[test]
fn convergence_measures_the_images_that_renders_write() {
    let directory = Directory::new("gradients");
    let path = |name: &str| directory.0.join(name).to_str().unwrap().to_owned();
    let [scene, out, image] = ["room.xml", "out", "image.exr"].map(path);
    std::fs::write(&scene, ROOM).unwrap();
    let reference = directory.exr("reference.exr", RgbImage::filled(16, 12, [0.3; 3]), None);
    let variants = ["l1=gdpt", "l2=gdpt --reconstruction l2", "none=gdpt --reconstruction none"];
    let variants = variants.map(|variant| format!("--variant={variant}"));
    let mut line = vec!["convergence", &scene, "--budget=0.05", "--repeats=1", "-o", &out];
    line.extend(["--integrators=path", "--reference", reference.to_str().unwrap()]);
    line.extend(variants.iter().map(String::as_str));
    stdout(&aether(&line));
    let errors = std::fs::read_to_string(directory.0.join("out/errors.csv")).unwrap();
    for (label, options) in [
        ("path", &["path"][..]),
        ("l1", &["gdpt"]),
        ("l2", &["gdpt", "--reconstruction=l2"]),
        ("none", &["gdpt", "--reconstruction=none"]),
    ] {
        let of_label = |row: &&str| row.split(',').nth(2) == Some(label);
        let row = errors.lines().rfind(of_label).unwrap();
        let fields: Vec<&str> = row.split(',').collect();
        let line = ["render", &scene, "--spp", fields[4], "-o", &image, "--integrator"];
        stdout(&aether(&[&line[..], options].concat()));
        let text = stdout(&compare(Path::new(&image), &reference, &["--json"]));
        let rendered: serde_json::Value = serde_json::from_str(&text).unwrap();
        let (measured, rendered) = (&fields[8..10], [&rendered["rmse"], &rendered["relmse"]]);
        for (measured, rendered) in measured.iter().zip(rendered) {
            assert_eq!(*measured, format!("{:.6e}", rendered.as_f64().unwrap()), "{row}");
        }
    }
}

#[test]
fn a_render_ends_at_its_target_and_tells_what_it_did() {
    let directory = Directory::new("target");
    let (scene, output) = (directory.0.join("room.xml"), directory.0.join("out.exr"));
    std::fs::write(&scene, ROOM).unwrap();
    let (scene, path) = (scene.to_str().unwrap(), output.to_str().unwrap());
    let render =
        ["render", scene, "-o", path, "--target-error", "0.5", "--stats", "--live-exr=0.01"];
    for integrator in ["path", "bdpt", "mlt", "ppm"] {
        let more = ["--spp=4096", "--integrator", integrator];
        let text = stdout(&aether(&[&render[..], &more].concat()));
        assert!(text.contains("rays, nearest") && text.contains("densities"), "{text}");
        let samples = match &Exr::read(&output).unwrap().attributes["samples"] {
            integrators::image::exr::Attribute::Integer(samples) => *samples,
            other => panic!("{other:?}"),
        };
        assert!((16..4096).contains(&samples), "{integrator}: {samples}");
    }
    // A ray for each sample finds what is seen directly.
    let seen = ["render", scene, "-o", path, "--spp=3", "--max-depth=1", "--threads=3", "--stats"];
    let text = stdout(&aether(&seen));
    assert!(text.contains("rays, nearest 5.7600e2, 1.00 per sample"), "{text}");
    assert!(text.contains("rays, any     0.0000e0, 0.00 per sample"), "{text}");
    let adaptive = [&render[..], &["--adaptive", "--integrator", "bdpt"]].concat();
    assert!(failure(aether(&adaptive)).contains("leave --adaptive out"));
    let layers = [&render[..], &["--adaptive", "--technique-images"]].concat();
    assert!(failure(aether(&layers)).contains("leave one of the two out"));
    assert!(failure(aether(&["render", scene, "--adaptive"])).contains("--target-error"));
    assert!(failure(aether(&["render", scene, "--target-error=0"])).contains("above 0"));
}

#[test]
fn help_and_version_succeed() {
    assert!(stdout(&aether(&["--help"])).contains("render"));
    assert!(stdout(&aether(&["render", "--help"])).contains("--max-depth"));
    assert!(stdout(&aether(&["--version"])).starts_with("aether "));
    assert_eq!(aether(&[]).status.code(), Some(2));
    assert_eq!(aether(&["paint"]).status.code(), Some(2));
}

#[test]
fn a_closed_pipe_is_no_failure() {
    let directory = Directory::new("pipe");
    let image = directory.exr("a.exr", RgbImage::filled(64, 64, [0.5; 3]), None);
    let mut child = Command::new(env!("CARGO_BIN_EXE_aether"))
        .args(["compare", image.to_str().unwrap(), image.to_str().unwrap()])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // The reader is gone before the program prints anything that fills a pipe.
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(output.stderr.is_empty());
}

/// The beginning of what the example `fuzz_loader` does for longer.
#[test]
fn damaged_files_are_loaded_or_refused() {
    let directory = Directory::new("damaged");
    let seeds = mutate::seeds(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenes"));
    let mut refused = 0;
    for case in 0..400 {
        let (name, outcome) = mutate::try_case(&seeds, case, &directory.0);
        if let mutate::Outcome::Refused(message) = outcome {
            assert!(message.contains(':') && message.len() > 20, "{name}, case {case}: {message}");
            refused += 1;
        }
    }
    assert!((100..400).contains(&refused), "{refused} of 400 are refused");
    assert!(!mutate::damaged_file(&seeds, 0).1.is_empty());
}
