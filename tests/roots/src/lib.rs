//! Tests of samplers with numerical roots: searches take long where they are not optimised, and so these are a package
//! of their own.
