use std::f32::consts::PI;

use glam::{Affine3A, Vec2, Vec3};

use crate::{NodeId, Scene};

/// Outline of an area light in its node's space: flat ones lie in the plane z = 0 around the origin and emit towards -z, the
/// way a camera looks; a sphere lies around the origin and emits outwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AreaLightShape {
    /// Disk.
    Disk {
        /// [m]
        radius: f32,
    },
    /// Rectangle; a square where both are the same.
    Rectangle {
        /// Width along x, height along y [m].
        size: Vec2,
    },
    /// Sphere.
    Sphere {
        /// [m]
        radius: f32,
    },
    /// Disk infinitely far away, seen towards the node's +z: a sun. It has no place, and its extent is that at a distance of 1.
    Sun {
        /// Angle between its middle and its rim, below a quarter turn [rad].
        angular_radius: f32,
    },
}

impl AreaLightShape {
    /// Area of the emitting surface [m^2].
    pub fn area(&self) -> f32 {
        match *self {
            Self::Disk { radius } => PI * radius * radius,
            Self::Rectangle { size } => size.x * size.y,
            Self::Sphere { radius } => 4.0 * PI * radius * radius,
            Self::Sun { angular_radius } => PI * angular_radius.tan().powi(2),
        }
    }

    /// Irradiance of a surface that faces it and sees all of it, per unit of its radiance: of a sun itself, of others in the scene times the
    /// square of their distance, far away [sr, m^2 sr]. That is their intensity.
    pub fn facing_irradiance(&self) -> f32 {
        match *self {
            Self::Sphere { radius } => PI * radius * radius,
            Self::Sun { angular_radius } => PI * angular_radius.sin().powi(2),
            Self::Disk { .. } | Self::Rectangle { .. } => self.area(),
        }
    }

    /// Half the width and height of the outline's bounding box across the axis [m].
    pub fn half_extent(&self) -> Vec2 {
        match *self {
            Self::Disk { radius } | Self::Sphere { radius } => Vec2::splat(radius),
            Self::Rectangle { size } => 0.5 * size,
            Self::Sun { angular_radius } => Vec2::splat(angular_radius.tan()),
        }
    }
}

/// How a light's radiance depends on the direction from its centre in which it is seen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Spread {
    /// Not at all.
    #[default]
    Even,
    /// A spot around its front: whole within the cone of half the angle `inner`, less and less up to that of `outer` [rad]
    /// (KHR_lights_punctual, "Inner and Outer Cone Angles").
    Cone {
        /// From 0 to below `outer`.
        inner: f32,
        /// Up to a quarter turn.
        outer: f32,
    },
    /// By the angle with its front.
    Profile(Profile),
}

/// A flat light gives nothing to what is nearer to its plane than this share of its smaller half side: surfaces that emit have their light a
/// little before them.
pub const FLAT_CLEARANCE: f32 = 3e-4;

/// Values of a [`Profile`]: what fits into a light's uniform.
pub const PROFILE_VALUES: usize = 24;

/// Shares of a light's radiance by the angle with its front, evenly spread from 0; beyond the last there is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Profile {
    /// Angle of the last one, above 0 [rad].
    last: f32,
    values: [f32; PROFILE_VALUES],
}

impl Profile {
    /// By the share at each angle [rad] up to `last`; `None` unless that is an angle above 0 and up to half a turn.
    pub fn new(last: f32, share: impl Fn(f32) -> f32) -> Option<Self> {
        let step = last / (PROFILE_VALUES - 1) as f32;
        let values = std::array::from_fn(|i| share(i as f32 * step));
        (last > 0.0 && last <= PI + 1e-3).then_some(Self { last, values })
    }

    /// Share in a direction of this cosine with the front.
    pub fn share(&self, cosine: f32) -> f32 {
        let place = cosine.clamp(-1.0, 1.0).acos() / self.last * (PROFILE_VALUES - 1) as f32;
        if place > (PROFILE_VALUES - 1) as f32 + 1e-3 {
            return 0.0;
        }
        let first = (place as usize).min(PROFILE_VALUES - 2);
        let between = place - first as f32;
        self.values[first] + between * (self.values[first + 1] - self.values[first])
    }
}

impl Spread {
    /// Factor and summand of the cosine in [`cone_share`].
    pub fn cone(&self) -> Vec2 {
        match *self {
            Self::Even | Self::Profile(_) => Vec2::new(0.0, 1.0),
            Self::Cone { inner, outer } => {
                let scale = 1.0 / (inner.cos() - outer.cos()).max(0.001);
                Vec2::new(scale, -outer.cos() * scale)
            }
        }
    }
}

