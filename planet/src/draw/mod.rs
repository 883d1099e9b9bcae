//! What a view draws: cameras and views, what is known of stored patches, the cut through the quadtrees, how much of each patch is
//! looked at, and every structure that the GPU sees.

pub mod camera_path;
pub mod cut;
pub mod layout;
pub mod loaded_patch;
pub mod meter;
pub mod orientation;
pub mod tone;
pub mod tree;
pub mod view;
pub mod view_line;
pub mod work;
