//! Ways to make paths, and the images beside the image, which show what they contribute.

use std::fmt;

/// A way to make paths of some length.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Technique {
    /// How many vertices the paths have.
    pub vertices: usize,
    /// What joins their ends: nothing for an edge between them, or the name of what lies there.
    pub joint: &'static str,
    /// How many vertices come from the camera.
    pub camera: usize,
    /// How many vertices come from the light.
    pub light: usize,
}

impl Technique {
    /// What joins the pieces of a merged path.
    pub const MERGE: &str = "merge";
    /// What joins pieces of paths through a portal.
    pub const PORTAL: &str = "portal";

    /// What joins pieces, by its name, which lives as long as the program like those that are written in it.
    pub fn joint_called(name: &str) -> &'static str {
        let known = ["", Self::MERGE, "mutated", Self::PORTAL];
        known.into_iter().find(|known| *known == name).unwrap_or_else(|| name.to_owned().leak())
    }

    /// An edge between vertices from the camera and from the light.
    pub fn edge(camera: usize, light: usize) -> Self {
        Technique { vertices: camera + light, joint: "", camera, light }
    }

    /// A vertex where pieces from the camera and from the light meet, which belongs to both.
    pub fn merge(camera: usize, light: usize) -> Self {
        Technique {
            vertices: (camera + light).saturating_sub(1),
            joint: Self::MERGE,
            camera,
            light,
        }
    }

    /// A segment of two vertices through a portal, between vertices from the camera and from the light.
    pub fn portal(camera: usize, light: usize) -> Self {
        Technique { vertices: camera + light + 2, joint: Self::PORTAL, camera, light }
    }

    /// Mutations of paths with so many vertices, which have no ends where they began.
    pub fn mutations(vertices: usize) -> Self {
        Technique { vertices, joint: "mutated", camera: vertices, light: 0 }
    }
}

/// An image beside the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Layer {
    /// Light that the camera sees at its source, where that is kept apart.
    Direct,
    /// How pixels differ from their right neighbours.
    Dx,
    /// How pixels differ from their lower neighbours.
    Dy,
    /// What one technique contributes.
    Technique {
        /// Whether contributions have their weights.
        weighted: bool,
        /// Which technique.
        technique: Technique,
    },
}

impl fmt::Display for Layer {
    /// The name of the channels in a file.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Layer::Direct => write!(f, "direct"),
            Layer::Dx => write!(f, "dx"),
            Layer::Dy => write!(f, "dy"),
            Layer::Technique { weighted, technique: Technique { joint, camera, light, .. } } => {
                let weighted = if *weighted { "weighted" } else { "alone" };
                let dash = if joint.is_empty() { "" } else { "-" };
                write!(f, "{weighted}.{joint}{dash}s{light}t{camera}")
            }
        }
    }
}
