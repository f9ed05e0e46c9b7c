#import seen

// A geometry layer of what is seen, as 32-bit words: whole numbers, or floats by their bits.

@group(GROUP_PASS) @binding(0) var identities: texture_2d<u32>;
@group(GROUP_PASS) @binding(1) var places: texture_2d<u32>;
@group(GROUP_PASS) @binding(2) var<uniform> layer: u32;
@group(GROUP_PASS) @binding(3) var layer_words: texture_storage_2d<rgba32uint, write>;

// The point of the camera's space that lies behind a place of the picture, at a depth.
fn camera_position(place: vec2f, depth: f32) -> vec3f {
    let ndc = place / vec2f(view.size) * vec2f(2.0, -2.0) + vec2f(-1.0, 1.0);
    let plane = ndc * seen_frame.plane_scale + seen_frame.plane_offset;
    return vec3f(plane * select(depth, 1.0, seen_frame.is_parallel != 0u), -depth);
}

fn background_motion(place: vec2f) -> vec2f {
    let direction = seen_frame.world_from_camera * vec4f(camera_position(place, 1.0), 0.0);
    return select(motion_from(seen_frame.clip_before_from_world * direction, place), vec2f(0.0), seen_frame.is_parallel != 0u);
}

@compute @workgroup_size(TILE, TILE)
fn write_layer(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= view.size) {
        return;
    }
    let identity = textureLoad(identities, id.xy, 0);
    let seen = textureLoad(places, id.xy, 0);
    let place = vec2f(id.xy) + 0.5;
    let is_seen = identity.y != 0u;
    var words = vec4u(0u);
    switch layer {
        case LAYER_DEPTH: {
            words.x = select(INFINITY_BITS, identity.w, is_seen);
        }
        case LAYER_NORMAL: {
            words = select(words, bitcast<vec4u>(vec4f(unpack_normal(identity.x), 0.0)), is_seen);
        }
        case LAYER_POSITION: {
            let position = seen_frame.world_from_camera * vec4f(camera_position(place, bitcast<f32>(identity.w)), 1.0);
            words = select(words, bitcast<vec4u>(position), is_seen);
        }
        case LAYER_UV: {
            words = vec4u(seen.xy, 0u, 0u);
        }
        case LAYER_MOTION: {
            words = vec4u(select(bitcast<vec2u>(background_motion(place)), seen.zw, is_seen), 0u, 0u);
        }
        case LAYER_OBJECT: {
            words.x = identity.y;
        }
        case LAYER_MATERIAL: {
            words.x = select(0u, identity.z + 1u, is_seen);
        }
        default: {}
    }
    textureStore(layer_words, id.xy, words);
}
