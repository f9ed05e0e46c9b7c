#import types

// A texture coordinate in [0, 1], as a texture's wrapping has it.
fn wrapped_coordinate(x: f32, wrap: u32) -> f32 {
    switch wrap {
        case WRAP_CLAMP: {
            return saturate(x);
        }
        case WRAP_MIRROR: {
            return 1.0 - abs(2.0 * fract(0.5 * x) - 1.0);
        }
        default: {
            return fract(x);
        }
    }
}
