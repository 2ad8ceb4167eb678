//! Kinds of density modulation functions.
//!
//! Source: PH 2: position-dependent f(x), position-independent f(k), geometry-dependent (it knows the gradient).

use super::error::LibraryError;
use super::file::{Include, include};
use super::library::Library;
use super::names::fields;
use std::collections::BTreeSet;
use std::fmt;

/// Kind of a DMF, by the parts of a sample that it reads besides the density.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum DmfKind {
    /// Density only: f(k).
    PositionIndependent,
    /// Position: f(x).
    PositionDependent,
    /// Distance, gradient or closest point.
    GeometryDependent,
}

impl DmfKind {
    const ALL: [DmfKind; 3] = [DmfKind::PositionIndependent, DmfKind::PositionDependent, DmfKind::GeometryDependent];
}

impl fmt::Display for DmfKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            DmfKind::PositionIndependent => "position-independent",
            DmfKind::PositionDependent => "position-dependent",
            DmfKind::GeometryDependent => "geometry-dependent",
        })
    }
}

impl Library {
    /// A sentence about the kinds of the DMFs in stacks; empty without DMFs.
    ///
    /// # Errors
    /// See [`Library::kind`].
    pub fn kinds<'a>(&self, stacks: impl IntoIterator<Item = &'a Vec<String>>) -> Result<String, LibraryError> {
        let modules = stacks.into_iter().flatten().map(|name| name.split('@').next().unwrap_or(name));
        let modules: BTreeSet<&str> = modules.collect();
        let kinds = modules.into_iter().map(|name| Ok(format!("{name} is {}", self.kind(name)?)));
        let all: Vec<String> = kinds.collect::<Result<_, LibraryError>>()?;
        Ok(if all.is_empty() { String::new() } else { format!("DMFs: {}.", all.join(", ")) })
    }

    /// The kind of a DMF, from the fields of `Sample` read by it or its includes.
    ///
    /// # Errors
    /// The module does not exist, or its header claims another kind.
    pub fn kind(&self, dmf: &str) -> Result<DmfKind, LibraryError> {
        let path = self.path("dmf", dmf)?;
        let (mut queue, mut seen, mut found) = (vec![path.clone()], BTreeSet::new(), DmfKind::PositionIndependent);
        while let Some(file) = queue.pop() {
            let text = self.source(&file).unwrap_or_default();
            let read = fields(text, "Sample").into_iter().map(|field| match field {
                "density" => DmfKind::PositionIndependent,
                "x" => DmfKind::PositionDependent,
                _ => DmfKind::GeometryDependent,
            });
            found = read.fold(found, DmfKind::max);
            for line in text.lines() {
                match include(line) {
                    Some(Include::Slot("project")) => found = DmfKind::GeometryDependent,
                    Some(Include::File(file)) if seen.insert(file.to_string()) => queue.push(file.into()),
                    _ => {}
                }
            }
        }
        let header: String =
            self.source(&path).unwrap_or_default().lines().take_while(|line| line.starts_with("//")).collect();
        let header = header.to_lowercase();
        let claims: Vec<DmfKind> = DmfKind::ALL.into_iter().filter(|kind| header.contains(&kind.to_string())).collect();
        match claims.as_slice() {
            [claimed] if *claimed != found => {
                Err(LibraryError::Kind { path, claimed: claimed.to_string(), found: found.to_string() })
            }
            _ => Ok(found),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shipped;

    #[test]
    fn p04_the_kind_of_a_dmf_is_what_it_reads_of_a_sample() {
        let library = shipped();
        let of = |kind| {
            library.modules("dmf").into_iter().filter(|dmf| library.kind(dmf).unwrap() == kind).collect::<Vec<_>>()
        };
        assert_eq!(of(DmfKind::PositionIndependent), ["biased", "folded", "gained", "scaled", "waves"]);
        assert_eq!(of(DmfKind::PositionDependent), ["fractal", "noisy", "traded", "turbulent"]);
        assert_eq!(
            of(DmfKind::GeometryDependent),
            ["fire", "fur", "knurled", "pebbled", "rugged", "settled", "tribble", "woven"]
        );
    }

    #[test]
    fn p04_a_header_that_claims_another_kind_is_refused() {
        let with = |text: &str| shipped().with_module("dmf", "mine", text).kind("mine");
        let body = "float mine(float density, Sample point) { return density * point.x.y; }\n";
        assert_eq!(with(body), Ok(DmfKind::PositionDependent));
        assert_eq!(with(&format!("// Position-dependent.\n{body}")), Ok(DmfKind::PositionDependent));
        let error = with(&format!("// Mine: position-independent, f(k).\n{body}")).unwrap_err().to_string();
        assert_eq!(
            error,
            "dmf/mine.glsl claims to be position-independent, but reads fields that make it position-dependent"
        );
    }
}
