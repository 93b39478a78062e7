//! `aether render` from a scene file to the files that it leaves.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

use integrators::image::RgbImage;
use integrators::image::exr::{Attribute, Exr};

/// A ball under a lamp; the ball's material is on line 15.
const SCENE: &str = r#"<scene version="3.0.0">
    <default name="spp" value="4"/>
    <default name="grey" value="0.5"/>
    <integrator type="path"><integer name="max_depth" value="4"/></integrator>
    <sensor type="perspective">
        <float name="fov" value="45"/>
        <transform name="to_world"><lookat origin="0,0,5" target="0,0,0" up="0,1,0"/></transform>
        <sampler type="independent"><integer name="sample_count" value="$spp"/></sampler>
        <film type="hdrfilm">
            <integer name="width" value="24"/><integer name="height" value="16"/>
            <rfilter type="box"/>
        </film>
    </sensor>
    <shape type="sphere">
        <bsdf type="diffuse"><rgb name="reflectance" value="$grey"/></bsdf>
    </shape>
    <shape type="sphere">
        <point name="center" x="1" y="3" z="2"/><float name="radius" value="0.5"/>
        <emitter type="area"><rgb name="radiance" value="20"/></emitter>
    </shape>
</scene>"#;

/// A directory with a scene in it, removed at the end of a test.
struct Directory(PathBuf);

