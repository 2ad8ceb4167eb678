//! The machine: runs lowered code for blocks of lanes.

mod basic_block;
pub(crate) mod control_flow;
mod instr;
pub(crate) mod lanes;
pub(crate) mod single;
mod snapshot;
