#import gbuffer_surface

// A scene without bumps, or one whose bumps only shade.

struct Relief {
    none: u32,
}

fn relief_at(sample: vec2u) -> Relief {
    return Relief(0u);
}

fn asks_for(form_factor: f32, relief: Relief) -> bool {
    return form_factor > 0.0;
}

fn asked_normal(form_factor: f32, relief: Relief, surface: Surface) -> vec3f {
    return surface.n;
}

fn surface_visibility(light: u32, relief: Relief, surface: Surface) -> f32 {
    return 1.0;
}

fn scattered_light(light: u32, relief: Relief, surface: Surface) -> vec3f {
    return vec3f(0.0);
}
