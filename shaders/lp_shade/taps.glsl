// An LP texel's surface from several G-buffer pixels of its footprint. One alone would be an arbitrary
// one of them: highlights would come and go as the picture moves.

layout(constant_id = 20) const bool HAS_TAPS = false;

// Places in the texel beside its centre, along u and v: two nested patterns of which each has a tap in
// every row and column of its grid, the first of 4 and both together of 8. More taps cost fetches and leave
// less noise.
const uint TAPS = 8u;
const uint TAPS_OF_SMALL = 4u;
const vec2 TAP_OFFSETS[TAPS] = vec2[](
    vec2(-0.1875, -0.4375), vec2(0.4375, -0.1875), vec2(0.1875, 0.4375), vec2(-0.4375, 0.1875),
    vec2(0.3125, -0.3125), vec2(0.0625, 0.0625), vec2(-0.3125, 0.3125), vec2(-0.0625, -0.0625));

// Texels at most so wide get the first pattern alone. Beyond, 4 taps and the centre miss what is smaller
// than about two pixels.
const float SMALL_TEXEL_PX = 4.0;

// A tap farther than this off the centre's plane, in widths of the texel, belongs to another surface. More
// lets normals run over silhouettes, less drops the taps of small round things.
const float PLANE_WIDTHS = 1.0;

// The most that the taps' normals add to the squared alpha: the clamp of Tokuyoshi and Kaplanyan (2019),
// which keeps silhouettes dark. There normals turn fast, but in one direction only, for which a round lobe
// is too wide. More flickers less on small round things and brightens their rims.
const float MOST_ALPHA2 = 0.18;

bool same_surface(PixelSurface centre, PixelSurface tap, float width_m) {
    return tap.depth > 0.0 && tap.surface.unlit == centre.surface.unlit
        && dot(tap.surface.normal, centre.surface.normal) > 0.0
        && abs(dot(centre.surface.normal, tap.position - centre.position)) <= PLANE_WIDTHS * width_m;
}

// The display pixel at a place in the texel; the nearest one where that lies off the display.
ivec2 tap_px(TexelPlace place, vec2 offset) {
    float angle = min(6.2831853 / place.height, 1.5) * offset.y;
    vec2 at = place_px(place, vec4(offset, fovea_cos_small(angle), fovea_sin_small(angle)));
    return clamp(ivec2(floor(at)), ivec2(0), ivec2(fovea.size.xy) - 1);
}

float alpha2_of(Surface surface) {
    float alpha = surface.roughness * surface.roughness;
    return alpha * alpha;
}

// Replaces the surface of the texel's centre by the mean over the taps of the same surface; position and
// kind stay. The normals' variance goes into the roughness.
void gather_taps(uvec2 texel, inout PixelSurface centre) {
    TexelPlace place = texel_place(texel);
    if (place.width_px <= 1.0) {
        return;
    }
    float width_m = place.width_px * frame.pixel_angle_rad * length(centre.position);
    Surface sum = centre.surface;
    float alpha2 = alpha2_of(centre.surface);
    // Differences to the centre's normal: for equal normals their variance is exactly 0.
    vec3 off = vec3(0.0);
    float off2 = 0.0;
    float count = 1.0;
    uint taps = place.width_px > SMALL_TEXEL_PX ? TAPS : TAPS_OF_SMALL;
    for (uint i = 0u; i < taps; ++i) {
        PixelSurface tap = surface_of_px(true, tap_px(place, TAP_OFFSETS[i]));
        if (!same_surface(centre, tap, width_m)) {
            continue;
        }
        vec3 step_ = tap.surface.normal - centre.surface.normal;
        off += step_;
        off2 += dot(step_, step_);
        sum.albedo += tap.surface.albedo;
        sum.emissive += tap.surface.emissive;
        sum.occlusion += tap.surface.occlusion;
        sum.metallic += tap.surface.metallic;
        alpha2 += alpha2_of(tap.surface);
        count += 1.0;
    }
    if (count == 1.0) {
        return;
    }
    centre.surface.albedo = sum.albedo / count;
    centre.surface.emissive = sum.emissive / count;
    centre.surface.occlusion = sum.occlusion / count;
    centre.surface.metallic = sum.metallic / count;
    off /= count;
    // Of unit normals: 1 less the squared length of their mean. The taps are spread evenly, so that for
    // normals that change evenly over the texel this is right as it is.
    float lost = max(off2 / count - dot(off, off), 0.0);
    float grown = min(alpha2_of_normals(lost), MOST_ALPHA2);
    centre.surface.roughness = widened(sqrt(sqrt(alpha2 / count)), grown);
    // Every tap's normal is within 90 degrees of the centre's: the mean is not near 0.
    centre.surface.normal = normalize(centre.surface.normal + off);
}
