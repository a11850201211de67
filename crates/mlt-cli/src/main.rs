//! `mlt`: stratified Metropolis light transport on the command line.
fn main() {}
