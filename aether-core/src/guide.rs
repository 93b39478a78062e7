//! A guide to the language, in chapters that build on each other.
//!
//! Every piece of code in it is compiled and run with the tests of this crate.
//!
//! | | |
//! | --- | --- |
//! | [1. A first sampler](ch01_first_sampler) | sample, density, inverse, and what is derived |
//! | [2. Spaces and measures](ch02_spaces_and_measures) | which type names which space |
//! | [3. Parameters](ch03_parameters) | domains, relations, errors |
//! | [4. Branches](ch04_branches) | pieces, folds with several preimages, no sample |
//! | [5. Maps](ch05_maps) | composition, and changes of measure that nobody writes |
//! | [6. Several points](ch06_joint_points) | tuples, and the order that they need |
//! | [7. Implicit steps](ch07_implicit_steps) | `solve`, and inverses without a closed form |
//! | [8. Checking a sampler](ch08_checking) | the battery, and property tests of legal parameters |
//! | [9. Discrete choices](ch09_choices) | weights, tables, mixtures |
//! | [10. Strategies](ch10_strategies) | the next vertex of a path: choices, atoms, a medium |
//! | [11. Paths](ch11_sequences) | random sequences, combination of techniques, estimates |
//! | [12. Mutations](ch12_mutations) | Markov chains and conditional densities |
//! | [13. Two vertices at once](ch13_two_vertices) | several vertices of one draw |

macro_rules! chapters {
    ($($name:ident)*) => {
        $(#[doc = include_str!(concat!("guide/", stringify!($name), ".md"))]
        pub mod $name {})*
    };
}

chapters! {
    ch01_first_sampler
    ch02_spaces_and_measures
    ch03_parameters
    ch04_branches
    ch05_maps
    ch06_joint_points
    ch07_implicit_steps
    ch08_checking
    ch09_choices
    ch10_strategies
    ch11_sequences
    ch12_mutations
    ch13_two_vertices
}
