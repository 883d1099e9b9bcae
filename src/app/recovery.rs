//! What becomes of a window whose device is lost: the same on the device anew.

use super::flight::Flight;
use super::{App, AppError};
use crate::scene::SceneError;
use crate::vulkan::VulkanError;
use std::time::{Duration, Instant};
use winit::event_loop::ActiveEventLoop;

/// How long a device must last to be used anew after it was lost.
const LASTING: Duration = Duration::from_secs(10);
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
}
