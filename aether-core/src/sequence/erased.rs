//! Strategies behind a pointer, where their set is not known when the program is compiled.

use core::fmt;

use crate::sequence::PathView;
use crate::strategy::{Conditional, Drawn, DrawnRun, MOST_VERTICES, Reads, Strategy, Vertex};
use crate::uniform::UniformSource;

/// [`Strategy`] as a trait object. Every strategy implements it.
pub trait DynStrategy<V: Vertex> {
    /// [`Strategy::sample`].
    fn sample_dyn(
        &self,
        path: PathView<'_, V>,
        uniforms: &mut dyn UniformSource<V::Real>,
    ) -> Option<Drawn<V>>;
    /// [`Strategy::pdf`].
    fn pdf_dyn(&self, path: PathView<'_, V>, target: &V) -> Conditional<V::Real>;
    /// [`Strategy::reads`].
    fn reads_dyn(&self) -> Reads;
    /// [`Strategy::length_class`].
    fn length_class_dyn(&self, len: usize) -> u32;
    /// [`Strategy::vertices`].
    fn vertices_dyn(&self) -> usize;
    /// [`Strategy::sample_joint`].
    fn sample_joint_dyn(
        &self,
        path: PathView<'_, V>,
        uniforms: &mut dyn UniformSource<V::Real>,
    ) -> Option<DrawnRun<V>>;
    /// [`Strategy::pdf_joint`].
    fn pdf_joint_dyn(&self, path: PathView<'_, V>, targets: &[V]) -> V::Real;
}

impl<V: Vertex, S: Strategy<V>> DynStrategy<V> for S {
    fn sample_dyn(
        &self,
        path: PathView<'_, V>,
        uniforms: &mut dyn UniformSource<V::Real>,
    ) -> Option<Drawn<V>> {
        self.sample(path, uniforms)
    }
    fn pdf_dyn(&self, path: PathView<'_, V>, target: &V) -> Conditional<V::Real> {
        self.pdf(path, target)
    }
    fn reads_dyn(&self) -> Reads {
        self.reads()
    }
    fn length_class_dyn(&self, len: usize) -> u32 {
        self.length_class(len)
    }
    fn vertices_dyn(&self) -> usize {
        self.vertices()
    }
    fn sample_joint_dyn(
        &self,
        path: PathView<'_, V>,
        uniforms: &mut dyn UniformSource<V::Real>,
    ) -> Option<DrawnRun<V>> {
        self.sample_joint(path, uniforms)
    }
    fn pdf_joint_dyn(&self, path: PathView<'_, V>, targets: &[V]) -> V::Real {
        self.pdf_joint(path, targets)
    }
}

/// A reference to any strategy: `Arena<V, Erased<V>>` holds paths of strategies that are chosen
/// while the program runs. Two of them are the same if they refer to the same object.
pub struct Erased<'s, V>(pub &'s dyn DynStrategy<V>);

impl<V> Clone for Erased<'_, V> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<V> Copy for Erased<'_, V> {}

impl<V> fmt::Debug for Erased<'_, V> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Erased(..)")
    }
}

impl<V: Vertex> Strategy<V> for Erased<'_, V> {
    const VERTICES: usize = MOST_VERTICES;

    fn sample<U: UniformSource<V::Real> + ?Sized>(
        &self,
        path: PathView<'_, V>,
        uniforms: &mut U,
    ) -> Option<Drawn<V>> {
        self.0.sample_dyn(path, &mut Borrowed(uniforms))
    }
    fn pdf(&self, path: PathView<'_, V>, target: &V) -> Conditional<V::Real> {
        self.0.pdf_dyn(path, target)
    }
    fn reads(&self) -> Reads {
        self.0.reads_dyn()
    }
    fn length_class(&self, len: usize) -> u32 {
        self.0.length_class_dyn(len)
    }
    fn vertices(&self) -> usize {
        self.0.vertices_dyn()
    }
    fn sample_joint<U: UniformSource<V::Real> + ?Sized>(
        &self,
        path: PathView<'_, V>,
        uniforms: &mut U,
    ) -> Option<DrawnRun<V>> {
        self.0.sample_joint_dyn(path, &mut Borrowed(uniforms))
    }
    fn pdf_joint(&self, path: PathView<'_, V>, targets: &[V]) -> V::Real {
        self.0.pdf_joint_dyn(path, targets)
    }
    fn same(&self, other: &Self) -> bool {
        core::ptr::eq(self.0, other.0)
    }
}

/// Makes a sized source of one that may not be.
pub(crate) struct Borrowed<'u, U: ?Sized>(pub &'u mut U);

impl<R: crate::real::Real, U: UniformSource<R> + ?Sized> UniformSource<R> for Borrowed<'_, U> {
    fn next(&mut self) -> R {
        self.0.next()
    }
    fn choice(&mut self) -> R {
        self.0.choice()
    }
    fn start(&mut self, block: u32) {
        self.0.start(block);
    }
    fn piece(&mut self, number: u32) {
        self.0.piece(number);
    }
}
