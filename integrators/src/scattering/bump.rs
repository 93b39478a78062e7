//! Normals that a texture turns: height fields and normal maps.

use aether_core::prelude::{Direction, Frame};
use glam::{DVec3, Vec2, Vec3};

use crate::kind::{Oriented, Presence, SceneKind};
use crate::scene::Tangents;
use crate::scene::bsdf::{Bump, Relief};
use crate::scene::texture::{Spot, Texture};
use crate::vertex::Surface;

/// What remains to be known of a surface once its normal is turned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bumped {
    /// The normal of the surface, on the viewer's side.
    normal: Vec3,
    /// The squared roughness of the facets that would scatter normals as widely as they are turned.
    alpha2: f32,
}

impl Bumped {
    /// The share of light from `w`, whose cosine with the turned normal is `turned`, that reaches the surface. None,
    /// where it comes from behind the surface but not from behind the turned one, or the other way round. Besides,
    /// where shadows are asked for, turned normals shade each other as those of GGX facets would (Estevez, Lecocq and
    /// Stein 2019).
    pub fn unhidden(&self, w: Vec3, turned: f32) -> f32 {
        let cosine = self.normal.dot(w);
        if cosine * turned <= 0.0 {
            return 0.0;
        }
        let tangent2 = (1.0 - cosine * cosine).max(0.0) / (cosine * cosine);
        2.0 / (1.0 + (1.0 + self.alpha2 * tangent2).sqrt())
    }
}

/// A surface before anything turns its normals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// Unit normal of the surface.
    normal: Vec3,
    /// Unit normal for shading.
    pub shading: Vec3,
    /// How texture coordinates run over it.
    pub tangents: Tangents,
    /// Where textures are looked up.
    pub spot: Spot,
    /// The way to the viewer, of any length.
    pub offset: Vec3,
    /// Where the viewer is.
    pub towards: Vec3,
}

impl Ground {
    /// A surface seen from some offset, whose direction is `towards`.
    #[inline(always)]
    pub fn new<K: SceneKind>(surface: &Surface<K>, [offset, towards]: [Vec3; 2]) -> Self {
        Ground {
            normal: surface.normal,
            shading: surface.shading,
            tangents: Oriented::<K>::value(surface.tangents),
            spot: Spot {
                uv: K::Textures::value(surface.uv),
                primitive: surface.primitive.0,
                position: surface.position,
            },
            offset,
            towards,
        }
    }
}

/// A frame about a unit normal whose first axis follows `tangent`, as far as there is one.
pub fn frame_along(normal: Vec3, tangent: Vec3) -> Frame<f32> {
    let n = normal.as_dvec3().normalize_or(DVec3::Z);
    let across = tangent.as_dvec3();
    let frame = (across - n.dot(across) * n).try_normalize().and_then(|s| {
        let [x, y, z] = [s, n.cross(s), n].map(|axis| axis.as_vec3().into());
        Frame::try_from_axes(x, y, z)
    });
    frame.unwrap_or_else(|| Frame::around(Direction::new(normal.x, normal.y, normal.z)))
}

/// What is seen of a surface whose normals are turned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seen {
    /// The side of the normal.
    Front,
    /// The other side, with the normals of the front from behind.
    Back,
    /// The back of a two-sided material: what the front has is seen in a mirror there.
    Mirrored,
}

/// The normal of a surface as a texture turns it, on the side that is seen.
pub fn turned(bump: Bump, textures: &[Texture], ground: &Ground, side: Seen) -> (Vec3, Bumped) {
    let Ground { shading, tangents, spot, towards, .. } = *ground;
    let frame = frame_along(shading, tangents.du);
    let texture = &textures[bump.texture as usize];
    let mut m = match bump.relief {
        Relief::Heights(scale) => {
            let normal = raised(ground, scale * texture.gradient(spot.uv));
            normal.map_or(Vec3::Z, |normal| frame.to_local(normal).into())
        }
        Relief::Normals => (2.0 * texture.on(&spot) - 1.0).try_normalize().unwrap_or(Vec3::Z),
    };
    let mut view: Vec3 = frame.to_local(towards).into();
    if side == Seen::Mirrored {
        view.z = -view.z;
    }
    if bump.flip_invalid && view.z * view.dot(m) <= 0.0 {
        m = Vec3::new(-m.x, -m.y, m.z);
    }
    let alpha2 =
        if bump.shadowing { (0.125 * (m.x * m.x + m.y * m.y) / (m.z * m.z)).min(1.0) } else { 0.0 };
    let (normal, seen) = match side {
        Seen::Front => (shading, m),
        Seen::Back => (-shading, -m),
        Seen::Mirrored => (-shading, Vec3::new(m.x, m.y, -m.z)),
    };
    (frame.to_world(seen).into(), Bumped { normal, alpha2 })
}

/// The normal of a surface that is raised along its normal by a height with this gradient in the texture
/// coordinates, to first order; none where the surface has no tangents.
fn raised(ground: &Ground, slope: Vec2) -> Option<Vec3> {
    let (n, tangents) = (ground.shading, ground.tangents);
    let along = |tangent: Vec3, slope: f32| tangent + (slope - n.dot(tangent)) * n;
    let normal = along(tangents.du, slope.x).cross(along(tangents.dv, slope.y)).try_normalize()?;
    Some(if normal.dot(ground.normal) < 0.0 { -normal } else { normal })
}
