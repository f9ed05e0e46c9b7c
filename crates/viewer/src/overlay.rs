//! What lies over the picture: caption, messages, help.

use eframe::egui::{
    Align2, Area, Color32, Context, FontId, Frame, Grid, Id, Margin, Order, Pos2, Rect, RichText, ScrollArea,
    Ui, Vec2, Window,
};
use gnomon_renderer::debug_view::DEBUG_VIEWS;

use crate::keys::HELP;
use crate::notices::{Level, Notices};
use crate::picture::Shown;
use crate::targets::Targets;
use crate::viewer::Viewer;

const SHADE: Color32 = Color32::from_black_alpha(170);

/// In place of a picture that is not there yet.
pub fn waiting(ui: &Ui, rect: Rect, is_loading: bool) {
    let text = if is_loading { "opening ..." } else { "drop a model, a scene or an environment here" };
    let font = FontId::proportional(18.0);
    ui.painter().text(rect.center(), Align2::CENTER_CENTER, text, font, Color32::from_gray(160));
}

/// While a file hangs over the window.
pub fn drop_here(ui: &Ui, rect: Rect) {
    ui.painter().rect_filled(rect, 0.0, SHADE);
    let font = FontId::proportional(22.0);
    let text = "drop to open: models and scenes, or pictures as environments";
    ui.painter().text(rect.center(), Align2::CENTER_CENTER, text, font, Color32::WHITE);
}

/// What is shown and how far it is from the truth, in the corner above right.
pub fn caption(ui: &Ui, rect: Rect, viewer: &Viewer) {
    let picture = &viewer.picture;
    let mut lines = Vec::new();
    match picture.shown {
        Shown::Gpu => {
            if let Some((view, choice)) =
                picture.debug.and_then(|choice| Some((DEBUG_VIEWS.get(choice.view)?, choice)))
            {
                let light = if view.of_light { format!(", light {}", choice.light) } else { String::new() };
                lines.push(format!("{}{light}", view.name));
            }
            if picture.frame_ms > 0.0 {
                let [width, height] = picture.size();
                lines.push(format!("{width} x {height}, {:.1} ms", picture.frame_ms));
            }
            lines.extend(picture.checked.map(|error| error.to_string()));
        }
        shown => {
            let name = if shown == Shown::Reference { "reference" } else { "GPU less reference" };
            match picture.truth {
                None => lines.push(format!("{name}: tracing the first pass")),
                Some(truth) => {
                    lines.push(format!("{name}, {} samples a pixel", truth.samples_per_pixel));
                    let noise = match truth.noise > 0.0 {
                        true => format!(" (noise {:.1} %)", 100.0 * truth.noise),
                        false => String::new(),
                    };
                    lines.push(format!("error of the GPU's picture {:.2} %{noise}", 100.0 * truth.error));
                }
            }
        }
    }
    if viewer.is_loading() {
        lines.push("working in the background ...".to_owned());
    }
    if lines.is_empty() {
        return;
    }
    let painter = ui.painter();
    let galley = painter.layout(lines.join("\n"), FontId::proportional(13.0), Color32::WHITE, rect.width());
    let corner = Pos2::new(rect.right() - galley.size().x - 14.0, rect.top() + 10.0);
    let back = Rect::from_min_size(corner, galley.size()).expand2(Vec2::new(8.0, 5.0));
    painter.rect_filled(back, 4.0, SHADE);
    painter.galley(corner, galley, Color32::WHITE);
}

/// The two buttons that must be there even without a panel.
pub fn buttons(
    ctx: &Context,
    targets: &mut Targets,
    has_panel: bool,
    panel: &mut Option<bool>,
    help: &mut bool,
) {
    Area::new(Id::unique("buttons")).anchor(Align2::RIGHT_BOTTOM, Vec2::new(-10.0, -10.0)).show(ctx, |ui| {
        ui.horizontal(|ui| {
            let show = ui.button(if has_panel { "hide panel" } else { "panel" }).on_hover_text("P");
            if show.clicked() {
                *panel = Some(!has_panel);
            }
            targets.put(ui, &show, "panel");
            let response = ui.button("?").on_hover_text("keys and mouse");
            if response.clicked() {
                *help = !*help;
            }
            targets.put(ui, &response, "help");
        });
    });
}

/// Messages at the foot of the picture, each to be dismissed; where they are, if there are any.
pub fn notices(ctx: &Context, picture: Rect, targets: &mut Targets, notices: &mut Notices) -> Option<Rect> {
    if notices.expire() {
        ctx.request_repaint_after(std::time::Duration::from_millis(500));
    }
    if notices.lines().is_empty() {
        return None;
    }
    let mut dismissed = None;
    let width = (picture.width() - 40.0).clamp(80.0, 900.0);
    let foot = picture.center_bottom() - Vec2::new(0.0, 44.0);
    let area = Area::new(Id::unique("notices")).order(Order::Foreground).fixed_pos(foot);
    let shown = area.pivot(Align2::CENTER_BOTTOM).show(ctx, |ui| {
        for (i, notice) in notices.lines().iter().enumerate() {
            let (fill, label) = match notice.level {
                Level::Done => (Color32::from_rgb(28, 70, 42), ""),
                Level::Warning => (Color32::from_rgb(92, 70, 18), "warning: "),
                Level::Error => (Color32::from_rgb(110, 28, 28), "error: "),
            };
            Frame::NONE.fill(fill).corner_radius(5.0).inner_margin(7.0).show(ui, |ui| {
                ui.set_max_width(width);
                ui.horizontal(|ui| {
                    let close = ui.small_button("×").on_hover_text("dismiss (Esc: all)");
                    targets.put(ui, &close, &format!("dismiss {i}"));
                    if close.clicked() {
                        dismissed = Some(i);
                    }
                    let count =
                        if notice.count > 1 { format!(" ({} times)", notice.count) } else { String::new() };
                    let text = RichText::new(format!("{label}{}{count}", notice.text)).color(Color32::WHITE);
                    ui.add(eframe::egui::Label::new(text).wrap());
                });
            });
        }
    });
    if let Some(i) = dismissed {
        notices.dismiss(i);
    }
    Some(shown.response.rect)
}

/// Keys and mouse, above the messages.
pub fn help(ctx: &Context, open: &mut bool, notices: Option<Rect>) {
    let window = ctx.content_rect();
    let foot = notices.map_or(window.bottom(), |notices| notices.top()).clamp(window.top(), window.bottom());
    let room = foot - window.top();
    Window::new("Keys and mouse")
        .id(Id::unique("keys and mouse"))
        .open(open)
        .collapsible(false)
        .resizable(false)
        .anchor(Align2::CENTER_CENTER, Vec2::new(0.0, 0.5 * (foot - window.bottom())))
        .show(ctx, |ui| {
            let height = (room - 100.0).max(60.0);
            ScrollArea::vertical().max_height(height).min_scrolled_height(height).show(ui, |ui| {
                // Room for the scroll bar.
                let room = Margin { right: 12, ..Margin::ZERO };
                Frame::NONE.inner_margin(room).show(ui, |ui| {
                    let grid = Grid::new("help").num_columns(2).spacing(Vec2::new(24.0, 5.0));
                    grid.striped(true).show(ui, |ui| {
                        for (keys, what) in HELP {
                            ui.strong(*keys);
                            ui.label(*what);
                            ui.end_row();
                        }
                    });
                });
            });
        });
}
