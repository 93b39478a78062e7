//! From the generic tree of a scene file to a [`Scene`].

use std::collections::HashMap;
use std::path::Path;
use std::rc::Rc;

use glam::{DMat4, DVec3, Vec2, Vec3};

use super::bsdf::{Bsdf, Diffuse};
use super::document::{Document, ObjectId, Property, Query};
use super::error::SceneError;
use super::lights::{Bulb, Distant, Sky};
use super::load_bsdf;
use super::load_lights::{Lone, read_area, read_lone};
use super::load_settings::{Sensor, read_integrator, read_sensor};
use super::load_texture::{Attributes, Textures, attributes_shown};
use super::model::{Bounds, Emitter, Primitive, Rectangle, Shape};
use super::settings::Integrator;
use super::shapes::{self, Geometry, MAX_COORDINATE, Source};
use super::size::strange_size;
use super::texture::{Colour, Patch};
use super::trace::Tracer;
use super::{Scene, facts, xml};

/// The most shapes and primitives that instances may add up to: 3.4 gigabytes while the tree is built.
const MAX_COPIES: (usize, usize) = (1 << 20, 1 << 23);

impl Scene {
    /// Loads a Mitsuba 3 XML file with all that it refers to. Each of `defines` is the name and
    /// value of a `$name` in the file and overrides the file's `<default>`.
    ///
    /// # Errors
    ///
    /// The first thing in the file that is malformed, missing or not supported.
    pub fn load(path: &Path, defines: &[(String, String)]) -> Result<Self, SceneError> {
        Self::load_with(path, defines, &Overrides::default())
    }

    /// Loads a scene file as if it said something else in some places.
    ///
    /// # Errors
    ///
    /// As [`Scene::load`].
    pub fn load_with(
        path: &Path,
        defines: &[(String, String)],
        overrides: &Overrides,
    ) -> Result<Self, SceneError> {
        build(&xml::read_file(path, defines)?, overrides)
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
        let document = xml::read_str(xml, Path::new("scene.xml"), folder.to_path_buf(), defines)?;
        build(&document, &Overrides::default())
    }
}

/// What is asked for in place of what a scene file says.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Overrides {
    /// The size of the image; the field of view keeps its axis.
    pub size: Option<(u32, u32)>,
    /// The ids of shapes that are openings which light has to pass, and no surfaces; besides those that the
    /// file's integrator names.
    pub portals: Vec<String>,
}

/// A scene under construction.
struct Builder<'a> {
    document: &'a Document,
    pending: Vec<Pending<'a>>,
    scene: Parts,
    bsdf_indices: HashMap<ObjectId, u32>,
    groups: HashMap<ObjectId, Rc<Vec<Member>>>,
    /// How many shapes and primitives are copies made for instances.
    copies: (usize, usize),
    textures: Textures,
    sky: Option<Sky>,
    bulbs: Vec<(Bulb, DVec3)>,
    distant: Vec<Distant>,
}

/// A shape that waits until it is known where the scene has its zero.
struct Pending<'a> {
    source: Source,
    shape: Shape,
    property: &'a Property,
}

/// A shape that may stand by itself or in a group.
struct Member {
    source: Source,
    shape: Shape,
}

#[derive(Default)]
struct Parts {
    primitives: Vec<super::Primitive>,
    primitive_shapes: Vec<u32>,
    shapes: Vec<Shape>,
    normals: Vec<[Vec3; 3]>,
    texcoords: Vec<[Vec2; 3]>,
    bsdfs: Vec<Bsdf>,
    emitters: Vec<Emitter>,
    degenerate: usize,
    portals: Vec<[Vec3; 3]>,
    attributes: Attributes,
}

