#import view

// Group 0 of the pass that sums light.

// Uniform, because every sample of the picture reads the same light at a time.
@group(0) @binding(1) var<uniform> lights: array<Light, MAX_BATCH_LIGHTS>;
@group(0) @binding(2) var<uniform> batch: Batch;
