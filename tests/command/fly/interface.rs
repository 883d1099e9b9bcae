//! The interface of a window: what is typed, clicked and dragged, and what it keeps.

use super::common::skipped;
use super::harness::{bake, display, end, terrane, Hand, Owned, Picture, Server, FRAMES, PATIENCE};
use glam::DVec3;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::Instant;
use tempfile::TempDir;
use terrane::stills::read_view;
use terrane_planet::draw::view::Camera;
use terrane_planet::draw::view_line::{Stand, ViewLine};
use terrane_planet::globe::sphere::direction_at;
use terrane_planet::recipe::shipped;

/// Size of the windows here: with room for the panel beside the middle.
const WINDOW: (f64, f64) = (640.0, 360.0);

/// A window over a small planet.
struct Session {
    folder: TempDir,
    planet: PathBuf,
    hand: Hand,
    flight: Owned,
    pictures: u32,
    _server: Server,
}

impl Session {
    /// Opens one under validation. None, and "skipped", where there is no X server.
    fn open(arguments: &[&str]) -> Option<Session> {
        let folder = tempfile::tempdir().unwrap();
        let planet = bake(folder.path());
        Session::over(folder, planet, arguments)
    }

    fn over(folder: TempDir, planet: PathBuf, arguments: &[&str]) -> Option<Session> {
        let Some((server, display)) = display() else {
            skipped(&"no Xvfb; apt install xvfb");
            return None;
        };
        if Hand::xdotool(&display, &["version"]).is_none() {
            skipped(&"no xdotool; apt install xdotool");
            return None;
        }
        let mut command = terrane(&["fly", "--validate", "--size", "640x360", "--stored-only", "--exposure", "1"]);
        command.args(arguments).arg("--screenshots").arg(folder.path()).arg(&planet).env("DISPLAY", &display);
        command.env("XDG_CONFIG_HOME", folder.path().join("config")).env("XDG_DATA_HOME", folder.path().join("data"));
        let mut flight = Owned(command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap());
        let hand = Hand::on(&display, &mut flight);
        let taken = (1..).take_while(|number| folder.path().join(format!("terrane-{number}.png")).exists()).count();
        let mut session = Session { folder, planet, hand, flight, pictures: taken as u32, _server: server };
        // The window is there when it has drawn.
        session.picture("p");
        Some(session)
    }

    /// Presses a key that saves a picture, and waits for it.
    fn picture(&mut self, key: &str) -> Picture {
        self.pictures += 1;
        self.hand.picture_by(key, &self.folder.path().join(format!("terrane-{}.png", self.pictures)))
    }

    /// A picture, once all is there that it shows: it does not change any more.
    fn settled(&mut self) -> Picture {
        let begun = Instant::now();
        let mut before = self.picture("p");
        loop {
            std::thread::sleep(2 * FRAMES);
            let picture = self.picture("p");
            // Waves go on from picture to picture, too small to be seen from here.
            if differences(&before, &picture, 0..640) == 0 {
                return picture;
            }
            assert!(begun.elapsed() < PATIENCE, "the picture does not settle");
            before = picture;
        }
    }

    /// Where the viewer is, once they have come to rest there.
    fn view(&mut self) -> ViewLine {
        let begun = Instant::now();
        let mut before: Option<ViewLine> = None;
        loop {
            self.picture("p");
            let file = std::fs::File::open(self.folder.path().join(format!("terrane-{}.png", self.pictures))).unwrap();
            let view: ViewLine = read_view(std::io::BufReader::new(file)).unwrap().unwrap().parse().unwrap();
            let view = ViewLine { time: None, ..view };
            if before.as_ref() == Some(&view) {
                return view;
            }
            assert!(begun.elapsed() < PATIENCE, "the viewer does not come to rest");
            before = Some(view);
        }
    }

    /// Goes to what is typed.
    fn go_to(&mut self, text: &str) -> ViewLine {
        self.hand.key("g");
        self.hand.does(&["type", "--", text]);
        self.hand.key("Return");
        self.view()
    }

    fn close(self) -> TempDir {
        self.hand.does(&["key", "Escape"]);
        let Session { folder, flight, .. } = self;
        let (code, _, stderr) = end(flight);
        assert_eq!((code, stderr.as_str()), (Some(0), ""));
        folder
    }
}