impl Directory {
    fn new(name: &str) -> Self {
        let path =
            std::env::temp_dir().join(format!("aether-render-{}-{name}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        std::fs::write(path.join("ball.xml"), SCENE).unwrap();
        Self(path)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// The program, in this directory, with these arguments.
    fn render(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_aether"));
        command.current_dir(&self.0).arg("render").args(arguments);
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    /// Renders and reads what was written.
    fn rendered(&self, output: &str, options: &[&str]) -> Exr {
        let run = self.render(&[&["ball.xml", "-o", output], options].concat()).output().unwrap();
        assert_eq!(run.status.code(), Some(0), "{}", message(&run));
        Exr::read(&self.path(output)).unwrap()
    }
}

impl Drop for Directory {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn message(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn samples(exr: &Exr) -> i32 {
    match exr.attributes["samples"] {
        Attribute::Integer(samples) => samples,
        ref other => panic!("{other:?}"),
    }
}

#[test]
fn a_render_leaves_an_exr_and_a_png() {
    let directory = Directory::new("files");
    let options = ["ball.xml", "--spp", "6", "--seed", "11", "-D", "grey=0.8"];
    let run = directory.render(&options).output().unwrap();
    assert_eq!(run.status.code(), Some(0), "{}", message(&run));
    // No progress bar on a pipe.
    assert_eq!(message(&run), "");
    let line = String::from_utf8_lossy(&run.stdout);
    assert!(line.contains("ball.exr") && line.contains("6 samples per pixel"), "{line}");

    let exr = Exr::read(&directory.path("ball.exr")).unwrap();
    assert_eq!((exr.rgb.width(), exr.rgb.height()), (24, 16));
    let variance = exr.variance.as_ref().unwrap();
    let lit = |image: &integrators::image::RgbImage| {
        image.pixels().iter().flatten().filter(|v| **v > 0.0).count()
    };
    assert!(lit(&exr.rgb) > 100 && lit(variance) > 100);
    assert!(variance.pixels().iter().flatten().all(|v| v.is_finite() && *v >= 0.0));

    let text = |text: &str| Attribute::Text(text.to_owned());
    assert_eq!(exr.attributes["scene"], text("ball.xml"));
    assert_eq!(exr.attributes["integrator"], text("path"));
    assert_eq!(exr.attributes["seed"], text("11"));
    assert_eq!(exr.attributes["settings"], text("max_depth=4 rr_depth=5 -D grey=0.8"));
    assert_eq!(samples(&exr), 6);
    assert!(matches!(exr.attributes["seconds"], Attribute::Number(s) if s >= 0.0));

    let png = std::fs::read(directory.path("ball.png")).unwrap();
    assert!(png.starts_with(b"\x89PNG\r\n\x1a\n"));
    // Nothing else is left behind.
    assert_eq!(std::fs::read_dir(&directory.0).unwrap().count(), 3);
}

#[test]
fn the_image_depends_on_the_seed_and_not_on_the_threads() {
    let directory = Directory::new("threads");
    let one = directory.rendered("one.exr", &["--threads", "1"]);
    for threads in ["2", "5"] {
        let many = directory.rendered("many.exr", &["--threads", threads]);
        assert!((&one.rgb, &one.variance) == (&many.rgb, &many.variance), "{threads} threads");
    }
    let other = directory.rendered("other.exr", &["--seed", "1"]);
    assert!(one.rgb != other.rgb);
    assert_eq!(samples(&one), 4);
}

#[test]
fn the_command_line_overrides_the_scene() {
    let directory = Directory::new("options");
    let lights = directory.rendered("lights.exr", &["--max-depth", "1"]);
    let lit = |exr: &Exr| exr.rgb.pixels().iter().filter(|p| p[0] > 0.0).count();
    let all = directory.rendered("all.exr", &[]);
    assert!(lit(&lights) < lit(&all), "{} {}", lit(&lights), lit(&all));
    assert_eq!(lit(&directory.rendered("nothing.exr", &["--max-depth", "0"])), 0);
    let large = directory.rendered("large.exr", &["--size", "48x32", "--spp", "1"]);
    assert_eq!((large.rgb.width(), large.rgb.height()), (48, 32));
    assert_eq!((samples(&large), large.variance), (1, None));
}

#[test]
fn a_time_limit_renders_at_least_one_sample() {
    let directory = Directory::new("time");
    let exr = directory.rendered("out.exr", &["--time", "0.2"]);
    assert!(samples(&exr) >= 1);
}

#[test]
fn what_is_not_supported_is_named_with_its_place() {
    let directory = Directory::new("unsupported");
    let fails = |scene: &str, expected: &[&str]| {
        std::fs::write(directory.path("ball.xml"), scene).unwrap();
        let run = directory.render(&["ball.xml"]).output().unwrap();
        let message = message(&run);
        assert_eq!(run.status.code(), Some(2), "{message}");
        assert!(run.stdout.is_empty() && !message.contains("panicked"), "{message}");
        for part in expected {
            assert!(message.contains(part), "`{part}` in: {message}");
        }
        assert!(!directory.path("ball.exr").exists());
    };
    fails(&SCENE.replace("\"diffuse\"", "\"glitter\""), &["ball.xml:15:9", "glitter", "diffuse"]);
    fails(&SCENE.replace("\"path\"", "\"volpath\""), &["ball.xml:4:5", "volpath", "path, bdpt"]);
    fails(&SCENE.replace("$spp", "many"), &["ball.xml:8:", "many"]);
    fails(&SCENE.replace("$grey", "$gray"), &["ball.xml:15:", "gray"]);
    fails(&SCENE.replace("</sensor>", ""), &["ball.xml:"]);
    fails("", &["ball.xml"]);
}

#[test]
fn a_file_tells_the_options_that_its_image_depends_on() {
    let directory = Directory::new("settings");
    for (options, settings) in [
        (&["--integrator=gdpt", "--reconstruction=l2"][..], "reconstruction=l2"),
        (&["--integrator=gdpt"], "reconstruction=l1"),
        (&["--integrator=vpl", "--light-paths=3", "--clamp=0.5"], "light_paths=3 clamp=0.5"),
        (&["--integrator=mlt", "--chained-direct"], "chained_direct"),
        (&["--integrator=mlt", "--mutations=caustic,lens"], "mutations=lens,caustic"),
        (&["--target-error=9", "--adaptive"], "target_error=9 adaptive"),
        (&["--mitsuba3-roughplastic"], "mitsuba3_roughplastic"),
    ] {
        let exr = directory.rendered("settings.exr", options);
        let expected = format!("max_depth=4 rr_depth=5 {settings}");
        assert_eq!(exr.attributes["settings"], Attribute::Text(expected));
    }
}

/// Interrupts a render that would take hours, after a while.
#[cfg(unix)]
fn interrupted(directory: &Directory, after: Duration) -> Output {
    let options = ["ball.xml", "--spp", "2000000000"];
    let child: Child = directory.render(&options).spawn().unwrap();
    std::thread::sleep(after);
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
    child.wait_with_output().unwrap()
}

#[cfg(unix)]
#[test]
fn ctrl_c_keeps_what_has_been_rendered() {
    let directory = Directory::new("interrupt");
    // On a busy machine the program may not have begun: then once more, with more patience.
    let run = [300, 1000, 4000, 16_000]
        .map(Duration::from_millis)
        .into_iter()
        .map(|after| interrupted(&directory, after))
        .find(|_| directory.path("ball.exr").exists());
    let run = run.expect("an image after sixteen seconds");
    assert_eq!(run.status.code(), Some(130), "{}", message(&run));
    let exr = Exr::read(&directory.path("ball.exr")).unwrap();
    assert!(samples(&exr) >= 1);
    assert!(exr.rgb.pixels().iter().any(|p| p[0] > 0.0));
    assert!(directory.path("ball.png").exists());
}

/// Interrupts a render that would take hours, once it has kept its state and something else has been done.
#[cfg(unix)]
fn interrupted_when(directory: &Directory, mut render: Command, done: impl FnOnce()) -> Child {
    render.args(["--checkpoint", "state", "--checkpoint-every", "0.05"]);
    let mut child = render.spawn().unwrap();
    while !directory.path("state").exists() {
        assert!(child.try_wait().unwrap().is_none(), "it has ended");
        std::thread::sleep(Duration::from_millis(1));
    }
    done();
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
    child
}

#[cfg(unix)]
#[test]
fn an_image_that_has_no_place_any_more_is_saved_elsewhere() {
    let directory = Directory::new("elsewhere");
    for integrator in ["path", "gdpt"] {
        let _ = std::fs::remove_file(directory.path("state"));
        std::fs::create_dir_all(directory.path("gone")).unwrap();
        std::fs::create_dir_all(directory.path("saved")).unwrap();
        let options =
            ["ball.xml", "--time", "10000", "-o", "gone/a.exr", "--integrator", integrator];
        let mut render = directory.render(&options);
        render.env("TMPDIR", directory.path("saved"));
        let remove = || std::fs::remove_dir_all(directory.path("gone")).unwrap();
        let child = interrupted_when(&directory, render, remove);
        let run = child.wait_with_output().unwrap();
        let text = message(&run);
        assert_eq!(run.status.code(), Some(2), "{text}");
        assert!(text.contains("error: cannot write `gone/a.exr`: "), "{text}");
        let place = text.split("; the image is in `").nth(1).expect("a place").split('`').next();
        let exr = Exr::read(Path::new(place.unwrap())).unwrap();
        assert_eq!(exr.attributes["integrator"], Attribute::Text(integrator.to_owned()));
        assert!(exr.rgb.pixels().iter().any(|p| p[0] > 0.0));
        std::fs::remove_dir_all(directory.path("saved")).unwrap();
    }
}

#[cfg(unix)]
#[test]
fn an_image_is_written_before_its_albedo_is_found() {
    let directory = Directory::new("aovs");
    let options = ["ball.xml", "--time", "10000", "--aovs", "--threads", "1", "--max-depth", "1"];
    let render = directory.render(&[&options[..], &["--size", "1200x800"]].concat());
    let mut child = interrupted_when(&directory, render, || ());
    // What a second Ctrl-C would leave.
    let output = directory.path("ball.exr");
    let first = loop {
        if let Ok(first) = std::fs::read(&output) {
            break first;
        }
        assert!(child.try_wait().unwrap().is_none(), "it has ended");
        std::thread::sleep(Duration::from_millis(1));
    };
    let run = child.wait_with_output().unwrap();
    assert_eq!(run.status.code(), Some(130), "{}", message(&run));
    let exr = Exr::read(&output).unwrap();
    assert!(["albedo", "normal", "depth"].iter().all(|name| exr.layers.contains_key(*name)));
    std::fs::write(directory.path("first.exr"), first).unwrap();
    let first = Exr::read(&directory.path("first.exr")).unwrap();
    assert!(first.layers.is_empty() && first.rgb == exr.rgb);
    assert_eq!(first.attributes, exr.attributes);
}

/// What a render leaves that does not depend on the clock.
fn lasting(exr: Exr) -> Exr {
    let mut attributes = exr.attributes;
    attributes.remove("seconds");
    Exr { attributes, ..exr }
}

/// Kills a render as soon as there is a checkpoint; false if it has ended before.
#[cfg(unix)]
fn killed(mut render: Command, checkpoint: &Path) -> bool {
    use std::os::unix::process::ExitStatusExt;
    let mut child = render.spawn().unwrap();
    while !checkpoint.exists() && child.try_wait().unwrap().is_none() {
        std::thread::sleep(Duration::from_millis(1));
    }
    // SIGKILL, which no program can answer.
    child.kill().unwrap();
    child.wait().unwrap().signal() == Some(9)
}

/// One integrator of each sort: pixels, splats, passes that are prepared, chains of both sorts.
#[cfg(unix)]
#[test]
fn a_render_that_is_killed_goes_on_to_the_same_image() {
    let directory = Directory::new("checkpoint");
    let runs =
        [("path", "2000"), ("bdpt", "250"), ("ppm", "60"), ("mlt", "100"), ("pssmlt", "200")];
    for (integrator, spp) in runs {
        let options = ["--integrator", integrator, "--spp", spp, "--threads", "2"];
        let expected = directory.rendered("whole.exr", &options);
        let more = ["--checkpoint", integrator, "--checkpoint-every", "0.01"];
        let options = [&options[..], &more].concat();
        let checkpoint = directory.path(integrator);
        let output = directory.path("killed.exr");
        // One that has ended before, with its image, tells nothing.
        let was_killed = (0..5).any(|_| {
            for file in [&checkpoint, &output] {
                let _ = std::fs::remove_file(file);
            }
            let arguments = [&["ball.xml", "-o", "killed.exr"], &options[..]].concat();
            killed(directory.render(&arguments), &checkpoint) && !output.exists()
        });
        assert!(was_killed, "{integrator}");
        let resumed = directory.rendered("resumed.exr", &options);
        let (mut expected, mut resumed) = (lasting(expected), lasting(resumed));
        if integrator == "ppm" {
            // The photons of the pass that was under way are shot again.
            for exr in [&mut expected, &mut resumed] {
                exr.attributes.retain(|name, _| name != "rays" && name != "densities");
            }
        }
        assert!(expected == resumed, "{integrator}");
        // What has ended has nothing to add, and more samples can follow.
        let again = directory.rendered("again.exr", &options);
        assert!(lasting(again).rgb == expected.rgb, "{integrator}");
    }
}

/// The bytes of an EXR file but for the seconds that it took.
fn timeless(path: &Path) -> Vec<u8> {
    let mut bytes = std::fs::read(path).unwrap();
    let name = b"seconds\0double\0\x08\0\0\0";
    let at = bytes.windows(name.len()).position(|part| part == name).expect("an attribute");
    bytes[at + name.len()..][..8].fill(0);
    bytes
}

#[test]
fn files_are_equal_byte_by_byte() {
    let directory = Directory::new("bytes");
    directory.rendered("whole.exr", &["--spp", "8"]);
    let whole = timeless(&directory.path("whole.exr"));
    for samples in ["3", "8"] {
        directory.rendered("parts.exr", &["--spp", samples, "--checkpoint", "state"]);
    }
    assert!(timeless(&directory.path("parts.exr")) == whole);
    let pictures =
        ["whole.png", "parts.png"].map(|name| std::fs::read(directory.path(name)).unwrap());
    assert!(pictures[0] == pictures[1]);
}

#[test]
fn two_renders_do_not_share_a_checkpoint() {
    let directory = Directory::new("shared");
    let render = |spp: &str| {
        directory.render(&[
            "ball.xml",
            "--spp",
            spp,
            "--checkpoint",
            "state",
            "--checkpoint-every",
            "0.01",
        ])
    };
    let mut first = render("2000000000").spawn().unwrap();
    while !directory.path("state").exists() && first.try_wait().unwrap().is_none() {
        std::thread::sleep(Duration::from_millis(1));
    }
    let second = render("4").output().unwrap();
    first.kill().unwrap();
    first.wait().unwrap();
    assert_eq!(second.status.code(), Some(2));
    let text = message(&second);
    assert!(text.contains("`state`: another process renders"), "{text}");
    // What was killed holds no lock.
    let third = render("1").output().unwrap();
    assert_eq!(third.status.code(), Some(0), "{}", message(&third));
    assert!(!directory.path("state.lock").exists());
}

#[test]
fn a_sampler_takes_the_place_of_the_scenes() {
    let directory = Directory::new("sampler");
    let independent = directory.rendered("independent.exr", &[]);
    let sobol = directory.rendered("sobol.exr", &["--sampler", "ldsampler"]);
    assert_eq!(sobol.attributes["sampler"], Attribute::Text("ldsampler".to_owned()));
    assert!(sobol.rgb != independent.rgb);
    // As if the scene asked for it.
    let scene = std::fs::read_to_string(directory.path("ball.xml")).unwrap();
    let scene = scene.replace("\"independent\"", "\"ldsampler\"");
    assert!(scene.contains("ldsampler"));
    std::fs::write(directory.path("ball.xml"), scene).unwrap();
    assert!(sobol.rgb == directory.rendered("scenes.exr", &[]).rgb);
    let other = directory.rendered("other.exr", &["--sampler", "independent"]);
    assert!(independent.rgb == other.rgb);
}

#[test]
fn a_checkpoint_takes_the_place_of_no_other_file_of_the_render() {
    let directory = Directory::new("one-file");
    let link = directory.path("link");
    std::fs::create_dir(&link).unwrap();
    let fails = |options: &[&str], reason: &str| {
        let run = directory.render(&[&["ball.xml"], options].concat()).output().unwrap();
        assert_eq!(run.status.code(), Some(2), "{options:?}");
        let text = message(&run);
        let expected = format!(": {reason}; name another file with --checkpoint");
        assert!(text.starts_with("error: ") && text.contains(&expected), "{options:?}: {text}");
    };
    let image = "the render writes an image to it";
    fails(&["--checkpoint", "ball.exr"], image);
    fails(&["--checkpoint", "link/../ball.png"], image);
    fails(&["-o", "link/a.exr", "--checkpoint", "./link/a.exr"], image);
    fails(&["--integrator", "gdpt", "--checkpoint", "ball-primal.exr"], image);
    fails(&["--technique-images", "--checkpoint", "ball-techniques.png"], image);
    fails(&["--checkpoint", "ball.xml"], "the scene is read from it");
    assert_eq!(std::fs::read_to_string(directory.path("ball.xml")).unwrap(), SCENE);
    assert!(!directory.path("ball.exr").exists());
}

#[test]
fn a_checkpoint_of_something_else_is_refused() {
    let directory = Directory::new("foreign");
    let options = ["--spp", "4", "--checkpoint", "state"];
    directory.rendered("four.exr", &options);
    let kept = std::fs::read(directory.path("state")).unwrap();
    // More samples follow those that are there.
    let eight = directory.rendered("eight.exr", &["--spp", "8", "--checkpoint", "state"]);
    assert!(lasting(eight) == lasting(directory.rendered("whole.exr", &["--spp", "8"])));
    let refused = |state: &[u8], more: &[&str], expected: &str| {
        std::fs::write(directory.path("state"), state).unwrap();
        let arguments = [&["ball.xml", "-o", "no.exr"], &options[..], more].concat();
        let run = directory.render(&arguments).output().unwrap();
        let text = message(&run);
        assert_eq!(run.status.code(), Some(2), "{text}");
        assert!(text.starts_with("error: ") && text.contains("`state`"), "{text}");
        assert!(text.contains(expected), "`{expected}` in {text}");
        assert_eq!(std::fs::read(directory.path("state")).unwrap(), state);
    };
    refused(&kept, &["--seed", "5"], "its seed is `0`, and that of this render `5`");
    refused(&kept, &["--integrator", "bdpt"], "integrator");
    refused(&kept, &["--sampler", "ldsampler"], "its sampler is `independent`");
    refused(&kept, &["--size", "8x8"], "its size is `24x16`");
    refused(&kept, &["--technique-images"], "technique images");
    refused(&kept, &["-D", "grey=0.6"], "its -D grey is nothing, and that of this render `0.6`");
    refused(b"<scene/>", &[], "no checkpoint");
    refused(&kept[..kept.len() / 2], &[], "cut short");
    let with = |at: usize, byte: u8| {
        let mut bytes = kept.clone();
        bytes[at] = byte;
        bytes
    };
    refused(&with(16, 99), &[], "version 99 of the format");
    let at = kept.len() - 100;
    refused(&with(at, !kept[at]), &[], "damaged");
    std::fs::write(directory.path("ball.xml"), SCENE.replace("value=\"20\"", "value=\"21\""))
        .unwrap();
    refused(&kept, &[], "its file 1 is `ball.xml, ");
}

#[test]
fn a_parameter_that_is_the_number_of_samples_may_grow() {
    let directory = Directory::new("more-samples");
    let kept = ["-D", "grey=0.6", "--checkpoint", "state"];
    directory.rendered("four.exr", &[&kept[..], &["-D", "spp=4"]].concat());
    let eight = directory.rendered("eight.exr", &[&kept[..], &["-D", "spp=8"]].concat());
    let whole = directory.rendered("whole.exr", &["-D", "grey=0.6", "--spp", "8"]);
    assert_eq!((samples(&eight), &eight.rgb), (8, &whole.rgb));
    // As an option may, and for another reason than the number of samples not.
    let option = directory.rendered("option.exr", &[&kept[..], &["--spp", "10"]].concat());
    assert_eq!(samples(&option), 10);
    let both = SCENE.replace(r#"value="20""#, r#"value="$spp""#);
    std::fs::write(directory.path("ball.xml"), both).unwrap();
    let options = ["ball.xml", "--checkpoint", "other", "-D"];
    let first = directory.render(&[&options[..], &["spp=4"]].concat()).output().unwrap();
    assert_eq!(first.status.code(), Some(0), "{}", message(&first));
    let second = directory.render(&[&options[..], &["spp=8"]].concat()).output().unwrap();
    assert_eq!(second.status.code(), Some(2));
    assert!(message(&second).contains("its -D spp is `4`"), "{}", message(&second));
}

#[test]
fn what_techniques_contribute_adds_up_to_the_image() {
    let directory = Directory::new("techniques");
    let names = ["path", "gdpt", "vpl", "ppm", "vcm", "ptracer", "mlt", "pssmlt", "bdpt"];
    let [.., exr] = names.map(|name| {
        let options = ["--integrator", name, "--technique-images", "5", "--aovs", "--spp", "8"];
        // Hardly a photon of a few comes next to what is seen.
        let light_paths = if name == "ppm" { "4096" } else { "64" };
        let more = ["--reconstruction", "none", "--light-paths", light_paths];
        let exr = directory.rendered(&format!("{name}.exr"), &[&options[..], &more].concat());
        assert!(directory.path(&format!("{name}-techniques.png")).is_file(), "{name}");
        // All lengths of paths that the scene asks for are shown.
        for (pixel, value) in exr.rgb.pixels().iter().enumerate() {
            let layers = exr.layers.iter().filter(|(name, _)| name.starts_with("weighted."));
            let weighted: f32 = layers.map(|(_, image)| image.pixels()[pixel][1]).sum();
            let off = (weighted - value[1]).abs();
            assert!(off <= 2e-5 * value[1].max(1.0), "{name}: {weighted} {value:?}");
        }
        exr
    });
    // The lamp and the ball: light that is seen directly, and techniques alone that agree on it.
    let mean = |name: &str| {
        let pixels = exr.layers[name].pixels();
        pixels.iter().map(|p| f64::from(p[1])).sum::<f64>() / pixels.len() as f64
    };
    let [scattered, direct, light] = ["alone.s0t3", "alone.s1t2", "alone.s2t1"].map(mean);
    assert!(direct > 0.0 && (light / direct - 1.0).abs() < 0.2, "{scattered} {direct} {light}");
    let centre = 8 * 24 + 12;
    assert!((exr.layers["depth"].pixels()[centre][0] - 4.0).abs() < 0.05);
    assert!((exr.layers["albedo"].pixels()[centre][0] - 0.5).abs() < 1e-6);
    assert!(exr.layers["normal"].pixels()[centre][2] > 0.97);
}

#[test]
fn what_a_scene_is_read_from_is_not_overwritten() {
    let directory = Directory::new("inputs");
    let light = directory.rendered("sky.exr", &[]);
    let sky = SCENE.replace(
        "</scene>",
        r#"<emitter type="envmap"><string name="filename" value="sky.exr"/></emitter></scene>"#,
    );
    std::fs::write(directory.path("sky.xml"), sky).unwrap();
    let run = directory.render(&["sky.xml"]).output().unwrap();
    assert_eq!(run.status.code(), Some(2));
    let text = message(&run);
    assert!(text.contains("read from `sky.exr`") && text.contains("-o"), "{text}");
    assert_eq!(Exr::read(&directory.path("sky.exr")).unwrap().rgb, light.rgb);
    let elsewhere = directory.render(&["sky.xml", "-o", "other.exr"]).output().unwrap();
    assert_eq!(elsewhere.status.code(), Some(0), "{}", message(&elsewhere));
}

#[test]
fn a_lock_takes_the_place_of_no_other_file() {
    let directory = Directory::new("lock");
    std::fs::write(directory.path("state.lock"), "kept").unwrap();
    let run = directory.render(&["ball.xml", "--checkpoint", "state"]).output().unwrap();
    assert_eq!(run.status.code(), Some(2));
    assert!(message(&run).contains("`state.lock`, which is another file"), "{}", message(&run));
    assert_eq!(std::fs::read_to_string(directory.path("state.lock")).unwrap(), "kept");
}

#[test]
fn options_of_other_integrators_are_pointed_out() {
    let directory = Directory::new("idle");
    let warnings = |options: &[&str]| {
        let run = directory.render(&[&["ball.xml"], options].concat()).output().unwrap();
        assert_eq!(run.status.code(), Some(0), "{}", message(&run));
        message(&run).lines().filter(|line| line.contains("does nothing")).count()
    };
    assert_eq!(warnings(&["--clamp", "2", "--reconstruction", "l2"]), 2);
    assert_eq!(warnings(&["--integrator", "mlt", "--sampler", "ldsampler"]), 1);
    assert_eq!(warnings(&["--integrator", "vpl", "--clamp", "2", "--light-paths", "3"]), 0);
}

/// A glass ball in front of a wall, under a lamp of any brightness.
const LAMP: &str = r#"<scene version="3.0.0">
    <default name="radiance" value="20"/>
    <default name="filter" value="box"/>
    <integrator type="path"><integer name="max_depth" value="6"/></integrator>
    <sensor type="perspective"><float name="fov" value="45"/>
        <transform name="to_world"><lookat origin="0,0,5" target="0,0,0" up="0,1,0"/></transform>
        <film type="hdrfilm"><integer name="width" value="24"/><integer name="height" value="16"/>
            <rfilter type="$filter"/></film>
    </sensor>
    <shape type="sphere"><bsdf type="dielectric"/></shape>
    <shape type="rectangle">
        <transform name="to_world"><scale value="4"/><translate z="-2"/></transform>
        <bsdf type="diffuse"><rgb name="reflectance" value="0.5 0.3 0.1"/></bsdf>
    </shape>
    <shape type="sphere">
        <point name="center" x="1" y="3" z="2"/><float name="radius" value="0.5"/>
        <emitter type="area"><rgb name="radiance" value="$radiance"/></emitter>
    </shape>
</scene>"#;

#[test]
fn dim_and_bright_scenes_look_alike() {
    let directory = Directory::new("brightness");
    std::fs::write(directory.path("lamp.xml"), LAMP).unwrap();
    let image = |options: &[&str], exponent: i32| {
        let radiance = format!("radiance={:e}", 2f64.powi(exponent - 4));
        let name = format!("lamp{exponent}.exr");
        let fixed = ["lamp.xml", "-o", &name, "--spp", "4", "-D", &radiance];
        let run = directory.render(&[&fixed[..], options].concat()).output().unwrap();
        assert_eq!((run.status.code(), message(&run).as_str()), (Some(0), ""), "{options:?}");
        Exr::read(&directory.path(&name)).unwrap()
    };
    let integrators: [&[&str]; 7] = [
        &["--integrator", "path", "-D", "filter=gaussian"],
        &["--integrator", "path", "-D", "filter=mitchell"],
        &["--integrator", "bdpt", "-D", "filter=gaussian", "--technique-images", "4"],
        &["--integrator", "ptracer"],
        &["--integrator", "vcm"],
        &["--integrator", "mlt"],
        &["--integrator", "pssmlt"],
    ];
    for options in integrators {
        let usual = image(options, 0);
        for exponent in [-60, 60] {
            let (other, scale) = (image(options, exponent), 2f32.powi(exponent));
            let unscaled = |image: &RgbImage| -> Vec<[f32; 3]> {
                image.pixels().iter().map(|pixel| pixel.map(|v| v / scale)).collect()
            };
            assert!(unscaled(&other.rgb) == usual.rgb.pixels(), "{options:?}, 2^{exponent}");
            assert!(other.layers.keys().eq(usual.layers.keys()), "{options:?}, 2^{exponent}");
            for (name, image) in &other.layers {
                assert!(unscaled(image) == usual.layers[name].pixels(), "{name}, 2^{exponent}");
            }
        }
    }
}
