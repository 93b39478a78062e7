//! How a path grows by one vertex: the traits that a strategy and a user's vertex implement.

use core::fmt::Debug;

use crate::density::Density;
use crate::point::Point;
use crate::real::{Mask, Real, Scalar};
use crate::sampler::{PdfOf, Sampler};
use crate::sequence::PathView;
use crate::uniform::UniformSource;

/// A vertex of a path: the user's own type, small and `Copy` (a surface hit, a point of a medium, a
/// lens).
pub trait Vertex: Copy + Debug {
    /// The precision that densities of this vertex have.
    type Real: Scalar;
    /// The space that the vertex lives in; conditional densities are with respect to its measure. A
    /// union of several spaces says by [`Includes`](crate::point::Includes) which these are, and
    /// densities are with respect to the measure of the one that the vertex lies in.
    type Point: Copy + Debug;
    /// Where the vertex is.
    fn point(&self) -> Self::Point;
}

/// Reads a locally constant value (what a ray cast returned, say) back from a vertex, so that a
/// density can be evaluated at the vertex without repeating the external call.
///
/// A user's vertex implements it for each type that the locally constant calls of its strategies
/// return.
pub trait Recall<T> {
    /// The value that the call returned; `None` if this vertex cannot have come from such a call.
    fn recall(&self) -> Option<T>;
}

/// What is discrete about a vertex that was found with a probability instead of a density.
///
/// A factor belongs to the vertex where it arises, so that techniques that travel in opposite
/// directions agree on it: a mirror's factor belongs to the vertex on the mirror, whether the path
/// continues from it towards the light or towards the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Dirac {
    /// The vertex itself can be nowhere else: a pinhole, a point light. Belongs to the new vertex.
    Position,
    /// The vertex before scatters or emits in this single direction: a mirror, a laser. Belongs to
    /// the vertex before.
    Direction,
}

/// How a vertex is distributed given the path before it: a density, or the probability of a
/// discrete mass, never a mixture of both. Only values with the same Dirac factor are comparable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conditional<R> {
    /// The density with respect to the measure of the vertex's space, or the probability.
    pub value: R,
    /// The Dirac factor; `None` for a density.
    pub dirac: Option<Dirac>,
}

impl<R: Real> Conditional<R> {
    /// The vertex cannot arise.
    pub const ZERO: Self = Conditional { value: R::ZERO, dirac: None };

    /// A density with respect to the measure of the vertex's space.
    pub fn density(value: R) -> Self {
        Conditional { value, dirac: None }
    }

    /// The probability of a discrete mass.
    pub fn atom(dirac: Dirac, probability: R) -> Self {
        Conditional { value: probability, dirac: Some(dirac) }
    }

    /// The value if it is of the kind asked for, else zero.
    pub fn of_kind(self, dirac: Option<Dirac>) -> R {
        if self.dirac == dirac { self.value } else { R::ZERO }
    }
}

/// A vertex that a strategy drew, and what is known about how it was drawn.
///
/// Most strategies return `Some(Drawn::new(vertex))`, those that cast a ray
/// `Some(Drawn::new(vertex).visible())`.
#[derive(Clone, Copy, Debug)]
// The vertex comes first, so that nothing is computed to get from one to the other.
#[repr(C)]
pub struct Drawn<V: Vertex> {
    /// The vertex.
    pub vertex: V,
    /// The Dirac factor that it was drawn with; `None` if it has a density.
    pub dirac: Option<Dirac>,
    /// Whether the vertex was found from the one before by a ray cast, so that nothing lies between
    /// them: no shadow ray is needed.
    pub visible: bool,
    /// The conditional density or probability, if sampling happened to compute it (the value that
    /// [`Strategy::pdf`] returns for this vertex, marginalised over all choices).
    pub value: Option<V::Real>,
}

impl<V: Vertex> Drawn<V> {
    /// A vertex that has a density.
    pub fn new(vertex: V) -> Self {
        Drawn { vertex, dirac: None, visible: false, value: None }
    }

    /// A vertex that was drawn with a Dirac factor.
    pub fn atom(vertex: V, dirac: Dirac) -> Self {
        Drawn { vertex, dirac: Some(dirac), visible: false, value: None }
    }

    /// Records that the vertex and the one before see each other.
    pub fn visible(self) -> Self {
        Drawn { visible: true, ..self }
    }

    /// Records the conditional density (or probability), so that it need not be evaluated.
    pub fn with_value(self, value: V::Real) -> Self {
        Drawn { value: Some(value), ..self }
    }
}

