//! Planets over HTTP: those that somebody published, by the address of their `planet.json`; and a server of them.
//!
//! The receiver decides what it needs and when; the server keeps no state (Cheng and Ooi, 2008). What came is kept in the user's cache.

mod fetch_cache;
mod http;
mod line;
mod metrics;
mod server;

pub(crate) use fetch_cache::FetchCache;
pub(crate) use http::{is_address, HttpObjects};
pub(crate) use server::{serve, Limits, Served};
