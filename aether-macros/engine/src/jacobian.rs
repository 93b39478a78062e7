//! The change of measure: √det(JᵀJ) in any dimension of sample and manifold.

pub mod moved;
pub mod sphere;

use crate::derivative::derivative;
use crate::expr::{Fun, Graph, Id, Leaf, Node, UNKNOWNS, children};
use crate::matrix::{cross, determinant, dot};
use crate::poly::{Expander, gathered, paired};
use crate::rational::Q;

/// What the unknowns are: free coordinates, or the coordinates of a direction, whose tangent space
/// is a plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Source {
    /// Uniforms, or the coordinates of a point of a line, a plane or space.
    Free,
    /// The three coordinates of a unit vector.
    Direction([Id; 3]),
}

/// Equal expressions for the volume that the map spans, the first as derived; `unit` says that the type of the
/// result makes it a vector of unit length.
pub fn volume(
    g: &mut Graph,
    outputs: &[Id],
    unknowns: &[Leaf],
    (source, unit): (Source, bool),
    frames: &[[[Id; 3]; 3]],
) -> Result<Vec<Id>, String> {
    let columns: Vec<Vec<Id>> =
        unknowns.iter().map(|&u| outputs.iter().map(|&f| derivative(g, f, u)).collect()).collect();
    let (m, n) = (outputs.len(), unknowns.len());
    // A frame by its type turns and keeps every measure.
    if frames.iter().any(|f| {
        (0..3).all(|i| columns.get(i).is_some_and(|c| **c == f[i]))
            || (0..3)
                .all(|i| columns.get(i).is_some_and(|c| (0..3).all(|j| c.get(j) == Some(&f[j][i]))))
    }) {
        return Ok(vec![g.int(1)]);
    }
    if m == 3
        && let Some(volume) = normalised(g, outputs, unknowns, source)
    {
        return Ok(volume);
    }
    match source {
        Source::Direction(w) if m == 2 => {
            // The area that the tangent plane's image covers: |w · (∇f × ∇g)|.
            let rows: Vec<Vec<Id>> =
                (0..2).map(|i| columns.iter().map(|c| c[i]).collect()).collect();
            let normal = cross(g, &rows[0], &rows[1]);
            let d = dot(g, &w, &normal);
            let tidy = simplify(g, d, Some(w));
            let candidates = [d, tidy].map(|d| g.call(Fun::Abs, &[d]));
            Ok(distinct(candidates.to_vec()))
        }
        Source::Direction(_) if m != 3 => Err(format!(
            "a direction has two dimensions and the result has {m} coordinate: many directions have the same image, and the density would be an integral over them. Map to a space of two dimensions"
        )),
        Source::Direction(w) => {
            let w_form = |g: &mut Graph, id| simplify(g, id, Some(w));
            let normal = image_of_plane(g, &columns, w);
            if unit {
                let units: Vec<[Id; 3]> = g.units().iter().copied().chain([w]).collect();
                let mut forms = moved::area(g, outputs, unknowns, w, &units).unwrap_or_default();
                forms.extend(along(g, outputs, &normal, &units));
                return Ok(distinct(forms));
            }
            let raw = norm(g, &normal);
            let tidy: Vec<Id> = normal.iter().map(|&c| w_form(g, c)).collect();
            let tidy = norm(g, &tidy);
            let tidier = w_form(g, tidy);
            Ok(distinct(vec![raw, tidy, tidier]))
        }
        Source::Free if m == n => {
            let d = determinant(g, &columns);
            let tidy = simplify(g, d, None);
            let gather = |g: &mut Graph, c: &Vec<Id>| c.iter().map(|&f| gathered(g, f)).collect();
            let columns: Vec<Vec<Id>> = columns.iter().map(|c| gather(g, c)).collect();
            let short = determinant(g, &columns);
            let candidates = [d, tidy, short].map(|d| g.call(Fun::Abs, &[d]));
            Ok(distinct(candidates.to_vec()))
        }
        Source::Free if n < m => {
            let mut candidates = sphere::unit_sphere(g, outputs, unknowns).unwrap_or_default();
            if unit && n == 2 && m == 3 {
                let normal = cross(g, &columns[0], &columns[1]);
                let units = g.units().to_vec();
                candidates.extend(along(g, outputs, &normal, &units));
            }
            candidates.extend(embedded(g, &columns));
            Ok(distinct(candidates))
        }
        Source::Free => Err(format!(
            "{n} uniforms for a point with {m} coordinates: more uniforms than dimensions give a marginal density, which is an integral and no formula"
        )),
    }
}

