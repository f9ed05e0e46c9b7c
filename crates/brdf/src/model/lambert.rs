//! Lambert's law: an ideally matte surface.

use glam::{Vec2, Vec3};

use super::ReflectanceModel;
use crate::{BASE_COLOR, LightPatch, Lobe, Parameter, Surface};

/// See the module.
#[derive(Clone, Copy, Debug)]
pub struct Lambert;

impl ReflectanceModel for Lambert {
    const NAME: &'static str = "lambert";
    const SUMMARY: &'static str = "ideally matte: base color over pi";
    const REQUIRED: &'static [&'static Parameter] = &[];
    const OPTIONAL: &'static [&'static Parameter] = &[&BASE_COLOR];
    const SHAPE: Option<&'static Parameter> = None;

    fn concerning(surface: Surface) -> Surface {
        Surface { metallic: 0.0, specular: 0.0, ..surface }
    }

    fn lobe(_: &Lobe, _: Vec3, _: Vec3) -> Vec3 {
        Vec3::ZERO
    }

    fn sample(_: &Lobe, _: Vec3, _: Vec2) -> Vec3 {
        Vec3::Z
    }

    fn pdf(_: &Lobe, _: Vec3, _: Vec3) -> f32 {
        0.0
    }

    fn light_lobe(_: &Lobe, _: Vec3, _: &LightPatch) -> Vec3 {
        Vec3::ZERO
    }
}
