// Fast approximate anti-aliasing (T. Lottes, 2009) on the texels of the LP-buffer.
//
// Where a texel differs from those beside it, the edge's direction is found, then how far the edge goes on
// both ways. A texel near an end of the edge is a stair's step: it is blended with the texel across the
// edge, by as much as the straight edge would cover. What stands out alone is blended by how much it does.
#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "shared/frame.glsl"
#include "shared/lp_neighbours.glsl"
layout(set = 0, binding = 6) uniform Frame { FrameParams frame; };

// Least contrast of an edge, as a share of the brightest neighbour's luma. Lottes proposes 1/8 as high
// quality; less finds fainter edges and costs time.
const float EDGE_SHARE = 0.125;
// Least contrast of an edge in the dark, where the share says little (Lottes: 1/24 shows only in motion).
const float EDGE_LEAST = 1.0 / 24.0;
// Most that a texel which stands out is blended. 0 keeps single texels, 1 removes them. Lottes proposes 3/4
// for pixels; here the inverse pass blurs once more, and beyond 20 degrees 3/4 ends 0.2 to
// 0.5 dB farther from a supersampled picture than 1/4, as small things there are a texel wide.
const float MOST_ALONE = 0.25;
// Texels that an edge is followed each way. A longer edge is nearly straight along the buffer; each step
// costs two luma values.
const int SEARCH_TEXELS = 4;

// FXAA's thresholds are shares of what is seen, but the buffer holds radiance without an upper end: in it
// every edge beside a lamp would count and none in a shadow. So luma is what a display would about show:
// exposed, compressed to below 1 by x / (1 + x), and encoded with gamma 2. It only finds edges and needs
// not be the tone curve of the output; colours are blended as radiance, like in the inverse pass.
float luma(vec3 radiance) {
    float exposed = dot(radiance, vec3(0.2126, 0.7152, 0.0722)) * frame.exposure;
    return sqrt(exposed / (1.0 + exposed));
}

float luma_at(Centre centre, ivec2 offset) {
    return luma(neighbour(centre, offset.x, offset.y));
}

// The lumas around the centre: x across columns, y along them, both -1 to 1.
struct Lumas {
    float centre, inner, outer, before, after;
    float inner_before, inner_after, outer_before, outer_after;
};

// 0 to 1: how far the texel stands out from the mean of its neighbours, as a share of the contrast.
float stands_out(Lumas l, float contrast) {
    float sides = l.inner + l.outer + l.before + l.after;
    float corners = l.inner_before + l.inner_after + l.outer_before + l.outer_after;
    float mean = (2.0 * sides + corners) / 12.0;
    float eased = smoothstep(0.0, 1.0, abs(mean - l.centre) / contrast);
    return eased * eased * MOST_ALONE;
}

// The edge between the centre and one of its sides.
struct Edge {
    ivec2 normal;  // to the side
    ivec2 tangent;
    float mean;    // luma on the edge
    float ends;    // the edge ends where its luma differs from the mean by this
};

Edge edge_of(Lumas l) {
    float change_across = 2.0 * abs(l.inner + l.outer - 2.0 * l.centre)
        + abs(l.inner_before + l.outer_before - 2.0 * l.before)
        + abs(l.inner_after + l.outer_after - 2.0 * l.after);
    float change_along = 2.0 * abs(l.before + l.after - 2.0 * l.centre)
        + abs(l.inner_before + l.inner_after - 2.0 * l.inner)
        + abs(l.outer_before + l.outer_after - 2.0 * l.outer);
    bool along_columns = change_across > change_along;
    vec2 sides = along_columns ? vec2(l.inner, l.outer) : vec2(l.before, l.after);
    vec2 steps = abs(sides - l.centre);
    bool second = steps.y > steps.x;
    int sign_of_normal = second ? 1 : -1;
    Edge edge;
    edge.normal = along_columns ? ivec2(sign_of_normal, 0) : ivec2(0, sign_of_normal);
    edge.tangent = along_columns ? ivec2(0, 1) : ivec2(1, 0);
    edge.mean = 0.5 * (l.centre + (second ? sides.y : sides.x));
    edge.ends = 0.25 * max(steps.x, steps.y);
    return edge;
}

// How much of the side's colour a texel on a stair's step takes, 0 to 0.5.
float step_share(Centre centre, Edge edge, float own) {
    vec2 ends = vec2(float(SEARCH_TEXELS));
    vec2 differences = vec2(0.0);
    for (int way = 0; way < 2; ++way) {
        for (int i = 1; i <= SEARCH_TEXELS; ++i) {
            ivec2 at = (way == 0 ? -i : i) * edge.tangent;
            float on_edge = 0.5 * (luma_at(centre, at) + luma_at(centre, at + edge.normal));
            differences[way] = on_edge - edge.mean;
            if (abs(differences[way]) >= edge.ends) {
                ends[way] = float(i);
                break;
            }
        }
    }
    int nearer = ends.y < ends.x ? 1 : 0;
    // At the nearer end the edge must turn away from this texel: else the step belongs to the other side.
    bool turns = (differences[nearer] < 0.0) != (own < edge.mean);
    return turns ? 0.5 - min(ends.x, ends.y) / (ends.x + ends.y) : 0.0;
}

void main() {
    Centre centre;
    if (!find_centre(centre)) {
        return;
    }
    Lumas l;
    l.centre = luma(centre.color);
    l.inner = luma_at(centre, ivec2(-1, 0));
    l.outer = luma_at(centre, ivec2(1, 0));
    l.before = luma_at(centre, ivec2(0, -1));
    l.after = luma_at(centre, ivec2(0, 1));
    float most = max(l.centre, max(max(l.inner, l.outer), max(l.before, l.after)));
    float least = min(l.centre, min(min(l.inner, l.outer), min(l.before, l.after)));
    if (most - least < max(EDGE_LEAST, EDGE_SHARE * most)) {
        store(centre, centre.color);
        return;
    }
    l.inner_before = luma_at(centre, ivec2(-1, -1));
    l.inner_after = luma_at(centre, ivec2(-1, 1));
    l.outer_before = luma_at(centre, ivec2(1, -1));
    l.outer_after = luma_at(centre, ivec2(1, 1));
    Edge edge = edge_of(l);
    float share = max(step_share(centre, edge, l.centre), stands_out(l, most - least));
    vec3 side = neighbour(centre, edge.normal.x, edge.normal.y);
    store(centre, centre.color + share * (side - centre.color));
}
