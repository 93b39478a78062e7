//! Whole scene files, good and bad.

use std::path::{Path, PathBuf};

use glam::{Vec3, vec2, vec3};

use super::bsdf::Diffuse;
use super::*;

fn load(body: &str) -> Result<Scene, String> {
    load_with(body, &[])
}

fn load_with(body: &str, defines: &[(&str, &str)]) -> Result<Scene, String> {
    let xml = format!("<scene version=\"3.0.0\">\n{body}\n</scene>");
    let defines: Vec<(String, String)> =
        defines.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())).collect();
    Scene::from_str(&xml, Path::new("."), &defines).map_err(|e| e.to_string())
}

fn diffuse(reflectance: Vec3) -> Bsdf {
    Bsdf::Diffuse(Diffuse { reflectance: reflectance.into() })
}

const SENSOR: &str = "<sensor type=\"perspective\"/>";

fn cornell_box() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/scenes/cornell-box.xml")
}

/// A folder for this test alone.
fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("aether-scene-{}-{name}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

#[test]
fn cornell_box_is_as_mitsuba_has_it() {
    let define = |name: &str, value: &str| (name.to_owned(), value.to_owned());
    let scene = Scene::load(&cornell_box(), &[define("spp", "7"), define("width", "128")]).unwrap();
    assert_eq!(scene.shapes.len(), 8);
    assert_eq!(scene.primitives.len(), 6 * 2 + 2 * 12);
    assert_eq!((scene.film.width, scene.film.height), (128, 256));
    assert_eq!(scene.film.filter, Filter::Box);
    assert_eq!((scene.sampler.sample_count, scene.sampler.kind.name()), (7, "independent"));
    assert_eq!((scene.integrator.max_depth, scene.integrator.rr_depth), (Some(8), 5));
    // A rectangle is one light.
    assert_eq!((scene.emitters.len(), scene.emitters[0].count), (1, 2));
    let area: f32 = scene.emitters.iter().map(|e| e.area).sum();
    assert!((area - 4.0 * 0.23 * 0.19).abs() < 1e-6);
    for emitter in &scene.emitters {
        assert_eq!(emitter.radiance, vec3(18.387, 13.9873, 6.75357));
        let normal = scene.primitives[emitter.primitive as usize].normal(Vec3::ZERO);
        assert!((normal + Vec3::Y).length() < 1e-6);
    }
    // All walls face the middle of the room.
    for axis in [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, -Vec3::Z] {
        let hit = scene.intersect(vec3(0.0, 0.2, 0.0), axis, None).unwrap();
        assert!(hit.geometric_normal.dot(axis) < -0.3, "{axis}: {hit:?}");
    }
    let red = scene.intersect(vec3(0.0, 0.9, 0.9), -Vec3::X, None).unwrap();
    assert_eq!(*scene.bsdf(red.primitive), diffuse(vec3(0.570068, 0.0430135, 0.0443706)));
    let summary = inspect::summary(&scene);
    assert!(summary.contains("6 rectangle, 2 cube"), "{summary}");
    let json = inspect::json(&scene);
    assert_eq!(json["shapes"]["cube"], 2);
    assert_eq!(json["film"]["width"], 128);
    assert_eq!(json["emitters"][0]["shape"], "light");
}

#[test]
fn camera_rays_are_mitsubas() {
    // `sensor.sample_ray(0, 0, [x / 320, y / 200], [0, 0]).d` with Mitsuba 3.9.1.
    let scene = load(
        "<sensor type=\"perspective\"><float name=\"fov\" value=\"50\"/>
         <string name=\"fov_axis\" value=\"smaller\"/>
         <transform name=\"to_world\"><lookat origin=\"1 2 3\" target=\"-2 0.5 1\" up=\"0.1 1 0\"/>
         </transform><film type=\"hdrfilm\"><integer name=\"width\" value=\"320\"/>
         <integer name=\"height\" value=\"200\"/></film></sensor>",
    )
    .unwrap();
    assert_eq!(scene.camera.origin, vec3(1.0, 2.0, 3.0));
    for (film, direction) in [
        (vec2(0.0, 0.0), MITSUBA_DIRECTIONS[0]),
        (vec2(250.5, 30.25), MITSUBA_DIRECTIONS[1]),
        (vec2(320.0, 200.0), MITSUBA_DIRECTIONS[2]),
    ] {
        let found = scene.camera.direction(film);
        assert!((found - Vec3::from_array(direction)).length() < 2e-6, "{film}: {found}");
    }
}

const MITSUBA_DIRECTIONS: [[f32; 3]; 3] = [
    [-0.997_609_56, 0.066_354_39, -0.019_291_76],
    [-0.546_076_7, -0.095_838_53, -0.832_235_16],
    [-0.155_917_32, -0.643_117_8, -0.749_726_24],
];

#[test]
fn defaults_are_mitsubas() {
    let scene = load(&format!(
        "{SENSOR}<shape type=\"disk\"/>
         <shape type=\"sphere\"><emitter type=\"area\"/></shape>"
    ))
    .unwrap();
    assert_eq!((scene.film.width, scene.film.height), (768, 576));
    assert_eq!(scene.film.filter, Filter::Gaussian { stddev: 0.5 });
    assert_eq!(scene.sampler.sample_count, 4);
    assert_eq!(scene.integrator, Integrator::default());
    assert_eq!(scene.bsdfs, [0.5, 0.0].map(|x| diffuse(Vec3::splat(x))));
    assert_eq!(scene.emitters[0].radiance, Vec3::ONE);
    assert!((scene.camera.tan_x - (38.1848_f32 / 2.0).to_radians().tan()).abs() < 1e-6);
}

#[test]
fn transforms_compose_in_file_order() {
    let scene = load(&format!(
        "{SENSOR}<shape type=\"sphere\"><transform name=\"to_world\">
         <scale value=\"2\"/><rotate z=\"1\" angle=\"90\"/><translate x=\"10\"/></transform>
         <point name=\"center\" x=\"1\" y=\"0\" z=\"0\"/><float name=\"radius\" value=\"0.5\"/>
         </shape>"
    ))
    .unwrap();
    let Primitive::Sphere { center, radius, flipped } = scene.primitives[0] else {
        panic!("not a sphere");
    };
    let in_file = scene.origin.as_vec3() + center;
    assert!((in_file - vec3(10.0, 2.0, 0.0)).length() < 1e-6);
    assert_eq!((radius, flipped), (1.0, false));
}

#[test]
fn materials_are_shared_and_two_sided() {
    let scene = load(&format!(
        "{SENSOR}<bsdf type=\"twosided\" id=\"t\"><ref id=\"d\"/></bsdf>
         <bsdf type=\"diffuse\" id=\"d\"><rgb name=\"reflectance\" value=\"#ff0000\"/></bsdf>
         <alias id=\"d\" as=\"e\"/>
         <shape type=\"cube\"><ref id=\"t\"/></shape><shape type=\"cube\"><ref id=\"e\"/></shape>
         <shape type=\"cube\"><ref id=\"d\"/></shape>"
    ))
    .unwrap();
    assert_eq!(scene.bsdfs.len(), 2);
    assert_eq!([0, 1, 2].map(|i| scene.shapes[i].bsdf), [0, 1, 1]);
    let red = || diffuse(Vec3::X);
    assert_eq!(scene.bsdfs, [Bsdf::TwoSided(Box::new([red(), red()])), red()]);
}

#[test]
fn includes_and_paths_are_followed() {
    let root = folder("includes");
    std::fs::create_dir_all(root.join("parts/meshes")).unwrap();
    let write = |name: &str, text: &str| std::fs::write(root.join(name), text).unwrap();
    write(
        "main.xml",
        "<scene version=\"3.0.0\"><default name=\"r\" value=\"0.25\"/>
         <sensor type=\"perspective\"/><path value=\"parts\"/><include filename=\"more.xml\"/></scene>",
    );
    write(
        "parts/more.xml",
        "<scene version=\"3.0.0\"><shape type=\"obj\"><string name=\"filename\"
         value=\"meshes/m.obj\"/><bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"$r\"/>
         </bsdf></shape></scene>",
    );
    write("parts/meshes/m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 2\nf 2 3 4\n");
    let scene = Scene::load(&root.join("main.xml"), &[]).unwrap();
    assert_eq!(scene.primitives.len(), 2);
    assert_eq!(scene.degenerate_triangles, 1);
    assert_eq!(scene.normals.len(), 2);
    assert_eq!(scene.bsdfs[0], diffuse(Vec3::splat(0.25)));
    let hit = scene.intersect(vec3(0.2, 0.2, -1.0), Vec3::Z, None).unwrap();
    assert_eq!(hit.geometric_normal, Vec3::Z);
    assert!(hit.shading_normal != hit.geometric_normal);

    write("loop.xml", "<scene version=\"3.0.0\">\n<include filename=\"loop.xml\"/></scene>");
    let error = Scene::load(&root.join("loop.xml"), &[]).map(|_| ()).unwrap_err();
    assert!(error.message.contains("does a file include itself?"), "{error}");
    assert_eq!(error.line, Some(2));

    write("parts/meshes/m.obj", "v 0 0 0\nf 1 2 3\n");
    let error = Scene::load(&root.join("main.xml"), &[]).map(|_| ()).unwrap_err().to_string();
    assert!(error.ends_with("m.obj:2: vertex 2 does not exist; there are 1 so far"), "{error}");
    std::fs::remove_dir_all(&root).unwrap();
}

#[test]
fn materials_say_what_is_wrong() {
    let checks = "<texture type=\"checkerboard\"/>";
    let named = |name: &str| format!("<texture type=\"checkerboard\" name=\"{name}\"/>");
    let alpha = |name: &str, value: &str| format!("<float name=\"{name}\" value=\"{value}\"/>");
    let matte = "<bsdf type=\"diffuse\"/>";
    let twice = format!("{}{}", alpha("alpha", "0.1"), alpha("alpha_u", "0.2"));
    let mixed = format!("{}{}", named("alpha"), alpha("alpha_u", "0.2"));
    let two = format!("{}{}", alpha("alpha_u", "0.1"), alpha("alpha_v", "0.2"));
    let bumped = format!("<bsdf type=\"bumpmap\">{checks}{matte}</bsdf>");
    let half = alpha("weight", "0.5");
    let pair = |part: String| format!("<bsdf type=\"blendbsdf\">{half}{part}{part}</bsdf>");
    let crowd = pair(pair(pair(matte.to_owned())));
    let crowd = format!("{half}{crowd}{crowd}");
    for (plugin, body, expected) in [
        ("bumpmap", matte, "needs one nested <texture>"),
        ("bumpmap", checks, "needs one nested <bsdf>"),
        ("bumpmap", &format!("{checks}{bumped}"), "other bumps within a bump are not supported"),
        ("bumpmap", &format!("{checks}{checks}{matte}"), "a second <texture>"),
        ("bumpmap", &format!("{checks}{matte}{}", alpha("scale", "1e9")), "at most 1e6"),
        ("normalmap", &format!("{checks}{matte}"), "the texture \"normalmap\" is missing"),
        ("blendbsdf", &crowd, "a mixture of 16 materials; at most 15 are supported"),
        (
            "blendbsdf",
            &format!("{matte}{matte}{}", named("opacity")),
            "the float \"weight\" is missing",
        ),
        ("mask", &format!("{matte}{}", named("weight")), "unreferenced texture \"weight\""),
        ("diffuse", &named("alpha"), "unreferenced texture \"alpha\""),
        ("roughconductor", &twice, "give either alpha or alpha_u and alpha_v"),
        ("roughdielectric", &mixed, "give either alpha or alpha_u and alpha_v"),
        ("roughconductor", &alpha("alpha_v", "0"), "the roughness must lie in 1e-5..=10"),
        ("roughplastic", &two, "give one alpha"),
        ("roughplastic", &named("alpha"), "textures are not supported here"),
        ("phong", &alpha("exponent", "-1"), "must lie in 0..=100000"),
        (
            "diffuse",
            "<texture type=\"scale\" name=\"reflectance\"><float name=\"scale\" value=\"9\"/>\
             <texture type=\"checkerboard\"/></texture>",
            "must lie in [0, 1]",
        ),
        ("diffuse", "<texture type=\"scale\" name=\"reflectance\"/>", "needs one nested <texture>"),
    ] {
        let error = load(&format!("{SENSOR}<bsdf type=\"{plugin}\">{body}</bsdf>"));
        let error = error.err().unwrap_or_else(|| panic!("{plugin} {body} is loaded"));
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn what_would_be_cut_away_is_a_warning() {
    let warnings = |near: &str, far: &str| {
        let clip = |name: &str, value: &str| format!("<float name=\"{name}\" value=\"{value}\"/>");
        let sensor = format!(
            "<sensor type=\"perspective\">{}{}</sensor>",
            clip("near_clip", near),
            clip("far_clip", far)
        );
        let square = "<shape type=\"rectangle\"><transform name=\"to_world\"><translate z=\"2\"/></transform></shape>";
        load(&format!("{sensor}{square}"))
            .unwrap()
            .warnings
            .iter()
            .map(ToString::to_string)
            .collect::<Vec<_>>()
    };
    assert!(warnings("1.9", "2.1").is_empty());
    for (near, far, expected) in
        [("2.1", "9", "what is nearer is not cut"), ("0.1", "1.9", "what is further away")]
    {
        let found = warnings(near, far);
        assert!(found.len() == 1 && found[0].contains(expected), "{found:?}");
    }
}

#[test]
fn a_portal_has_triangles_and_no_emitter() {
    let with = |shape: &str, emitter: &str| {
        let portal =
            "<integrator type=\"tridir\"><string name=\"portal\" value=\"p\"/></integrator>";
        load(&format!("{SENSOR}{portal}<shape type=\"{shape}\" id=\"p\">{emitter}</shape>"))
    };
    assert!(with("rectangle", "").unwrap().warnings.is_empty());
    let shining = with("rectangle", "<emitter type=\"area\"/>").unwrap();
    assert!(shining.emitters.is_empty());
    let warnings: Vec<String> = shining.warnings.iter().map(ToString::to_string).collect();
    assert!(warnings.len() == 1 && warnings[0].contains("its emitter is left out"), "{warnings:?}");
    for curved in ["disk", "sphere"] {
        let error = with(curved, "").err().unwrap();
        assert!(error.contains("2:") && error.contains("use a rectangle or a mesh"), "{error}");
    }
}

/// A square of two triangles with colours at its corners and a number for each face.
const PAINTED: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
    property float z\nproperty float r\nproperty float g\nproperty float b\nproperty float gloss_x\n\
    element face 1\nproperty list uchar int vertex_indices\nproperty float tone_0\nend_header\n\
    0 0 0 1 0 0 0.1\n1 0 0 0 1 0 0.2\n1 1 0 0 0 1 0.3\n0 1 0 0 0 0 0.4\n4 0 1 2 3 0.7\n";

#[test]
fn meshes_bring_colours() {
    let root = folder("painted");
    std::fs::write(root.join("painted.ply"), PAINTED).unwrap();
    let shape = |what: &str, name: &str, more: &str| {
        format!(
            "<scene version=\"3.0.0\">{SENSOR}<shape type=\"ply\"><string name=\"filename\" value=\"painted.ply\"/>\
             <transform name=\"to_world\"><scale x=\"-2\" y=\"2\"/><translate z=\"1\"/></transform>\
             <bsdf type=\"roughconductor\"><texture type=\"mesh_attribute\" name=\"{what}\">\
             <string name=\"name\" value=\"{name}\"/>{more}</texture></bsdf></shape></scene>"
        )
    };
    let load = |xml: &str| Scene::from_str(xml, &root, &[]).map_err(|error| error.to_string());
    let value = |what: &str, name: &str| {
        let scene = load(&shape(what, name, "<float name=\"scale\" value=\"0.5\"/>")).unwrap();
        // At (0.75, 0.5) of the square, in its lower triangle: weights 0.25, 0.25 and 0.5.
        let hit = scene.intersect(vec3(-1.5, 1.0, 0.0), Vec3::Z, None).unwrap();
        let spot = texture::Spot {
            uv: vec2(0.0, 0.0),
            primitive: hit.primitive.0,
            position: hit.position,
        };
        scene.textures[0].on(&spot)
    };
    let near = |found: Vec3, expected: Vec3| {
        assert!((found - expected).abs().max_element() < 1e-6, "{found}, not {expected}");
    };
    near(value("specular_reflectance", "vertex_color"), 0.5 * vec3(0.25, 0.25, 0.5));
    near(value("alpha", "vertex_gloss"), Vec3::splat(0.5 * (0.25 * 0.1 + 0.25 * 0.2 + 0.5 * 0.3)));
    near(value("alpha", "face_tone"), Vec3::splat(0.35));
    for (what, name, more, expected) in [
        ("alpha", "vertex_tone", "", "there are: vertex_color, vertex_gloss, face_tone"),
        ("alpha", "tone", "", "begins with \"vertex_\" or \"face_\""),
        (
            "specular_reflectance",
            "face_tone",
            "<float name=\"scale\" value=\"2\"/>",
            "are from 1.4 to 1.4",
        ),
    ] {
        let error = load(&shape(what, name, more)).err().expect("an error");
        assert!(error.contains(expected), "{error}");
    }
    std::fs::remove_dir_all(&root).unwrap();
}

#[test]
fn old_textures_are_scaled_and_moved() {
    let scene = load(&format!(
        "{SENSOR}<bsdf type=\"diffuse\"><texture type=\"scale\" name=\"reflectance\">\
         <float name=\"scale\" value=\"0.5\"/><texture type=\"checkerboard\">\
         <float name=\"uvscale\" value=\"2\"/><float name=\"uoffset\" value=\"0.5\"/></texture>\
         </texture></bsdf>"
    ));
    let scene = scene.unwrap_or_else(|error| panic!("{error}"));
    // Half of 0.4 and of 0.2, in squares of a quarter, moved by one.
    let [here, there] = [vec2(0.1, 0.1), vec2(0.35, 0.1)].map(|uv| scene.textures[0].at(uv).x);
    assert!((here - 0.1).abs() < 1e-7 && (there - 0.2).abs() < 1e-7, "{here} {there}");
}

#[test]
fn errors_say_where_and_what() {
    let with = |body: &str| match load(&format!("{SENSOR}\n{body}")) {
        Ok(_) => panic!("{body} is loaded"),
        Err(error) => error,
    };
    for (body, expected) in [
        (
            "<bsdf type=\"foo\"/>",
            "scene.xml:3:1: <bsdf type=\"foo\">: not supported; supported: diffuse, conductor, dielectric, \
          thindielectric, roughconductor, roughdielectric, plastic, roughplastic, phong, twosided, mask, blendbsdf, bumpmap, normalmap, null",
        ),
        (
            "  <shape type=\"hair\"/>",
            "scene.xml:3:3: <shape type=\"hair\">: not supported; supported: rectangle, cube, \
          sphere, disk, cylinder, obj, ply, serialized, shapegroup, instance",
        ),
        (
            "<shape type=\"cube\"><float name=\"size\" value=\"1\"/></shape>",
            "scene.xml:3:20: <float name=\"size\">: unreferenced property \"size\" in \
          <shape type=\"cube\">; supported: to_world, flip_normals, silhouette_sampling_weight, max_smooth_angle",
        ),
        (
            "<shape type=\"cube\"><medium type=\"homogeneous\"/></shape>",
            "scene.xml:3:20: <medium type=\"homogeneous\">: <medium> is not supported inside \
          <shape type=\"cube\">; supported: <bsdf>, <emitter>",
        ),
        (
            "<emitter type=\"sunsky\"/>",
            "scene.xml:3:1: <emitter type=\"sunsky\">: not supported; supported: area (inside a \
          <shape>), constant, envmap, point, spot, directional",
        ),
        (
            "<emitter type=\"envmap\"/>",
            "scene.xml:3:1: <emitter type=\"envmap\">: the string \"filename\" is missing",
        ),
        (
            "<emitter type=\"envmap\"><string name=\"filename\" value=\"../tests/scenes/textures/sky.exr\"/>\
             <transform name=\"to_world\"><scale x=\"2\"/></transform></emitter>",
            "scene.xml:3:1: <emitter type=\"envmap\">: a sky can be turned and mirrored, but not distorted",
        ),
        (
            "<emitter type=\"envmap\"><string name=\"filename\" value=\"../tests/scenes/textures/picture.png\"/>\
             <float name=\"scale\" value=\"-1\"/></emitter>",
            "scene.xml:3:94: <float name=\"scale\">: must not be negative",
        ),
        (
            "<emitter type=\"area\"/>",
            "scene.xml:3:1: <emitter type=\"area\">: an area emitter must stand inside a <shape>",
        ),
        (
            "<shape type=\"cube\"><ref id=\"x\"/></shape>",
            "scene.xml:3:20: <ref id=\"x\">: no object has the id \"x\"",
        ),
        (
            "<bsdf type=\"twosided\" id=\"a\"><ref id=\"a\"/></bsdf>",
            "scene.xml:3:30: <ref id=\"a\">: this reference closes a circle",
        ),
        (
            "<bsdf type=\"diffuse\" id=\"a\"/><bsdf type=\"diffuse\" id=\"a\"/>",
            "scene.xml:3:30: <bsdf type=\"diffuse\">: the id \"a\" is already in use",
        ),
        (
            "<bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"1 2\"/></bsdf>",
            "scene.xml:3:22: <rgb name=\"reflectance\">: one or three numbers are needed, found 2",
        ),
        (
            "<bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"1 2 0\"/></bsdf>",
            "scene.xml:3:22: <rgb name=\"reflectance\">: the reflectance [1, 2, 0] must lie in [0, 1]",
        ),
        (
            "<bsdf type=\"diffuse\"><texture type=\"bitmap\" name=\"reflectance\"/></bsdf>",
            "scene.xml:3:22: <texture type=\"bitmap\">: the string \"filename\" is missing",
        ),
        (
            "<bsdf type=\"diffuse\"><string name=\"reflectance\" value=\"1\"/></bsdf>",
            "scene.xml:3:22: <string name=\"reflectance\">: \"reflectance\" is a <string>, but must be \
          a <rgb>",
        ),
        (
            "<shape type=\"sphere\"><float name=\"radius\" value=\"nan\"/></shape>",
            "scene.xml:3:22: <float name=\"radius\">: \"nan\" is not a finite number",
        ),
        (
            "<shape type=\"sphere\"><float name=\"radius\" value=\"$r\"/></shape>",
            "scene.xml:3:22: <float name=\"radius\">: undefined parameter $r; add <default \
          name=\"r\" value=\"…\"/> before its use, or pass -D r=…",
        ),
        (
            "<shape type=\"sphere\"><transform name=\"to_world\"><scale x=\"2\"/></transform></shape>",
            "scene.xml:3:22: <transform name=\"to_world\">: a sphere must be scaled evenly; \
          ellipsoids are not supported (nearest: ply, obj)",
        ),
        (
            "<shape type=\"disk\"><transform name=\"to_world\"><scale x=\"0\"/></transform></shape>",
            "scene.xml:3:20: <transform name=\"to_world\">: the transform flattens space",
        ),
        (
            "<shape type=\"cube\"><transform name=\"to_world\"><scale value=\"1e30\"/></transform>\
          </shape>",
            "scene.xml:3:1: <shape type=\"cube\">: too small or too large: coordinates must be at most \
          1e15 and areas representable; scale the scene",
        ),
        (
            "<shape type=\"ply\"/>",
            "scene.xml:3:1: <shape type=\"ply\">: the string \"filename\" is missing",
        ),
        (
            "<shape type=\"ply\"><string name=\"filename\" value=\"no.ply\"/></shape>",
            "scene.xml:3:19: <string name=\"filename\">: file \"no.ply\" not found; tried ./no.ply",
        ),
        (
            "<foo/>",
            "scene.xml:3:1: <foo>: not supported; supported: sensor, film, rfilter, sampler, \
          integrator, shape, bsdf, emitter, default, include, path, alias, ref, transform, float, \
          integer, boolean, string, rgb, spectrum, point, vector",
        ),
        ("<shape/>", "scene.xml:3:1: <shape>: the attribute \"type\" is missing"),
        (
            "<integrator type=\"path\"><integer name=\"max_depth\" value=\"-2\"/></integrator>",
            "scene.xml:3:25: <integer name=\"max_depth\">: \"max_depth\" is -2, but must be in \
          -1..=4294967295",
        ),
    ] {
        assert_eq!(with(body), expected);
    }
    let error = load("").map(|_| ()).unwrap_err();
    assert!(error.contains("the scene has no <sensor>"), "{error}");
    let error = load("<shape").map(|_| ()).unwrap_err();
    assert!(error.starts_with("scene.xml:3:1: not well-formed XML"), "{error}");
    let error = load_with(SENSOR, &[("x", "1")]).map(|_| ()).unwrap_err();
    assert_eq!(error, "scene.xml: -D x=…: the scene has no parameter $x");
    let error = Scene::load(Path::new("no.xml"), &[]).map(|_| ()).unwrap_err().to_string();
    assert!(error.starts_with("no.xml: cannot be read"), "{error}");
}

#[test]
fn other_integrators_are_left_to_the_renderer() {
    let scene = load(&format!(
        "{SENSOR}<integrator type=\"bdpt\"><integer name=\"max_depth\" value=\"3\"/>
         <float name=\"whatever\" value=\"1\"/></integrator>"
    ))
    .unwrap();
    assert_eq!((scene.integrator.name.as_str(), scene.integrator.max_depth), ("bdpt", Some(3)));
    let place = scene.integrator.place.unwrap();
    assert!(place.error("x").to_string().starts_with("scene.xml:2:"));
}

#[test]
fn old_files_are_read_as_they_were_meant() {
    let scene = |version: &str| {
        let text = format!(
            r#"<scene version="{version}"><sensor type="perspective"><float name="nearClip" value="1"/>
            <string name="unheard" value="of"/><string name="unheard" value="of"/></sensor>
            <medium type="homogeneous" id="m"/>
            <bsdf type="diffuse" id="a"><rgb name="diffuseReflectance" value="0.25"/></bsdf>
            <bsdf type="diffuse" id="b"><texture type="checkerboard" name="reflectance">
            <float name="uscale" value="4"/><float name="uvscale" value="2"/>
            <float name="voffset" value="0.5"/></texture></bsdf></scene>"#
        );
        Scene::from_str(&text, Path::new("."), &[]).map_err(|error| error.to_string())
    };
    let old = scene("0.5.0").unwrap();
    let warnings: Vec<String> = old.warnings.iter().map(|w| w.to_string()).collect();
    assert_eq!(warnings.len(), 3, "{warnings:#?}");
    for (warning, text) in warnings.iter().zip(["a second property", "unreferenced", "no medium"]) {
        assert!(warning.contains(text), "{warning}");
    }
    assert_eq!(old.bsdfs[0], diffuse(Vec3::splat(0.25)));
    let to_uv = old.textures[0].to_uv;
    assert_eq!(to_uv.transform_point2(glam::Vec2::ONE), glam::Vec2::new(4.0, 2.5));
    assert!(scene("3.0.0").err().unwrap().contains("a second property"));
}

#[test]
fn groups_are_seen_through_their_instances() {
    let instance = |x: f32| {
        format!(
            r#"<shape type="instance"><ref id="g"/><transform name="to_world"><scale value="2"/>
            <translate x="{x}"/></transform></shape>"#
        )
    };
    let group = r#"<shape type="shapegroup" id="g"><shape type="sphere"><point name="center" value="0 0 1"/>
        </shape><shape type="cube"><bsdf type="diffuse"/></shape></shape>"#;
    // The group may come after its instances, and is nothing by itself.
    let alone = load(&format!("{SENSOR}{group}")).unwrap();
    assert!(alone.primitives.is_empty());
    let scene = load(&format!("{SENSOR}{}{group}{}", instance(0.0), instance(10.0))).unwrap();
    assert_eq!((scene.shapes.len(), scene.primitives.len()), (4, 26));
    assert_eq!(scene.shapes[0].bsdf, scene.shapes[2].bsdf);
    let hit = scene.intersect(vec3(10.0, 0.0, 9.0) - scene.origin.as_vec3(), -Vec3::Z, None);
    assert_eq!(scene.in_file(hit.unwrap().position).as_vec3(), vec3(10.0, 0.0, 4.0));
}

#[test]
fn an_instance_moves_normals_with_the_surface() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenes/meshes");
    let mesh = r#"<string name="filename" value="octahedron.ply"/>
        <transform name="to_world"><scale x="-1"/></transform>"#;
    let squeezed = r#"<transform name="to_world"><scale z="0.25"/></transform>"#;
    let load = |shapes: String| {
        let xml = format!("<scene version=\"3.0.0\">{SENSOR}{shapes}</scene>");
        Scene::from_str(&xml, &folder, &[]).unwrap()
    };
    let plain = load(format!(r#"<shape type="ply">{mesh}</shape>"#));
    let moved = load(format!(
        r#"<shape type="shapegroup" id="g"><shape type="ply">{mesh}</shape></shape>
        <shape type="instance"><ref id="g"/>{squeezed}</shape>"#
    ));
    // The same point of the surface, before and after.
    let hit = |scene: &Scene, z: f32| scene.intersect(vec3(0.2, 0.3, z), -Vec3::Z, None).unwrap();
    let (before, after) = (hit(&plain, 5.0), hit(&moved, 5.0));
    assert!((before.position.z * 0.25 - after.position.z).abs() < 1e-6);
    let expected = (before.shading_normal * vec3(1.0, 1.0, 4.0)).normalize();
    assert!(before.shading_normal.dot(before.geometric_normal) > 0.5);
    assert!((after.shading_normal - expected).length() < 1e-5, "{after:?}, {expected}");
}

#[test]
fn a_window_of_a_film_keeps_its_place_when_its_size_changes() {
    let text = r#"<scene version="3.0.0"><sensor type="perspective"><film type="hdrfilm">
        <integer name="width" value="100"/><integer name="height" value="80"/>
        <integer name="crop_offset_x" value="20"/><integer name="crop_offset_y" value="40"/>
        <integer name="crop_width" value="50"/><integer name="crop_height" value="40"/>
        </film></sensor></scene>"#;
    let folder = std::env::temp_dir().join(format!("aether-window-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join("window.xml");
    std::fs::write(&file, text).unwrap();
    let whole = Scene::load(&file, &[]).unwrap();
    let half =
        Scene::load_with(&file, &[], &Overrides { size: Some((25, 20)), ..Default::default() })
            .unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    assert_eq!((whole.film.width, whole.film.height), (50, 40));
    assert_eq!((half.film.width, half.camera.width, half.camera.height), (25, 50, 40));
    // The same point of the image looks in the same direction.
    let [a, b] = [
        whole.camera.direction(glam::vec2(8.0, 30.0)),
        half.camera.direction(glam::vec2(4.0, 15.0)),
    ];
    assert!((a - b).length() < 1e-6);
    let corner = whole.camera.direction(glam::vec2(30.0, 0.0));
    let tangent = corner.dot(whole.camera.right) / corner.dot(whole.camera.forward);
    assert!(tangent.abs() < 1e-6, "the middle of the film is 30 pixels into the window");
}

#[test]
fn deep_nesting_is_refused() {
    let depth = 20_000;
    let body = "<bsdf type=\"twosided\">".repeat(depth) + &"</bsdf>".repeat(depth);
    assert!(load(&body).is_err());
}

#[test]
fn threads_share_a_scene() {
    fn shareable<T: Send + Sync>() {}
    shareable::<Scene>();
    shareable::<SceneError>();
}
