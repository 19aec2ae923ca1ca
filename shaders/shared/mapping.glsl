// Every method's mapping between the display and the LP-buffer's columns. Needs `fovea` and the blocks
// LpTables (`lp_tables`) and, for the way from the display, ForwardTable (`forward_table`).
//
// Only the kind in use is compiled in. What a kind keeps in the tables:
//   kernel: a column's radii in px; after the columns the rows' directions
//   radial: sines and cosines of a column's eccentricities; forward: knots over the root of tan(e / 2)
//   axes:   a column's x and where its rows begin; after the columns the rows' y; forward: a column
//           coordinate for each display column, a row coordinate for each display row, for each layer
#ifndef MACULA_MAPPING_GLSL
#define MACULA_MAPPING_GLSL

layout(constant_id = 40) const uint MAPPING_KIND = 0u;

const uint MAPPING_KERNEL = 0u; // KFR
const uint MAPPING_RADIAL = 1u; // circles of equal eccentricity, each with its own height
const uint MAPPING_AXES = 2u;   // one or two layers of columns and rows of display pixels

const float OFF_THE_PLANE = 1e9;

// Height of a column, texels.
float column_height(uint u) {
    return lp_tables[2u * u + 1u].z;
}

// Where the rows begin in lp_tables.
uint first_row(uint u) {
    uint rows = 2u * fovea.size.z;
    return MAPPING_KIND == MAPPING_AXES ? rows + uint(lp_tables[2u * u].w) : rows;
}

// --- LP-buffer to display ------------------------------------------------------------------------

// Display position of a ray of the gaze's frame; far off the display where it does not meet the plane.
// `depth`: 1 over the length at which a ray of length 1 meets the plane at distance 1.
vec2 px_of_frame_ray(vec3 ray, out float depth) {
    depth = dot(fovea.px_rows[2].xyz, ray);
    vec2 across = vec2(dot(fovea.px_rows[0].xyz, ray), dot(fovea.px_rows[1].xyz, ray));
    vec2 px = (across / max(depth, 1e-12) + fovea.base_px.zw) + fovea.base_px.xy;
    return depth > 1e-9 ? px : vec2(OFF_THE_PLANE);
}

// At an offset from a texel's centre, -0.5 to 0.5: the parabola through both edges and the centre, which need
// not lie in the middle where the mapping bends.
vec2 within_texel(vec2 low, vec2 centre, vec2 high, vec2 offset) {
    vec2 bend = 2.0 * ((high - centre) - (centre - low));
    return centre + offset * ((high - low) + offset * bend);
}

// At an offset from a column's centre, -0.5 to 0.5: sine and cosine of the eccentricity, by the parabola
// through both edges and the centre.
vec2 circle_in_column(uint u, float offset) {
    vec4 inner_centre = lp_tables[2u * u];
    return within_texel(inner_centre.xy, inner_centre.zw, lp_tables[2u * u + 1u].xy, vec2(offset));
}

vec2 axes_texel_px(uvec2 texel) {
    return vec2(lp_tables[2u * texel.x].y, lp_tables[first_row(texel.x) + texel.y].y);
}

// Display position of a texel's centre, px.
vec2 texel_px(uvec2 texel) {
    if (MAPPING_KIND == MAPPING_KERNEL) {
        return lp_tables[first_row(0u) + texel.y].xy * lp_tables[2u * texel.x].y + fovea.gaze_px.xy;
    }
    if (MAPPING_KIND == MAPPING_AXES) {
        return axes_texel_px(texel);
    }
    vec2 around = fovea_direction((float(texel.y) + 0.5) / column_height(texel.x));
    vec2 circle = lp_tables[2u * texel.x].zw;
    float depth;
    return px_of_frame_ray(vec3(circle.x * around, circle.y), depth);
}

// What the samples within one texel have in common.
struct TexelPlace {
    uvec2 texel;
    vec4 radii_px;  // by kernels: of the column; by axes: left and right edge, upper and lower edge
    vec2 around;    // direction of the texel's centre from the gaze; by axes: the centre, px
    float height;   // of the column
    float width_px; // the texel's greater extent, in pixels of the display's centre
};

