use glam::{DVec3, Vec2, Vec3};
use gnomon_envmap::Equirect;

/// Outline of a distant light on the plane that touches the unit sphere at the light's centre direction (gnomonic
/// projection), in the light's own `tangent` and `bitangent`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightShape {
    /// All directions within `angular_radius` [rad] of the centre.
    Disk {
        /// Half the apex angle of the cone [rad], in (0, pi/2).
        angular_radius: f32,
    },
    /// A convex quadrilateral, counter-clockwise seen from the scene: the four corners as unit directions.
    Rectangle {
        /// Corner directions (unit). A rectangle on a cube face seen from its own centre is this quadrilateral.
        corners: [Vec3; 4],
    },
}

/// A uniform area light infinitely far away.
#[derive(Clone, Debug, PartialEq)]
pub struct DistantLight {
    /// Unit direction from the scene towards the light's centre.
    pub direction: Vec3,
    /// Unit direction, perpendicular to `direction`: the first axis of the light's plane.
    pub tangent: Vec3,
    /// `direction x tangent`: the second axis.
    pub bitangent: Vec3,
    /// Outline.
    pub shape: LightShape,
    /// Exact solid angle of the outline [sr].
    pub solid_angle: f32,
    /// Radiance, uniform over the outline; linear Rec. 709.
    pub radiance: Vec3,
}

impl DistantLight {
    /// Flux [radiance x sr], channel by channel.
    pub fn flux(&self) -> DVec3 {
        self.radiance.as_dvec3() * f64::from(self.solid_angle)
    }

    /// Half the width and height of the outline's bounding box on the tangent plane (tangents of half angles).
    pub fn tan_half_extent(&self) -> Vec2 {
        match self.shape {
            LightShape::Disk { angular_radius } => Vec2::splat(angular_radius.tan()),
            LightShape::Rectangle { corners } => corners
                .iter()
                .map(|corner| {
                    let depth = corner.dot(self.direction);
                    Vec2::new(corner.dot(self.tangent), corner.dot(self.bitangent)).abs() / depth
                })
                .fold(Vec2::ZERO, Vec2::max),
        }
    }
}

/// What a fit makes of an environment map. Flux of all `lights` plus flux of `residual` equals the map's flux.
#[derive(Clone, Debug)]
pub struct LightSet {
    /// Name of the fit that made it.
    pub method: &'static str,
    /// Lights, in the order they were found.
    pub lights: Vec<DistantLight>,
    /// What is left of the map: the ambient part. As large as the input map.
    pub residual: Equirect,
}
