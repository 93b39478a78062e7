//! The options that an image depends on, in one list: the header of an image tells those that it depends on, and a render that
//! goes on has to have those that samples depend on.

use super::arguments::RenderArguments;
use super::plan::Plan;
use crate::convergence::reference::crop_text;
use crate::poisson::Reconstruction;

/// What depends on a setting, and is to tell it.
#[derive(Clone, Copy, Debug, PartialEq)]
enum By {
    /// The header of an image: samples are the same without it.
    Image,
    /// A checkpoint: images do not depend on it, or have attributes for it.
    Samples,
    /// Both.
    Both,
}

/// An option that is set, by a name that a user knows.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Setting {
    name: String,
    value: String,
    by: By,
}

/// The value of an option that is set or not.
const SET: &str = "set";

/// All options that are set to something else than what they mostly are, but for how many samples there are.
pub(super) fn settings(plan: &Plan, arguments: &RenderArguments) -> Vec<Setting> {
    use By::{Both, Image, Samples};
    let Plan { integrator, size, seed, max_depth, techniques, mutations, .. } = plan;
    let some = |value: String| Some(value);
    let set = |is_set: bool| is_set.then(|| SET.to_owned());
    let reconstruction = match plan.reconstruction {
        Reconstruction::L1 => "l1",
        Reconstruction::L2 => "l2",
        Reconstruction::None => "none",
    };
    // Windows that are good enough for one target may not be for another.
    let by_target = if arguments.adaptive { Both } else { Image };
    let list = [
        (Samples, "version of the program", some(env!("CARGO_PKG_VERSION").to_owned())),
        (Samples, "size", some(format!("{}x{}", size.0, size.1))),
        (Samples, "crop", some(crop_text(plan.crop))),
        (Samples, "integrator", some(integrator.clone())),
        (Samples, "seed", some(seed.to_string())),
        (Samples, "sampler", some(plan.sampler_name().to_owned())),
        (Samples, "kind", some(plan.kind.clone())),
        (Samples, "technique images", arguments.technique_images.map(|n| n.to_string())),
        (Both, "max_depth", some(max_depth.map_or("-1".to_owned(), |depth| depth.to_string()))),
        (Both, "rr_depth", some(plan.rr_depth.to_string())),
        (Both, "hide_emitters", set(plan.hide_emitters)),
        (Both, "techniques", (!techniques.is_all()).then(|| techniques.to_string())),
        (Image, "reconstruction", (integrator == "gdpt").then(|| reconstruction.to_owned())),
        (Both, "light_paths", plan.light_paths.map(|paths| paths.to_string())),
        (Both, "clamp", plan.clamp.map(|limit| limit.to_string())),
        (Both, "mutations", (*mutations != Default::default()).then(|| mutations.to_string())),
        (Both, "chained_direct", set(!plan.separate_direct)),
        (by_target, "target_error", arguments.target_error.map(|target| target.to_string())),
        (Both, "adaptive", set(arguments.adaptive)),
        (Both, "mitsuba3_roughplastic", set(arguments.mitsuba3_roughplastic)),
        (Both, "portal", Some(arguments.portals.join(",")).filter(|ids| !ids.is_empty())),
    ];
    let parameters = arguments.defines.iter().map(|(name, value)| {
        let by = if plan.sample_parameters.contains(name) { Image } else { Both };
        Setting { name: format!("-D {name}"), value: value.clone(), by }
    });
    let list = list.into_iter().filter_map(|(by, name, value)| {
        value.map(|value| Setting { name: name.to_owned(), value, by })
    });
    list.chain(parameters).collect()
}

/// Those that samples depend on, by name.
pub(super) fn of_samples(settings: Vec<Setting>) -> Vec<(String, String)> {
    let known = settings.into_iter().filter(|setting| setting.by != By::Image);
    known.map(|setting| (setting.name, setting.value)).collect()
}

/// Those that an image depends on and has no attribute for, in one line.
pub(super) fn of_image(settings: &[Setting]) -> String {
    let told = settings.iter().filter(|setting| setting.by != By::Samples);
    let told = told.map(|Setting { name, value, .. }| match value.as_str() {
        SET => name.clone(),
        _ => format!("{name}={value}"),
    });
    told.collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::scene::Scene;

    fn settings_of(line: &[&str]) -> Vec<Setting> {
        let xml = r#"<scene version="3.0.0"><sensor type="perspective">
            <sampler type="independent"><integer name="sample_count" value="$n"/></sampler></sensor>
            <shape type="sphere"><bsdf type="diffuse"><rgb name="reflectance" value="$grey"/></bsdf></shape></scene>"#;
        let words = ["aether", "render", "a.xml", "-Dn=4", "-Dgrey=0.5"].iter().chain(line);
        let arguments = match super::super::Arguments::parse_from(words).command {
            super::super::Command::Render(arguments) => *arguments,
            other => panic!("{other:?}"),
        };
        let scene = Scene::from_str(xml, std::path::Path::new("."), &arguments.defines).unwrap();
        settings(&Plan::new(&scene, &arguments), &arguments)
    }

    #[test]
    fn what_biases_an_image_is_told_of_it_and_of_its_samples() {
        let usual = settings_of(&[]);
        assert_eq!(of_image(&usual), "max_depth=-1 rr_depth=5 -D n=4 -D grey=0.5");
        let samples = of_samples(usual.clone());
        // How many samples there are is no matter.
        assert!(samples.iter().all(|(name, _)| name != "-D n"), "{samples:?}");
        for option in [
            "--techniques=1:*",
            "--mutations=lens,caustic",
            "--clamp=2",
            "--light-paths=3",
            "--chained-direct",
            "--mitsuba3-roughplastic",
            "--portal=a",
            "--max-depth=3",
            "-Dgrey=0.6",
        ] {
            let other = settings_of(&[option]);
            assert_ne!(of_image(&other), of_image(&usual), "{option}");
            assert_ne!(of_samples(other), samples, "{option}");
        }
        // What is made of samples may change.
        let (l1, l2) = (["--integrator=gdpt"], ["--integrator=gdpt", "--reconstruction=l2"]);
        let (l1, l2) = (settings_of(&l1), settings_of(&l2));
        assert_ne!(of_image(&l1), of_image(&l2));
        assert_eq!(of_samples(l1), of_samples(l2));
        let target = settings_of(&["--target-error=0.1"]);
        assert_eq!(of_samples(target.clone()), samples);
        assert!(of_image(&target).contains("target_error=0.1"));
        let adaptive = settings_of(&["--target-error=0.1", "--adaptive"]);
        assert!(of_samples(adaptive).contains(&("target_error".to_owned(), "0.1".to_owned())));
    }
}