TexelPlace texel_place(uvec2 texel) {
    TexelPlace place;
    place.texel = texel;
    place.height = column_height(texel.x);
    if (MAPPING_KIND == MAPPING_KERNEL) {
        place.radii_px = lp_tables[2u * texel.x];
        place.around = lp_tables[first_row(0u) + texel.y].xy;
        float along_px = place.radii_px.y * (6.2831853 / place.height);
        place.width_px = max(place.radii_px.z - place.radii_px.x, along_px);
    } else if (MAPPING_KIND == MAPPING_AXES) {
        vec4 column = lp_tables[2u * texel.x];
        vec4 row = lp_tables[first_row(texel.x) + texel.y];
        place.radii_px = vec4(column.x, column.z, row.x, row.z);
        place.around = vec2(column.y, row.y);
        place.width_px = max(column.z - column.x, row.z - row.x);
    } else {
        place.around = fovea_direction((float(texel.y) + 0.5) / place.height);
        vec4 inner_centre = lp_tables[2u * texel.x];
        float outward = distance(lp_tables[2u * texel.x + 1u].xy, inner_centre.xy);
        float along = 6.2831853 * inner_centre.z / place.height;
        place.width_px = max(outward, along) * fovea.table.z;
    }
    return place;
}

// Display position of a sample within a texel. `offset`: xy from the texel's centre along u and v, -0.5 to
// 0.5; zw the turn by y in a column as high as the LP-buffer.
vec2 place_px(TexelPlace place, vec4 offset) {
    if (MAPPING_KIND == MAPPING_AXES) {
        return within_texel(place.radii_px.xz, place.around, place.radii_px.yw, offset.xy);
    }
    vec2 turn = offset.zw;
    if (MAPPING_KIND == MAPPING_RADIAL) {
        // At most an eighth of a turn; columns of fewer than four texels lie inside the native disc.
        float angle = min(6.2831853 / place.height, 1.5) * offset.y;
        turn = vec2(fovea_cos_small(angle), fovea_sin_small(angle));
    }
    vec2 around = vec2(
        place.around.x * turn.x - place.around.y * turn.y, place.around.x * turn.y + place.around.y * turn.x);
    if (MAPPING_KIND == MAPPING_KERNEL) {
        vec4 radii = place.radii_px;
        return around * within_texel(radii.xx, radii.yy, radii.zz, offset.xx).x + fovea.gaze_px.xy;
    }
    vec2 circle = circle_in_column(place.texel.x, offset.x);
    float depth;
    return px_of_frame_ray(vec3(circle.x * around, circle.y), depth);
}

// A texel's bounds on the display.
struct TexelReach {
    vec2 px;        // centre
    bool seen;      // a pixel of the display may interpolate with the texel
    float reach_px; // those pixels lie within this distance of the centre, or at the horizon a little farther
    float into;     // how far past the native region the outermost of those pixels is; below 0: all are native
};

// Distance of a point to the display, px; 0 inside.
float outside_px(vec2 px) {
    vec2 size = fovea.size_f.zw;
    return length(max(max(-px, px - size), vec2(0.0)));
}

