//! Planets as per-patch progressive meshes: cube-sphere terrain, the progressive-mesh builder, the planet file and the
//! CPU reference of everything the GPU does. Knows no Vulkan, no window and no GPU.
//!
//! Rooms in the order in which they may use one another, each only those above it: [`globe`], [`recipe`], [`ground`], [`terrain`],
//! [`mesh`], [`store`], [`published`], [`maps`], [`draw`], [`planet`], [`reference`](mod@reference), [`query`], [`verify`], [`export`],
//! [`tiles`].

pub mod draw;
pub mod export;
pub mod globe;
pub mod ground;
pub mod maps;
pub mod mesh;
pub mod planet;
pub mod published;
pub mod query;
pub mod recipe;
pub mod reference;
pub mod store;
pub mod terrain;
pub mod tiles;
pub mod verify;
