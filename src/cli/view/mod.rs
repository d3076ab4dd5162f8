//! `caustica view`: renders a scene, shows it on a live page, and follows changes of its files.

mod event;
mod job;
mod orbit;
mod preview;
mod scene;
mod session;
mod watch;

use super::args::{EffectsArguments, MethodArguments};
use super::interrupt::listen_for_signals;
use super::live::{print_page_address, read_reference};
use super::scene_args::SceneArguments;
use super::value_parsers::{parse_confidence, parse_duration, parse_positive_count, parse_relative_error};
use super::{CommandFailure, Exit};
use crate::render::RenderLimits;
use crate::render::error_estimate::Confidence;
use crate::view::{ListenAddress, LivePage, PageServer};
use clap::Args;
use event::{Event, EventQueue};
use miette::Report;
use session::Session;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

/// Arguments of `view`.
#[derive(Debug, Args)]
pub struct ViewArguments {
    #[command(flatten)]
    pub scene: SceneArguments,

    /// Address and port of the live page. The default is a free port that only this machine can
    /// open
    #[arg(long, value_name = "ADDR:PORT", default_value = "127.0.0.1:0")]
    pub listen: ListenAddress,

    /// Picture to compare with: .exr, .png or .hdr
    #[arg(long, value_name = "FILE")]
    pub reference: Option<PathBuf>,

    #[command(flatten)]
    pub method: MethodArguments,

    #[command(flatten)]
    pub effects: EffectsArguments,

    /// Also show direct, indirect and caustic light, as layers that add up to the picture
    #[arg(long)]
    pub light_groups: bool,

    /// Number of passes after which the render pauses  [default: no limit; 1 for raycast]
    #[arg(long, value_parser = parse_positive_count, value_name = "N")]
    pub passes: Option<u32>,

    /// Pause after the pass whose end is nearest to this time, such as 60s or 5m. Pilots are part
    /// of the time  [default: 5m; no limit with --passes or --target-error]
    #[arg(long, value_parser = parse_duration, value_name = "TIME")]
    pub time: Option<Duration>,

    /// Pause after the pass in which the estimated relative error is at most this, such as 2%
    /// [default: 3%; none with --passes or --time]
    #[arg(long, value_parser = parse_relative_error, value_name = "ERROR")]
    pub target_error: Option<f64>,

    /// Confidence that the error is at most --target-error when the render pauses
    #[arg(long, value_parser = parse_confidence, default_value = "90%", value_name = "PART")]
    pub confidence: Confidence,
}

impl ViewArguments {
    /// Returns the limits of passes, time and error at which a render pauses, from the command
    /// line.
    fn limits(&self) -> RenderLimits {
        let Self { passes, time, target_error, confidence, .. } = *self;
        RenderLimits { max_passes: passes, time_limit: time, target_error, confidence, preview: false }
    }
}

/// Runs `caustica view` until the first interrupting signal.
pub(super) fn run(arguments: &ViewArguments) -> Result<Exit, CommandFailure> {
    let reference = read_reference(arguments.reference.as_deref())?;
    let scene = arguments.scene.scene.display().to_string();
    let page = Arc::new(LivePage::new(scene, arguments.method.integrator.name(), true, reference));
    let threads = arguments.scene.threads.map_or(0, |n| n as usize);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|error| CommandFailure::usage_error(Report::from_err(error)))?;
    let (queue, events) = EventQueue::new();
    let requests = queue.clone();
    let server = PageServer::start(
        arguments.listen,
        page.clone(),
        Box::new(move |request| requests.try_send(Event::Request(request))),
    );
    let server = server.map_err(|error| CommandFailure::usage_error(Report::new(error)))?;
    listen_for_signals("the view ends");
    print_page_address(&server);
    Session::new(arguments, &page, &pool, queue).run(&events);
    server.finish();
    Ok(Exit::Success)
}
