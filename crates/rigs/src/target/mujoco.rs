//! MuJoCo, as MJCF to include into a model (<https://mujoco.readthedocs.io/en/stable/XMLreference.html#body-light>).
//!
//! - +z is up: a scene turns as glTF's importers turn it, `(x, y, z)` to `(x, -z, y)`.
//! - `dir` is where a directional light shines. What a surface shows is its colour times `diffuse` times the cosine, without a division by pi,
//!   and clipped at 1: `diffuse` is irradiance / pi, exposed so that the map's mean is 0.5.
//! - There are eight lights at most, of which the headlight is one. It holds the ambient light: the mean of what the lights leave.

use gnomon_lights::DistantLight;

use super::{Reflections, Target, numbers, xml_comment};
use crate::rig::z_up;
use crate::{Rig, Sun};

pub(super) const TARGET: Target = Target {
    name: "mujoco",
    extensions: &["mjcf"],
    summary: "MuJoCo: MJCF with directional lights and the headlight as ambient light, exposed",
    reflections: Reflections::Nothing,
    most_lights: Some(7),
    loses: "lights have no size, and what they leave becomes even ambient light",
    map_extension: "exr",
    text,
};

/// Distance of lights from the origin [m]: shadow maps are drawn from there.
const DISTANCE: f64 = 5.0;
/// Strength of highlights: that of a light by default over its diffuse colour.
const SPECULAR: f64 = 0.3 / 0.7;

fn text(rig: &Rig) -> String {
    let exposure = f64::from(rig.map.suitable_exposure()).exp2();
    let ambient = rig.set.residual_flux() * (exposure / (4.0 * std::f64::consts::PI));
    let about = xml_comment(rig, "     ");
    let lights: String =
        rig.set.lights.iter().enumerate().map(|(index, light)| entry(light, index, exposure)).collect();
    format!(
        "<!--\n{about}     Colours are exposed by a factor of {}.\n-->\n<mujoco model=\"rig\">\n  <visual>\n    \
         <headlight ambient=\"{}\" diffuse=\"0 0 0\" specular=\"0 0 0\"/>\n  </visual>\n  <worldbody>\n{lights}  </worldbody>\n</mujoco>\n",
        numbers([exposure], ""),
        numbers(ambient.to_array(), " ")
    )
}

fn entry(light: &DistantLight, index: usize, exposure: f64) -> String {
    let sun = Sun::of(light);
    let towards = z_up(sun.towards);
    let diffuse = sun.irradiance * (exposure / std::f64::consts::PI);
    let triple = |v: glam::DVec3| numbers(v.to_array(), " ");
    format!(
        "    <light name=\"rig_{index}\" directional=\"true\" castshadow=\"true\" pos=\"{}\" dir=\"{}\" ambient=\"0 0 0\" diffuse=\"{}\" specular=\"{}\"/>\n",
        triple(towards * DISTANCE),
        triple(-towards),
        triple(diffuse),
        triple(diffuse * SPECULAR)
    )
}
