#import view

// The frame of the pass that sums light: a batch of lights.

// Uniform, because every sample of the picture reads the same light at a time.
@group(GROUP_FRAME) @binding(1) var<uniform> lights: array<Light, MAX_BATCH_LIGHTS>;
@group(GROUP_FRAME) @binding(2) var<uniform> batch: Batch;

// Whether a light of the batch is let through: unshadowed light is that of all of them.
fn is_shown(light: u32) -> bool {
    return batch.group == ALL_GROUPS || batch.group == lights[light].group;
}
