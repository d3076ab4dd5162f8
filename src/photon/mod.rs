//! Photon mapping: emission, tracing, photon maps, and density estimates.

mod audit;
mod beam;
mod coverage;
mod deposits;
mod emit;
mod estimate;
mod guiding;
mod kernel;
mod map;
mod packet;
mod points;
mod record;
mod store_mask;
mod trace;
mod visible;

pub use audit::Audit;
pub use beam::{Beam, BeamIntersection, BeamMap};
pub use coverage::{coverage, nested_coverage};
pub use deposits::{Deposits, VolumePhotons};
pub use emit::PhotonSource;
pub use estimate::{Bandwidth, Estimate, LEVELS, NestedEstimate, Scratch};
pub use guiding::{GuidingPilot, GuidingReport};
pub use kernel::{Kernel, UnknownKernel};
pub use map::PhotonMap;
pub use points::{PointMap, VolumePhoton};
pub use record::{Photon, PhotonData};
pub use store_mask::{PhotonKind, StoreMask, THINNING};
pub use trace::{PhotonPass, Traced};
pub use visible::{VisiblePoint, VisiblePointMap};
