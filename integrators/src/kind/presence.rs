//! Types that say whether something is there.

use std::fmt::Debug;

/// Nothing: the type of what a kind of scene leaves out. It has no values, so that code which handles
/// one is never reached and is dropped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Absent {}

/// The type of a feature that a kind of scene has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Present;

/// What can come with something that is present.
pub trait Value: Copy + Debug + PartialEq + Send + Sync + 'static {}

impl<T: Copy + Debug + PartialEq + Send + Sync + 'static> Value for T {}

/// A `T` if `P` is present.
pub type With<P, T> = <P as Presence>::With<T>;

/// [`Present`] or [`Absent`].
pub trait Presence: Copy + Debug + PartialEq + Send + Sync + 'static {
    /// Present if this is, otherwise `B`.
    type Or<B: Presence>: Presence;
    /// The value, if there is one.
    const VALUE: Option<Self>;
    /// A `T` if this is present. Unlike a pair of the two it takes no room where this is absent, so that
    /// an enum has no variant for it.
    type With<T: Value>: Value;
    /// What comes with this, made only if there is a use for it.
    fn with<T: Value>(make: impl FnOnce() -> T) -> Option<Self::With<T>>;
    /// What came with this: where this is absent, code behind it is never reached.
    fn get<T: Value>(with: Self::With<T>) -> T;
    /// The same by reference.
    fn get_ref<T: Value>(with: &Self::With<T>) -> &T;
    /// A `T` if this is present, otherwise nothing: what a struct has more for this.
    type Field<T: Value + Default>: Value + Default;
    /// Evaluates what goes into the field, if there is one.
    fn field<T: Value + Default>(make: impl FnOnce() -> T) -> Self::Field<T>;
    /// What is in the field; the default where there is none.
    fn value<T: Value + Default>(field: Self::Field<T>) -> T;
}

impl Presence for Present {
    type Or<B: Presence> = Present;
    const VALUE: Option<Self> = Some(Present);
    type With<T: Value> = T;
    #[inline(always)]
    fn with<T: Value>(make: impl FnOnce() -> T) -> Option<T> {
        Some(make())
    }
    #[inline(always)]
    fn get<T: Value>(with: T) -> T {
        with
    }
    #[inline(always)]
    fn get_ref<T: Value>(with: &T) -> &T {
        with
    }
    type Field<T: Value + Default> = T;
    #[inline(always)]
    fn field<T: Value + Default>(make: impl FnOnce() -> T) -> T {
        make()
    }
    #[inline(always)]
    fn value<T: Value + Default>(field: T) -> T {
        field
    }
}

impl Presence for Absent {
    type Or<B: Presence> = B;
    const VALUE: Option<Self> = None;
    type With<T: Value> = Absent;
    #[inline(always)]
    fn with<T: Value>(_: impl FnOnce() -> T) -> Option<Absent> {
        None
    }
    #[inline(always)]
    fn get<T: Value>(with: Absent) -> T {
        match with {}
    }
    #[inline(always)]
    fn get_ref<T: Value>(with: &Absent) -> &T {
        match *with {}
    }
    type Field<T: Value + Default> = ();
    #[inline(always)]
    fn field<T: Value + Default>(_: impl FnOnce() -> T) {}
    #[inline(always)]
    fn value<T: Value + Default>((): ()) -> T {
        T::default()
    }
}

/// Present if one of two is.
pub type Either<A, B> = <A as Presence>::Or<B>;

/// A model `T` that a kind of scene has (then this is `T` itself), or has not ([`Absent`]).
pub trait Part<T>: Copy + Debug + PartialEq + Send + Sync + 'static {
    /// Whether there is such a part.
    type Presence: Presence;
    /// The part, if the kind has it.
    fn keep(part: T) -> Option<Self>;
    /// What it is.
    fn get(&self) -> &T;
}

impl<T> Part<T> for Absent {
    type Presence = Absent;
    fn keep(_: T) -> Option<Self> {
        None
    }
    #[inline(always)]
    fn get(&self) -> &T {
        match *self {}
    }
}

/// Says of models that they are parts of kinds.
macro_rules! parts {
    ($($model:ty),+ $(,)?) => {$(
        impl Part<$model> for $model {
            type Presence = Present;
            fn keep(part: $model) -> Option<Self> {
                Some(part)
            }
            #[inline(always)]
            fn get(&self) -> &$model {
                self
            }
        }
    )+};
}

use crate::scene::bsdf::*;

parts!(
    Diffuse,
    Conductor,
    Dielectric,
    ThinDielectric,
    Plastic,
    RoughConductor,
    RoughDielectric,
    RoughPlastic,
    Phong,
);
