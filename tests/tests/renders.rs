//! The path tracer against images that another renderer made, and against exact answers.

use integrators::image::block_test::holm;
use integrators::path::PathTracer;
use integrators::render::Film;
use integrators::scene::SamplerKind::{self, Independent, LowDiscrepancy};
use tests::renders::{MisjudgingTracer, Reference, film, path_traced, scene, scores, settings};

#[test]
fn explore() {
    let names = [
        "cornell-box", "rectangle", "cube", "sphere", "disk", "obj", "ply-ascii", "ply-binary", "two-lights",
        "tent-filter", "gaussian-filter", 
    ];
    let spp: u32 = std::env::var("SPP").unwrap().parse().unwrap();
    for name in names {
        let reference = Reference::stored(name);
        let scene = scene(name);
        for (a, b) in [(1.0, 1.0), (1.0, 1.01)] {
            let t = std::time::Instant::now();
            let mut tracer = MisjudgingTracer::new(&scene, 1);
            (tracer.scatter_factor, tracer.light_factor) = (a, b);
            let film = film(&tracer, &scene, spp, None);
            let s = scores(&film, &reference);
            let n = s.len();
            let max = s[..n - 6].iter().map(|s| s.z.abs()).fold(0.0, f64::max);
            let w = &s[n - 6..n-3]; let q = &s[n-3..];
            println!("{name:18} {a:.2} {b:.2} {:5.1}s block {max:6.2}  mean z {:7.2} {:7.2} {:7.2}  ratio {:.5} {:.5} {:.5}  W {:6.2} {:6.2} {:6.2}",
                t.elapsed().as_secs_f64(), w[0].z, w[1].z, w[2].z,
                w[0].mean / w[0].reference_mean, w[1].mean / w[1].reference_mean, w[2].mean / w[2].reference_mean, q[0].z, q[1].z, q[2].z);
        }
    }
}
