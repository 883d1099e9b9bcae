//! Serves a published planet. Nothing is computed for a question and nothing is remembered of who asks: a server can be stopped and started at
//! any time, and there can be many.

use super::metrics::Metrics;
use anyhow::Context as _;
use axum::body::{Body, HttpBody};
use axum::extract::{Path as InPath, Request, State};
use axum::http::{header, HeaderMap, HeaderValue, Method, StatusCode};
use axum::middleware::{from_fn_with_state, Next};
use axum::response::{Html, IntoResponse, Response};
use axum::routing::get;
use axum::Router;
use std::io::{Read, Seek, SeekFrom};
use std::net::SocketAddr;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use terrane_planet::published::{ObjectName, MANIFEST};
use tokio::sync::Semaphore;
use tower_http::services::ServeDir;

/// Most bytes of a range: who asks for more gets the first of them.
const MOST_BYTES: u64 = 4 << 20;

/// How long whoever is turned away is asked to wait, seconds.
const RETRY_AFTER: &str = "1";

/// How long answers that are on their way get after the server was told to stop.
const LAST_WORDS: Duration = Duration::from_secs(5);

/// How often it looks whether it was.
const MOMENT: Duration = Duration::from_millis(100);

/// Longest time that an answer may take to be found.
const LONGEST: Duration = Duration::from_secs(20);

/// What a server may use.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// Questions that are answered at a time.
    pub(crate) at_once: usize,
    /// Questions a second.
    pub(crate) per_second: f64,
    /// Bytes of answers a second.
    pub(crate) bytes_per_second: f64,
}

/// What a server serves.
pub(crate) struct Served {
    /// The folder with `planet.json`.
    pub(crate) folder: PathBuf,
    /// A folder with a `tileset.json`.
    pub(crate) tiles: Option<PathBuf>,
    /// Name of the planet.
    pub(crate) name: String,
}

struct Shop {
    served: Served,
    limits: Limits,
    room: Arc<Semaphore>,
    requests: Mutex<Bucket>,
    bytes: Mutex<Bucket>,
    metrics: Metrics,
}

/// An allowance that fills with time, up to that of two seconds. What is charged may overdraw it.
struct Bucket {
    left: f64,
    rate: f64,
    at: Instant,
}

impl Bucket {
    fn new(rate: f64) -> Mutex<Bucket> {
        Mutex::new(Bucket { left: (2.0 * rate).max(1.0), rate, at: Instant::now() })
    }

    /// Charges an amount, if there is as much as `needed`.
    fn take(bucket: &Mutex<Bucket>, needed: f64, amount: f64) -> bool {
        let mut bucket = bucket.lock().unwrap_or_else(PoisonError::into_inner);
        let now = Instant::now();
        let gained = bucket.rate * now.duration_since(bucket.at).as_secs_f64();
        bucket.left = (bucket.left + gained).min((2.0 * bucket.rate).max(1.0));
        bucket.at = now;
        let is_there = bucket.left >= needed;
        if is_there {
            bucket.left -= amount;
        }
        is_there
    }
}

/// Serves until `stop` is raised. Says where, as soon as it listens.
///
/// # Errors
/// If it cannot listen at the address.
pub(crate) fn serve(
    served: Served,
    address: SocketAddr,
    limits: Limits,
    stop: Arc<AtomicBool>,
    listening: &dyn Fn(SocketAddr),
) -> anyhow::Result<()> {
    let tiles = served.tiles.clone();
    let shop = Arc::new(Shop {
        served,
        limits,
        room: Arc::new(Semaphore::new(limits.at_once)),
        requests: Bucket::new(limits.per_second),
        bytes: Bucket::new(limits.bytes_per_second),
        metrics: Metrics::default(),
    });
    let mut router =
        Router::new().route("/", get(page)).route("/planet.json", get(manifest)).route("/objects/{folder}/{name}", get(object));
    if let Some(tiles) = tiles {
        router = router.nest_service("/tiles", ServeDir::new(tiles));
    }
    let router = router.layer(from_fn_with_state(shop.clone(), guard)).route("/metrics", get(metrics)).with_state(shop);
    let threads = std::thread::available_parallelism().map_or(2, usize::from).min(4);
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(threads)
        .max_blocking_threads(limits.at_once)
        .enable_all()
        .build()
        .context("cannot start the server's threads")?;
    runtime.block_on(async move {
        let listener = tokio::net::TcpListener::bind(address).await;
        let listener = listener.with_context(|| format!("cannot listen at {address}; choose another --addr"))?;
        listening(listener.local_addr()?);
        let server = axum::serve(listener, router).with_graceful_shutdown(raised(stop.clone()));
        let late = async move {
            raised(stop).await;
            tokio::time::sleep(LAST_WORDS).await;
        };
        tokio::select! {
            ended = server => ended.context("the server failed"),
            () = late => Ok(()),
        }
    })?;
    // Whoever still reads slowly does not hold up the end.
    runtime.shutdown_timeout(MOMENT);
    Ok(())
}

