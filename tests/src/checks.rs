//! What tests say of samplers in one line.

use aether_core::DomainError;

/// The sampler, whose parameters are in their domain.
///
/// # Panics
/// If they are not.
pub fn right<T>(made: Result<T, DomainError>) -> T {
    made.expect("the parameters are in their domain")
}

/// A module of tests for each line, `name: sampler, sampler, ...;`. The list before says which tests:
/// the battery in `double` and in `single` precision, and that it fails where the density is off by one
/// percent, `off`.
#[macro_export]
macro_rules! batteries {
    (@double $($sampler:expr),+) => {
        #[test]
        fn double_precision() {
            $(::aether_core::battery::check(&$sampler).assert_ok();)+
        }
    };
    (@single $($sampler:expr),+) => {
        #[test]
        fn single_precision() {
            $(::aether_core::battery::check_f32(&$sampler).assert_ok();)+
        }
    };
    (@off $($sampler:expr),+) => {
        #[test]
        fn one_percent_off() {
            $({
                let off = $crate::mutation::OnePercentOff($sampler);
                assert!(!::aether_core::battery::check(&off).is_ok());
            })+
        }
    };
    (@line [$($kind:ident)+] $samplers:tt) => {
        $($crate::batteries! { @unpack $kind $samplers })+
    };
    (@unpack $kind:ident [$($sampler:expr),+]) => {
        $crate::batteries! { @$kind $($sampler),+ }
    };
    ($kinds:tt $($name:ident: $($sampler:expr),+;)*) => {
        $(mod $name {
            #[allow(unused_imports)]
            use super::*;
            $crate::batteries! { @line $kinds [$($sampler),+] }
        })*
    };
}
