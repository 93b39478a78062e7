//! What views show of a path.

use super::*;
use crate::strategies;
use crate::strategy::{Conditional, Strategy};
use crate::uniform::UniformSource;

#[derive(Clone, Copy, Debug, PartialEq)]
struct At(f64);

impl Vertex for At {
    type Real = f64;
    type Point = f64;
    fn point(&self) -> f64 {
        self.0
    }
}

#[test]
fn no_more_is_shown_than_is_read_wherever_it_lies() {
    let vertices = [At(0.0), At(1.0), At(2.0), At(3.0)];
    let drawn = vertices.map(Drawn::new);
    let row = |at: fn(usize) -> usize| {
        let mut window = Window { vertices: [None; WINDOW], sees_next: 0, fixed: 0 };
        for k in 0..LAST {
            window.vertices[at(k)] = Some(&vertices[3 - k]);
        }
        window
    };
    let [ahead, behind] = [row(|k| 4 - k), row(|k| 5 + k)];
    let views = [
        PathView::from_slice(&vertices),
        PathView::of_drawn(each_last(|k| Some(&drawn[3 - k])), 4),
        PathView::of_window(&ahead, 4, false, 4),
        PathView::of_window(&behind, 5, true, 4),
    ];
    for (view, read) in views.iter().flat_map(|view| (0..=LAST).map(move |read| (view, read))) {
        for length in [false, true] {
            let shown = view.limited(Reads { vertices: read, length });
            assert_eq!(shown.len(), if length { 4 } else { read });
            for k in 0..5 {
                assert_eq!(shown.back(k), (k < read).then(|| vertices[3 - k]), "{view:?}");
            }
            // What is hidden does not appear again.
            let more = shown.limited(Reads { vertices: LAST, length });
            assert_eq!(more.back(read), None, "{view:?}");
        }
    }
}

/// Finds how many vertices it is shown, though it says that it reads one.
#[derive(Clone, Copy)]
struct Curious;

fn shown(path: &PathView<'_, At>) -> f64 {
    (0..LAST).filter(|k| path.back(*k).is_some()).count() as f64
}

impl Strategy<At> for Curious {
    fn sample<U>(&self, path: PathView<'_, At>, _: &mut U) -> Option<Drawn<At>>
    where
        U: UniformSource<f64> + ?Sized,
    {
        Some(Drawn::new(At(shown(&path))))
    }
    fn pdf(&self, path: PathView<'_, At>, _: &At) -> Conditional<f64> {
        Conditional::density(shown(&path))
    }
    fn reads(&self) -> Reads {
        Reads { vertices: 1, length: true }
    }
}

strategies! {
    #[derive(Clone, Copy)]
    enum Set for At { Curious(Curious) }
}

#[test]
fn sets_show_strategies_what_they_read() {
    let vertices = [At(0.0), At(1.0), At(2.0)];
    let (path, set) = (PathView::from_slice(&vertices), Set::from(Curious));
    let drawn = set.sample_limited(path, &mut || 0.5).map(|drawn| drawn.vertex);
    assert_eq!(drawn, Some(At(1.0)));
    assert_eq!(set.pdf_limited(path, &At(0.0)).of_kind(None), 1.0);
    assert_eq!(Curious.pdf_limited(path, &At(0.0)).of_kind(None), 1.0);
    assert_eq!(set.pdf(path, &At(0.0)).of_kind(None), 3.0);
}