/// Metres of a view's camera above the datum; what it says above the ground is not needed here.
fn height(view: &ViewLine) -> f64 {
    match view.stand {
        Stand::Height(metres) => metres,
        Stand::Altitude(_) => panic!("windows say heights: {view}"),
    }
}

fn radius() -> f64 {
    shipped::load("tiny").unwrap().radius
}

fn camera(view: &ViewLine) -> Camera {
    let position = direction_at(view.at[0], view.at[1]) * (radius() + height(view));
    let [heading, pitch] = view.look.unwrap();
    Camera::looking(position, heading, pitch, view.fov.unwrap().to_radians(), [WINDOW.0 as u32, WINDOW.1 as u32])
}

/// Where a ball as large as the planet is under a pixel.
fn ball_at(view: &ViewLine, [x, y]: [f64; 2]) -> DVec3 {
    let camera = camera(view);
    let (h, v) = camera.half_extents();
    let ray = camera.forward + camera.right() * (h * (2.0 * x / WINDOW.0 - 1.0)) + camera.up * (v * (1.0 - 2.0 * y / WINDOW.1));
    let ray = ray.normalize();
    let along = -camera.position.dot(ray);
    let inside = along * along - (camera.position.length_squared() - radius() * radius());
    camera.position + ray * (along - inside.sqrt())
}

/// Pixels between the places at which two points are seen.
fn pixels_apart(view: &ViewLine, a: DVec3, b: DVec3) -> f64 {
    let camera = camera(view);
    let pixel_angle = 2.0 * camera.half_extents().1 / WINDOW.1;
    (a - camera.position).angle_between(b - camera.position) / pixel_angle
}

fn differences(a: &Picture, b: &Picture, columns: std::ops::Range<u32>) -> usize {
    let differ = |x: u32, y: u32| a.brightness(x, y).abs_diff(b.brightness(x, y)) > 6;
    (0..a.size.1).flat_map(|y| columns.clone().map(move |x| (x, y))).filter(|(x, y)| differ(*x, *y)).count()
}

#[test]
fn ground_stays_under_the_cursor_that_drags_it() {
    let Some(mut session) = Session::open(&[]) else { return };
    let before = session.view();
    let (from, to) = ([300.0, 150.0], [352.0, 196.0]);
    session.hand.does(&["mousemove", "300", "150", "mousedown", "1"]);
    for at in [["310", "160"], ["325", "170"], ["340", "188"], ["352", "196"]] {
        session.hand.does(&["mousemove", at[0], at[1]]);
        std::thread::sleep(FRAMES / 4);
    }
    std::thread::sleep(FRAMES);
    session.hand.does(&["mouseup", "1"]);
    let after = session.view();
    assert_ne!(after.at, before.at);
    let off = pixels_apart(&after, ball_at(&before, from), ball_at(&after, to));
    println!("{off:.3} pixels off");
    assert!(off < 1.5, "the ground is {off} pixels away from the cursor");
    let control = pixels_apart(&after, ball_at(&before, from), ball_at(&after, from));
    assert!(control > 20.0, "the check sees nothing: {control}");
    session.close();
}

#[test]
fn one_goes_where_one_types_or_clicks_and_back() {
    let Some(mut session) = Session::open(&[]) else { return };
    let home = session.view();
    let there = session.go_to("10 20 9 km");
    assert!((there.at[0] - 10.0).abs() < 1e-6 && (there.at[1] - 20.0).abs() < 1e-6, "{there}");
    assert!((8e3..12e3).contains(&height(&there)), "{there}");
    // What is typed into the line moves and switches nothing.
    session.hand.key("g");
    session.hand.does(&["type", "--", "wasd 3"]);
    session.hand.key("Return");
    session.hand.key("Escape");
    assert_eq!(session.view(), there);

    session.hand.does(&["mousemove", "320", "240", "click", "--repeat", "2", "--delay", "60", "1"]);
    std::thread::sleep(FRAMES);
    let nearer = session.view();
    let clicked = ball_at(&there, [320.0, 240.0]);
    let distance = |view: &ViewLine| camera(view).position.distance(clicked);
    assert!(distance(&nearer) < 0.4 * distance(&there), "{} m, from {} m", distance(&nearer), distance(&there));

    session.hand.key("alt+Left");
    assert_eq!(session.view(), there);
    session.hand.key("alt+Right");
    assert_eq!(session.view(), nearer);
    session.hand.key("Home");
    assert_eq!(session.view(), home);
    session.close();
}