TexelReach radial_reach(uvec2 texel) {
    TexelReach result;
    float height = column_height(texel.x);
    vec2 around = fovea_direction((float(texel.y) + 0.5) / height);
    vec4 inner_centre = lp_tables[2u * texel.x];
    vec4 outer_rest = lp_tables[2u * texel.x + 1u];
    vec3 ray = vec3(inner_centre.z * around, inner_centre.w);
    float depth;
    result.px = px_of_frame_ray(ray, depth);
    // A pixel that reads the texel lies less than one texel outwards and one along the circle away. As an
    // angle, because on the display's plane a texel near the horizon has no end.
    float outward = 2.0 * distance(outer_rest.xy, inner_centre.zw);
    float along = 6.2831853 * max(outer_rest.x, inner_centre.z) / height;
    float reach = 1.01 * length(vec2(outward, along)) + 1e-6;
    vec4 inside = vec4(
        dot(fovea.edges[0].xyz, ray), dot(fovea.edges[1].xyz, ray),
        dot(fovea.edges[2].xyz, ray), dot(fovea.edges[3].xyz, ray));
    result.seen = all(greaterThanEqual(inside, vec4(-reach)));
    float ray_length = 1.0 / max(depth, 1e-9);
    // Density and acuity change by less than this over the reach.
    float over_acuity = 1.05 * ray_length * ray_length * ray_length / outer_rest.w;
    result.reach_px = reach * ray_length * ray_length * fovea.table.z + 1.0;
    float past_disc_px = distance(result.px, fovea.gaze_px.xy) + result.reach_px - (fovea.ring.x - fovea.ring.y);
    result.into = min(over_acuity - 1.0, past_disc_px);
    return result;
}

TexelReach kernel_reach(uvec2 texel) {
    TexelReach result;
    vec4 radii_px = lp_tables[2u * texel.x];
    result.px = texel_px(texel);
    // A pixel reads the four texels around it: those whose centres are less than a texel away.
    float along_px = radii_px.w * (6.2831853 / fovea.size_f.y);
    result.reach_px = length(vec2(radii_px.w - radii_px.y, along_px)) + 1.0;
    result.seen = outside_px(result.px) <= result.reach_px;
    result.into = radii_px.w + 1.0 - (fovea.ring.x - fovea.ring.y);
    return result;
}

// How far a point lies outside a rectangle (x0, y0, x1, y1), px; negative inside.
float outside_rect_px(vec4 rect, vec2 px) {
    vec2 beyond = max(rect.xy - px, px - rect.zw);
    return max(beyond.x, beyond.y);
}

TexelReach axes_reach(uvec2 texel) {
    TexelReach result;
    vec4 column = lp_tables[2u * texel.x];
    vec4 row = lp_tables[first_row(texel.x) + texel.y];
    result.px = vec2(column.y, row.y);
    result.reach_px = length(vec2(column.z - column.x, row.z - row.x)) + 1.0;
    result.seen = outside_px(result.px) <= result.reach_px;
    bool inner = float(texel.x) < fovea.axes.z;
    vec4 finer = inner ? fovea.native_rect : fovea.layer_rect;
    result.into = outside_rect_px(finer, result.px) + result.reach_px + (inner ? fovea.axes.x : fovea.axes.y);
    return result;
}

TexelReach texel_reach(uvec2 texel) {
    if (MAPPING_KIND == MAPPING_KERNEL) {
        return kernel_reach(texel);
    }
    return MAPPING_KIND == MAPPING_AXES ? axes_reach(texel) : radial_reach(texel);
}

// --- Display to LP-buffer ------------------------------------------------------------------------

struct LpLookup {
    float u;       // texels
    float v_share; // of the column's height
    vec2 columns;  // first and last column that may be read
};

#ifdef MAPPING_FORWARD

#ifndef MAPPING_OF_NATIVE
#define MAPPING_OF_NATIVE false
#endif

// The ray through a display position in the gaze's frame.
vec3 frame_ray(vec2 px) {
    precise vec2 offset = (px - fovea.base_px.xy) - fovea.base_px.zw;
    vec3 at = vec3(offset, 1.0);
    return vec3(dot(fovea.ray_rows[0].xyz, at), dot(fovea.ray_rows[1].xyz, at), dot(fovea.ray_rows[2].xyz, at));
}

// Knot values at a ray: column coordinate and the acuity's density.
vec2 forward_knot(vec3 ray, float ray_length) {
    float across = length(ray.xy);
    // tan(e / 2), in the form that does not cancel.
    float half_tangent = ray.z >= 0.0 ? across / (ray_length + ray.z) : (ray_length - ray.z) / max(across, 1e-30);
    float at = min(sqrt(half_tangent) * fovea.table.x, fovea.table.y);
    if (fovea.axes.x > 0.0) {
        // Dense at the end: share (2 - share) of the reach, solved for the share.
        at = fovea.table.y * (1.0 - sqrt(1.0 - at / fovea.table.y));
    }
    float knot = min(floor(at), fovea.table.y - 1.0);
    return mix(forward_table[uint(knot)], forward_table[uint(knot) + 1u], at - knot);
}

