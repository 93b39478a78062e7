//! Scattering functions are reciprocal and not negative, and their lobes cover them; samples are
//! distributed as their densities say.

use std::f32::consts::TAU;
use std::path::Path;

use glam::{Affine2, Vec2, Vec3};

use super::{Lobe, Material, Scattering};
use crate::chi_square::{FINE, FINER, Sampled, deviation};
use crate::kind::Everything;
use crate::scene::bsdf::*;
use crate::scene::texture::{Colour, Grey, Pattern, Square, Texture};
use crate::scene::{PrimitiveId, Scene, Tangents};
use crate::strategies::{SampleBsdf, sample_bsdf};
use crate::vertex::{Place, SceneVertex, Surface};
use crate::world::World;

fn rough(distribution: Distribution) -> Roughness {
    Roughness { distribution, alpha: [0.3; 2], sample_visible: true }
}

fn facets(distribution: Distribution) -> Facets {
    Facets { distribution, alpha: [0.3, 0.5].map(Grey::from), sample_visible: true }
}

fn materials() -> Vec<Bsdf> {
    let metal = Some(Metal { eta: Vec3::new(0.2, 0.9, 1.1), k: Vec3::new(3.9, 2.5, 2.1) });
    let (white, grey) = (Colour::from(Vec3::ONE), Colour::from(Vec3::splat(0.5)));
    let mut all = vec![
        Bsdf::Diffuse(Diffuse { reflectance: grey }),
        Bsdf::Plastic(Plastic { eta: 1.5, diffuse: grey, reflectance: white, nonlinear: true }),
    ];
    all.push(Bsdf::Phong(Phong { diffuse: grey, specular: grey, exponent: 8.0, scale: 0.9 }));
    for distribution in [Distribution::Beckmann, Distribution::Ggx] {
        let facets = facets(distribution);
        all.push(Bsdf::RoughConductor(RoughConductor { facets, metal, reflectance: white }));
        all.push(Bsdf::RoughPlastic(RoughPlastic {
            roughness: rough(distribution),
            eta: 1.5,
            diffuse: grey,
            reflectance: white,
            nonlinear: false,
            conserving: true,
        }));
        all.push(Bsdf::RoughDielectric(RoughDielectric {
            facets,
            eta: 1.5,
            reflectance: white,
            transmittance: white,
        }));
    }
    let pair = [all[0].clone(), all[3].clone()];
    all.push(Bsdf::Blend { weight: 0.3.into(), nested: Box::new(pair.clone()) });
    all.push(Bsdf::Blend {
        weight: 0.3.into(),
        nested: Box::new(pair.map(|part| masked(0.6, part))),
    });
    all
}

fn masked(opacity: f32, nested: Bsdf) -> Bsdf {
    Bsdf::Mask { opacity: opacity.into(), nested: Box::new(nested) }
}

fn direction(k: u32) -> Vec3 {
    let z = 2.0 * ((k as f32 * 0.618_034 + 0.17) % 1.0) - 1.0;
    let phi = 2.4 * k as f32;
    let r = (1.0 - z * z).sqrt();
    Vec3::new(r * phi.cos(), r * phi.sin(), z)
}

/// Scattering at a surface without textures that faces +z.
fn scattering(material: &Material<Everything>, v: Vec3) -> Option<Scattering<'_, Everything>> {
    let surface = Surface {
        position: Vec3::ZERO,
        normal: Vec3::Z,
        shading: Vec3::Z,
        primitive: PrimitiveId(0),
        emitter: None,
        uv: Vec2::ZERO,
        tangents: Tangents { du: Vec3::new(0.8, 0.6, 0.0), dv: Vec3::new(-0.6, 0.8, 0.0) },
    };
    Scattering::new(material, &[], &surface, [v, v])
}

/// The value for light from `w` to `v`, without the cosine; zero where the material is black.
fn value(material: &Material<Everything>, v: Vec3, w: Vec3) -> Vec3 {
    scattering(material, v).map_or(Vec3::ZERO, |s| s.value(w) / w.z.abs())
}

