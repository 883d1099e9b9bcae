//! Published planets over HTTP and HTTPS.

use super::fetch_cache::FetchCache;
use super::line::{Carried, Line, Stretch};
use anyhow::{ensure, Context as _};
use std::io::Read;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Duration;
use terrane_planet::published::{FetchError, Freshness, Manifest, ObjectName, Objects, MANIFEST, MOST_MANIFEST_BYTES};
use ureq::http::{header, Response, StatusCode};
use ureq::{Agent, Body};

/// Longest time to reach a server, and for an answer as a whole.
const CONNECT: Duration = Duration::from_secs(5);
const ANSWER: Duration = Duration::from_secs(30);

/// How long a server that says nothing of it is left alone when it is at its limit.
const REST: Duration = Duration::from_secs(1);

/// How often a server that is at its limit is asked for `planet.json` again, and how long it is left alone at most.
const PATIENCE: usize = 5;
const LONGEST_REST: Duration = Duration::from_secs(5);

/// Most bytes of an object that a server sends whole where a range was asked for.
const MOST_WHOLE: u64 = 64 << 20;

/// Whether a text is the address of a planet, and no file or name.
pub(crate) fn is_address(text: &str) -> bool {
    text.starts_with("http://") || text.starts_with("https://")
}

/// The files of a planet that a server has.
pub(crate) struct HttpObjects {
    /// Address of the folder, with a slash at its end.
    base: String,
    place: PathBuf,
    agent: Agent,
    line: Line,
    cache: Option<FetchCache>,
}

impl HttpObjects {
    /// The planet at the address of its `planet.json`, or of the folder that this is in.
    pub(crate) fn new(address: &str, cache: Option<FetchCache>) -> anyhow::Result<HttpObjects> {
        let folder = address.strip_suffix(MANIFEST).unwrap_or(address);
        ensure!(
            folder.ends_with('/') && !address.contains(['?', '#']),
            "{address}: expected the address of a {MANIFEST}, or of the folder with it and a slash at its end"
        );
        address.parse::<ureq::http::Uri>().with_context(|| format!("{address} is no address"))?;
        let config = Agent::config_builder()
            .timeout_connect(Some(CONNECT))
            .timeout_global(Some(ANSWER))
            // 304, 404 and 503 are answers.
            .http_status_as_error(false)
            .user_agent(concat!("terrane/", env!("CARGO_PKG_VERSION")));
        let agent = config.build().new_agent();
        Ok(HttpObjects {
            base: folder.to_owned(),
            place: PathBuf::from(format!("{folder}{MANIFEST}")),
            agent,
            line: Line::new(),
            cache,
        })
    }

    /// Asks the server for a stretch.
    fn carry(&self, ((object, from), range): &Stretch) -> Carried {
        let address = format!("{}{}", self.base, object.path());
        let mut request =
            self.agent.get(&address).header(header::RANGE, format!("bytes={}-{}", range.start, range.end.saturating_sub(1)));
        if *from == Freshness::Origin {
            request = request.header(header::CACHE_CONTROL, "no-cache");
        }
        let mut response = match request.call() {
            Ok(response) => response,
            Err(error) => return Carried::Failed(format!("{address}: {error}")),
        };
        let status = response.status();
        let length = range.end - range.start;
        match status {
            StatusCode::PARTIAL_CONTENT => match body(&mut response, length) {
                Ok(bytes) => Carried::Bytes(bytes),
                Err(error) => Carried::Failed(format!("{address}: {error}")),
            },
            // The server knows no ranges.
            StatusCode::OK => match body(&mut response, MOST_WHOLE) {
                Ok(bytes) => {
                    let at = |position: u64| usize::try_from(position).unwrap_or(usize::MAX).min(bytes.len());
                    Carried::Bytes(bytes[at(range.start)..at(range.end)].to_vec())
                }
                Err(error) => Carried::Failed(format!("{address}: {error}")),
            },
            StatusCode::SERVICE_UNAVAILABLE | StatusCode::TOO_MANY_REQUESTS => {
                let after =
                    response.headers().get(header::RETRY_AFTER).and_then(|after| after.to_str().ok()?.trim().parse().ok());
                Carried::Refused(format!("{address}: {status}"), after.map_or(REST, Duration::from_secs))
            }
            _ if status.is_client_error() => Carried::Missing(format!("{address}: {status}")),
            _ => Carried::Failed(format!("{address}: {status}")),
        }
    }
}

