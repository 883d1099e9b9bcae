//! The Vulkan layer on a real device, with validation: any message fails a test.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]

mod compute;
mod drawing;
mod images;
mod machine;
mod shaders;
mod validation;

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::{Context, ContextOptions, MessageLog};

/// One device at a time: several software devices at once only slow each other down.
static DEVICE: Mutex<()> = Mutex::new(());

/// A context that fails the test if validation has said anything by the time it is dropped.
struct Checked {
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
fn device() -> Option<Checked> {
    let guard = DEVICE.lock().unwrap_or_else(PoisonError::into_inner);
    let options = ContextOptions { validation: true, ..ContextOptions::default() };
    match Context::new(&options) {
        Ok(context) => {
            let log = context.message_log();
            Some(Checked { context: Some(context), log, _device: guard })
        }
        Err(error) => {
            let required = std::env::var("TERRANE_REQUIRE_GPU").is_ok_and(|value| value == "1");
            assert!(!required, "no device: {error}");
            println!("skipped: {error}");
            None
        }
    }
}
