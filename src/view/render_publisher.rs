//! Publishing of a render's state to the live page.

use super::frame::LiveFrame;
use super::live_page::{LivePage, LiveState};
use super::publication_throttle::PublicationThrottle;
use super::status::{ErrorCurvePoint, ForecastReport, PlanReport, RenderStage};
use crate::integrate::SurfaceAovs;
use crate::render::{ErrorTarget, PassProgress, RenderResult, StopCriteria};
use glam::Vec3;
use std::sync::Arc;
use std::time::Instant;

/// Largest number of points in the error curve of a render. Few curves get so long, because error
/// estimates become rarer as passes go on.
const MAX_CURVE_POINTS: usize = 400;

/// Publisher of one render on a live page. The render's thread calls it when the render begins,
/// after each pass, and at the end.
#[derive(Debug)]
pub struct RenderPublisher<'a> {
    page: &'a LivePage,
    /// Number of the render on its page, from [`LivePage::begin_render`].
    number: u32,
    /// Time at which loading of the scene began.
    load_start: Instant,
    picture_throttle: PublicationThrottle,
    error_map_throttle: PublicationThrottle,
    error_curve: Arc<Vec<ErrorCurvePoint>>,
    forecast: Option<Arc<ForecastReport>>,
}

impl<'a> RenderPublisher<'a> {
    /// Begins a new render on `page`. `load_start` is the time at which loading of its scene began.
    #[must_use]
    pub fn begin(page: &'a LivePage, load_start: Instant) -> Self {
        Self {
            page,
            number: page.begin_render(),
            load_start,
            picture_throttle: PublicationThrottle::default(),
            error_map_throttle: PublicationThrottle::default(),
            error_curve: Arc::default(),
            forecast: None,
        }
    }

    /// Returns the number that the page gave to this render, counted from 1.
    #[must_use]
    pub fn render_number(&self) -> u32 {
        self.number
    }

    /// Applies `change` to the state on the page and publishes the state, unless a newer render has
    /// begun. The second argument of `change` is the sequence number of this update.
    pub fn publish(&self, change: impl FnOnce(&mut LiveState, u32)) {
        self.page.publish(self.number, change);
    }

    /// Publishes the stage that the render has entered.
    pub fn publish_stage(&self, stage: RenderStage) {
        self.publish(|state, _| state.status.stage = stage);
    }

    /// Publishes a preview of `size` (width, height) pixels as the newest picture.
    pub fn show_preview(&self, size: (u32, u32), pixels: &[Vec3]) {
        let seconds = self.load_start.elapsed().as_secs_f64();
        self.publish(|state, sequence| {
            let frame = LiveFrame { is_preview: true, ..LiveFrame::from_picture(sequence, size, 0, pixels) };
            state.picture = Some(Arc::new(frame));
            state.status.first_pixels_seconds.get_or_insert(seconds);
        });
    }

    /// Publishes the plan and the limits of the render, its picture size (width, height) \[pixels],
    /// and the stage [`RenderStage::Passes`]. Called before the first pass, and when a render is
    /// resumed.
    pub fn publish_plan_and_limits(&self, plan: PlanReport, stop: &StopCriteria<'_>, size: (u32, u32)) {
        self.publish(|state, _| {
            let status = &mut state.status;
            status.stage = RenderStage::Passes;
            status.end_reason = None;
            status.size = size;
            status.plan = Some(Arc::new(plan));
            status.pass_limit = stop.max_passes;
            status.time_limit_seconds = stop.time_limit.map(|time| time.as_secs_f64());
            status.error_limit = stop.target.map(|target| target.error);
            status.interval_confidence = stop.target.map(ErrorTarget::interval_confidence);
        });
    }