impl Spread {
    /// The last angle of a profile, 0 without one [rad], and its values.
    pub fn profile(&self) -> (f32, [f32; PROFILE_VALUES]) {
        match self {
            Self::Profile(profile) => (profile.last, profile.values),
            _ => (0.0, [0.0; PROFILE_VALUES]),
        }
    }

    /// Share of its radiance that a light has in a direction of this cosine with its front.
    pub fn share(&self, cosine: f32) -> f32 {
        match self {
            Self::Profile(profile) => profile.share(cosine),
            _ => cone_share(cosine, self.cone()),
        }
    }
}

/// Share of its radiance that a light has in a direction of this cosine with its front.
pub fn cone_share(cosine: f32, cone: Vec2) -> f32 {
    let share = (cosine * cone.x + cone.y).clamp(0.0, 1.0);
    share * share
}

/// A uniform Lambertian emitter at a place in the scene. It lights surfaces and is mirrored by them, but the camera does not see
/// it, and it casts no shadow.
#[derive(Clone, Debug, PartialEq)]
pub struct AreaLight {
    /// The node that places it. Only the node's position and orientation count: its scale leaves the outline as it is.
    pub node: NodeId,
    /// Outline.
    pub shape: AreaLightShape,
    /// Radiance, the same everywhere and in every direction of its front; linear Rec. 709. The power is `pi area radiance`.
    pub radiance: Vec3,
    /// In which directions.
    pub spread: Spread,
}

/// An [`AreaLight`] in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacedLight {
    /// Outline.
    pub shape: AreaLightShape,
    /// Centre [m].
    pub center: Vec3,
    /// Unit normal of the front, towards which it emits. For a sphere the node's own -z.
    pub normal: Vec3,
    /// Unit axis of the width.
    pub tangent: Vec3,
    /// Unit axis of the height: `tangent x normal`.
    pub bitangent: Vec3,
    /// Radiance, linear Rec. 709.
    pub radiance: Vec3,
    /// In which directions.
    pub spread: Spread,
}

impl PlacedLight {
    /// `None` where the light is dark, has no extent or is not finite, or where the transform leaves it no orientation.
    fn new(light: &AreaLight, world_from_node: &Affine3A) -> Option<Self> {
        let half = light.shape.half_extent();
        let center = Vec3::from(world_from_node.translation);
        let finite = half.is_finite() && center.is_finite() && light.radiance.is_finite();
        if !finite || half.min_element() <= 0.0 || light.radiance.max_element() <= 0.0 {
            return None;
        }
        let axis = |axis| Vec3::from(world_from_node.matrix3 * axis).try_normalize();
        let tangent = axis(glam::Vec3A::X)?;
        // The plane keeps its own direction under a shear, and its front stays the front under a reflection.
        let plane = tangent.cross(axis(glam::Vec3A::Y)?).try_normalize()?;
        let normal = if plane.dot(axis(glam::Vec3A::Z)?) > 0.0 { -plane } else { plane };
        Some(Self {
            shape: light.shape,
            center,
            normal,
            tangent,
            bitangent: tangent.cross(normal),
            radiance: light.radiance.max(Vec3::ZERO),
            spread: light.spread,
        })
    }

    /// Share of its radiance that it has towards a place: that of the direction from its centre, for all of it.
    pub fn share_towards(&self, position: Vec3) -> f32 {
        self.spread.share((position - self.center).normalize_or_zero().dot(self.normal))
    }

    /// Corners of a rectangle, or of the square around another outline, counter-clockwise seen from the front [m].
    pub fn corners(&self) -> [Vec3; 4] {
        let half = self.shape.half_extent();
        let (across, up) = (self.tangent * half.x, self.bitangent * half.y);
        [-across - up, up - across, across + up, across - up].map(|corner| self.center + corner)
    }
}

impl Scene {
    /// The lights that shine, in world space and in their order. Those that emit nothing are left out: dark ones, ones without
    /// extent, and ones whose transform has collapsed.
    pub fn placed_lights(&self) -> Vec<PlacedLight> {
        let world = self.world_from_nodes();
        let placed = |light: &AreaLight| PlacedLight::new(light, world.get(light.node.0)?);
        self.lights.iter().filter_map(placed).collect()
    }
}

