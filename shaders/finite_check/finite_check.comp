// Counts NaN and infinite values of an image, and texels that nothing has written (alpha not 1) where
// `full` says that there should be none.
#version 450
#extension GL_EXT_samplerless_texture_functions : require
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform texture2D image;
layout(set = 0, binding = 1, std430) buffer Findings { uint non_finite; uint holes; };
layout(push_constant) uniform Push { uint full; };

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, textureSize(image, 0)))) {
        return;
    }
    vec4 value = texelFetch(image, at, 0);
    if (any(isnan(value)) || any(isinf(value))) {
        atomicAdd(non_finite, 1u);
    }
    if (full != 0u && value.a != 1.0) {
        atomicAdd(holes, 1u);
    }
}
