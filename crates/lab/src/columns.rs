//! Columns and sentences that many tables and sections have.

use std::rc::Rc;

use crate::report::Cell;
use crate::timing::Spread;
use crate::{Environment, View};

/// Headings of [`time_cells`].
pub(crate) const TIME_COLUMNS: [(&str, &str); 4] =
    [("frame, median", "ms"), ("minimum", "ms"), ("first quartile", "ms"), ("third quartile", "ms")];

/// Median, minimum and quartiles, for four columns [ms].
pub(crate) fn time_cells(spread: Option<&Spread>) -> [Cell; 4] {
    let cell = |value: fn(&Spread) -> f64| Cell::from(spread.map(value));
    [
        cell(|spread| spread.median),
        cell(|spread| spread.minimum),
        cell(|spread| spread.first_quartile),
        cell(|spread| spread.third_quartile),
    ]
}

/// Mebibytes.
pub(crate) fn mebibytes(bytes: u64) -> f64 {
    bytes as f64 / f64::from(1 << 20)
}

/// Mean and greatest of what was measured; none for nothing.
pub(crate) fn mean_and_worst(values: &[f64]) -> Option<[f64; 2]> {
    let worst = values.iter().copied().reduce(f64::max)?;
    Some([values.iter().sum::<f64>() / values.len() as f64, worst])
}

/// One sentence for each scene or environment for which a built-in stands in.
pub(crate) fn stand_ins(views: &[Rc<View>], environments: &[Rc<Environment>]) -> Vec<String> {
    let sentence = |what: &str, name: &str, stand_in: &str| {
        format!("The {what} '{name}' is not in the data folder; the built-in '{stand_in}' stands in for it.")
    };
    let views = views.iter().filter_map(|view| Some(sentence("scene", view.name, view.stand_in?)));
    let environments = environments
        .iter()
        .filter_map(|environment| Some(sentence("environment", environment.name, environment.stand_in?)));
    views.chain(environments).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_has_no_mean() {
        assert_eq!(mean_and_worst(&[0.25, 0.75]), Some([0.5, 0.75]));
        assert_eq!(mean_and_worst(&[]), None);
    }
}