/// The volume of a normalised vector T / |T|: |T · (∂T × ∂T)| / |T|³, where the vector product spans
/// the image of the unknowns (or of the tangent plane of a direction).
fn normalised(g: &mut Graph, outputs: &[Id], unknowns: &[Leaf], source: Source) -> Option<Vec<Id>> {
    let minus_half = g.number(Q::HALF.neg());
    let shared = g.factors(outputs[0]).into_iter().filter(|&(b, e)| {
        e == minus_half
            && g.has(b, UNKNOWNS)
            && outputs[1..].iter().all(|o| g.factors(*o).contains(&(b, e)))
    });
    // Of nested lengths the outermost, which has the others in it.
    let (base, _) = shared.collect::<Vec<_>>().into_iter().max_by_key(|&(b, _)| cost(g, b))?;
    let root = g.pow(base, minus_half);
    let t: Vec<Id> = outputs.iter().map(|&o| g.div(o, root)).collect();
    let squared = dot(g, &t, &t);
    let gap = g.sub(squared, base);
    let gap = Expander::new(g).normal_form(gap)?;
    if !g.as_number(gap).is_some_and(Q::is_zero) {
        return None;
    }
    // A factor of the whole vector, such as an earlier length of it, does not turn it.
    let bodies: Vec<Id> = t.iter().map(|&t| g.split(t).1).collect();
    let mut common = g.factors(bodies[0]);
    common.retain(|f| bodies[1..].iter().all(|b| g.factors(*b).contains(f)));
    let common = g.product(&common);
    let t: Vec<Id> = t.iter().map(|&t| g.div(t, common)).collect();
    let columns: Vec<Vec<Id>> =
        unknowns.iter().map(|&u| t.iter().map(|&f| derivative(g, f, u)).collect()).collect();
    let (normal, unit) = match source {
        Source::Direction(w) => (image_of_plane(g, &columns, w), Some(w)),
        Source::Free if columns.len() == 2 => (cross(g, &columns[0], &columns[1]), None),
        Source::Free => return None,
    };
    let triple = dot(g, &t, &normal);
    let tidy = simplify(g, triple, unit);
    let cubed = g.number(Q::new(-3, 2)?);
    let over = g.pow(base, cubed);
    let cube = g.powi(common, 3);
    let cube = g.call(Fun::Abs, &[cube]);
    let over = g.mul(cube, over);
    let candidates = [tidy, triple].map(|d| {
        let size = g.call(Fun::Abs, &[d]);
        g.mul(size, over)
    });
    Some(distinct(candidates.to_vec()))
}

/// The normal, as long as the area is stretched, of the image of the plane with normal `w` under the
/// linear map with these columns: its cofactors applied to `w`.
fn image_of_plane(g: &mut Graph, columns: &[Vec<Id>], w: [Id; 3]) -> Vec<Id> {
    let parts = [(1, 2), (2, 0), (0, 1)];
    let crosses: Vec<Vec<Id>> =
        parts.iter().map(|&(i, j)| cross(g, &columns[i], &columns[j])).collect();
    (0..3)
        .map(|i| {
            let along: Vec<Id> = (0..3).map(|k| crosses[k][i]).collect();
            dot(g, &w, &along)
        })
        .collect()
}

/// The area of an image on the unit sphere: its normal has the direction of the point itself, so that its length
/// is the product of both.
fn along(g: &mut Graph, point: &[Id], normal: &[Id], units: &[[Id; 3]]) -> Vec<Id> {
    let product = dot(g, point, normal);
    let tidy = simplify_with(g, product, units);
    distinct([tidy, product].map(|d| g.call(Fun::Abs, &[d])).to_vec())
}

/// Fewer unknowns than outputs: the length of the vector of all maximal minors (Cauchy and Binet), which is the vector
/// product for a surface in space, or where the columns are orthogonal the product of their lengths. Gram's determinant
/// is the same, but a difference that loses twice as many digits where columns are nearly parallel.
fn embedded(g: &mut Graph, columns: &[Vec<Id>]) -> Vec<Id> {
    let direct = minors(g, columns);
    let tidied: Vec<Id> = direct.iter().map(|&minor| simplify(g, minor, None)).collect();
    let [direct, tidy] = [direct, tidied].map(|minors| norm(g, &minors));
    let tidier = simplify(g, tidy, None);
    let mut candidates: Vec<Id> = orthogonal(g, columns).into_iter().collect();
    candidates.extend([tidier, tidy, direct]);
    candidates
}

/// The determinants of as many rows as there are columns, for all choices of rows.
fn minors(g: &mut Graph, columns: &[Vec<Id>]) -> Vec<Id> {
    let (n, m) = (columns.len(), columns[0].len());
    if let ([a, b], 3) = (columns, m) {
        return cross(g, a, b);
    }
    let choices = (0u32..1 << m).filter(|rows| rows.count_ones() as usize == n);
    let minor = |rows: u32| {
        let kept =
            |column: &Vec<Id>| (0..m).filter(|i| rows >> i & 1 == 1).map(|i| column[i]).collect();
        let square: Vec<Vec<Id>> = columns.iter().map(kept).collect();
        determinant(g, &square)
    };
    choices.map(minor).collect()
}

