//! From the generic tree of a scene file to a [`Scene`].

use std::collections::HashMap;
use std::path::Path;

use glam::{DMat4, DVec3, Vec2, Vec3};

use super::camera::{self, Camera};
use super::document::{Document, ObjectId, Property, Query};
use super::error::SceneError;
use super::model::{Bounds, Bsdf, Emitter, Shape};
use super::settings::{Film, Filter, Integrator, Sampler, SamplerKind};
use super::shapes::{self, Geometry};
use super::trace::Tracer;
use super::{Scene, xml};

/// The linear Rec. 709 colour of a constant emission spectrum of 1 (illuminant E; a constant
/// reflectance is simply grey). From Mitsuba 3.9.1.
const ILLUMINANT_E: DVec3 = DVec3::new(1.204_793_9, 0.948_291, 0.908_916_06);
const MAX_FILM_SIZE: i64 = 1 << 16;

impl Scene {
    /// Loads a Mitsuba 3 XML file with all that it refers to. Each of `defines` is the name and
    /// value of a `$name` in the file and overrides the file's `<default>`.
    ///
    /// # Errors
    ///
    /// The first thing in the file that is malformed, missing or not supported.
    pub fn load(path: &Path, defines: &[(String, String)]) -> Result<Self, SceneError> {
        build(&xml::read_file(path, defines)?)
    }

    /// Loads a scene from a string. `folder` is where files that it names are looked up; errors
    /// call the scene `scene.xml`.
    ///
    /// # Errors
    ///
    /// As [`Scene::load`].
    pub fn from_str(
        xml: &str,
        folder: &Path,
        defines: &[(String, String)],
    ) -> Result<Self, SceneError> {
        build(&xml::read_str(
            xml,
            Path::new("scene.xml"),
            folder.to_path_buf(),
            defines,
        )?)
    }
}

/// A scene under construction.
struct Builder<'a> {
    document: &'a Document,
    scene: Parts,
    bsdf_indices: HashMap<ObjectId, u32>,
}

#[derive(Default)]
struct Parts {
    primitives: Vec<super::Primitive>,
    primitive_shapes: Vec<u32>,
    shapes: Vec<Shape>,
    normals: Vec<[Vec3; 3]>,
    bsdfs: Vec<Bsdf>,
    emitters: Vec<Emitter>,
    degenerate: usize,
}

fn build(document: &Document) -> Result<Scene, SceneError> {
    let mut builder = Builder {
        document,
        scene: Parts::default(),
        bsdf_indices: HashMap::new(),
    };
    let root = document.query(0);
    let mut sensor = None;
    for (property, id) in root.children() {
        let query = document.query(id);
        match query.object.tag.as_str() {
            "shape" => builder.shape(&query, property)?,
            "bsdf" => drop(builder.bsdf(id)?),
            "emitter" => return Err(lone_emitter(&query)),
            "sensor" => {
                let read = read_sensor(document, &query)?;
                // As Mitsuba does, the first of several sensors is used.
                sensor.get_or_insert(read);
            }
            _ => {}
        }
    }
    let integrator = match root.child("integrator")? {
        Some(id) => read_integrator(&document.query(id))?,
        None => Integrator::default(),
    };
    root.ignore(&["allow_thread_reordering", "compact_acceleration_structures"]);
    root.finish(&["shape", "bsdf", "sensor", "integrator", "emitter"])?;
    let (camera, film, sampler) = sensor.ok_or_else(|| {
        root.error_at("", "the scene has no <sensor>; add <sensor type=\"perspective\">")
    })?;
    let parts = builder.scene;
    let bounds = parts.primitives.iter().map(super::Primitive::bounds);
    let bounds = bounds.fold(Bounds::EMPTY, Bounds::union);
    Ok(Scene {
        tracer: Tracer::new(&parts.primitives, camera.origin),
        primitives: parts.primitives,
        primitive_shapes: parts.primitive_shapes,
        shapes: parts.shapes,
        normals: parts.normals,
        bsdfs: parts.bsdfs,
        emitters: parts.emitters,
        camera,
        film,
        sampler,
        integrator,
        bounds,
        degenerate_triangles: parts.degenerate,
    })
}

