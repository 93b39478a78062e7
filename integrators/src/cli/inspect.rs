//! `aether inspect`: what is in a scene, and what a render will use.

use std::process::ExitCode;

use super::arguments::InspectArguments;
use super::warnings::warn_of;
use super::{Failure, print};
use crate::scene::{Scene, inspect};

/// Reads the scene and prints its contents.
pub(super) fn run(arguments: &InspectArguments) -> Result<ExitCode, Failure> {
    let scene = Scene::load(&arguments.scene, &arguments.defines)?;
    warn_of(&scene);
    let text = if arguments.json {
        format!("{:#}", inspect::json(&scene))
    } else {
        inspect::summary(&scene)
    };
    print(text.trim_end())?;
    Ok(ExitCode::SUCCESS)
}
