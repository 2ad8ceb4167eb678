//! The machine: runs lowered code for blocks of lanes.

mod basic_block;
pub mod control_flow;
mod instr;
pub mod lanes;
pub mod single;
mod snapshot;
