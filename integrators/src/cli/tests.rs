//! From a scene and a command line to a plan, and what is refused and warned of.

use clap::Parser;

use super::arguments::RenderArguments;
use super::kernel::algorithm_for;
use super::plan::{Plan, load};
use super::warnings::loses_light;
use super::{Arguments, Command};
use crate::scene::{SamplerKind, Scene};

const SCENE: &str = r#"<scene version="3.0.0">
    <integrator type="path"><integer name="max_depth" value="7"/></integrator>
    <sensor type="perspective">
        <float name="fov" value="40"/>
        <film type="hdrfilm">
            <integer name="width" value="80"/><integer name="height" value="60"/>
        </film>
        <sampler type="independent"><integer name="sample_count" value="9"/></sampler>
    </sensor>
    <shape type="sphere"><bsdf type="diffuse"/></shape>
</scene>"#;

/// What a command line of `aether render` asks for.
pub(super) fn parsed(line: &[&str]) -> RenderArguments {
    let line = ["aether", "render"].iter().chain(line);
    match Arguments::parse_from(line).command {
        Command::Render(arguments) => *arguments,
        other => panic!("{other:?}"),
    }
}

fn arguments(line: &[&str]) -> RenderArguments {
    parsed(&[&["scene.xml"], line].concat())
}

fn scene() -> Scene {
    Scene::from_str(SCENE, std::path::Path::new("."), &[]).unwrap()
}

#[test]
fn the_scene_decides_what_the_command_line_leaves_open() {
    let plan = Plan::new(&scene(), &arguments(&[]));
    assert_eq!((plan.integrator.as_str(), plan.size), ("path", (80, 60)));
    assert_eq!((plan.samples, plan.seed, plan.max_depth), (9, 0, Some(7)));
}

#[test]
fn the_command_line_wins() {
    let line = ["--integrator", "bdpt", "--spp", "3", "--seed", "5", "--max-depth", "-1"];
    let plan = Plan::new(&scene(), &arguments(&line));
    assert_eq!((plan.integrator.as_str(), plan.samples), ("bdpt", 3));
    assert_eq!((plan.seed, plan.max_depth), (5, None));
    assert_eq!(plan.sampler, SamplerKind::Independent);
    let plan = Plan::new(&scene(), &arguments(&["--sampler", "multijitter"]));
    assert_eq!(plan.sampler, SamplerKind::Multijitter);
    let plan = Plan::new(&scene(), &arguments(&["--max-depth", "0"]));
    assert_eq!(plan.max_depth, Some(0));
}