fn lone_emitter(query: &Query) -> SceneError {
    if query.object.plugin == "area" {
        query.error_at("", "an area emitter must stand inside a <shape>")
    } else {
        query.unsupported("area, inside a <shape>")
    }
}

impl Builder<'_> {
    fn shape(&mut self, query: &Query, property: &Property) -> Result<(), SceneError> {
        let kind = shapes::kind(query)?;
        let geometry = shapes::build(kind, query)?;
        let emission = match query.child("emitter")? {
            Some(id) => Some(read_area(&self.document.query(id))?),
            None => None,
        };
        let bsdf = match query.child("bsdf")? {
            Some(id) => self.bsdf(id)?,
            // Mitsuba's default; a shape that only emits reflects nothing.
            None => self.add_bsdf(Bsdf {
                reflectance: Vec3::splat(if emission.is_some() { 0.0 } else { 0.5 }),
                two_sided: false,
            }),
        };
        query.finish(&["bsdf", "emitter"])?;
        let parts = &mut self.scene;
        let total = parts.primitives.len() + geometry.primitives.len();
        if total >= u32::MAX as usize {
            return Err(property.place.error("the scene has too many primitives"));
        }
        let index = parts.shapes.len();
        let name = query.object.id.clone();
        let shape = Shape {
            name: name.unwrap_or_else(|| format!("{}-{index}", kind.name())),
            kind,
            bsdf,
            emission,
            first_primitive: parts.primitives.len() as u32,
            primitive_count: geometry.primitives.len() as u32,
            first_normals: (!geometry.normals.is_empty()).then_some(parts.normals.len() as u32),
        };
        parts.add(shape, geometry);
        Ok(())
    }

    fn add_bsdf(&mut self, bsdf: Bsdf) -> u32 {
        self.scene.bsdfs.push(bsdf);
        self.scene.bsdfs.len() as u32 - 1
    }

    fn bsdf(&mut self, id: ObjectId) -> Result<u32, SceneError> {
        if let Some(&index) = self.bsdf_indices.get(&id) {
            return Ok(index);
        }
        let query = self.document.query(id);
        let bsdf = match query.object.plugin.as_str() {
            "diffuse" => read_diffuse(&query)?,
            "twosided" => {
                let inner = query.child("bsdf")?;
                let inner = inner.ok_or_else(|| query.error_at("", "needs a nested <bsdf>"))?;
                query.ignore(&["allow_transmission"]);
                query.finish(&["bsdf"])?;
                let inner = self.document.query(inner);
                if inner.object.plugin != "diffuse" {
                    return Err(inner.unsupported("diffuse, inside twosided"));
                }
                Bsdf {
                    two_sided: true,
                    ..read_diffuse(&inner)?
                }
            }
            _ => return Err(query.unsupported("diffuse, twosided")),
        };
        let index = self.add_bsdf(bsdf);
        self.bsdf_indices.insert(id, index);
        Ok(index)
    }
}

impl Parts {
    fn add(&mut self, shape: Shape, geometry: Geometry) {
        let index = self.shapes.len() as u32;
        for (offset, primitive) in geometry.primitives.into_iter().enumerate() {
            if let Some(radiance) = shape.emission.filter(|radiance| *radiance != Vec3::ZERO) {
                self.emitters.push(Emitter {
                    primitive: shape.first_primitive + offset as u32,
                    radiance,
                    area: primitive.area(),
                });
            }
            self.primitives.push(primitive);
            self.primitive_shapes.push(index);
        }
        self.normals.extend(geometry.normals);
        self.degenerate += geometry.degenerate;
        self.shapes.push(shape);
    }
}

