//! Data sets: pictures by the thousand, each decided by its number alone, so that any number of runs may draw them.

mod draw;
mod files;
mod item;
mod record;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use gnomon_picture::tonemap::tone_mapped;
use gnomon_picture::{RgbImage, exr, ldr};
use gnomon_renderer::layers::{Layer, RenderedLayers};
use gnomon_renderer::{Gpu, GpuOptions, RenderError};
use serde::Deserialize;
use serde_json::{Value, json};
use toml::Table;

use crate::sequence::Digest;
use crate::{Stage, Studio, StudioError};

pub use files::{DatasetFiles, ItemFiles, Unit};
pub use record::Record;

use draw::Template;
use item::{Item, Stages};

/// Most items of a manifest.
const MOST_ITEMS: u64 = 1_000_000_000;

/// What a data set consists of: a TOML file of the tables of an item, in which any value may be drawn; `DATASET.md` describes it.
#[derive(Clone, Debug)]
pub struct Manifest {
    path: PathBuf,
    table: Table,
    template: Template,
    items: u64,
    head: Head,
}

/// Keys of a manifest that are no item's.
#[derive(Clone, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Head {
    /// Number of items; as many as fill the grid once where it is left out.
    items: Option<u64>,
    seed: u64,
    pictures: BTreeSet<Kind>,
    /// Layers of the EXR pictures.
    layers: Vec<Layer>,
    /// Pixels that each picture is checked by.
    check: usize,
}

impl Default for Head {
    fn default() -> Self {
        Self {
            items: None,
            seed: 0,
            pictures: BTreeSet::from([Kind::Png, Kind::Exr]),
            layers: Vec::new(),
            check: 0,
        }
    }
}

const HEAD_KEYS: [&str; 5] = ["items", "seed", "pictures", "layers", "check"];

/// A file of an item.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Kind {
    /// Exposed and tone-mapped, 8 bits.
    Png,
    /// Linear radiance.
    Exr,
}

impl Manifest {
    /// Reads a manifest; the first item has to make sense.
    ///
    /// # Errors
    /// [`StudioError::Read`], [`StudioError::Request`] with the line or the place at fault.
    pub fn read(path: &Path) -> Result<Self, StudioError> {
        let at = |what: String| StudioError::Request(format!("{}: {what}", path.display()));
        let text = std::fs::read_to_string(path)
            .map_err(|source| StudioError::Read { path: path.to_owned(), source })?;
        let table: Table = text.parse().map_err(|error: toml::de::Error| {
            let before = error.span().and_then(|span| text.get(..span.start)).unwrap_or_default();
            at(format!(
                "line {}: {}",
                before.matches('\n').count() + 1,
                gnomon_messages::quoted(error.message())
            ))
        })?;
        let (head, of_items): (Table, Table) =
            table.clone().into_iter().partition(|(key, _)| HEAD_KEYS.contains(&key.as_str()));
        for (key, value) in &head {
            let one = toml::Value::Table(Table::from_iter([(key.clone(), value.clone())]));
            one.try_into::<Head>()
                .map_err(|error| at(format!("`{key}`: {}", gnomon_messages::quoted(error.message()))))?;
        }
        let head: Head = toml::Value::Table(head)
            .try_into()
            .map_err(|error: toml::de::Error| at(gnomon_messages::quoted(error.message())))?;
        if !head.layers.is_empty() && !head.pictures.contains(&Kind::Exr) {
            return Err(at(
                "layers are written into the EXR pictures: `pictures` has to hold \"exr\"".to_owned()
            ));
        }
        if head.layers.contains(&Layer::Motion) {
            return Err(at("no frame was before an item's: there is no layer `motion`".to_owned()));
        }
        let template = Template::new(of_items, head.seed).map_err(|error| at(error.to_string()))?;
        let items = head.items.unwrap_or(template.cells());
        if !(1..=MOST_ITEMS).contains(&items) {
            return Err(at(format!("a data set has 1 to {MOST_ITEMS} items, not {items}")));
        }
        let manifest = Self { path: path.to_owned(), table, template, items, head };
        manifest.item(0).map_err(|error| at(error.to_string()))?;
        Ok(manifest)
    }

