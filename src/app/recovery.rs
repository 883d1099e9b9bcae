//! What becomes of a window whose device is lost: the same on the device anew; and of one whose planet file another program edits: the file is
//! read anew.

use super::flight::Flight;
use super::{App, AppError};
use crate::scene::SceneError;
use crate::vulkan::VulkanError;
use std::time::{Duration, Instant};
use terrane_planet::store::StoreError;
use winit::event_loop::{ActiveEventLoop, ControlFlow};

/// How long a device must last to be used anew after it was lost.
const LASTING: Duration = Duration::from_secs(10);

/// Least time between two readings of a planet file that another program edits.
const BETWEEN_READINGS: Duration = Duration::from_secs(1);

impl AppError {
    fn is_lost_device(&self) -> bool {
        matches!(
            self,
            AppError::Vulkan(VulkanError::DeviceLost { .. })
                | AppError::Scene(SceneError::Vulkan(VulkanError::DeviceLost { .. }))
        )
    }
}

impl App {
    /// After its device is lost the window goes on with it anew, where it was; unless it was lost a moment ago, too.
    pub(super) fn recover(&mut self, events: &ActiveEventLoop, error: AppError) {
        let again = self.recovered.is_some_and(|at| at.elapsed() < LASTING);
        if !error.is_lost_device() || again || self.options.stand.is_some() {
            return self.fail(events, error);
        }
        let Some(mut flight) = self.flight.take() else { return };
        tracing::warn!("{error}; it is used anew");
        let (window, survivors) = (flight.window.clone(), flight.survivors(self.options.keys.clone()));
        let log = flight.context.message_log();
        // A window bears one surface.
        drop(flight);
        self.report.messages.extend(log.all());
        self.options.camera = survivors.viewer.pose.camera(&survivors.viewer.lens);
        self.options.path = None;
        match Flight::new(window, &self.options) {
            Ok(mut flight) => {
                flight.take_over(survivors);
                flight.panel.set_bookmarks(self.options.host.bookmarks());
                flight.panel.say("the GPU was lost, and is used anew".to_owned());
                (self.flight, self.recovered) = (Some(flight), Some(Instant::now()));
            }
            Err(error) => self.fail(events, error),
        }
    }

    /// Reads the planet file anew if another program has edited it. True if it was, or is soon: nothing is asked of it until then.
    pub(super) fn read_anew(&mut self, events: &ActiveEventLoop, now: Instant) -> bool {
        let Some(flight) = self.flight.as_mut().filter(|flight| flight.scene.is_overtaken()) else { return false };
        if let Some(at) = self.read_at.map(|last| last + BETWEEN_READINGS).filter(|at| *at > now) {
            events.set_control_flow(ControlFlow::WaitUntil(at));
            return true;
        }
        self.read_at = Some(now);
        events.set_control_flow(ControlFlow::Poll);
        match flight.read_anew(&self.options.file) {
            Ok(()) => flight.panel.say("another program edited the planet: it is read anew".to_owned()),
            // Edited again meanwhile.
            Err(AppError::Scene(SceneError::Store(StoreError::Changed { .. }))) => {}
            Err(error) => self.recover(events, error),
        }
        true
    }
}
