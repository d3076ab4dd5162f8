//! Pictures of one pixel and of one row, angles near zero and a half turn, cameras that cannot be.
