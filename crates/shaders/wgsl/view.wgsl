#import types

// Binding 0 of group 0 of every pass over the screen.

@group(0) @binding(0) var<uniform> view: View;