/// The most vertices that one draw of a joint strategy yields.
pub const MOST_VERTICES: usize = 8;

/// Vertices drawn together are an element of the product of their spaces.
impl<V: Vertex, const N: usize> Vertex for [V; N] {
    type Real = V::Real;
    type Point = [V::Point; N];
    fn point(&self) -> [V::Point; N] {
        self.map(|vertex| vertex.point())
    }
}

/// The vertices that one draw of a joint strategy yielded, in order of travel. Made from a
/// [`Drawn`] array of two to eight vertices.
#[derive(Clone, Copy, Debug)]
pub struct DrawnRun<V: Vertex> {
    /// Only the first `len` count.
    vertices: [V; MOST_VERTICES],
    len: usize,
    /// Whether each vertex but the first sees the one before: no shadow ray is needed.
    pub visible: bool,
    /// The joint conditional density, if sampling happened to compute it.
    pub value: Option<V::Real>,
}

impl<V: Vertex> DrawnRun<V> {
    /// The vertices.
    pub fn vertices(&self) -> &[V] {
        &self.vertices[..self.len]
    }
}

impl<V: Vertex, const N: usize> From<Drawn<[V; N]>> for DrawnRun<V> {
    fn from(drawn: Drawn<[V; N]>) -> Self {
        const { assert!(2 <= N && N <= MOST_VERTICES, "a run has two to eight vertices") };
        let vertices = core::array::from_fn(|i| drawn.vertex[i.min(N - 1)]);
        DrawnRun { vertices, len: N, visible: drawn.visible, value: drawn.value }
    }
}

impl<V: Vertex> From<V> for Drawn<V> {
    fn from(vertex: V) -> Self {
        Drawn::new(vertex)
    }
}

/// The random variable that is always the same point: what `atom(direction, measure)` draws in a
/// strategy. Its density is the measure, at any point, for whether a vertex is the atom is known
/// from how the path was made.
#[derive(Clone, Copy, Debug)]
pub struct Atom<P, R> {
    point: P,
    measure: R,
}

impl<P, R> Atom<P, R> {
    /// An atom at a point of a space, and the measure there in which atoms are stated, per measure of
    /// the space.
    pub fn new(point: P, measure: R) -> Self {
        Atom { point, measure }
    }
}

impl<P: Point<R>, R: Real> Sampler<R> for Atom<P, R> {
    type Uniforms = [R; 0];
    type Point = P;
    #[inline(always)]
    fn forward(&self, _: [R; 0]) -> (P, R::Mask) {
        (self.point, R::Mask::FALSE.not())
    }
    #[inline(always)]
    fn pdf(&self, _: &P) -> PdfOf<Self, R> {
        Density::new(self.measure)
    }
    #[inline(always)]
    fn pdf_of_uniforms(&self, _: [R; 0]) -> PdfOf<Self, R> {
        Density::new(self.measure)
    }
    fn preimages(&self, _: &P, mut visit: impl FnMut([R; 0], R::Mask)) {
        visit([], R::Mask::FALSE.not());
    }
}

/// What a strategy reads of the path before the vertex; densities are remembered by it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reads {
    /// How many of the preceding vertices. The view that the strategy is given shows no more.
    pub vertices: usize,
    /// Whether the number of preceding vertices ([`PathView::len`]) matters.
    pub length: bool,
}

impl Reads {
    /// The two vertices before, whatever the length of the path: scattering.
    pub const TWO: Reads = Reads { vertices: 2, length: false };
    /// Nothing of the path: a camera, a light picked without regard to where it will shine.
    pub const NOTHING: Reads = Reads { vertices: 0, length: false };

    /// What two strategies read between them.
    #[must_use]
    pub fn and(self, other: Reads) -> Reads {
        Reads { vertices: self.vertices.max(other.vertices), length: self.length || other.length }
    }
}

impl Default for Reads {
    /// The two vertices before and the length.
    fn default() -> Self {
        Reads { vertices: 2, length: true }
    }
}

/// Which kinds of atoms a strategy may yield.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Atoms {
    /// [`Dirac::Position`].
    pub position: bool,
    /// [`Dirac::Direction`].
    pub direction: bool,
}

impl Atoms {
    /// Only densities.
    pub const NONE: Atoms = Atoms { position: false, direction: false };
    /// Any kind.
    pub const ANY: Atoms = Atoms { position: true, direction: true };

