//! What is drawn and lit of a band, once or layer after layer.

use super::{Lit, Renderer, Target};
use crate::RenderError;
use crate::gbuffer::DrawnScene;
use crate::light_batches::LitScene;
use crate::recorder::Recorder;

impl Renderer {
    /// Lights what is in the G-buffer: draws the relief of it, lists points and sums light there, stage after stage.
    pub(super) fn light_surfaces(
        &self,
        recorder: &mut Recorder<'_>,
        lit: &Lit,
        scene: LitScene<'_>,
    ) -> Result<(), RenderError> {
        recorder.end_pass("gbuffer")?;
        if let Some(relief) = &self.relief {
            self.passes.relief.encode(recorder, scene.seen, self.drawn_scene(), relief);
            recorder.end_pass("relief")?;
        }
        let gbuffer_group = &scene.seen.group;
        for stage in &scene.points.stages {
            self.passes.of_models.points.encode(
                recorder,
                scene.points,
                stage,
                &self.view_group,
                gbuffer_group,
            );
            recorder.end_pass("points")?;
            lit.batches.encode(recorder, &lit.light, scene, stage)?;
            if stage.list == 0 {
                let groups = [&self.view_group, gbuffer_group];
                self.passes.of_models.points.even_out(recorder, scene.points, stage, groups);
                recorder.end_pass("even out")?;
            }
            if let Some(gloss) = lit.gloss.as_ref().filter(|_| self.debug.is_none()) {
                gloss.encode(recorder, gbuffer_group, scene.points, stage);
                recorder.end_pass("gloss")?;
            }
        }
        Ok(())
    }

    pub(super) fn drawn_scene(&self) -> DrawnScene<'_> {
        DrawnScene { view_group: &self.view_group, geometry: &self.geometry, materials: &self.materials }
    }

    /// What is lit in a band of the picture, and in one of its layers.
    pub(super) fn lit_scene<'a>(
        &'a self,
        target: &'a Target,
        (is_first_band, is_first_layer): (bool, bool),
    ) -> LitScene<'a> {
        LitScene {
            geometry: &self.geometry,
            materials: &self.materials,
            seen: &target.gbuffer,
            view: &self.view_group,
            points: &target.points,
            is_first_band,
            is_first_layer,
        }
    }
}
