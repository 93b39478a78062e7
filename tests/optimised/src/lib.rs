//! Tests of samplers that take long where these are not optimised, in a package of their own: numerical roots, which are
//! searched for, and masses over manifolds and polygons, for which densities are evaluated many times.
