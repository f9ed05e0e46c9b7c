//! The structs shared by Rust and WGSL have the same members at the same offsets.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

use std::mem::{offset_of, size_of};

use gnomon_shaders::{layout, resolve};
use naga::TypeInner;

struct Field {
    name: &'static str,
    offset: usize,
}

/// Compares one Rust struct with the WGSL struct of the same name; the first difference, if any.
fn difference(module: &naga::Module, name: &str, size: usize, fields: &[Field]) -> Option<String> {
    let found = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some(name));
    let Some((_, ty)) = found else { return Some(format!("no struct {name} in WGSL")) };
    let TypeInner::Struct { members, span } = &ty.inner else { return Some(format!("{name} is no struct")) };
    if *span as usize != size {
        return Some(format!("{name}: {span} bytes in WGSL, {size} in Rust"));
    }
    if members.len() != fields.len() {
        return Some(format!("{name}: {} members in WGSL, {} in Rust", members.len(), fields.len()));
    }
    members.iter().zip(fields).find_map(|(member, field)| {
        let same = member.name.as_deref() == Some(field.name) && member.offset as usize == field.offset;
        (!same).then(|| {
            format!(
                "{name}: WGSL has {:?} at {}, Rust {} at {}",
                member.name, member.offset, field.name, field.offset
            )
        })
    })
}

macro_rules! fields {
    ($ty:ident { $($field:ident),* $(,)? }) => {{
        // A struct pattern without `..` fails to compile when a field is missing here.
        let _ = |value: layout::$ty| { let layout::$ty { $($field: _),* } = value; };
        (
            stringify!($ty),
            size_of::<layout::$ty>(),
            vec![$(Field { name: stringify!($field), offset: offset_of!(layout::$ty, $field) }),*],
        )
    }};
}

fn shared() -> Vec<(&'static str, usize, Vec<Field>)> {
    vec![
        fields!(View {
            clip_from_world,
            world_from_clip,
            eye_world,
            size,
            flags,
            shadow_sampling,
            sample_extent,
            interleave,
            padding_0,
            padding_1,
            residual_sh,
            full_sh,
            environment_from_world,
        }),
        fields!(Light {
            direction,
            shape,
            tangent,
            angular_radius,
            bitangent,
            solid_angle,
            radiance,
            padding_2,
            corners,
            light_from_world,
            map_width_world,
            depth_range_world,
            normal_offset_world,
            near_world,
            position,
            kind,
            half_extent,
            role,
            caster_deviation_world,
            vector_irradiance,
            padding_1,
        }),
        fields!(Batch { first_light, end_light, flags, padding_0 }),
        fields!(DebugParameters {
            view,
            light,
            has_light,
            has_maps,
            to_viewer,
            lights_before,
            least_depth,
            depth_range,
            exposure,
            light_count,
        }),
        fields!(ShadingPoint { position_world, sample, normal, padding }),
        fields!(LightSums {
            diffuse_unshadowed,
            probed,
            diffuse_shadowed,
            probed_open,
            specular_unshadowed,
            padding_0,
            specular_shadowed,
            padding_1,
            diffuse_near,
            padding_2,
            specular_near,
            padding_3,
        }),
        fields!(CachedLobe { model, parameter, padding_0, padding_1 }),
        fields!(RadianceCache {
            right,
            count,
            up,
            samples,
            to_viewer,
            padding,
            environment_from_world,
            lobes
        }),
        fields!(MeshVertex { position, instance, normal, tangent_sign, tangent, record }),
        fields!(Instance { world_from_mesh, normal_from_mesh, first_joint, first_weight, padding }),
        fields!(Material {
            base_color,
            emissive,
            metallic,
            specular_color,
            specular,
            roughness,
            ior,
            normal_scale,
            alpha_cutoff,
            model,
            lobe_parameter,
            padding_0,
            padding_1,
            uv_rows,
        }),
        fields!(HardParameters { depth_bias, padding_0, padding_1, padding_2 }),
        fields!(PcfParameters { samples, radius_uv, depth_bias, normal_offset_scale }),
        fields!(PcssParameters {
            search_samples,
            filter_samples,
            depth_bias,
            normal_offset_scale,
            rotate_per_pixel,
            padding_0,
            padding_1,
            padding_2,
        }),
        fields!(MomentParameters {
            resolution,
            max_level,
            moment_bias,
            depth_bias,
            slope_bias,
            footprint_scale,
            intensity_scale,
            normal_offset_scale,
        }),
        fields!(ConvolutionParameters {
            order,
            groups,
            resolution,
            max_level,
            black_point,
            white_point,
            sharpening_a,
            sharpening_b,
            depth_bias,
            average_bias,
            footprint_scale,
            plane_iterations,
            contact_samples,
            contact_reach,
            padding_0,
            padding_1,
            far_sin,
            far_cos,
        }),
        fields!(ResolveParameters { samples, exposure, tone_mapping, padding }),
    ]
}

fn parse(source: &str) -> naga::Module {
    naga::front::wgsl::parse_str(source).unwrap()
}

#[test]
fn rust_and_wgsl_structs_agree() {
    let module = parse(&resolve("types", &[]).unwrap());
    for (name, size, fields) in shared() {
        assert_eq!(difference(&module, name, size, &fields), None);
    }
    let in_wgsl = module.types.iter().filter(|(_, ty)| matches!(ty.inner, TypeInner::Struct { .. })).count();
    assert_eq!(in_wgsl, shared().len(), "a struct of types.wgsl has no Rust mirror");
}

#[test]
fn two_swapped_fields_are_found() {
    let source = resolve("types", &[]).unwrap();
    let swapped = source.replace(
        "    black_point: f32,\n    white_point: f32,",
        "    white_point: f32,\n    black_point: f32,",
    );
    assert_ne!(source, swapped);
    let module = parse(&swapped);
    let found = shared().iter().filter_map(|(n, s, f)| difference(&module, n, *s, f)).collect::<Vec<_>>();
    assert_eq!(found.len(), 1, "{found:?}");
}
