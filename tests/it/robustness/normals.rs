//! Shading normals that differ from geometric normals: no light leaks through surfaces, large
//! photon weights are rare, and no energy is gained.

mod furnace;
mod leaks;
mod weights;
