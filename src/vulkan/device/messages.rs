//! Collects what the validation layers say, so that a test (or a frame report) can read it.

use std::borrow::Cow;
use std::ffi::{c_void, CStr};
use std::sync::{Mutex, MutexGuard, PoisonError};

use ash::vk;

/// Messages kept; later ones are counted but dropped, so that a message per draw cannot fill the memory.
pub const MAX_MESSAGES: usize = 1000;

/// How bad a message is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Probably a mistake.
    Warning,
    /// A violation of the Vulkan specification.
    Error,
}

/// One message of the validation layers.
#[derive(Debug, Clone)]
pub struct ValidationMessage {
    /// How bad it is.
    pub severity: Severity,
    /// Identifier such as `SYNC-HAZARD-READ-AFTER-WRITE`.
    pub id: String,
    /// The full text.
    pub text: String,
}

/// A list of messages that outlives the context which fills it.
#[derive(Debug, Default)]
pub struct MessageLog {
    messages: Mutex<Vec<ValidationMessage>>,
}

impl MessageLog {
    /// A copy of all messages so far.
    pub fn all(&self) -> Vec<ValidationMessage> {
        self.lock().clone()
    }

    /// Takes all messages, leaving none.
    pub fn take(&self) -> Vec<ValidationMessage> {
        std::mem::take(&mut *self.lock())
    }

    fn push(&self, message: ValidationMessage) {
        let mut messages = self.lock();
        if messages.len() < MAX_MESSAGES {
            messages.push(message);
        }
    }

    fn lock(&self) -> MutexGuard<'_, Vec<ValidationMessage>> {
        self.messages.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The create info of a messenger that fills this log. The log must outlive the messenger.
    pub(crate) fn messenger(&self) -> vk::DebugUtilsMessengerCreateInfoEXT<'static> {
        let log: *const Self = self;
        vk::DebugUtilsMessengerCreateInfoEXT::default()
            .message_severity(vk::DebugUtilsMessageSeverityFlagsEXT::WARNING | vk::DebugUtilsMessageSeverityFlagsEXT::ERROR)
            // Not GENERAL: the loader reports there every driver that finds no hardware.
            .message_type(vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION | vk::DebugUtilsMessageTypeFlagsEXT::PERFORMANCE)
            .pfn_user_callback(Some(receive))
            .user_data(log.cast_mut().cast())
    }
}

/// Called by the layers, from any thread; the user data is a `MessageLog`.
unsafe extern "system" fn receive(
    severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _kind: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    log: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: `messenger` set the user data to a log that outlives the messenger; shared references only.
    let log = unsafe { log.cast::<MessageLog>().as_ref() };
    // SAFETY: the layer passes valid data for the length of this call.
    let data = unsafe { data.as_ref() };
    if let (Some(log), Some(data)) = (log, data) {
        // SAFETY: both are null or strings that end in a null byte.
        let (id, text) = unsafe { (to_text(data.p_message_id_name), to_text(data.p_message)) };
        let error = severity.contains(vk::DebugUtilsMessageSeverityFlagsEXT::ERROR);
        let severity = if error { Severity::Error } else { Severity::Warning };
        tracing::warn!(?severity, "{text}");
        log.push(ValidationMessage { severity, id: id.into_owned(), text: text.into_owned() });
    }
    vk::FALSE
}

/// # Safety
/// `text` is null or points to a string that ends in a null byte and outlives the result.
unsafe fn to_text<'a>(text: *const std::ffi::c_char) -> Cow<'a, str> {
    if text.is_null() {
        return Cow::Borrowed("");
    }
    // SAFETY: not null, and the caller vouches for the rest.
    unsafe { CStr::from_ptr(text) }.to_string_lossy()
}
