//! A flight: the window with everything that is drawn in it. One call of [`Flight::draw`] is one frame.

use super::keys::{next_mode, Command};
use super::ledger::Ledger;
use super::overlay::{Overlay, Status};
use super::pacing::{Due, Motives, Pacing, Scale};
use super::playback::{FlyFrame, Playback};
use super::pose::Pose;
use super::surface::DrawnSurface;
use super::viewer::Viewer;
use super::{view_line, AppError, FlyOptions, SaveScreenshot};
use crate::frame::{FrameTables, Look, Overlay as OverlayStage, Renderer};
use crate::scene::{uploads_within, Scene, SceneOptions, Scope};
use crate::vulkan::{capture, vk, Access, Commands, Context, GpuKind, Image, ImageDescription, Swapchain};
use glam::DQuat;
use std::sync::Arc;
use std::time::Instant;
use terrane_planet::draw::layout::{EmitState, Mode};
use terrane_planet::draw::view::View;
use terrane_planet::draw::view_line::ViewLine;
use terrane_planet::maps::waves::CASCADES;
use winit::window::Window;

/// Longest time in seconds that one frame moves the viewer on by, however long it took.
const LONGEST_FRAME: f64 = 0.25;
/// Radians that the sun moves along its daily course with each key press.
const SUN_STEP: f64 = 0.05;
/// Seconds in which exposure goes most of the way to its goal.
const ADAPTATION_SECONDS: f64 = 0.6;
/// Milliseconds that a moving frame may take on a software renderer unless told otherwise: ten frames a second, and some room.
const SOFTWARE_MS: f64 = 80.0;
/// Frames after which a path begins to be played.
const FIRST_FRAMES: u64 = 2;
/// Frames a second where the screen does not say how many it shows.
const USUAL_FPS: f64 = 60.0;
/// Windows at least this wide have text of twice the size.
const WIDE: u32 = 1000;

/// Whether the selection follows the viewer.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Selection {
    Follows,
    /// The next frame emits the whole mesh once more, without culling, to be seen from all sides.
    Freezes,
    Frozen,
}

/// Everything that a window needs.
pub(super) struct Flight {
    pub(super) viewer: Viewer,
    pub(super) overlay: Overlay,
    pub(super) scene: Scene,
    pub(super) window: Arc<Window>,
    context: Arc<Context>,
    swapchain: Swapchain,
    renderer: Renderer,
    stage: OverlayStage,
    look: Look,
    /// The view as text, as far as nothing changes it.
    line: ViewLine,
    tolerance: f64,
    geomorphs: bool,
    orientation: bool,
    /// Of the latest frame; while frozen, of the frame that stays.
    tables: Option<FrameTables>,
    selection: Selection,
    /// Patches that this frame may take in.
    uploads: usize,
    screenshot_wanted: bool,
    pacing: Pacing,
    ledger: Ledger,
    playback: Option<Playback>,
    /// Whether every frame gets a row in the report.
    reports: bool,
    density: f64,
    /// Where the viewer was in the latest frame.
    latest_pose: Option<Pose>,
    /// Whether they moved in the latest frame.
    moving: bool,
    counters: EmitState,
    begun: Option<Instant>,
    latest: Instant,
    frames: u64,
}

