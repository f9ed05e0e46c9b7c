use std::borrow::Cow;

use gnomon_picture::RgbImage;
use gnomon_renderer::RenderSettings;
use gnomon_renderer::shadow::{self, Prefilter, ShadowSettings};

use crate::drawn::Drawn;
use crate::{Lab, LabError, Setup};

/// One way to draw shadows, under the name that tables give it.
#[derive(Clone, Debug)]
pub(super) struct Variant {
    pub name: Cow<'static, str>,
    /// Registered name of the technique.
    pub technique: &'static str,
    /// Its parameters.
    pub settings: ShadowSettings,
}

impl Variant {
    /// Any technique with its default parameters.
    pub fn technique(technique: &'static str) -> Self {
        Self { name: technique.into(), technique, settings: ShadowSettings::default() }
    }

    /// Convolution soft shadows with mip maps and M = `order`.
    pub fn mip(order: u32) -> Self {
        let mut variant = Self::technique("convolution");
        variant.name = format!("convolution mip M={order}").into();
        variant.settings.convolution.order = order;
        variant
    }

    /// Convolution soft shadows with summed-area tables and M = `order`.
    pub fn sat(order: u32) -> Self {
        let mut variant = Self::mip(order);
        variant.name = format!("convolution SAT M={order}").into();
        variant.settings.convolution.prefilter = Prefilter::SummedAreaTable;
        variant
    }

    /// Convolution soft shadows of M = `order` with every way of filtering.
    pub fn prefilters(order: u32) -> Vec<Self> {
        vec![Self::mip(order), Self::sat(order)]
    }

    /// Every technique there is, convolution at both of the paper's orders.
    pub fn all() -> Vec<Self> {
        shadow::names()
            .flat_map(|(name, _)| match name {
                "convolution" => [4, 16].into_iter().flat_map(Self::prefilters).collect(),
                other => vec![Self::technique(other)],
            })
            .collect()
    }

    /// The settings of a frame that uses it, all else as in `frame`.
    pub fn settings(&self, frame: &RenderSettings) -> RenderSettings {
        frame.clone().with(|s| {
            s.techniques.shadows = self.technique.to_owned();
            s.techniques.shadow_settings = self.settings.clone();
        })
    }

    /// One picture with it, all else as in `frame`; `None` where the adapter cannot hold it.
    pub fn drawn<'a>(
        &self,
        lab: &Lab<'a>,
        setup: Setup<'a>,
        frame: &RenderSettings,
        truth: &RgbImage,
    ) -> Result<Option<Drawn<'a>>, LabError> {
        Drawn::new(lab, self.name.as_ref(), self.settings(frame), setup, truth)
    }
}