#[cfg(test)]
mod tests {
    use glam::{Affine3A, Quat};

    use super::*;
    use crate::Node;

    fn lit(transforms: &[Affine3A], shape: AreaLightShape, radiance: Vec3) -> Scene {
        let nodes = transforms.iter().enumerate().map(|(index, &parent_from_node)| Node {
            parent: index.checked_sub(1).map(NodeId),
            parent_from_node,
            ..Node::default()
        });
        let light = AreaLight { node: NodeId(transforms.len() - 1), shape, radiance, spread: Spread::Even };
        Scene { nodes: nodes.collect(), lights: vec![light], ..Scene::default() }
    }

    const RECTANGLE: AreaLightShape = AreaLightShape::Rectangle { size: Vec2::new(2.0, 1.0) };

    #[test]
    fn a_light_moves_with_the_hierarchy_and_keeps_its_size() {
        let parent = Affine3A::from_scale_rotation_translation(
            Vec3::splat(3.0),
            Quat::from_rotation_y(std::f32::consts::FRAC_PI_2),
            Vec3::new(0.0, 5.0, 0.0),
        );
        let scene = lit(&[parent, Affine3A::from_translation(Vec3::Z)], RECTANGLE, Vec3::ONE);
        let [light] = scene.placed_lights()[..] else { panic!("one light") };
        assert!((light.center - Vec3::new(3.0, 5.0, 0.0)).length() < 1e-5);
        assert!((light.normal - Vec3::NEG_X).length() < 1e-6, "{}", light.normal);
        assert!((light.tangent - Vec3::NEG_Z).length() < 1e-6 && (light.bitangent - Vec3::Y).length() < 1e-6);
        assert_eq!(light.shape, RECTANGLE);
        let [a, b, c, _] = light.corners();
        assert!((b - a).cross(c - b).dot(light.normal) > 0.0, "counter-clockwise seen from the front");
        assert!((a - Vec3::new(3.0, 4.5, 1.0)).length() < 1e-5, "{a}");
    }

    #[test]
    fn the_front_stays_the_front_under_reflections() {
        for scale in [Vec3::new(-1.0, 1.0, 1.0), Vec3::new(1.0, 2.0, 1.0), Vec3::new(-1.0, -1.0, -1.0)] {
            let scene = lit(&[Affine3A::from_scale(scale)], RECTANGLE, Vec3::ONE);
            let light = scene.placed_lights()[0];
            assert_eq!(light.normal, Vec3::new(0.0, 0.0, -scale.z), "{scale}");
            assert!((light.tangent.cross(light.bitangent) + light.normal).length() < 1e-6);
        }
    }

    #[test]
    fn what_emits_nothing_is_left_out() {
        let one = [Affine3A::IDENTITY];
        for scene in [
            lit(&one, RECTANGLE, Vec3::ZERO),
            lit(&one, RECTANGLE, Vec3::splat(f32::NAN)),
            lit(&one, AreaLightShape::Sphere { radius: 0.0 }, Vec3::ONE),
            lit(&one, AreaLightShape::Disk { radius: f32::NAN }, Vec3::ONE),
            lit(&one, AreaLightShape::Rectangle { size: Vec2::new(1.0, -1.0) }, Vec3::ONE),
            lit(&[Affine3A::from_scale(Vec3::new(1.0, 0.0, 1.0))], RECTANGLE, Vec3::ONE),
            lit(&[Affine3A::from_translation(Vec3::splat(f32::INFINITY))], RECTANGLE, Vec3::ONE),
            Scene {
                lights: vec![AreaLight {
                    node: NodeId(9),
                    shape: RECTANGLE,
                    radiance: Vec3::ONE,
                    spread: Spread::Even,
                }],
                ..Scene::default()
            },
        ] {
            assert!(scene.placed_lights().is_empty(), "{:?}", scene.lights);
        }
    }

    #[test]
    fn appended_lights_follow_their_nodes() {
        let mut scene = lit(&[Affine3A::IDENTITY], RECTANGLE, Vec3::ONE);
        let other = lit(&[Affine3A::from_translation(Vec3::X)], RECTANGLE, Vec3::ONE);
        let root = Node { parent_from_node: Affine3A::from_translation(Vec3::Y), ..Node::default() };
        scene.append(other, root);
        let centers: Vec<Vec3> = scene.placed_lights().iter().map(|light| light.center).collect();
        assert_eq!(centers, [Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0)]);
    }
}
