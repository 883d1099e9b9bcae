//! Pipelines from SPIR-V: reflection, layouts, compute and graphics.

pub(super) mod compute;
pub(super) mod graphics;
pub(super) mod layout;
pub(super) mod reflection;
pub(super) mod shader;
pub(super) mod types;
