use crate::{RgbImage, font};
use glam::Vec3;

const GAP: u32 = ContactSheet::GAP;

/// One picture and what stands above it.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Its caption; each line of it starts a line, longer ones are wrapped.
    pub caption: String,
    /// Display-linear values in 0..1.
    pub picture: RgbImage,
}

impl Panel {
    /// A captioned picture.
    pub fn new(caption: impl Into<String>, picture: RgbImage) -> Self {
        Self { caption: caption.into(), picture }
    }
}

/// A labelled grid of pictures under a title, with a wide picture on top if wanted.
#[derive(Clone, Debug)]
pub struct ContactSheet {
    /// Stem of its file's name.
    pub name: String,
    /// The line above everything.
    pub title: String,
    /// A wide picture under the title.
    pub banner: Option<RgbImage>,
    /// The pictures, row by row.
    pub panels: Vec<Panel>,
    /// Panels in a row, at least 1.
    pub columns: u32,
    /// Every pixel of a panel becomes a square of this many, at least 1.
    pub enlargement: u32,
}

impl ContactSheet {
    /// Pixels between panels, and around all of them.
    pub const GAP: u32 = 12;

    /// A sheet without pictures.
    pub fn new(name: impl Into<String>, title: impl Into<String>, columns: u32) -> Self {
        Self {
            name: name.into(),
            title: title.into(),
            banner: None,
            panels: Vec::new(),
            columns: columns.max(1),
            enlargement: 1,
        }
    }

    /// The whole sheet, display-linear, to be written as PNG.
    pub fn to_image(&self) -> RgbImage {
        let enlargement = self.enlargement.max(1);
        let size = |side: fn(&RgbImage) -> u32| {
            self.panels.iter().map(|panel| side(&panel.picture) * enlargement).max().unwrap_or(0)
        };
        let cell_width = size(RgbImage::width);
        let columns = self.columns.clamp(1, self.panels.len().max(1) as u32);
        let grid_width = columns * cell_width + (columns - 1) * GAP;
        let banner_width = self.banner.as_ref().map_or(0, RgbImage::width);
        let scale = if cell_width == 0 || cell_width >= 200 { 2 } else { 1 };
        let line = (font::HEIGHT + 3) * scale;
        let title_width = self.title.chars().count() as u32 * font::ADVANCE * 2;
        let inner = grid_width.max(banner_width).max(title_width.min(MAX_TITLE_WIDTH));

        let title = wrapped(&self.title, inner, 2);
        let title_height = title.len() as u32 * (font::HEIGHT + 3) * 2;
        let rows: Vec<(u32, u32)> = self
            .panels
            .chunks(columns as usize)
            .map(|row| {
                let lines = row.iter().map(|panel| wrapped(&panel.caption, cell_width, scale).len()).max();
                let height = row.iter().map(|panel| panel.picture.height() * enlargement).max();
                (lines.unwrap_or(0) as u32 * line + GAP / 3, height.unwrap_or(0))
            })
            .collect();
        let banner_height = self.banner.as_ref().map_or(0, |banner| banner.height() + GAP);
        let body: u32 = rows.iter().map(|(caption, picture)| caption + picture + GAP).sum();
        // Darker than nearly any picture, so that their edges show: sRGB 0.1.
        let (width, height) = (inner + 2 * GAP, GAP + title_height + GAP / 2 + banner_height + body);
        let mut sheet = RgbImage::filled(width, height, Vec3::splat(0.01));

        let mut y = GAP;
        write_lines(&mut sheet, (GAP, y), &title, 2);
        y += title_height + GAP / 2;
        if let Some(banner) = &self.banner {
            place(&mut sheet, (GAP, y), banner, 1);
            y += banner_height;
        }
        for (row, (caption_height, picture_height)) in self.panels.chunks(columns as usize).zip(rows) {
            for (panel, column) in row.iter().zip(0..) {
                let x = GAP + column * (cell_width + GAP);
                let caption = wrapped(&panel.caption, cell_width, scale);
                write_lines(&mut sheet, (x, y), &caption, scale);
                place(&mut sheet, (x, y + caption_height), &panel.picture, enlargement);
            }
            y += caption_height + picture_height + GAP;
        }
        sheet
    }
}