#[test]
fn scattering_is_reciprocal() {
    for bsdf in materials() {
        let eta = if let Bsdf::RoughDielectric(glass) = &bsdf { glass.eta } else { 1.0 };
        let material = Material::new(&bsdf).unwrap();
        let mut positive = 0;
        for k in 0..400 {
            let (v, w) = (direction(k), direction(7 * k + 3));
            let (there, back) = (value(&material, v, w), value(&material, w, v));
            // f(v, w) / n² is symmetric, where n is the index of refraction where the light arrives.
            let scale = |to: Vec3| if to.z < 0.0 { eta * eta } else { 1.0 };
            let (a, b) = (there / scale(v), back / scale(w));
            assert!(a.min_element() >= 0.0, "{a} at {v} {w}");
            assert!(
                (a - b).abs().max_element() <= 2e-4 * a.max_element() + 1e-7,
                "{a} {b} {v} {w} {bsdf:?}"
            );
            positive += u32::from(a.max_element() > 0.0);
        }
        assert!(positive > 60, "{positive}: {bsdf:?}");
    }
}

/// Smooth glass and a pane.
fn panes() -> [Bsdf; 2] {
    let [reflectance, transmittance] = [0.9, 0.8].map(|share| Vec3::splat(share).into());
    [
        Bsdf::Dielectric(Dielectric { eta: 1.5, reflectance, transmittance }),
        Bsdf::ThinDielectric(ThinDielectric { eta: 1.5, reflectance, transmittance }),
    ]
}

/// What a mirror, a pane or a boundary sends one way it sends the other way, as radiance over the squared index of
/// refraction.
#[test]
fn atoms_are_reciprocal() {
    let metal = Some(Metal { eta: Vec3::new(0.2, 0.9, 1.1), k: Vec3::new(3.9, 2.5, 2.1) });
    let mut all = panes().to_vec();
    all.push(materials()[1].clone());
    all.push(Bsdf::Conductor(Conductor { metal, reflectance: Vec3::splat(0.9).into() }));
    for bsdf in all {
        let eta = if let Bsdf::Dielectric(glass) = &bsdf { glass.eta } else { 1.0 };
        let squared = |w: Vec3| if w.z < 0.0 { eta * eta } else { 1.0 };
        let material = Material::<Everything>::new(&bsdf).unwrap();
        let atoms = |v: Vec3| -> Vec<(Vec3, Vec3)> {
            let Some(s) = scattering(&material, v) else { return Vec::new() };
            let lobes = (0..s.count()).filter_map(|i| s.lobe(i));
            let with = |lobe| {
                let w: Vec3 = s.pose.frame().to_world(s.direction(&lobe)?).into();
                Some((w, lobe.coefficient * squared(w) / squared(v)))
            };
            lobes.filter_map(with).collect()
        };
        let mut pairs = 0;
        for v in (0..100).map(direction) {
            // Total reflection has no other side.
            for (w, there) in
                atoms(v).into_iter().filter(|(w, there)| w.z != 0.0 && *there != Vec3::ZERO)
            {
                let back = atoms(w).into_iter().filter(|(to, _)| to.distance(v) < 1e-3);
                let back: Vec3 = back.map(|(_, share)| share).sum();
                let error = (there - back).abs().max_element();
                // A cosine is known to a rounding error over itself: that of the direction on the other side.
                let least = v.z.abs().min(w.z.abs());
                let bound = (1e-5 + 1e-6 / (least * least)) * there.max_element();
                assert!(error <= bound, "{there} {back} {v} {w} {bsdf:?}");
                pairs += 1;
            }
        }
        assert!(pairs >= 40, "{pairs}: {bsdf:?}");
    }
}

