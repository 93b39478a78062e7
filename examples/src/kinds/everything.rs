//! A path tracer for all scenes; a test looks what is in this program.

use integrators::kind::Everything;

mod render;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    render::mean::<Everything>()
}
