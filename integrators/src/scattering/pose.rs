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
    /// The frame about the normal on the side of the viewer.
    pub frame: Frame<f32>,
    /// Where the viewer is, in the frame: above, unless the normals are turned away.
    pub view: Direction<f32>,
    /// How far above the viewer is, per any length.
    height: f32,
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
        let (frame, bumped) = match layer.bump {
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
                (bump::frame_along(normal, tangent), Some(bumped))
            }
            None if Oriented::<K>::VALUE.is_some() && oriented => {
                (bump::frame_along(n, tangent), None)
            }
            None => (Frame::around(Direction::from_unit(n.into())), None),
        };
        let height = match bumped {
            Some(_) => frame.to_local(ground.offset).z,
            None => ground.shading.dot(ground.offset).abs(),
        };
        let mut view = frame.to_local(ground.towards);
        if height > 0.0 {
            // The direction is rounded once more than the offset.
            view.z = view.z.max(f32::EPSILON * f32::EPSILON);
        }
        let view = Direction::from_unit(view);
        Pose { frame, view, height, bumped: K::Bumps::field(|| bumped) }
    }

    /// Whether the viewer is above; what is turned away scatters nothing.
    #[inline(always)]
    pub fn is_seen(&self) -> bool {
        self.height > 0.0
    }

    /// What is left of light from `w` (in world coordinates) because the normals are turned.
    #[inline]
    pub fn unhidden(&self, w: Vec3) -> f32 {
        K::Bumps::value(self.bumped).map_or(1.0, |bumped| bumped.unhidden(w, self.frame))
    }

    /// The direction straight on.
    pub fn passed(&self) -> Direction<f32> {
        let v = self.view;
        Direction::new(-v.x, -v.y, -v.z)
    }

    /// The mirror direction.
    pub fn mirrored(&self) -> Direction<f32> {
        let v = self.view;
        Direction::new(-v.x, -v.y, v.z)
    }

    /// The direction in which a boundary with this relative index of refraction bends light.
    pub fn bent(&self, eta: f32) -> Direction<f32> {
        let v = self.view;
        let (_, beyond) = super::fresnel::dielectric(v.z, eta);
        Direction::new(-v.x / eta, -v.y / eta, -beyond)
    }
}
