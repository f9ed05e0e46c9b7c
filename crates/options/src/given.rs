//! Options that somebody gave.

use std::collections::BTreeMap;
use std::fmt;
use std::marker::PhantomData;

use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess, Visitor};
use serde::ser::{SerializeMap, Serializer};

use crate::{OptionError, OptionSpec, OptionValue, Options, specs};

/// Options that somebody gave, by their names: a part of some settings, to be laid over the whole.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Given(BTreeMap<String, OptionValue>);

impl Given {
    /// What has changed from `before` to `after`.
    pub fn changes<T: Options>(before: &T, after: &T) -> Self {
        let mut was = Vec::new();
        before.visit(&mut |_, field| was.push(field.get()));
        let (mut was, mut given) = (was.into_iter(), BTreeMap::new());
        after.visit(&mut |spec, field| {
            let is = field.get();
            if was.next().as_ref() != Some(&is) {
                given.insert(spec.name(), is);
            }
        });
        Self(given)
    }

    /// Gives an option by a text.
    ///
    /// # Errors
    /// [`OptionError`] for what the option cannot be.
    pub fn parse(&mut self, spec: &OptionSpec, text: &str) -> Result<(), OptionError> {
        self.0.insert(spec.name(), spec.parse(text)?);
        Ok(())
    }

    /// Whether an option is given, by its name.
    pub fn has(&self, name: &str) -> bool {
        self.0.contains_key(name)
    }

    /// These with others, which go before.
    #[must_use]
    pub fn with(&self, others: &Self) -> Self {
        let mut all = self.0.clone();
        all.extend(others.0.clone());
        Self(all)
    }

    /// Lays them over settings; options of other settings are passed over. An option that does not go together with one that is given
    /// is left to the program again.
    pub fn apply(&self, settings: &mut dyn Options) {
        let mut excluded = Vec::new();
        settings.visit(&mut |spec, _| {
            let given = self.0.get(&spec.name()).is_some_and(|value| *value != OptionValue::Automatic);
            excluded.extend(spec.excludes.filter(|_| given));
        });
        settings.visit_mut(&mut |spec, field| {
            match self.0.get(&spec.name()) {
                Some(value) => drop(field.put(value)),
                None if excluded.contains(&spec.key) => drop(field.put(&OptionValue::Automatic)),
                None => {}
            };
        });
    }

    /// Reads a table of the options of `T`, in which those of groups with a name have tables of their own.
    ///
    /// # Errors
    /// Keys that are no options, and values that options cannot have.
    pub fn deserialize<'de, T: Options + Default, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Self, D::Error> {
        let mut given = Self::default();
        Table { specs: &specs::<T>(), table: "", given: &mut given }.deserialize(deserializer)?;
        Ok(given)
    }
}

/// Reads one table: the outer one, or that of a group.
struct Table<'a> {
    specs: &'a [&'static OptionSpec],
    table: &'a str,
    given: &'a mut Given,
}

impl Table<'_> {
    fn spec(&self, key: &str) -> Option<&'static OptionSpec> {
        let is_meant = |spec: &&&'static OptionSpec| {
            (spec.group.table == self.table && spec.key == key)
                || (self.table.is_empty() && spec.alias.is_some_and(|alias| alias.replace('-', "_") == key))
        };
        self.specs.iter().find(is_meant).copied()
    }

    fn has_table(&self, key: &str) -> bool {
        self.table.is_empty() && self.specs.iter().any(|spec| spec.group.table == key)
    }

    fn unknown<E: Error>(&self, key: &str) -> E {
        let keys = self.specs.iter().filter(|spec| spec.group.table == self.table).map(|spec| spec.key);
        let mut tables: Vec<&str> = match self.table {
            "" => self.specs.iter().map(|spec| spec.group.table).filter(|table| !table.is_empty()).collect(),
            _ => Vec::new(),
        };
        tables.dedup();
        let known: Vec<String> = keys.chain(tables).map(|key| format!("`{key}`")).collect();
        E::custom(format!("unknown field `{key}`, expected one of {}", known.join(", ")))
    }
}

impl<'de> DeserializeSeed<'de> for Table<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for Table<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a table of options")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        while let Some(key) = map.next_key::<String>()? {
            if let Some(spec) = self.spec(&key) {
                let value = map.next_value_seed(Value(spec, PhantomData))?;
                if self.given.0.insert(spec.name(), value).is_some() {
                    return Err(Error::custom(format!("`{key}` is given twice")));
                }
            } else if self.has_table(&key) {
                map.next_value_seed(Table { specs: self.specs, table: &key, given: &mut *self.given })?;
            } else {
                return Err(self.unknown(&key));
            }
        }
        let given = |spec: &&&'static OptionSpec| self.given.0.contains_key(&spec.name());
        for spec in self.specs.iter().filter(given) {
            let other = spec.excludes.and_then(|key| self.specs.iter().find(|other| other.key == key));
            if let Some(other) = other.filter(|other| self.given.has(&other.name())) {
                return Err(Error::custom(format!("`{}` and `{}` exclude each other", spec.key, other.key)));
            }
        }
        Ok(())
    }
}

/// Reads the value of one option, so that a mistake is told with its line.
struct Value<'a>(&'static OptionSpec, PhantomData<&'a ()>);

impl<'de> DeserializeSeed<'de> for Value<'_> {
    type Value = OptionValue;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<OptionValue, D::Error> {
        let value = <OptionValue as serde::Deserialize>::deserialize(deserializer)?;
        let key = || format!("`{}`", self.0.key);
        self.0.accept(value).map_err(|error| Error::custom(OptionError { option: key(), ..error }))
    }
}

/// Writes settings as a table that [`Given::deserialize`] reads; options that are left to the program are left out.
///
/// # Errors
/// The serializer's.
pub fn serialize<S: Serializer>(settings: &dyn Options, serializer: S) -> Result<S::Ok, S::Error> {
    let mut tables: Vec<(&'static str, BTreeMap<&'static str, OptionValue>)> = vec![("", BTreeMap::new())];
    settings.visit(&mut |spec, field| {
        let value = field.get();
        if value == OptionValue::Automatic {
            return;
        }
        let table = spec.group.table;
        match tables.iter_mut().find(|(name, _)| *name == table) {
            Some((_, options)) => drop(options.insert(spec.key, value)),
            None => tables.push((table, BTreeMap::from([(spec.key, value)]))),
        }
    });
    let mut map = serializer.serialize_map(None)?;
    for (table, options) in tables {
        match table {
            "" => options.iter().try_for_each(|(key, value)| map.serialize_entry(key, value))?,
            table => map.serialize_entry(table, &options)?,
        }
    }
    map.end()
}
