//! The photon store: emission, tracing, the kd-tree, and density estimates.

mod audit;
mod beam;
mod coverage;
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
pub use beam::{Beam, BeamMap, Crossing};
pub use coverage::{coverage, nested_coverage};
pub use emit::PhotonSource;
pub use estimate::{Bandwidth, Estimate, LEVELS, NestedEstimate, Scratch};
pub use guiding::{GuidingPilot, GuidingReport};
pub use kernel::{Kernel, UnknownKernel};
pub use map::PhotonMap;
pub use points::{PointMap, VolumePhoton};
pub use record::{Photon, PhotonData};
pub use store_mask::{PhotonKind, StoreMask, THINNING};
pub use trace::{PhotonPass, Traced, Volume};
pub use visible::{VisiblePoint, VisiblePointMap};
