//! Where the panel's controls are, by name, so that a script can click on them.

use std::collections::HashMap;

use eframe::egui::{Align, Rect, Response, Ui};

/// Controls of the frame that was drawn last.
#[derive(Debug, Default)]
pub struct Targets {
    places: HashMap<String, Rect>,
    /// Those of the frame before.
    before: HashMap<String, Rect>,
    /// What a script looks for.
    wanted: Option<String>,
}

impl Targets {
    /// Forgets all places, before the panel is drawn anew.
    pub fn clear(&mut self) {
        self.before = std::mem::take(&mut self.places);
    }

    /// Notes where a control is. What a script looks for is scrolled into view first.
    pub fn put(&mut self, ui: &Ui, response: &Response, name: &str) {
        let wanted = self.wanted.as_deref() == Some(name);
        if wanted && !ui.clip_rect().contains(response.rect.center()) {
            response.scroll_to_me(Some(Align::Center));
            return;
        }
        if ui.clip_rect().contains(response.rect.center()) {
            self.places.insert(name.to_owned(), response.rect);
        }
    }

    /// Looks for a control.
    pub fn want(&mut self, name: Option<&str>) {
        self.wanted = name.map(str::to_owned);
    }

    /// Where a control is on display, once it rests: a panel that scrolls or grows would have another there by the time of a click.
    pub fn place(&self, name: &str) -> Option<Rect> {
        self.places.get(name).copied().filter(|place| self.before.get(name) == Some(place))
    }
}
