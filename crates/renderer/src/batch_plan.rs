//! Lights in batches. Lights with the same needs share what a technique keeps, in turns where memory does not hold all of them,
//! so that their number is bounded by the light list alone.

use gnomon_options::choices;

use crate::RenderError;

/// Texels along the side of the smallest map.
const LEAST_RESOLUTION: u32 = 32;

/// Footprint of a light with a map of [`crate::TechniqueSettings::shadow_resolution`]; one twice as wide has one of half the side. Its
/// penumbrae are wider than the larger texels.
const FOOTPRINT_AT_RESOLUTION: f32 = 0.15;

/// A light that casts sharper shadows than that may have so many times the texels along a side as it gives times this share of all light, what
/// each of the usual 64 gives on average: of one that gives less nobody sees how sharp they are.
const SHARE_AT_RESOLUTION: f32 = 1.0 / 64.0;

choices! {
    /// How large the lights' shadow maps are.
    pub enum ShadowSizing {
        /// The wider the light, the coarser its map.
        Footprint = "footprint",
        /// All alike.
        Uniform = "uniform",
    }
}

/// Whether a light with that [`crate::light_frame::footprint`] which gives a `share` of the environment's light casts shadows so sharp, and so
/// much to be seen, that it deserves more texels and points than others.
pub(crate) fn is_sharp(footprint: f32, share: f32) -> bool {
    footprint < FOOTPRINT_AT_RESOLUTION && share > SHARE_AT_RESOLUTION
}

impl ShadowSizing {
    /// Texels along the side of the map of a light with [`crate::light_frame::footprint`] `footprint` that gives a `share` of the
    /// environment's light. `usual` and `sharpest` are those of the settings.
    pub(crate) fn resolution(self, footprint: f32, share: f32, [usual, sharpest]: [u32; 2]) -> u32 {
        if self == Self::Uniform {
            return usual;
        }
        let most = (share / SHARE_AT_RESOLUTION).max(1.0);
        let finer = (FOOTPRINT_AT_RESOLUTION / footprint).min(most).log2().round().clamp(-16.0, 16.0);
        let texels = (f64::from(usual) * f64::from(finer).exp2()) as u32;
        texels.clamp(LEAST_RESOLUTION.min(usual), sharpest.max(usual))
    }
}

/// What decides which lights share batches: those with the same needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct LightNeeds {
    /// The list of shading points that it is summed at, by its place among those of the frame. Lists are filled one after the other.
    pub points: usize,
    /// Texels along the side of its map.
    pub resolution: u32,
}

/// Lights with the same needs.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Class {
    pub needs: LightNeeds,
    /// Lights whose shadows are held at a time.
    pub capacity: u32,
    /// Indices of the lights, batch by batch: each at most `capacity`.
    pub batches: Vec<Vec<usize>>,
}

/// What the shadows of one light cost, and what there is.
pub(crate) struct Budget<'a> {
    /// Bytes of one light with such needs.
    pub bytes_per_light: &'a dyn Fn(LightNeeds) -> u64,
    /// Bytes for all that is held at a time.
    pub bytes: u64,
    /// Most lights that the adapter's textures and bindings hold at a time.
    pub most_lights: &'a dyn Fn(LightNeeds) -> u32,
    /// For messages.
    pub adapter: &'a str,
}

