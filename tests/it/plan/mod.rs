//! The promise of the plan: a picture with the effects that the scene calls for is the same, bit for bit, as one with all of them.
//!
//! `CAUSTICA_PLAN_SEEDS=N cargo test --test it plan::` looks at N random scenes in place of the usual number.

mod compare;
mod generate;
mod judge;
mod random;
mod scenes;
mod sketch;
mod wishes;
