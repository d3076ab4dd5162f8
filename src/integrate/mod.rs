//! Rendering algorithms: path tracing, photon mapping, ray tracing and ray casting.
//!
//! All implement [`Integrator`]. `PathIntegrator` implements it for every algorithm that a
//! `PathPolicy` describes. Each algorithm's file, such as `hybrid.rs`, makes its policy, and
//! `camera_path.rs` holds the loop that follows it. Ray casting implements [`Integrator`] directly,
//! in `raycast.rs`.
//!
//! # Terms
//!
//! - *Receiver*: a surface or medium that stores photons, such as a diffuse wall or fog. *Caster*:
//!   a surface that passes photons on, such as a mirror or glass. *Caustic*: light that reaches a
//!   receiver via one or more casters. [`PhotonKind`](crate::photon::PhotonKind) has the exact
//!   definitions.
//! - *Prefix*: the part of a camera path up to its first receiver. *Prefix ray*: an extra camera
//!   path that ends at its first receiver.
//! - *Lamp image*: the part of the film at which camera rays meet a small lamp, directly or via
//!   specular surfaces.
//! - *Scattering point*: a point in a medium from which a shadow ray starts.
//! - *Pilot*: a small simulation before the first pass, whose rays and photons no pass uses.
//! - *Slice*: a part of the shutter interval with its own copy of the scene, photons and camera
//!   rays.
//!
//! # Photon paths and photon maps
//!
//! A pass traces two sets of photon paths. Flags and JSON reports call them by other names:
//!
//! | photon paths | start | flag | name in JSON |
//! | --- | --- | --- | --- |
//! | aimed | towards casters | `--caustic-photons` | `caustic` |
//! | unaimed | in all directions | `--photons` | `global` |
//!
//! Each photon map holds some [kinds of photons](crate::photon::PhotonKind) of one set:
//!
//! | map | algorithm | kinds of photons | paths | finds |
//! | --- | --- | --- | --- | --- |
//! | caustic | all with photons | `Caustic` | aimed | caustics |
//! | indirect | `pm`, `ppm`, `sppm` | `AfterCaustic`, `AfterDirect` | unaimed | indirect light |
//! | indirect | `hybrid` | `AfterCaustic` | aimed | indirect light of caustics |
//! | interreflection | `hybrid` | `AfterDirect` | unaimed | all other indirect light |
//!
//! If final-gathering rays read the indirect map of `pm`, it holds `Direct` photons too. Jensen
//! 2001 calls the indirect map the global map. In JSON reports, `radii.global` is the gather radius
//! of the indirect map. In EXR files, the layers `radius.global` and `photons.global` describe
//! density estimates from the indirect and the interreflection map.
//!
//! Three functions decide which photons a pass stores. `PathPolicy::photon_map_request` names the
//! kinds of photons for the maps that a policy reads. In `hybrid`, `PhotonMapBuilder::new` drops
//! unaimed paths if media emit light. `PhotonMapBuilder::mask_for_volume_estimator` chooses between
//! photon beams and photon points.
//!
//! # State of a camera path
//!
//! | struct | content | lifetime |
//! | --- | --- | --- |
//! | `PathContext` | scene, policy, photon maps, limits | pass |
//! | `CameraRay` | ray, sampler, film position, shutter slice, weights | camera ray |
//! | `PathTask` | the three structs below, and counts of rays | tile, or chunk of a pilot |
//! | `PixelLight` | light kept apart from the radiance, such as light groups | pixel |
//! | `PilotRecords` | records that pilots take from the task | task |
//! | `ScratchBuffers` | reused memory | vertex or medium segment |
//! | `PathState` | ray, throughput and history of one branch | until the branch ends |
//!
//! `indirect_division.rs` lists the fields that divide indirect light between camera paths and
//! photons, in the order in which they are used.

mod adaptive_pilot;
mod algorithm;
mod balance;
mod camera_path;
mod camera_ray;
mod distributed;
mod environment_guide;
mod environment_pilot;
mod film_points;
mod film_sampling;
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
mod nested_differences;
mod pass;
mod pass_renderer;
mod path;
mod path_integrator;
mod path_task;
mod photon_maps;
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
#[cfg(test)]
mod test_scenes;
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
pub use map_builder::DEFAULT_CAUSTIC_K;
pub use nested_differences::{MeanGatherDisc, NestedDifferences};
pub use pass::{ExpectedPhotons, PassResult, PassStage, PhotonReport, ProgressMonitor, SilentMonitor, StageTimes};
pub use radius_law::{DEFAULT_ALPHA, RadiusLaw, squared_radius_ratio};
pub use radius_pilot::{EmissionGuidingReports, GatherRadii};
pub use scatter_point_pilot::ScatterPointGuidingReport;
pub use settings::{CameraPathSettings, FinalGathering, IndirectPhotons, LightTracing, Settings};
pub use surface_aovs::{AovSurface, SURFACE_AOV_RAYS, SurfaceAovs, render_surface_aovs};
pub use volume_estimate::VolumeEstimator;
