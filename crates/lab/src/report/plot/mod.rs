mod axis;
mod svg;

pub use axis::{Axis, Scale};

use serde_json::{Value, json};

use crate::report::regression::PowerLaw;

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Style {
    /// Markers joined by lines.
    #[default]
    Line,
    /// Markers alone.
    Points,
    /// Markers joined by dashes, for what others measured.
    Dashed,
}

/// One set of points.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// Points in the units of the axes, joined in this order. One that is not finite, or not positive on a logarithmic axis, is
    /// not drawn and interrupts the line.
    pub points: Vec<(f64, f64)>,
    /// How it is drawn.
    pub style: Style,
    /// Fit a power law, draw it thin and tell its exponent in the legend (a straight line where both axes are logarithmic).
    pub slope: bool,
}

impl Series {
    /// A line with markers.
    pub fn new(name: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Self { name: name.into(), points, style: Style::default(), slope: false }
    }

    /// The same in another style.
    #[must_use]
    pub fn styled(self, style: Style) -> Self {
        Self { style, ..self }
    }

    /// The same with its fitted slope.
    #[must_use]
    pub fn with_slope(self) -> Self {
        Self { slope: true, ..self }
    }

    /// The fitted law, where one is asked for and the points allow one.
    pub fn law(&self) -> Option<PowerLaw> {
        self.slope.then(|| PowerLaw::fit(&self.points)).flatten()
    }

    fn label(&self) -> String {
        match self.law() {
            Some(law) => format!("{} (slope {:.2})", self.name, law.exponent),
            None => self.name.clone(),
        }
    }
}

/// Several series over two axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Plot {
    /// Stem of its file's name.
    pub name: String,
    /// The line above it.
    pub title: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// What is drawn, each in a colour and with a marker of its own (they repeat after eight).
    pub series: Vec<Series>,
}

impl Plot {
    /// A plot without series.
    pub fn new(name: impl Into<String>, title: impl Into<String>, x: Axis, y: Axis) -> Self {
        Self { name: name.into(), title: title.into(), x, y, series: Vec::new() }
    }

    /// A whole SVG file, black on white, without any reference to others.
    pub fn to_svg(&self) -> String {
        svg::write(self)
    }

    /// `{name, title, x, y, series: [{name, points: [[x, y]], slope}]}`; what is not finite is null.
    pub fn to_json(&self) -> Value {
        let series: Vec<Value> = self
            .series
            .iter()
            .map(|series| {
                let slope = series.law().map(|law| law.exponent);
                json!({ "name": series.name, "points": series.points, "slope": slope })
            })
            .collect();
        json!({
            "name": self.name, "title": self.title,
            "x": self.x.heading(), "y": self.y.heading(), "series": series,
        })
    }

    /// Points that can be drawn.
    fn drawable(&self, (x, y): (f64, f64)) -> bool {
        self.x.takes(x) && self.y.takes(y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_are_in_the_legend_and_the_json() {
        let mut plot = Plot::new("p", "t", Axis::logarithmic("x", ""), Axis::logarithmic("y", ""));
        plot.series.push(Series::new("a", vec![(1.0, 1.0), (10.0, 100.0)]).with_slope());
        plot.series.push(Series::new("b", vec![(1.0, f64::NAN)]).with_slope().styled(Style::Points));
        assert!(plot.to_svg().contains("a (slope 2.00)"));
        let json = plot.to_json();
        assert!((json["series"][0]["slope"].as_f64().unwrap() - 2.0).abs() < 1e-9);
        assert!(json["series"][1]["slope"].is_null() && json["series"][1]["points"][0][1].is_null());
    }
}