fn build(document: &Document, overrides: &Overrides) -> Result<Scene, SceneError> {
    let mut builder = Builder {
        document,
        pending: Vec::new(),
        scene: Parts::default(),
        bsdf_indices: HashMap::new(),
        groups: HashMap::new(),
        copies: (0, 0),
        textures: Textures::default(),
        sky: None,
        bulbs: Vec::new(),
        distant: Vec::new(),
    };
    let root = document.query(0);
    let mut sensor = None;
    for (property, id) in root.children() {
        let query = document.query(id);
        match query.object.tag.as_str() {
            "shape" => builder.shape(id, &query, property)?,
            "bsdf" => drop(builder.bsdf(id)?),
            "emitter" => builder.light(&query)?,
            "sensor" => {
                let read = read_sensor(document, &query, overrides.size)?;
                // As Mitsuba does, the first of several sensors is used.
                sensor.get_or_insert(read);
            }
            "medium" => {
                document.warn(property.place.error("no medium is supported; nothing uses it"))
            }
            _ => {}
        }
    }
    let mut integrator = match root.child("integrator")? {
        Some(id) => read_integrator(&document.query(id))?,
        None => Integrator::default(),
    };
    root.ignore(&["allow_thread_reordering", "compact_acceleration_structures"]);
    root.finish(&["shape", "bsdf", "sensor", "integrator", "emitter", "texture", "medium"])?;
    let Sensor { mut camera, position, film, sampler, clips } = sensor.ok_or_else(|| {
        root.error_at("", "the scene has no <sensor>; add <sensor type=\"perspective\">")
    })?;
    integrator.portals.extend_from_slice(&overrides.portals);
    let named = |id: &String| builder.pending.iter().any(|pending| pending.shape.name == *id);
    if let Some(unknown) = integrator.portals.iter().find(|id| !named(id)) {
        return Err(root.error_at("", format!("the portal `{unknown}` is no id of a shape")));
    }
    let (sky, distant) = (builder.sky.take(), std::mem::take(&mut builder.distant));
    let bulbs = std::mem::take(&mut builder.bulbs);
    let textures = std::mem::take(&mut builder.textures);
    let (parts, origin) = builder.parts(&integrator.portals)?;
    let textures = textures.finished(&parts.attributes)?;
    let bulbs = bulbs
        .into_iter()
        .map(|(bulb, place)| Bulb { position: (place - origin).as_vec3(), ..bulb });
    let bulbs = bulbs.collect();
    camera.origin = (position - origin).as_vec3();
    let bounds = parts.primitives.iter().map(super::Primitive::bounds);
    let bounds = bounds.fold(Bounds::EMPTY, Bounds::union);
    let reach = Vec3::splat(camera.reach());
    let mut scene = Scene {
        tracer: Tracer::new(&parts.primitives, reach),
        seen_by_eyes: integrator.hide_emitters.then(|| parts.tracer_of_eyes(reach)).flatten(),
        facts: facts(&parts.primitives, &parts.primitive_shapes, &parts.shapes),
        primitives: parts.primitives,
        primitive_shapes: parts.primitive_shapes,
        shapes: parts.shapes,
        normals: parts.normals,
        texcoords: parts.texcoords,
        textures,
        bsdfs: parts.bsdfs,
        emitters: parts.emitters,
        sky,
        bulbs,
        distant,
        portals: parts.portals,
        camera,
        film,
        sampler,
        integrator,
        origin,
        bounds,
        warnings: document.warnings.take(),
        files: document.files.take(),
        sample_parameters: document.sample_parameters.clone(),
        degenerate_triangles: parts.degenerate,
    };
    let cut: Vec<SceneError> = clips
        .into_iter()
        .filter_map(|(clip, warning)| clip.matters(&scene).then_some(warning))
        .collect();
    scene.warnings.extend(cut);
    let size = strange_size(&scene.bounds).map(|message| root.error_at("", message));
    scene.warnings.extend(size);
    Ok(scene)
}

impl<'a> Builder<'a> {
    fn light(&mut self, query: &Query) -> Result<(), SceneError> {
        match read_lone(self.document, query, &mut self.textures)? {
            Lone::Sky(sky) => {
                if self.sky.replace(sky).is_some() {
                    return Err(query.error_at("", "a second sky; only one is allowed"));
                }
            }
            Lone::Bulb(bulb, position) => self.bulbs.push((bulb, position)),
            Lone::Distant(light) => self.distant.push(light),
        }
        Ok(())
    }

    fn shape(
        &mut self,
        id: ObjectId,
        query: &Query,
        property: &'a Property,
    ) -> Result<(), SceneError> {
        match query.object.plugin.as_str() {
            "shapegroup" => drop(self.group(id)?),
            "instance" => self.instance(query, property)?,
            _ => {
                let Member { source, shape } = self.member(query)?;
                self.pending.push(Pending { source, shape, property });
            }
        }
        Ok(())
    }

