//! The spaces of points, and the types that name them.

use syn::{GenericArgument, PathArguments, Type};

use super::signature::last_segment;
use crate::diagnostics::Diagnostics;
use crate::points::Kind;

/// The space of a result or of a map's argument.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Space {
    /// The real line.
    Line,
    /// The plane.
    Plane,
    /// Space, with volume.
    Volume,
    /// The unit sphere.
    Direction,
    /// A surface that the type identifies.
    SurfacePoint,
    /// A manifold of dimension `k` in R^`n` known only through the map.
    Embedded {
        /// Dimension of the manifold.
        k: usize,
        /// Dimension of the space around it.
        n: usize,
    },
    /// Several points at once, with the product of their measures.
    Joint(Vec<Space>),
}

impl Space {
    /// Dimension and number of coordinates.
    pub fn dimensions(&self) -> (usize, usize) {
        match self {
            Space::Line => (1, 1),
            Space::Plane => (2, 2),
            Space::Volume => (3, 3),
            Space::Direction | Space::SurfacePoint => (2, 3),
            Space::Embedded { k, n } => (*k, *n),
            Space::Joint(parts) => parts
                .iter()
                .map(Space::dimensions)
                .fold((0, 0), |(k, n), (dk, dn)| (k + dk, n + dn)),
        }
    }

    /// The points that make up a joint one; a space of single points is its own only part.
    pub fn parts(&self) -> Vec<Space> {
        if let Space::Joint(parts) = self { parts.clone() } else { vec![self.clone()] }
    }

    /// Coordinates and kind of a map's argument.
    pub fn argument(&self) -> (usize, Kind) {
        match self {
            Space::Line => (1, Kind::Vector(1)),
            Space::Plane => (2, Kind::Vector(2)),
            Space::Direction => (3, Kind::Direction),
            _ => (3, Kind::Vector(3)),
        }
    }

    /// The name of its measure.
    pub fn measure(&self) -> &'static str {
        match self {
            Space::Line | Space::Embedded { k: 1, .. } => "length",
            Space::Plane | Space::SurfacePoint | Space::Embedded { k: 2, .. } => "area",
            Space::Volume => "volume",
            Space::Direction => "solid angle",
            Space::Joint(_) => "product of the parts' measures",
            Space::Embedded { .. } => "Hausdorff measure",
        }
    }
}

/// The most points of a tuple: as many as tuples are implemented for.
const MAX_POINTS: usize = 8;

/// The most coordinates of a result, for which there are bits in [`crate::expr::Deps`].
const MAX_COORDINATES: usize = 24;

/// The most dimensions of a manifold, for which the runtime has measures, and of the space that it lies in.
const MAX_EMBEDDED: usize = 4;

const MAX_AROUND: usize = 8;

pub(super) fn space(ty: &Type, errors: &mut Diagnostics) -> Option<Space> {
    if let Type::Tuple(tuple) = ty
        && (2..=MAX_POINTS).contains(&tuple.elems.len())
    {
        let parts: Vec<Option<Space>> = tuple.elems.iter().map(|t| space(t, errors)).collect();
        let joint = parts.into_iter().collect::<Option<Vec<Space>>>().map(Space::Joint)?;
        if joint.dimensions().1 > MAX_COORDINATES {
            errors.error(ty, format!("these points have more than {MAX_COORDINATES} coordinates together: sample fewer at once, each run given the one before, in a `#[strategy]`"));
            return None;
        }
        return Some(joint);
    }
    let found = match last_segment(ty).as_deref() {
        Some("f64") => Some(Space::Line),
        Some("Vec2") => Some(Space::Plane),
        Some("Vec3") => Some(Space::Volume),
        Some("Direction") => Some(Space::Direction),
        Some("SurfacePoint") => Some(Space::SurfacePoint),
        Some("Surface") => Some(Space::Embedded { k: 2, n: 3 }),
        Some("Curve") => Some(Space::Embedded { k: 1, n: 3 }),
        Some("Embedded") => {
            let found = embedded(ty);
            if found.is_none() {
                errors.error(ty, format!("the numbers of `Embedded<K, N>` are literals: a manifold of K dimensions, one to {MAX_EMBEDDED}, of points with N coordinates, K to {MAX_AROUND}. More numbers are several points, a tuple, or are sampled one given the others in a `#[strategy]`"));
            }
            return found;
        }
        _ => None,
    };
    if found.is_none() {
        errors.error(ty, "this type names no space: use one of `f64` (length), `Vec2` (area), `Vec3` (volume), `Direction` (solid angle), `Surface` and `SurfacePoint` (area), `Curve` (length), `Embedded<K, N>`");
    }
    found
}

/// `T` of `Option<T>`: a body that may yield no sample.
pub(super) fn optional(ty: &Type) -> Option<&Type> {
    argument_of(ty, "Option")
}

/// `T` of `Name<T>`.
pub(super) fn argument_of<'t>(ty: &'t Type, name: &str) -> Option<&'t Type> {
    let Type::Path(p) = ty else { return None };
    let last = p.path.segments.last().filter(|s| s.ident == name)?;
    let PathArguments::AngleBracketed(arguments) = &last.arguments else { return None };
    match arguments.args.first() {
        Some(GenericArgument::Type(inner)) => Some(inner),
        _ => None,
    }
}

fn embedded(ty: &Type) -> Option<Space> {
    let Type::Path(p) = ty else { return None };
    let PathArguments::AngleBracketed(a) = &p.path.segments.last()?.arguments else { return None };
    let numbers: Vec<usize> = a
        .args
        .iter()
        .filter_map(|a| match a {
            GenericArgument::Const(syn::Expr::Lit(l)) => match &l.lit {
                syn::Lit::Int(i) => i.base10_parse().ok(),
                _ => None,
            },
            _ => None,
        })
        .collect();
    match numbers[..] {
        [k, n] if (1..=MAX_EMBEDDED).contains(&k) && (k..=MAX_AROUND).contains(&n) => {
            Some(Space::Embedded { k, n })
        }
        _ => None,
    }
}
