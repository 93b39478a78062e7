//! How a part of a material lies: its frame, and where the viewer is in it.

use aether_core::prelude::{Direction, Frame};
use glam::Vec3;

use super::bump::{self, Bumped, Ground};
use super::material::Layer;
use crate::kind::{Oriented, Presence, SceneKind};
use crate::scene::texture::Texture;

/// The frame of a part of a material at a point. Textures may turn its normals, each part's its own way.
#[derive(Clone, Copy, Debug)]
pub struct Pose<K: SceneKind> {
    /// The normal on the side of the viewer.
    normal: Vec3,
    /// Where the viewer is, in world coordinates.
    towards: Vec3,
    /// How far above the viewer is, per any length.
    height: f32,
    /// The frame, if it follows the texture coordinates.
    along: <Oriented<K> as Presence>::Field<Option<Frame<f32>>>,
    bumped: <K::Bumps as Presence>::Field<Option<Bumped>>,
}

impl<K: SceneKind> Pose<K> {
    /// How a part lies on a surface whose shading normal on the side of the viewer is `n`; an `oriented` one follows
    /// the texture coordinates.
    #[inline(always)]
    pub fn new(
        layer: &Layer<K>,
        oriented: bool,
        ground: &Ground,
        n: Vec3,
        textures: &[Texture],
    ) -> Self {
        let tangent = ground.tangents.du;
        let (along, bumped) = match layer.bump {
            Some(bump) => {
                let (map, front) = K::Bumps::get(bump);
                let behind = ground.shading.dot(ground.offset) <= 0.0;
                let side = match behind {
                    false => bump::Seen::Front,
                    true if front => bump::Seen::Mirrored,
                    // Where normals are not flipped, those of the front may face the viewer behind.
                    true if !map.flip_invalid && layer.model.is_opaque() => bump::Seen::Front,
                    true => bump::Seen::Back,
                };
                let (normal, bumped) = bump::turned(map, textures, ground, side);
                (Some(bump::frame_along(normal, tangent)), Some(bumped))
            }
            None if Oriented::<K>::VALUE.is_some() && oriented => {
                (Some(bump::frame_along(n, tangent)), None)
            }
            None => (None, None),
        };
        let normal = along.map_or(n, |frame| frame.z.into());
        let height = match bumped {
            Some(_) => normal.dot(ground.offset),
            None => ground.shading.dot(ground.offset).abs(),
        };
        let (along, bumped) = (Oriented::<K>::field(|| along), K::Bumps::field(|| bumped));
        Pose { normal, towards: ground.towards, height, along, bumped }
    }

    /// The frame about the normal on the side of the viewer.
    #[inline(always)]
    pub fn frame(&self) -> Frame<f32> {
        let any = || Frame::around(Direction::from_unit(self.normal.into()));
        Oriented::<K>::value(self.along).unwrap_or_else(any)
    }

    /// The cosine of a direction (in world coordinates, of unit length) with the normal.
    #[inline(always)]
    pub fn cosine(&self, w: Vec3) -> f32 {
        self.normal.dot(w)
    }

    /// Where the viewer is, in the frame: above, unless the normals are turned away.
    #[inline(always)]
    pub fn view(&self) -> Direction<f32> {
        let mut view = self.frame().to_local(self.towards);
        view.z = self.view_cosine();
        Direction::from_unit(view)
    }

    /// The cosine of the viewer's direction with the normal.
    #[inline(always)]
    pub fn view_cosine(&self) -> f32 {
        let cosine = self.cosine(self.towards);
        // The direction is rounded once more than the offset.
        if self.height > 0.0 { cosine.max(f32::EPSILON * f32::EPSILON) } else { cosine }
    }

    /// Whether the viewer is above; what is turned away scatters nothing.
    #[inline(always)]
    pub fn is_seen(&self) -> bool {
        self.height > 0.0
    }

    /// What is left of light from `w` (in world coordinates) because the normals are turned.
    #[inline]
    pub fn unhidden(&self, w: Vec3) -> f32 {
        K::Bumps::value(self.bumped).map_or(1.0, |bumped| bumped.unhidden(w, self.cosine(w)))
    }

    /// The direction straight on.
    pub fn passed(&self) -> Direction<f32> {
        let v = self.view();
        Direction::new(-v.x, -v.y, -v.z)
    }

    /// The mirror direction.
    pub fn mirrored(&self) -> Direction<f32> {
        let v = self.view();
        Direction::new(-v.x, -v.y, v.z)
    }

    /// The direction in which a boundary with this relative index of refraction bends light.
    pub fn bent(&self, eta: f32) -> Direction<f32> {
        let v = self.view();
        let (_, beyond) = super::fresnel::dielectric(v.z, eta);
        Direction::new(-v.x / eta, -v.y / eta, -beyond)
    }
}
