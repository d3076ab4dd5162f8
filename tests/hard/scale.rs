//! Scale and place: scenes that are huge, tiny, far away or turned show the same picture.
