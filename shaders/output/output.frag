// Exposure, tone curve, and the debug views, into the target.
#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "shared/frame.glsl"
#include "shared/fovea.glsl"
layout(set = 0, binding = 0) uniform Frame { FrameParams frame; };
layout(set = 0, binding = 1) uniform texture2D radiance;
layout(set = 0, binding = 2) uniform Fovea { FoveaParams fovea; };
layout(location = 0) out vec4 color;

layout(constant_id = 0) const uint TONE_MAP = 1u;      // 0 none, 1 ACES
layout(constant_id = 1) const bool ENCODE_SRGB = true; // false for targets of sRGB format
layout(constant_id = 2) const uint VIEW = 0u;          // 0 picture, 1 density, 2 grid, 3 gaze, 4 rings
layout(constant_id = 3) const bool FOVEATED = true;

// ACES filmic curve: the rational fit by K. Narkowicz (2015).
vec3 aces(vec3 x) {
    return clamp((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0);
}

// IEC 61966-2-1.
vec3 srgb(vec3 c) {
    return mix(1.055 * pow(max(c, vec3(0.0031308)), vec3(1.0 / 2.4)) - 0.055, 12.92 * c, lessThan(c, vec3(0.0031308)));
}

// Display area of the LP texel at a position, px^2.
float texel_area_px(vec2 at) {
    vec2 uv = fovea_forward_texels(fovea, at);
    float r = distance(at, fovea.gaze_px.xy);
    float r0 = length(fovea_inverse_offset(fovea, vec2(max(uv.x - 0.5, 0.0), uv.y)));
    float r1 = length(fovea_inverse_offset(fovea, vec2(min(uv.x + 0.5, fovea.size_f.x), uv.y)));
    return max((r1 - r0) * r * (6.2831853 / fovea.size_f.y), 1e-6);
}

// Samples per pixel as a colour: blue 1/16, green 1/4, yellow 1, red above.
vec3 density_color(float samples_per_px) {
    float t = clamp((log2(samples_per_px) + 6.0) / 7.0, 0.0, 1.0);
    return clamp(vec3(3.0 * t - 1.2, 1.6 - abs(3.2 * t - 1.9), 1.6 - 3.2 * t), 0.0, 1.0);
}

// Eccentricity (degrees) of a display position.
float eccentricity_deg(vec2 at) {
    vec3 a = normalize(frame.ray_base.xyz + at.x * frame.ray_dx.xyz + at.y * frame.ray_dy.xyz);
    vec3 b = normalize(frame.ray_base.xyz + frame.gaze.x * frame.ray_dx.xyz + frame.gaze.y * frame.ray_dy.xyz);
    return degrees(atan(length(cross(a, b)), dot(a, b)));
}

vec3 overlay(vec3 picture, vec2 at) {
    float r = distance(at, frame.gaze.xy);
    if (VIEW == 1u) {
        float density = 1.0;
        if (r >= fovea.ring.x && FOVEATED) {
            density = 1.0 / texel_area_px(at);
        }
        return mix(density_color(density), picture, 0.15);
    }
    if (VIEW == 2u && r >= fovea.ring.x && FOVEATED) {
        // Every eighth texel's border, as wide as a pixel and a half.
        vec2 uv = fovea_forward_texels(fovea, at) / 8.0;
        vec2 across = fovea_forward_texels(fovea, at + (at - frame.gaze.xy) / r) / 8.0;
        float wide_u = 0.75 * abs(across.x - uv.x);
        float wide_v = 0.75 * fovea.size_f.y / (6.2831853 * r) / 8.0;
        vec2 near_line = abs(uv - round(uv));
        bool line = near_line.x < wide_u || near_line.y < wide_v;
        return line ? mix(picture, vec3(1.0, 0.85, 0.2), 0.7) : picture;
    }
    if (VIEW == 3u) {
        vec2 d = abs(at - frame.gaze.xy);
        bool cross_ = (min(d.x, d.y) < 1.0 && max(d.x, d.y) < 24.0) || abs(r - 16.0) < 1.0;
        return cross_ ? vec3(1.0, 0.1, 0.1) : picture;
    }
    if (VIEW == 4u) {
        const float rings[5] = float[](2.0, 5.0, 10.0, 20.0, 40.0);
        float e = eccentricity_deg(at);
        float wide = degrees(frame.pixel_angle_rad);
        for (int i = 0; i < 5; ++i) {
            if (abs(e - rings[i]) < wide) {
                return vec3(0.2, 1.0, 0.5);
            }
        }
        // Where the native disc ends.
        if (abs(r - fovea.ring.x) < 1.0 && FOVEATED) {
            return vec3(1.0, 0.8, 0.1);
        }
    }
    return picture;
}

void main() {
    ivec2 px = ivec2(gl_FragCoord.xy);
    vec3 linear = texelFetch(radiance, px, 0).rgb * frame.exposure;
    vec3 mapped = TONE_MAP == 1u ? aces(linear) : clamp(linear, 0.0, 1.0);
    mapped = overlay(mapped, vec2(px) + 0.5);
    color = vec4(ENCODE_SRGB ? srgb(mapped) : mapped, 1.0);
}
