//! A scene with what sampling needs beside it: lights as a discrete distribution, materials, frames.

use aether_core::Sampler;
use aether_core::prelude::{Direction, Frame, Vec2};
use glam::Vec3;

use crate::eye::{Lens, ParallelFilm};
use crate::film_filter::{FilmProfile, FilterTable, ImagePoints};
use crate::kind::{Everything, NotCovered, Oriented, Presence, SceneKind, With, covers};
use crate::lights::{AreaLight, Form, Lights};
use crate::render::shares::Shares;
use crate::scattering::{Material, Scattering};
use crate::scene::{Camera, Filter, Hit, Primitive, PrimitiveId, Scene, Sight, Sky, Tangents, hit};
use crate::strategies::Pixel;
use crate::vertex::{Eye, Place, SceneVertex, Seen, SkyOf, Surface};

/// A scene ready for the strategies.
pub struct World<'s, K: SceneKind = Everything> {
    /// The scene.
    pub scene: &'s Scene,
    /// The lights.
    pub lights: Lights<K>,
    /// The materials, in the order of the scene's.
    materials: Vec<Material<K>>,
    /// What each primitive is.
    pieces: Vec<Piece>,
    /// The least roughness of any material.
    least_roughness: f32,
    /// The camera's axes: right, down, forward.
    pub camera_frame: Frame<f32>,
    /// The film, as a pinhole sees it.
    pub(crate) film: PinholeFilm,
    /// One over the integral of the reconstruction filter, and over the area of the lens if there is one.
    pub filter_scale: f32,
    /// The lens, if there is one.
    lens: Option<With<K::ThinLens, Lens>>,
    /// The film, if its rays are parallel.
    parallel: Option<With<K::Orthographic, ParallelFilm>>,
    /// How film points are drawn if the filter has negative lobes.
    filter_table: Option<FilterTable>,
    /// How film points are drawn that count for all pixels, if the filter is no box.
    film_profile: Option<FilmProfile>,
}

impl<'s, K: SceneKind> World<'s, K> {
    /// Prepares a scene.
    ///
    /// # Errors
    /// If the scene needs what the kind leaves out.
    pub fn new(scene: &'s Scene) -> Result<Self, NotCovered> {
        // Some features leave no trace below: without textures a colour would be their mean.
        covers::<K>(scene)?;
        let materials_of = scene.primitive_shapes.iter().map(|s| scene.shapes[*s as usize].bsdf);
        let mut pieces: Vec<Piece> =
            materials_of.map(|material| Piece { material, emitter: Piece::DARK }).collect();
        for (index, emitter) in (0..).zip(&scene.emitters) {
            for primitive in emitter.primitives() {
                pieces[primitive as usize].emitter = index;
            }
        }
        let materials = scene.bsdfs.iter().map(Material::new).collect::<Result<_, _>>()?;
        let least_roughness =
            scene.bsdfs.iter().map(|bsdf| bsdf.roughness()).fold(f32::INFINITY, f32::min);
        let camera_frame = camera_frame(&scene.camera);
        let lens = Lens::of(&scene.camera);
        let filter_scale = 1.0 / profile_integral(scene.film.filter).powi(2);
        let filter_scale = filter_scale / lens.map_or(1.0, |lens| lens.area());
        let lens = lens.and_then(|lens| K::ThinLens::with(|| lens));
        let parallel = ParallelFilm::of(&scene.camera, PinholeFilm::of(&scene.camera).centre);
        let parallel = parallel.and_then(|film| K::Orthographic::with(|| film));
        let lights = Lights::new(scene)?;
        let filter_table = K::SignedFilter::VALUE.and_then(|_| FilterTable::new(scene.film.filter));
        let film_profile = FilmProfile::new(scene.film.filter);
        Ok(World {
            scene,
            lights,
            materials,
            least_roughness,
            pieces,
            camera_frame,
            film: PinholeFilm::of(&scene.camera),
            filter_scale,
            lens,
            parallel,
            filter_table,
            film_profile,
        })
    }

