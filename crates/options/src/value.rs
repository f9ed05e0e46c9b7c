use std::fmt;

use serde::de::{Deserialize, Deserializer, SeqAccess, Visitor};
use serde::ser::{Serialize, Serializer};

/// The value of any option.
#[derive(Clone, Debug, PartialEq)]
pub enum OptionValue {
    /// Yes or no.
    Bool(bool),
    /// A whole number.
    Whole(i64),
    /// A number.
    Number(f32),
    /// The name of a choice.
    Name(String),
    /// Width and height.
    Size([u32; 2]),
    /// Linear Rec. 709.
    Color([f32; 3]),
    /// Left to the program.
    Automatic,
}

impl fmt::Display for OptionValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bool(value) => value.fmt(f),
            Self::Whole(value) => value.fmt(f),
            Self::Number(value) => value.fmt(f),
            Self::Name(value) => value.fmt(f),
            Self::Size([width, height]) => write!(f, "{width}x{height}"),
            Self::Color([red, green, blue]) => write!(f, "{red}/{green}/{blue}"),
            Self::Automatic => f.write_str("automatic"),
        }
    }
}

impl Serialize for OptionValue {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Bool(value) => value.serialize(serializer),
            Self::Whole(value) => value.serialize(serializer),
            Self::Number(value) => brief(*value).serialize(serializer),
            Self::Name(value) => value.serialize(serializer),
            Self::Size(value) => value.serialize(serializer),
            Self::Color(value) => value.map(brief).serialize(serializer),
            Self::Automatic => "automatic".serialize(serializer),
        }
    }
}

/// The fewest digits that bring the same number back.
fn brief(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::from(value))
}

impl<'de> Deserialize<'de> for OptionValue {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(AnyValue)
    }
}

struct AnyValue;

impl<'de> Visitor<'de> for AnyValue {
    type Value = OptionValue;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("true, false, a number, a name, [width, height] or [red, green, blue]")
    }

    fn visit_bool<E>(self, value: bool) -> Result<OptionValue, E> {
        Ok(OptionValue::Bool(value))
    }

    fn visit_i64<E>(self, value: i64) -> Result<OptionValue, E> {
        Ok(OptionValue::Whole(value))
    }

    fn visit_u64<E>(self, value: u64) -> Result<OptionValue, E> {
        Ok(i64::try_from(value).map_or(OptionValue::Number(value as f32), OptionValue::Whole))
    }

    fn visit_f64<E>(self, value: f64) -> Result<OptionValue, E> {
        Ok(OptionValue::Number(value as f32))
    }

    fn visit_str<E>(self, value: &str) -> Result<OptionValue, E> {
        Ok(match value {
            "automatic" => OptionValue::Automatic,
            name => OptionValue::Name(name.to_owned()),
        })
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut sequence: A) -> Result<OptionValue, A::Error> {
        let wrong =
            || serde::de::Error::custom("a size is [width, height] in pixels, a color [red, green, blue]");
        let mut numbers = Vec::new();
        while let Some(number) = sequence.next_element::<f64>()? {
            numbers.push(number);
        }
        let side = |number: f64| {
            (number >= 0.0 && number.fract() == 0.0 && number <= u32::MAX.into()).then_some(number as u32)
        };
        match numbers[..] {
            [red, green, blue] => Ok(OptionValue::Color([red, green, blue].map(|channel| channel as f32))),
            [width, height] => {
                Ok(OptionValue::Size([side(width).ok_or_else(wrong)?, side(height).ok_or_else(wrong)?]))
            }
            _ => Err(wrong()),
        }
    }
}
