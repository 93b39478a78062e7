//! From a scene file and the command line to something that can be rendered.

use aether_core::uniform::MOST_PIECES;

use super::arguments::{RenderArguments, check_size};
use super::{Failure, warn};
use crate::algorithm::Algorithm;
use crate::bidirectional::Bidirectional;
use crate::gradient_domain::GradientDomain;
use crate::instant_radiosity::InstantRadiosity;
use crate::kind;
use crate::light_tracer::LightTracer;
use crate::metropolis::{Metropolis, MutationSet};
use crate::path::PathSettings;
use crate::photon_mapping::PhotonMapping;
use crate::poisson::Reconstruction;
use crate::portals::Portals;
use crate::primary_sample::PrimarySample;
use crate::render::AnyKernel;
use crate::scene::{Bsdf, Overrides, Sampler, SamplerKind, Scene, Shape};
use crate::selection::Selection;
use crate::tridirectional::Tridirectional;
use crate::vertex_merging::VertexMerging;

/// What an integrator is asked for: the scene's settings, overridden by the command line.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Plan {
    /// The name of the integrator.
    pub integrator: String,
    /// Columns and rows of the image.
    pub size: (u32, u32),
    /// The first column and row of the image on the film that the scene describes.
    pub crop: (u32, u32),
    /// Samples per pixel, unless a time is given.
    pub samples: u32,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Where the uniforms come from, for integrators that do not make chains or passes of them.
    pub sampler: SamplerKind,
    /// The longest path in edges as Mitsuba counts them, or `None` for any length.
    pub max_depth: Option<u32>,
    /// The path length from which Russian roulette may end a path.
    pub rr_depth: u32,
    /// The kind of scenes that the renderer is compiled for.
    pub kind: String,
    /// Which techniques are used.
    pub techniques: Selection,
    /// How many light paths the pixels share, for integrators where they do.
    pub light_paths: Option<u32>,
    /// What the geometry term of a connection is at most, for instant radiosity.
    pub clamp: Option<f32>,
    /// Which mutations are used, for Metropolis light transport.
    pub mutations: MutationSet,
    /// Whether Markov chains leave direct light to path tracing.
    pub separate_direct: bool,
    /// How an image is made of its gradients, for integrators that have them.
    pub reconstruction: Reconstruction,
    /// Whether the camera does not see lights.
    pub hide_emitters: bool,
    /// The parameters that say nothing but how many samples there are.
    pub sample_parameters: Vec<String>,
}

impl Plan {
    /// The name of where uniforms come from, for the record.
    pub fn sampler_name(&self) -> &'static str {
        let is_own = OWN_UNIFORMS.contains(&self.integrator.as_str());
        if is_own { "of the integrator" } else { self.sampler.name() }
    }

    /// The settings of a scene with those of the command line in their place.
    pub fn new(scene: &Scene, arguments: &RenderArguments) -> Self {
        let requested = &scene.integrator;
        Self {
            integrator: arguments.integrator.clone().unwrap_or_else(|| requested.name.clone()),
            size: (scene.film.width, scene.film.height),
            // Whole numbers of pixels.
            crop: (scene.camera.crop.x as u32, scene.camera.crop.y as u32),
            samples: arguments.spp.unwrap_or(scene.sampler.sample_count),
            seed: arguments.seed.unwrap_or(scene.sampler.seed),
            sampler: arguments.sampler.unwrap_or(scene.sampler.kind),
            // -1 has no counterpart in u32: no limit.
            max_depth: arguments.max_depth.map_or(requested.max_depth, |d| u32::try_from(d).ok()),
            rr_depth: requested.rr_depth,
            kind: arguments.kind.clone().unwrap_or_else(|| kind::smallest(scene).to_owned()),
            techniques: arguments.techniques.unwrap_or_default(),
            light_paths: arguments.light_paths,
            clamp: arguments.clamp,
            mutations: arguments.mutations.unwrap_or_default(),
            separate_direct: !arguments.chained_direct,
            reconstruction: arguments.reconstruction.unwrap_or_default(),
            hide_emitters: requested.hide_emitters,
            sample_parameters: scene.sample_parameters.clone(),
        }
    }
}

/// Reads the scene file that the command line names, with the size that it asks for.
pub(super) fn load(arguments: &RenderArguments) -> Result<Scene, Failure> {
    let overrides = Overrides { size: arguments.size, portals: arguments.portals.clone() };
    let mut scene = Scene::load_with(&arguments.scene, &arguments.defines, &overrides)?;
    warn_of(&scene);
    check_size((scene.film.width, scene.film.height))
        .map_err(|error| Failure::new(format!("image size {error}")))?;
    if arguments.mitsuba3_roughplastic {
        scene.bsdfs.iter_mut().for_each(Bsdf::lose_energy);
    }
    Ok(scene)
}

