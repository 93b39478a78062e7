//! One short file for each thing that a user wants to learn; each is a program of its own and ends
//! with a test. Run one with `cargo run --release -p examples --bin NAME`.
//!
//! - `irradiance`: an integral estimated with one sampler, and with two combined.
//! - `new_sampler`: a sampler that no library has, what was derived for it, and how to check it.
//! - `custom_strategy`: a scattering strategy of your own in the renderer's path tracer.
