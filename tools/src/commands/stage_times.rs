//! GPU times of a frame's stages, for reports.

use serde_json::{json, Map, Value};
use terrane::frame::PerStage;

/// Milliseconds by stage name, of the stages that ran.
pub(crate) fn stage_times(stages_ms: &PerStage<Option<f64>>) -> Map<String, Value> {
    stages_ms.iter().filter_map(|(stage, ms)| Some((stage.name().to_owned(), json!((*ms)?)))).collect()
}
