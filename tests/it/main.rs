//! Integration tests, in one binary so that the renderer's generic loops compile once.
//!
//! `cargo test --test it NAME` runs the tests whose path contains NAME, such as `analytic` or
//! `cli::diff`.

mod agreement;
mod analytic;
mod aovs;
mod cli;
mod course;
mod gltf;
mod golden;
#[cfg(feature = "view")]
mod live_page;
mod mitsuba;
mod pbrt;
mod plan;
mod report;
mod robustness;
mod support;
mod textures;
mod threads;
mod tungsten;
mod windows;
