//! Labelled controls in two columns, each known to scripts by its name.

use std::ops::RangeInclusive;

use eframe::egui::{
    Align, CollapsingHeader, ComboBox, DragValue, Layout, RichText, Slider, SliderClamping, TextEdit, Ui,
    Vec2, emath,
};

use gnomon_options::OptionValue;

use crate::targets::Targets;

/// Width of the labels' column [points].
const LABELS: f32 = 112.0;

/// Where controls are added. They change a value only where the user does: values may be finer than a control shows, and outside of its range.
pub struct Fields<'a> {
    pub ui: &'a mut Ui,
    pub targets: &'a mut Targets,
}

impl Fields<'_> {
    /// A group that can be folded away.
    pub fn section(&mut self, title: &str, open: bool, contents: impl FnOnce(&mut Fields<'_>)) {
        let targets = &mut *self.targets;
        let shown = CollapsingHeader::new(RichText::new(title).strong()).default_open(open).show_unindented(
            self.ui,
            |ui| {
                contents(&mut Fields { ui, targets: &mut *targets });
                ui.add_space(6.0);
            },
        );
        self.targets.put(self.ui, &shown.header_response, &format!("section {title}"));
    }

    /// A label, and a control that takes the rest of the row.
    pub fn row<R>(&mut self, label: &str, tip: &str, control: impl FnOnce(&mut Ui, &mut Targets) -> R) -> R {
        let targets = &mut *self.targets;
        self.ui
            .horizontal(|ui| {
                let size = Vec2::new(LABELS, ui.spacing().interact_size.y);
                let text = ui
                    .allocate_ui_with_layout(size, Layout::left_to_right(Align::Center), |ui| {
                        ui.set_min_width(LABELS);
                        ui.add(eframe::egui::Label::new(label).truncate())
                    })
                    .inner;
                if !tip.is_empty() {
                    text.on_hover_text(tip);
                }
                control(ui, targets)
            })
            .inner
    }

    /// A line of text beside a label.
    pub fn text(&mut self, label: &str, text: &str) {
        self.row(label, "", |ui, _| ui.add(eframe::egui::Label::new(text).truncate()));
    }

    /// One of a list. Entries are a name and a line of explanation.
    pub fn choice<'n>(
        &mut self,
        label: &str,
        name: &str,
        chosen: &str,
        entries: impl IntoIterator<Item = (&'n str, &'n str)>,
    ) -> Option<&'n str> {
        self.row(label, "", |ui, targets| list(ui, targets, name, chosen, entries))
    }

    /// A number on a slider; whether the user changed it.
    pub fn slider<N: emath::Numeric>(
        &mut self,
        label: &str,
        name: &str,
        value: &mut N,
        range: RangeInclusive<N>,
        unit: &str,
    ) -> bool {
        self.row(label, "", |ui, targets| slide(ui, targets, name, value, range, unit))
    }

    /// Yes or no.
    pub fn check(&mut self, label: &str, name: &str, value: &mut bool, text: &str) -> bool {
        self.row(label, "", |ui, targets| tick(ui, targets, name, value, text))
    }

    /// Buttons in a row; the one that was clicked.
    pub fn buttons<'n>(&mut self, names: &[&'n str]) -> Option<&'n str> {
        let targets = &mut *self.targets;
        let mut clicked = None;
        self.ui.horizontal(|ui| {
            for &name in names {
                let response = ui.button(name);
                targets.put(ui, &response, name);
                if response.clicked() {
                    clicked = Some(name);
                }
            }
        });
        clicked
    }

    /// A line to be typed, and a button that does something with it.
    pub fn line(&mut self, button: &str, name: &str, text: &mut String, hint: &str) -> bool {
        let targets = &mut *self.targets;
        self.ui
            .horizontal(|ui| {
                let room = (ui.available_width() - LABELS - 14.0).max(60.0);
                let edit = ui.add(TextEdit::singleline(text).hint_text(hint).desired_width(room));
                targets.put(ui, &edit, &format!("{name} path"));
                let response = ui.add_sized(
                    [LABELS - 6.0, ui.spacing().interact_size.y],
                    eframe::egui::Button::new(button),
                );
                targets.put(ui, &response, name);
                response.clicked()
            })
            .inner
    }
}

