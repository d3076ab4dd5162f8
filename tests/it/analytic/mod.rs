//! What the renderer does, end to end, against closed forms.
//!
//! Every comparison with noise is a t-test over independent passes: points within a pass are a scrambled net and not
//! independent, passes are. The false-alarm rate is [`crate::support::ALPHA`] a comparison; with about 350 comparisons the suite fails
//! by chance less than once in 2000 seeds, and the seed is fixed. Each comparison also states how sharp it must be, so that it
//! cannot pass by being blind.

mod audit;
mod density;
mod dielectric;
mod dispersion;
mod edges;
mod focus;
mod furnace;
mod invariance;
mod irradiance;
mod lens;
mod media;
mod nephroid;
mod plates;
mod reference;
mod sphere;
mod water;