/// Prints what is strange about a scene file.
pub(super) fn warn_of(scene: &Scene) {
    for warning in &scene.warnings {
        warn(&format!("warning: {warning}"));
    }
}

/// Warns if the command line takes the place of an integrator that does not exist here.
pub(super) fn warn_of_integrator(scene: &Scene, plan: &Plan) {
    let wanted = &scene.integrator;
    if wanted.name != plan.integrator && !INTEGRATORS.contains(&wanted.name.as_str()) {
        let message = format!("not supported; \"{}\" takes its place", plan.integrator);
        match &wanted.place {
            Some(place) => warn(&format!("warning: {}", place.error(message))),
            None => warn(&format!("warning: integrator `{}`: {message}", wanted.name)),
        }
    }
}

/// Warns of light that light tracing by itself does not find.
pub(super) fn warn_of_lost_light(scene: &Scene, plan: &Plan) {
    if loses_light(scene, plan) {
        warn(
            "warning: light tracing alone loses light at a `bumpmap` or `normalmap` around what transmits, whose normals \
             are flipped for the viewer and not for the light; use another integrator, or give the material \
             <boolean name=\"flip_invalid_normals\" value=\"false\"/>",
        );
    }
}

fn loses_light(scene: &Scene, plan: &Plan) -> bool {
    let from_lights = plan.integrator == "ptracer" || plan.techniques.is_light_tracing();
    let flips = |shape: &Shape| scene.bsdfs[shape.bsdf as usize].flips_transmitting();
    from_lights && scene.shapes.iter().any(flips)
}

/// Warns of options of other integrators than the one that renders.
pub(super) fn warn_of_idle_options(plan: &Plan, arguments: &RenderArguments) {
    let given: [(&str, bool, &[&str]); 5] = [
        ("--light-paths", arguments.light_paths.is_some(), &["bdpt", "vpl", "ppm"]),
        ("--clamp", arguments.clamp.is_some(), &["vpl"]),
        ("--mutations", arguments.mutations.is_some(), &["mlt"]),
        ("--chained-direct", arguments.chained_direct, &["mlt", "pssmlt"]),
        ("--reconstruction", arguments.reconstruction.is_some(), &["gdpt"]),
    ];
    let name = plan.integrator.as_str();
    for (option, is_given, integrators) in given {
        if is_given && !integrators.contains(&name) {
            let those = integrators.join(", ");
            warn(&format!("warning: {option} does nothing for `{name}`; it is of {those}"));
        }
    }
    if arguments.sampler.is_some() && OWN_UNIFORMS.contains(&name) {
        warn(&format!(
            "warning: --sampler does nothing for `{name}`, which has uniforms of its own"
        ));
    }
}

/// The integrators that make chains or passes of their uniforms.
const OWN_UNIFORMS: [&str; 4] = ["mlt", "pssmlt", "ppm", "vcm"];

/// The integrator called `plan.integrator` with the settings of `plan`.
pub(super) fn kernel_for<'a>(
    scene: &'a Scene,
    plan: &Plan,
) -> Result<Box<dyn AnyKernel + 'a>, Failure> {
    let sampler = Sampler { kind: plan.sampler, seed: plan.seed, ..scene.sampler };
    match algorithm_for(scene, plan)?.kernel(&plan.kind, scene, sampler) {
        Some(kernel) => kernel.map_err(|error| Failure::new(error.to_string())),
        None => Err(Failure::new(format!("there is no kind `{}`", plan.kind))),
    }
}

