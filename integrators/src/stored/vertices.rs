//! Vertices of paths as bytes. Primitives, emitters and lights are numbers of the scene, which the file that keeps
//! a vertex has to belong to.

use std::io::{self, Read, Write};

use glam::Vec2;

use super::{Stored, malformed};
use crate::kind::{Oriented, Presence, SceneKind};
use crate::scene::{PrimitiveId, Tangents};
use crate::vertex::{Place, SceneVertex, SkyOf, Surface};

impl Stored for Tangents {
    fn store(&self, to: &mut dyn Write) -> io::Result<()> {
        [self.du, self.dv].store(to)
    }

    fn load(from: &mut dyn Read) -> io::Result<Self> {
        let [du, dv] = Stored::load(from)?;
        Ok(Tangents { du, dv })
    }
}

impl<K: SceneKind> Stored for Surface<K> {
    fn store(&self, to: &mut dyn Write) -> io::Result<()> {
        [self.position, self.normal, self.shading].store(to)?;
        (self.primitive.0, self.emitter).store(to)?;
        K::Textures::value::<Vec2>(self.uv).store(to)?;
        Oriented::<K>::value::<Tangents>(self.tangents).store(to)
    }

    fn load(from: &mut dyn Read) -> io::Result<Self> {
        let [position, normal, shading] = Stored::load(from)?;
        let (primitive, emitter) = Stored::load(from)?;
        let (uv, tangents) = (Stored::load(from)?, Stored::load(from)?);
        Ok(Surface {
            position,
            normal,
            shading,
            primitive: PrimitiveId(primitive),
            emitter,
            uv: K::Textures::field(|| uv),
            tangents: Oriented::<K>::field(|| tangents),
        })
    }
}

impl<K: SceneKind> Stored for SceneVertex<K> {
    fn store(&self, to: &mut dyn Write) -> io::Result<()> {
        self.position.store(to)?;
        match self.place {
            Place::Camera => 0u8.store(to),
            Place::Parallel(_) => 1u8.store(to),
            Place::Backdrop(_) => 2u8.store(to),
            Place::Surface(surface) => {
                3u8.store(to)?;
                surface.store(to)
            }
            Place::Sky(_) => 4u8.store(to),
            Place::Bulb(number) => (5u8, K::Point::get::<u32>(number)).store(to),
            Place::Distant(number) => (6u8, K::Directional::get::<u32>(number)).store(to),
        }
    }

    fn load(from: &mut dyn Read) -> io::Result<Self> {
        let (position, place) = Stored::load(from)?;
        let place = match place {
            0u8 => Some(Place::Camera),
            1 => K::Orthographic::VALUE.map(Place::Parallel),
            2 => {
                SkyOf::<K>::VALUE.and_then(|sky| K::Orthographic::with(|| sky)).map(Place::Backdrop)
            }
            3 => Some(Place::Surface(Surface::load(from)?)),
            4 => SkyOf::<K>::VALUE.map(Place::Sky),
            5 => {
                let number = u32::load(from)?;
                K::Point::with(|| number).map(Place::Bulb)
            }
            6 => {
                let number = u32::load(from)?;
                K::Directional::with(|| number).map(Place::Distant)
            }
            _ => None,
        };
        let place = place.ok_or_else(|| malformed("a vertex that this kind of scene has not"))?;
        Ok(SceneVertex { position, place })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kind::{DiffuseRooms, Everything, Present};
    use glam::Vec3;

    #[test]
    fn vertices_of_all_places() {
        let surface = Surface::<Everything> {
            position: Vec3::new(1.0, 2.0, 3.0),
            normal: Vec3::X,
            shading: Vec3::Y,
            primitive: PrimitiveId(7),
            emitter: Some(3),
            uv: Vec2::new(0.25, 0.5),
            tangents: Tangents { du: Vec3::X, dv: Vec3::Z },
        };
        let places = [
            Place::Camera,
            Place::Parallel(Present),
            Place::Backdrop(Present),
            Place::Surface(surface),
            Place::Sky(Present),
            Place::Bulb(4),
            Place::Distant(5),
        ];
        for (number, place) in places.into_iter().enumerate() {
            let vertex = SceneVertex::<Everything> { position: Vec3::new(0.1, -0.0, 1e-40), place };
            let mut file = Vec::new();
            vertex.store(&mut file).unwrap();
            assert_eq!(SceneVertex::load(&mut &file[..]).unwrap(), vertex);
            // A kind without such a place says so.
            let other = SceneVertex::<DiffuseRooms>::load(&mut &file[..]);
            let absent = ![0, 3].contains(&number);
            assert_eq!(other.is_err(), absent, "{number}: {other:?}");
        }
    }
}
