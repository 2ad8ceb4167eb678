//! Findings of an examination.

use serde::Serialize;

/// Result of an examination.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(crate) struct Diagnosis {
    /// Name and version of the program.
    pub program: &'static str,
    /// Whether nothing failed.
    pub healthy: bool,
    /// Facts about the device, then results of tests.
    pub findings: Vec<Finding>,
}

/// A fact or the result of a test.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// The fact; of a result `PASS`, `NOTE` where the renderer or its user works around something, or `FAIL` where pictures would be
    /// wrong or missing.
    pub what: String,
    /// Its value, or the reason of a result.
    pub finding: String,
}

impl Diagnosis {
    /// Adds a finding; `FAIL` makes the device unhealthy.
    pub(super) fn line(&mut self, what: &str, finding: &str) {
        self.healthy &= what != "FAIL";
        self.findings.push(Finding { what: what.into(), finding: finding.into() });
    }

    /// Findings as lines of text.
    pub fn text(&self) -> String {
        let lines = self.findings.iter().map(|Finding { what, finding }| format!("{what:<11} {finding}\n"));
        format!("{}\n{}", self.program, lines.collect::<String>())
    }
}
