//! Stratified Metropolis sampling over an arbitrary state space.
