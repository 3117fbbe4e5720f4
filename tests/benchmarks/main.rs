//! Published benchmarks, closed forms, and CalculiX: its test decks and its element matrices.
//!
//! CalculiX and its test decks are Debian's packages calculix-ccx and calculix-ccx-test, which `tests/run.sh`
//! installs. Without them these tests say that they are skipped; `STIFFMAP_CCX=require` makes that a failure.

#[path = "../support/mod.rs"]
mod support;

mod bench;
mod decks;
mod element_matrices;
mod free_bodies;
mod incompatible_bricks;
mod nafems;
mod thin_cantilever;