#[test]
fn light_tracing_alone_loses_light_where_normals_of_glass_are_flipped() {
    let loses = |bsdf: &str, line: &[&str]| {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
        let xml = SCENE.replace(r#"<bsdf type="diffuse"/>"#, bsdf);
        let textures = folder.join("../tests/scenes/textures");
        let scene = Scene::from_str(&xml, &textures, &[]).unwrap();
        loses_light(&scene, &Plan::new(&scene, &arguments(line)))
    };
    let bumped = |flip: &str, nested: &str| {
        format!(
            r#"<bsdf type="mask"><float name="opacity" value="0.5"/><bsdf type="normalmap">{flip}
            <texture name="normalmap" type="bitmap"><string name="filename" value="normals.png"/>
            <boolean name="raw" value="true"/></texture><bsdf type="{nested}"/></bsdf></bsdf>"#
        )
    };
    let (light, glass) = (["--integrator", "ptracer"], bumped("", "dielectric"));
    assert!(loses(&glass, &light));
    assert!(loses(&glass, &["--integrator", "bdpt", "--techniques", "*:1"]));
    assert!(!loses(&glass, &["--integrator", "bdpt", "--techniques", "*:1,0:*"]));
    assert!(!loses(&glass, &["--integrator", "bdpt"]));
    assert!(!loses(&bumped("", "diffuse"), &light));
    let flip = r#"<boolean name="flip_invalid_normals" value="false"/>"#;
    assert!(!loses(&bumped(flip, "dielectric"), &light));
    assert!(!loses(r#"<bsdf type="dielectric"/>"#, &light));
}

#[test]
fn light_paths_that_memory_has_no_room_for_are_refused() {
    let of = |integrator: &str, line: &[&str]| {
        let line = [&["--integrator", integrator], line].concat();
        let plan = Plan::new(&scene(), &arguments(&line));
        algorithm_for(&scene(), &plan).map(|_| ()).map_err(|failure| failure.to_string())
    };
    let with = |line: &[&str]| of("vpl", line);
    // Seven edges are eight vertices, of which the eye is not one of the light path: some hundred bytes each.
    let message = with(&["--light-paths", "16777216"]).unwrap_err();
    assert!(
        message.starts_with("16777216 light paths of integrator `vpl` may take 1"),
        "{message}"
    );
    assert!(message.contains(" GB; ask for fewer, `--light-paths "), "{message}");
    // What it says fits does, and shorter ones do.
    let fewer = message.split('`').nth(3).expect("a remedy");
    assert_eq!(with(&fewer.split(' ').collect::<Vec<_>>()), Ok(()), "{message}");
    assert_eq!(with(&["--light-paths", "16777216", "--max-depth", "2"]), Ok(()));
    // Paths of any length have one all the same.
    assert!(with(&["--light-paths", "16777216", "--max-depth", "-1"]).is_err());
    assert_eq!(with(&["--light-paths", "1000000", "--max-depth", "-1"]), Ok(()));
    // Seven photons of 52 bytes each are 6.1 GB, and twice that while they are sorted.
    let message = of("ppm", &["--light-paths", "16777216"]).unwrap_err();
    assert!(message.starts_with("16777216 light paths of integrator `ppm` may"), "{message}");
    let fewer = message.split('`').nth(3).expect("a remedy");
    assert_eq!(of("ppm", &fewer.split(' ').collect::<Vec<_>>()), Ok(()), "{message}");
    assert!(of("ppm", &["--light-paths", "16777216", "--max-depth", "-1"]).is_err());
    assert_eq!(of("ppm", &["--light-paths", "4000000"]), Ok(()));
    assert_eq!(of("ppm", &[]), Ok(()));
}

#[test]
fn images_whose_light_paths_memory_has_no_room_for_are_refused() {
    let of = |integrator: &str, (width, height): (u32, u32), line: &[&str]| {
        let line = [&["--integrator", integrator], line].concat();
        let plan = Plan { size: (width, height), ..Plan::new(&scene(), &arguments(&line)) };
        algorithm_for(&scene(), &plan).map(|_| ()).map_err(|failure| failure.to_string())
    };
    let large = (16_384, 8192);
    for integrator in ["vcm", "ppm"] {
        let message = of(integrator, large, &[]).unwrap_err();
        let beginning = format!("134217728 light paths of integrator `{integrator}` may take ");
        assert!(message.starts_with(&beginning), "{message}");
        assert!(of(integrator, (1920, 1080), &["--max-depth", "-1"]).is_ok());
        assert!(of(integrator, large, &["--max-depth", "-1"]).is_err());
    }
    let message = of("vcm", large, &[]).unwrap_err();
    assert!(message.contains(" GB; one for each pixel: ask for a smaller image, `--size "));
    // What it says fits does.
    let fitting = message.split('`').nth(3).expect("a remedy");
    let size = fitting.trim_start_matches("--size ").split_once('x').expect("a size");
    let size = (size.0.parse().expect("columns"), size.1.parse().expect("rows"));
    assert_eq!(of("vcm", size, &[]), Ok(()), "{message}");
    let message = of("ppm", large, &[]).unwrap_err();
    let fewer = message.split('`').nth(3).expect("a remedy");
    assert_eq!(of("ppm", large, &fewer.split(' ').collect::<Vec<_>>()), Ok(()), "{message}");
}

#[test]
fn a_size_takes_the_place_of_the_films() {
    let file = std::env::temp_dir().join(format!("aether-size-{}.xml", std::process::id()));
    std::fs::write(&file, SCENE).unwrap();
    let arguments = parsed(&[file.to_str().unwrap(), "--size", "50x100"]);
    let scene = load(&arguments);
    std::fs::remove_file(&file).unwrap();
    let scene = scene.unwrap();
    assert_eq!((scene.film.width, scene.camera.height), (50, 100));
    // The field of view lies along x and stays; the other one follows the proportions.
    assert!((scene.camera.tan_x - 20f32.to_radians().tan()).abs() < 1e-6);
    assert!((scene.camera.tan_y / scene.camera.tan_x - 2.0).abs() < 1e-6);
}
