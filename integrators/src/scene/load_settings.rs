//! From `<sensor>` and `<integrator>` to the settings of a scene.

use glam::{DMat4, DVec3, Vec2};

use super::Scene;
use super::camera::{self, Camera, Projection};
use super::document::{Document, Query};
use super::error::SceneError;
use super::settings::{Film, Filter, Integrator, Sampler, SamplerKind};
use super::values::relative_determinant;

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
    /// Distances along the axis before or behind which the file wants nothing to be seen, with what to say where
    /// there is something.
    pub clips: Vec<(Clip, SceneError)>,
}

/// What a file wants to be cut away: nothing is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Clip {
    /// What is nearer than this.
    Near(f32),
    /// What is further away.
    Far(f32),
}

impl Clip {
    /// Whether the centre of one of 16x16 parts of the image shows something that is to be cut away.
    pub fn matters(self, scene: &Scene) -> bool {
        let Scene { camera, film, .. } = scene;
        (0..256).any(|k| {
            let part = Vec2::new((k % 16) as f32 + 0.5, (k / 16) as f32 + 0.5) / 16.0;
            let direction =
                camera.direction(part * Vec2::new(film.width as f32, film.height as f32));
            let hit = scene.sight_of_eyes().intersect(camera.origin, direction, None);
            hit.is_some_and(|hit| {
                let depth = hit.t * direction.dot(camera.forward);
                match self {
                    Clip::Near(near) => depth < near,
                    Clip::Far(far) => depth > far,
                }
            })
        })
    }
}

/// The near and the far plane that a file asks for.
fn clips(query: &Query) -> Result<Vec<(Clip, SceneError)>, SceneError> {
    let mut found = Vec::new();
    for (name, what) in [("near_clip", "nearer"), ("far_clip", "further away")] {
        let (Some(distance), Some(property)) = (query.float(name)?, query.get(name)) else {
            continue;
        };
        let clip = if name == "near_clip" { Clip::Near } else { Clip::Far };
        let message = format!("what is {what} is not cut away; move the camera or the shapes");
        found.push((clip(distance as f32), property.place.error(message)));
    }
    Ok(found)
}

/// The camera of a `<sensor>`, with its film and sampler. A `size` takes the place of the film's.
pub fn read_sensor(
    document: &Document,
    query: &Query,
    size: Option<(u32, u32)>,
) -> Result<Sensor, SceneError> {
    let projection = query.object.plugin.as_str();
    if !["perspective", "thinlens", "orthographic"].contains(&projection) {
        return Err(query.unsupported("perspective, thinlens, orthographic"));
    }
    let mut film = match query.child("film")? {
        Some(id) => read_film(document, &document.query(id))?,
        None => Window::whole(Film {
            width: 768,
            height: 576,
            filter: Filter::Gaussian { stddev: 0.5 },
        }),
    };
    if let Some(size) = size {
        film.resize(size);
    }
    let sampler = match query.child("sampler")? {
        Some(id) => read_sampler(&document.query(id))?,
        None => Sampler { kind: SamplerKind::Independent, sample_count: 4, seed: 0 },
    };
    let (camera, position) = match projection {
        "orthographic" => read_orthographic(query, &film)?,
        _ => read_camera(query, &film)?,
    };
    // Of an orthographic camera the near plane is where rays start.
    let clips = if projection == "orthographic" { Vec::new() } else { clips(query)? };
    query.ignore(&["shutter_open", "shutter_close"]);
    query.finish(&["film", "sampler"])?;
    Ok(Sensor { camera, position, film: film.image, sampler, clips })
}

/// The part of a film that becomes the image.
struct Window {
    /// The image.
    image: Film,
    /// Columns and rows of the whole film.
    film: (u32, u32),
    /// Where the image begins on it, in pixels.
    crop: Vec2,
}

impl Window {
    fn whole(image: Film) -> Self {
        Window { image, film: (image.width, image.height), crop: Vec2::ZERO }
    }

    /// Gives the image another size; the film goes with it.
    fn resize(&mut self, (width, height): (u32, u32)) {
        let scale = [(width, self.image.width), (height, self.image.height)];
        let [x, y] = scale.map(|(new, old)| f64::from(new) / f64::from(old));
        let scaled = |size: u32, by: f64| (f64::from(size) * by).round().clamp(1.0, 4e9) as u32;
        self.film = (scaled(self.film.0, x), scaled(self.film.1, y));
        self.crop *= Vec2::new(x as f32, y as f32);
        (self.image.width, self.image.height) = (width, height);
    }
}

/// How far away from the image its axis may go through the film, in images.
const FURTHEST: f64 = 1e3;

fn read_camera(query: &Query, film: &Window) -> Result<(Camera, DVec3), SceneError> {
    let aspect = f64::from(film.film.0) / f64::from(film.film.1);
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
    let origin = query.near_enough("camera", ("to_world", to_world.w_axis.truncate()))?;
    let [left, up, forward] = axes.map(|axis| axis.as_vec3());
    let tan_x = (0.5 * fov).to_radians().tan();
    let is_lens = query.object.plugin == "thinlens";
    let projection = if is_lens { read_lens(query)? } else { Projection::Pinhole };
    let offset = |name| match query.float(name)?.unwrap_or(0.0) {
        x if x.abs() <= FURTHEST => Ok(x as f32),
        x => Err(query.error_at(name, format!("{x:e} must lie within {FURTHEST} images"))),
    };
    let principal = if is_lens {
        Vec2::ZERO
    } else {
        Vec2::new(offset("principal_point_offset_x")?, offset("principal_point_offset_y")?)
    };
    // A pinhole is in focus everywhere, and rays start at it, not at the near plane.
    query.ignore(&["near_clip", "far_clip", "focus_distance"]);
    let camera = Camera {
        origin: origin.as_vec3(),
        right: -left,
        up,
        forward,
        tan_x: tan_x as f32,
        tan_y: (tan_x / aspect) as f32,
        width: film.film.0,
        height: film.film.1,
        principal,
        crop: film.crop,
        projection,
    };
    Ok((camera, origin))
}

