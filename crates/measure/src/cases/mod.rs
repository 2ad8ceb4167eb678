//! Test cases of the method: scenes whose pictures are known, and the errors on the device at hand.
//!
//! Role: [`CASES`] lists each case with its scenes, its closed form or relation and its bounds; [`run`] renders them and
//! reports a [`Row`] per measurement. Invariant: expected values share nothing with the GLSL, and every row can fail.

mod analytic;
mod analytic_scenes;
mod camera;
mod closed_forms;
mod data;
mod drivers;
mod fields;
mod function;
mod invariances;
mod lab;
mod lenses;
mod list;
mod matter;
mod noise;
mod opacity;
mod optimizer;
mod rays;
mod relations;
mod report;
mod run;
mod scenes;
mod shaping;
mod volumes;

pub use analytic::{AnalyticCase, Level, levels, order};
pub use analytic_scenes::{
    COLOR_BY_DEPTH, HOMOGENEOUS, PERLIN_BALLS, SLANTED, SOFT_BALLS, TWO_TONE, TWO_TONES, library, two_tone,
};
pub use closed_forms::luneburg_miss;
pub use lab::{CaseError, Lab, PASSES, Report, Row, Rows, same};
pub use lenses::{clear, exit_rays};
pub use list::{CASES, suite};
pub use rays::{Ray, rays};
pub use report::{chart_page, table};
pub use run::{Case, Measure, Suite, devices, run};
pub use scenes::{box_subject, homogeneous};
pub use shaping::{bias, gain};