/// Ends when a flag is raised.
async fn raised(flag: Arc<AtomicBool>) {
    while !flag.load(Ordering::Relaxed) {
        tokio::time::sleep(MOMENT).await;
    }
}

/// Lets in what there is room for, and counts.
async fn guard(State(shop): State<Arc<Shop>>, request: Request, next: Next) -> Response {
    let begun = Instant::now();
    if !matches!(*request.method(), Method::GET | Method::HEAD) {
        return plain(StatusCode::METHOD_NOT_ALLOWED, "this server only answers GET and HEAD");
    }
    let is_within = Bucket::take(&shop.bytes, 0.0, 0.0) && Bucket::take(&shop.requests, 1.0, 1.0);
    let Some(_room) = shop.room.clone().try_acquire_owned().ok().filter(|_| is_within) else {
        shop.metrics.turned_away();
        let mut response = plain(StatusCode::SERVICE_UNAVAILABLE, "the server is at its limit; ask again in a second");
        response.headers_mut().insert(header::RETRY_AFTER, HeaderValue::from_static(RETRY_AFTER));
        return response;
    };
    let Ok(mut response) = tokio::time::timeout(LONGEST, next.run(request)).await else {
        return plain(StatusCode::SERVICE_UNAVAILABLE, "it took too long");
    };
    // Pages from elsewhere may show what anybody may read.
    response.headers_mut().insert(header::ACCESS_CONTROL_ALLOW_ORIGIN, HeaderValue::from_static("*"));
    let stated = response.headers().get(header::CONTENT_LENGTH).and_then(|length| length.to_str().ok()?.parse::<u64>().ok());
    let bytes = stated.unwrap_or_else(|| response.body().size_hint().lower());
    Bucket::take(&shop.bytes, f64::NEG_INFINITY, bytes as f64);
    shop.metrics.answered(response.status(), bytes, begun.elapsed());
    response
}

fn plain(status: StatusCode, text: &'static str) -> Response {
    (status, text).into_response()
}

async fn page(State(shop): State<Arc<Shop>>, headers: HeaderMap) -> Html<String> {
    let host = headers.get(header::HOST).and_then(|host| host.to_str().ok()).unwrap_or("127.0.0.1:8080");
    let safe = |text: &str| text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
    let (name, host) = (safe(&shop.served.name), safe(host));
    let tiles = match shop.served.tiles {
        Some(_) => format!("<p>In CesiumJS, three.js and others, as 3D Tiles: <code>http://{host}/tiles/tileset.json</code></p>"),
        None => "<p>There are no 3D Tiles here: <code>terrane tiles</code> makes them, <code>terrane serve --tiles</code> serves them.</p>".to_owned(),
    };
    Html(format!(
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\"><title>{name}</title>\
         <style>body{{font:16px/1.5 system-ui,sans-serif;max-width:44em;margin:3em auto;padding:0 1em;color-scheme:light dark}}\
         code{{background:#8882;padding:.1em .3em;border-radius:.2em}}</style>\
         <h1>{name}</h1><p>A planet, published by Terrane. Fly over it: <code>terrane fly http://{host}/{MANIFEST}</code></p>\
         <p>One picture: <code>terrane shot http://{host}/{MANIFEST} --out planet.png</code></p>{tiles}\
         <p><a href=\"{MANIFEST}\">{MANIFEST}</a> says what there is, <a href=\"metrics\">metrics</a> what this server did.</p></html>"
    ))
}

async fn metrics(State(shop): State<Arc<Shop>>) -> Response {
    let in_flight = shop.limits.at_once - shop.room.available_permits();
    ([(header::CONTENT_TYPE, "text/plain; version=0.0.4")], shop.metrics.text(in_flight)).into_response()
}

/// `planet.json`, which may be replaced while the server runs.
async fn manifest(State(shop): State<Arc<Shop>>, headers: HeaderMap) -> Response {
    let path = shop.served.folder.join(MANIFEST);
    let Ok(bytes) = tokio::fs::read(&path).await else { return plain(StatusCode::NOT_FOUND, "there is no planet.json any more") };
    let tag = format!("\"{}\"", ObjectName::of(&bytes));
    let known = headers.get(header::IF_NONE_MATCH).is_some_and(|known| known.as_bytes() == tag.as_bytes());
    let about = [
        (header::ETAG, tag),
        (header::CACHE_CONTROL, "no-cache".to_owned()),
        (header::CONTENT_TYPE, "application/json".to_owned()),
    ];
    if known {
        return (StatusCode::NOT_MODIFIED, about).into_response();
    }
    (about, bytes).into_response()
}

