// What lighting.glsl reads.
layout(set = 0, binding = 0) uniform Frame { FrameParams frame; };
layout(set = 0, binding = 1, std430) readonly buffer Lights { Light lights[]; };
layout(set = 0, binding = 2, std430) readonly buffer ShadowViews { ShadowView shadow_views[]; };
layout(set = 0, binding = 3) uniform texture2DArray shadow_maps;
layout(set = 0, binding = 4) uniform sampler2D sky;
layout(set = 0, binding = 5) uniform sampler2D specular_env;
layout(set = 0, binding = 6) uniform sampler2D dfg;