LpLookup axes_lookup(vec2 px, bool inner) {
    uvec2 at = min(uvec2(max(px, vec2(0.0))), fovea.size.xy - 1u);
    uint first = inner ? 0u : uint(fovea.axes.w);
    LpLookup lookup;
    lookup.u = forward_table[first + at.x].x;
    lookup.v_share = forward_table[first + fovea.size.x + at.y].x;
    lookup.columns = inner ? vec2(0.0, fovea.axes.z - 1.0) : vec2(fovea.axes.z, fovea.size_f.x - 1.0);
    return lookup;
}

// How far a pixel is past the native region: 0 or less inside, where it is shaded itself; 1 or more
// where the picture comes from the LP-buffer alone. `lookup` is where it lies there.
float mapping_forward(vec2 px, out LpLookup lookup) {
    lookup.columns = vec2(0.0, fovea.size_f.x - 1.0);
    if (MAPPING_KIND == MAPPING_AXES) {
        bool inner = outside_rect_px(fovea.layer_rect, px) < 0.0;
        lookup = axes_lookup(px, inner);
        return outside_rect_px(fovea.native_rect, px) / fovea.axes.x + 1.0;
    }
    float past_disc = (distance(px, fovea.gaze_px.xy) - (fovea.ring.x - fovea.ring.y)) / fovea.ring.y;
    if (MAPPING_KIND == MAPPING_KERNEL) {
        // Native pixels need no place in the LP-buffer.
        vec2 texels = past_disc > 0.0 || MAPPING_OF_NATIVE ? fovea_forward_texels(fovea, px) : vec2(0.0);
        lookup.u = texels.x;
        lookup.v_share = texels.y / fovea.size_f.y;
        return past_disc;
    }
    vec3 ray = frame_ray(px);
    float ray_length = length(ray);
    vec2 knot = forward_knot(ray, ray_length);
    lookup.u = knot.x;
    lookup.v_share = fovea_turns(ray.xy);
    float over_acuity = ray_length * ray_length * ray_length / knot.y;
    return min(past_disc, (over_acuity - 1.0) * fovea.table.w);
}

// Display area of the LP texel at a lookup's place, px^2: 1 over the mapping's Jacobian determinant.
float texel_area_px2(vec2 px, LpLookup lookup) {
    uint u = uint(clamp(lookup.u, lookup.columns.x, lookup.columns.y));
    vec4 column = lp_tables[2u * u];
    float height = column_height(u);
    if (MAPPING_KIND == MAPPING_KERNEL) {
        return (column.z - column.x) * column.y * (6.2831853 / height);
    }
    if (MAPPING_KIND == MAPPING_AXES) {
        vec4 row = lp_tables[first_row(u) + uint(clamp(lookup.v_share * height, 0.0, height - 1.0))];
        return (column.z - column.x) * (row.z - row.x);
    }
    float outward = distance(lp_tables[2u * u + 1u].xy, column.xy);
    float along = 6.2831853 * column.z / height;
    // The plane's area grows over the solid angle by the cube of the ray's length.
    vec3 ray = frame_ray(px);
    float ray_length2 = dot(ray, ray);
    return outward * along * ray_length2 * sqrt(ray_length2) * (fovea.table.z * fovea.table.z);
}

// Mip levels by which a sample at a display position is coarser than a pixel: log2 of the side of a square
// of the texel's area. 0 where pixels are shaded themselves; rises to the texel's over the blend band.
float footprint_levels(vec2 px) {
    LpLookup lookup;
    float past_native = mapping_forward(px, lookup);
    if (past_native <= 0.0) {
        return 0.0;
    }
    float levels = 0.5 * log2(max(texel_area_px2(px, lookup), 1.0));
    return levels * min(past_native, 1.0);
}

#endif
#endif