/// How long a server wants to be left alone. Dates are taken for the usual time.
fn retry_after(response: &Response<Body>) -> Duration {
    let after = response.headers().get(header::RETRY_AFTER).and_then(|after| after.to_str().ok()?.trim().parse().ok());
    after.map_or(REST, Duration::from_secs)
}

/// Whether another time there would be no other answer.
fn is_final(status: StatusCode) -> bool {
    let passing = [StatusCode::REQUEST_TIMEOUT, StatusCode::TOO_EARLY, StatusCode::TOO_MANY_REQUESTS];
    status.is_client_error() && !passing.contains(&status)
}

fn body(response: &mut Response<Body>, most: u64) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    response.body_mut().as_reader().take(most).read_to_end(&mut bytes)?;
    Ok(bytes)
}

impl Objects for HttpObjects {
    fn place(&self) -> &Path {
        &self.place
    }

    fn manifest(&self) -> Result<Vec<u8>, FetchError> {
        let address = self.place.display().to_string();
        let known = self.cache.as_ref().and_then(|cache| cache.manifest(&address));
        let ask = || {
            let request = self.agent.get(&address);
            match known.as_ref().filter(|(tag, _)| !tag.is_empty()) {
                Some((tag, _)) => request.header(header::IF_NONE_MATCH, tag).call(),
                None => request.call(),
            }
        };
        let failed = |reason: String| match &known {
            // What is built and fetched for it is in the cache as well.
            Some((_, bytes)) => {
                tracing::warn!("{reason}: taken from the cache, as it was the last time");
                Ok(bytes.clone())
            }
            None => Err(FetchError::Unreachable(reason)),
        };
        let mut response = ask();
        for _ in 0..PATIENCE {
            match &response {
                Ok(busy) if [StatusCode::SERVICE_UNAVAILABLE, StatusCode::TOO_MANY_REQUESTS].contains(&busy.status()) => {
                    std::thread::sleep(retry_after(busy).min(LONGEST_REST));
                    response = ask();
                }
                _ => break,
            }
        }
        let mut response = match response {
            Ok(response) => response,
            Err(error) => return failed(error.to_string()),
        };
        match (response.status(), &known) {
            (StatusCode::NOT_MODIFIED, Some((_, bytes))) => Ok(bytes.clone()),
            (StatusCode::OK, _) => {
                let bytes = match body(&mut response, MOST_MANIFEST_BYTES) {
                    Ok(bytes) => bytes,
                    Err(error) => return failed(error.to_string()),
                };
                // A page that says "log in first" is none.
                if Manifest::parse(&bytes).is_err() {
                    return Ok(bytes);
                }
                let tag = response.headers().get(header::ETAG).and_then(|tag| tag.to_str().ok()).unwrap_or_default();
                if let Some(cache) = &self.cache {
                    cache.keep_manifest(&address, tag, &bytes);
                }
                Ok(bytes)
            }
            (status, _) if is_final(status) => Err(FetchError::Missing(status.to_string())),
            (status, _) => failed(status.to_string()),
        }
    }

    fn kept(&self, object: ObjectName, range: &Range<u64>) -> Option<Vec<u8>> {
        self.cache.as_ref()?.stretch(object, range)
    }

    fn keep(&self, object: ObjectName, range: &Range<u64>, bytes: &[u8]) {
        if let Some(cache) = &self.cache {
            cache.keep(object, range.start, bytes);
        }
    }

    fn read(&self, object: ObjectName, range: Range<u64>, from: Freshness) -> Result<Vec<u8>, FetchError> {
        self.line.fetch(((object, from), range), &|stretch| self.carry(stretch))
    }

    fn is_busy(&self) -> bool {
        self.line.is_busy()
    }

    fn traffic(&self) -> (u64, u64) {
        self.line.traffic()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_those_of_a_manifest_or_its_folder() {
        assert!(
            is_address("https://a/b/planet.json")
                && is_address("http://a/")
                && !is_address("httpd.planet")
                && !is_address("terra")
        );
        for good in ["http://127.0.0.1:8080/terra/planet.json", "https://example.org/a/"] {
            let objects = HttpObjects::new(good, None).expect(good);
            assert!(objects.base.ends_with('/') && objects.place.ends_with(MANIFEST), "{}", objects.base);
        }
        for wrong in ["http://a/b", "http://a/planet.json?x=1", "http://a b/planet.json", "http:///planet.json#"] {
            assert!(HttpObjects::new(wrong, None).is_err(), "{wrong}");
        }
    }
}
