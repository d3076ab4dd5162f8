//! Ends of the unit interval through every warp, densities near zero, roulette at its ends, lobes at theirs.
