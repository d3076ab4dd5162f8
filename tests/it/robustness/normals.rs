//! Shading normals that differ from geometric normals: no light leaks through surfaces, no weight
//! is unbounded, and no energy is gained.

mod furnace;
mod leaks;
mod weights;
