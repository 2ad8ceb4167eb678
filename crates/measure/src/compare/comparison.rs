//! Result of a comparison: rows, failures, and groups of one truth.

use super::candidates::Candidate;
use super::front;
use super::ground_truths::GroundTruth;
use super::metrics::{Angles, Metrics};
use super::timing::{Run, Spread};
use hypertexture::render::{Frame, RenderError};
use hypertexture::scene::Scene;
use std::sync::Arc;

/// A candidate that was measured.
#[derive(Clone, Debug)]
pub struct Row {
    /// The candidate.
    pub candidate: Candidate,
    /// The truth of its scene.
    pub truth: Arc<GroundTruth>,
    /// Its errors against the truth.
    pub metrics: Metrics,
    /// Angles between its surface normals and those of many samples; `None` without a surface.
    pub normals: Option<Angles>,
    /// Every run, in the order in which they were made.
    pub runs: Vec<Run>,
    /// First frame, with the preparation time.
    pub first: Frame,
}

impl Row {
    /// Milliseconds on the device.
    pub fn gpu(&self) -> Spread {
        Spread::of(&self.runs.iter().map(|run| run.gpu_ms).collect::<Vec<_>>())
    }

    /// Milliseconds from scene to pixels.
    pub fn wall(&self) -> Spread {
        Spread::of(&self.runs.iter().map(|run| run.wall_ms).collect::<Vec<_>>())
    }

    /// Milliseconds of the processor if it is the device, which other processes hardly change; else on the device.
    pub fn time(&self) -> Spread {
        Spread::of(&self.runs.iter().map(|run| run.processor_ms.unwrap_or(run.gpu_ms)).collect::<Vec<_>>())
    }

    /// Time and linear error: the axes of the report.
    pub fn point(&self) -> (f64, f64) {
        (self.time().median, self.metrics.errors.rmse)
    }

    /// Time, error and settings in words.
    pub fn text(&self) -> String {
        let (time, error) = self.point();
        format!("{time:9.3} ms  error {error:.2e}  {}", self.candidate.label())
    }

    /// Efficiency: 1 / (mean square error x seconds).
    pub fn efficiency(&self) -> f64 {
        1.0 / (self.metrics.errors.rmse.powi(2) * self.time().median * 1e-3)
    }
}

/// A candidate that has no row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure {
    /// The candidate in words.
    pub label: String,
    /// Error message.
    pub message: String,
}

impl Failure {
    /// The failure of a candidate.
    pub fn of((candidate, error): &(Candidate, RenderError)) -> Failure {
        Failure { label: candidate.label(), message: error.to_string() }
    }
}

/// Result of a comparison.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// The scene, with the size that was compared.
    pub scene: Scene,
    /// The candidates, curve by curve.
    pub rows: Vec<Row>,
    /// Failed candidates.
    pub failures: Vec<Failure>,
    /// Candidates that were planned.
    pub planned: usize,
    /// Whether it was stopped before its end.
    pub partial: bool,
}

/// The rows of one truth, by their indices.
#[derive(Clone, Debug)]
pub struct Group {
    /// The truth.
    pub truth: Arc<GroundTruth>,
    /// Its rows.
    pub rows: Vec<usize>,
    /// Those of the Pareto front, by rising time.
    pub front: Vec<usize>,
}

impl Comparison {
    /// The rows by their truths, the scene's own first: pictures of different noises have no common front.
    pub fn groups(&self) -> Vec<Group> {
        let mut groups: Vec<Group> = Vec::new();
        for (index, row) in self.rows.iter().enumerate() {
            match groups.iter_mut().find(|group| Arc::ptr_eq(&group.truth, &row.truth)) {
                Some(group) => group.rows.push(index),
                None => groups.push(Group { truth: row.truth.clone(), rows: vec![index], front: Vec::new() }),
            }
        }
        for group in &mut groups {
            let points: Vec<(f64, f64)> = group.rows.iter().map(|&index| self.rows[index].point()).collect();
            group.front = front::front(&points).into_iter().map(|place| group.rows[place]).collect();
        }
        groups.sort_by_key(|group| !group.truth.is_own);
        groups
    }

    /// Number of rows with unsteady times.
    pub fn unsteady(&self) -> usize {
        self.rows.iter().filter(|row| row.time().is_unsteady()).count()
    }

    /// The clock of the report's times, in words.
    pub fn clock(&self) -> &'static str {
        let of_processor = self.rows.iter().flat_map(|row| &row.runs).all(|run| run.processor_ms.is_some());
        if of_processor { "of the processor" } else { "on the device" }
    }
}
