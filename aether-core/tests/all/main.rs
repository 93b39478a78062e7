//! The tests of what strategies, sequences, estimators and tables do, as one program: what they instantiate is compiled once,
//! and they run beside each other.

mod as_found;
mod choices;
mod combine_samples;
mod grid;
mod joint;
#[cfg(feature = "wide")]
mod kernels;
mod legal;
mod medium;
mod mixed;
mod mutations;
mod mutations_enumerated;
mod oracle;
mod parameters;
mod random_walk;
mod reflected_lobes;
mod rough_dielectric;
mod sequences;
mod shifts;
mod special;
mod strategy;
mod strategy_battery;
mod strategy_choices;
mod tables;
mod two_walks;
mod two_walks_extreme;
mod weights;
mod world;
