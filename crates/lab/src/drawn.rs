use gnomon_metrics::{Comparison, compare};
use gnomon_picture::{Panel, RgbImage};
use gnomon_renderer::RenderSettings;

use crate::pictures::{difference, shown};
use crate::report::significant;
use crate::timing::{Spread, TimingPlan, interleaved};
use crate::{Lab, LabError, Setup, TimedRenderer};

/// A way to draw at work: its renderer, one picture, how far that is from the truth, and what it takes.
pub(crate) struct Drawn<'a> {
    /// Name in tables and captions.
    pub name: String,
    pub renderer: TimedRenderer<'a>,
    pub picture: RgbImage,
    /// Over every pixel, the background included.
    pub comparison: Comparison,
    /// Of frames; set by [`time_in_turns`].
    pub spread: Option<Spread>,
}

impl<'a> Drawn<'a> {
    /// Draws a first picture; `None` where the adapter cannot hold it.
    pub fn new(
        lab: &Lab<'a>,
        name: impl Into<String>,
        settings: RenderSettings,
        setup: Setup<'a>,
        truth: &RgbImage,
    ) -> Result<Option<Self>, LabError> {
        let Some(mut renderer) = TimedRenderer::if_it_fits(lab, settings, setup)? else { return Ok(None) };
        let picture = renderer.picture()?;
        let comparison = compare(&picture, truth, None)?;
        Ok(Some(Self { name: name.into(), renderer, picture, comparison, spread: None }))
    }

    /// `label` over the relative RMSE.
    pub fn caption(&self, label: &str) -> String {
        format!("{label}\nRMSE {}", significant(self.comparison.relative_rmse, 3))
    }

    /// The picture as a display shows it at `stops`, under the name and the error.
    pub fn panel(&self, stops: f32) -> Panel {
        Panel::new(self.caption(&self.name), shown(&self.picture, stops))
    }

    /// Picture minus truth under `label` and the error.
    pub fn difference_panel(&self, label: &str, truth: &RgbImage) -> Result<Panel, LabError> {
        Ok(Panel::new(self.caption(label), difference(&self.picture, truth)?))
    }
}

/// Times frames of all of `drawn` against each other, see [`interleaved`].
pub(crate) fn time_in_turns<'d, 'a: 'd>(
    drawn: impl IntoIterator<Item = &'d mut Drawn<'a>>,
    plan: &TimingPlan,
) -> Result<(), LabError> {
    let (mut rivals, mut spreads) = (Vec::new(), Vec::new());
    for Drawn { renderer, spread, .. } in drawn {
        rivals.push(renderer.rival());
        spreads.push(spread);
    }
    for (place, spread) in spreads.into_iter().zip(interleaved(&mut rivals, plan)?) {
        *place = Some(spread);
    }
    Ok(())
}