fn read_diffuse(query: &Query) -> Result<Bsdf, SceneError> {
    reject_texture(query, "reflectance")?;
    let reflectance = query.color("reflectance", DVec3::ONE)?;
    let reflectance = reflectance.unwrap_or(DVec3::splat(0.5));
    if reflectance.min_element() < 0.0 || reflectance.max_element() > 1.0 {
        return Err(query.error_at(
            "reflectance",
            format!("the reflectance {reflectance} must lie in [0, 1]"),
        ));
    }
    query.finish(&[])?;
    Ok(Bsdf {
        reflectance: reflectance.as_vec3(),
        two_sided: false,
    })
}

fn read_area(query: &Query) -> Result<Vec3, SceneError> {
    if query.object.plugin != "area" {
        return Err(query.unsupported("area"));
    }
    reject_texture(query, "radiance")?;
    let radiance = query.color("radiance", ILLUMINANT_E)?.unwrap_or(DVec3::ONE);
    if radiance.min_element() < 0.0 || radiance.max_element() > 1e18 {
        let message = format!("the radiance {radiance} must lie in [0, 1e18]");
        return Err(query.error_at("radiance", message));
    }
    query.ignore(&["sampling_weight"]);
    query.finish(&[])?;
    Ok(radiance.as_vec3())
}

/// Colours that vary over the surface are a likely wish; say so plainly.
fn reject_texture(query: &Query, name: &str) -> Result<(), SceneError> {
    match query.children().find(|(property, _)| property.name == name) {
        Some((property, _)) => Err(property.place.error(format!(
            "textures are not supported; supported for \"{name}\": rgb, spectrum, float"
        ))),
        None => Ok(()),
    }
}

fn read_sensor(
    document: &Document,
    query: &Query,
) -> Result<(Camera, Film, Sampler), SceneError> {
    if query.object.plugin != "perspective" {
        return Err(query.unsupported("perspective"));
    }
    let film = match query.child("film")? {
        Some(id) => read_film(document, &document.query(id))?,
        None => Film {
            width: 768,
            height: 576,
            filter: Filter::Gaussian { stddev: 0.5 },
        },
    };
    let sampler = match query.child("sampler")? {
        Some(id) => read_sampler(&document.query(id))?,
        None => Sampler {
            kind: SamplerKind::Independent,
            sample_count: 4,
            seed: 0,
        },
    };
    let camera = read_camera(query, film)?;
    // A pinhole is in focus everywhere, and rays start at it, not at the near plane.
    query.ignore(&["near_clip", "far_clip", "focus_distance"]);
    query.ignore(&["shutter_open", "shutter_close"]);
    query.finish(&["film", "sampler"])?;
    Ok((camera, film, sampler))
}

fn read_camera(query: &Query, film: Film) -> Result<Camera, SceneError> {
    let aspect = f64::from(film.width) / f64::from(film.height);
    let fov = query.float("fov")?;
    let axis = query.string("fov_axis")?.unwrap_or("x");
    let focal_length = query.string("focal_length")?;
    if fov.is_some() && focal_length.is_some() {
        return Err(query.error_at("focal_length", "give either fov or focal_length, not both"));
    }
    let fov = match fov {
        Some(fov) => camera::horizontal_fov(fov, axis, aspect),
        None => camera::diagonal_fov(focal_length.unwrap_or("50mm"))
            .and_then(|fov| camera::horizontal_fov(fov, "diagonal", aspect)),
    };
    let fov = fov.map_err(|e| query.error_at("fov", e))?;
    let to_world = query.transform("to_world")?.unwrap_or(DMat4::IDENTITY);
    let axes = camera::orthonormal_axes(&to_world).map_err(|e| query.error_at("to_world", e))?;
    let origin = to_world.w_axis.truncate();
    if origin.abs().max_element() > 1e15 {
        return Err(query.error_at("to_world", "the camera is too far away; scale the scene"));
    }
    let [left, up, forward] = axes.map(|axis| axis.as_vec3());
    let tan_x = (0.5 * fov).to_radians().tan();
    let offset = |name| query.float(name).map(|x| x.unwrap_or(0.0) as f32);
    Ok(Camera {
        origin: origin.as_vec3(),
        right: -left,
        up,
        forward,
        tan_x: tan_x as f32,
        tan_y: (tan_x / aspect) as f32,
        width: film.width,
        height: film.height,
        principal: Vec2::new(
            offset("principal_point_offset_x")?,
            offset("principal_point_offset_y")?,
        ),
    })
}