impl Flight {
    pub(super) fn new(window: Arc<Window>, options: &FlyOptions) -> Result<Flight, AppError> {
        let (context, surface) = Context::with_window(&options.context, window.clone())?;
        let scene = Scene::open(&context, &options.file, SceneOptions { scope: Scope::Flight, ..options.scene.clone() })?;
        let size = window.inner_size();
        let swapchain = Swapchain::new(&context, surface, (size.width, size.height), false)?;
        let format = swapchain.format();
        let software = context.device_info().kind == GpuKind::Cpu;
        let scale = options.scale.unwrap_or(Scale::Within(if software { SOFTWARE_MS } else { f64::INFINITY }));
        let shown = window.current_monitor().and_then(|monitor| monitor.refresh_rate_millihertz());
        let most_fps = options.most_fps.unwrap_or(shown.map_or(USUAL_FPS, |millihertz| f64::from(millihertz) * 1e-3));
        let mut renderer = Renderer::new(&context, (options.camera.size[0], options.camera.size[1]), format)?;
        renderer.time = options.view.time.unwrap_or(0.0);
        Ok(Flight {
            viewer: Viewer::new(&options.camera),
            overlay: Overlay::default(),
            scene,
            window,
            renderer,
            stage: OverlayStage::new(&context, format)?,
            context,
            swapchain,
            look: options.look,
            line: options.view.clone(),
            tolerance: options.tolerance,
            geomorphs: options.geomorphs,
            orientation: options.orientation,
            tables: None,
            selection: Selection::Follows,
            uploads: uploads_within(0.0),
            screenshot_wanted: false,
            pacing: Pacing::new(scale, most_fps),
            ledger: Ledger::default(),
            playback: options.path.clone().map(|path| Playback::new(path, options.stand)),
            reports: options.stand.is_some(),
            density: 1.0,
            latest_pose: None,
            moving: false,
            counters: EmitState::default(),
            begun: None,
            latest: Instant::now(),
            frames: 0,
        })
    }

    pub(super) fn context(&self) -> &Arc<Context> {
        &self.context
    }

    /// Frames drawn, and the seconds since the first.
    pub(super) fn pace(&self) -> (u64, f64) {
        (self.frames, self.begun.map_or(0.0, |begun| begun.elapsed().as_secs_f64()))
    }

    /// The frames drawn, where they are reported.
    pub(super) fn rows(&mut self) -> Vec<FlyFrame> {
        std::mem::take(&mut self.ledger.rows)
    }

    /// Something happened to the window.
    pub(super) fn touch(&mut self) {
        self.pacing.touch(Instant::now());
    }

    /// When the window closes by itself.
    pub(super) fn closes(&self) -> Option<Instant> {
        self.playback.as_ref()?.closes()
    }

    /// When the next frame is due.
    pub(super) fn due(&self, now: Instant) -> Due {
        let plays = self.playback.as_ref().is_some_and(|playback| playback.is_moving(now));
        let motives = Motives {
            moving: self.viewer.is_moving() || plays || self.has_waves() || self.latest_pose != Some(self.viewer.pose),
            arrived: self.selection == Selection::Follows && self.scene.has_arrived(),
            pending: self.selection == Selection::Follows && self.scene.pending() > 0,
            metered: self.look.metering.is_some(),
            until: self.overlay.vanishes(),
        };
        self.pacing.due(now, &motives)
    }

    /// Whether the sea moves where the viewer can see it. On software renderers it only does while they move themselves.
    fn has_waves(&self) -> bool {
        let sees = self.scene.planet().recipe.sea.is_some() && self.look.mode == Mode::Shaded;
        let pixel = self.viewer.pose.camera(&self.viewer.lens).pixel_angle();
        let longest = CASCADES[0].wavelengths[0];
        !self.software() && sees && self.viewer.altitude(&DrawnSurface::of_scene(&self.scene)) * pixel < longest
    }

    fn software(&self) -> bool {
        self.context.device_info().kind == GpuKind::Cpu
    }

    pub(super) fn resize(&mut self, width: u32, height: u32) {
        self.swapchain.resize(width, height);
    }

    /// Does what a key asks for, other than ending and what goes to the user.
    pub(super) fn obey(&mut self, command: Command) {
        match command {
            Command::Quit | Command::CopyView => {}
            Command::Help => self.overlay.help = !self.overlay.help,
            Command::SwitchCamera => self.viewer.switch_camera(),
            Command::Show(mode) => self.look.mode = mode,
            Command::ShowNext => self.look.mode = next_mode(self.look.mode),
            Command::Toggle(mode) => self.look.mode = if self.look.mode == mode { Mode::Shaded } else { mode },
            Command::Geomorphs => self.geomorphs = !self.geomorphs,
            Command::Freeze if self.selection == Selection::Follows => self.selection = Selection::Freezes,
            Command::Freeze => self.selection = Selection::Follows,
            Command::Screenshot => self.screenshot_wanted = true,
            Command::Clouds => self.look.clouds = !self.look.clouds,
            Command::Sun(steps) => self.look.sun = DQuat::from_rotation_z(-SUN_STEP * steps) * self.look.sun,
            Command::Zoom(notches) => self.viewer.wheel(notches),
        }
    }

