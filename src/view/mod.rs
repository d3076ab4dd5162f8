//! Views of a running render: the live page, which is a web page, and the image viewer tev.
//!
//! A render publishes its newest state to a [`LivePage`], and never waits for a reader. A
//! [`PageServer`] serves the page and the newest state to any number of browsers.

mod address;
mod frame;
mod guard;
mod live_page;
mod publication_throttle;
mod render_publisher;
mod request;
mod responses;
mod server;
mod status;
mod tev;

pub use address::{ListenAddress, ListenError};
pub use frame::{Layer, LayerKind, LiveFrame};
pub use live_page::{LivePage, LiveState};
pub use render_publisher::RenderPublisher;
pub use request::{Orbit, Request};
pub use server::{PageServer, RequestHandler};
pub use status::{LiveStatus, PlanReport, RenderStage, SceneProblem, SceneSource};
pub use tev::{TevAddress, TevAddressError, TevClient};

#[cfg(test)]
mod tests;