    /// The camera's lens, if it has one.
    #[inline]
    pub fn lens(&self) -> Option<Lens> {
        self.lens.map(K::ThinLens::get)
    }

    /// The camera's film, if its rays are parallel.
    #[inline]
    pub fn parallel(&self) -> Option<ParallelFilm> {
        self.parallel.map(K::Orthographic::get)
    }

    /// How film points are drawn if the filter has negative lobes.
    #[inline]
    pub fn filter_table(&self) -> Option<&FilterTable> {
        K::SignedFilter::VALUE.and(self.filter_table.as_ref())
    }

    /// How film points are drawn that count for all pixels, if the filter is no box.
    #[inline]
    pub fn film_profile(&self) -> Option<&FilmProfile> {
        self.film_profile.as_ref()
    }

    /// What a sample that is made for all pixels ([`ImagePoints`]) counts at a film point if it is for its own pixel alone:
    /// the value of its filter, over its part in the densities of all.
    pub fn counts_alone(&self, pixel: Pixel, point: Vec2<f32>) -> f32 {
        let film = &self.scene.film;
        if film.filter == Filter::Box {
            // Rounding may have moved the point to the next pixel.
            return 1.0;
        }
        let points = ImagePoints::new(self.film_profile(), pixel);
        let own = points.own().pdf(&point).value();
        let all = points.pdf(&point).value();
        if own > 0.0 { film.response(pixel, point) * all / own } else { 0.0 }
    }

    /// Has shares be those of a sample of a pixel that is made for all, at a film point.
    pub fn share(&self, shares: &mut Shares, pixel: Pixel, point: Vec2<f32>) {
        shares.move_to(&self.scene.film, pixel, point);
        let total = shares.total();
        shares.count_own(|| self.counts_alone(pixel, point) / total);
    }

    /// The eye of a camera without a lens.
    pub fn eye(&self) -> Eye<K> {
        let infinite = self.parallel().and_then(|film| K::Orthographic::with(|| -film.forward));
        infinite.map_or(Eye::Pinhole(self.scene.camera.origin), Eye::Parallel)
    }

    /// What a ray from a vertex in direction `w` meets first.
    #[inline]
    pub fn cast(&self, from: &SceneVertex<K>, w: &Direction<f32>) -> Option<Seen<K>> {
        if self.scene.hides_emitters() && from.is_eye() {
            return self.seen_by_eye(from.position, w.vec().into());
        }
        self.seen(from.position, w.vec().into(), from.primitive())
    }

    /// What a point of the film of a parallel projection sees.
    pub fn seen_from_film(&self, film: &Vec2<f32>) -> Option<Seen<K>> {
        let parallel = self.parallel()?;
        self.seen_by_eye(parallel.point(film), parallel.forward)
    }

    /// The first surface on a ray that leaves a primitive, or the sky behind everything.
    fn seen(&self, origin: Vec3, w: Vec3, from: Option<PrimitiveId>) -> Option<Seen<K>> {
        self.scene.sight().intersect_then(origin, w, from, |hit| self.seen_at(hit))
    }

    /// The same of a ray from an eye, which may not see shapes that emit: by itself, as all other rays know while compiling
    /// where their tree is.
    #[cold]
    fn seen_by_eye(&self, origin: Vec3, w: Vec3) -> Option<Seen<K>> {
        self.seen_at(self.scene.sight_of_eyes().intersect(origin, w, None))
    }

    #[inline(always)]
    fn seen_at(&self, hit: Option<Hit>) -> Option<Seen<K>> {
        match hit {
            Some(hit) => Some(Seen::Surface(self.surface_at(&hit))),
            // Without a sky that shines there is nothing to see.
            None => self.sky().map(Seen::Sky),
        }
    }

    /// The piece of surface at a hit.
    #[inline(always)]
    fn surface_at(&self, hit: &Hit) -> Surface<K> {
        Surface {
            position: hit.position,
            normal: hit.geometric_normal,
            shading: hit.shading_normal,
            primitive: hit.primitive,
            emitter: self.piece(hit.primitive).emitter(),
            uv: K::Textures::field(|| self.texture_coordinates(hit)),
            tangents: Oriented::<K>::field(|| self.tangents(hit)),
        }
    }

