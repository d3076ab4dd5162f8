//! Sums of very many samples, the order of passes, and what a file format cannot hold.
