//! Errors and emitted code, on token streams.

use proc_macro2::TokenStream;
use quote::quote;

use super::strategy;

fn expand(item: TokenStream) -> String {
    strategy(TokenStream::new(), item).to_string()
}

/// The body within a signature that is right.
fn body(statements: TokenStream) -> String {
    expand(quote! {
        pub fn scatter(path: &PathView<Hit>, scene: &Scene, q: f64) -> Hit { #statements }
    })
}

/// The messages in an expansion.
fn errors(expansion: &str) -> Vec<&str> {
    let after = expansion.split("compile_error ! {").skip(1);
    after.filter_map(|rest| rest.split_once('}').map(|(message, _)| message.trim())).collect()
}

/// Checks that there is one error, with these words, and that the function is still emitted.
fn refuses(expansion: &str, words: &str) {
    let found = errors(expansion);
    assert!(found.len() == 1 && found[0].contains(words), "{words}: {found:#?}");
    assert!(expansion.contains("const _ : () ="), "hidden function is missing");
}

#[test]
fn a_right_strategy_has_all_items() {
    let text = body(quote! {
        let here = given(path.last());
        let w = draw(cosine().then(rotate(here.frame())));
        let hit = constant(scene.cast(here, &w));
        Hit::new(hit, plane(hit).apply(&w))
    });
    assert_eq!(errors(&text), [""; 0]);
    for part in [
        "pub struct Scatter < 'scene > { scene : & 'scene Scene , q : f64 , }",
        "pub fn scatter < 'scene > (scene : & 'scene Scene , q : f64) -> Scatter < 'scene >",
        ":: aether_core :: strategy :: Strategy < Hit > for Scatter < 'scene >",
        "vertices : 1usize , length : false",
        "let vertex = Hit :: new (hit , __point_1) ;",
        "Drawn { value : own , dirac : :: core :: option :: Option :: None , .. drawn } . visible ()",
        "recall (target , || { let w = :: aether_core :: forms :: emitted :: point_of",
        "true && :: core :: ptr :: eq (self . scene , other . scene) && self . q . to_bits () == other . q . to_bits ()",
        "locally constant `hit` of `scene.cast(here, &w)`, read from the vertex",
    ] {
        assert!(text.contains(part), "{part}\nis not in\n{text}");
    }
    // The density repeats neither the ray cast nor the draw.
    let density = &text[text.find("fn pdf").unwrap()..text.find("fn reads").unwrap()];
    assert_eq!(density.matches("cast").count(), 1);
    assert!(!density.contains("uniforms"));
}

#[test]
fn signatures() {
    refuses(
        &expand(quote!(
            fn f(scene: &Scene) -> Hit {
                stop()
            }
        )),
        "first parameter",
    );
    refuses(
        &expand(quote!(
            fn f() -> Hit {
                stop()
            }
        )),
        "first parameter",
    );
    refuses(
        &expand(quote!(
            fn f(&self, path: &PathView<Hit>) -> Hit {
                stop()
            }
        )),
        "not a method",
    );
    refuses(
        &expand(quote!(
            async fn f(path: &PathView<Hit>) -> Hit {
                stop()
            }
        )),
        "`async`",
    );
    refuses(
        &expand(quote!(
            unsafe fn f(path: &PathView<Hit>) -> Hit {
                stop()
            }
        )),
        "`unsafe`",
    );
    refuses(
        &expand(quote!(
            const fn f(path: &PathView<Hit>) -> Hit {
                stop()
            }
        )),
        "`const`",
    );
    refuses(
        &expand(quote!(
            fn f(path: &PathView<Hit>) {
                return stop();
            }
        )),
        "write its type",
    );
    refuses(
        &expand(quote!(
            fn f(path: &PathView<Hit>) -> [Hit; 9] {
                stop()
            }
        )),
        "as a number",
    );
    refuses(
        &expand(quote!(
            fn f(path: PathView<Hit>, (a, b): P) -> Hit {
                stop()
            }
        )),
        "plain name",
    );
    refuses(
        &expand(quote!(
            fn f(path: PathView<Hit>, a: &mut A) -> Hit {
                stop()
            }
        )),
        "pure",
    );
    refuses(
        &expand(quote!(
            fn f(path: PathView<Hit>, draw: A) -> Hit {
                stop()
            }
        )),
        "special form",
    );
    let unknown = strategy(
        quote!(fast),
        quote!(
            fn f(path: PathView<Hit>) -> Hit {
                stop()
            }
        ),
    );
    refuses(&unknown.to_string(), "unknown argument");
}

#[test]
fn errors_are_collected() {
    let text = expand(quote! {
        async fn f(path: &PathView<Hit>, (a, b): P) {}
    });
    assert_eq!(errors(&text).len(), 3, "{text}");
}

#[test]
fn special_forms_out_of_place() {
    refuses(&body(quote!(Hit::at(draw(line())))), "all of the right side");
    refuses(&body(quote!(for i in 0..3 { let w = draw(line()); } stop())), "in a loop");
    refuses(&body(quote!(let f = || choose(coin(q)); stop())), "in a closure");
    refuses(&body(quote!(let here = path.last()?; stop())), "given(option)");
    refuses(&body(quote!(let draw = 1.0; stop())), "special form");
    refuses(&body(quote!(let c = choose(a, b); stop())), "one argument");
    refuses(&body(quote!(let (a, b) = draw(line()); Hit::at(a))), "plain name");
    refuses(&body(quote!(while q > 0.0 { return stop(); } stop())), "cannot be followed");
    refuses(&body(quote!(let Some(a) = scene.a() else { panic!() }; stop())), "let .. else");
    refuses(&body(quote!(let a = 1.0;)), "without a vertex");
}

#[test]
fn what_is_drawn_must_be_used_once() {
    refuses(&body(quote!(let w = draw(line()); Hit::origin())), "not made from it");
    for computed in [quote!(2.0 * w), quote!(-w), quote!(w.normalize()), quote!(f(here + (w)))] {
        refuses(&body(quote!(let w = draw(line()); Hit::new(#computed))), "has another density");
    }
    for part in
        [quote!(w, 2.0 * w), quote!(*w), quote!(w.into()), quote!((w.x, w.y)), quote!(f(&w))]
    {
        let text = body(quote!(let w = draw(line()); Hit::new(#part)));
        assert_eq!(errors(&text), [""; 0]);
    }
    let two = quote!(let v = draw(line()); let w = draw(line()); Hit::at(w));
    refuses(&body(two), "a second draw");
    let two = quote! {
        let w = draw(line());
        let a = m.apply(&w);
        let b = n.apply(&w);
        Hit::new(a, b)
    };
    refuses(&body(two), "two points");
    refuses(
        &body(quote!(let w = draw(line()); Hit::at(scale(w).apply(&w)))),
        "depends on the drawn",
    );
    let hidden = quote!(let w = draw(line()); let w = m.apply(&w); Hit::at(w));
    refuses(&body(hidden), "hides a value");
}

#[test]
fn decisions_on_what_is_drawn() {
    let matched = quote!(let w = draw(line()); match side(w) { A => Hit::at(w), _ => stop() });
    refuses(&body(matched), "`match` on a value");
    let chosen = quote!(let w = draw(line()); let (c, _) = choose(scene.lobes(w)); Hit::at(c, w));
    let text = body(chosen);
    assert!(errors(&text).is_empty() && text.contains("outcomes_of"), "{text}");
    let hidden = quote! {
        let w = draw(line());
        let a = choose(scene.lobes(w));
        let a = choose(scene.lobes(w));
        Hit::at(w)
    };
    refuses(&body(hidden), "hides a value");
    let given = quote!(let w = draw(line()); let h = given(scene.cast(w)); Hit::new(h, w));
    refuses(&body(given), "use `constant(..)`");
    let late = quote!(let w = draw(line()); if w < q { return stop(); } Hit::at(w));
    assert!(body(late).contains("density_times"));
}

#[test]
fn an_atom_is_brought_along_by_maps() {
    let text = expand(quote! {
        fn mirror<'s>(path: &PathView<Hit>, scene: &'s Scene) -> Hit {
            let here = given(path.last());
            let w = atom(here.mirrored(), here.cosine());
            let hit = constant(scene.cast(here, &w));
            Hit::new(hit, plane(hit).apply(&w))
        }
    });
    assert_eq!(errors(&text), [""; 0]);
    for part in [
        ":: aether_core :: strategy :: Atom :: new (here . mirrored () , here . cosine ())",
        "if kind == :: core :: option :: Option :: Some (:: aether_core :: strategy :: Dirac :: Direction)",
        "position : false , direction : true",
    ] {
        assert!(text.contains(part), "{part}\nis not in\n{text}");
    }
}

#[test]
fn atoms_must_be_told_apart() {
    refuses(&body(quote!(Hit::origin())), "it is an atom");
    let lights = quote! {
        let light = choose(scene.lights());
        let id = constant(Some(light.id));
        Hit::light(id)
    };
    refuses(&body(lights), "identified_by");
    let arms = quote! {
        let id = constant(scene.pinhole());
        if choose(coin(q)) { Hit::a(id) } else { Hit::b(id) }
    };
    refuses(&body(arms), "identified_by");
    let identified = quote! {
        let light = choose(scene.lights()).identified_by(|hit: &Hit| hit.light);
        let id = constant(Some(light.id));
        Hit::light(id)
    };
    let text = body(identified);
    assert!(errors(&text).is_empty() && text.contains("Dirac :: Position"));
    // What is cast is read back alone; a lamp is compared as well.
    assert!(text.contains("recall_called (target , || { Some (light . id) })"), "{text}");
    let mirror = quote! {
        let here = given(path.last());
        let id = constant(scene.cast(here, here.mirrored()));
        Hit::on(id)
    };
    assert!(body(mirror).contains("Dirac :: Direction"));
}

#[test]
fn reads_of_the_path() {
    refuses(&body(quote!(let a = path.back(q); stop())), "must be a literal");
    refuses(&body(quote!(let a = scene.look(path); stop())), "must be seen here");
    refuses(&body(quote!(let a = path.dirac(); stop())), "reads its path through");
    let text = body(quote!(let a = path.back(1); let n = path.len(); stop()));
    assert!(text.contains("vertices : 2usize , length : true"));
    assert!(!text.contains("length_class"));
    // Lengths that are only compared with parameters are of two classes.
    let seen = quote! {
        let here = given(path.last());
        let id = constant(scene.cast(here, here.mirrored()));
        Hit::on(id)
    };
    let text = body(quote!(if path.len() > q as usize { return stop(); } #seen));
    assert_eq!(errors(&text), [""; 0]);
    assert!(text.contains("length : true"), "{text}");
    assert!(text.contains("u32 :: from (len > q as usize)"), "{text}");
    let exact = [
        quote!(let n = 3; if path.len() > n { return stop(); } #seen),
        quote!(let q = 2.0 * q; if path.len() > q as usize { return stop(); } #seen),
        quote!(if path.len() > q as usize { return stop(); } let n = path.len(); #seen),
        quote!(if q > 0.0 && path.len() > 10 / q as usize { return stop(); } #seen),
        quote!(if path.len() > q as usize - 1 { return stop(); } #seen),
        quote!(if path.len() > q as usize && !path.is_empty() { return stop(); } #seen),
    ];
    for statements in exact {
        let text = body(statements);
        assert_eq!(errors(&text), [""; 0]);
        assert!(!text.contains("length_class"), "{text}");
    }
}

#[test]
fn other_strategies() {
    let text = body(quote!(if choose(coin(q)) {
        delegate(walk(scene))
    } else {
        return delegate(jump(q));
    }));
    assert_eq!(errors(&text), [""; 0]);
    let reads = "length : false } . and (:: aether_core :: strategy :: Strategy :: < Hit > :: reads \
                 (& walk (scene)))";
    assert!(text.contains(reads), "{text}");
    assert!(text.contains("the vertex of `jump(q)`"), "{text}");
    refuses(&body(quote!(let w = draw(line()); delegate(walk(scene)))), "`w` is drawn");
    refuses(&body(quote!(let n = 1; delegate(walk(n)))), "`n` is not a parameter");
    refuses(&body(quote!(let v = delegate(walk(scene)); v)), "end of the path's execution");
    refuses(&body(quote!(let v = if q > 0.5 { delegate(a) } else { x }; v)), "end of the path");
    refuses(&body(quote!(delegate(a, b))), "one argument");
    refuses(&body(quote!(delegate(choose(all)))), "all of the right side");
}

/// The body of a strategy of two vertices.
fn joint(statements: TokenStream) -> String {
    expand(quote! {
        fn segment(path: &PathView<Hit>, scene: &Scene) -> [Hit; 2] { #statements }
    })
}

#[test]
fn each_locally_constant_value_is_read_from_the_vertex_that_keeps_it() {
    let text = joint(quote! {
        let ray = draw(rays());
        let scenery = constant(scene.name());
        let a = constant(scene.cast(&ray));
        let other = a.other;
        let b = constant(scene.cast(&other));
        let ends = through(a, b).apply(&ray);
        [Hit::new(ends.0, other, scenery), Hit::new(ends.1, b, scenery)]
    });
    assert_eq!(errors(&text), [""; 0]);
    let density = &text[text.find("fn pdf_joint").unwrap()..];
    let reads: Vec<_> = density.split("recall (").skip(1).map(|rest| &rest[..18]).collect();
    assert_eq!(reads, ["& target [0usize] ", "& target [0usize] ", "& target [1usize] "]);
    assert!(text.contains("const VERTICES : usize = 2usize"), "{text}");
    let mixed = quote! {
        let ray = draw(rays());
        let a = constant(scene.cast(&ray));
        let b = constant(scene.cast(&ray));
        [Hit::new(ray.0, a, b), Hit::new(ray.1, a, b)]
    };
    refuses(&joint(mixed), "let each value go into one vertex");
    let differs = quote! {
        let ray = draw(rays());
        let a = constant(scene.cast(&ray));
        if path.is_empty() {
            [Hit::new(ray.0, a), Hit::at(ray.1)]
        } else {
            [Hit::at(ray.0), Hit::new(ray.1, a)]
        }
    };
    refuses(&joint(differs), "let each value go into one vertex");
}

#[test]
fn several_vertices_are_made_from_as_many_points() {
    let ends = |vertices: TokenStream| joint(quote!(let x = draw(pair()); #vertices));
    assert_eq!(errors(&ends(quote!([Hit::at(x.0), Hit::at(x.1)]))), [""; 0]);
    assert_eq!(errors(&ends(quote!([Hit::at(x.1), Hit::at(x.0)]))).len(), 2);
    refuses(&ends(quote!([Hit::at(x.0), Hit::at(x)])), "vertex 1 of a draw");
    refuses(&ends(quote!([Hit::at(x.0), Hit::at(x.1 - x.0)])), "vertex 1 of a draw");
    refuses(&ends(quote!(both(x))), "write the 2 vertices");
    refuses(&joint(quote!(delegate(other(scene)))), "only a strategy of one vertex");
    refuses(&joint(quote!([Hit::a(), Hit::b()])), "nothing is drawn for these vertices");
}

#[test]
fn branches_of_another_kind_are_not_entered() {
    let text = body(quote! {
        if choose(coin(q)) {
            let id = constant(scene.pinhole());
            return Hit::a(id);
        }
        let w = draw(line());
        Hit::at(w)
    });
    assert_eq!(errors(&text), [""; 0]);
    let density = &text[text.find("fn __density").unwrap()..];
    for kind in
        ["Option :: None", "Option :: Some (:: aether_core :: strategy :: Dirac :: Position)"]
    {
        let asked = format!("matches ! (kind , :: core :: option :: {kind})");
        assert!(density.contains(&asked), "{asked}\nis not in\n{density}");
    }
}

#[test]
fn what_follows_a_branch_moves_into_its_arms() {
    let text = body(quote! {
        let w = if choose(coin(q)) { draw(line()) } else { draw(ray()) };
        Hit::at(w)
    });
    assert_eq!(errors(&text), [""; 0]);
    assert_eq!(text.matches("let vertex = Hit :: at (w) ;").count(), 2);
    let confused = quote! {
        let n = 1.0;
        if choose(coin(q)) { let n = 2.0; log(n); }
        let w = draw(line());
        Hit::new(n, w)
    };
    refuses(&body(confused), "give it another name");
    let branch = quote!(if choose(coin(q)) {
        log(1);
    });
    let many: TokenStream = std::iter::repeat_n(branch, 7).collect();
    refuses(&body(quote!(let w = draw(line()); #many Hit::at(w))), "more than 64 ways");
}