    /// The sky, if there is one.
    pub fn sky(&self) -> Option<SkyOf<K>> {
        self.scene.sky.as_ref().and(Presence::VALUE)
    }

    /// The first surface on a ray that leaves a primitive, or none.
    #[inline]
    pub fn trace(&self, origin: Vec3, w: Vec3, from: Option<PrimitiveId>) -> Option<Surface<K>> {
        self.seen(origin, w, from)?.surface()
    }

    /// The first surface that light from infinitely far away meets, where it comes through the point `p`
    /// of a [`World::window`].
    pub fn shone_on(&self, window: &ParallelFilm, p: &Vec2<f32>) -> Option<Surface<K>> {
        self.trace(window.point(p), window.forward, None)
    }

    /// The first surface behind a window in the scene that light from infinitely far away meets, where it comes
    /// through the point `p`; none if something keeps it from the window.
    pub fn shone_on_inside(&self, window: &ParallelFilm, p: &Vec2<f32>) -> Option<Surface<K>> {
        let from = window.point(p);
        let is_open = self.scene.is_open(from, None, -window.forward);
        if is_open { self.trace(from, window.forward, None) } else { None }
    }

    /// The plane through which light from a direction, of unit length, comes to the scene: where it is
    /// further than [`Lights::bounds`] says from the middle, it passes by.
    pub fn window(&self, towards: Vec3) -> ParallelFilm {
        let frame = Frame::around(Direction::from_unit(towards.into()));
        let axis = |x, y| frame.to_world(aether_core::Vec3::new(x, y, 0.0)).into();
        let (middle, radius) = self.lights.bounds;
        ParallelFilm {
            origin: middle + radius * towards,
            centre: Vec2::new(0.0, 0.0),
            across: axis(1.0, 0.0),
            down: axis(0.0, 1.0),
            forward: -towards,
        }
    }

    #[inline(always)]
    fn piece(&self, id: PrimitiveId) -> Piece {
        self.pieces[id.0 as usize]
    }

    /// The texture coordinates at a hit, if the scene has textures.
    #[inline]
    fn texture_coordinates(&self, hit: &Hit) -> glam::Vec2 {
        if self.scene.textures.is_empty() {
            return glam::Vec2::ZERO;
        }
        self.scene.texture_coordinates(hit)
    }

    /// How texture coordinates run over a surface, if its material depends on it.
    #[inline]
    fn tangents(&self, hit: &Hit) -> Tangents {
        let material = self.piece(hit.primitive).material;
        let oriented = self.materials[material as usize].is_oriented();
        if oriented { self.scene.tangents(hit) } else { Tangents::default() }
    }

    /// The surface that a ray from a vertex in direction `w` meets first.
    pub fn hit(&self, from: &SceneVertex<K>, w: &Direction<f32>) -> Option<Surface<K>> {
        self.cast(from, w)?.surface()
    }

    /// Whether nothing lies between two vertices. An eye sees none that lies on a shape which is hidden from it.
    pub fn visible(&self, from: &SceneVertex<K>, to: &SceneVertex<K>) -> bool {
        if self.scene.hides_emitters() && (from.is_eye() || to.is_eye()) {
            return self.visible_to_eye(from, to);
        }
        self.visible_in(self.scene.sight(), from, to)
    }

    #[cold]
    fn visible_to_eye(&self, from: &SceneVertex<K>, to: &SceneVertex<K>) -> bool {
        let mut on = [from, to].into_iter().filter_map(SceneVertex::primitive);
        !on.any(|id| self.scene.is_hidden(id))
            && self.visible_in(self.scene.sight_of_eyes(), from, to)
    }

