//! What the battery found.

use core::fmt;

/// How a check went.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Everything as it should be.
    Passed,
    /// Something is wrong, or could not be decided; the detail says what.
    Failed,
    /// The check does not apply to this sampler; the detail says why.
    NotApplicable,
}

/// One check and its outcome.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Which check.
    pub check: &'static str,
    /// How it went.
    pub verdict: Verdict,
    /// The figures: how many points, the worst deviation, a counterexample.
    pub detail: String,
}

/// What the battery found; prints as one line a check.
#[derive(Clone, Debug, PartialEq)]
#[must_use = "call `assert_ok` or look at the findings"]
pub struct Report {
    subject: String,
    findings: Vec<Finding>,
}

impl Report {
    pub(super) fn new(subject: &str) -> Self {
        Report { subject: subject.to_owned(), findings: Vec::new() }
    }

    pub(super) fn add(&mut self, check: &'static str, verdict: Verdict, detail: String) {
        self.findings.push(Finding { check, verdict, detail });
    }

    /// Adds a check over many points, which fails on the first counterexample.
    pub(super) fn conclude(
        &mut self,
        check: &'static str,
        failure: Option<String>,
        success: String,
    ) {
        match failure {
            None => self.add(check, Verdict::Passed, success),
            Some(detail) => self.add(check, Verdict::Failed, detail),
        }
    }

    /// Every check in the order in which it ran.
    pub fn findings(&self) -> &[Finding] {
        &self.findings
    }

    /// The checks that failed.
    pub fn failures(&self) -> impl Iterator<Item = &Finding> {
        self.findings.iter().filter(|f| f.verdict == Verdict::Failed)
    }

    /// Whether no check failed.
    pub fn is_ok(&self) -> bool {
        self.failures().next().is_none()
    }

    /// Does nothing if no check failed.
    ///
    /// # Panics
    /// With the whole report as the message if a check failed.
    #[track_caller]
    pub fn assert_ok(&self) {
        assert!(self.is_ok(), "the sampler fails its check battery\n{self}");
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.subject)?;
        for Finding { check, verdict, detail } in &self.findings {
            let word = match verdict {
                Verdict::Passed => "ok",
                Verdict::Failed => "FAILED",
                Verdict::NotApplicable => "n/a",
            };
            writeln!(f, "  {check:<12} {word:<7} {detail}")?;
        }
        Ok(())
    }
}
