//! What an item of a manifest is: every value that may be drawn is, by the item's number alone.

use std::collections::BTreeMap;

use toml::{Table, Value};

use crate::StudioError;

/// A table of a manifest in which any value may be one of these in its place:
///
/// - `{ list = [...] }` and `{ from = a, to = b, steps = n }`, both ends included: axes of a grid that the items fill, in the alphabetical order of their
///   places, the last one fastest; when it is full it begins again; steps are whole numbers where the ends and all between are;
/// - `{ any = [...] }`: one of these, by chance;
/// - `{ min = a, max = b }`: evenly spread, arrays number by number; whole numbers are drawn from whole ones, both ends included.
#[derive(Clone, Debug)]
pub struct Template {
    table: Table,
    seed: u64,
    /// Places of the grid's axes, with how many values each has, and how many items have one value after another.
    axes: BTreeMap<String, (u64, u64)>,
    cells: u64,
}

/// What stands in a value's place.
enum Rule<'a> {
    Grid(Grid<'a>),
    Any(&'a [Value]),
    Between(&'a Value, &'a Value),
}

enum Grid<'a> {
    List(&'a [Value]),
    Steps {
        from: f64,
        to: f64,
        steps: u64,
    },
    /// Whole numbers, so far apart.
    Whole {
        from: i64,
        step: i64,
        steps: u64,
    },
}

impl Grid<'_> {
    fn len(&self) -> u64 {
        match self {
            Self::List(values) => values.len() as u64,
            Self::Steps { steps, .. } | Self::Whole { steps, .. } => *steps,
        }
    }

    fn value(&self, number: u64) -> Value {
        match self {
            Self::List(values) => values[number as usize].clone(),
            Self::Whole { from, step, .. } => Value::Integer(from + step * number as i64),
            Self::Steps { from, steps: 1, .. } => Value::Float(*from),
            Self::Steps { from, to, steps } => {
                Value::Float(from + (to - from) * number as f64 / (steps - 1) as f64)
            }
        }
    }
}

/// Whole numbers from a whole one to another, where all between are.
fn whole_steps(from: &Value, to: &Value, steps: u64) -> Option<Grid<'static>> {
    let from = from.as_integer()?;
    let (way, gaps) = (to.as_integer()?.checked_sub(from)?, i64::try_from(steps - 1).ok()?);
    match gaps {
        0 => Some(Grid::Whole { from, step: 0, steps }),
        _ => (way % gaps == 0).then_some(Grid::Whole { from, step: way / gaps, steps }),
    }
}

fn wrong(place: &str, what: &str) -> StudioError {
    StudioError::Request(format!("`{place}` {what}"))
}

fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Integer(number) => Some(*number as f64),
        Value::Float(number) => Some(*number),
        _ => None,
    }
    .filter(|number| number.is_finite())
}

/// The rule that a table is; `None` for one that is a table.
fn rule<'a>(table: &'a Table, place: &str) -> Result<Option<Rule<'a>>, StudioError> {
    let keys: Vec<&str> = table.keys().map(String::as_str).collect();
    let values = |key: &str| match table.get(key).and_then(Value::as_array) {
        Some(values) if !values.is_empty() => Ok(values.as_slice()),
        _ => Err(wrong(place, &format!("has no values: `{key}` is a list of at least one"))),
    };
    Ok(Some(match *keys {
        ["list"] => Rule::Grid(Grid::List(values("list")?)),
        ["any"] => Rule::Any(values("any")?),
        ["from", "steps", "to"] => {
            let steps =
                table["steps"].as_integer().and_then(|steps| u64::try_from(steps).ok()).filter(|n| *n > 0);
            match (number(&table["from"]), number(&table["to"]), steps) {
                (Some(from), Some(to), Some(steps)) => {
                    Rule::Grid(whole_steps(&table["from"], &table["to"], steps).unwrap_or(Grid::Steps {
                        from,
                        to,
                        steps,
                    }))
                }
                _ => return Err(wrong(place, "goes from a number to a number in a whole number of steps")),
            }
        }
        ["max", "min"] => Rule::Between(&table["min"], &table["max"]),
        _ => return Ok(None),
    }))
}

fn below(place: &str, name: &str) -> String {
    if place.is_empty() { name.to_owned() } else { format!("{place}.{name}") }
}