#[test]
fn chances_add_up_to_one() {
    let mut all = materials();
    all.extend(panes());
    let masked = all.iter().cloned().map(|nested| masked(0.3, nested));
    for bsdf in all.clone().into_iter().chain(masked) {
        let material = Material::<Everything>::new(&bsdf).unwrap();
        for k in 0..50 {
            let Some(s) = scattering(&material, direction(k)) else { continue };
            let lobes = (0..s.count()).map(|i| s.lobe(i).expect("there are so many"));
            let sum: f32 = lobes.clone().map(|lobe| lobe.chance).sum();
            assert!((sum - 1.0).abs() < 1e-6, "{sum} {bsdf:?}");
            // Light that passes unchanged, or in one direction, is found by that direction.
            for lobe in lobes.filter(|lobe| lobe.lobe.is_atom()) {
                let w = s.direction(&lobe).expect("an atom has a direction");
                let atoms = s.atoms(s.pose.frame().to_world(w).into());
                let expected = lobe.coefficient * s.measure(&lobe.lobe, w);
                assert!(
                    (atoms - expected).abs().max_element() < 1e-6
                        || matches!(lobe.lobe, Lobe::Passage(_))
                );
            }
        }
    }
}

/// Holes in the parts of a mixture, and in all of it: values and what passes are those of the parts.
#[test]
fn parts_of_mixtures_have_holes_of_their_own() {
    let [matte, metal] = [0, 3].map(|k| materials()[k].clone());
    let mixture = |parts: [Bsdf; 2]| Bsdf::Blend { weight: 0.3.into(), nested: Box::new(parts) };
    let material = |bsdf: &Bsdf| Material::<Everything>::new(bsdf).unwrap();
    let holed = mixture([masked(0.8, matte.clone()), metal.clone()]);
    let mixed = material(&masked(0.5, holed));
    let parts = [material(&matte), material(&metal)];
    let share = [0.5 * 0.7 * 0.8, 0.5 * 0.3];
    let (v, w) = (Vec3::new(0.36, 0.48, 0.8), Vec3::new(-0.6, 0.0, 0.8));
    let value = |material| scattering(material, v).expect("not black").value(w);
    let expected = share[0] * value(&parts[0]) + share[1] * value(&parts[1]);
    let found = value(&mixed);
    assert!((found - expected).abs().max_element() < 1e-6, "{found}, not {expected}");
    let s = scattering(&mixed, v).expect("not black");
    let passage = s.lobe(s.count() - 1).expect("a hole");
    let holes = 1.0 - share[0] - share[1];
    assert!((passage.coefficient - holes).abs().max_element() < 1e-6, "{passage:?}");
    assert!((passage.chance - holes).abs() < 1e-6, "{passage:?}");
}

/// Scattering at a surface whose material turns normals by a texture.
fn turned<'a>(
    material: &'a Material<Everything>,
    textures: &'a [Texture],
    v: Vec3,
) -> Option<Scattering<'a, Everything>> {
    let tangents = Tangents { du: Vec3::X, dv: Vec3::Y };
    let (normal, shading) = (Vec3::Z, Vec3::Z);
    let (position, uv) = (Vec3::ZERO, Vec2::splat(0.25));
    let primitive = PrimitiveId(0);
    let surface = Surface { position, normal, shading, primitive, emitter: None, uv, tangents };
    Scattering::new(material, textures, &surface, [v, v])
}

