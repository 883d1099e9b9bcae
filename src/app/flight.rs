//! A flight: the window with everything that is drawn in it. One call of [`Flight::draw`] is one frame.

use super::choices::Choices;
use super::host::Host;
use super::inspection::{drawn_at, Anatomy};
use super::interface::Interface;
use super::ledger::Ledger;
use super::outlines::FrozenView;
use super::pacing::{Due, Motives, Pacing, Scale};
use super::panel::{Asked, Panel};
use super::playback::{FlyFrame, Playback};
use super::pose::Pose;
use super::surface::DrawnSurface;
use super::viewer::Viewer;
use super::{AppError, FlyOptions};
use crate::frame::{FrameTables, GuiFrame, PerStage, Renderer};
use crate::scene::{uploads_within, Scene, SceneOptions, Scope};
use crate::vulkan::{vk, Access, Commands, Context, Frame, GpuInfo, GpuKind, Image, ImageDescription, Swapchain};
use glam::DVec3;
use std::sync::Arc;
use std::time::{Duration, Instant};
use terrane_planet::draw::layout::{EmitState, Mode};
use terrane_planet::draw::view::View;
use terrane_planet::draw::view_line::ViewLine;
use terrane_planet::maps::waves::CASCADES;
use winit::window::Window;

/// Longest time in seconds that one frame moves the viewer on by, however long it took.
const LONGEST_FRAME: f64 = 0.25;
/// Seconds of a frame that would take in as many patches as are taken in at a time without one.
const TAKEN_IN: f64 = 0.05;
/// How often what is being built is said anew while no picture is drawn.
const PROGRESS: Duration = Duration::from_millis(200);
/// Seconds in which exposure goes most of the way to its goal.
const ADAPTATION_SECONDS: f64 = 0.6;
/// Milliseconds that a moving frame may take on a software renderer unless told otherwise: ten frames a second, and some room.
const SOFTWARE_MS: f64 = 80.0;
/// Largest error of the mesh in pixels at first.
pub(super) const USUAL_TOLERANCE: f64 = 1.0;
/// Frames after which a path begins to be played.
const FIRST_FRAMES: u64 = 2;
/// Frames a second where the screen does not say how many it shows.
const USUAL_FPS: f64 = 60.0;

/// Whether the selection follows the viewer.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Selection {
    Follows,
    /// The next frame emits the whole mesh once more, without culling, to be seen from all sides.
    Freezes,
    Frozen,
}

/// A picture that is wanted as a file.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Screenshot {
    /// Of the planet alone.
    Picture,
    /// With the interface in it.
    Window,
    /// Small, to remember the view by.
    Bookmark,
}

/// Everything that a window needs.
pub(super) struct Flight {
    pub(super) viewer: Viewer,
    pub(super) panel: Panel,
    pub(super) interface: Interface,
    pub(super) choices: Choices,
    pub(super) scene: Scene,
    pub(super) window: Arc<Window>,
    pub(super) selection: Selection,
    pub(super) screenshot: Option<Screenshot>,
    /// What the panel asked for that is not done yet.
    pub(super) asked: Asked,
    /// Text that is to be copied.
    pub(super) copied: Vec<String>,
    /// Where the window began.
    pub(super) home: Pose,
    /// Where the cursor was when the button of the tool went down.
    pub(super) put_down: Option<[f64; 2]>,
    /// The direction of what was picked.
    pub(super) picked: Option<DVec3>,
    /// The vertices of the patch that is drawn there.
    pub(super) anatomy: Option<Anatomy>,
    /// What the selection was frozen with.
    pub(super) frozen: Option<FrozenView>,
    pub(super) context: Arc<Context>,
    /// What scenes may use and build.
    pub(super) options: SceneOptions,
    swapchain: Swapchain,
    pub(super) renderer: Renderer,
    /// The latest picture, without the interface: frames in which only that changes put it over the same.
    pub(super) picture: Option<Image>,
    /// The view as text, as far as nothing changes it.
    pub(super) line: ViewLine,
    /// Of the latest frame; while frozen, of the frame that stays.
    pub(super) tables: Option<FrameTables>,
    /// Patches that this frame may take in.
    uploads: usize,
    /// Whether the latest frame put the interface over the picture before.
    reused: bool,
    /// Whether some were taken in that no picture shows yet.
    taken_in: bool,
    pub(super) pacing: Pacing,
    ledger: Ledger,
    pub(super) playback: Option<Playback>,
    /// Whether every frame gets a row in the report.
    reports: bool,
    pub(super) density: f64,
    /// Where the viewer was in the latest frame.
    latest_pose: Option<Pose>,
    /// Whether they moved in the latest frame.
    moving: bool,
    /// Of a frame that is done: its counters, and GPU milliseconds of its stages.
    pub(super) counters: EmitState,
    pub(super) stages: PerStage<Option<f64>>,
    begun: Option<Instant>,
    latest: Instant,
    frames: u64,
}