    /// Adds the error estimate of a pass, if there is one, to the error curve. Publishes the
    /// picture, unless the last publication was too recent. Also publishes error maps if a browser
    /// has asked for them.
    ///
    /// After the last pass, only [`RenderPublisher::publish_end`] publishes the picture.
    pub fn publish_pass_if_due(&mut self, progress: &PassProgress<'_>, stop: &StopCriteria<'_>) {
        if let Some((estimate, forecast)) = &progress.error
            && estimate.error.is_finite()
        {
            let point = ErrorCurvePoint::new(estimate, progress.rendered.wall_time.as_secs_f64());
            push_curve_point(Arc::make_mut(&mut self.error_curve), point);
            self.forecast = Some(Arc::new(ForecastReport::new(estimate, forecast, stop)));
        }
        let start = Instant::now();
        if progress.end_reason.is_some() || !self.picture_throttle.is_due(start) {
            return;
        }
        self.publish_result(progress.rendered);
        self.picture_throttle.record(start, Instant::now());
        let start = Instant::now();
        if self.error_map_throttle.is_due(start) && self.page.take_error_map_request() {
            self.publish_error_maps(progress.rendered);
            self.error_map_throttle.record(start, Instant::now());
        }
    }

    /// Publishes surface AOVs if a browser has asked for them. Only then is `find` called, which
    /// computes the AOVs; nothing is published if it returns `None`. `size` is the width and height
    /// of the picture \[pixels].
    pub fn publish_wanted_surface_aovs(&self, size: (u32, u32), find: impl FnOnce() -> Option<SurfaceAovs>) {
        if self.page.take_surface_aov_request()
            && let Some(aovs) = find()
        {
            self.publish(|state, sequence| {
                state.surface_aovs = Some(Arc::new(LiveFrame::from_surface_aovs(sequence, size, &aovs)));
            });
            // This publication also serves requests that came while `find` ran: forget them.
            self.page.take_surface_aov_request();
        }
    }

    /// Publishes the final result of a render. `stage` is [`RenderStage::Stopped`] or
    /// [`RenderStage::Ended`].
    pub fn publish_end(&mut self, rendered: &RenderResult, stage: RenderStage) {
        self.publish_result(rendered);
        self.publish_error_maps(rendered);
        self.publish(|state, _| {
            state.status.stage = stage;
            state.status.end_reason = Some(rendered.end_reason);
        });
    }

    /// Publishes the picture, times and counts of `rendered`, with the present error curve and
    /// forecast.
    fn publish_result(&self, rendered: &RenderResult) {
        let seconds = self.load_start.elapsed().as_secs_f64();
        let frame = LiveFrame::from_render(0, rendered);
        self.publish(|state, sequence| {
            state.picture = Some(Arc::new(LiveFrame { sequence, ..frame }));
            let status = &mut state.status;
            status.passes = rendered.film.passes();
            status.seconds = rendered.wall_time.as_secs_f64();
            status.first_pixels_seconds.get_or_insert(seconds);
            status.error_curve = self.error_curve.clone();
            status.forecast.clone_from(&self.forecast);
            status.counters = rendered.counters;
            status.unaimed = rendered.unaimed;
            status.aimed = rendered.aimed;
        });
    }

    /// Publishes maps of the estimated error of `rendered`; does nothing without an error estimate.
    fn publish_error_maps(&self, rendered: &RenderResult) {
        if let Some(maps) = LiveFrame::from_error_maps(0, rendered) {
            self.publish(|state, sequence| state.error_maps = Some(Arc::new(LiveFrame { sequence, ..maps })));
        }
    }
}

/// Appends `point` to `curve`. If the curve already has [`MAX_CURVE_POINTS`] points, every second
/// point is removed first.
fn push_curve_point(curve: &mut Vec<ErrorCurvePoint>, point: ErrorCurvePoint) {
    if curve.len() >= MAX_CURVE_POINTS {
        *curve = curve.iter().copied().step_by(2).collect();
    }
    curve.push(point);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn full_error_curves_still_take_new_points() {
        let (mut curve, count) = (Vec::new(), 3 * MAX_CURVE_POINTS as u32);
        for passes in 1..=count {
            let point =
                ErrorCurvePoint { seconds: 1.0, passes, error: 0.1, low: 0.05, high: 0.2, noise: 0.1, bias: 0.0 };
            push_curve_point(&mut curve, point);
            assert!(curve.len() <= MAX_CURVE_POINTS && curve.is_sorted_by_key(|point| point.passes));
        }
        assert_eq!((curve[0].passes, curve.last().unwrap().passes), (1, count));
    }
}