/// A file that never changes, or a range of it.
async fn object(State(shop): State<Arc<Shop>>, InPath((folder, name)): InPath<(String, String)>, headers: HeaderMap) -> Response {
    // Its name leads to it, and nothing else: no address leads out of the folder.
    let Some(name) = ObjectName::parse(&name).filter(|name| name.path() == format!("objects/{folder}/{name}")) else {
        return plain(StatusCode::NOT_FOUND, "there is no such object");
    };
    let path = shop.served.folder.join(name.path());
    let asked = headers.get(header::RANGE).and_then(|range| range.to_str().ok()).map(str::to_owned);
    let read = tokio::task::spawn_blocking(move || read_range(&path, asked.as_deref())).await;
    match read {
        Ok(Ok((bytes, range, length))) => {
            let is_part = range != (0..length) && !bytes.is_empty();
            let mut response = Response::new(Body::from(bytes));
            let about = response.headers_mut();
            about.insert(header::ACCEPT_RANGES, HeaderValue::from_static("bytes"));
            about.insert(header::CACHE_CONTROL, HeaderValue::from_static("public, max-age=31536000, immutable"));
            about.insert(header::CONTENT_TYPE, HeaderValue::from_static("application/octet-stream"));
            if let Ok(tag) = HeaderValue::from_str(&format!("\"{name}\"")) {
                about.insert(header::ETAG, tag);
            }
            if is_part {
                if let Ok(part) = HeaderValue::from_str(&format!("bytes {}-{}/{length}", range.start, range.end - 1)) {
                    about.insert(header::CONTENT_RANGE, part);
                }
                *response.status_mut() = StatusCode::PARTIAL_CONTENT;
            }
            response
        }
        Ok(Err(Unread::Range(length))) => {
            (StatusCode::RANGE_NOT_SATISFIABLE, [(header::CONTENT_RANGE, format!("bytes */{length}"))]).into_response()
        }
        Ok(Err(Unread::File)) => plain(StatusCode::NOT_FOUND, "there is no such object"),
        Err(_) => plain(StatusCode::INTERNAL_SERVER_ERROR, "it could not be read"),
    }
}

/// Why nothing was read.
enum Unread {
    File,
    /// The range is not within so many bytes.
    Range(u64),
}

/// Bytes of a file, which these are, and how many there are in all.
fn read_range(path: &Path, asked: Option<&str>) -> Result<(Vec<u8>, Range<u64>, u64), Unread> {
    let mut file = std::fs::File::open(path).map_err(|_| Unread::File)?;
    let length = file.metadata().map_err(|_| Unread::File)?.len();
    let range = match asked {
        Some(text) => range_of(text, length)?,
        None => 0..length,
    };
    // Of a range the first part will do (RFC 9110, 15.3.7), of the whole it would not.
    let most = if range == (0..length) { length } else { MOST_BYTES };
    let range = range.start..range.end.min(range.start + most);
    file.seek(SeekFrom::Start(range.start)).map_err(|_| Unread::File)?;
    let mut bytes = Vec::new();
    file.take(range.end - range.start).read_to_end(&mut bytes).map_err(|_| Unread::File)?;
    let end = range.start + bytes.len() as u64;
    Ok((bytes, range.start..end, length))
}

/// The range that a header names, of so many bytes. What is no single range means the whole (RFC 9110, 14.2).
fn range_of(text: &str, length: u64) -> Result<Range<u64>, Unread> {
    let parts = text.strip_prefix("bytes=").and_then(|range| range.split_once('-'));
    let Some((first, last)) = parts.map(|(first, last)| (first.trim(), last.trim())) else { return Ok(0..length) };
    let range = match (first.parse::<u64>().ok(), last.parse::<u64>().ok()) {
        (Some(first), Some(last)) if last >= first => first..last.saturating_add(1).min(length),
        (Some(first), None) if last.is_empty() => first..length,
        (None, Some(last)) if first.is_empty() => length.saturating_sub(last)..length,
        _ => return Ok(0..length),
    };
    if range.start >= length {
        return Err(Unread::Range(length));
    }
    Ok(range)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_those_of_rfc_9110() {
        let of = |text: &str| range_of(text, 1000).ok();
        assert_eq!(of("bytes=0-499"), Some(0..500));
        assert_eq!(of("bytes=500-"), Some(500..1000));
        assert_eq!(of("bytes=-200"), Some(800..1000));
        assert_eq!(of("bytes=990-2000"), Some(990..1000));
        assert_eq!(of("bytes=1000-1001"), None);
        for whole in ["bytes=5-2", "lines=0-1", "bytes=a-b", "bytes=0-1,5-6", "bytes=-", "", "bytes=18446744073709551616-"] {
            assert_eq!(of(whole), Some(0..1000), "{whole}");
        }
        assert_eq!(of("bytes=0-18446744073709551615"), Some(0..1000));
    }

    #[test]
    fn an_allowance_is_used_up_and_fills_again() {
        let bucket = Bucket::new(1.0);
        let taken = || (0..40).filter(|_| Bucket::take(&bucket, 1.0, 1.0)).count();
        assert_eq!(taken(), 2);
        std::thread::sleep(Duration::from_millis(1200));
        assert_eq!(taken(), 1);
        // What is overdrawn is waited for.
        assert!(Bucket::take(&bucket, f64::NEG_INFINITY, 100.0) && !Bucket::take(&bucket, 0.0, 0.0));
    }
}
