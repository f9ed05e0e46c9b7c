use crate::report::number::significant;

/// How values are spread along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Evenly; includes 0 unless some value is negative.
    Linear,
    /// By their logarithm; only positive values are drawn.
    Logarithmic,
}

/// One axis of a plot.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// What is measured along it.
    pub label: String,
    /// Its unit, empty for a pure number.
    pub unit: String,
    /// How values are spread.
    pub scale: Scale,
    /// Where to put ticks; empty leaves it to the axis.
    pub ticks: Vec<f64>,
}

/// A place on an axis that is told.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tick {
    pub value: f64,
    /// Empty for a minor one.
    pub label: String,
}

/// Lower and upper end of an axis: finite, in order, and positive on a logarithmic one.
pub(super) type Range = (f64, f64);

impl Axis {
    /// An evenly spread axis.
    pub fn linear(label: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { label: label.into(), unit: unit.into(), scale: Scale::Linear, ticks: Vec::new() }
    }

    /// A logarithmic axis.
    pub fn logarithmic(label: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { scale: Scale::Logarithmic, ..Self::linear(label, unit) }
    }

    /// The same with ticks at these values.
    #[must_use]
    pub fn with_ticks(self, ticks: Vec<f64>) -> Self {
        Self { ticks, ..self }
    }

    /// `label [unit]`.
    pub(super) fn heading(&self) -> String {
        if self.unit.is_empty() { self.label.clone() } else { format!("{} [{}]", self.label, self.unit) }
    }

    /// Whether a value has a place on it.
    pub(super) fn takes(&self, value: f64) -> bool {
        // Beyond these, differences and ratios overflow.
        match self.scale {
            Scale::Linear => value.abs() <= 1e300,
            Scale::Logarithmic => (1e-150..=1e150).contains(&value),
        }
    }

    /// Ends that hold all of `values` that the axis takes, with a margin.
    pub(super) fn range(&self, values: impl Iterator<Item = f64>) -> Range {
        let values = values.filter(|&value| self.takes(value));
        let (low, high) =
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        match self.scale {
            _ if low > high => (if self.scale == Scale::Linear { 0.0 } else { 0.1 }, 1.0),
            Scale::Logarithmic => {
                let margin = (high / low).powf(0.06).max(1.05);
                if high / low < 1.01 { (low / 2.0, high * 2.0) } else { (low / margin, high * margin) }
            }
            Scale::Linear => {
                let (low, high) = if low >= 0.0 { (0.0, high) } else { (low, high.max(0.0)) };
                let margin = 0.06 * (high - low);
                match (low, high) {
                    (0.0, 0.0) => (0.0, 1.0),
                    (0.0, high) => (0.0, high + margin),
                    (low, high) => (low - margin, high + margin),
                }
            }
        }
    }

    /// Place of a value between the ends, 0..1 inside them.
    pub(super) fn place(&self, value: f64, (low, high): Range) -> f64 {
        match self.scale {
            Scale::Linear => (value - low) / (high - low),
            Scale::Logarithmic => (value / low).ln() / (high / low).ln(),
        }
    }

    /// Ticks between the ends, in order.
    pub(super) fn ticks(&self, range: Range) -> Vec<Tick> {
        let (low, high) = range;
        let told = |value: f64| Tick { value, label: tick_label(value) };
        if !self.ticks.is_empty() {
            let inside = self.ticks.iter().copied().filter(|v| self.takes(*v) && (low..=high).contains(v));
            return inside.map(told).collect();
        }
        let linear = || linear_ticks(low, high).into_iter().map(told).collect();
        if self.scale == Scale::Linear {
            return linear();
        }
        let decades = (high / low).log10();
        if decades < 0.7 {
            return linear();
        }
        let step = (decades / 8.0).ceil() as i32;
        let (first, last) = (low.log10().floor() as i32, high.log10().ceil() as i32);
        let mut ticks = Vec::new();
        for exponent in first..=last {
            for digit in 1..10 {
                let value = format!("{digit}e{exponent}").parse::<f64>().unwrap_or(f64::NAN);
                let is_told = match digit {
                    1 => exponent.rem_euclid(step) == 0,
                    2 | 5 => decades < 2.5,
                    _ => false,
                };
                if (low..=high).contains(&value) && (is_told || step == 1) {
                    ticks.push(if is_told { told(value) } else { Tick { value, label: String::new() } });
                }
            }
        }
        ticks
    }
}