    /// Draws a frame. False if there was nothing to draw to: try again a little later.
    pub(super) fn draw(&mut self, save: &mut SaveScreenshot) -> Result<bool, AppError> {
        let Some(mut frame) = self.swapchain.acquire()? else { return Ok(false) };
        let (now, slot) = (Instant::now(), frame.slot());
        if let Some(times) = &frame.timestamps {
            self.counters = self.renderer.earlier_counters()?;
            if let Some(cost) = self.ledger.settle(slot, times, now) {
                self.pacing.learn(cost);
            }
        }
        self.pacing.begin(now);
        let (width, height) = frame.target.size();
        self.viewer.lens.size = [width, height];
        self.renderer.resize((width, height))?;
        let seconds = self.pass_time(now);
        let commands = &mut frame.commands;
        self.record_mesh(commands, now, seconds)?;
        self.renderer.record_picture(commands, &self.scene, &self.look, &frame.target)?;
        let text = self.text();
        let scale = (self.window.scale_factor() * if width >= WIDE { 2.0 } else { 1.0 }).round().max(1.0);
        self.stage.record(commands, &frame.target, &text, scale as u32)?;
        commands.ready(&[frame.target.to(Access::Present)])?;
        let row = self.reports.then(|| self.row(now));
        self.ledger.send(slot, now, self.context.allocations(), row, self.density);
        self.window.pre_present_notify();
        self.swapchain.present(frame)?;
        if std::mem::take(&mut self.screenshot_wanted) {
            self.save_screenshot((width, height), save)?;
        }
        Ok(true)
    }

    /// Counts a frame. Returns the seconds by which it moves the viewer on.
    fn pass_time(&mut self, now: Instant) -> f64 {
        let seconds = now.duration_since(std::mem::replace(&mut self.latest, now)).as_secs_f64();
        if self.begun.is_some() {
            self.frames += 1;
            self.overlay.count_frame(seconds);
        } else {
            self.begun = Some(now);
        }
        if let Some(share) = &mut self.look.metering {
            *share = (1.0 - (-seconds / ADAPTATION_SECONDS).exp()) as f32;
        }
        self.uploads = uploads_within(seconds);
        self.renderer.time += seconds;
        seconds.min(LONGEST_FRAME)
    }

    /// Moves the viewer on, selects and emits what they see; while frozen, what was emitted last is only seen from elsewhere. The scene
    /// is not updated then, so that all its patches stay.
    fn record_mesh(&mut self, commands: &mut Commands, now: Instant, seconds: f64) -> Result<(), AppError> {
        let frozen = self.selection == Selection::Frozen;
        if !frozen {
            self.scene.set_sun(self.look.sun);
            self.scene.receive(self.uploads, commands)?;
        }
        self.step(now, seconds)?;
        if let (true, Some(tables)) = (frozen, &self.tables) {
            self.renderer.prepare_again(&self.scene, &self.view(), tables, &self.look)?;
            return Ok(self.renderer.record_again(commands, &self.scene, tables)?);
        }
        let mut cut = self.scene.choose(&self.view());
        // The cut may draw other ground below the viewer than the one before, which they were kept above.
        if self.viewer.rise(&DrawnSurface::of_scene(&self.scene)) {
            cut = self.scene.choose(&self.view());
        }
        let freezes = self.selection == Selection::Freezes;
        let view = if freezes { self.view().without_culling() } else { self.view() };
        let tables = self.renderer.prepare(&self.scene, &view, &cut, &self.look, freezes)?;
        self.renderer.record_mesh(commands, &self.scene, &tables)?;
        if freezes {
            self.selection = Selection::Frozen;
        }
        self.tables = Some(tables);
        Ok(())
    }