    #[inline(always)]
    fn visible_in(&self, sight: Sight<'_>, from: &SceneVertex<K>, to: &SceneVertex<K>) -> bool {
        if let Some(film) = self.parallel() {
            // Such an eye sees what lies in front of its film.
            for (eye, other) in [(from, to), (to, from)] {
                if matches!(eye.place, Place::Parallel(_)) {
                    let before = film.before(other.position);
                    return sight.visible(before, None, other.position, other.primitive());
                }
            }
        }
        if to.is_infinite() {
            return sight.is_open(from.position, from.primitive(), to.position);
        }
        sight.visible(from.position, from.primitive(), to.position, to.primitive())
    }

    /// Whether a flat light shines to the side on which a point lies.
    #[inline(always)]
    pub fn faces(&self, light: &AreaLight, point: Vec3) -> bool {
        light.flat.as_ref().is_none_or(|flat| flat.faces(point))
    }

    /// The piece of a light that a ray in one of the directions in which it is seen meets first.
    pub fn lit(
        &self,
        light: &AreaLight,
        from: &SceneVertex<K>,
        w: &Direction<f32>,
    ) -> Option<Surface<K>> {
        let (origin, w) = (from.position, w.vec().into());
        let point = match light.shape {
            Form::Rectangle(_) | Form::Single(Primitive::Triangle { .. }) => {
                light.flat.as_ref()?.plane.met_by(origin, w)?
            }
            Form::Single(Primitive::Sphere { center, radius, .. }) => {
                hit::nearest_on_sphere(origin, w, center, radius)
            }
            Form::Single(Primitive::Disk { .. } | Primitive::Cylinder { .. }) => return None,
        };
        Some(self.light_surface(light, point))
    }

    /// The piece of surface of a light at a point of it.
    pub fn light_surface(&self, light: &AreaLight, position: Vec3) -> Surface<K> {
        let is_second = match &light.shape {
            Form::Rectangle(rectangle) => rectangle.is_beyond_diagonal(position),
            Form::Single(_) => false,
        };
        let primitive = PrimitiveId(light.emitter.primitive + u32::from(is_second));
        let normal = match &light.flat {
            Some(flat) => flat.normals[usize::from(is_second)],
            None => self.scene.normal(primitive, position),
        };
        // The path ends here: only a texture of the emission matters.
        let uv = K::Textures::field(|| match light.emitter.texture {
            Some(_) => self.scene.texture_coordinates_at(primitive, position),
            None => glam::Vec2::ZERO,
        });
        let (emitter, tangents) = (Some(light.index), Default::default());
        Surface { position, normal, shading: normal, primitive, emitter, uv, tangents }
    }

    /// What a vertex emits towards another, in linear Rec. 709: radiance, of a point light intensity, of
    /// parallel light irradiance.
    pub fn emitted(&self, vertex: &SceneVertex<K>, towards: &SceneVertex<K>) -> Vec3 {
        let w = || towards.direction_from(vertex.position);
        match vertex.place {
            Place::Camera | Place::Parallel(_) => Vec3::ZERO,
            Place::Backdrop(sky) => {
                let sky = K::Orthographic::get(sky);
                let position = -towards.position;
                self.emitted(&SceneVertex { position, place: Place::Sky(sky) }, towards)
            }
            Place::Surface(surface) => match surface.emitter {
                Some(e) if surface.normal.dot(towards.offset_from(vertex.position)) > 0.0 => {
                    let emitter = &self.scene.emitters[e as usize];
                    match emitter.texture {
                        Some(texture) if K::Textures::VALUE.is_some() => {
                            let uv = K::Textures::value(surface.uv);
                            self.scene.textures[texture as usize].at(uv)
                        }
                        _ => emitter.radiance,
                    }
                }
                _ => Vec3::ZERO,
            },
            Place::Sky(_) => match &self.scene.sky {
                Some(Sky::Constant(radiance)) => *radiance,
                Some(Sky::Picture(map)) if K::Envmap::VALUE.is_some() => {
                    map.radiance(vertex.position)
                }
                _ => Vec3::ZERO,
            },
            Place::Bulb(index) => {
                let textures = K::Textures::VALUE.map_or(&[][..], |_| &self.scene.textures);
                let bulb = &self.scene.bulbs[K::Point::get(index) as usize];
                bulb.intensity_towards(w(), textures)
            }
            Place::Distant(index) => {
                self.scene.distant[K::Directional::get(index) as usize].irradiance
            }
        }
    }

