//! Shading normals against geometric ones: no light through the back, no exploding weights, no energy gained.

mod furnace;
mod leaks;
mod weights;