#[test]
fn the_panel_leaves_the_middle_free_and_hides_and_is_as_it_was_in_the_next_window() {
    let Some(mut session) = Session::open(&[]) else { return };
    session.hand.key("F2");
    std::thread::sleep(FRAMES);
    let (window, picture) = (session.picture("shift+p"), session.picture("p"));
    let [panel, middle] = [0..300, 310..640].map(|columns| differences(&window, &picture, columns));
    assert!(panel > 20_000, "the panel covers {panel} pixels");
    // What was saved last is said in the middle below.
    assert!(middle < 6_000, "{middle} pixels beside the panel are not the picture's");
    session.hand.key("F1");
    let help = session.picture("shift+p");
    assert!(differences(&help, &picture, 310..640) > 20_000, "the help is not there");
    session.hand.key("Escape");
    session.hand.key("F3");
    let hidden = session.picture("shift+p");
    assert!(differences(&hidden, &picture, 0..300) < 3_000, "the interface does not hide");
    session.hand.key("F3");
    let planet = session.planet.clone();
    let folder = session.close();
    let settings = std::fs::read_to_string(folder.path().join("config/terrane/window.toml")).unwrap();
    assert!(settings.contains("panel = true"), "{settings}");
    let mut again = Session::over(folder, planet, &[]).unwrap();
    let (window, picture) = (again.picture("shift+p"), again.picture("p"));
    assert!(differences(&window, &picture, 0..300) > 20_000, "the next window has no panel");
    again.close();
}

#[test]
fn a_view_is_remembered_as_a_picture_and_a_path_is_made_and_played() {
    let Some(mut session) = Session::open(&["--at", "10,20,9000"]) else { return };
    let here = session.view();
    session.hand.key("b");
    let shelf = session.folder.path().join("data/terrane/views");
    let begun = Instant::now();
    let kept = loop {
        if let Some(entry) = std::fs::read_dir(&shelf).ok().and_then(|mut entries| entries.next()) {
            break entry.unwrap().path();
        }
        assert!(begun.elapsed() < PATIENCE, "nothing is remembered");
        std::thread::sleep(FRAMES / 10);
    };
    std::thread::sleep(FRAMES);
    let remembered: ViewLine =
        read_view(std::io::BufReader::new(std::fs::File::open(&kept).unwrap())).unwrap().unwrap().parse().unwrap();
    assert_eq!(ViewLine { time: None, ..remembered }, here);

    session.hand.key("r");
    let there = session.go_to("12 24 7 km");
    session.hand.key("r");
    session.hand.key("Home");
    session.view();
    session.hand.key("Return");
    // Its frames are told apart from standing still by where they are.
    std::thread::sleep(3 * FRAMES);
    let end = session.view();
    assert!((end.at[1] - there.at[1]).abs() < 1e-3 && (height(&end) - height(&there)).abs() < 5.0, "{end}\n{there}");
    session.close();
}

/// How many edits a planet file has.
fn edits(planet: &Path) -> usize {
    let output = terrane(&["edit"]).arg(planet).args(["list", "--json"]).output().unwrap();
    let listed: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    listed["edits"].as_array().unwrap().len()
}

fn wait_for_edits(planet: &Path, number: usize) {
    let begun = Instant::now();
    while edits(planet) != number {
        assert!(begun.elapsed() < PATIENCE, "{} edits, expected {number}", edits(planet));
        std::thread::sleep(FRAMES / 4);
    }
}

/// Saves pictures until one is as it should be.
fn wait_for_picture(session: &mut Session, what: &str, is: impl Fn(&Picture) -> bool) {
    let begun = Instant::now();
    while !is(&session.picture("p")) {
        assert!(begun.elapsed() < PATIENCE, "the ground does not look {what}");
        std::thread::sleep(FRAMES);
    }
}

