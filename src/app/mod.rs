//! Flying over a planet in a window.
//!
//! In: a planet file, where to begin, and a [`Host`] that saves, copies and finds what is asked for. Out: a window until it is closed, then a
//! [`FlyReport`]. Events come in here; `flight` draws, `viewer` moves, `keys` says which key does what, `orders` does it.

mod asking;
mod calendar;
mod choices;
mod chord;
mod destination;
mod earthwork;
mod facts;
mod flight;
mod fly_camera;
mod history;
mod host;
mod inspection;
mod interface;
mod journey;
mod keys;
mod ledger;
mod orbit_camera;
mod orders;
mod outlines;
mod pacing;
mod panel;
mod playback;
mod pose;
mod recovery;
#[cfg(feature = "hot-reload")]
mod reload;
mod reopening;
mod screenshots;
mod snapshot;
mod storyboard;
mod surface;
mod view_line;
mod viewer;
mod walk_camera;

pub use host::{Bookmark, Host, Opened, Picture, Settings};
pub use keys::{Keys, KeysError};
pub use pacing::{Scale, DENSITIES};
pub use playback::FlyFrame;

use crate::frame::Look;
use crate::scene::{SceneError, SceneOptions};
use crate::vulkan::{ContextOptions, GpuChoice, ValidationMessage, VulkanError};
use flight::Flight;
use keys::Command;
use pacing::Due;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};
use surface::DrawnSurface;
use terrane_planet::draw::camera_path::CameraPath;
use terrane_planet::draw::view::Camera;
use terrane_planet::draw::view_line::ViewLine;
use thiserror::Error;
use viewer::{Button, Manner};
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{ElementState, KeyEvent, MouseButton, MouseScrollDelta, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop};
use winit::keyboard::{Key, ModifiersState};
use winit::window::{Window, WindowId};

/// How long to wait before another try when a window has nothing to draw to.
const RETRY: Duration = Duration::from_millis(30);
/// How often to ask the host for news that it expects.
const LOOK_FOR_NEWS: Duration = Duration::from_millis(500);
/// Pixels of smooth scrolling that make one notch of a wheel.
const PIXELS_PER_NOTCH: f64 = 40.0;

/// Why a flight cannot start or go on.
#[derive(Debug, Error)]
pub enum AppError {
    /// Nowhere to open a window.
    #[error("no window system: {tried}; {reason}. Start it in a desktop session, or make pictures and films without a window with `terrane shot` and `terrane record`")]
    NoWindowSystem {
        /// What was looked at, and what was there.
        tried: String,
        /// What the window library said.
        reason: String,
    },
    /// The window system refuses.
    #[error(
        "cannot open a window: {reason}; pictures and films without a window are made with `terrane shot` and `terrane record`"
    )]
    Window {
        /// What the window library said.
        reason: String,
    },
    /// The planet file, or the GPU while loading from it.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The GPU.
    #[error(transparent)]
    Vulkan(#[from] VulkanError),
}

/// How to fly.
pub struct FlyOptions {
    /// Planet file.
    pub file: PathBuf,
    /// GPU and validation.
    pub context: ContextOptions,
    /// Where to begin; its size is the window's.
    pub camera: Camera,
    /// Mode, sun and exposure to begin with.
    pub look: Look,
    /// Largest error of the mesh in pixels.
    pub tolerance: f64,
    /// Whether vertices slide into their positions.
    pub geomorphs: bool,
    /// Whether errors count as they are seen, see [`terrane_planet::draw::orientation`].
    pub orientation: bool,
    /// How many pixels are drawn; as many as keep software renderers at ten frames a second, if `None`, and all on others.
    pub scale: Option<Scale>,
    /// Most frames a second; those of the screen if `None`.
    pub most_fps: Option<f64>,
    /// Which key does what.
    pub keys: Keys,
    /// A path to play from the beginning.
    pub path: Option<CameraPath>,
    /// Standing for so long at the path's end closes the window, and the frames until then are reported.
    pub stand: Option<Duration>,
    /// What the scene may use and build.
    pub scene: SceneOptions,
    /// What is known of the view beside camera and look: planet, spacing and so on; and for how many seconds waves have run.
    pub view: ViewLine,
    /// What the user chose before.
    pub settings: Settings,
    /// Shaders to draw with in place of those that the program was built with, as they are edited.
    #[cfg(feature = "hot-reload")]
    pub shaders: Option<crate::hot_reload::ShaderWatch>,
    /// Files, the clipboard, other planets.
    pub host: Box<dyn Host>,
}

/// What a flight was.
#[derive(Debug, Default)]
pub struct FlyReport {
    /// Frames drawn after the first.
    pub frames: u64,
    /// Seconds since the first frame.
    pub seconds: f64,
    /// Each of them, where that was asked for.
    pub rows: Vec<FlyFrame>,
    /// Everything that validation said, to the very end.
    pub messages: Vec<ValidationMessage>,
}