    /// Number of its items.
    pub fn items(&self) -> u64 {
        self.items
    }

    fn item(&self, number: u64) -> Result<Item, StudioError> {
        Item::new(self.template.item(number)?)
    }

    fn folder(&self) -> &Path {
        self.path.parent().unwrap_or(Path::new(""))
    }

    /// A digest of everything that items depend on: the manifest, the files that it names, this program, and `how`, which says what draws them. Files
    /// that those name in turn, such as textures, are not looked at.
    ///
    /// # Errors
    /// [`StudioError::Read`] for a file that is there and cannot be read.
    pub fn digest(&self, how: &Value) -> Result<String, StudioError> {
        let mut digest = Digest::default();
        let words = json!({
            "program": concat!("gnomon ", env!("CARGO_PKG_VERSION")),
            "manifest": self.table,
            "drawn_by": how,
        });
        digest.add(words.to_string().as_bytes());
        for name in self.names_of_files() {
            let path = self.folder().join(name);
            // One that is not there is told item by item.
            if path.is_file() {
                let bytes = std::fs::read(&path).map_err(|source| StudioError::Read { path, source })?;
                digest.add(&bytes);
            }
        }
        Ok(digest.to_string())
    }

    /// All texts that may stand where a file is named.
    fn names_of_files(&self) -> BTreeSet<&str> {
        let mut names = BTreeSet::new();
        for (table, keys) in [("scene", &["file"][..]), ("environment", &["file", "rig", "background_map"])] {
            let table = self.table.get(table).and_then(toml::Value::as_table);
            let values = keys.iter().filter_map(|key| table?.get(*key));
            values.for_each(|value| collect_texts(value, &mut names));
        }
        names
    }

    /// Units in an order in which each shares what it can with the one before: by environment, then by scene.
    pub fn in_order(&self, units: Vec<Unit>) -> Vec<Unit> {
        let mut units = units;
        units.sort_by_cached_key(|Unit(items)| (self.group(*items.start()), *items.start()));
        units
    }

    fn group(&self, number: u64) -> Option<(String, String)> {
        self.item(number).ok().map(|item| item.group())
    }
}

fn collect_texts<'a>(value: &'a toml::Value, texts: &mut BTreeSet<&'a str>) {
    match value {
        toml::Value::String(text) => drop(texts.insert(text)),
        toml::Value::Array(values) => values.iter().for_each(|value| collect_texts(value, texts)),
        toml::Value::Table(table) => table.values().for_each(|value| collect_texts(value, texts)),
        _ => {}
    }
}

/// An item that was drawn.
pub struct DrawnItem {
    /// Linear radiance.
    pub radiance: RgbImage,
    /// Layers that the manifest asks for.
    pub layers: RenderedLayers,
    /// What is known beside it.
    pub record: Record,
    /// The stage that was drawn.
    pub stage: Stage,
}

/// Draws items on a device.
pub struct Dataset {
    manifest: Manifest,
    stages: Stages,
    options: GpuOptions,
    gpu: Gpu,
    studio: Option<Studio>,
}

impl Dataset {
    /// Opens an adapter for a manifest.
    ///
    /// # Errors
    /// As [`Gpu::new`].
    pub fn new(manifest: Manifest, options: GpuOptions) -> Result<Self, StudioError> {
        let gpu = Gpu::new(&options)?;
        Ok(Self { stages: Stages::new(manifest.folder()), manifest, options, gpu, studio: None })
    }

    /// What is drawn.
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// What draws it, for [`Manifest::digest`].
    pub fn drawn_by(&self) -> Value {
        json!({ "gpu": self.gpu.adapter().name })
    }

