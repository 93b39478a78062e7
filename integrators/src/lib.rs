//! Light transport algorithms composed from Aether strategies, and what the `aether` renderer
//! needs around them.
//!
//! A file becomes a [`scene`], the scene a [`world`] that strategies can sample. [`samplers`] and
//! [`strategies`] say how paths are made, [`integrand`] what is integrated, and [`path`] puts them
//! together; none of the three knows of the others' business, and no density is written by hand. All of
//! them are generic over the [`kind`] of scene: what a scene does not need is not compiled. [`scattering`]
//! is what surfaces do with light.
//! [`render`] distributes pixels over threads, [`image`] reads, writes and compares pictures, [`convergence`]
//! measures errors against time, and [`cli`] is the program.

pub mod algorithm;
pub mod aovs;
pub mod bidirectional;
pub mod chains;
#[cfg(test)]
mod chi_square;
pub mod cli;
pub mod convergence;
pub mod daylight;
pub mod emission;
pub mod envmap;
pub mod eye;
pub mod film_filter;
pub mod gradient_domain;
pub mod half_vectors;
pub mod image;
pub mod instant_radiosity;
pub mod integrand;
pub mod integrator;
pub mod kind;
pub mod light_tracer;
pub mod lights;
pub mod metropolis;
pub mod mutations;
pub mod path;
pub mod photon_mapping;
pub mod photons;
pub mod poisson;
pub mod portals;
pub mod primary_sample;
pub mod render;
pub mod samplers;
pub mod scattering;
pub mod scene;
pub mod seen;
pub mod selection;
pub mod shift;
pub mod stored;
pub mod strategies;
pub mod subpaths;
pub mod tridirectional;
pub mod uniforms;
pub mod vertex;
pub mod vertex_merging;
pub mod work;
pub mod world;
