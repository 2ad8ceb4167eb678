//! A report of made-up measurements, for tests.

use super::{Environment, Report};
use crate::compare::candidates::{Sweep, candidates};
use crate::compare::metrics::Metrics;
use crate::compare::timing::Run;
use crate::compare::{Comparison, GroundTruth, Row};
use crate::metric::Errors;
use crate::reference::Reference;
use hypertexture::render::Frame;
use hypertexture::scene::preset;
use hypertexture::shader;
use std::sync::Arc;

/// Fire by several strategies: the error is 1 / samples by points and 1 / samples^2 by segments, the time grows with
/// samples. Those that read a block have the scene's own truth, the others one of their own.
pub fn report() -> Report {
    let mut scene = preset("fire").unwrap();
    scene.image.size = [8, 8];
    let sweep = Sweep { samples: Some(vec![16, 32, 64]), quick: true, ..Sweep::default() };
    let truth = |is_own: bool| {
        let estimate = vec![1e-7; 64];
        let reference = Reference { size: [8, 8], pixels: vec![[0.0; 4]; 64], estimate, open: vec![1e-3; 64] };
        let pattern = if is_own { "own" } else { "other" }.to_string();
        Arc::new(GroundTruth { pattern, is_own, reference: reference.into() })
    };
    let truths = [truth(false), truth(true)];
    let row = |candidate: crate::compare::candidates::Candidate| {
        let samples = f64::from(candidate.samples());
        let second = candidate.curve().label().contains("segment");
        let rmse = samples.powf(if second { -2.0 } else { -1.0 });
        let metrics = Metrics {
            errors: Errors {
                rmse,
                covered_rmse: 2.0 * rmse,
                rgb_rmse: rmse,
                opacity_rmse: rmse,
                max: 4.0 * rmse,
                p999: 3.0 * rmse,
            },
            own_rmse: Some(0.5 * rmse),
            relative_mse: rmse,
            psnr: -20.0 * rmse.log10(),
            ssim: 1.0 - rmse,
            flip: rmse,
            flip_p99: 2.0 * rmse,
            not_finite: 0,
        };
        let run =
            |index: u32| Run { gpu_ms: samples + 0.01 * f64::from(index), processor_ms: None, wall_ms: samples + 2.0 };
        let first = Frame { size: [8, 8], pixels: Vec::new(), measurements: Default::default() };
        Row {
            truth: truths[usize::from(candidate.reads_block)].clone(),
            candidate,
            metrics,
            normals: None,
            runs: (0..7).map(run).collect(),
            first,
        }
    };
    let rows: Vec<Row> = candidates(&scene, &shader::shipped(), &sweep).unwrap().into_iter().map(row).collect();
    let comparison =
        Comparison { scene: scene.clone(), planned: rows.len(), rows, failures: Vec::new(), partial: false };
    let environment = Environment {
        device: "a device".into(),
        command: "hypertexture compare fire".into(),
        ..Environment::default()
    };
    let hash = super::hash(&scene);
    let (pictures, live, crops) = Default::default();
    let title = "fire".into();
    Report { title, hash, tolerance: 1e-4, environment, comparison, pictures, live, table: None, crops }
}
