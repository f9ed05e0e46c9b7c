use std::collections::BTreeMap;

use crate::{OptionError, OptionField, OptionSpec, OptionValue};

/// Settings that are a list of options.
pub trait Options {
    /// Shows every option with its field, in the order of their declaration.
    fn visit(&self, see: &mut dyn FnMut(&'static OptionSpec, &dyn OptionField));

    /// The same for whoever changes them.
    fn visit_mut(&mut self, see: &mut dyn FnMut(&'static OptionSpec, &mut dyn OptionField));

    /// Whether every option is what it may be.
    ///
    /// # Errors
    /// [`OptionError`] for the first that is not.
    fn check(&self) -> Result<(), OptionError> {
        let mut result = Ok(());
        self.visit(&mut |spec, field| {
            if result.is_ok() {
                result = spec.accept(field.get()).map(drop);
            }
        });
        result
    }
}

/// The options of a kind of settings.
pub fn specs<T: Options + Default>() -> Vec<&'static OptionSpec> {
    let mut specs = Vec::new();
    T::default().visit(&mut |spec, _| specs.push(spec));
    specs
}

/// Whether options matter, by the choices that settings make ([`OptionSpec::condition`]).
pub fn matters(settings: &dyn Options) -> impl Fn(&OptionSpec) -> bool + use<> {
    let mut chosen = BTreeMap::new();
    settings.visit(&mut |spec, field| {
        if let OptionValue::Name(name) = field.get() {
            chosen.insert(spec.name(), name);
        }
    });
    move |spec| {
        spec.condition()
            .is_none_or(|(name, values)| chosen.get(name).is_some_and(|is| values.contains(&is.as_str())))
    }
}

impl<A: Options, B: Options> Options for (A, B) {
    fn visit(&self, see: &mut dyn FnMut(&'static OptionSpec, &dyn OptionField)) {
        self.0.visit(see);
        self.1.visit(see);
    }

    fn visit_mut(&mut self, see: &mut dyn FnMut(&'static OptionSpec, &mut dyn OptionField)) {
        self.0.visit_mut(see);
        self.1.visit_mut(see);
    }
}

/// Declares settings: a struct whose fields are options.
///
/// ```
/// use gnomon_options::{Group, choices, settings, choice, number, whole};
///
/// static SOUP: Group = Group { table: "soup", heading: "Soup", condition: None };
///
/// choices! {
///     /// What it is cooked in.
///     pub enum Pot {
///         /// An iron one.
///         Iron = "iron",
///         /// A clay one.
///         Clay = "clay",
///     }
/// }
///
/// settings! {
///     /// How soup is cooked.
///     pub struct SoupSettings in SOUP {
///         /// Leeks in it.
///         leeks: u32 = 3, whole(0, 12);
///         /// Time on the fire.
///         time: f32 = 1.5, number(0.0, 24.0).unit("h");
///         /// What it is cooked in.
///         pot: Pot = Pot::Iron, choice(Pot::choices);
///     }
/// }
///
/// let names: Vec<String> = gnomon_options::specs::<SoupSettings>().iter().map(|spec| spec.name()).collect();
/// assert_eq!(names, ["soup-leeks", "soup-time", "soup-pot"]);
/// ```
///
/// A help sentence is documentation: it is written for people who cook. Settings of other groups may follow the options, as
/// `with { /// ... name: OtherSettings; }`; where there are no others, `in GROUP { ... }` is left out.
#[macro_export]
macro_rules! settings {
    ($(#[$meta:meta])* pub struct $name:ident with { $($inner:tt)+ }) => {
        $crate::settings! { $(#[$meta])* pub struct $name in NONE {} with { $($inner)+ } }
    };
    (
        $(#[$meta:meta])*
        pub struct $name:ident in $group:ident {
            $( $(#[doc = $help:literal])+ $field:ident : $type:ty = $default:expr, $spec:expr; )*
        }
        $( with { $( $(#[doc = $about:literal])+ $inner:ident : $inner_type:ty; )+ } )?
    ) => {
        $(#[$meta])*
        #[derive(Clone, Debug, PartialEq)]
        pub struct $name {
            $( $(#[doc = $help])+ pub $field: $type, )*
            $($( $(#[doc = $about])+ pub $inner: $inner_type, )+)?
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $( $field: $default, )* $($( $inner: Default::default(), )+)? }
            }
        }

        impl $name {
            const OPTIONS: &'static [$crate::OptionSpec] =
                &[$( ($spec).of_field(stringify!($field), concat!($($help),+), &$group), )*];
        }

        impl $crate::Options for $name {
            fn visit(&self, see: &mut dyn FnMut(&'static $crate::OptionSpec, &dyn $crate::OptionField)) {
                let mut specs = Self::OPTIONS.iter();
                $( if let Some(spec) = specs.next() { see(spec, &self.$field); } )*
                $($( $crate::Options::visit(&self.$inner, see); )+)?
            }

            fn visit_mut(&mut self, see: &mut dyn FnMut(&'static $crate::OptionSpec, &mut dyn $crate::OptionField)) {
                let mut specs = Self::OPTIONS.iter();
                $( if let Some(spec) = specs.next() { see(spec, &mut self.$field); } )*
                $($( $crate::Options::visit_mut(&mut self.$inner, see); )+)?
            }
        }

        impl $crate::serde::Serialize for $name {
            fn serialize<S: $crate::serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                $crate::serialize(self, serializer)
            }
        }

        impl<'de> $crate::serde::Deserialize<'de> for $name {
            fn deserialize<D: $crate::serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let mut settings = Self::default();
                $crate::Given::deserialize::<Self, D>(deserializer)?.apply(&mut settings);
                Ok(settings)
            }
        }
    };
}