    /// Moves the viewer on, along the path that is played if there is one, and chooses how many pixels are drawn.
    fn step(&mut self, now: Instant, seconds: f64) -> Result<(), AppError> {
        let surface = &DrawnSurface::of_scene(&self.scene);
        // Drivers compile shaders while the first frames are drawn.
        let playback = self.playback.as_mut().filter(|_| self.frames > FIRST_FRAMES);
        match playback.and_then(|playback| playback.at(now)) {
            Some(keyframe) => {
                let camera = self.scene.planet().camera_at(&keyframe, self.viewer.lens.size);
                self.viewer.lens.fov = camera.fov;
                self.viewer.pose = Pose::of_camera(&camera);
                self.viewer.rise(surface);
            }
            None => self.viewer.step(seconds, surface),
        }
        self.moving = self.latest_pose.replace(self.viewer.pose).is_some_and(|pose| pose != self.viewer.pose);
        if self.moving {
            self.pacing.moved(now);
        }
        // Saved pictures have all their pixels.
        self.density = if self.screenshot_wanted { 1.0 } else { self.pacing.density(now) };
        Ok(self.renderer.set_density(self.density)?)
    }

    /// The row of the frame that began at `now`.
    fn row(&self, now: Instant) -> FlyFrame {
        FlyFrame {
            time_s: self.begun.map_or(0.0, |begun| now.duration_since(begun).as_secs_f64()),
            moving: self.moving,
            density: self.density,
            patches: self.tables.as_ref().map_or(0, |tables| tables.patches.len()),
            pending: self.scene.pending(),
            ..FlyFrame::default()
        }
    }

    /// What is seen, as text that shows it elsewhere.
    pub(super) fn view_line(&self) -> ViewLine {
        let line = ViewLine {
            time: Some(self.renderer.time),
            no_geomorphs: !self.geomorphs,
            orientation: self.orientation,
            error: Some(self.tolerance),
            ..self.line.clone()
        };
        view_line::of(line, &self.viewer, self.scene.planet().recipe.radius, &self.look)
    }

    fn view(&self) -> View {
        let camera = self.viewer.pose.camera(&self.viewer.lens);
        let view = View::new(camera, self.scene.lattice(), self.scene.planet().cells, self.tolerance);
        let view = if self.geomorphs { view } else { view.without_geomorphs() };
        if self.orientation {
            view.with_orientation(self.scene.planet().ground_radius())
        } else {
            view
        }
    }

    fn text(&mut self) -> String {
        let status = Status {
            altitude_m: self.viewer.altitude(&DrawnSurface::of_scene(&self.scene)),
            counters: self.counters,
            patches: self.tables.as_ref().map_or(0, |tables| tables.patches.len()),
            pending: self.scene.pending(),
            allocated: self.context.allocated_bytes(),
            bytes: [self.scene.gpu_bytes(), self.scene.host_bytes()],
            density: self.density,
            device: &self.context.device_info().name,
            flying: self.viewer.flying,
            geomorphs: self.geomorphs,
            frozen: self.selection != Selection::Follows,
            mode: self.look.mode,
        };
        self.overlay.text(&status)
    }

    /// Draws the frame once more without the text, waits for it, and hands it to `save`.
    fn save_screenshot(&mut self, size: (u32, u32), save: &mut SaveScreenshot) -> Result<(), AppError> {
        let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT;
        let image = Image::new(&self.context, &ImageDescription::new("screenshot", size, self.swapchain.format(), usage))?;
        Commands::once(&self.context, "screenshot", |commands| {
            self.renderer.record_picture(commands, &self.scene, &self.look, image.view())
        })?;
        let pixels = capture(&self.context, &image, (0, 0), Access::ColorTarget)?.to_rgba8()?;
        let said = save([size.0, size.1], &pixels, &self.view_line()).unwrap_or_else(|problem| problem);
        tracing::info!("{said}");
        self.overlay.say(said);
        Ok(())
    }
}

impl Drop for Flight {
    fn drop(&mut self) {
        // The frames in flight still use what is dropped next. A lost device waits for nothing.
        let _ = self.context.wait_idle();
    }
}