/// The algorithm called `plan.integrator` with the settings of `plan`, not yet prepared for a scene.
pub(super) fn algorithm_for(scene: &Scene, plan: &Plan) -> Result<Algorithm, Failure> {
    let techniques = plan.techniques;
    let path = PathSettings { max_depth: plan.max_depth, techniques, ..PathSettings::new(scene) };
    let bidirectional = Bidirectional::new(path);
    let pixels = u64::from(plan.size.0) * u64::from(plan.size.1);
    let fewer_paths = |fitting| format!("ask for fewer, `--light-paths {fitting}`");
    let algorithm = match plan.integrator.as_str() {
        "path" => Algorithm::Path(path),
        "ptracer" => Algorithm::LightTracer(LightTracer { path }),
        "bdpt" => {
            let light_paths = plan.light_paths.unwrap_or(1);
            if light_paths > MOST_PIECES {
                let message = "--light-paths of integrator `bdpt`: a sample takes at most";
                return Err(Failure::new(format!("{message} {MOST_PIECES}")));
            }
            Algorithm::Bidirectional(Bidirectional { light_paths, ..bidirectional })
        }
        "vpl" => {
            let light_paths = plan.light_paths.unwrap_or(256);
            let radiosity = InstantRadiosity { path, light_paths, clamp: plan.clamp };
            check_bytes("vpl", u64::from(light_paths), radiosity.bytes(), fewer_paths)?;
            Algorithm::InstantRadiosity(radiosity)
        }
        "ppm" => {
            let settings = PhotonMapping::new(path);
            // As many as pixels, of which there are fewer than 2^32.
            let light_paths = plan.light_paths.unwrap_or(pixels as u32);
            let bytes = settings.bytes(light_paths);
            check_bytes("ppm", u64::from(light_paths), bytes, fewer_paths)?;
            Algorithm::PhotonMapping(PhotonMapping { light_paths: plan.light_paths, ..settings })
        }
        "vcm" => {
            let settings = VertexMerging::new(path);
            check_bytes("vcm", pixels, settings.bytes(pixels), |fitting| {
                let smaller = (fitting as f64 / pixels as f64).sqrt();
                let [width, height] = [plan.size.0, plan.size.1]
                    .map(|side| (f64::from(side) * smaller).max(1.0) as u32);
                format!("one for each pixel: ask for a smaller image, `--size {width}x{height}`")
            })?;
            Algorithm::VertexMerging(settings)
        }
        "mlt" => {
            let (mutations, direct) = (plan.mutations, plan.separate_direct);
            Algorithm::Metropolis(Metropolis { mutations, direct, ..Metropolis::new(path) })
        }
        "pssmlt" => {
            let direct = plan.separate_direct;
            Algorithm::PrimarySample(PrimarySample { direct, ..PrimarySample::new(bidirectional) })
        }
        "gdpt" => Algorithm::GradientDomain(GradientDomain::new(path)),
        "tridir" => {
            let portals = Portals::new(scene).map_err(Failure::new)?;
            Algorithm::Tridirectional(Tridirectional { path, portals })
        }
        unknown => {
            let supported = INTEGRATORS.join(", ");
            let message =
                format!("integrator `{unknown}` is not supported; supported: {supported}");
            return Err(match &scene.integrator.place {
                Some(place) if scene.integrator.name == unknown => {
                    Failure::new(place.error(message).to_string())
                }
                _ => Failure::new(message),
            });
        }
    };
    let vertices = 2 + usize::from(path.hide_emitters)..=path.most_vertices();
    techniques.check(algorithm.techniques(), vertices).map_err(|why| {
        Failure::new(format!("--techniques of integrator `{}`: {why}", plan.integrator))
    })?;
    Ok(algorithm)
}

/// The most bytes that the light paths of a sample, or images of techniques, may take.
pub(super) const MOST_BYTES: u64 = 8_000_000_000;

/// That so many light paths of an integrator, which take so many bytes, fit into memory; how to ask for as many as fit is said
/// otherwise.
fn check_bytes(
    integrator: &str,
    paths: u64,
    bytes: u64,
    remedy: impl Fn(u64) -> String,
) -> Result<(), Failure> {
    if bytes <= MOST_BYTES {
        return Ok(());
    }
    Err(Failure::new(format!(
        "{paths} light paths of integrator `{integrator}` may take {:.1} GB; {}, or for shorter ones, `--max-depth`",
        bytes as f64 / 1e9,
        remedy(MOST_BYTES / (bytes / paths))
    )))
}

/// The integrators, by their names in scene files and on the command line.
const INTEGRATORS: [&str; 10] =
    ["path", "bdpt", "tridir", "gdpt", "mlt", "pssmlt", "vpl", "ppm", "vcm", "ptracer"];

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

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

    fn arguments(line: &[&str]) -> RenderArguments {
        let line = ["aether", "render", "scene.xml"].iter().chain(line);
        match super::super::Arguments::parse_from(line).command {
            super::super::Command::Render(arguments) => *arguments,
            other => panic!("{other:?}"),
        }
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
        let line = ["aether", "render", file.to_str().unwrap(), "--size", "50x100"];
        let arguments = match super::super::Arguments::parse_from(line).command {
            super::super::Command::Render(arguments) => *arguments,
            other => panic!("{other:?}"),
        };
        let scene = load(&arguments);
        std::fs::remove_file(&file).unwrap();
        let scene = scene.unwrap();
        assert_eq!((scene.film.width, scene.camera.height), (50, 100));
        // The field of view lies along x and stays; the other one follows the proportions.
        assert!((scene.camera.tan_x - 20f32.to_radians().tan()).abs() < 1e-6);
        assert!((scene.camera.tan_y / scene.camera.tan_x - 2.0).abs() < 1e-6);
    }
}