/// Divides lights with such `needs` into batches within `budget`. Batches of a class are of even length.
///
/// # Errors
/// [`RenderError::OverBudget`] if one light of every class is more than the budget, [`RenderError::OverLimit`] if it is more than the adapter
/// holds.
pub(crate) fn plan(needs: &[LightNeeds], budget: &Budget<'_>) -> Result<Vec<Class>, RenderError> {
    let mut kinds = needs.to_vec();
    kinds.sort_unstable();
    kinds.dedup();
    let members =
        |kind: LightNeeds| needs.iter().enumerate().filter(move |(_, n)| **n == kind).map(|(i, _)| i);
    let bytes = |kind: LightNeeds| (budget.bytes_per_light)(kind);
    let least: u64 = kinds.iter().map(|&kind| bytes(kind)).sum();
    if least > budget.bytes {
        return Err(RenderError::OverBudget { wanted: least, budget: budget.bytes });
    }
    if kinds.iter().any(|&kind| (budget.most_lights)(kind) == 0) {
        return Err(RenderError::OverLimit {
            what: "texture layers or bytes of one light's shadows",
            wanted: 1,
            limit: 0,
            adapter: budget.adapter.to_owned(),
        });
    }
    // Beyond one light a class, classes share what is left in proportion to what they want.
    let wanted: u64 = kinds.iter().map(|&kind| bytes(kind) * (members(kind).count() as u64 - 1)).sum();
    let share = if wanted == 0 { 1.0 } else { ((budget.bytes - least) as f64 / wanted as f64).min(1.0) };
    Ok(kinds
        .into_iter()
        .map(|needs| {
            let lights: Vec<usize> = members(needs).collect();
            let held = 1 + ((lights.len() - 1) as f64 * share + 1e-9) as usize;
            let held = held.min((budget.most_lights)(needs) as usize);
            let turns = lights.len().div_ceil(held);
            let capacity = lights.len().div_ceil(turns);
            let batches = lights.chunks(capacity).map(<[usize]>::to_vec).collect();
            Class { needs, capacity: capacity as u32, batches }
        })
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn planned(resolutions: &[u32], bytes: u64, lights_per_class: u32) -> Result<Vec<Class>, RenderError> {
        let needs: Vec<_> =
            resolutions.iter().map(|&resolution| LightNeeds { points: 0, resolution }).collect();
        let bytes_per_light = |needs: LightNeeds| u64::from(needs.resolution);
        let most_lights = |_| lights_per_class;
        let budget =
            Budget { bytes_per_light: &bytes_per_light, bytes, most_lights: &most_lights, adapter: "test" };
        plan(&needs, &budget)
    }

    #[test]
    fn every_light_is_in_one_batch_and_the_budget_holds() {
        let resolutions: Vec<u32> = (0..100).map(|i| [64, 128, 256][i % 3]).collect();
        for (bytes, layers) in [(448, 9), (2000, 1000), (20_000, 4), (u64::MAX / 4, 2048)] {
            let classes = planned(&resolutions, bytes, layers).unwrap();
            let mut seen: Vec<usize> = classes.iter().flat_map(|c| c.batches.concat()).collect();
            seen.sort_unstable();
            assert_eq!(seen, (0..100).collect::<Vec<_>>());
            let held: u64 = classes.iter().map(|c| u64::from(c.capacity * c.needs.resolution)).sum();
            assert!(held <= bytes, "{held} > {bytes}");
            for class in &classes {
                assert!(class.capacity <= layers);
                for batch in &class.batches {
                    assert!(!batch.is_empty() && batch.len() <= class.capacity as usize);
                    assert!(batch.iter().all(|&light| resolutions[light] == class.needs.resolution));
                }
            }
        }
    }

    #[test]
    fn what_fits_is_held_at_once() {
        let classes = planned(&[64; 60], 64 * 60, 256).unwrap();
        assert_eq!((classes.len(), classes[0].batches.len(), classes[0].capacity), (1, 1, 60));
    }

    #[test]
    fn a_budget_below_one_light_is_an_error_that_says_both() {
        let bytes_per_light = |needs: LightNeeds| u64::from(needs.resolution) << 20;
        let budget = Budget {
            bytes_per_light: &bytes_per_light,
            bytes: 191 << 20,
            most_lights: &|_| 16,
            adapter: "test",
        };
        let needs = [64, 128].map(|resolution| LightNeeds { points: 0, resolution });
        let error = plan(&needs, &budget).unwrap_err().to_string();
        assert!(error.contains("192 MiB") && error.contains("191 MiB"), "{error}");
    }

    #[test]
    fn lights_summed_at_other_points_are_in_other_batches() {
        let needs = [0, 1, 0, 1].map(|points| LightNeeds { points, resolution: 64 });
        let budget = Budget {
            bytes_per_light: &|_| 1,
            bytes: 100,
            // Many points leave room for few lights.
            most_lights: &|needs| if needs.points == 0 { 1 } else { 16 },
            adapter: "test",
        };
        let batches: Vec<_> = plan(&needs, &budget).unwrap().into_iter().map(|class| class.batches).collect();
        assert_eq!(batches, [vec![vec![0], vec![2]], vec![vec![1, 3]]]);
    }

    #[test]
    fn no_lights_need_no_maps() {
        assert!(planned(&[], 0, 16).unwrap().is_empty());
    }

    #[test]
    fn wider_lights_have_smaller_maps_and_sharp_ones_that_give_much_light_larger_ones() {
        let resolution =
            |footprint, share, usual| ShadowSizing::Footprint.resolution(footprint, share, [usual, 2048]);
        assert_eq!([0.15, 0.3, 0.6, 1.2, 100.0].map(|f| resolution(f, 0.5, 256)), [256, 128, 64, 32, 32]);
        assert_eq!([0.07, 0.02, 0.0].map(|f| resolution(f, 0.5, 256)), [512, 2048, 2048]);
        assert_eq!(
            [0.0, 0.02, 0.04, 0.08, 1.0].map(|s| resolution(0.0, s, 256)),
            [256, 256, 512, 1024, 2048]
        );
        assert_eq!((resolution(100.0, 0.0, 16), resolution(0.0, 1.0, 4096)), (16, 4096));
        assert_eq!(ShadowSizing::Uniform.resolution(100.0, 1.0, [256, 2048]), 256);
    }
}
