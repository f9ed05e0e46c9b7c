//! Options that somebody gave.

use std::collections::BTreeMap;
use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, Visitor};
use serde::ser::{SerializeMap, Serializer};

use crate::{Kind, OptionError, OptionSpec, OptionValue, Options, specs};

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

    /// Gives an option a value.
    ///
    /// # Errors
    /// [`OptionError`] for what the option cannot be.
    pub fn put(&mut self, spec: &OptionSpec, value: OptionValue) -> Result<(), OptionError> {
        self.0.insert(spec.name(), spec.accept(value)?);
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

    /// Changes the paths of files among them, which are options of `T`.
    #[must_use]
    pub fn map_files<T: Options + Default>(mut self, to: impl Fn(&str) -> String) -> Self {
        for spec in specs::<T>().into_iter().filter(|spec| matches!(spec.kind, Kind::File)) {
            if let Some(OptionValue::Name(path)) = self.0.get_mut(&spec.name()) {
                *path = to(path);
            }
        }
        self
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
        Self::deserialize_beside::<T, D>(&[], deserializer)
    }

    /// The same of a table that holds keys of `others` too, which are passed over.
    ///
    /// # Errors
    /// As [`Given::deserialize`].
    pub fn deserialize_beside<'de, T: Options + Default, D: Deserializer<'de>>(
        others: &[&str],
        deserializer: D,
    ) -> Result<Self, D::Error> {
        let mut given = Self::default();
        Table { specs: &specs::<T>(), table: "", others, given: &mut given }.deserialize(deserializer)?;
        Ok(given)
    }
}

/// Reads one table: the outer one, or that of a group.
struct Table<'a> {
    specs: &'a [&'static OptionSpec],
    table: &'a str,
    others: &'a [&'a str],
    given: &'a mut Given,
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
        let Self { specs, table, others, given } = self;
        while let Some(entry) = map.next_key_seed(Key { specs, table, others, given })? {
            match entry {
                Entry::Option(spec) => drop(given.0.insert(spec.name(), map.next_value_seed(Value(spec))?)),
                Entry::Table(table) => {
                    map.next_value_seed(Table { specs, table, others: &[], given: &mut *given })?;
                }
                Entry::Other => drop(map.next_value::<IgnoredAny>()?),
            }
        }
        Ok(())
    }
}

/// What a key stands for.
enum Entry {
    Option(&'static OptionSpec),
    Table(&'static str),
    Other,
}

/// Reads a key, so that one that cannot be is told with its line.
struct Key<'a> {
    specs: &'a [&'static OptionSpec],
    table: &'a str,
    others: &'a [&'a str],
    given: &'a Given,
}

impl<'de> DeserializeSeed<'de> for Key<'_> {
    type Value = Entry;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Entry, D::Error> {
        deserializer.deserialize_identifier(self)
    }
}

impl Visitor<'_> for Key<'_> {
    type Value = Entry;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the name of an option")
    }

    fn visit_str<E: Error>(self, key: &str) -> Result<Entry, E> {
        if self.others.contains(&key) {
            return Ok(Entry::Other);
        }
        let is_outer = self.table.is_empty();
        let is_meant = |spec: &OptionSpec| {
            spec.group.table == self.table && spec.key == key
                || is_outer && spec.alias.is_some_and(|alias| alias.replace('-', "_") == key)
        };
        let mut specs = self.specs.iter().copied();
        if let Some(spec) = specs.clone().find(|spec| is_meant(spec)) {
            let other = spec.excludes.and_then(|key| specs.find(|other| other.key == key));
            return match other.filter(|other| self.given.has(&other.name())) {
                _ if self.given.has(&spec.name()) => Err(E::custom(format!("`{key}` is given twice"))),
                Some(other) => Err(E::custom(format!("`{}` and `{key}` exclude each other", other.key))),
                None => Ok(Entry::Option(spec)),
            };
        }
        match specs.find(|spec| is_outer && !key.is_empty() && spec.group.table == key) {
            Some(spec) => Ok(Entry::Table(spec.group.table)),
            None => Err(self.unknown(key)),
        }
    }
}

impl Key<'_> {
    fn unknown<E: Error>(&self, key: &str) -> E {
        let own = self.specs.iter().filter(|spec| spec.group.table == self.table).map(|spec| spec.key);
        let mut known: Vec<&str> = self.others.iter().copied().chain(own).collect();
        if self.table.is_empty() {
            known.extend(self.specs.iter().map(|spec| spec.group.table).filter(|table| !table.is_empty()));
            known.dedup();
        }
        let known: Vec<String> = known.iter().map(|key| format!("`{key}`")).collect();
        E::custom(format!("unknown field `{key}`, expected one of {}", known.join(", ")))
    }
}

/// Reads the value of one option, so that a mistake is told with its line.
struct Value(&'static OptionSpec);

impl<'de> DeserializeSeed<'de> for Value {
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
