#import gbuffer_surface

// Rays begin so many texels of the G-buffer before their surface, towards the viewer, who sees it: a rasterizer puts vertices on a grid of
// 1/256 of a texel, and what is seen so far beyond the edge of its surface lies behind another one, which the viewer may see at a small angle.
const TOWARDS_VIEWER: f32 = 0.125;
// Rounding of a position that was found from its depth, as a share of its distance from the eye, and of its coordinates.
const DEPTH_ROUNDING: f32 = 4e-6;
const ROUNDING: f32 = 2e-6;

// Where rays from a sample's surface begin.
fn ray_origin(position_world: vec3f, normal_world: vec3f) -> vec3f {
    let largest = max(max(abs(position_world.x), abs(position_world.y)), abs(position_world.z));
    let clearance = DEPTH_ROUNDING * distance(position_world, view.eye_world.xyz) * view.eye_world.w + ROUNDING * largest;
    let to_viewer = normalize(view.eye_world.xyz - position_world * view.eye_world.w);
    let step = TOWARDS_VIEWER * f32(view.interleave) * sample_extent_at(position_world);
    return position_world + clearance * normal_world + step * to_viewer;
}

// Number of a pixel among 16, such that those around it on its own grid and on one of every second pixel have the others.
fn pixel_of_16(pixel: vec2u) -> u32 {
    let near = (pixel ^ (pixel >> vec2u(2u))) & vec2u(1u);
    let far = (pixel >> vec2u(1u)) & vec2u(1u);
    return 4u * (2u * (near.x ^ near.y) + near.y) + 2u * (far.x ^ far.y) + far.y;
}
