//! The user interface as a machine: egui's context, what the window tells it, and the stage that paints it.
//!
//! In: events, and a function that lays everything out. Out: whether an event was meant for the interface, and a frame to record.

use crate::frame::{Gui, GuiFrame};
use crate::vulkan::{vk, Commands, Context, ImageView, Result};
use egui::{Color32, CornerRadius, Order, OutputCommand, Pos2, Stroke, ViewportId, Visuals};
use egui_winit::State;
use std::sync::Arc;
use std::time::{Duration, Instant};
use winit::dpi::PhysicalPosition;
use winit::event::WindowEvent;
use winit::window::Window;

/// Repaints that are farther off than this are none.
const FAR: Duration = Duration::from_secs(3600);
/// Windows at least so high have text of twice the size where the screen does not ask for more itself.
const TALL: u32 = 1800;
/// What lies behind text: the picture shows through it a little.
const VEIL: Color32 = Color32::from_rgba_premultiplied(10, 12, 16, 218);

/// egui in a window.
pub(super) struct Interface {
    context: egui::Context,
    state: State,
    stage: Gui,
    window: Arc<Window>,
    cursor: PhysicalPosition<f64>,
    /// When it wants to be painted again although nothing happens.
    repaint: Option<Instant>,
}

impl Interface {
    pub(super) fn new(context: &Arc<Context>, window: &Arc<Window>, format: vk::Format) -> Result<Interface> {
        let gui = egui::Context::default();
        gui.set_theme(egui::Theme::Dark);
        gui.set_visuals(visuals());
        // Each step of an animation would be a frame.
        gui.all_styles_mut(|style| style.animation_time = 0.0);
        let side = context.limits().max_image_dimension2_d as usize;
        let state = State::new(gui.clone(), ViewportId::ROOT, window, None, None, Some(side));
        Ok(Interface {
            context: gui,
            state,
            stage: Gui::new(context, format)?,
            window: window.clone(),
            cursor: PhysicalPosition::default(),
            repaint: None,
        })
    }

    /// Hands an event on. True if it was meant for the interface alone.
    pub(super) fn takes(&mut self, event: &WindowEvent) -> bool {
        match event {
            // Keys go to text that is being typed, and to nothing else: Tab is a key of ours.
            WindowEvent::KeyboardInput { .. } if !self.is_typing() => false,
            WindowEvent::CursorMoved { position, .. } => {
                self.cursor = *position;
                let _ = self.state.on_window_event(&self.window, event);
                self.context.is_using_pointer()
            }
            WindowEvent::MouseInput { state, .. } => {
                let _ = self.state.on_window_event(&self.window, event);
                // A release ends what its press began, wherever the cursor is by then.
                state.is_pressed() && self.is_under_cursor()
            }
            WindowEvent::MouseWheel { .. } => {
                let _ = self.state.on_window_event(&self.window, event);
                self.is_under_cursor()
            }
            _ => self.state.on_window_event(&self.window, event).consumed,
        }
    }

    /// Puts text into the field that has the keyboard.
    pub(super) fn paste(&mut self, text: String) {
        self.state.egui_input_mut().events.push(egui::Event::Paste(text));
    }

    /// Whether a text field has the keyboard.
    pub(super) fn is_typing(&self) -> bool {
        self.context.wants_keyboard_input()
    }

    /// Whether the cursor is over something of the interface, as it was laid out last.
    pub(super) fn is_under_cursor(&self) -> bool {
        let scale = self.context.pixels_per_point();
        let at = Pos2::new(self.cursor.x as f32 / scale, self.cursor.y as f32 / scale);
        self.context.layer_id_at(at).is_some_and(|layer| layer.order != Order::Background)
    }

    /// When it wants to be painted again although nothing happens.
    pub(super) fn repaint(&self) -> Option<Instant> {
        self.repaint
    }

    /// Lays out a frame. What is to be copied from it goes to `copied`.
    pub(super) fn lay_out(&mut self, copied: &mut Vec<String>, show: impl FnMut(&egui::Context)) -> GuiFrame {
        self.context.set_zoom_factor(if self.window.inner_size().height >= TALL && self.window.scale_factor() < 1.5 {
            2.0
        } else {
            1.0
        });
        let input = self.state.take_egui_input(&self.window);
        let output = self.context.run(input, show);
        for command in &output.platform_output.commands {
            if let OutputCommand::CopyText(text) = command {
                copied.push(text.clone());
            }
        }
        self.state.handle_platform_output(&self.window, output.platform_output);
        let delay = output.viewport_output.get(&ViewportId::ROOT).map_or(FAR, |viewport| viewport.repaint_delay);
        self.repaint = (delay < FAR).then(|| Instant::now() + delay);
        GuiFrame {
            primitives: self.context.tessellate(output.shapes, output.pixels_per_point),
            images: output.textures_delta,
            pixels_per_point: output.pixels_per_point,
        }
    }

    /// Records a frame over a picture.
    pub(super) fn record(&mut self, commands: &mut Commands, picture: &ImageView, frame: &GuiFrame) -> Result<()> {
        self.stage.record(commands, picture, frame)
    }
}

fn visuals() -> Visuals {
    let mut visuals = Visuals::dark();
    visuals.window_fill = VEIL;
    visuals.panel_fill = VEIL;
    visuals.window_stroke = Stroke::new(1.0, Color32::from_white_alpha(24));
    visuals.window_shadow = egui::Shadow::NONE;
    visuals.popup_shadow = egui::Shadow::NONE;
    visuals.window_corner_radius = CornerRadius::same(6);
    visuals.override_text_color = Some(Color32::from_gray(225));
    visuals
}
