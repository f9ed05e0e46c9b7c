use std::fmt::Write;

use super::axis::Range;
use super::{Axis, Plot, Series, Style};

/// Inner corners of the drawing area and height of the whole picture, in pixels.
const LEFT: f64 = 78.0;
const TOP: f64 = 42.0;
const WIDTH: f64 = 520.0;
const HEIGHT: f64 = 340.0;
const BELOW: f64 = 58.0;
const LEGEND_GAP: f64 = 18.0;
const LEGEND_LINE: f64 = 20.0;

/// Colours that are told apart by all readers (Okabe and Ito 2008), darkened where they were too light on white.
const COLORS: [&str; 8] =
    ["#0072b2", "#d55e00", "#009e73", "#b1568c", "#3a9bd0", "#b8860b", "#000000", "#7a7a7a"];

/// Marker outlines around the origin, five pixels in radius.
const MARKERS: [&str; 8] = [
    "M-4,0a4,4 0 1,0 8,0a4,4 0 1,0 -8,0z",
    "M-3.6,-3.6h7.2v7.2h-7.2z",
    "M0,-5l4.6,8h-9.2z",
    "M0,-5l5,5l-5,5l-5,-5z",
    "M0,5l4.6,-8h-9.2z",
    "M-1.6,-4.6h3.2v3h3v3.2h-3v3h-3.2v-3h-3v-3.2h3z",
    "M-5,-2.4h10v4.8h-10z",
    "M-2.4,-5h4.8v10h-4.8z",
];

/// The whole file.
pub(super) fn write(plot: &Plot) -> String {
    let points = || plot.series.iter().flat_map(|series| &series.points).filter(|p| plot.drawable(**p));
    let ranges = (plot.x.range(points().map(|point| point.0)), plot.y.range(points().map(|point| point.1)));
    let longest = plot.series.iter().map(|series| series.label().chars().count()).max();
    let legend_width = longest.map_or(0.0, |characters| 34.0 + 6.8 * characters as f64);
    let legend_height = TOP + LEGEND_LINE * plot.series.len() as f64;
    let width = LEFT + WIDTH + LEGEND_GAP + legend_width.max(12.0);
    let height = (TOP + HEIGHT + BELOW).max(legend_height + 12.0);

    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{height:.0}\" \
         viewBox=\"0 0 {width:.0} {height:.0}\" font-family=\"DejaVu Sans, Arial, sans-serif\" font-size=\"12\">\n\
         <title>{title}</title>\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n\
         <text x=\"{LEFT}\" y=\"24\" font-size=\"15\" font-weight=\"bold\">{title}</text>\n",
        title = escaped(&plot.title),
    );
    grid(&mut svg, plot, ranges);
    // Points inside the drawing area only: fitted lines may leave it.
    push(
        &mut svg,
        format_args!(
            "<clipPath id=\"area\"><rect x=\"{LEFT}\" y=\"{TOP}\" width=\"{WIDTH}\" height=\"{HEIGHT}\"/></clipPath>\n"
        ),
    );
    for (index, series) in plot.series.iter().enumerate() {
        draw(&mut svg, plot, series, index, ranges);
    }
    if points().next().is_none() {
        let (x, y) = (LEFT + 0.5 * WIDTH, TOP + 0.5 * HEIGHT);
        push(
            &mut svg,
            format_args!(
                "<text x=\"{x}\" y=\"{y}\" text-anchor=\"middle\" fill=\"#555555\">no data</text>\n"
            ),
        );
    }
    svg + "</svg>\n"
}

/// Frame, grid lines, tick labels and axis headings.
fn grid(svg: &mut String, plot: &Plot, (x_range, y_range): (Range, Range)) {
    let (right, bottom) = (LEFT + WIDTH, TOP + HEIGHT);
    for tick in plot.x.ticks(x_range) {
        let x = across(&plot.x, tick.value, x_range);
        let color = if tick.label.is_empty() { "#f0f0f0" } else { "#d5d5d5" };
        push(
            svg,
            format_args!(
                "<path d=\"M{x:.1},{TOP}V{bottom}\" stroke=\"{color}\"/>\n<text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>\n",
                bottom + 18.0,
                tick.label
            ),
        );
    }
    for tick in plot.y.ticks(y_range) {
        let y = down(&plot.y, tick.value, y_range);
        let color = if tick.label.is_empty() { "#f0f0f0" } else { "#d5d5d5" };
        push(
            svg,
            format_args!(
                "<path d=\"M{LEFT},{y:.1}H{right}\" stroke=\"{color}\"/>\n<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>\n",
                LEFT - 8.0,
                y + 4.0,
                tick.label
            ),
        );
    }
    push(
        svg,
        format_args!(
            "<rect x=\"{LEFT}\" y=\"{TOP}\" width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"none\" stroke=\"#444444\"/>\n"
        ),
    );
    let (middle_x, middle_y) = (LEFT + 0.5 * WIDTH, TOP + 0.5 * HEIGHT);
    push(
        svg,
        format_args!(
            "<text x=\"{middle_x}\" y=\"{}\" text-anchor=\"middle\" font-size=\"13\">{}</text>\n\
             <text transform=\"translate(20,{middle_y}) rotate(-90)\" text-anchor=\"middle\" font-size=\"13\">{}</text>\n",
            bottom + 42.0,
            escaped(&plot.x.heading()),
            escaped(&plot.y.heading()),
        ),
    );
}

