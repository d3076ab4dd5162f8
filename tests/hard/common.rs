//! Scenes, renders and statistics that the groups share.
