//! Parameters and uniforms of an item as expressions.

use quote::quote;

use super::body::Body;
use super::whole::range_of;
use super::{Options, Param, ParamKind, Segment, Source, Value};
use crate::expr::{Graph, Id, Leaf};
use crate::interval::Interval;
use crate::points::Kind;

impl Body<'_> {
    /// Replaces uniforms by what maps the unit interval to their segments; the segments in the terms
    /// of this graph.
    pub(super) fn confine(
        &mut self,
        source: &Source,
        unknowns: &[Leaf],
        segments: &[Option<(Segment, &Graph)>],
    ) -> Vec<Option<Segment>> {
        let Source::Uniforms { name, .. } = source else { return vec![] };
        let g = &mut self.graph;
        let mut confined = Vec::new();
        let ids = unknowns
            .iter()
            .enumerate()
            .map(|(i, &leaf)| {
                let inner = g.get_leaf(leaf);
                let segment = segments.get(i).copied().flatten().map(|(s, from)| Segment {
                    low: g.import(from, s.low),
                    width: g.import(from, s.width),
                    closed: s.closed,
                });
                confined.push(segment);
                segment.map_or(inner, |s| {
                    let inside = g.mul(s.width, inner);
                    g.add(s.low, inside)
                })
            })
            .collect();
        self.names.insert(name.clone(), Value::Uniforms(ids));
        confined
    }

    pub(super) fn scalar_param(&mut self, name: &str, range: Interval) -> Id {
        let leaf = Leaf::Param(self.next_param);
        self.next_param += 1;
        self.graph.leaf(leaf, name, range)
    }

    /// Makes a parameter known under its name.
    pub fn declare_param(
        &mut self,
        p: &Param,
        options: &Options,
        kinds: &mut Vec<Kind>,
        frames: &mut Vec<[[Id; 3]; 3]>,
    ) {
        let name = p.name.to_string();
        self.parameters.insert(name.clone(), false);
        let coordinates = |body: &mut Self, n: usize, range| -> Vec<Id> {
            (0..n)
                .map(|i| body.scalar_param(&format!("{name}.{}", ["x", "y", "z"][i]), range))
                .collect()
        };
        let value = match p.kind {
            ParamKind::Scalar => {
                let declared = options.domain(&name);
                let domain = declared.map(|d| d.interval);
                let id = self.scalar_param(&name, domain.unwrap_or(Interval::ALL));
                kinds.push(match declared {
                    Some(d) if d.whole => {
                        self.whole.push(id);
                        Kind::Whole(d.interval)
                    }
                    _ => Kind::Scalar(domain),
                });
                Value::Scalar(id)
            }
            ParamKind::Integer(ty) => {
                let all = range_of(ty);
                let range = options.domain(&name).map_or(all, |d| d.interval.intersection(all));
                let id = self.scalar_param(&name, range);
                self.whole.push(id);
                kinds.push(Kind::Whole(range));
                Value::Integer(id)
            }
            ParamKind::Flag => {
                let range = Interval::new(0.0, 1.0);
                kinds.push(Kind::Whole(range));
                Value::Flag(self.scalar_param(&name, range))
            }
            ParamKind::Array(n) => {
                kinds.extend(vec![Kind::Scalar(None); n]);
                let number =
                    |i| Value::Scalar(self.scalar_param(&format!("{name}[{i}]"), Interval::ALL));
                Value::List((0..n).map(number).collect())
            }
            ParamKind::Vec2 | ParamKind::Vec3 => {
                let n = if p.kind == ParamKind::Vec2 { 2 } else { 3 };
                kinds.push(Kind::Vector(n));
                Value::Vector(coordinates(self, n, Interval::ALL))
            }
            ParamKind::Direction => {
                kinds.push(Kind::Direction);
                let v = coordinates(self, 3, Interval::new(-1.0, 1.0));
                self.graph.declare_unit([v[0], v[1], v[2]]);
                Value::Vector(v)
            }
            ParamKind::Mat3 | ParamKind::Frame => {
                let is_frame = p.kind == ParamKind::Frame;
                let range = if is_frame { Interval::new(-1.0, 1.0) } else { Interval::ALL };
                let columns: [Vec<Id>; 3] = ["x", "y", "z"].map(|c| {
                    let element = |i: usize| format!("{name}.{c}{}", ["x", "y", "z"][i]);
                    (0..3).map(|i| self.scalar_param(&element(i), range)).collect()
                });
                if is_frame {
                    kinds.push(Kind::Frame);
                    frames.push([0, 1, 2].map(|c| [columns[c][0], columns[c][1], columns[c][2]]));
                } else {
                    kinds.push(Kind::Matrix);
                }
                Value::Matrix(columns)
            }
            ParamKind::Identity => {
                let ident = &p.name;
                Value::Opaque(quote!(self.#ident))
            }
        };
        self.names.insert(name, value);
    }
}
