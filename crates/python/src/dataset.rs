//! Data sets, item by item.

use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use gnomon::renderer::GpuOptions;
use gnomon::studio::{self, DatasetFiles, Manifest, StudioError};
use gnomon_messages::with_causes;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::refused;
use crate::layers::Pictures;
use crate::{picture, work};

/// What a manifest describes, on a graphics adapter.
#[pyclass(frozen, module = "gnomon")]
pub struct Dataset {
    manifest: Manifest,
    dataset: Arc<Mutex<studio::Dataset>>,
}

#[pymethods]
impl Dataset {
    #[new]
    #[pyo3(signature = (manifest, adapter=None))]
    fn new(py: Python<'_>, manifest: PathBuf, adapter: Option<String>) -> PyResult<Self> {
        let (manifest, dataset) = work::run(py, None, |_| {
            let manifest = Manifest::read(&manifest)?;
            Ok((manifest.clone(), studio::Dataset::new(manifest, GpuOptions { adapter })?))
        })?;
        Ok(Self { manifest, dataset: Arc::new(Mutex::new(dataset)) })
    }

    fn __len__(&self) -> usize {
        usize::try_from(self.manifest.items()).unwrap_or(usize::MAX)
    }

    /// Draws an item: arrays by name, `radiance` and the manifest's layers, and what is known beside them.
    fn draw<'py>(&self, py: Python<'py>, item: u64) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyDict>)> {
        let mut pictures = Pictures::default();
        let drawn = work::run(py, None, |_| {
            let mut dataset = self.dataset.lock().unwrap_or_else(PoisonError::into_inner);
            let drawn = dataset.draw(item)?;
            pictures.add(&drawn.radiance, drawn.layers.clone());
            Ok(drawn)
        })?;
        let shape = [drawn.radiance.height() as usize, drawn.radiance.width() as usize];
        Ok((pictures.arrays(py, &shape, true)?, picture::document(py, &drawn.record)?))
    }

    /// Draws the items from `first` to `last` that are not in a folder yet, as the command does. Gives what failed, item by item.
    #[pyo3(signature = (output, first=0, last=None, *, shards=None, overwrite=false, progress=None))]
    #[expect(clippy::too_many_arguments, reason = "each is a keyword in Python")]
    fn write(
        &self,
        py: Python<'_>,
        output: PathBuf,
        first: u64,
        last: Option<u64>,
        shards: Option<u64>,
        overwrite: bool,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Vec<(u64, String)>> {
        let range: RangeInclusive<u64> = first..=last.unwrap_or(self.manifest.items() - 1);
        if range.is_empty() || *range.end() >= self.manifest.items() {
            let items = self.manifest.items();
            return Err(refused(format!(
                "the data set has {items} items, from 0: it has no items {first} to {}",
                range.end()
            )));
        }
        work::run(py, progress, |job| {
            let mut dataset = self.dataset.lock().unwrap_or_else(PoisonError::into_inner);
            let digest = self.manifest.digest(&dataset.drawn_by())?;
            let files = DatasetFiles::new(&output, shards, digest)?;
            let units = self.manifest.in_order(files.missing(range, self.manifest.items(), overwrite)?);
            let mut failed = Vec::new();
            for (done, unit) in units.iter().enumerate() {
                if job.is_cancelled() {
                    break;
                }
                job.tell(done as f32 / units.len() as f32);
                dataset.write(unit, &files, &mut |item, error: &StudioError| {
                    failed.push((item, with_causes(error)))
                })?;
            }
            Ok(failed)
        })
    }

    /// Loses the device, as a driver's reset does; for tests.
    fn _lose_device(&self, py: Python<'_>) -> PyResult<()> {
        work::run(py, None, |_| {
            self.dataset.lock().unwrap_or_else(PoisonError::into_inner).gpu().device().destroy();
            Ok(())
        })
    }

    fn __repr__(&self) -> String {
        format!("<gnomon.Dataset of {} items>", self.manifest.items())
    }
}
