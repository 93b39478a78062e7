//! `aether report`: one page for several measurements.

use std::process::ExitCode;

use super::arguments::ReportArguments;
use super::{Failure, print};
use crate::convergence::report::Measurements;

/// Reads the directories and writes the page.
pub(super) fn run(arguments: &ReportArguments) -> Result<ExitCode, Failure> {
    let measurements = Measurements::read(&arguments.directories).map_err(Failure::new)?;
    let text = measurements.report(&arguments.output).map_err(Failure::new)?;
    print(&text)?;
    print(&format!("{}", arguments.output.join("report.html").display()))?;
    Ok(ExitCode::SUCCESS)
}
