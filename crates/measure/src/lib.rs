//! Error against run time: references, metrics, comparisons, benches, the fastest settings within an error, checks,
//! stability, validity, predictions.

pub mod bench;
pub mod cases;
pub mod compare;
pub mod guard;
pub mod metric;
pub mod pick;
pub mod picture_check;
pub mod predict;
pub mod reference;
pub mod statistics;
pub mod sweep;
pub mod validity;
pub mod worker;