    /// A shape by itself.
    fn member(&mut self, query: &Query) -> Result<Member, SceneError> {
        let kind = shapes::kind(query)?;
        let source = shapes::read(kind, query)?;
        let emission = match query.child("emitter")? {
            Some(id) => {
                let emitter = self.document.query(id);
                Some(read_area(self.document, &emitter, &mut self.textures)?)
            }
            None => None,
        };
        let bsdf = match query.child("bsdf")? {
            Some(id) => {
                let index = self.bsdf(id)?;
                for name in attributes_shown(self.document, id)? {
                    if !source.attributes().any(|other| other == name) {
                        let found: Vec<&str> = source.attributes().collect();
                        let found = if found.is_empty() { "none".into() } else { found.join(", ") };
                        let message = format!(
                            "the material needs the attribute \"{name}\"; there are: {found}"
                        );
                        return Err(query.error_at("", message));
                    }
                }
                index
            }
            // Mitsuba's default; a shape that only emits reflects nothing.
            None => self.add_bsdf(Bsdf::Diffuse(Diffuse {
                reflectance: Vec3::splat(if emission.is_some() { 0.0 } else { 0.5 }).into(),
            })),
        };
        query.finish(&["bsdf", "emitter"])?;
        let index = self.pending.len();
        let name = query.object.id.clone();
        let shape = Shape {
            name: name.unwrap_or_else(|| format!("{}-{index}", kind.name())),
            kind,
            bsdf,
            emission,
            first_primitive: 0,
            primitive_count: 0,
            first_normals: None,
            first_texcoords: None,
            to_local: source.to_local(),
        };
        Ok(Member { source, shape })
    }

    /// The shapes of a `shapegroup`, which is seen only through its instances.
    fn group(&mut self, id: ObjectId) -> Result<Rc<Vec<Member>>, SceneError> {
        if let Some(group) = self.groups.get(&id) {
            return Ok(group.clone());
        }
        let query = self.document.query(id);
        let mut members = Vec::new();
        for (property, child) in query.children() {
            let child = self.document.query(child);
            let plugin = child.object.plugin.as_str();
            if child.object.tag != "shape" {
                continue;
            }
            if plugin == "shapegroup" || plugin == "instance" {
                let message = "a group may contain neither groups nor instances";
                return Err(property.place.error(message));
            }
            let member = self.member(&child)?;
            if member.shape.emission.is_some() {
                return Err(property.place.error("a shape in a group may not emit"));
            }
            members.push(Member { source: member.source.settled(), ..member });
        }
        query.finish(&["shape"])?;
        let group = Rc::new(members);
        self.groups.insert(id, group.clone());
        Ok(group)
    }

    /// An `instance`: its group once more, placed by its own transform. Primitives are copied, so that rays
    /// need no second level; how many is limited.
    fn instance(&mut self, query: &Query, property: &'a Property) -> Result<(), SceneError> {
        let to_world = query.transform("to_world")?.unwrap_or(DMat4::IDENTITY);
        let group = query.child("shape")?;
        query.finish(&["shape"])?;
        let group = group.filter(|id| self.document.objects[*id].plugin == "shapegroup");
        let group = group.ok_or_else(|| query.error_at("", "needs a <ref> to a shapegroup"))?;
        for Member { source, shape } in self.group(group)?.iter() {
            let source = source.moved(&to_world);
            source.check().map_err(|message| query.error_at("to_world", message))?;
            self.copies.0 += 1;
            self.copies.1 += source.primitive_count();
            if self.copies.0 > MAX_COPIES.0 || self.copies.1 > MAX_COPIES.1 {
                let (shapes, primitives) = MAX_COPIES;
                return Err(query.error_at(
                    "",
                    format!(
                        "instances are copied, and add up to more than {shapes} shapes or {primitives} \
                         primitives, which take 3.4 gigabytes: use fewer of them, or a group with less in it"
                    ),
                ));
            }
            let shape = Shape { to_local: source.to_local(), ..shape.clone() };
            self.pending.push(Pending { source, shape, property });
        }
        Ok(())
    }