impl Flight {
    pub(super) fn new(window: Arc<Window>, options: &FlyOptions) -> Result<Flight, AppError> {
        let (context, surface) = Context::with_window(&options.context, window.clone())?;
        let mut scene = Scene::open(&context, &options.file, SceneOptions { scope: Scope::Flight, ..options.scene.clone() })?;
        scene.bear_edits_of_others();
        let size = window.inner_size();
        let swapchain = Swapchain::new(&context, surface, (size.width, size.height), false)?;
        let format = swapchain.format();
        let software = context.device_info().kind == GpuKind::Cpu;
        let budget = Scale::Within(if software { SOFTWARE_MS } else { f64::INFINITY });
        let scale = options.scale.unwrap_or(budget);
        let shown = window.current_monitor().and_then(|monitor| monitor.refresh_rate_millihertz());
        let most_fps = options.most_fps.unwrap_or(shown.map_or(USUAL_FPS, |millihertz| f64::from(millihertz) * 1e-3));
        let mut renderer = Renderer::new(&context, (options.camera.size[0], options.camera.size[1]), format)?;
        renderer.time = options.view.time.unwrap_or(0.0);
        let mut viewer = Viewer::new(&options.camera, options.keys.clone());
        viewer.set_speed(options.settings.speed);
        Ok(Flight {
            viewer,
            panel: Panel::new(options.settings.panel),
            interface: Interface::new(&context, &window, format)?,
            choices: Choices {
                look: options.look,
                date: options.view.date(),
                tolerance: options.tolerance,
                geomorphs: options.geomorphs,
                orientation: options.orientation,
                scale,
                budget: if matches!(scale, Scale::Within(_)) { scale } else { budget },
            },
            scene,
            window,
            selection: Selection::Follows,
            screenshot: None,
            asked: Asked::default(),
            copied: Vec::new(),
            home: Pose::of_camera(&options.camera),
            put_down: None,
            picked: None,
            anatomy: None,
            frozen: None,
            options: options.scene.clone(),
            renderer,
            context,
            swapchain,
            picture: None,
            line: options.view.clone(),
            tables: None,
            uploads: uploads_within(0.0),
            reused: false,
            taken_in: false,
            pacing: Pacing::new(scale, most_fps, software),
            ledger: Ledger::default(),
            playback: options
                .path
                .clone()
                .map(|path| Playback::new(path, options.stand).lit(options.camera.position.normalize(), options.look.sun)),
            reports: options.stand.is_some(),
            density: 1.0,
            latest_pose: None,
            moving: false,
            counters: EmitState::default(),
            stages: PerStage::from_fn(|_| None),
            begun: None,
            latest: Instant::now(),
            frames: 0,
        })
    }

    /// Frames drawn, and the seconds since the first.
    pub(super) fn pace(&self) -> (u64, f64) {
        (self.frames, self.begun.map_or(0.0, |begun| begun.elapsed().as_secs_f64()))
    }

    /// The frames drawn, where they are reported.
    pub(super) fn rows(&mut self) -> Vec<FlyFrame> {
        std::mem::take(&mut self.ledger.rows)
    }

