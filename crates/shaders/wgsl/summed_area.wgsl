#import types
#import series

// Summed-area tables of the basis images of all lights' shadow maps (`basis.wgsl`), layer for layer: first along rows, then along
// columns, one thread each. Summed are differences to the value of a texel that nothing blocks: sums stay small where
// little blocks, which keeps their precision (Hensley et al. 2005, section 4), and whatever lies outside the map adds 0.

@group(GROUP_PASS) @binding(0) var<uniform> parameters: ConvolutionParameters;
@group(GROUP_PASS) @binding(1) var depth_maps: texture_depth_2d_array;
@group(GROUP_PASS) @binding(2) var row_sums: texture_storage_2d_array<rgba32float, write>;

@group(GROUP_PASS) @binding(3) var summed_rows: texture_2d_array<f32>;
@group(GROUP_PASS) @binding(4) var table_rgba32: texture_storage_2d_array<rgba32float, write>;
@group(GROUP_PASS) @binding(5) var table_r32: texture_storage_2d_array<r32float, write>;

const IMAGE_SIN: u32 = 0u;
const IMAGE_COS: u32 = 1u;
const IMAGE_Z_SIN: u32 = 2u;
const IMAGE_Z_COS: u32 = 3u;

fn sum_row(row: u32, layer: u32, image: u32) {
    let size = textureDimensions(depth_maps);
    if row >= size.y {
        return;
    }
    let light = layer / parameters.groups;
    let group = layer % parameters.groups;
    let with_cosine = image == IMAGE_COS || image == IMAGE_Z_COS;
    let with_depth = image == IMAGE_Z_SIN || image == IMAGE_Z_COS;
    let far = select(parameters.far_sin[group], parameters.far_cos[group], with_cosine)
        * select(1.0, SERIES_DEPTH_SCALE, with_depth);
    var sum = vec4f(0.0);
    for (var x = 0u; x < size.x; x++) {
        let stored = textureLoad(depth_maps, vec2u(x, row), light, 0);
        // Nothing blocks: the difference is 0 exactly.
        if stored < 1.0 {
            let z = SERIES_DEPTH_SCALE * stored;
            let phases = series_phases(z, group);
            sum += select(phases[1], phases[0], with_cosine) * select(1.0, z, with_depth) - far;
        }
        textureStore(row_sums, vec2u(x, row), layer, sum);
    }
}

@compute @workgroup_size(LINE_WORKGROUP)
fn rows_sin(@builtin(global_invocation_id) id: vec3u) {
    sum_row(id.x, id.z, IMAGE_SIN);
}

@compute @workgroup_size(LINE_WORKGROUP)
fn rows_cos(@builtin(global_invocation_id) id: vec3u) {
    sum_row(id.x, id.z, IMAGE_COS);
}

@compute @workgroup_size(LINE_WORKGROUP)
fn rows_z_sin(@builtin(global_invocation_id) id: vec3u) {
    sum_row(id.x, id.z, IMAGE_Z_SIN);
}

@compute @workgroup_size(LINE_WORKGROUP)
fn rows_z_cos(@builtin(global_invocation_id) id: vec3u) {
    sum_row(id.x, id.z, IMAGE_Z_COS);
}

@compute @workgroup_size(LINE_WORKGROUP)
fn rows_depth(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(depth_maps);
    if id.x >= size.y {
        return;
    }
    var sum = 0.0;
    for (var x = 0u; x < size.x; x++) {
        sum += SERIES_DEPTH_SCALE * (textureLoad(depth_maps, vec2u(x, id.x), id.z, 0) - 1.0);
        textureStore(row_sums, vec2u(x, id.x), id.z, vec4f(sum, 0.0, 0.0, 0.0));
    }
}

@compute @workgroup_size(LINE_WORKGROUP)
fn columns_rgba32(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(summed_rows);
    if id.x >= size.x {
        return;
    }
    var sum = vec4f(0.0);
    for (var y = 0u; y < size.y; y++) {
        sum += textureLoad(summed_rows, vec2u(id.x, y), id.z, 0);
        textureStore(table_rgba32, vec2u(id.x, y), id.z, sum);
    }
}

@compute @workgroup_size(LINE_WORKGROUP)
fn columns_r32(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(summed_rows);
    if id.x >= size.x {
        return;
    }
    var sum = 0.0;
    for (var y = 0u; y < size.y; y++) {
        sum += textureLoad(summed_rows, vec2u(id.x, y), id.z, 0).r;
        textureStore(table_r32, vec2u(id.x, y), id.z, vec4f(sum, 0.0, 0.0, 0.0));
    }
}
