//! Rays, boxes, frames, transforms, sampling warps, sums, means, medians and error bounds.

mod binned_sums;
mod bounds;
mod compensated_sum;
mod double_double;
mod float;
mod frame;
mod gcd;
mod median;
mod morton;
mod motion;
mod pixel_square;
mod ray;
mod transform;
pub mod warp;

pub use binned_sums::BinnedSums;
pub use bounds::{BoundingSphere, Bounds};
pub use compensated_sum::CompensatedSum;
pub use double_double::{exact_cross, exact_dot};
pub use float::{distance2_direction_distance, quadratic_roots_half_b, rounding_error_bound, sin_cos_turns};
pub use frame::Frame;
pub use gcd::gcd;
pub use median::positive_median;
pub use morton::morton_order;
pub use motion::{Motion, MotionFactor, rotation_matrix, rotation_matrix_degrees};
pub use pixel_square::{SummedAreaTable, square_mean, square_sum};
pub use ray::{Ray, offset_ray_origin};
pub use transform::{SingularTransformError, Transform};
