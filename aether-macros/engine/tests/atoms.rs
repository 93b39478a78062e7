//! Probabilities of atoms: which formula they are given, and what is refused.

use aether_engine::interpret::Item;
use quote::quote;

fn compile(
    attribute: proc_macro2::TokenStream,
    item: proc_macro2::TokenStream,
) -> Result<Item, String> {
    Item::new(attribute, item, true)
}

/// The probability of atom 0 as text, with the only way to it.
fn probability(item: &Item) -> String {
    let [atom] = &item.atoms[..] else { panic!("there are {} ways to atoms", item.atoms.len()) };
    aether_engine::display::show(&atom.graph, atom.probability)
}

#[test]
fn a_tail_is_written_as_such() {
    let flights = [
        quote!(-(-u[0]).ln_1p() / extinction),
        quote!(-(1.0 - u[0]).ln() / extinction),
        quote!(-u[0].ln() / extinction),
    ];
    for t in flights {
        let item = compile(
            quote!(extinction in 0.0..=1e3, wall in 0.0..=1e3),
            quote!(
                fn flight(u: [Uniform; 1], extinction: f64, wall: f64) -> Mixed {
                    let t = #t;
                    if t < wall { Mixed::Continuous(t) } else { Mixed::Atom(0, wall) }
                }
            ),
        )
        .expect("can be derived");
        assert_eq!(probability(&item), "exp(-extinction wall)");
        assert_eq!(item.probability(&[2.0, 300.0], 0), (-600f64).exp());
        assert_eq!(item.probability(&[2.0, 300.0], 1), 0.0);
    }
}

#[test]
fn a_comparison_that_follows_from_another_costs_nothing() {
    let item = compile(
        quote!(left in -1e9..=1e9, right in -1e9..=1e9, where left < right),
        quote!(
            fn right_wall(u: [Uniform; 1], left: f64, right: f64) -> Option<Mixed> {
                let x = (PI * (u[0] - 0.5)).tan();
                if x < left {
                    None
                } else if x > right {
                    Some(Mixed::Atom(0, right))
                } else {
                    Some(Mixed::Continuous(x))
                }
            }
        ),
    )
    .expect("can be derived");
    assert_eq!(probability(&item), "atan2(1, right) / π");
}

#[test]
fn uniforms_multiply() {
    let item = compile(
        quote!(a in 0.0..=1.0, b in 0.0..=1.0),
        quote!(
            fn corner(u: [Uniform; 2], a: f64, b: f64) -> Mixed<Vec2> {
                if u[0] < a && u[1] > b {
                    return Mixed::Atom(0, Vec2::new(a, b));
                }
                Mixed::Continuous(Vec2::new(u[0], u[1]))
            }
        ),
    )
    .expect("can be derived");
    assert_eq!(probability(&item), "a (1 - b)");
}

/// Asserts that a body is refused for a reason.
#[track_caller]
fn refused(attribute: proc_macro2::TokenStream, body: proc_macro2::TokenStream, why: &str) {
    let item = quote!(
        fn item(u: [Uniform; 2], r: f64) -> Mixed<Vec2> {
            let at = Vec2::new(0.0, 1.0);
            let rest = Mixed::Continuous(Vec2::new(u[0], u[1]));
            #body
        }
    );
    let Err(message) = compile(attribute, item) else { panic!("{body} was taken") };
    assert!(message.contains(why), "{message}");
}

#[test]
fn what_has_no_formula_is_refused() {
    let unit = quote!(r in 0.0..=1.0);
    let atom = quote!(Mixed::Atom(0, at));
    refused(unit.clone(), quote!(if u[0] + u[1] < r { #atom } else { rest }), "together");
    refused(
        quote!(r in 0.0..=0.2),
        quote!(if u[0] * (1.0 - u[0]) < r { #atom } else { rest }),
        "monotone",
    );
    refused(quote!(), quote!(if r * u[0] < 1.0 { #atom } else { rest }), "declare its domain");
    refused(
        quote!(r in 0.2..=0.8),
        quote!(if u[0] + 0.5 * u[0].sin() < r { #atom } else { rest }),
        "cannot be solved",
    );
    refused(
        unit.clone(),
        quote!(if u[0] < r { Mixed::Atom(0, Vec2::new(0.0, u[1])) } else { rest }),
        "depends on parameters alone",
    );
    refused(
        unit.clone(),
        quote!(if u[0] < 0.25 { #atom } else if u[0] < 0.5 { Mixed::Atom(0, Vec2::new(r, r)) } else { rest }),
        "on another way",
    );
    refused(unit.clone(), quote!(if u[0] < r { Mixed::Atom(r, at) } else { rest }), "a literal");
    refused(unit.clone(), quote!(if u[0] < r { at } else { rest }), "promises a `Mixed` point");
    refused(
        unit,
        quote!(if u[0] < r { #atom } else { Mixed::Atom(1, -at) }),
        "every way through this body ends in an atom",
    );
}

#[test]
fn a_map_has_no_atoms() {
    let item = quote!(
        fn clamped(x: f64) -> Mixed {
            if x < 0.0 { Mixed::Atom(0, 0.0) } else { Mixed::Continuous(x) }
        }
    );
    let message = Item::new(quote!(), item, false).err().expect("is refused");
    assert!(message.contains("only a sampler draws atoms"), "{message}");
}