/// Opens a window and flies until it is closed. Validation's messages come with the result, or with the error if it ends in one.
///
/// # Errors
/// No window system, no usable GPU, a damaged planet file, or device loss.
pub fn fly(options: FlyOptions) -> (FlyReport, Result<(), AppError>) {
    let mut app = App {
        options,
        flight: None,
        report: FlyReport::default(),
        error: None,
        hidden: false,
        retry_at: None,
        begun: None,
        recovered: None,
        read_at: None,
        modifiers: ModifiersState::empty(),
    };
    let ended = EventLoop::new().map_err(|error| no_window_system(&error)).and_then(|events| {
        let ended = events.run_app(&mut app);
        ended.map_err(|error| AppError::Window { reason: error.to_string() })
    });
    (app.report, app.error.map_or(ended, Err))
}

fn no_window_system(error: &impl std::fmt::Display) -> AppError {
    let found = |name: &str| match std::env::var_os(name).filter(|value| !value.is_empty()) {
        Some(value) => format!("{name} is '{}'", value.to_string_lossy()),
        None => format!("{name} is not set"),
    };
    let tried = ["WAYLAND_DISPLAY", "DISPLAY"].map(found).join(", ");
    AppError::NoWindowSystem { tried, reason: error.to_string().trim_end_matches('.').to_owned() }
}

struct App {
    options: FlyOptions,
    flight: Option<Flight>,
    report: FlyReport,
    error: Option<AppError>,
    /// Whether nothing of the window can be seen.
    hidden: bool,
    /// Set while the window has nothing to draw to.
    retry_at: Option<Instant>,
    /// What was chosen when the window opened.
    begun: Option<Settings>,
    /// When a lost device was last used anew.
    recovered: Option<Instant>,
    /// When the planet file was last read anew, because another program had edited it.
    read_at: Option<Instant>,
    /// Keys that are held beside others.
    modifiers: ModifiersState,
}

impl App {
    fn open(&self, events: &ActiveEventLoop) -> Result<Flight, AppError> {
        let [width, height] = self.options.camera.size;
        let attributes = Window::default_attributes()
            .with_title(format!("Terrane: {}", self.options.file.display()))
            .with_inner_size(PhysicalSize::new(width, height))
            .with_min_inner_size(PhysicalSize::new(64, 64));
        let window = events.create_window(attributes).map_err(|error| AppError::Window { reason: error.to_string() })?;
        let flight = Flight::new(Arc::new(window), &self.options)?;
        if self.options.context.gpu == GpuChoice::Auto {
            flight.warn_of_software();
        }
        Ok(flight)
    }

    fn fail(&mut self, events: &ActiveEventLoop, error: AppError) {
        self.error = Some(error);
        events.exit();
    }

    fn redraw(&mut self, events: &ActiveEventLoop) {
        let Some(flight) = &mut self.flight else { return };
        match flight.draw(self.options.host.as_mut()) {
            Ok(drawn) => self.retry_at = (!drawn).then(|| Instant::now() + RETRY),
            Err(error) => return self.recover(events, error),
        }
        for text in flight.copied.drain(..) {
            self.options.host.copy(&text);
        }
        let asked = std::mem::take(&mut flight.asked);
        self.ask_host(&asked);
        for command in asked.commands {
            self.obey(events, command);
        }
    }

    fn obey(&mut self, events: &ActiveEventLoop, command: Command) {
        let Some(flight) = &mut self.flight else { return };
        match command {
            Command::Quit if flight.panel.close() => flight.touch_interface(),
            Command::Quit => events.exit(),
            Command::CopyView => {
                let said = self.options.host.copy(&flight.view_line().to_string());
                flight.panel.say(said);
                flight.touch_interface();
            }
            _ => flight.obey(command),
        }
    }

    fn key(&mut self, events: &ActiveEventLoop, event: &KeyEvent) {
        let Some(flight) = &mut self.flight else { return };
        let down = event.state == ElementState::Pressed;
        let combined = self.modifiers.intersects(ModifiersState::CONTROL | ModifiersState::ALT | ModifiersState::SUPER);
        flight.viewer.held.set(event.physical_key, down && !combined);
        flight.touch_interface();
        let moves = flight.viewer.manner() != Manner::Orbit;
        let keys = &flight.viewer.keys;
        let command = keys.command(event.physical_key, &event.logical_key, self.modifiers, moves).filter(|_| down);
        // Holding a key repeats only what is gradual.
        let repeats = matches!(command, Some(Command::Sun(_) | Command::Zoom(_)));
        if let Some(command) = command.filter(|_| repeats || !event.repeat) {
            self.obey(events, command);
        }
    }