    /// Something happened that the picture shows.
    pub(super) fn touch(&mut self) {
        self.pacing.touch(Instant::now());
    }

    /// Something happened that only the interface shows.
    pub(super) fn touch_interface(&mut self) {
        self.pacing.touch_interface();
    }

    /// When the window closes by itself.
    pub(super) fn closes(&self) -> Option<Instant> {
        self.playback.as_ref()?.closes()
    }

    /// When the next frame is due.
    pub(super) fn due(&self, now: Instant) -> Due {
        self.pacing.due(now, &self.motives())
    }

    fn motives(&self) -> Motives {
        let plays = self.playback.as_ref().is_some_and(|playback| playback.is_moving());
        let follows = self.selection == Selection::Follows;
        Motives {
            moving: self.viewer.is_moving() || plays || self.has_waves() || self.latest_pose != Some(self.viewer.pose),
            arrived: follows && (self.scene.has_arrived() || self.taken_in),
            pending: follows && self.scene.pending() > 0,
            metered: self.choices.look.metering.is_some(),
            until: [self.panel.vanishes(), self.interface.repaint()].into_iter().flatten().min(),
        }
    }

    /// Takes in what has arrived without drawing it: on a software renderer a picture takes the time of many patches, and each tells which
    /// are wanted next.
    pub(super) fn take_in(&mut self, now: Instant) -> Result<(), AppError> {
        let follows = self.selection == Selection::Follows && self.picture.is_some();
        if self.software() && follows && self.scene.has_arrived() && !self.pacing.wants_picture(now, &self.motives()) {
            let was_busy = self.scene.edits().is_busy();
            self.scene.update(&self.view(), uploads_within(TAKEN_IN))?;
            self.taken_in = true;
            self.pacing.touch_interface_within(now, PROGRESS);
            if was_busy && !self.scene.edits().is_busy() {
                self.touch();
            }
        }
        Ok(())
    }