/// One of a list. Entries are a name and a line of explanation.
pub fn list<'n>(
    ui: &mut Ui,
    targets: &mut Targets,
    name: &str,
    chosen: &str,
    entries: impl IntoIterator<Item = (&'n str, &'n str)>,
) -> Option<&'n str> {
    let mut picked = None;
    let width = ui.available_width() - 8.0;
    let list = ComboBox::from_id_salt(name).width(width).truncate().selected_text(chosen).height(400.0);
    let shown = list.show_ui(ui, |ui| {
        for (entry, summary) in entries {
            let response = ui.selectable_label(entry == chosen, entry);
            targets.put(ui, &response, &format!("{name}={entry}"));
            let response = if summary.is_empty() { response } else { response.on_hover_text(summary) };
            if response.clicked() {
                picked = Some(entry);
            }
        }
    });
    targets.put(ui, &shown.response, name);
    picked
}

/// A number on a slider, fine near 0 where it may be a fraction; whether the user changed it.
pub fn slide<N: emath::Numeric>(
    ui: &mut Ui,
    targets: &mut Targets,
    name: &str,
    value: &mut N,
    range: RangeInclusive<N>,
    unit: &str,
) -> bool {
    // Room for the number as it is written: where it was wider than that, the panel would grow frame by frame.
    let room = if unit.is_empty() { 66.0 } else { 82.0 };
    ui.spacing_mut().slider_width = (ui.available_width() - room).max(40.0);
    let decimals = if unit.is_empty() { 4 } else { 2 };
    let slider = Slider::new(value, range).clamping(SliderClamping::Edits).suffix(unit);
    let response = ui.add(if N::INTEGRAL { slider } else { slider.max_decimals(decimals) });
    targets.put(ui, &response, name);
    response.changed()
}

/// A number to be typed or dragged; whether the user changed it.
pub fn drag<N: emath::Numeric>(
    ui: &mut Ui,
    targets: &mut Targets,
    name: &str,
    value: &mut N,
    range: RangeInclusive<N>,
) -> bool {
    let speed = if N::INTEGRAL { 0.5 } else { 0.02 };
    let drag = DragValue::new(value).update_while_editing(false).clamp_existing_to_range(false);
    let response = ui.add(drag.range(range).speed(speed));
    targets.put(ui, &response, name);
    response.changed()
}

/// The path of a file to be typed, or none; what the user made of it once the line is left.
pub fn path(ui: &mut Ui, targets: &mut Targets, name: &str, value: &OptionValue) -> Option<OptionValue> {
    let own = if let OptionValue::Name(path) = value { path.as_str() } else { "" };
    let id = ui.make_persistent_id(name);
    let typed = ui.data(|data| data.get_temp::<String>(id));
    let mut text = typed.unwrap_or_else(|| own.to_owned());
    let width = ui.available_width() - 8.0;
    let response = ui.add(TextEdit::singleline(&mut text).hint_text("none").desired_width(width));
    targets.put(ui, &response, name);
    if response.has_focus() {
        ui.data_mut(|data| data.insert_temp(id, text));
        return None;
    }
    ui.data_mut(|data| data.remove::<String>(id));
    let changed = response.lost_focus() && text != own;
    match text.is_empty() {
        _ if !changed => None,
        true => Some(OptionValue::Automatic),
        false => Some(OptionValue::Name(text)),
    }
}

/// Yes or no; whether the user changed it.
pub fn tick(ui: &mut Ui, targets: &mut Targets, name: &str, value: &mut bool, text: &str) -> bool {
    let response = ui.checkbox(value, text);
    targets.put(ui, &response, name);
    response.changed()
}
