//! Densities of other renderers at single points, from `reference/mitsuba-warp.csv`.

/// A point, and what another renderer says of it.
#[derive(Clone, Debug)]
pub struct PeerPoint {
    /// Parameters of the sampler.
    pub numbers: Vec<f64>,
    /// Uniforms.
    pub u: Vec<f64>,
    /// Their sample, rounded to single precision.
    pub x: Vec<f64>,
    /// The exact density of the sample before it was rounded.
    pub exact: f64,
    /// The other renderer's density at `x`.
    pub density: f64,
}

/// The points for a sampler.
///
/// # Panics
/// If the file is damaged.
pub fn peer_points(name: &str) -> Vec<PeerPoint> {
    let number = |text: &str| -> f64 { text.parse().expect("a number") };
    let numbers = |text: &str| text.split_whitespace().map(number).collect();
    let text = include_str!("../../reference/mitsuba-warp.csv");
    let lines = text.lines().skip(1).map(|line| line.split(',').collect::<Vec<_>>());
    lines
        .filter(|fields| fields[0] == name)
        .map(|f| PeerPoint {
            numbers: numbers(f[1]),
            u: numbers(f[2]),
            x: numbers(f[3]),
            exact: number(f[4]),
            density: number(f[5]),
        })
        .collect()
}