/// Parts of mixtures of mixtures have normals of their own: what all scatter is the weighted sum of what each
/// does alone, from sides too from which some are turned away.
#[test]
fn parts_of_mixtures_are_turned_by_themselves() {
    let normals = [Vec3::new(0.8, 0.5, 0.9), Vec3::new(0.2, 0.6, 0.8)];
    let textures = normals.map(|colour| Texture {
        pattern: Pattern::Checkerboard([colour; 2].map(Square::Plain)),
        to_uv: Affine2::IDENTITY,
        scale: 1.0,
    });
    let bumped = |texture, nested: &Bsdf| Bsdf::Bump {
        bump: Bump { texture, relief: Relief::Normals, flip_invalid: false, shadowing: true },
        nested: Box::new(nested.clone()),
    };
    let mixture = |share: f32, parts: [Bsdf; 2]| Bsdf::Blend {
        weight: share.into(),
        nested: Box::new(parts),
    };
    let mirror = Bsdf::Conductor(Conductor { metal: None, reflectance: Vec3::ONE.into() });
    let parts = [
        (0.5 * 0.6 * 0.8, bumped(0, &materials()[3])),
        (0.5 * 0.6 * 0.2, bumped(1, &mirror)),
        (0.5 * 0.4, materials()[1].clone()),
    ];
    let inner = mixture(0.2, [parts[0].1.clone(), parts[1].1.clone()]);
    let whole = masked(0.5, mixture(0.4, [inner, parts[2].1.clone()]));
    let whole = Material::<Everything>::new(&whole).unwrap();
    let mut lit = 0;
    for k in 0..200 {
        let (v, w) = (direction(k), direction(5 * k + 2));
        let s = turned(&whole, &textures, v).expect("light passes the holes");
        let alone = parts.each_ref().map(|(_, bsdf)| Material::<Everything>::new(bsdf).unwrap());
        let mut expected = Vec3::ZERO;
        for ((share, _), part) in parts.iter().zip(&alone) {
            let Some(part) = turned(part, &textures, v) else { continue };
            expected += *share * part.value(w);
            for index in 0..part.count() {
                let lobe = part.lobe(index).expect("there are so many");
                let Some(local) = part.direction(&lobe) else { continue };
                let along = Vec3::from(part.pose.frame().to_world(Vec3::from(local.vec())));
                let (found, expected) = (s.atoms(along), *share * part.atoms(along));
                assert!((found - expected).abs().max_element() < 1e-5, "{found} {expected} {v}");
                lit += u32::from(expected != Vec3::ZERO);
            }
        }
        let found = s.value(w);
        assert!((found - expected).abs().max_element() < 1e-5, "{found} {expected} {v} {w}");
        lit += u32::from(expected != Vec3::ZERO);
        let chances = (0..s.count()).map(|index| s.lobe(index).expect("so many").chance);
        assert!((chances.sum::<f32>() - 1.0).abs() < 1e-5);
    }
    assert!(lit > 100, "{lit}");
}

/// Phong's lobe reflects all light that arrives along the normal, and never more.
#[test]
fn phong_reflects_no_more_than_there_is() {
    for exponent in [0.0, 1.0, 20.0] {
        let (diffuse, specular) = (Vec3::ZERO.into(), Vec3::ONE.into());
        let bsdf = Bsdf::Phong(Phong { diffuse, specular, exponent, scale: 1.0 });
        let material = Material::<Everything>::new(&bsdf).unwrap();
        for z in [1.0f32, 0.7, 0.2] {
            let view = Vec3::new((1.0 - z * z).sqrt(), 0.0, z);
            let s = scattering(&material, view).unwrap();
            const N: usize = 400;
            let sum: f32 = (0..N * N)
                .map(|k| {
                    let z = ((k / N) as f32 + 0.5) / N as f32;
                    let phi = TAU * ((k % N) as f32 + 0.5) / N as f32;
                    let r = (1.0 - z * z).sqrt();
                    s.value(Vec3::new(r * phi.cos(), r * phi.sin(), z)).x
                })
                .sum();
            let albedo = sum * TAU / (N * N) as f32;
            assert!(albedo < 1.001, "{albedo} for exponent {exponent} at {z}");
            assert!(z < 1.0 || albedo > 0.999, "{albedo} for exponent {exponent}");
        }
    }
}

/// A square of a material under a sky that shines everywhere.
fn square(bsdf: &str) -> Scene {
    let xml = format!(
        r#"<scene version="3.0.0"><sensor type="perspective"/>
        <emitter type="constant"/><shape type="rectangle">{bsdf}</shape></scene>"#
    );
    Scene::from_str(&xml, Path::new("."), &[]).unwrap_or_else(|error| panic!("{error}"))
}

/// How a material is sampled, seen from a direction.
fn sampled<'w>(world: &'w World<'w>, view: Vec3) -> Sampled<'w, SampleBsdf<'w, 'w, Everything>> {
    let eye = SceneVertex { position: 4.0 * view, place: Place::Camera };
    let hit = world.trace(eye.position, -view, None).expect("the square is in sight");
    let strategy = sample_bsdf(world, u32::MAX, None);
    Sampled { world, strategy, path: vec![eye, SceneVertex::on(hit)] }
}

