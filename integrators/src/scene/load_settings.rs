//! From `<sensor>` and `<integrator>` to the settings of a scene.

use glam::{DMat4, DVec3, Vec2};

use super::camera::{self, Camera};
use super::document::{Document, Query};
use super::error::SceneError;
use super::settings::{Film, Filter, Integrator, Sampler, SamplerKind};

const MAX_FILM_SIZE: i64 = 1 << 16;

/// What a `<sensor>` says.
pub struct Sensor {
    /// The camera, its origin still that of the file.
    pub camera: Camera,
    /// Where the camera is in the file's world.
    pub position: DVec3,
    /// The film.
    pub film: Film,
    /// The sampler.
    pub sampler: Sampler,
}

/// The camera of a `<sensor>`, with its film and sampler. A `size` takes the place of the film's.
pub fn read_sensor(
    document: &Document,
    query: &Query,
    size: Option<(u32, u32)>,
) -> Result<Sensor, SceneError> {
    if query.object.plugin != "perspective" {
        return Err(query.unsupported("perspective"));
    }
    let mut film = match query.child("film")? {
        Some(id) => read_film(document, &document.query(id))?,
        None => Film { width: 768, height: 576, filter: Filter::Gaussian { stddev: 0.5 } },
    };
    if let Some(size) = size {
        (film.width, film.height) = size;
    }
    let sampler = match query.child("sampler")? {
        Some(id) => read_sampler(&document.query(id))?,
        None => Sampler { kind: SamplerKind::Independent, sample_count: 4, seed: 0 },
    };
    let (camera, position) = read_camera(query, film)?;
    // A pinhole is in focus everywhere, and rays start at it, not at the near plane.
    query.ignore(&["near_clip", "far_clip", "focus_distance"]);
    query.ignore(&["shutter_open", "shutter_close"]);
    query.finish(&["film", "sampler"])?;
    Ok(Sensor { camera, position, film, sampler })
}

fn read_camera(query: &Query, film: Film) -> Result<(Camera, DVec3), SceneError> {
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
    let camera = Camera {
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
    };
    Ok((camera, origin))
}

fn read_film(document: &Document, query: &Query) -> Result<Film, SceneError> {
    match query.object.plugin.as_str() {
        "hdrfilm" => {}
        // The film of version 0.x for pictures to look at; the PNG that is written has the gamma of sRGB.
        "ldrfilm" => query.ignore(&["gamma", "exposure", "tonemap_method", "key", "burn"]),
        _ => return Err(query.unsupported("hdrfilm, ldrfilm")),
    }
    let width = query.integer("width", 1, MAX_FILM_SIZE)?.unwrap_or(768) as u32;
    let height = query.integer("height", 1, MAX_FILM_SIZE)?.unwrap_or(576) as u32;
    let filter = match query.child("rfilter")? {
        Some(id) => read_filter(&document.query(id))?,
        None => Filter::Gaussian { stddev: 0.5 },
    };
    // How the image is stored is for the program to say.
    query.ignore(&["file_format", "pixel_format", "component_format"]);
    query.ignore(&["sample_border", "banner", "compensate", "attach_log", "high_quality_edges"]);
    query.finish(&["rfilter"])?;
    Ok(Film { width, height, filter })
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
        "tent" => Filter::Tent { radius: size("radius", 1.0)? },
        "gaussian" => Filter::Gaussian { stddev: size("stddev", 0.5)? },
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
    Ok(Sampler { kind, sample_count: samples.unwrap_or(4) as u32, seed: seed.unwrap_or(0) as u64 })
}

/// An `<integrator>` of any type.
pub fn read_integrator(query: &Query) -> Result<Integrator, SceneError> {
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