/// One series, and its line of the legend.
fn draw(svg: &mut String, plot: &Plot, series: &Series, index: usize, (x_range, y_range): (Range, Range)) {
    let (color, marker) = (COLORS[index % COLORS.len()], MARKERS[index % MARKERS.len()]);
    let place = |(x, y): (f64, f64)| (across(&plot.x, x, x_range), down(&plot.y, y, y_range));
    let dashes = if series.style == Style::Dashed { " stroke-dasharray=\"6 4\"" } else { "" };
    push(svg, format_args!("<g clip-path=\"url(#area)\" stroke=\"{color}\" fill=\"none\">\n"));
    if series.style != Style::Points {
        let mut path = String::new();
        let mut pen_down = false;
        for &point in &series.points {
            if plot.drawable(point) {
                let (x, y) = place(point);
                push(&mut path, format_args!("{}{x:.1},{y:.1}", if pen_down { 'L' } else { 'M' }));
                pen_down = true;
            } else {
                pen_down = false;
            }
        }
        push(svg, format_args!("<path d=\"{path}\" stroke-width=\"1.8\"{dashes}/>\n"));
    }
    if let Some(law) = series.law() {
        // Enough steps to look smooth on linear axes.
        let at = |step: i32| {
            let share = f64::from(step) / 32.0;
            let (low, high) = x_range;
            let x = match plot.x.scale {
                super::Scale::Linear => low + share * (high - low),
                super::Scale::Logarithmic => low * (high / low).powf(share),
            };
            (x, law.at(x))
        };
        let line: Vec<String> = (0..=32)
            .map(at)
            .filter(|&point| plot.drawable(point))
            .map(|point| {
                let (x, y) = place(point);
                format!("{x:.1},{:.1}", y.clamp(-1e4, 1e4))
            })
            .collect();
        push(
            svg,
            format_args!(
                "<polyline points=\"{}\" stroke-width=\"1\" stroke-opacity=\"0.45\" stroke-dasharray=\"2 3\"/>\n",
                line.join(" ")
            ),
        );
    }
    push(svg, format_args!("</g>\n<g fill=\"{color}\">\n"));
    for &point in series.points.iter().filter(|point| plot.drawable(**point)) {
        let (x, y) = place(point);
        push(svg, format_args!("<path d=\"{marker}\" transform=\"translate({x:.1},{y:.1})\"/>\n"));
    }
    let (x, y) = (LEFT + WIDTH + LEGEND_GAP, TOP + 8.0 + LEGEND_LINE * index as f64);
    if series.style != Style::Points {
        push(
            svg,
            format_args!("<path d=\"M{x},{y}h24\" stroke=\"{color}\" stroke-width=\"1.8\"{dashes}/>\n"),
        );
    }
    push(
        svg,
        format_args!(
            "<path d=\"{marker}\" transform=\"translate({},{y})\"/>\n<text x=\"{}\" y=\"{}\" fill=\"#000000\">{}</text>\n</g>\n",
            x + 12.0,
            x + 32.0,
            y + 4.0,
            escaped(&series.label()),
        ),
    );
}

/// Pixels from the left.
fn across(axis: &Axis, value: f64, range: Range) -> f64 {
    LEFT + WIDTH * axis.place(value, range)
}

/// Pixels from the top.
fn down(axis: &Axis, value: f64, range: Range) -> f64 {
    TOP + HEIGHT * (1.0 - axis.place(value, range))
}

fn push(text: &mut String, arguments: std::fmt::Arguments<'_>) {
    // Writing to a string cannot fail.
    let _ = text.write_fmt(arguments);
}

/// For text and attributes of XML. Control characters, which XML forbids, are dropped.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped += "&amp;",
            '<' => escaped += "&lt;",
            '>' => escaped += "&gt;",
            '"' => escaped += "&quot;",
            '\'' => escaped += "&apos;",
            _ if character.is_control() => {}
            _ => escaped.push(character),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot(points: Vec<(f64, f64)>) -> Plot {
        let mut plot = Plot::new("p", "a < b & \"c\"", Axis::linear("x", "m"), Axis::logarithmic("y", "ms"));
        plot.series.push(Series::new("s<1>\u{1b}", points));
        plot
    }

    #[test]
    fn markup_in_names_is_escaped() {
        let svg = plot(vec![(1.0, 2.0)]).to_svg();
        assert!(svg.contains("a &lt; b &amp; &quot;c&quot;") && svg.contains("s&lt;1&gt;<"));
        assert!(svg.contains("x [m]") && svg.contains("y [ms]"));
        assert_eq!(svg.matches("<g").count(), svg.matches("</g>").count());
    }

    #[test]
    fn points_that_have_no_place_interrupt_the_line() {
        let svg = plot(vec![(1.0, 2.0), (2.0, 0.0), (3.0, 4.0), (f64::NAN, 4.0), (4.0, 8.0)]).to_svg();
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
        let line = svg.lines().find(|line| line.contains("stroke-width=\"1.8\"/>")).unwrap();
        assert_eq!(line.matches('M').count(), 3);
        assert_eq!(line.matches('L').count(), 0);
    }

    #[test]
    fn a_plot_of_nothing_says_so() {
        assert!(plot(Vec::new()).to_svg().contains("no data"));
        assert!(plot(vec![(f64::NAN, 1.0)]).to_svg().contains("no data"));
        let nothing = Plot::new("p", "", Axis::linear("", ""), Axis::linear("", ""));
        assert!(nothing.to_svg().ends_with("</svg>\n"));
    }
}
