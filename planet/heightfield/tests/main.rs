//! All tests of this folder as one program: each program links everything, and these need no process of their own.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod classic_costs;
mod classic_splits;
mod dem_folder;
mod gdal_feature;
mod import;
mod joins;
mod kinds;
mod kinds_of_containers;
mod kinds_of_places;
mod kinds_of_samples;
mod peer;
mod tiff_file;
mod world_files;
