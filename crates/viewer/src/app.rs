//! One window: input in, panel and picture out.

use eframe::egui::{
    self, CentralPanel, Color32, Context, CornerRadius, Frame, Panel, PointerButton, RawInput, Rect,
    ScrollArea, Sense, Ui, Vec2,
};
use eframe::egui_wgpu::RenderState;

use crate::keys::{Action, KEYS};
use crate::overlay;
use crate::panel;
use crate::player::{Player, Request, Status};
use crate::targets::Targets;
use crate::viewer::Viewer;

#[cfg(test)]
mod tests;

/// Narrower windows start with the panel hidden [points].
const ROOM_FOR_PANEL: f32 = 620.0;
/// Width of the panel [points].
const PANEL_WIDTH: f32 = 300.0;
/// A drag across the window turns by this much [rad].
const TURN_ACROSS: f32 = 3.5;
/// A press of an arrow turns by this much [rad], and moves by this share of the view's width.
const TURN_STEP: f32 = 0.1;
const PAN_STEP: f32 = 0.05;
/// A press of + brings the eye nearer by this factor, a line of the wheel by this power of e a point.
const DOLLY_STEP: f32 = 0.9;
const DOLLY_SCROLL: f32 = 0.004;
/// A press of a bracket turns the environment by this much [degrees].
const ROTATION_STEP: f32 = 15.0;

/// The window's contents.
pub struct App<'a> {
    viewer: &'a mut Viewer,
    player: Option<&'a mut Player>,
    state: RenderState,
    targets: Targets,
    help: bool,
    /// What the user chose; otherwise the window's width decides.
    panel: Option<bool>,
    closing: bool,
    /// Where the picture is.
    place: Rect,
}

impl<'a> App<'a> {
    /// Fails where the window has no device.
    pub fn new(
        creation: &eframe::CreationContext<'_>,
        viewer: &'a mut Viewer,
        player: Option<&'a mut Player>,
    ) -> Result<Self, Box<dyn std::error::Error + Send + Sync>> {
        let state = creation.wgpu_render_state.clone().ok_or("eframe runs without wgpu")?;
        creation.egui_ctx.set_theme(egui::Theme::Dark);
        Ok(Self::over(state, viewer, player))
    }

    /// Draws with a window's device.
    fn over(state: RenderState, viewer: &'a mut Viewer, player: Option<&'a mut Player>) -> Self {
        viewer.attach(&state);
        Self {
            viewer,
            player,
            state,
            targets: Targets::default(),
            help: false,
            panel: None,
            closing: false,
            place: Rect::ZERO,
        }
    }

    fn has_panel(&self, width: f32) -> bool {
        self.panel.unwrap_or(width >= ROOM_FOR_PANEL)
    }

    fn take_drops(&mut self, ctx: &Context) {
        for file in ctx.input(|input| input.raw.dropped_files.clone()) {
            self.viewer.open_file(file.path());
        }
    }

    fn take_keys(&mut self, ctx: &Context) {
        if ctx.egui_wants_keyboard_input() {
            return;
        }
        for (shortcut, action) in KEYS {
            if ctx.input_mut(|input| input.consume_shortcut(shortcut)) {
                self.act(ctx, *action);
            }
        }
    }

    fn act(&mut self, ctx: &Context, action: Action) {
        let viewer = &mut *self.viewer;
        match action {
            Action::Help => self.help = !self.help,
            Action::NextPicture => viewer.picture.shown = viewer.picture.shown.next(),
            Action::DebugView(by) => viewer.step_debug_view(by),
            Action::Light(by) => viewer.step_light(by),
            Action::Turn(x, y) => {
                viewer.move_view(|orbit| orbit.turn(TURN_STEP * glam::Vec2::new(x as f32, y as f32)));
            }
            Action::Pan(x, y) => {
                viewer.move_view(|orbit| orbit.pan(PAN_STEP * glam::Vec2::new(x as f32, y as f32)));
            }
            Action::Dolly(by) => viewer.move_view(|orbit| orbit.dolly(DOLLY_STEP.powi(-by))),
            Action::Frame => viewer.frame_scene(),
            Action::RotateEnvironment(by) => viewer.edit(|look| {
                look.environment.rotation =
                    panel::wrapped(look.environment.rotation + ROTATION_STEP * by as f32);
            }),
            Action::Exposure(by) => {
                let exposure = viewer.studio().map(|studio| studio.stage().exposure());
                viewer.edit(|look| look.display.exposure = exposure.map(|stops| stops + 0.5 * by as f32));
            }
            Action::Play => viewer.toggle_playing(),
            Action::Panel => self.panel = Some(!self.has_panel(ctx.content_rect().width())),
            Action::Times => viewer.times = !viewer.times,
            Action::SavePicture => viewer.save_picture(),
            Action::SaveScene => viewer.save_scene(),
            Action::Dismiss => match std::mem::replace(&mut self.help, false) {
                true => {}
                false => viewer.notices.clear(),
            },
        }
        if matches!(action, Action::Times | Action::DebugView(_)) {
            self.viewer.picture.touch();
        }
    }

