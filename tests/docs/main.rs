//! What pages say of the code is true.

mod layers;
mod papers;
mod readme;
