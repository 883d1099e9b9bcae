//! Planets over HTTP: a picture of a published planet is that of its file, whatever becomes of the line; and a server that answers whatever it is
//! asked, and ends when it is told to.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use crate::common::{command, device, text};
use crate::mesh_and_bench::planet_in;
use serde_json::Value;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::OnceLock;
use std::time::{Duration, Instant};
use terrane_planet::globe::random::Random;

/// Runs the command in a folder, with a cache of a name there.
fn terrane(folder: &Path, cache: &str, arguments: &[&str]) -> Output {
    command(arguments).current_dir(folder).env("XDG_CACHE_HOME", folder.join(cache)).output().expect("terrane runs")
}

fn succeeds(folder: &Path, cache: &str, arguments: &[&str]) -> Output {
    let output = terrane(folder, cache, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
    output
}

/// A picture of a planet: what the command says of it, on stdout and on stderr.
fn shot(folder: &Path, cache: &str, planet: &str, out: &str, more: &[&str]) -> (Value, String) {
    let usual = ["--at", "10,20,4000", "--look", "40,-30", "--size", "320x180", "--spacing", "120", "--json", "--out", out];
    let output = succeeds(folder, cache, &[&["shot", planet], &usual[..], more].concat());
    (serde_json::from_slice(&output.stdout).unwrap(), text(&output.stderr))
}

fn same(folder: &Path, a: &str, b: &str) -> bool {
    std::fs::read(folder.join(a)).unwrap() == std::fs::read(folder.join(b)).unwrap()
}

/// A server in the background, which goes with this.
struct Server {
    child: Child,
    /// Its host and port.
    host: String,
}

impl Server {
    /// `terrane serve` on a free port.
    fn terrane(folder: &Path, arguments: &[&str]) -> Server {
        let mut serve = command(&["serve", "--addr", "127.0.0.1:0"]);
        serve.args(arguments).current_dir(folder).env("XDG_CACHE_HOME", folder.join("served"));
        let log = std::fs::File::create(folder.join("serve.log")).unwrap();
        let mut child = serve.stdout(Stdio::piped()).stderr(log).spawn().unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let host = line.split("http://").nth(1).and_then(|rest| rest.split('/').next());
        let host = host.unwrap_or_else(|| panic!("'{line}', expected where it listens")).to_owned();
        Server { child, host }
    }

    /// nginx with a folder of its own; none prints "skipped".
    fn nginx(folder: &Path, served: &Path, rate: &str) -> Option<Server> {
        let home = folder.join(format!("nginx{}", rate.len()));
        std::fs::create_dir_all(&home).unwrap();
        let port = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        let (own, root, host) = (home.display(), served.display(), format!("127.0.0.1:{port}"));
        let folders: String =
            ["client_body", "proxy", "fastcgi", "uwsgi", "scgi"].map(|kind| format!("{kind}_temp_path {own}/{kind};")).concat();
        let settings = format!(
            "daemon off; master_process off; pid {own}/pid; error_log {own}/error.log; events {{}}\n\
             http {{ access_log {own}/access.log; {folders} server {{ listen {host}; root {root}; {rate} }} }}\n"
        );
        std::fs::write(home.join("nginx.conf"), settings).unwrap();
        let Some(program) = nginx() else {
            println!("skipped: nginx is neither installed nor to be had, so that nothing is fetched from it");
            return None;
        };
        let mut nginx = Command::new(program);
        nginx.arg("-p").arg(&home).arg("-e").arg(home.join("error.log")).arg("-c").arg(home.join("nginx.conf"));
        let child = nginx.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        let server = Server { child, host };
        let begun = Instant::now();
        while TcpStream::connect(&server.host).is_err() {
            assert!(
                begun.elapsed() < Duration::from_secs(10),
                "nginx does not listen: {}",
                std::fs::read_to_string(home.join("error.log")).unwrap()
            );
            std::thread::sleep(Duration::from_millis(20));
        }
        Some(server)
    }

    fn planet(&self) -> String {
        format!("http://{}/planet.json", self.host)
    }

    /// The answer to a request, whatever that is.
    fn ask(&self, request: &[u8]) -> String {
        self.ask_within(request, Duration::from_secs(10))
    }

    /// What is answered to a request in a time.
    fn ask_within(&self, request: &[u8], limit: Duration) -> String {
        let mut stream = TcpStream::connect(&self.host).unwrap();
        stream.set_read_timeout(Some(limit)).unwrap();
        let (mut answer, _) = (Vec::new(), stream.write_all(request));
        if !request.ends_with(b"\r\n\r\n") {
            // It would wait for the rest.
            let _ = stream.shutdown(std::net::Shutdown::Write);
        }
        let _ = stream.read_to_end(&mut answer);
        text(&answer)
    }

    fn get(&self, path: &str) -> String {
        self.ask(format!("GET {path} HTTP/1.1\r\nHost: {}\r\nConnection: close\r\n\r\n", self.host).as_bytes())
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The program of nginx: the system's, or Debian's, unpacked into the target folder. Installed it would begin to serve, now and after
/// every start of the machine.
fn nginx() -> Option<PathBuf> {
    static FOUND: OnceLock<Option<PathBuf>> = OnceLock::new();
    let find = || {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/nginx");
        let runs = |program: &PathBuf| Command::new(program).arg("-v").output().is_ok_and(|output| output.status.success());
        let unpacked = folder.join("unpacked/usr/sbin/nginx");
        let there = [PathBuf::from("nginx"), "/usr/sbin/nginx".into(), unpacked.clone()].into_iter().find(runs);
        there.or_else(|| {
            std::fs::create_dir_all(&folder).ok()?;
            Command::new("apt-get").args(["download", "nginx"]).current_dir(&folder).output().ok()?;
            let package = std::fs::read_dir(&folder).ok()?.filter_map(|entry| Some(entry.ok()?.path()));
            let package = package.into_iter().find(|path| path.extension().is_some_and(|extension| extension == "deb"))?;
            Command::new("dpkg").arg("-x").args([package, folder.join("unpacked")]).output().ok()?;
            Some(unpacked).filter(runs)
        })
    };
    FOUND.get_or_init(find).clone()
}

/// Whether there is a planet file in a folder.
fn kept_file(folder: &Path) -> bool {
    let mut entries = std::fs::read_dir(folder).into_iter().flatten().filter_map(|entry| Some(entry.ok()?.path()));
    entries.any(|path| path.extension().is_some_and(|extension| extension == "planet"))
}

/// A planet file, and the folder that it is published in.
fn published(folder: &Path) {
    planet_in(folder);
    succeeds(folder, "local", &["publish", "tiny.planet", "--out", "www", "--json"]);
}

#[test]
fn a_picture_over_http_is_that_of_the_file_and_a_second_one_asks_for_less() {
    if device().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    published(folder);
    shot(folder, "local", "tiny.planet", "local.png", &[]);
    let served = Server::terrane(folder, &["www"]);
    let servers = [Some(served), Server::nginx(folder, &folder.join("www"), "")];
    for (k, server) in servers.into_iter().flatten().enumerate() {
        let cache = format!("cache{k}");
        let (first, _) = shot(folder, &cache, &server.planet(), "far.png", &[]);
        assert!(same(folder, "local.png", "far.png"), "{first}");
        let count = |summary: &Value, key: &str| summary["fetched"][key].as_u64().unwrap();
        assert!(count(&first, "requests") > 10 && count(&first, "network_bytes") > 100_000, "{first}");
        // What was fetched is in the cache, and so is most of what was built.
        let (second, _) = shot(folder, &cache, &server.planet(), "far.png", &[]);
        assert!(same(folder, "local.png", "far.png"));
        assert!(2 * count(&second, "network_bytes") < count(&first, "network_bytes"), "{second}");
        // Only what is published is drawn, or nothing of it.
        shot(folder, "local", "tiny.planet", "stored.png", &["--stored-only"]);
        let (stored, _) = shot(folder, &format!("{cache}-stored"), &server.planet(), "far.png", &["--no-build"]);
        assert!(same(folder, "stored.png", "far.png") && stored["patches_built"] == 0);
        let (built, _) = shot(folder, &format!("{cache}-built"), &server.planet(), "far.png", &["--no-fetch"]);
        assert!(
            same(folder, "local.png", "far.png") && count(&built, "network_bytes") < 10_000 && built["patches_built"] != 0,
            "{built}"
        );
        // Commands that read a whole file fetch it.
        let mesh = |planet: &str, out: &str| {
            succeeds(folder, &format!("{cache}-mesh"), &["mesh", planet, "--at", "10,20,9000", "--out", out])
        };
        mesh("tiny.planet", "local.glb");
        mesh(&server.planet(), "far.glb");
        assert!(same(folder, "local.glb", "far.glb"));
    }
}

#[test]
fn faults_of_the_line_are_named_and_the_picture_stays() {
    if device().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    published(folder);
    shot(folder, "local", "tiny.planet", "local.png", &[]);
    // A server that ends half-way: what it does not send is built.
    if let Some(mut slow) = Server::nginx(folder, &folder.join("www"), "limit_rate_after 3k; limit_rate 500;") {
        let address = slow.planet();
        std::thread::scope(|scope| {
            let far = scope.spawn(|| shot(folder, "cut", &address, "cut.png", &[]));
            // The planet is known when its file is made; its larger stretches would take seconds.
            let begun = Instant::now();
            while !kept_file(&folder.join("cut/terrane")) {
                assert!(begun.elapsed() < Duration::from_secs(60), "no planet file is made");
                std::thread::sleep(Duration::from_millis(10));
            }
            std::thread::sleep(Duration::from_millis(500));
            slow.child.kill().unwrap();
            let (summary, _) = far.join().unwrap();
            assert!(same(folder, "local.png", "cut.png") && summary["fetched"]["failed"].as_u64() > Some(0), "{summary}");
        });
        // Without a server the planet is still known, and drawn.
        let (_, said) = shot(folder, "cut", &address, "cut.png", &[]);
        assert!(same(folder, "local.png", "cut.png") && said.contains("taken from the cache, as it was the last time"), "{said}");
        let unknown = terrane(folder, "nothing", &["shot", &address, "--out", "x.png"]);
        assert!(
            !unknown.status.success() && text(&unknown.stderr).contains("cannot fetch planet.json"),
            "{}",
            text(&unknown.stderr)
        );
    }
    // A server at its limit is asked again later.
    let narrow = Server::terrane(folder, &["www", "--rate", "5"]);
    let (summary, _) = shot(folder, "narrow", &narrow.planet(), "narrow.png", &[]);
    assert!(same(folder, "local.png", "narrow.png"), "{summary}");
    assert!(!narrow.get("/metrics").contains("terrane_requests_refused_total 0"));
    // Wrong bytes are refused by name. The largest files hold data.
    let objects = std::fs::read_dir(folder.join("www/objects"))
        .unwrap()
        .flat_map(|folder| std::fs::read_dir(folder.unwrap().path()).unwrap());
    let mut objects: Vec<_> = objects.map(|entry| entry.unwrap().path()).collect();
    objects.sort_by_key(|path| std::cmp::Reverse(path.metadata().unwrap().len()));
    for path in objects.iter().take(6) {
        let mut bytes = std::fs::read(path).unwrap();
        bytes.iter_mut().step_by(50).for_each(|byte| *byte ^= 4);
        std::fs::write(path, bytes).unwrap();
    }
    let (summary, said) = shot(folder, "garbled", &Server::terrane(folder, &["www"]).planet(), "garbled.png", &[]);
    assert!(same(folder, "local.png", "garbled.png") && summary["fetched"]["refused"].as_u64() > Some(0), "{summary}");
    assert!(
        said.contains("bytes that are not those that were published; asked for again") && said.contains("segment 1 of"),
        "{said}"
    );
    let output = terrane(folder, "local", &["shot", "http://127.0.0.1:9/planet", "--out", "x.png"]);
    assert!(text(&output.stderr).contains("expected the address of a planet.json"), "{}", text(&output.stderr));
}

#[test]
fn a_server_answers_whatever_it_is_asked_and_ends_when_it_is_told_to() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    published(folder);
    let secret = folder.join("secret");
    std::fs::write(&secret, "not to be read").unwrap();
    std::fs::create_dir(folder.join("tiles")).unwrap();
    std::fs::write(folder.join("tiles/tileset.json"), "{}").unwrap();
    let mut server = Server::terrane(folder, &["www", "--tiles", "tiles", "--at-once", "4"]);
    assert!(server.get("/").contains("<title>Tiny</title>") && server.get("/planet.json").contains("etag"));
    assert!(server.get("/tiles/tileset.json").contains("access-control-allow-origin: *"));
    let manifest: Value = serde_json::from_slice(&std::fs::read(folder.join("www/planet.json")).unwrap()).unwrap();
    let recipe = manifest["recipe"]["object"].as_str().unwrap();
    let whole = server.get(&format!("/objects/{}/{recipe}", &recipe[..2]));
    assert!(whole.contains("immutable") && whole.contains("radius_m = 30000.0"), "{whole}");
    for path in [
        "/objects/../../secret",
        "/tiles/../secret",
        "/tiles/%2e%2e/secret",
        "/objects/..%2f..%2fsecret/x",
        "//secret",
        "/tiles//../../secret",
    ] {
        let answer = server.get(path);
        assert!(answer.starts_with("HTTP/1.1 4") && !answer.contains("not to be read"), "{path}: {answer}");
    }
    assert!(server
        .ask(b"POST /planet.json HTTP/1.1\r\nHost: a\r\nContent-Length: 0\r\nConnection: close\r\n\r\n")
        .starts_with("HTTP/1.1 405"));
    // Ten thousand questions, most of them nonsense, from several sides.
    let (answers, threads, each) = (AtomicUsize::new(0), 8, 1250);
    std::thread::scope(|scope| {
        for thread in 0..threads {
            let (server, answers) = (&server, &answers);
            scope.spawn(move || {
                let mut random = Random::new(thread);
                let mut below = |most: u64| random.bits() % most;
                for _ in 0..each {
                    let valid = format!(
                        "GET /objects/{}/{recipe} HTTP/1.1\r\nHost: a\r\nRange: bytes={}-{}\r\nConnection: close\r\n\r\n",
                        &recipe[..2],
                        below(9000),
                        below(9000)
                    );
                    let mut request = valid.into_bytes();
                    for _ in 0..below(8) {
                        let at = below(request.len() as u64) as usize;
                        match below(3) {
                            0 => request[at] = below(256) as u8,
                            1 => drop(request.drain(at..(at + below(40) as usize).min(request.len()))),
                            _ => request.splice(at..at, (0..below(200)).map(|_| b'/')).for_each(drop),
                        }
                        if request.is_empty() {
                            request.push(0);
                        }
                    }
                    answers.fetch_add(
                        usize::from(server.ask_within(&request, Duration::from_millis(60)).starts_with("HTTP/1.1 ")),
                        Ordering::Relaxed,
                    );
                }
            });
        }
    });
    assert!(answers.load(Ordering::Relaxed) > 2000, "{answers:?} of {} were understood", threads * each);
    let metrics = server.get("/metrics");
    assert!(
        metrics.contains("terrane_requests_total{status=\"2xx\"}")
            && metrics.contains("terrane_requests_total{status=\"5xx\"} 0"),
        "{metrics}"
    );
    let log = std::fs::read_to_string(folder.join("serve.log")).unwrap();
    assert!(!log.contains("panic"), "{log}");
    // SIGTERM ends it, though somebody keeps a connection open.
    let idle = TcpStream::connect(&server.host).unwrap();
    assert!(Command::new("kill").arg(server.child.id().to_string()).status().unwrap().success());
    let begun = Instant::now();
    let status = loop {
        if let Some(status) = server.child.try_wait().unwrap() {
            break status;
        }
        assert!(begun.elapsed() < Duration::from_secs(15), "it does not end");
        std::thread::sleep(Duration::from_millis(20));
    };
    assert!(status.success());
    drop(idle);
    // One that cannot listen says so.
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    let refused = terrane(folder, "served", &["serve", "www", "--addr", &address]);
    assert!(text(&refused.stderr).contains("cannot listen at"), "{}", text(&refused.stderr));
}
