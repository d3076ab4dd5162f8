//! End-to-end renders against closed forms.
//!
//! Every comparison with noise is a t-test over independent passes. Points within a pass are a
//! scrambled low-discrepancy set, so they are not independent. The false-alarm rate of a comparison
//! is [`crate::support::FALSE_ALARM_RATE`]. With about 350 comparisons, less than one seed in 2000
//! makes the suite fail by chance, and the seed is fixed. Each comparison also limits its standard
//! error, so that it cannot pass only because of noise.

mod audit;
mod density;
mod dielectric;
mod dispersion;
mod edges;
mod environment_guiding;
mod focus;
mod furnace;
mod indirect_photons;
mod invariance;
mod irradiance;
mod lens;
mod light_tracing;
mod media;
mod motion;
mod nephroid;
mod panes;
mod plates;
mod prefix_rays;
mod reference;
mod scatter_point_guiding;
mod sphere;
mod water;
