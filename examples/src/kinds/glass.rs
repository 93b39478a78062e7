//! A path tracer for one kind of scenes; a test looks what is in this program.

use integrators::scene_kind;

mod render;

scene_kind! {
    /// Matte walls, lamps and rough glass.
    pub struct Glass: Diffuse, RoughDielectric, Area;
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    render::mean::<Glass>()
}