impl Template {
    /// Takes a table whose random values are those of `seed`.
    ///
    /// # Errors
    /// [`StudioError::Request`] for rules that give no value.
    pub fn new(table: Table, seed: u64) -> Result<Self, StudioError> {
        let mut lengths = Vec::new();
        find_axes(&Value::Table(table.clone()), "", &mut lengths)?;
        lengths.sort();
        let (mut axes, mut cells) = (BTreeMap::new(), 1_u64);
        for (place, length) in lengths.into_iter().rev() {
            let stride = cells;
            cells = cells.checked_mul(length).ok_or_else(|| wrong(&place, "makes the grid too large"))?;
            axes.insert(place, (length, stride));
        }
        let template = Self { table, seed, axes, cells };
        // What can be wrong with an item's values is so for all.
        template.item(0)?;
        Ok(template)
    }

    /// Items that fill the grid once.
    pub fn cells(&self) -> u64 {
        self.cells
    }

    /// The table of an item.
    ///
    /// # Errors
    /// As [`Template::new`].
    pub fn item(&self, item: u64) -> Result<Table, StudioError> {
        let drawn = self.table.iter().map(|(key, value)| Ok((key.clone(), self.drawn(value, key, item)?)));
        drawn.collect()
    }

    fn drawn(&self, value: &Value, place: &str, item: u64) -> Result<Value, StudioError> {
        Ok(match value {
            Value::Array(values) => {
                let drawn = (0..)
                    .zip(values)
                    .map(|(i, value)| self.drawn(value, &below(place, &i.to_string()), item));
                Value::Array(drawn.collect::<Result<_, _>>()?)
            }
            Value::Table(table) => match rule(table, place)? {
                None => {
                    let drawn = table
                        .iter()
                        .map(|(key, value)| Ok((key.clone(), self.drawn(value, &below(place, key), item)?)));
                    Value::Table(drawn.collect::<Result<_, StudioError>>()?)
                }
                Some(Rule::Grid(grid)) => {
                    let (length, stride) = self.axes.get(place).copied().unwrap_or((1, 1));
                    grid.value(item / stride % length)
                }
                Some(Rule::Any(values)) => {
                    values[self.whole(item, place, values.len() as u64) as usize].clone()
                }
                Some(Rule::Between(least, most)) => self.between(least, most, place, item)?,
            },
            other => other.clone(),
        })
    }

    fn between(&self, least: &Value, most: &Value, place: &str, item: u64) -> Result<Value, StudioError> {
        match (least, most) {
            (Value::Array(least), Value::Array(most)) if least.len() == most.len() => {
                let pairs = (0..).zip(least.iter().zip(most));
                let drawn = pairs
                    .map(|(i, (least, most))| self.between(least, most, &below(place, &i.to_string()), item));
                Ok(Value::Array(drawn.collect::<Result<_, _>>()?))
            }
            (Value::Integer(least), Value::Integer(most)) if least <= most => {
                let count = most.abs_diff(*least).saturating_add(1);
                Ok(Value::Integer(least.saturating_add_unsigned(self.whole(item, place, count))))
            }
            _ => match number(least).zip(number(most)) {
                Some((least, most)) if least <= most => {
                    Ok(Value::Float(least + (most - least) * self.share(item, place)))
                }
                _ => Err(wrong(place, "lies between two numbers, or lists of them, `min` not above `max`")),
            },
        }
    }

    /// A whole number below `count`. Its bias is below `count` / 2^53.
    fn whole(&self, item: u64, place: &str, count: u64) -> u64 {
        ((self.share(item, place) * count as f64) as u64).min(count - 1)
    }