    /// All shapes as primitives, and where they have their zero in the file's world.
    ///
    /// `portals` are the ids of those that are no surfaces.
    fn parts(mut self, portals: &[String]) -> Result<(Parts, DVec3), SceneError> {
        let origin = shapes::origin(self.pending.iter().map(|p| &p.source));
        for Pending { source, shape, property } in self.pending {
            let geometry = source.geometry(origin).ok_or_else(|| {
                property.place.error(format!(
                    "too small or too large: coordinates must be at most {MAX_COORDINATE:e} and areas \
                     representable; scale the scene"
                ))
            })?;
            let total = self.scene.primitives.len() + geometry.primitives.len();
            // The upper half of the numbers is for surfaces that are no primitives.
            if total >= 1 << 31 {
                return Err(property.place.error("the scene has too many primitives"));
            }
            if portals.contains(&shape.name) {
                let corners = |p: super::Primitive| {
                    match p {
                    super::Primitive::Triangle { v0, v1, v2 } => Ok([v0, v1, v2]),
                    _ => Err(property.place.error(format!(
                        "`{}` is named as a portal, and a portal is made of triangles: use a rectangle or a mesh",
                        shape.name
                    ))),
                }
                };
                for primitive in geometry.primitives {
                    self.scene.portals.push(corners(primitive)?);
                }
                if shape.emission.is_some() {
                    self.document.warn(property.place.error(format!(
                        "`{}` is named as a portal, which is no surface: its emitter is left out",
                        shape.name
                    )));
                }
            } else {
                self.scene.add(shape, geometry);
            }
        }
        Ok((self.scene, origin))
    }

    fn add_bsdf(&mut self, bsdf: Bsdf) -> u32 {
        self.scene.bsdfs.push(bsdf);
        self.scene.bsdfs.len() as u32 - 1
    }

    fn bsdf(&mut self, id: ObjectId) -> Result<u32, SceneError> {
        if let Some(&index) = self.bsdf_indices.get(&id) {
            return Ok(index);
        }
        let bsdf = load_bsdf::read(self.document, id, &mut self.textures)?;
        let index = self.add_bsdf(bsdf);
        self.bsdf_indices.insert(id, index);
        Ok(index)
    }
}

impl Parts {
    /// What rays from eyes meet where these are not to see shapes that emit; none if there are no such shapes.
    ///
    /// A tree of its own costs rays nothing, and leaves no question of where a ray goes on that has passed through a
    /// shape, or through two at the same place.
    fn tracer_of_eyes(&self, reach: Vec3) -> Option<Tracer> {
        let is_dark = |shape: u32| self.shapes[shape as usize].emission.is_none();
        let shapes = (0..).zip(&self.primitive_shapes);
        let dark: Vec<u32> = shapes.filter(|(_, of)| is_dark(**of)).map(|(id, _)| id).collect();
        let any_emits = dark.len() < self.primitives.len();
        any_emits.then(|| Tracer::among(&self.primitives, &dark, reach))
    }

    fn add(&mut self, mut shape: Shape, geometry: Geometry) {
        let index = self.shapes.len() as u32;
        shape.first_primitive = self.primitives.len() as u32;
        shape.primitive_count = geometry.primitives.len() as u32;
        shape.first_normals = (!geometry.normals.is_empty()).then_some(self.normals.len() as u32);
        shape.first_texcoords =
            (!geometry.texcoords.is_empty()).then_some(self.texcoords.len() as u32);
        if let Some(emission) = shape.emission.filter(|emission| emission.value != Vec3::ZERO) {
            self.add_emitters(emission, shape.first_primitive, &geometry.primitives);
        }
        for (name, values) in geometry.attributes {
            let corners = geometry.primitives.iter().filter_map(|primitive| match primitive {
                Primitive::Triangle { v0, v1, v2 } => Some([*v0, *v1, *v2]),
                _ => None,
            });
            let patch =
                Patch { first: shape.first_primitive, triangles: corners.zip(values).collect() };
            self.attributes.push((name, patch));
        }
        self.primitive_shapes.extend(geometry.primitives.iter().map(|_| index));
        self.primitives.extend(geometry.primitives);
        self.normals.extend(geometry.normals);
        self.texcoords.extend(geometry.texcoords);
        self.degenerate += geometry.degenerate;
        self.shapes.push(shape);
    }

    /// The primitives of a shape that emits, the first of which has this number; two that make a rectangle are one light.
    fn add_emitters(&mut self, emission: Colour, first: u32, primitives: &[Primitive]) {
        let mut rest = primitives;
        while let [one, more @ ..] = rest {
            let is_rectangle = more.first().is_some_and(|o| Rectangle::of(one, o).is_some());
            let (light, others) = rest.split_at(if is_rectangle { 2 } else { 1 });
            self.emitters.push(Emitter {
                primitive: first + (primitives.len() - rest.len()) as u32,
                count: light.len() as u32,
                radiance: emission.value,
                texture: emission.texture,
                area: light.iter().map(Primitive::area).sum(),
            });
            rest = others;
        }
    }
}
