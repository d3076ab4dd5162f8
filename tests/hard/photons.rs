//! Photon maps that hold nothing, one photon or ten million, at a point, in a plane, or nine orders of density.
