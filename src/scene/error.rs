//! Reasons why a scene cannot be built.

/// Reason why a scene cannot be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BuildError {
    /// An unbounded plane emits: its power would be infinite.
    #[error("an infinite plane cannot emit light: use a rectangle or a disc")]
    EmissivePlane,
    /// A coordinate relative to the scene's origin is so large that products overflow in single
    /// precision. Holds the greatest absolute coordinate.
    #[error("the scene spans more than single precision can hold: the farthest coordinate is {0:e} from its middle")]
    ExtentTooLarge(f64),
    /// The scene is so small that squared lengths underflow in single precision. Holds the greatest
    /// absolute coordinate relative to the scene's origin.
    #[error(
        "the scene is smaller than single precision can hold: the farthest coordinate is {0:e} from its middle; choose a larger unit of length"
    )]
    ExtentTooSmall(f64),
    /// The power of the light with this index does not fit single precision.
    #[error("light {0} (counted from 0) is stronger than single precision can hold")]
    TooBright(usize),
    /// The transform of a motion is singular: it flattens an object, light, camera or texture
    /// mapping.
    #[error("a motion flattens what it moves: choose scales that are not so small")]
    SingularMotion,
    /// The material with this index is a mix that contains itself or a missing material.
    #[error("material {0} (counted from 0) is a mix that contains itself or a material that does not exist")]
    InvalidMix(usize),
    /// The scene has this number of triangles, which does not fit 31 bits.
    #[error("{0} triangles are more than the 2³¹ that can be indexed")]
    TooManyTriangles(usize),
}