#[test]
fn a_click_with_the_tool_digs_and_undo_fills_in() {
    let Some(mut session) = Session::open(&["--at", "10,20,9000", "--clear-sky"]) else { return };
    let planet = session.planet.clone();
    let before = session.settled();
    session.hand.does(&["mousemove", "330", "230"]);
    session.hand.key("x");
    session.hand.does(&["click", "1"]);
    wait_for_edits(&planet, 1);
    wait_for_picture(&mut session, "dug", |picture| differences(&before, picture, 0..640) > 20);
    session.hand.key("ctrl+z");
    wait_for_edits(&planet, 0);
    wait_for_picture(&mut session, "as before", |picture| differences(&before, picture, 0..640) < 20);
    session.hand.key("ctrl+y");
    wait_for_edits(&planet, 1);
    session.close();
}

#[test]
fn a_planet_that_another_program_edits_is_read_anew_and_the_viewer_stays() {
    let Some(mut session) = Session::open(&["--at", "10,20,9000", "--look", "0,-90", "--clear-sky", "--no-sea"]) else { return };
    let (planet, before) = (session.planet.clone(), session.settled());
    let mut edit = terrane(&["edit"]);
    edit.arg(&planet).args(["crater", "--at", "10,20", "--radius", "3000", "--depth", "900"]);
    assert!(edit.status().unwrap().success());
    // What was not there yet is read there.
    let there = session.go_to("-40 -120 9 km");
    assert!((there.at[0] + 40.0).abs() < 1e-6, "{there}");
    session.hand.key("Home");
    wait_for_picture(&mut session, "dug", |picture| differences(&before, picture, 0..640) > 1000);
    session.close();
}

#[test]
fn keys_are_the_users_own_and_a_file_of_them_that_cannot_be_meant_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let with_config = |arguments: &[&str]| {
        let mut command = terrane(arguments);
        command.env("XDG_CONFIG_HOME", folder.path()).env_remove("DISPLAY");
        command.output().unwrap()
    };
    let usual = String::from_utf8(with_config(&["fly", "--keys"]).stdout).unwrap();
    assert!(usual.lines().any(|line| line.starts_with("freeze = [\"Z\"]")), "{usual}");
    std::fs::create_dir_all(folder.path().join("terrane")).unwrap();
    let file = folder.path().join("terrane/keys.toml");
    std::fs::write(&file, usual.replace("freeze = [\"Z\"]", "freeze = [\"F9\", \"Ctrl+F\"]")).unwrap();
    let changed = String::from_utf8(with_config(&["fly", "--keys"]).stdout).unwrap();
    assert!(changed.contains("freeze = [\"F9\", \"Ctrl+F\"]"), "{changed}");
    std::fs::write(&file, "frieze = [\"Z\"]").unwrap();
    let refused = with_config(&["fly"]);
    let message = String::from_utf8(refused.stderr).unwrap();
    assert_eq!(refused.status.code(), Some(1), "{message}");
    assert!(message.contains("keys.toml") && message.contains("'frieze' is nothing that keys do"), "{message}");
}

#[test]
fn a_window_whose_device_is_lost_goes_on_where_it_was() {
    let Some((_server, display)) = display() else { return skipped(&"no Xvfb; apt install xvfb") };
    if Hand::xdotool(&display, &["version"]).is_none() {
        return skipped(&"no xdotool; apt install xdotool");
    }
    let folder = tempfile::tempdir().unwrap();
    let planet = bake(folder.path());
    let mut command =
        terrane(&["fly", "--validate", "--size", "320x240", "--stored-only", "--at", "10,20,9000", "--screenshots"]);
    command.arg(folder.path()).arg(&planet).env("DISPLAY", &display).env("TERRANE_LOSE_DEVICE", "4");
    let mut flight = Owned(command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap());
    let hand = Hand::on(&display, &mut flight);
    // Each mode is a frame: one of them is the fifth.
    for key in ["2", "3", "4", "5", "6", "3"] {
        hand.key(key);
    }
    let picture = folder.path().join("terrane-1.png");
    hand.picture(&picture);
    let view: ViewLine =
        read_view(std::io::BufReader::new(std::fs::File::open(&picture).unwrap())).unwrap().unwrap().parse().unwrap();
    hand.key("Escape");
    let (code, _, stderr) = end(flight);
    assert_eq!(code, Some(0), "{stderr}");
    assert!(stderr.contains("the GPU was lost") && stderr.contains("it is used anew") && stderr.lines().count() == 1, "{stderr}");
    assert_eq!((view.at, view.mode.map(|mode| mode.name())), ([10.0, 20.0], Some("levels")));
}
