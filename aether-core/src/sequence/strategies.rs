//! A set of strategies as one type.

/// Declares the set of strategies that the paths of a program are made of, as an enum that is a
/// strategy itself: calls are dispatched statically, and what a program does not name costs it
/// nothing.
///
/// ```
/// # use aether_core::sequence::PathView;
/// # use aether_core::strategy::{Conditional, Drawn, Strategy, Vertex};
/// # use aether_core::{UniformSource, strategies};
/// # #[derive(Clone, Copy, Debug)] struct Hit(f64);
/// # impl Vertex for Hit {
/// #     type Real = f64; type Point = f64;
/// #     fn point(&self) -> f64 { self.0 }
/// # }
/// # #[derive(Clone, Copy)] struct Start;
/// # #[derive(Clone, Copy)] struct Walk<'a>(&'a f64);
/// # macro_rules! toy { ($($name:ty)*) => { $(impl Strategy<Hit> for $name {
/// #     fn sample<U: UniformSource<f64> + ?Sized>(&self, _: PathView<'_, Hit>, u: &mut U)
/// #         -> Option<Drawn<Hit>> { Some(Drawn::new(Hit(u.next()))) }
/// #     fn pdf(&self, _: PathView<'_, Hit>, _: &Hit) -> Conditional<f64> {
/// #         Conditional::density(1.0) }
/// # })* } }
/// # toy! { Start Walk<'_> }
/// strategies! {
///     /// How this program makes its paths.
///     #[derive(Clone, Copy)]
///     pub enum Strategies<'a> for Hit { Start(Start), Walk(Walk<'a>) }
/// }
/// let arena = aether_core::sequence::Arena::<Hit, Strategies<'_>>::new();
/// let mut path = arena.sequence();
/// path.append(Start).append(Walk(&1.0)).sample(&mut || 0.5);
/// assert_eq!(path.len(), 2);
/// ```
///
/// After its lifetimes the enum may have type parameters, each with one bound:
/// `enum Strategies<'a, K: SceneKind> for Hit<K>`.
#[macro_export]
macro_rules! strategies {
    (@chosen $self:ident $name:ident [$($variant:ident)+] $strategy:ident => $result:expr) => {
        match $self {
            $($name::$variant($strategy) => $result,)+
        }
    };
    (@conversions $generics:tt $arguments:tt $name:ident $($variant:ident($strategy:ty))+) => {
        $($crate::strategies! { @conversion $generics $arguments $name $variant($strategy) })+
    };
    (
        @conversion [$($generics:tt)*] [$($arguments:tt)*]
        $name:ident $variant:ident($strategy:ty)
    ) => {
        impl $($generics)* From<$strategy> for $name $($arguments)* {
            fn from(strategy: $strategy) -> Self { $name::$variant(strategy) }
        }
    };
    (
        $(#[$meta:meta])*
        $visibility:vis enum $name:ident
            $(<$($lifetime:lifetime),+ $(, $parameter:ident: $bound:path $(= $default:ty)?)*>)?
            for $vertex:ty
        {
            $($(#[$variant_meta:meta])* $variant:ident($strategy:ty)),+ $(,)?
        }
    ) => {
        $(#[$meta])*
        $visibility enum $name $(<$($lifetime),+ $(, $parameter: $bound $(= $default)?)*>)? {
            $($(#[$variant_meta])* #[allow(missing_docs)] $variant($strategy),)+
        }

        $crate::strategies! {
            @conversions
            [$(<$($lifetime),+ $(, $parameter: $bound)*>)?]
            [$(<$($lifetime),+ $(, $parameter)*>)?]
            $name $($variant($strategy))+
        }

        impl $(<$($lifetime),+ $(, $parameter: $bound)*>)? $crate::strategy::Strategy<$vertex>
            for $name $(<$($lifetime),+ $(, $parameter)*>)?
        {
            const ATOMS: $crate::strategy::Atoms = $crate::strategy::Atoms::NONE
                $(.and(<$strategy as $crate::strategy::Strategy<$vertex>>::ATOMS))+;

            const VERTICES: usize = {
                let mut most = 1;
                $(if <$strategy as $crate::strategy::Strategy<$vertex>>::VERTICES > most {
                    most = <$strategy as $crate::strategy::Strategy<$vertex>>::VERTICES;
                })+
                most
            };

            #[inline]
            fn sample<U>(
                &self,
                path: $crate::sequence::PathView<'_, $vertex>,
                uniforms: &mut U,
            ) -> Option<$crate::strategy::Drawn<$vertex>>
            where
                U: $crate::uniform::UniformSource<
                        <$vertex as $crate::strategy::Vertex>::Real,
                    > + ?Sized,
            {
                $crate::strategies! {
                    @chosen self $name [$($variant)+] s =>
                        $crate::strategy::Strategy::<$vertex>::sample(s, path, uniforms)
                }
            }

            #[inline]
            fn pdf(
                &self,
                path: $crate::sequence::PathView<'_, $vertex>,
                target: &$vertex,
            ) -> $crate::strategy::Conditional<<$vertex as $crate::strategy::Vertex>::Real> {
                $crate::strategies! {
                    @chosen self $name [$($variant)+] s =>
                        $crate::strategy::Strategy::<$vertex>::pdf(s, path, target)
                }
            }

            #[inline(always)]
            fn sample_limited<U>(
                &self,
                path: $crate::sequence::PathView<'_, $vertex>,
                uniforms: &mut U,
            ) -> Option<$crate::strategy::Drawn<$vertex>>
            where
                U: $crate::uniform::UniformSource<
                        <$vertex as $crate::strategy::Vertex>::Real,
                    > + ?Sized,
            {
                $crate::strategies! {
                    @chosen self $name [$($variant)+] s =>
                        $crate::strategy::Strategy::<$vertex>::sample_limited(s, path, uniforms)
                }
            }

            #[inline(always)]
            fn pdf_limited(
                &self,
                path: $crate::sequence::PathView<'_, $vertex>,
                target: &$vertex,
            ) -> $crate::strategy::Conditional<<$vertex as $crate::strategy::Vertex>::Real> {
                $crate::strategies! {
                    @chosen self $name [$($variant)+] s =>
                        $crate::strategy::Strategy::<$vertex>::pdf_limited(s, path, target)
                }
            }

            #[inline]
            fn reads(&self) -> $crate::strategy::Reads {
                $crate::strategies! {
                    @chosen self $name [$($variant)+] s =>
                        $crate::strategy::Strategy::<$vertex>::reads(s)
                }
            }

            #[inline]
            fn length_class(&self, len: usize) -> u32 {
                $crate::strategies! {
                    @chosen self $name [$($variant)+] s =>
                        $crate::strategy::Strategy::<$vertex>::length_class(s, len)
                }
            }

            #[inline]
            fn vertices(&self) -> usize {
                $crate::strategies! {
                    @chosen self $name [$($variant)+] s =>
                        $crate::strategy::Strategy::<$vertex>::vertices(s)
                }
            }

            #[inline]
            fn sample_joint<U>(
                &self,
                path: $crate::sequence::PathView<'_, $vertex>,
                uniforms: &mut U,
            ) -> Option<$crate::strategy::DrawnRun<$vertex>>
            where
                U: $crate::uniform::UniformSource<
                        <$vertex as $crate::strategy::Vertex>::Real,
                    > + ?Sized,
            {
                $crate::strategies! {
                    @chosen self $name [$($variant)+] s =>
                        $crate::strategy::Strategy::<$vertex>::sample_joint(s, path, uniforms)
                }
            }

            #[inline]
            fn pdf_joint(
                &self,
                path: $crate::sequence::PathView<'_, $vertex>,
                targets: &[$vertex],
            ) -> <$vertex as $crate::strategy::Vertex>::Real {
                $crate::strategies! {
                    @chosen self $name [$($variant)+] s =>
                        $crate::strategy::Strategy::<$vertex>::pdf_joint(s, path, targets)
                }
            }

            #[inline]
            fn same(&self, other: &Self) -> bool {
                match (self, other) {
                    $(($name::$variant(a), $name::$variant(b)) => {
                        $crate::strategy::Strategy::<$vertex>::same(a, b)
                    })+
                    #[allow(unreachable_patterns)]
                    _ => false,
                }
            }
        }
    };
}
