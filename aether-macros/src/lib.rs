//! The attributes of `aether-core`.