/// The product of the lengths of columns that are seen to be orthogonal.
fn orthogonal(g: &mut Graph, columns: &[Vec<Id>]) -> Option<Id> {
    let zero = g.int(0);
    for (i, a) in columns.iter().enumerate() {
        for b in &columns[..i] {
            let product = dot(g, a, b);
            if simplify(g, product, None) != zero {
                return None;
            }
        }
    }
    let squares: Vec<Id> = columns.iter().map(|c| dot(g, c, c)).collect();
    let factors: Vec<(Id, Id)> =
        squares.into_iter().map(|s| (simplify(g, s, None), g.number(Q::HALF))).collect();
    let volume = g.product(&factors);
    Some(simplify(g, volume, None))
}

fn norm(g: &mut Graph, v: &[Id]) -> Id {
    let s = dot(g, v, v);
    // A common factor of all squares comes out of the root.
    let s = factor_out(g, s);
    g.sqrt(s)
}

/// a·s² + b·s² … as (a + b …)·s², for factors common to all terms of a sum.
pub fn factor_out(g: &mut Graph, id: Id) -> Id {
    let Node::Sum(c, terms) = g.node(id).clone() else { return id };
    if !c.is_zero() || terms.len() < 2 {
        return id;
    }
    let mut common = g.factors(terms[0].1);
    for (_, t) in &terms[1..] {
        let f = g.factors(*t);
        common.retain(|x| f.contains(x));
    }
    if common.is_empty() {
        return id;
    }
    let outside = g.product(&common);
    let rest: Vec<(Q, Id)> = terms.iter().map(|&(q, t)| (q, g.div(t, outside))).collect();
    let inside = g.sum(Q::ZERO, &rest);
    let inside = factor_out(g, inside);
    g.mul(outside, inside)
}

/// The cheapest of an expression and its normal forms.
pub fn simplify(g: &mut Graph, id: Id, unit: Option<[Id; 3]>) -> Id {
    simplify_with(g, id, unit.as_slice())
}

/// The same, where these vectors have unit length.
pub fn simplify_with(g: &mut Graph, id: Id, units: &[[Id; 3]]) -> Id {
    let mut best = id;
    for open in [UNKNOWNS | crate::expr::OUTS, crate::expr::Deps::MAX] {
        let mut e = Expander::new(g).only(open);
        for unit in units {
            e = e.unit(*unit);
        }
        if let Some(n) = e.normal_form(id)
            && cost(g, n) < cost(g, best)
        {
            best = n;
        }
    }
    paired(g, best)
}

/// A rough count of the work to evaluate an expression, shared parts counted once.
pub fn cost(g: &Graph, id: Id) -> usize {
    if let Some(&known) = g.costs.borrow().get(&id) {
        return known;
    }
    let total = cost_together(g, &[id]);
    g.costs.borrow_mut().insert(id, total);
    total
}

/// The same of several expressions, with what they share counted once.
pub fn cost_together(g: &Graph, ids: &[Id]) -> usize {
    let mut seen = vec![false; g.len()];
    let mut open = ids.to_vec();
    let mut total = 0;
    while let Some(id) = open.pop() {
        if std::mem::replace(&mut seen[id.0 as usize], true) {
            continue;
        }
        total += match g.node(id) {
            Node::Call(Fun::Abs, _) => 1,
            Node::Call(..) => 12,
            Node::If(..) => 2,
            // Each of its steps computes the body once.
            Node::Root(r) => 10 * (cost(g, r.body) + cost(g, r.slope)),
            Node::Product(f) => f
                .iter()
                .map(|(_, e)| match g.as_number(*e) {
                    Some(q) if q.is_int() && !q.is_negative() => q.num().unsigned_abs() as usize,
                    Some(q) if q.is_int() => 3 + q.num().unsigned_abs() as usize,
                    Some(q) if q.den() == 2 => 5,
                    _ => 20,
                })
                .sum(),
            // Three or more terms of both signs may cancel: better avoided.
            Node::Sum(c, t) => {
                let negative = t.iter().filter(|(q, _)| q.is_negative()).count()
                    + usize::from(c.is_negative());
                let all = t.len() + usize::from(!c.is_zero());
                let mixed = all > 2 && negative > 0 && negative < all;
                t.len() + if mixed && !far_from_zero(g, id) { 30 } else { 0 }
            }
            _ => 0,
        };
        open.extend(children(g.node(id)));
    }
    total
}

/// Whether the values of a sum are known to be so close together, on one side of zero, that its terms
/// cannot cancel.
fn far_from_zero(g: &Graph, id: Id) -> bool {
    let range = g.range(id);
    let (least, most) = if range.lo > 0.0 { (range.lo, range.hi) } else { (-range.hi, -range.lo) };
    least > 0.0 && most <= 4.0 * least
}

/// Without repetitions.
pub fn distinct(mut ids: Vec<Id>) -> Vec<Id> {
    let mut seen = Vec::new();
    ids.retain(|i| {
        let new = !seen.contains(i);
        seen.push(*i);
        new
    });
    ids
}