    /// The kinds that one of two strategies may yield.
    #[must_use]
    pub const fn and(self, other: Atoms) -> Atoms {
        Atoms {
            position: self.position || other.position,
            direction: self.direction || other.direction,
        }
    }

    /// Whether there is a kind that both may yield.
    pub const fn overlaps(self, other: Atoms) -> bool {
        (self.position && other.position) || (self.direction && other.direction)
    }
}

/// A way to choose the next vertex of a path (Aether 2017, sections 5.3 and 5.6): a mixture of
/// continuous samplers, discrete choices, plain code and locally constant calls.
///
/// A strategy is a pure function of its fields, the part of the path that it declares in
/// [`Strategy::reads`], and the uniforms.
///
/// # Joint strategies
///
/// A strategy may yield a run of several vertices with one draw (a segment through a window): its
/// [`Strategy::vertices`] is more than one. It implements [`Strategy::sample_joint`] and
/// [`Strategy::pdf_joint`]; as it never yields a single vertex, [`Strategy::sample`] returns `None`,
/// and [`Strategy::pdf`] zero. A run has a density, never an atom.
pub trait Strategy<V: Vertex>: Clone {
    /// The most vertices that a draw yields. Where it is one, nothing is ever done for runs.
    const VERTICES: usize = 1;

    /// Which kinds of atoms this may yield. A choice between strategies of which two yield the same
    /// kind has to be identified from the vertex, because atoms are never told apart by comparing
    /// coordinates.
    const ATOMS: Atoms = Atoms::ANY;

    /// Draws the next vertex, given the path so far; `None` if there is none (the ray left the
    /// scene, Russian roulette ended the path).
    fn sample<U: UniformSource<V::Real> + ?Sized>(
        &self,
        path: PathView<'_, V>,
        uniforms: &mut U,
    ) -> Option<Drawn<V>>;

    /// How `target` is distributed as the vertex after `path`, marginalised over all discrete
    /// choices, the probability of yielding a vertex at all included.
    ///
    /// [`PathView::dirac`] says which kind of value is asked for, as recorded when the path was
    /// made: a mixture of a mirror and a diffuse lobe sums up only the choices of that kind. A value
    /// of another kind counts as zero.
    fn pdf(&self, path: PathView<'_, V>, target: &V) -> Conditional<V::Real>;

    /// What the strategy reads of the path before the vertex.
    fn reads(&self) -> Reads {
        Reads::default()
    }

    /// [`Strategy::sample`] after a path of which no more is shown than the strategy reads. A set of strategies passes this on to the
    /// one in question, of which the compiler knows how much that is.
    #[inline(always)]
    fn sample_limited<U: UniformSource<V::Real> + ?Sized>(
        &self,
        path: PathView<'_, V>,
        uniforms: &mut U,
    ) -> Option<Drawn<V>> {
        self.sample(path.limited(self.reads()), uniforms)
    }

    /// [`Strategy::pdf`] after a path of which no more is shown than the strategy reads, likewise.
    #[inline(always)]
    fn pdf_limited(&self, path: PathView<'_, V>, target: &V) -> Conditional<V::Real> {
        self.pdf(path.limited(self.reads()), target)
    }

    /// Which lengths of the path before the vertex make no difference: they are of one class, and densities are
    /// shared between them. Asked for only if [`Strategy::reads`] declares the length.
    fn length_class(&self, len: usize) -> u32 {
        len as u32
    }

    /// How many vertices a draw of this strategy yields, at most [`Strategy::VERTICES`].
    fn vertices(&self) -> usize {
        Self::VERTICES
    }

    /// Draws the next vertices of a joint strategy, [`Strategy::vertices`] of them.
    fn sample_joint<U: UniformSource<V::Real> + ?Sized>(
        &self,
        path: PathView<'_, V>,
        uniforms: &mut U,
    ) -> Option<DrawnRun<V>> {
        let _ = (path, uniforms);
        None
    }

    /// The density of `targets` as the vertices after `path`, in order of travel, with respect to the
    /// product of the measures of their spaces. Zero if there are not [`Strategy::vertices`] of them.
    fn pdf_joint(&self, path: PathView<'_, V>, targets: &[V]) -> V::Real {
        let _ = (path, targets);
        V::Real::ZERO
    }

    /// Whether `other` is the same strategy with the same arguments, so that densities can be shared
    /// between them. `false` is always safe. Compare references by address.
    fn same(&self, other: &Self) -> bool {
        let _ = other;
        false
    }
}
