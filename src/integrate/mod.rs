//! Rendering algorithms: path tracing, photon mapping, ray tracing and ray casting.
//!
//! All implement [`Integrator`]. `PathIntegrator` implements it for every algorithm that a
//! `PathPolicy` describes: `hybrid.rs` makes such a policy, and `camera_path.rs` holds the loop
//! that follows it. Ray casting implements [`Integrator`] directly, in `raycast.rs`.
//!
//! Terms of this folder:
//!
//! - *Receiver*, *caster*, *caustic*: see [`PhotonKind`](crate::photon::PhotonKind).
//! - *Caustic map*, *indirect map*, *interreflection map*; *aimed* and *unaimed* photon paths: see
//!   `photon_maps.rs`.
//! - *Prefix*: the part of a camera path up to its first receiver. *Prefix ray*: an extra camera
//!   path that ends at its first receiver.
//! - *Image of a lamp*: the part of the film at which camera rays meet the lamp, directly or over
//!   specular surfaces.
//! - *Pilot*: a small simulation before the first pass, whose rays and photons no pass uses.
//! - *Slice*: a part of the shutter interval with its own copy of the scene, photons and camera
//!   rays.

mod adaptive_pilot;
mod algorithm;
mod balance;
mod camera_path;
mod distributed;
mod environment_guide;
mod environment_pilot;
mod film_points;
mod gather_guide;
mod hybrid;
mod indirect_division;
mod indirect_pilot;
mod integrator;
mod lamp_image_pilot;
mod lamp_images;
mod light_group;
mod map_builder;
mod nee;
mod nested_estimates;
mod pass;
mod pass_renderer;
mod path;
mod path_integrator;
mod path_task;
mod photon_maps;
mod pilot_statistics;
mod pm;
mod policy;
mod ppm;
mod prefix_pilot;
mod prefix_rays;
mod radius_law;
mod radius_pilot;
mod raycast;
mod scatter;
mod scatter_point_guide;
mod scatter_point_pilot;
mod settings;
mod shutter;
mod specular_chain;
mod sppm;
mod surface_aovs;
mod tiles;
mod vertex;
mod visible_pilot;
mod volume_estimate;
mod whitted;
mod work_pilot;

pub use algorithm::Algorithm;
pub use balance::RayPhotonBalance;
pub use environment_pilot::EnvironmentGuidingReport;
pub use integrator::Integrator;
pub use light_group::LightGroup;
pub use map_builder::CAUSTIC_K;
pub use nested_estimates::{MeanGatherDisc, NestedEstimates};
pub use pass::{ExpectedPhotons, Pass, PassStage, PhotonReport, ProgressMonitor, SilentMonitor, StageTimes};
pub use radius_law::{ALPHA, RadiusLaw, squared_radius_ratio};
pub use radius_pilot::{EmissionGuidingReports, GatherRadii};
pub use scatter_point_pilot::ScatterPointGuidingReport;
pub use settings::{CameraPathSettings, FinalGathering, IndirectPhotons, LightTracing, Settings};
pub use surface_aovs::{AovSurface, SURFACE_AOV_RAYS, SurfaceAovs, render_surface_aovs};
pub use volume_estimate::VolumeEstimator;
