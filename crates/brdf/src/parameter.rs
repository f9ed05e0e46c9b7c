//! Parameters of surfaces as people write them. A model lists those that concern it.

use glam::Vec3;

use crate::Surface;

/// A parameter of a surface.
#[derive(Debug)]
pub struct Parameter {
    /// Name for files and options, snake_case.
    pub name: &'static str,
    /// Another name that is read, as papers have it.
    pub alias: Option<&'static str>,
    /// One line for people.
    pub help: &'static str,
    /// Three numbers instead of one.
    pub is_color: bool,
    /// Least and greatest value allowed.
    pub range: [f32; 2],
    /// What sliders offer of it.
    pub slider: [f32; 2],
    /// Where sliders start.
    pub start: f32,
    /// Its field, a number as three equal ones.
    pub get: fn(&Surface) -> Vec3,
    /// Writes its field; of three numbers one that takes one number reads the first.
    pub set: fn(&mut Surface, Vec3),
}

impl PartialEq for Parameter {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Parameter {
    /// Whether people call it so.
    pub fn is_called(&self, name: &str) -> bool {
        self.name == name || self.alias == Some(name)
    }

    /// What people may call it, for a list.
    pub fn names(&self) -> String {
        self.alias.map_or(self.name.to_owned(), |alias| format!("{} (or {alias})", self.name))
    }

    /// Whether every channel is in the range; not for NaN.
    pub fn allows(&self, value: Vec3) -> bool {
        let [least, most] = self.range;
        value.to_array().iter().all(|value| (least..=most).contains(value))
    }

    /// A number within its range, the lower end for NaN.
    #[allow(clippy::manual_clamp, reason = "clamp keeps NaN")]
    pub fn clamped(&self, surface: &Surface) -> f32 {
        (self.get)(surface).x.max(self.range[0]).min(self.range[1])
    }
}

/// Declares a parameter of the field of its name.
macro_rules! parameter {
    (color $id:ident $field:ident, $alias:expr, $help:literal, $range:expr, $slider:expr, $start:expr) => {
        #[doc = $help]
        pub static $id: Parameter = Parameter {
            name: stringify!($field),
            alias: $alias,
            help: $help,
            is_color: true,
            range: $range,
            slider: $slider,
            start: $start,
            get: |surface| surface.$field,
            set: |surface, value| surface.$field = value,
        };
    };
    (number $id:ident $field:ident, $help:literal, $range:expr, $slider:expr, $start:expr) => {
        #[doc = $help]
        pub static $id: Parameter = Parameter {
            name: stringify!($field),
            alias: None,
            help: $help,
            is_color: false,
            range: $range,
            slider: $slider,
            start: $start,
            get: |surface| Vec3::splat(surface.$field),
            set: |surface, value| surface.$field = value.x,
        };
    };
}

const UNIT: [f32; 2] = [0.0, 1.0];

parameter!(color BASE_COLOR base_color, Some("diffuse"), "Colour of the matte part, and of metal", UNIT, UNIT, 0.5);
parameter!(number METALLIC metallic, "0 dielectric, 1 metal", UNIT, UNIT, 0.0);
parameter!(number ROUGHNESS roughness, "Perceptual roughness: 0 a mirror, 1 almost matte", UNIT, UNIT, 0.4);
parameter!(number SPECULAR specular, "Strength of the glossy part; 0 is matte", UNIT, UNIT, 0.3);
parameter!(color SPECULAR_COLOR specular_color, None, "Tint of the glossy part, of a dielectric's along the normal", [0.0, f32::MAX], UNIT, 1.0);
parameter!(number IOR ior, "Index of refraction of the dielectric", [1.0, 10.0], [1.0, 3.0], 1.5);
// Upper end: a lobe 0.8 degrees wide, and normals are stored that finely.
parameter!(number SHININESS shininess, "Exponent of the lobe", [0.0, 10_000.0], [0.0, 500.0], 40.0);
// Lower end: n . h rounds by 6e-8, which moves the density of so narrow a lobe by 0.1 %. Upper end: as far as `gaussian_norm` is fitted.
parameter!(number SLOPE slope, "m of the microfacets: their root mean square slope or angle", [0.01, 1.0], [0.05, 1.0], 0.25);
parameter!(number ASPECT aspect, "Width of the lobe across the tangent over that along it", [0.1, 10.0], [0.2, 5.0], 4.0);
parameter!(color INDEX index, None, "Index of refraction, its real part", [0.01, 1000.0], [0.01, 5.0], 1.5);
parameter!(color EXTINCTION extinction, None, "Its imaginary part; 0 for what is no metal", [0.0, 1000.0], [0.0, 10.0], 0.0);
parameter!(number ANISOTROPY anisotropy, "Strength of glTF's anisotropy: the lobe widens along the tangent", UNIT, UNIT, 0.7);
parameter!(number ANISOTROPY_ROTATION anisotropy_rotation, "From the tangent, counter-clockwise [rad]", [-7.0, 7.0], [-3.2, 3.2], 0.0);
parameter!(color AXES axes, None, "Weights of a cosine lobe's axes; -1/-1/1 is Phong's", [-1.0, 1.0], [-1.0, 1.0], 1.0);
parameter!(number CLEARCOAT clearcoat, "Strength of a clear coat over the model", UNIT, UNIT, 1.0);
parameter!(number CLEARCOAT_ROUGHNESS clearcoat_roughness, "Perceptual roughness of the clear coat", UNIT, UNIT, 0.05);

parameter!(color SHEEN_COLOR sheen_color, None, "Sheen of cloth over the model", UNIT, UNIT, 1.0);
parameter!(number SHEEN_ROUGHNESS sheen_roughness, "Perceptual roughness of the sheen", UNIT, UNIT, 0.5);

/// Parameters of what lies on the base: they concern every model.
pub static FINISH: &[&Parameter] = &[&CLEARCOAT, &CLEARCOAT_ROUGHNESS, &SHEEN_COLOR, &SHEEN_ROUGHNESS];