    /// How the surface at a vertex scatters light to or from another vertex: `None` if there is no
    /// surface or if that side is black.
    #[inline(always)]
    pub fn scattering(
        &self,
        here: &SceneVertex<K>,
        other: &SceneVertex<K>,
    ) -> Option<Scattering<'_, K>> {
        let surface = here.surface()?;
        let material = &self.materials[self.piece(surface.primitive).material as usize];
        let offset = other.offset_from(here.position);
        let towards = other.direction_from(here.position);
        Scattering::new(material, &self.scene.textures, &surface, [offset, towards])
    }

    /// The least roughness of what a vertex scatters by beside atoms; infinite where there is no surface.
    pub fn roughness(&self, vertex: &SceneVertex<K>) -> f32 {
        vertex.primitive().map_or(f32::INFINITY, |primitive| {
            self.scene.bsdfs[self.scene.shape(primitive).bsdf as usize].roughness()
        })
    }

    /// The least [`World::roughness`] of any vertex.
    pub fn least_roughness(&self) -> f32 {
        self.least_roughness
    }

    /// The number of the lobe of the atom that scatters at a vertex from one neighbour to the other.
    pub fn mirror_between(
        &self,
        before: &SceneVertex<K>,
        here: &SceneVertex<K>,
        next: &SceneVertex<K>,
    ) -> Option<u32> {
        let scattering = self.scattering(here, before)?;
        let mut leading = scattering.leading_to(Some(next.direction_from(here.position)));
        let is_atom = |lobe: &usize| scattering.lobe(*lobe).is_some_and(|l| l.lobe.is_atom());
        leading.find(is_atom).map(|lobe| lobe as u32)
    }
}

/// What a primitive is.
#[derive(Clone, Copy, Debug)]
struct Piece {
    /// Its material.
    material: u32,
    /// Its emitter, or [`Piece::DARK`].
    emitter: u32,
}

impl Piece {
    const DARK: u32 = u32::MAX;

    #[inline(always)]
    fn emitter(self) -> Option<u32> {
        (self.emitter != Self::DARK).then_some(self.emitter)
    }
}

/// Where the film of a pinhole is, computed once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PinholeFilm {
    /// The point that the camera's axis goes through, in pixels of the image.
    pub centre: Vec2<f32>,
    /// Width and height of a pixel at distance one.
    pub scale: Vec2<f32>,
}

impl PinholeFilm {
    fn of(camera: &Camera) -> Self {
        let Camera { width, height, principal, crop, tan_x, tan_y, .. } = *camera;
        let along = |offset: f32, size: u32, crop: f32| (0.5 - offset) * size as f32 - crop;
        PinholeFilm {
            centre: Vec2::new(
                along(principal.x, width, crop.x),
                along(principal.y, height, crop.y),
            ),
            scale: Vec2::new(2.0 * tan_x / width as f32, 2.0 * tan_y / height as f32),
        }
    }
}

fn camera_frame(camera: &Camera) -> Frame<f32> {
    let [x, y, z] = [camera.right, -camera.up, camera.forward].map(|v| v.as_dvec3());
    let axes = Frame::try_from_axes(x.as_vec3().into(), y.as_vec3().into(), z.as_vec3().into());
    // The loader has made the axes orthonormal.
    axes.unwrap_or_else(|| Frame::around(Direction::new(0.0, 0.0, 1.0)))
}

/// The integral of the filter's profile along one axis, by Simpson's rule on each half.
pub(crate) fn profile_integral(filter: Filter) -> f32 {
    const PANELS: usize = 64;
    let h = f64::from(filter.radius()) / PANELS as f64;
    let sum: f64 = (0..=PANELS)
        .map(|i| {
            let weight = if i == 0 || i == PANELS { 1.0 } else { 2.0 + 2.0 * (i % 2) as f64 };
            weight * f64::from(filter.profile((h * i as f64) as f32))
        })
        .sum();
    (2.0 * sum * h / 3.0) as f32
}