/// A title alone widens a sheet up to here; a longer one is wrapped.
const MAX_TITLE_WIDTH: u32 = 720;

/// Lines of at most `width` pixels, broken at spaces where there are some.
fn wrapped(text: &str, width: u32, scale: u32) -> Vec<String> {
    let most = (width / (font::ADVANCE * scale)).max(1) as usize;
    let mut lines = Vec::new();
    for paragraph in text.lines() {
        let mut line = String::new();
        for word in paragraph.split_whitespace() {
            if !line.is_empty() && line.chars().count() + 1 + word.chars().count() > most {
                lines.push(std::mem::take(&mut line));
            }
            if !line.is_empty() {
                line.push(' ');
            }
            line += word;
            while line.chars().count() > most {
                let rest = line.chars().skip(most).collect();
                lines.push(line.chars().take(most).collect());
                line = rest;
            }
        }
        lines.push(line);
    }
    lines
}

fn write_lines(sheet: &mut RgbImage, (x, y): (u32, u32), lines: &[String], scale: u32) {
    for (text, index) in lines.iter().zip(0..) {
        font::write(sheet, (x, y + index * (font::HEIGHT + 3) * scale), text, scale, Vec3::splat(0.7));
    }
}

fn place(sheet: &mut RgbImage, (x, y): (u32, u32), picture: &RgbImage, enlargement: u32) {
    for row in 0..picture.height() * enlargement {
        for column in 0..picture.width() * enlargement {
            *sheet.get_mut(x + column, y + row) = picture.get(column / enlargement, row / enlargement);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panels_lie_where_their_order_says() {
        let mut sheet = ContactSheet::new("s", "t", 2);
        sheet.enlargement = 3;
        for value in 1..=3 {
            sheet.panels.push(Panel::new("a", RgbImage::filled(4, 2, Vec3::splat(value as f32))));
        }
        let image = sheet.to_image();
        let count = |value: f32| image.texels().iter().filter(|texel| texel.x == value).count();
        assert_eq!([count(1.0), count(2.0), count(3.0)], [72, 72, 72]);
        let place = |value: f32| {
            let index = image.texels().iter().position(|texel| texel.x == value).unwrap() as u32;
            (index % image.width(), index / image.width())
        };
        assert!(place(1.0).1 == place(2.0).1 && place(1.0).0 < place(2.0).0);
        assert!(place(3.0).0 == place(1.0).0 && place(3.0).1 > place(1.0).1 + 6);
    }

    #[test]
    fn an_empty_sheet_is_its_title() {
        let image = ContactSheet::new("s", "", 0).to_image();
        assert!(image.width() > 0 && image.height() > 0);
        let image = ContactSheet::new("s", "title", 3).to_image();
        assert!(image.texels().iter().any(|texel| texel.x == 0.7));
    }

    #[test]
    fn pictures_of_different_sizes_and_none_fit() {
        let mut sheet = ContactSheet::new("s", "t", 3);
        sheet.banner = Some(RgbImage::filled(90, 4, Vec3::ONE));
        for side in [0, 5, 40] {
            sheet.panels.push(Panel::new("caption of many words", RgbImage::filled(side, side, Vec3::ONE)));
        }
        let image = sheet.to_image();
        let white = image.texels().iter().filter(|texel| texel.x == 1.0).count();
        assert_eq!(white, 90 * 4 + 25 + 1600);
    }

    #[test]
    fn captions_break_at_spaces_and_long_words_anywhere() {
        assert_eq!(wrapped("ab cd ef", 5 * font::ADVANCE, 1), ["ab cd", "ef"]);
        assert_eq!(wrapped("abcdefg h\n\ni", 3 * font::ADVANCE, 1), ["abc", "def", "g h", "", "i"]);
        assert_eq!(wrapped("ab", 0, 1), ["a", "b"]);
    }
}
