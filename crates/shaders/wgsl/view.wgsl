#import types

// Of every pass that draws or reads what the camera sees.

@group(GROUP_FRAME) @binding(0) var<uniform> view: View;