/// Four to ten multiples of 1, 2 or 5 times a power of ten.
fn linear_ticks(low: f64, high: f64) -> Vec<f64> {
    let rough = (high - low) / 6.0;
    let decade = 10_f64.powf(rough.log10().floor());
    let steps = [10.0, 5.0, 2.0, 1.0].map(|factor| factor * decade);
    let step = steps.into_iter().find(|&step| step <= 1.5 * rough).unwrap_or(rough);
    let (first, last) = ((low / step).ceil(), (high / step).floor());
    if !(step > 0.0 && last - first < 100.0) {
        return Vec::new();
    }
    // 0.1 is no sum of powers of two: 3 steps of it are shown as 0.3 by rounding, see `tick_label`.
    (0..=(last - first) as u32).map(|i| (first + f64::from(i)) * step).collect()
}

/// As few digits as tell the value.
fn tick_label(value: f64) -> String {
    let text = significant(value, 6);
    let (mantissa, exponent) = match text.split_once('e') {
        Some((mantissa, exponent)) => (mantissa, format!("e{exponent}")),
        None => (text.as_str(), String::new()),
    };
    let trimmed =
        if mantissa.contains('.') { mantissa.trim_end_matches('0').trim_end_matches('.') } else { mantissa };
    format!("{trimmed}{exponent}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis, range: Range) -> Vec<String> {
        axis.ticks(range).into_iter().map(|tick| tick.label).filter(|label| !label.is_empty()).collect()
    }

    #[test]
    fn linear_ticks_are_round() {
        let axis = Axis::linear("", "");
        assert_eq!(labels(&axis, (0.0, 0.32)), ["0", "0.05", "0.1", "0.15", "0.2", "0.25", "0.3"]);
        assert_eq!(labels(&axis, (-7.0, 43.0)), ["0", "10", "20", "30", "40"]);
        assert!(labels(&axis, (0.0, 1.0)).len() >= 5);
        assert!(labels(&axis, (1e299, 1.0000001e300)).len() < 12);
    }

    #[test]
    fn logarithmic_ticks_are_decades_with_more_between_where_there_is_room() {
        let axis = Axis::logarithmic("", "");
        assert_eq!(labels(&axis, (0.9, 1100.0)), ["1", "10", "100", "1000"]);
        assert_eq!(labels(&axis, (0.9, 60.0)), ["1", "2", "5", "10", "20", "50"]);
        // Less than a decade: round values.
        assert_eq!(labels(&axis, (110.0, 160.0)), ["110", "120", "130", "140", "150", "160"]);
        // Thirty decades: not thirty labels.
        let many = axis.ticks((1e-15, 1e15));
        assert!(many.len() <= 9 && many.iter().all(|tick| !tick.label.is_empty()));
        // Minor ticks have no label.
        assert!(axis.ticks((0.9, 1100.0)).iter().any(|tick| tick.label.is_empty() && tick.value == 300.0));
    }

    #[test]
    fn wanted_ticks_are_kept_if_inside() {
        let axis = Axis::logarithmic("", "").with_ticks(vec![0.0, 128.0, 256.0, 4096.0, f64::NAN]);
        assert_eq!(labels(&axis, (100.0, 1000.0)), ["128", "256"]);
    }

    #[test]
    fn ranges_hold_their_values_and_survive_anything() {
        let (linear, logarithmic) = (Axis::linear("", ""), Axis::logarithmic("", ""));
        assert_eq!(linear.range([2.0, 4.0].into_iter()).0, 0.0);
        assert!(linear.range([-2.0, 4.0].into_iter()).0 < -2.0);
        let (low, high) = logarithmic.range([5.0, 50.0, 0.0, -1.0, f64::NAN, f64::INFINITY].into_iter());
        assert!(low > 0.0 && low < 5.0 && high > 50.0 && high < 100.0);
        for axis in [&linear, &logarithmic] {
            for values in
                [vec![], vec![0.0], vec![f64::NAN], vec![3.0, 3.0], vec![1e-150, 1e150], vec![-1e300, 1e300]]
            {
                let (low, high) = axis.range(values.clone().into_iter());
                assert!(low.is_finite() && high.is_finite() && low < high, "{values:?}: {low} {high}");
                assert!(axis.ticks((low, high)).len() < 100, "{values:?}");
            }
        }
    }
}
