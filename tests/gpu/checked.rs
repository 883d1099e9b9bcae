//! A device that must stay silent. Two test programs share it: this one and the unit tests of `src/vulkan`.

#[path = "../common/skipped.rs"]
mod skipped;

use crate::vulkan::{Context, ContextOptions, MessageLog};
use skipped::skipped;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// One device at a time: several software devices at once only slow each other down.
static DEVICE: Mutex<()> = Mutex::new(());

/// A context that fails the test if validation has said anything by the time it is dropped.
pub(crate) struct Checked {
    context: Option<Arc<Context>>,
    log: Arc<MessageLog>,
    _device: MutexGuard<'static, ()>,
}

impl std::ops::Deref for Checked {
    type Target = Arc<Context>;

    fn deref(&self) -> &Arc<Context> {
        self.context.as_ref().expect("the context is dropped last")
    }
}

impl Drop for Checked {
    fn drop(&mut self) {
        // Destruction is validated too.
        self.context = None;
        let messages = self.log.take();
        if !std::thread::panicking() {
            assert!(messages.is_empty(), "validation: {messages:#?}");
        }
    }
}

/// The device to test on; none prints "skipped", or fails where `TERRANE_REQUIRE_GPU=1`.
pub(crate) fn device() -> Option<Checked> {
    device_with(None)
}

/// The device, drawing with so many samples a pixel.
pub(crate) fn device_with(samples: Option<u32>) -> Option<Checked> {
    let guard = DEVICE.lock().unwrap_or_else(PoisonError::into_inner);
    match Context::new(&ContextOptions { validation: true, samples, ..ContextOptions::default() }) {
        Ok(context) => Some(Checked { log: context.message_log(), context: Some(context), _device: guard }),
        Err(error) => {
            skipped(&error);
            None
        }
    }
}
