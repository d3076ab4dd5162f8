//! Tests of plans: a render with only the needed effects equals one with all effects, bit for bit.
//!
//! `CAUSTICA_PLAN_SEEDS=N cargo test --test it plan::` checks N random scenes instead of the usual
//! number.

mod compare;
mod generate;
mod judge;
mod overrides;
mod random;
mod scenes;
mod sketch;
