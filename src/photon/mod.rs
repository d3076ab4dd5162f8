//! Photon mapping: photon emission, photon tracing, photon maps and density estimation.

mod audit;
mod beam;
mod beam_thinning;
mod concatenation;
mod coverage;
mod deposits;
mod emit;
mod estimate;
mod guiding;
mod kernel;
mod light_tracing;
mod map;
mod packet;
mod store_mask;
mod surface_photon;
mod trace;
mod visible;
mod volume_coverage;
mod volume_photon;

pub use audit::EnergyAudit;
pub use beam::{BeamIntersection, PhotonBeam, PhotonBeamMap};
pub use beam_thinning::thin_beams;
pub use coverage::{disc_coverage, nested_disc_coverage};
pub use deposits::{Deposits, Splat, VolumePhotons};
pub use emit::PhotonSource;
pub use estimate::{Bandwidth, NESTED_DISC_COUNT, NestedRadianceEstimate, PhotonSearchBuffers, RadianceEstimate};
pub use guiding::{EmissionGuidingPilotSettings, EmissionGuidingReport};
pub use kernel::{Kernel, UnknownKernel};
pub use light_tracing::{
    DensityEstimateShares, LightTracer, PassDensityEstimateShares, add_splats, add_splats_across_seams,
};
pub use map::PhotonMap;
pub use store_mask::{AFTER_CAUSTIC_THINNING, PhotonKind, StoreMask};
pub use surface_photon::{Photon, PhotonAttributes};
pub use trace::{PhotonTracer, TracedPhotons};
pub use visible::{VisiblePoint, VisiblePointMap};
pub use volume_coverage::KernelProbes;
pub use volume_photon::{VolumePhoton, VolumePhotonMap};