    /// The picture, and what the pointer does to the view.
    fn picture(&mut self, ui: &mut Ui) {
        let rect = ui.available_rect_before_wrap();
        if !(rect.width() >= 1.0 && rect.height() >= 1.0) {
            // The panel leaves no room; messages are still to be seen.
            self.place = ui.ctx().content_rect();
            return;
        }
        self.place = rect;
        let response = ui.allocate_rect(rect, Sense::click_and_drag());
        self.targets.put(ui, &response, "picture");
        self.take_pointer(ui.ctx(), &response, rect);
        let scale = ui.ctx().pixels_per_point();
        let pixels =
            [rect.width(), rect.height()].map(|side| (side * scale).round().clamp(0.0, 16384.0) as u32);
        self.viewer.draw(ui.ctx(), &self.state, pixels);
        // A picture of a device that is lost by now must not be painted.
        if self.viewer.device_is_lost() {
            return;
        }
        let painter = ui.painter();
        match self.viewer.picture.texture() {
            Some(texture) => {
                let whole = Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
                painter.image(texture, rect, whole, Color32::WHITE);
            }
            None => overlay::waiting(ui, rect, self.viewer.is_loading()),
        }
        overlay::caption(ui, rect, self.viewer);
        if ui.ctx().input(|input| !input.raw.hovered_files.is_empty()) {
            overlay::drop_here(ui, rect);
        }
    }

    fn take_pointer(&mut self, ctx: &Context, response: &egui::Response, rect: Rect) {
        let (shift, scroll, zoom) =
            ctx.input(|input| (input.modifiers.shift, input.smooth_scroll_delta(), input.zoom_delta()));
        let delta = response.drag_delta() / rect.width().max(1.0);
        let delta = glam::Vec2::new(delta.x, delta.y);
        if delta != glam::Vec2::ZERO {
            let moves = shift
                || response.dragged_by(PointerButton::Secondary)
                || response.dragged_by(PointerButton::Middle);
            self.viewer.move_view(|orbit| match moves {
                // What was under the pointer stays there.
                true => orbit.pan(glam::Vec2::new(-delta.x, delta.y)),
                false => orbit.turn(TURN_ACROSS * glam::Vec2::new(-delta.x, delta.y)),
            });
        }
        if response.double_clicked() {
            self.viewer.frame_scene();
        }
        if !response.contains_pointer() {
            return;
        }
        if zoom != 1.0 {
            self.viewer.move_view(|orbit| orbit.dolly(1.0 / zoom));
        } else if scroll != Vec2::ZERO {
            self.viewer.move_view(|orbit| match shift {
                true => orbit.pan(glam::Vec2::new(-scroll.x, scroll.y) / rect.width().max(1.0)),
                false => orbit.dolly((-DOLLY_SCROLL * scroll.y).exp()),
            });
        }
    }
}

impl eframe::App for App<'_> {
    fn raw_input_hook(&mut self, ctx: &Context, raw: &mut RawInput) {
        let Some(player) = &mut self.player else { return };
        let viewer = &mut *self.viewer;
        let samples = viewer.picture.truth.map_or(0, |truth| truth.samples_per_pixel);
        let status = Status { busy: viewer.is_busy(), samples, notices: &viewer.notices };
        if player.play(ctx, raw, &mut self.targets, &status) == Some(Request::LoseDevice) {
            viewer.lose_device(&self.state);
        }
    }

    fn ui(&mut self, ui: &mut Ui, _: &mut eframe::Frame) {
        self.show(ui);
    }
}

impl App<'_> {
    /// One frame.
    fn show(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        // Nothing can be painted any more: the window is opened anew.
        if self.closing || self.viewer.device_is_lost() {
            if !std::mem::replace(&mut self.closing, true) {
                ctx.send_viewport_cmd(egui::ViewportCommand::Close);
            }
            ctx.request_repaint();
            return;
        }
        self.viewer.poll();
        self.take_drops(&ctx);
        self.take_keys(&ctx);
        self.targets.clear();
        if self.has_panel(ctx.content_rect().width()) {
            let most = (ctx.content_rect().width() - 60.0).max(120.0);
            Panel::left("panel")
                .resizable(true)
                .default_size(PANEL_WIDTH.min(most))
                .size_range(180.0_f32.min(most)..=most)
                .show(ui, |ui| {
                    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                        panel::show(ui, self.viewer, &mut self.targets);
                    });
                });
        }
        let frame = Frame::NONE.fill(Color32::from_gray(16)).corner_radius(CornerRadius::ZERO);
        CentralPanel::default().frame(frame).show(ui, |ui| self.picture(ui));
        if self.viewer.device_is_lost() {
            return;
        }
        let has_panel = self.has_panel(ctx.content_rect().width());
        overlay::buttons(&ctx, &mut self.targets, has_panel, &mut self.panel, &mut self.help);
        let notices = overlay::notices(&ctx, self.place, &mut self.targets, &mut self.viewer.notices);
        overlay::help(&ctx, &mut self.help, notices);
    }
}