    /// A number in [0, 1) for one item and place.
    fn share(&self, item: u64, place: &str) -> f64 {
        let place = place.bytes().fold(0, |state, byte| mixed(state ^ u64::from(byte)));
        let bits = mixed(mixed(mixed(self.seed) ^ item) ^ place);
        (bits >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// One step of SplitMix64 (Steele, Lea and Flood 2014): every bit of the state decides every bit of the result.
fn mixed(state: u64) -> u64 {
    let z = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

fn find_axes(value: &Value, place: &str, axes: &mut Vec<(String, u64)>) -> Result<(), StudioError> {
    match value {
        Value::Array(values) => {
            (0..).zip(values).try_for_each(|(i, value)| find_axes(value, &below(place, &i.to_string()), axes))
        }
        Value::Table(table) => match rule(table, place)? {
            Some(Rule::Grid(grid)) => {
                axes.push((place.to_owned(), grid.len()));
                Ok(())
            }
            Some(_) => Ok(()),
            None => table.iter().try_for_each(|(key, value)| find_axes(value, &below(place, key), axes)),
        },
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn template(text: &str, seed: u64) -> Result<Template, String> {
        Template::new(text.parse().unwrap(), seed).map_err(|error| error.to_string())
    }

    #[test]
    fn a_grid_is_filled_and_begins_again() {
        let template = template(
            "a.b = { list = ['x', 'y'] }\nc = { from = 0, to = 90, steps = 3 }\nd = 7\n[[e]]\nf = { list = [1, 2] }",
            1,
        )
        .unwrap();
        assert_eq!(template.cells(), 12);
        let items: Vec<String> = (0..12).map(|n| template.item(n).unwrap().to_string()).collect();
        for (number, item) in items.iter().enumerate() {
            assert_eq!(items.iter().position(|other| other == item), Some(number), "each cell once");
            assert_eq!(template.item(number as u64 + 24).unwrap().to_string(), *item);
        }
        let first = template.item(0).unwrap();
        assert_eq!((first["c"].as_integer(), first["d"].as_integer()), (Some(0), Some(7)));
        let last = template.item(11).unwrap();
        assert_eq!((last["a"]["b"].as_str(), last["c"].as_integer()), (Some("y"), Some(90)));
        // The last place in the alphabet changes first.
        assert_eq!(template.item(1).unwrap()["e"][0]["f"].as_integer(), Some(2));
    }

    #[test]
    fn steps_are_whole_where_ends_and_all_between_are() {
        let values = |text: &str| {
            let template = template(&format!("a = {text}"), 1).unwrap();
            (0..template.cells()).map(|n| template.item(n).unwrap()["a"].clone()).collect::<Vec<_>>()
        };
        let whole = |numbers: &[i64]| numbers.iter().copied().map(Value::Integer).collect::<Vec<_>>();
        assert_eq!(values("{ from = 20, to = 10, steps = 3 }"), whole(&[20, 15, 10]));
        assert_eq!(values("{ from = 4, to = 9, steps = 1 }"), whole(&[4]));
        assert_eq!(values("{ from = 0, to = 1, steps = 3 }"), [0.0, 0.5, 1.0].map(Value::Float));
        assert_eq!(values("{ from = 0.0, to = 2, steps = 3 }"), [0.0, 1.0, 2.0].map(Value::Float));
    }

    #[test]
    fn chance_depends_on_seed_item_and_place_alone_and_is_even() {
        let text = "a = { min = 0.0, max = 2.0 }\nb = { min = [1, 0.5], max = [3, 0.5] }\nc = { any = ['x', 'y', 'z'] }";
        let (one, other) = (template(text, 1).unwrap(), template(text, 2).unwrap());
        let alone = template("a = { min = 0.0, max = 2.0 }", 1).unwrap();
        let (mut sum, mut counts) = (0.0, [0; 3]);
        let count = 3000;
        for number in 0..count {
            let item = one.item(number).unwrap();
            let a = item["a"].as_float().unwrap();
            assert_eq!(alone.item(number).unwrap()["a"].as_float(), Some(a));
            assert_ne!(other.item(number).unwrap()["a"].as_float(), Some(a));
            assert_eq!(item["b"][1].as_float(), Some(0.5));
            counts[item["b"][0].as_integer().unwrap() as usize - 1] += 1;
            sum += a;
        }
        let mean = sum / count as f64;
        // The standard error of the mean is 0.0105, that of a third 26.
        assert!((mean - 1.0).abs() < 0.05, "{mean}");
        assert!(counts.iter().all(|share: &i32| share.abs_diff(1000) < 110), "{counts:?}");
    }

    #[test]
    fn rules_that_give_nothing_are_named() {
        for (text, why) in [
            ("a.b = { list = [] }", "`a.b` has no values"),
            ("a = { any = 3 }", "`a` has no values"),
            ("a = { from = 0, to = 'x', steps = 2 }", "`a` goes from a number"),
            ("a = { from = 0, to = 1, steps = 0 }", "`a` goes from a number"),
            ("a = { min = 2, max = 1 }", "`a` lies between"),
            ("a = { min = [1], max = [1, 2] }", "`a` lies between"),
            ("a = { min = nan, max = 1 }", "`a` lies between"),
        ] {
            let error = template(text, 0).unwrap_err();
            assert!(error.starts_with(why), "{text}: {error}");
        }
    }
}
