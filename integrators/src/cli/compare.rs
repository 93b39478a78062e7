//! `aether compare`: error measures of an image against a reference.

use std::process::ExitCode;

use serde_json::{Value, json};

use super::arguments::CompareArguments;
use super::{Failure, print, warn};
use crate::image::compare::{Comparison, compare};
use crate::image::exr::Exr;

/// Reads both files and prints all measures.
pub(super) fn run(arguments: &CompareArguments) -> Result<ExitCode, Failure> {
    let image = Exr::read(&arguments.image)?;
    let reference = Exr::read(&arguments.reference)?;
    let comparison = compare(&image, &reference)?;
    for (path, count) in [
        (&arguments.image, comparison.non_finite_pixels),
        (&arguments.reference, comparison.non_finite_reference_pixels),
    ] {
        if count > 0 {
            warn(&format!("warning: `{}` has {count} NaN or infinite pixels", path.display()));
        }
    }
    let json = arguments.json;
    print(&if json { format!("{:#}", as_json(&comparison)) } else { as_text(&comparison) })?;
    Ok(ExitCode::SUCCESS)
}

fn as_json(comparison: &Comparison) -> Value {
    let block_test = comparison.block_test.as_ref().map(|test| {
        json!({
            "blocks": test.blocks,
            "max_abs_z": test.max_z(),
            "failing_blocks": test.failing_blocks,
            "worst_block": [test.worst.origin.0, test.worst.origin.1],
            "worst_channel": channel_name(test.worst.channel),
        })
    });
    json!({
        "width": comparison.size.0,
        "height": comparison.size.1,
        "rmse": comparison.rmse,
        "relmse": comparison.rel_mse,
        "smape": comparison.smape,
        "psnr_db": comparison.psnr,
        "flip": comparison.flip,
        "mean_ratio": comparison.mean_ratio,
        "non_finite_pixels": comparison.non_finite_pixels,
        "non_finite_reference_pixels": comparison.non_finite_reference_pixels,
        "block_test": block_test,
    })
}

fn as_text(comparison: &Comparison) -> String {
    let blocks = match &comparison.block_test {
        None => "not possible: it needs variance.R, variance.G, variance.B in both".to_owned(),
        Some(test) => format!(
            "{} of {} blocks differ, max |z| {:.2} at pixel {},{} in {}",
            test.failing_blocks,
            test.blocks,
            test.max_z(),
            test.worst.origin.0,
            test.worst.origin.1,
            channel_name(test.worst.channel),
        ),
    };
    let lines = [
        ("size", format!("{}x{}", comparison.size.0, comparison.size.1)),
        ("RMSE", format!("{:.6e}", comparison.rmse)),
        ("relMSE", format!("{:.6e}", comparison.rel_mse)),
        ("SMAPE", format!("{:.6}", comparison.smape)),
        ("PSNR", format!("{:.2} dB (peak 1)", comparison.psnr)),
        ("FLIP", format!("{:.6}", comparison.flip)),
        ("mean ratio", format!("{:.6}", comparison.mean_ratio)),
        ("block z-test", blocks),
    ];
    let lines = lines.map(|(name, value)| format!("{name:<14}{value}"));
    lines.join("\n")
}

fn channel_name(channel: usize) -> &'static str {
    ["R", "G", "B"][channel]
}