/// The lens of a `thinlens`: a pinhole if it has no extent. Without a distance it is in focus at the far
/// plane.
fn read_lens(query: &Query) -> Result<Projection, SceneError> {
    let radius = query.float("aperture_radius")?;
    let radius = radius.ok_or_else(|| query.error_at("", "needs the float \"aperture_radius\""))?;
    let far = query.float("far_clip")?.unwrap_or(1e4);
    let focus = query.float("focus_distance")?.unwrap_or(far);
    if !(0.0..=1e15).contains(&radius) {
        return Err(query.error_at("aperture_radius", "must be in 0..=1e15"));
    }
    if !(1e-15..=1e15).contains(&focus) {
        return Err(query.error_at("focus_distance", "must be in 1e-15..=1e15"));
    }
    let (aperture_radius, focus_distance) = (radius as f32, focus as f32);
    Ok(if std::f32::consts::PI * aperture_radius * aperture_radius >= f32::MIN_POSITIVE {
        Projection::ThinLens { aperture_radius, focus_distance }
    } else {
        Projection::Pinhole
    })
}

/// An `orthographic` sensor: the film is as wide as the x axis of `to_world` to both sides, and lies in the
/// near plane.
fn read_orthographic(query: &Query, film: &Window) -> Result<(Camera, DVec3), SceneError> {
    let to_world = query.transform("to_world")?.unwrap_or(DMat4::IDENTITY);
    if relative_determinant(&to_world).abs() < 1e-12 {
        return Err(query.error_at("to_world", "the transform flattens space"));
    }
    let near = query.float("near_clip")?.unwrap_or(0.01);
    query.ignore(&["far_clip", "focus_distance"]);
    let [x, y, z] = [to_world.x_axis, to_world.y_axis, to_world.z_axis].map(|c| c.truncate());
    let origin =
        query.near_enough("camera", ("to_world", to_world.w_axis.truncate() + near * z))?;
    let pixel = 2.0 / f64::from(film.film.0);
    let (across, down) = ((-pixel * x).as_vec3(), (-pixel * y).as_vec3());
    let reach = film.film.0 as f32 * across.length() + film.film.1 as f32 * down.length();
    // Written so that NaN is refused.
    if !(across.cross(down).length() >= f32::MIN_POSITIVE && reach <= 1e15) {
        return Err(query.error_at("to_world", "the film is too small or too large"));
    }
    let camera = Camera {
        origin: origin.as_vec3(),
        right: -x.normalize().as_vec3(),
        up: y.normalize().as_vec3(),
        forward: z.normalize().as_vec3(),
        tan_x: 0.0,
        tan_y: 0.0,
        width: film.film.0,
        height: film.film.1,
        principal: Vec2::ZERO,
        crop: film.crop,
        projection: Projection::Orthographic { across, down },
    };
    Ok((camera, origin))
}

fn read_film(document: &Document, query: &Query) -> Result<Window, SceneError> {
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
    let window = |offset, size, all: u32| -> Result<_, SceneError> {
        let whole = i64::from(all);
        let begin = query.integer(offset, 0, whole - 1)?.unwrap_or(0);
        let size = query.integer(size, 1, whole - begin)?.unwrap_or(whole - begin);
        Ok((begin as f32, size as u32))
    };
    let (left, columns) = window("crop_offset_x", "crop_width", width)?;
    let (top, rows) = window("crop_offset_y", "crop_height", height)?;
    query.finish(&["rfilter"])?;
    let image = Film { width: columns, height: rows, filter };
    Ok(Window { image, film: (width, height), crop: Vec2::new(left, top) })
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
        "mitchell" => {
            let parameter = |name| -> Result<f32, SceneError> {
                let value = query.float(name)?.unwrap_or(1.0 / 3.0);
                if (0.0..=1.0).contains(&value) {
                    return Ok(value as f32);
                }
                Err(query.error_at(name, format!("\"{name}\" is {value}, but must be in 0..=1")))
            };
            Filter::Cubic { b: parameter("B")?, c: parameter("C")? }
        }
        "catmullrom" => Filter::Cubic { b: 0.0, c: 0.5 },
        "lanczos" => Filter::Lanczos { lobes: query.integer("lobes", 1, 16)?.unwrap_or(3) as u32 },
        _ => {
            return Err(query.unsupported("box, tent, gaussian, mitchell, catmullrom, lanczos"));
        }
    };
    query.finish(&[])?;
    Ok(filter)
}

fn read_sampler(query: &Query) -> Result<Sampler, SceneError> {
    let kind = query.object.plugin.parse::<SamplerKind>();
    let kind = kind.map_err(|kinds| query.unsupported(&kinds))?;
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
    let portals = query.string("portal")?.unwrap_or("");
    let portals = portals.split(',').map(str::trim).filter(|id| !id.is_empty());
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
        portals: portals.map(str::to_owned).collect(),
        place: Some(query.object.place.clone()),
    })
}
