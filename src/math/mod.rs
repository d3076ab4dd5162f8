//! Arithmetic of geometry: rays, boxes, frames, transforms, warps, and bounds on rounding errors.

mod bounds;
mod double;
mod float;
mod frame;
mod morton;
mod motion;
mod ray;
mod sum;
mod transform;
pub mod warp;

pub use bounds::{Bounds, Sphere};
pub use double::{exact_cross, exact_dot};
pub use float::{direction, gamma, quadratic, sin_cos_turns};
pub use frame::Frame;
pub use morton::morton_order;
pub use motion::{Motion, Step, turn, turn_degrees};
pub use ray::{Ray, offset_origin};
pub use sum::Sum;
pub use transform::{Singular, Transform};
