use crate::OptionValue;

/// A field that holds an option.
pub trait OptionField {
    /// Its value.
    fn get(&self) -> OptionValue;

    /// Takes another value over; whether the field can hold it.
    fn put(&mut self, value: &OptionValue) -> bool;
}

macro_rules! field {
    ($type:ty, $value:ident, $get:expr, $variant:pat => $put:expr) => {
        impl OptionField for $type {
            fn get(&self) -> OptionValue {
                let $value = self;
                $get
            }

            fn put(&mut self, value: &OptionValue) -> bool {
                let $variant = value else { return false };
                let Some(new) = $put else { return false };
                *self = new;
                true
            }
        }
    };
}

field!(bool, value, OptionValue::Bool(*value), OptionValue::Bool(new) => Some(*new));
field!(f32, value, OptionValue::Number(*value), OptionValue::Number(new) => Some(*new));
field!(u32, value, OptionValue::Whole((*value).into()), OptionValue::Whole(new) => (*new).try_into().ok());
field!(u64, value, whole(*value), OptionValue::Whole(new) => (*new).try_into().ok());
field!(usize, value, whole(*value), OptionValue::Whole(new) => (*new).try_into().ok());
field!(String, value, OptionValue::Name(value.clone()), OptionValue::Name(new) => Some(new.clone()));
field!([u32; 2], value, OptionValue::Size(*value), OptionValue::Size(new) => Some(*new));
field!([f32; 3], value, OptionValue::Color(*value), OptionValue::Color(new) => Some(*new));

/// A number too large for an option is out of every option's range.
fn whole(value: impl TryInto<i64>) -> OptionValue {
    OptionValue::Whole(value.try_into().unwrap_or(i64::MAX))
}

impl<T: OptionField + Default> OptionField for Option<T> {
    fn get(&self) -> OptionValue {
        self.as_ref().map_or(OptionValue::Automatic, OptionField::get)
    }

    fn put(&mut self, value: &OptionValue) -> bool {
        if *value == OptionValue::Automatic {
            *self = None;
            return true;
        }
        let mut new = T::default();
        let fits = new.put(value);
        if fits {
            *self = Some(new);
        }
        fits
    }
}