fn read_film(document: &Document, query: &Query) -> Result<Film, SceneError> {
    if query.object.plugin != "hdrfilm" {
        return Err(query.unsupported("hdrfilm"));
    }
    let width = query.integer("width", 1, MAX_FILM_SIZE)?.unwrap_or(768) as u32;
    let height = query.integer("height", 1, MAX_FILM_SIZE)?.unwrap_or(576) as u32;
    let filter = match query.child("rfilter")? {
        Some(id) => read_filter(&document.query(id))?,
        None => Filter::Gaussian { stddev: 0.5 },
    };
    // How the image is stored is for the program to say.
    query.ignore(&["file_format", "pixel_format", "component_format"]);
    query.ignore(&["sample_border", "banner", "compensate"]);
    query.finish(&["rfilter"])?;
    Ok(Film {
        width,
        height,
        filter,
    })
}

fn read_filter(query: &Query) -> Result<Filter, SceneError> {
    let size = |name, default: f64| {
        let size = query.float(name)?.unwrap_or(default);
        if (1e-3..=1e3).contains(&size) {
            Ok(size as f32)
        } else {
            let message = format!("\"{name}\" is {size}, but must be in 0.001..=1000 pixels");
            Err(query.error_at(name, message))
        }
    };
    let filter = match query.object.plugin.as_str() {
        "box" => Filter::Box,
        "tent" => Filter::Tent {
            radius: size("radius", 1.0)?,
        },
        "gaussian" => Filter::Gaussian {
            stddev: size("stddev", 0.5)?,
        },
        _ => return Err(query.unsupported("box, tent, gaussian")),
    };
    query.finish(&[])?;
    Ok(filter)
}

fn read_sampler(query: &Query) -> Result<Sampler, SceneError> {
    let kind = match query.object.plugin.as_str() {
        "independent" => SamplerKind::Independent,
        "stratified" => SamplerKind::Stratified,
        "multijitter" => SamplerKind::Multijitter,
        "orthogonal" => SamplerKind::Orthogonal,
        "ldsampler" => SamplerKind::LowDiscrepancy,
        _ => {
            return Err(
                query.unsupported("independent, stratified, multijitter, orthogonal, ldsampler")
            );
        }
    };
    let samples = query.integer("sample_count", 1, i64::from(u32::MAX))?;
    let seed = query.integer("seed", 0, i64::MAX)?;
    // Details of how Mitsuba stratifies.
    query.ignore(&["jitter", "strength"]);
    query.finish(&[])?;
    Ok(Sampler {
        kind,
        sample_count: samples.unwrap_or(4) as u32,
        seed: seed.unwrap_or(0) as u64,
    })
}

fn read_integrator(query: &Query) -> Result<Integrator, SceneError> {
    let max_depth = query.integer("max_depth", -1, i64::from(u32::MAX))?;
    let rr_depth = query.integer("rr_depth", 1, i64::from(u32::MAX))?;
    let hide_emitters = query.boolean("hide_emitters")?;
    query.ignore(&["timeout", "block_size", "samples_per_pass"]);
    // What another integrator may be told is not known here, and the user may choose another one
    // than the file does.
    if query.object.plugin == "path" {
        query.finish(&[])?;
    }
    Ok(Integrator {
        name: query.object.plugin.clone(),
        max_depth: max_depth.and_then(|depth| u32::try_from(depth).ok()),
        rr_depth: rr_depth.unwrap_or(5) as u32,
        hide_emitters: hide_emitters.unwrap_or(false),
        place: Some(query.object.place.clone()),
    })
}