#[test]
fn samples_have_the_densities_that_they_say() {
    let facets = |plugin: &str, more: &str, alpha: f64| {
        ["beckmann", "ggx"].map(|distribution| {
            format!(
                r#"<bsdf type="{plugin}"><float name="alpha_u" value="{alpha}"/>{more}
                <float name="alpha_v" value="{alpha}"/>
                <string name="distribution" value="{distribution}"/></bsdf>"#
            )
        })
    };
    let classical = r#"<boolean name="sample_visible" value="false"/>"#;
    let mut models = vec![
        r#"<bsdf type="diffuse"/>"#.to_owned(),
        r#"<bsdf type="plastic"/>"#.to_owned(),
        r#"<bsdf type="phong"><float name="exponent" value="9"/></bsdf>"#.to_owned(),
        r#"<bsdf type="blendbsdf"><float name="weight" value="0.4"/><bsdf type="diffuse"/>
            <bsdf type="roughconductor"><float name="alpha_u" value="0.3"/>
                <float name="alpha_v" value="0.6"/></bsdf></bsdf>"#
            .to_owned(),
        r#"<bsdf type="mask"><bsdf type="roughdielectric"><float name="alpha" value="0.4"/></bsdf>
            </bsdf>"#
            .to_owned(),
    ];
    let turned = |colour: &str, nested: &str| {
        format!(
            r#"<bsdf type="normalmap"><texture type="checkerboard" name="normalmap">
            <rgb name="color0" value="{colour}"/><rgb name="color1" value="{colour}"/></texture>{nested}</bsdf>"#
        )
    };
    let rough = r#"<bsdf type="roughconductor"><float name="alpha" value="0.4"/></bsdf>"#;
    models.push(format!(
        r#"<bsdf type="blendbsdf"><float name="weight" value="0.6"/>{}
        <bsdf type="blendbsdf"><float name="weight" value="0.5"/>{}<bsdf type="plastic"/></bsdf></bsdf>"#,
        turned("0.8,0.5,0.9", rough),
        turned("0.3,0.7,0.85", r#"<bsdf type="diffuse"/>"#),
    ));
    for alpha in [0.15, 0.3, 0.8] {
        models.extend(facets("roughconductor", "", alpha));
        models.extend(facets("roughdielectric", "", alpha));
    }
    models.extend(facets("roughconductor", classical, 0.4));
    models.extend(facets("roughplastic", "", 0.4));
    let mut off = Vec::new();
    for (seed, model) in (1..).zip(&models) {
        let scene = square(model);
        let world = World::new(&scene).unwrap();
        for z in [0.95f32, 0.5, 0.15, 0.04, -0.6] {
            let narrow = model.contains("0.15");
            if z == 0.04 && !narrow && !model.contains(classical) {
                continue;
            }
            let r = (1.0 - z * z).sqrt();
            let view = Vec3::new(0.6 * r, -0.8 * r, z);
            if z < 0.0 && !model.contains("dielectric") {
                continue;
            }
            let fine = if narrow || z == 0.04 { FINER } else { FINE };
            let z = sampled(&world, view).deviation(seed, fine);
            println!("{z:.1} standard deviations, seen from {view}: {model}");
            // One of all would be that far off once in a hundred thousand runs.
            if z > 5.0 {
                off.push((z, view, model));
            }
        }
    }
    assert!(off.is_empty(), "{off:#?}");
    // A roughness that is five percent larger is told apart.
    let [scene, other] = [0.3, 0.315].map(|alpha| square(&facets("roughconductor", "", alpha)[0]));
    let [world, other] = [&scene, &other].map(|scene| World::new(scene).unwrap());
    let view = Vec3::new(0.6, 0.0, 0.8);
    let counts = sampled(&world, view).counts(1);
    assert!(deviation(&counts, &sampled(&other, view).expected(FINE)) > 5.0);
}