    /// Draws an item. It is the same whatever was drawn before.
    ///
    /// # Errors
    /// Files that cannot be used, names of nothing, what the adapter cannot hold.
    pub fn draw(&mut self, number: u64) -> Result<DrawnItem, StudioError> {
        match self.try_to_draw(number) {
            Err(StudioError::Render(RenderError::DeviceLost { .. })) => {
                self.studio = None;
                self.gpu = Gpu::new(&self.options)?;
                self.try_to_draw(number)
            }
            drawn => drawn,
        }
    }

    fn try_to_draw(&mut self, number: u64) -> Result<DrawnItem, StudioError> {
        if number >= self.manifest.items {
            return Err(StudioError::Request(format!(
                "there is no item {number}: the data set has {}, from 0",
                self.manifest.items
            )));
        }
        let table = self.manifest.template.item(number)?;
        let stage = self.stages.stage(&Item::new(table.clone())?)?;
        let [width, height] = stage.look().picture.size;
        let studio = match &mut self.studio {
            Some(studio) => {
                studio.set_stage(stage)?;
                studio
            }
            None => self.studio.insert(Studio::new(&self.gpu, stage)?),
        };
        let (frame, layers) = studio.frame_layers(width, height, self.manifest.head.layers.as_slice())?;
        let radiance = frame.radiance;
        let stage = studio.stage().clone();
        let check = match self.manifest.head.check {
            0 => None,
            pixels => Some(stage.check(&radiance, pixels)?),
        };
        let mut record = Record::new((number, table), &stage, studio.lights(), check)?;
        record.find_in(&layers);
        Ok(DrawnItem { radiance, layers, record, stage })
    }

    /// Draws a unit and writes it. An item that cannot be drawn is told to `failed`, and the rest goes on.
    ///
    /// # Errors
    /// Files that cannot be written; a device that cannot be had again.
    pub fn write(
        &mut self,
        unit: &Unit,
        files: &DatasetFiles,
        failed: &mut dyn FnMut(u64, &StudioError),
    ) -> Result<(), StudioError> {
        let mut numbers: Vec<u64> = unit.0.clone().collect();
        numbers.sort_by_cached_key(|&number| (self.manifest.group(number), number));
        let (mut items, mut bad) = (Vec::with_capacity(numbers.len()), Vec::new());
        for number in numbers {
            match self.draw(number).and_then(|drawn| self.encoded(&drawn)) {
                Ok((parts, line)) => items.push((number, parts, line)),
                Err(
                    error @ StudioError::Render(
                        RenderError::NoAdapter { .. } | RenderError::DeviceLost { .. },
                    ),
                ) => {
                    return Err(error);
                }
                Err(error) => {
                    failed(number, &error);
                    bad.push(number);
                }
            }
        }
        items.sort_by_key(|(number, ..)| *number);
        files.finish(unit, items, bad)
    }

    fn encoded(&self, drawn: &DrawnItem) -> Result<(ItemFiles, Value), StudioError> {
        let DrawnItem { radiance, layers, record, stage } = drawn;
        let encode = |kind: &Kind| match kind {
            Kind::Png => {
                let display = &stage.look().display;
                let shown = tone_mapped(radiance, display.tone_mapping, stage.exposure());
                ldr::encode_png(&shown).map(|bytes| (".png", bytes))
            }
            Kind::Exr if layers.layers.is_empty() => exr::encode(radiance).map(|bytes| (".exr", bytes)),
            Kind::Exr => {
                let (channels, about) = layers.with_picture(radiance);
                // The encoder keeps attributes in a hash map: several would stand in another order in every process.
                let about: Vec<String> = about.iter().map(|(name, text)| format!("{name}: {text}")).collect();
                let about = [("gnomon.layers".to_owned(), about.join("; "))];
                exr::encode_channels(layers.size, channels, &about).map(|bytes| (".exr", bytes))
            }
        };
        let parts = self.manifest.head.pictures.iter().map(encode).collect::<Result<_, _>>();
        let parts =
            parts.map_err(|error| StudioError::Request(format!("a picture cannot be encoded: {error}")))?;
        Ok((parts, json!(record)))
    }
}
