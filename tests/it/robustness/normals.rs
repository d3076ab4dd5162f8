//! Shading normals against geometric normals: no light through the back, no exploding weights, no
//! energy gain.

mod furnace;
mod leaks;
mod weights;
