/// Declares an enum whose variants are the choices of an option. The first is the default; a variant's documentation is its line in
/// help and panel.
#[macro_export]
macro_rules! choices {
    (
        $(#[$meta:meta])*
        pub enum $name:ident { $( $(#[doc = $help:literal])+ $variant:ident = $text:literal, )+ }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $name { $( $(#[doc = $help])+ $variant, )+ }

        impl $name {
            /// Every one, the default first.
            pub const ALL: &[Self] = &[$( Self::$variant, )+];

            /// Its name for people and files.
            pub const fn name(self) -> &'static str {
                match self { $( Self::$variant => $text, )+ }
            }

            /// The one of that name.
            pub fn from_name(name: &str) -> Option<Self> {
                Self::ALL.iter().copied().find(|choice| choice.name() == name)
            }

            /// All of them, for an option.
            pub fn choices() -> Vec<$crate::Choice> {
                vec![$( $crate::Choice { name: $text, summary: concat!($($help),+).trim_ascii() }, )+]
            }
        }

        impl Default for $name {
            fn default() -> Self {
                Self::ALL[0]
            }
        }

        impl $crate::serde::Serialize for $name {
            fn serialize<S: $crate::serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.serialize_str(self.name())
            }
        }

        impl<'de> $crate::serde::Deserialize<'de> for $name {
            fn deserialize<D: $crate::serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let name = <String as $crate::serde::Deserialize>::deserialize(deserializer)?;
                let unknown = || $crate::serde::de::Error::unknown_variant(&name, &[$( $text, )+]);
                Self::from_name(&name).ok_or_else(unknown)
            }
        }

        impl $crate::OptionField for $name {
            fn get(&self) -> $crate::OptionValue {
                $crate::OptionValue::Name(self.name().to_owned())
            }

            fn put(&mut self, value: &$crate::OptionValue) -> bool {
                let $crate::OptionValue::Name(name) = value else { return false };
                let choice = Self::from_name(name);
                *self = choice.unwrap_or(*self);
                choice.is_some()
            }
        }
    };
}