    fn mouse(&mut self, event: &WindowEvent) {
        let Some(flight) = &mut self.flight else { return };
        if let WindowEvent::MouseInput { state, button: MouseButton::Left, .. } = event {
            flight.work_ground(*state == ElementState::Pressed);
        }
        if matches!(event, WindowEvent::MouseInput { .. } | WindowEvent::MouseWheel { .. }) {
            flight.stop_playing();
        }
        let (now, surface) = (Instant::now(), &DrawnSurface::of_scene(&flight.scene, flight.choices.look.sea));
        match event {
            WindowEvent::CursorMoved { position, .. } => flight.viewer.point([position.x, position.y], now, surface),
            WindowEvent::MouseInput { state, button, .. } => {
                let button = match button {
                    MouseButton::Left => Button::Left,
                    MouseButton::Right | MouseButton::Middle => Button::Right,
                    _ => return,
                };
                flight.viewer.press(button, *state == ElementState::Pressed, now, surface);
            }
            WindowEvent::MouseWheel { delta, .. } => flight.viewer.wheel(match delta {
                MouseScrollDelta::LineDelta(_, lines) => f64::from(*lines),
                MouseScrollDelta::PixelDelta(pixels) => pixels.y / PIXELS_PER_NOTCH,
            }),
            _ => {}
        }
    }
}

/// Whether an event is Ctrl+V going down.
fn is_paste(event: &WindowEvent, held: ModifiersState) -> bool {
    let WindowEvent::KeyboardInput { event, .. } = event else { return false };
    let v = matches!(&event.logical_key, Key::Character(text) if text.eq_ignore_ascii_case("v"));
    v && held.control_key() && event.state == ElementState::Pressed
}

impl ApplicationHandler for App {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.flight.is_some() {
            return;
        }
        match self.open(events) {
            Ok(mut flight) => {
                let host = &mut self.options.host;
                flight.panel.set_bookmarks(host.bookmarks());
                flight.panel.planets = host.planets();
                flight.panel.recent = self.options.settings.recent.clone();
                self.begun = Some(flight.settings());
                self.flight = Some(flight);
            }
            Err(error) => self.fail(events, error),
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        if event != WindowEvent::RedrawRequested {
            if let Some(flight) = &mut self.flight {
                flight.touch_interface();
                // A key may be let go of while text is typed.
                if let WindowEvent::KeyboardInput {
                    event: KeyEvent { physical_key, state: ElementState::Released, .. }, ..
                } = &event
                {
                    flight.viewer.held.set(*physical_key, false);
                }
                let pasted = flight.interface.is_typing() && is_paste(&event, self.modifiers);
                if pasted {
                    self.options.host.paste().into_iter().for_each(|text| flight.interface.paste(text));
                }
                if pasted || flight.interface.takes(&event) {
                    return;
                }
            }
        }
        match &event {
            WindowEvent::CloseRequested => events.exit(),
            WindowEvent::RedrawRequested => self.redraw(events),
            WindowEvent::Occluded(hidden) => self.hidden = *hidden,
            WindowEvent::KeyboardInput { event, .. } => self.key(events, event),
            WindowEvent::DroppedFile(path) => self.open_other(&path.to_string_lossy()),
            WindowEvent::ModifiersChanged(modifiers) => self.modifiers = modifiers.state(),
            WindowEvent::Resized(size) => {
                if let Some(flight) = &mut self.flight {
                    flight.resize(size.width, size.height);
                    flight.touch();
                }
            }
            WindowEvent::Focused(false) => {
                if let Some(flight) = &mut self.flight {
                    flight.viewer.let_go();
                }
            }
            _ => self.mouse(&event),
        }
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        let Some(flight) = &mut self.flight else { return };
        let now = Instant::now();
        if let Some(news) = self.options.host.news() {
            flight.panel.say(news);
            flight.touch_interface();
        }
        #[cfg(feature = "hot-reload")]
        self.options.shaders.iter().for_each(|watch| flight.follow_shaders(watch));
        if flight.closes().is_some_and(|at| at <= now) {
            return events.exit();
        }
        if self.read_anew(events, now) {
            return;
        }
        let Some(flight) = &mut self.flight else { return };
        if let Err(error) = flight.take_in(now) {
            return self.recover(events, error);
        }
        let Some(flight) = &mut self.flight else { return };
        let due = match self.retry_at {
            _ if self.hidden => Due::Never,
            Some(at) if now < at => Due::At(at),
            Some(_) => Due::Now,
            None => flight.due(now),
        };
        if due == Due::Now {
            flight.window.request_redraw();
        }
        let news = self.options.host.expects_news().then(|| now + LOOK_FOR_NEWS);
        #[cfg(feature = "hot-reload")]
        let news = news.or(self.options.shaders.as_ref().map(|_| now + LOOK_FOR_NEWS));
        let wake = [if let Due::At(at) = due { Some(at) } else { None }, flight.closes(), news].into_iter().flatten().min();
        events.set_control_flow(wake.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
    }

    fn exiting(&mut self, _: &ActiveEventLoop) {
        let Some(mut flight) = self.flight.take() else { return };
        let log = flight.context.message_log();
        (self.report.frames, self.report.seconds) = flight.pace();
        self.report.rows = flight.rows();
        if let (Some(begun), None) = (&self.begun, self.options.stand) {
            let settings = self.options.settings.clone().with_changes(begun, &flight.settings());
            if let Err(problem) = self.options.host.keep(&settings) {
                tracing::warn!("{problem}");
            }
        }
        drop(flight);
        self.report.messages.extend(log.all());
    }
}