    /// What the viewer moves over.
    pub(super) fn surface(&self) -> DrawnSurface<'_> {
        DrawnSurface::of_scene(&self.scene, self.choices.look.sea)
    }

    /// Whether the sea moves where the viewer can see it. On software renderers it only does while they move themselves.
    fn has_waves(&self) -> bool {
        let look = &self.choices.look;
        let sees = self.scene.planet().recipe.sea.is_some() && look.sea && look.mode == Mode::Shaded;
        let pixel = self.viewer.pose.camera(&self.viewer.lens).pixel_angle();
        let longest = CASCADES[0].wavelengths[0];
        !self.software() && sees && self.viewer.altitude(&self.surface()) * pixel < longest
    }

    /// Says that a software renderer draws: who has a GPU is to know that its driver is missing.
    pub(super) fn warn_of_software(&self) {
        if self.software() {
            let GpuInfo { name, index, .. } = self.context.device_info();
            tracing::warn!(
                "the software renderer {name} draws, slowly, because no usable GPU was found; `terrane gpus` says why, `--gpu {index}` \
                 asks for it"
            );
        }
    }

    fn software(&self) -> bool {
        self.context.device_info().kind == GpuKind::Cpu
    }

    pub(super) fn resize(&mut self, width: u32, height: u32) {
        self.swapchain.resize(width, height);
    }

    /// Draws a frame. False if there was nothing to draw to: try again a little later.
    pub(super) fn draw(&mut self, host: &mut dyn Host) -> Result<bool, AppError> {
        #[cfg(debug_assertions)]
        lose_device_on_purpose(self.frames)?;
        let Some(mut frame) = self.swapchain.acquire()? else { return Ok(false) };
        let (now, slot, size) = (Instant::now(), frame.slot(), frame.target.size());
        self.learn(&frame, now)?;
        let stale = self.picture.as_ref().is_none_or(|picture| picture.size() != size);
        let anew = stale || self.pacing.wants_picture(now, &self.motives());
        self.pacing.begin(now, anew);
        self.reused = !anew;
        if anew {
            self.draw_picture(&mut frame.commands, now, size)?;
        }
        let gui = self.lay_out(now);
        let commands = &mut frame.commands;
        if let Some(picture) = &self.picture {
            if !anew {
                commands.found(picture.view(), Access::TransferRead);
            }
            commands.ready(&[picture.view().to(Access::TransferRead), frame.target.anew(Access::TransferWrite)])?;
            commands.copy_to_view(picture, &frame.target)?;
        }
        self.interface.record(commands, &frame.target, &gui)?;
        commands.ready(&[frame.target.to(Access::Present)])?;
        if anew {
            let row = self.reports.then(|| self.row(now));
            self.ledger.send(slot, now, self.context.allocations(), row, self.density);
        }
        self.window.pre_present_notify();
        self.swapchain.present(frame)?;
        if let Some(wanted) = self.screenshot.take().filter(|_| anew) {
            self.save_screenshot(wanted, gui, host)?;
        }
        Ok(true)
    }

    /// Learns from the frame that was drawn in this slot before, which is done.
    fn learn(&mut self, frame: &Frame, now: Instant) -> Result<(), AppError> {
        let Some(times) = &frame.timestamps else { return Ok(()) };
        // The frame before may have been of the interface alone: then the latest picture is done, too.
        self.counters = if self.reused { self.renderer.counters()? } else { self.renderer.earlier_counters()? };
        if let Some(cost) = self.ledger.settle(frame.slot(), times, now) {
            self.stages = PerStage::gpu_ms(times);
            self.pacing.learn(cost);
        }
        Ok(())
    }

    /// Draws the planet.
    fn draw_picture(&mut self, commands: &mut Commands, now: Instant, size: (u32, u32)) -> Result<(), AppError> {
        self.viewer.lens.size = [size.0, size.1];
        self.renderer.resize(size)?;
        let picture = match self.picture.take() {
            Some(picture) if picture.size() == size => picture,
            _ => {
                let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT;
                Image::new(&self.context, &ImageDescription::new("picture", size, self.swapchain.format(), usage))?
            }
        };
        self.taken_in = false;
        let seconds = self.pass_time(now);
        self.record_mesh(commands, now, seconds)?;
        self.renderer.record_picture(commands, &self.scene, &self.choices.look, picture.view())?;
        self.picture = Some(picture);
        Ok(())
    }

    /// Lays out the interface, and does what it is asked for. What it changes shows in the next frame.
    fn lay_out(&mut self, now: Instant) -> GuiFrame {
        self.dissect();
        let facts = self.facts();
        let (mut choices, mut asked) = (self.choices, std::mem::take(&mut self.asked));
        let (panel, keys) = (&mut self.panel, &self.viewer.keys);
        let gui = self.interface.lay_out(&mut self.copied, |ctx| panel.show(ctx, &facts, &mut choices, keys, &mut asked));
        if choices != self.choices {
            self.choices = choices;
            self.follow_scale();
            self.touch();
            // What is slid is to follow the hand.
            self.pacing.moved(now);
        }
        self.answer(&mut asked);
        self.asked = asked;
        gui
    }

    /// Gets to know the vertices of the patch that was picked, if it is another than before.
    fn dissect(&mut self) {
        let (Some(tables), Some(site)) = (&self.tables, self.picked) else {
            self.anatomy = None;
            return;
        };
        let Some(patch) = drawn_at(tables, site).map(|at| tables.leaves[at].id) else { return };
        if self.anatomy.as_ref().is_none_or(|anatomy| !anatomy.is_of(&self.scene, patch)) {
            self.anatomy = Some(Anatomy::of(&self.scene, patch));
        }
    }

    /// Counts a frame. Returns the seconds by which it moves the viewer on.
    fn pass_time(&mut self, now: Instant) -> f64 {
        let seconds = now.duration_since(std::mem::replace(&mut self.latest, now)).as_secs_f64();
        if self.begun.is_some() {
            self.frames += 1;
            // Who stands waits for nothing, and how long says nothing.
            if self.moving {
                self.panel.count_frame(seconds);
            }
        } else {
            self.begun = Some(now);
        }
        if let Some(share) = &mut self.choices.look.metering {
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
            self.scene.set_sun(self.choices.look.sun);
            self.scene.receive(self.uploads, commands)?;
        }
        self.step(now, seconds)?;
        if let (true, Some(tables)) = (frozen, &self.tables) {
            self.renderer.prepare_again(&self.scene, &self.view(), tables, &self.choices.look)?;
            return Ok(self.renderer.record_again(commands, &self.scene, tables)?);
        }
        let mut cut = self.scene.choose(&self.view());
        // The cut may draw other ground below the viewer than the one before, which they were kept above.
        if self.viewer.rise(&DrawnSurface::of_scene(&self.scene, self.choices.look.sea)) {
            cut = self.scene.choose(&self.view());
        }
        let freezes = self.selection == Selection::Freezes;
        let view = if freezes { self.view().without_culling() } else { self.view() };
        let tables = self.renderer.prepare(&self.scene, &view, &cut, &self.choices.look, freezes)?;
        self.renderer.record_mesh(commands, &self.scene, &tables)?;
        if freezes {
            self.selection = Selection::Frozen;
            let leaves = tables.leaves.iter().map(|leaf| leaf.id).collect();
            self.frozen = Some(FrozenView { view, leaves });
        }
        self.tables = Some(tables);
        Ok(())
    }

    /// Moves the viewer on, along the path that is played if there is one, and chooses how many pixels are drawn.
    fn step(&mut self, now: Instant, seconds: f64) -> Result<(), AppError> {
        let surface = &DrawnSurface::of_scene(&self.scene, self.choices.look.sea);
        // Drivers compile shaders while the first frames are drawn.
        let playback = self.playback.as_mut().filter(|_| self.frames > FIRST_FRAMES);
        match playback.and_then(|playback| playback.at(now)) {
            Some(waypoint) => {
                let camera = self.scene.planet().camera_on(&waypoint, self.viewer.lens.size);
                self.viewer.lens.fov = camera.fov;
                self.viewer.pose = Pose::of_camera(&camera);
                self.viewer.rise(surface);
                let sun = self.playback.as_ref().and_then(|playback| playback.sun(&waypoint));
                self.choices.look.sun = sun.unwrap_or(self.choices.look.sun);
            }
            None => self.viewer.step(seconds, surface),
        }
        self.playback = self.playback.take().filter(|playback| !playback.is_over());
        self.moving = self.latest_pose.replace(self.viewer.pose).is_some_and(|pose| pose != self.viewer.pose);
        if self.moving {
            self.pacing.moved(now);
        }
        // Saved pictures have all their pixels.
        self.density = if self.screenshot.is_some() { 1.0 } else { self.pacing.density(now) };
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

    pub(super) fn view(&self) -> View {
        let camera = self.viewer.pose.camera(&self.viewer.lens);
        let view = View::new(camera, self.scene.lattice(), self.scene.planet().cells, self.choices.tolerance);
        let view = if self.choices.geomorphs { view } else { view.without_geomorphs() };
        if self.choices.orientation {
            view.with_orientation(self.scene.planet().ground_radius())
        } else {
            view
        }
    }
}

impl Drop for Flight {
    fn drop(&mut self) {
        // The frames in flight still use what is dropped next. A lost device waits for nothing.
        let _ = self.context.wait_idle();
    }
}

/// Fails as a lost device does, in the frame that `TERRANE_LOSE_DEVICE` says, once: no test can lose a real one.
#[cfg(debug_assertions)]
fn lose_device_on_purpose(frame: u64) -> Result<(), AppError> {
    use std::sync::atomic::{AtomicBool, Ordering};
    static LOST: AtomicBool = AtomicBool::new(false);
    let wanted = std::env::var("TERRANE_LOSE_DEVICE").ok().and_then(|text| text.parse().ok());
    if wanted.is_some_and(|wanted: u64| frame >= wanted) && !LOST.swap(true, Ordering::Relaxed) {
        return Err(crate::vulkan::VulkanError::DeviceLost { zone: "none (on purpose)".to_owned() }.into());
    }
    Ok(())
}
