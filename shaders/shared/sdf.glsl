// The ray-marched scene: twenty kinds of solids, each given by its signed distance, on a chequered
// floor under a sky. Declares no bindings; the only entry is `sdf_radiance`.
//
// Speed comes from the grid: every solid stands in the middle of a cell of its own and inside a box
// of known size, so a ray visits cells in order, skips those whose box it misses, and evaluates one
// solid per step.
//
// A good place to look from (engine/src/scene/sdf.rs has the same):
//   const vec3 SDF_EYE     = vec3(-2.2, 3.4, 8.4);
//   const vec3 SDF_LOOK_AT = vec3(-0.1, 0.4, 0.2);

#ifndef SDF_GLSL
#define SDF_GLSL

const int SDF_COLUMNS = 5;
const int SDF_ROWS = 4;
// Side of a cell, metres.
const float SDF_CELL = 2.2;
// Half the box round a solid, and the height of its middle; solids stay 0.03 inside, so that soft
// shadows see a little of the room round them.
const vec3 SDF_BOX = vec3(0.82, 0.8, 0.82);
// Steps of one ray through all cells; turned down, silhouettes of far solids fray.
const int SDF_STEPS = 72;
// How much sharper than its distance a shadow's edge is: a sun of about 1/14 radian.
const float SDF_SUN_SHARPNESS = 14.0;
// A shadow ray that passes a solid by less than half this angle is as good as blocked: a 1/64 of the
// sun is left, of which the smooth edge makes less than 1/1000. Turned down, rays creep along solids.
const float SDF_DARK_RAD = 2.0 / (64.0 * SDF_SUN_SHARPNESS);
const vec3 SDF_SUN_DIRECTION = vec3(-0.7194, 0.5995, 0.3507);
const vec3 SDF_SUN_RADIANCE = vec3(2.5, 2.15, 1.7);
// Beyond this the floor is the horizon's colour anyway, metres.
const float SDF_FAR = 400.0;
const float SDF_INFINITE = 1e30;
// The kinds whose distance is a convex function, a bit for each: all but frame, tori, link, ellipsoid,
// solid angle and dented sphere.
const uint SDF_CONVEX = 0xa7f87u;
// How far each kind's middle lies below its box's, so that all solids stand on the floor.
const float SDF_SINK[20] = float[20](0.1, 0.2, 0.15, 0.14, 0.06, 0.36, 0.04, 0.1, 0.1, 0.32,
                                     0.04, 0.18, 0.44, 0.02, 0.1, 0.38, 0.8, 0.06, 0.08, 0.03);

// From a profile's signed distance and the distance to a slab's faces, that of the extruded solid.
float sdf_extruded(float profile, float slab)
{
    vec2 outside = max(vec2(profile, slab), 0.0);
    return min(max(profile, slab), 0.0) + length(outside);
}

float sdf_box(vec3 p, vec3 extent)
{
    vec3 over = abs(p) - extent;
    return length(max(over, 0.0)) + min(max(over.x, max(over.y, over.z)), 0.0);
}

// Twelve square bars along a cube's edges. By symmetry only the bar along the axis that the point is
// nearest to in its middle can be the closest one: the axis of the smallest coordinate.
float sdf_box_frame(vec3 p, float extent, float bar)
{
    vec3 a = abs(p);
    float least = min(a.x, min(a.y, a.z));
    float greatest = max(a.x, max(a.y, a.z));
    float middle = a.x + a.y + a.z - least - greatest;
    vec3 from_bar = vec3(least, middle - (extent - bar), greatest - (extent - bar));
    return sdf_box(from_bar, vec3(extent, bar, bar));
}

float sdf_ring(vec2 plane, float across, float radius)
{
    return length(vec2(length(plane) - radius, across));
}

// A ring of which only the part within `half_angle` of +Y is left; round ends.
float sdf_arc(vec3 p, float radius, vec2 sin_cos_half)
{
    p.x = abs(p.x);
    bool within = p.x * sin_cos_half.y < p.y * sin_cos_half.x;
    vec2 end = p.xy - radius * sin_cos_half;
    return within ? sdf_ring(p.xy, p.z, radius) : length(vec3(end, p.z));
}

// A cone's frustum: `at` is (distance to the axis, height above the middle).
float sdf_frustum(vec2 at, float bottom, float top, float half_height)
{
    vec2 slant = vec2(top - bottom, 2.0 * half_height);
    vec2 from_rim = at - vec2(bottom, -half_height);
    float share = clamp(dot(from_rim, slant) / dot(slant, slant), 0.0, 1.0);
    float to_slant = length(from_rim - slant * share);
    float rim = at.y < 0.0 ? bottom : top;
    float above = abs(at.y) - half_height;
    float to_lid = length(vec2(max(at.x - rim, 0.0), above));
    bool inside = above < 0.0 && from_rim.x * slant.y < from_rim.y * slant.x;
    float nearest = min(to_slant, to_lid);
    return inside ? -nearest : nearest;
}

// The hull of two spheres on the axis: below and above the slanted part the spheres are nearest.
float sdf_round_cone(vec2 at, float low_radius, float high_radius, float apart)
{
    float lean = (low_radius - high_radius) / apart;
    float rise = sqrt(1.0 - lean * lean);
    float along = dot(at, vec2(-lean, rise));
    if (along < 0.0) {
        return length(at) - low_radius;
    }
    if (along > rise * apart) {
        return length(at - vec2(0.0, apart)) - high_radius;
    }
    return dot(at, vec2(rise, lean)) - low_radius;
}

// Regular hexagon: two mirrorings bring every side onto the one at y = inner radius.
float sdf_hexagon(vec2 p, float inner)
{
    const vec2 mirror = vec2(-0.8660254, 0.5);
    p = abs(p);
    p -= 2.0 * min(dot(mirror, p), 0.0) * mirror;
    float half_side = inner * 0.57735027;
    vec2 from_side = p - vec2(clamp(p.x, -half_side, half_side), inner);
    return from_side.y < 0.0 ? -length(from_side) : length(from_side);
}

// A ball's part within a cone round +Y, its tip at the origin.
float sdf_sector(vec2 at, float radius, vec2 sin_cos_half)
{
    vec2 to_edge = at - sin_cos_half * clamp(dot(at, sin_cos_half), 0.0, radius);
    float beside = at.x * sin_cos_half.y > at.y * sin_cos_half.x ? length(to_edge) : -length(to_edge);
    return max(length(at) - radius, beside);
}

// Signed distance, or less than it, to the solid of one kind; p is relative to the box's middle.
// The order is that of PRIMITIVE_KINDS in engine/src/scene/sdf.rs.
float sdf_solid(int kind, vec3 p)
{
    p.y += SDF_SINK[kind];
    float off_axis = length(p.xz);
    switch (kind) {
    case 0: // sphere
        return length(p) - 0.7;
    case 1: // box
        return sdf_box(p, vec3(0.6));
    case 2: // round box
        return sdf_box(p, vec3(0.45)) - 0.2;
    case 3: // box frame
        return sdf_box_frame(p, 0.64, 0.07) - 0.012;
    case 4: // torus
        return sdf_ring(p.xy, p.z, 0.54) - 0.2;
    case 5: // capped torus
        return sdf_arc(p, 0.56, vec2(0.8660254, -0.5)) - 0.16;
    case 6: // link
        return sdf_ring(vec2(p.x, max(abs(p.y) - 0.3, 0.0)), p.z, 0.32) - 0.14;
    case 7: // cylinder
        return sdf_extruded(off_axis - 0.5, abs(p.y) - 0.7);
    case 8: // capped cone
        return sdf_frustum(vec2(off_axis, p.y), 0.68, 0.24, 0.7);
    case 9: // round cone
        return sdf_round_cone(vec2(off_axis, p.y), 0.48, 0.22, 0.8);
    case 10: // capsule
        return length(vec3(p.x, p.y - clamp(p.y, -0.4, 0.4), p.z)) - 0.36;
    case 11: // hexagonal prism
        return sdf_extruded(sdf_hexagon(p.xz, 0.58), abs(p.y) - 0.62);
    case 12: // triangular prism
        return max(max(abs(p.x) * 0.8660254 + p.y * 0.5, -p.y) - 0.36, abs(p.z) - 0.5);
    case 13: // octahedron
        return (abs(p.x) + abs(p.y) + abs(p.z) - 0.78) * 0.57735027;
    case 14: // pyramid: its sides rise 1.4 over a half base of 0.7
        return max(max(abs(p.x), abs(p.z)) * 0.8944272 + (p.y - 0.7) * 0.4472136, -p.y - 0.7);
    case 15: { // ellipsoid: the implicit function over its own slope, the slope kept above zero
        vec3 scaled = p / vec3(0.74, 0.42, 0.55);
        float slope = length(scaled / vec3(0.74, 0.42, 0.55));
        float level = length(scaled);
        // Far off the quotient is too great by as much as the axes differ.
        return 0.85 * level * (level - 1.0) / max(slope, 1e-4);
    }
    case 16: // solid angle
        return sdf_sector(vec2(off_axis, p.y), 1.3, vec2(0.5, 0.8660254));
    case 17: // cut sphere
        return max(length(p) - 0.74, dot(p, vec3(0.4, 0.7, 0.5915)) - 0.22);
    case 18: // sphere with a dent
        return max(length(p) - 0.72, 0.5 - length(p - vec3(0.38, 0.42, 0.42)));
    default: // rhombic prism
        return sdf_extruded((abs(p.x) / 0.68 + abs(p.y) / 0.74 - 1.0) * 0.5007, abs(p.z) - 0.3) - 0.03;
    }
}

vec3 sdf_centre(ivec2 cell)
{
    vec2 middle = (vec2(cell) - 0.5 * vec2(SDF_COLUMNS - 1, SDF_ROWS - 1)) * SDF_CELL;
    return vec3(middle.x, SDF_BOX.y, middle.y);
}

int sdf_kind(ivec2 cell)
{
    return cell.y * SDF_COLUMNS + cell.x;
}

bool sdf_in_grid(ivec2 cell)
{
    return all(greaterThanEqual(cell, ivec2(0))) && all(lessThan(cell, ivec2(SDF_COLUMNS, SDF_ROWS)));
}

ivec2 sdf_cell(vec2 at)
{
    vec2 cell = floor(at / SDF_CELL + 0.5 * vec2(SDF_COLUMNS, SDF_ROWS));
    return clamp(ivec2(clamp(cell, vec2(-1.0), vec2(16.0))), ivec2(0), ivec2(SDF_COLUMNS - 1, SDF_ROWS - 1));
}

// Follows a ray through the grid up to `end`. Returns the distance of the first solid, its cell in
// `hit`, or SDF_INFINITE. `clearance` is the least share of the sun that passes what the ray passes by;
// where it is not asked for (`leaps`), rays take larger steps towards convex solids, and none past them.
float sdf_trace(vec3 origin, vec3 direction, float end, float pixel_angle_rad, bool leaps, out ivec2 hit,
                out float clearance)
{
    hit = ivec2(0);
    clearance = 1.0;
    // A direction along an axis would divide by zero: 1e-7 of slope is far below a pixel.
    vec3 slope = vec3(direction.x < 0.0 ? min(direction.x, -1e-7) : max(direction.x, 1e-7),
                      direction.y < 0.0 ? min(direction.y, -1e-7) : max(direction.y, 1e-7),
                      direction.z < 0.0 ? min(direction.z, -1e-7) : max(direction.z, 1e-7));
    vec3 inverse = 1.0 / slope;
    vec3 grid_half = vec3(0.5 * SDF_CELL * float(SDF_COLUMNS), SDF_BOX.y, 0.5 * SDF_CELL * float(SDF_ROWS));
    vec3 middle = (vec3(0.0, SDF_BOX.y, 0.0) - origin) * inverse;
    vec3 reach = grid_half * abs(inverse);
    vec3 enter = middle - reach;
    vec3 leave = middle + reach;
    float t = max(max(enter.x, max(enter.y, enter.z)), 0.0);
    end = min(end, min(leave.x, min(leave.y, leave.z)));
    if (t >= end) {
        return SDF_INFINITE;
    }
    ivec2 cell = sdf_cell(origin.xz + direction.xz * t);
    ivec2 turn = ivec2(direction.x < 0.0 ? -1 : 1, direction.z < 0.0 ? -1 : 1);
    vec3 box_reach = SDF_BOX * abs(inverse);
    ivec2 current = cell;
    float box_end = -1.0;
    float last_t = 0.0;
    float last_free = -1.0; // none yet in this box
    bool going = true;
    for (int count = 0; count < SDF_STEPS && going; ++count) {
        // To the next box on the way; at most as many cells as a line can cross.
        for (int visit = 0; visit < SDF_COLUMNS + SDF_ROWS && going && t >= box_end; ++visit) {
            if (!sdf_in_grid(cell)) {
                going = false;
                break;
            }
            vec3 towards = (sdf_centre(cell) - origin) * inverse;
            vec3 near = towards - box_reach;
            vec3 far = towards + box_reach;
            float box_start = max(max(near.x, max(near.y, near.z)), t);
            float box_leave = min(min(far.x, min(far.y, far.z)), end);
            vec2 border = towards.xz + 0.5 * SDF_CELL * abs(inverse.xz);
            current = cell;
            cell += border.x < border.y ? ivec2(turn.x, 0) : ivec2(0, turn.y);
            if (box_start < box_leave) {
                t = box_start;
                box_end = box_leave;
                last_free = -1.0;
                break;
            }
            going = min(border.x, border.y) < end;
        }
        if (!going || t >= box_end) {
            break;
        }
        int kind = sdf_kind(current);
        float free = sdf_solid(kind, origin + direction * t - sdf_centre(current));
        // Half a pixel's width at this distance; never below what single precision resolves.
        if (free < max(0.5 * t * pixel_angle_rad, 2e-4)) {
            hit = current;
            clearance = 0.0;
            return t;
        }
        clearance = min(clearance, SDF_SUN_SHARPNESS * free / max(t, 1e-3));
        float advance = max(free, 1e-3);
        if (leaps && last_free >= 0.0 && (SDF_CONVEX >> kind & 1u) != 0u) {
            // Along a line the distance to a convex solid is a convex function: it lies above the line
            // through two of its values, beyond them. So where that line falls the solid is not before
            // its zero, and where it rises there is no more solid.
            float fall = (last_free - free) / (t - last_t);
            advance = fall > 1e-3 ? max(advance, free / fall) : SDF_INFINITE;
        }
        last_t = t;
        last_free = free;
        // Not into the next box: its solid has not been asked yet.
        t = min(t + advance, box_end);
    }
    return SDF_INFINITE;
}

vec3 sdf_sky(vec3 direction)
{
    float up = clamp(direction.y, 0.0, 1.0);
    vec3 sky = mix(vec3(0.5, 0.6, 0.74), vec3(0.09, 0.2, 0.46), sqrt(up));
    float towards = clamp(dot(direction, SDF_SUN_DIRECTION), 0.0, 1.0);
    float glow = towards * towards;
    glow *= glow;
    glow *= glow;
    float disc = smoothstep(0.9990, 0.9994, towards);
    return sky + vec3(0.5, 0.36, 0.2) * glow * glow + SDF_SUN_RADIANCE * (4.0 * disc);
}

// Mean of the square wave of period 2, values -1 and 1, over `width` round x: differences of its
// integral, a triangle wave.
vec2 sdf_square_wave(vec2 x, vec2 width)
{
    vec2 ahead = abs(fract((x + 0.5 * width) * 0.5) * 2.0 - 1.0);
    vec2 behind = abs(fract((x - 0.5 * width) * 0.5) * 2.0 - 1.0);
    return (ahead - behind) / width;
}

vec3 sdf_floor_color(vec2 at, vec3 direction, float t, float pixel_angle_rad)
{
    // A pixel's cone on the floor: its width, and along the view longer by the grazing angle.
    float width = t * pixel_angle_rad;
    vec2 footprint = width * (1.0 + abs(direction.xz) / max(abs(direction.y), 1e-4));
    vec2 waves = sdf_square_wave(at / 1.1, clamp(footprint / 1.1, vec2(1e-3), vec2(1e3)));
    return mix(vec3(0.055, 0.06, 0.075), vec3(0.36, 0.345, 0.32), 0.5 + 0.5 * waves.x * waves.y);
}

// Slope of the distance from four points of a tetrahedron, in a loop so that the solids' code is
// there once.
vec3 sdf_normal(int kind, vec3 p, float reach)
{
    vec3 sum = vec3(0.0);
    for (int corner = 0; corner < 4; ++corner) {
        vec3 to = vec3((corner & 1) == 0 ? -1.0 : 1.0, (corner & 2) == 0 ? -1.0 : 1.0, 1.0);
        to.z = to.x * to.y;
        sum += to * sdf_solid(kind, p + to * reach);
    }
    float size = length(sum);
    return size > 1e-12 ? sum / size : vec3(0.0, 1.0, 0.0);
}

// Openness from five taps along the normal: how much less room there is than in the open. The last
// tap stays nearer than the next cell's solid can be, so that cells show no seams.
float sdf_openness(vec3 position, vec3 normal)
{
    ivec2 cell = sdf_cell(position.xz);
    vec3 local = position - sdf_centre(cell);
    float missing = 0.0;
    float weight = 1.0;
    for (int tap = 1; tap <= 5; ++tap) {
        float out_by = 0.06 * float(tap);
        vec3 at = local + normal * out_by;
        float room = min(sdf_solid(sdf_kind(cell), at), at.y + SDF_BOX.y);
        missing += weight * max(out_by - room, 0.0);
        weight *= 0.75;
    }
    return clamp(1.0 - 1.9 * missing, 0.0, 1.0);
}

// Sun and sky on a surface: Lambert and a GGX lobe.
vec3 sdf_shade(vec3 normal, vec3 to_eye, vec3 color, float metallic, float roughness, float sun, float open)
{
    vec3 middle = SDF_SUN_DIRECTION + to_eye;
    float middle_length = length(middle);
    middle = middle_length > 1e-5 ? middle / middle_length : normal;
    float n_sun = clamp(dot(normal, SDF_SUN_DIRECTION), 0.0, 1.0);
    float n_eye = clamp(dot(normal, to_eye), 1e-3, 1.0);
    float n_middle = clamp(dot(normal, middle), 0.0, 1.0);
    float alpha = roughness * roughness;
    float alpha2 = alpha * alpha;
    float spread = n_middle * n_middle * (alpha2 - 1.0) + 1.0;
    float lobe = alpha2 / (3.14159265 * spread * spread);
    float k = 0.5 * alpha;
    float hidden = 0.25 / ((n_sun * (1.0 - k) + k) * (n_eye * (1.0 - k) + k));
    vec3 facing = mix(vec3(0.04), color, metallic);
    float away = 1.0 - clamp(dot(middle, to_eye), 0.0, 1.0);
    float away2 = away * away;
    vec3 fresnel = facing + (1.0 - facing) * (away2 * away2 * away);
    vec3 diffuse = color * (1.0 - metallic);
    // Lambert's 1/pi is part of the sun's radiance; the lobe is held below what half floats bear.
    float gloss = min(lobe * hidden * 3.14159265, 24.0);
    vec3 direct = SDF_SUN_RADIANCE * (n_sun * sun) * (diffuse * (1.0 - fresnel) + fresnel * gloss);
    float grazing = 1.0 - n_eye;
    float grazing2 = grazing * grazing;
    vec3 mirror = facing + (max(vec3(1.0 - roughness), facing) - facing) * (grazing2 * grazing2 * grazing);
    vec3 mirrored = reflect(-to_eye, normal);
    // What a mirror sees below the horizon is the sunlit floor, blurred by the roughness.
    vec3 above = mix(vec3(0.5, 0.6, 0.74), vec3(0.09, 0.2, 0.46), sqrt(clamp(mirrored.y, 0.0, 1.0)));
    float blur = 0.05 + 0.4 * roughness;
    vec3 seen = mix(vec3(0.2, 0.195, 0.19), above, smoothstep(-blur, blur, mirrored.y));
    vec3 ambient = mix(vec3(0.1, 0.095, 0.09), vec3(0.24, 0.3, 0.4), 0.5 + 0.5 * normal.y);
    return direct + open * (diffuse * ambient + mirror * seen);
}

// Linear radiance along a ray; finite and not negative. `direction` is a unit vector, and
// `pixel_angle_rad` the angle that a pixel covers (above 0).
vec3 sdf_radiance(vec3 origin, vec3 direction, float pixel_angle_rad)
{
    float to_floor = direction.y < -1e-5 && origin.y > 0.0 ? -origin.y / direction.y : SDF_INFINITE;
    ivec2 cell;
    float unused;
    float t = sdf_trace(origin, direction, min(to_floor, SDF_FAR), pixel_angle_rad, true, cell, unused);
    bool solid = t < SDF_INFINITE;
    vec3 sky = sdf_sky(direction);
    if (!solid && to_floor > SDF_FAR) {
        return sky;
    }
    t = solid ? t : to_floor;
    vec3 position = origin + direction * t;
    float lift = max(0.5 * t * pixel_angle_rad, 1e-3);
    vec3 normal = vec3(0.0, 1.0, 0.0);
    vec3 color;
    float metallic = 0.0;
    float roughness = 0.35;
    if (solid) {
        int kind = sdf_kind(cell);
        normal = sdf_normal(kind, position - sdf_centre(cell), lift);
        float hue = fract(float(kind) * 0.61803399);
        color = 0.42 + 0.38 * cos(6.2831853 * (vec3(0.0, 0.36, 0.68) + hue));
        metallic = kind % 3 == 1 ? 0.9 : 0.0;
        roughness = 0.16 + 0.12 * float(kind % 5);
    } else {
        color = sdf_floor_color(position.xz, direction, t, pixel_angle_rad);
    }
    ivec2 blocker;
    float sun;
    // Off the surface by more than the threshold of the ray that found it.
    vec3 start = position + normal * (2.5 * lift);
    sdf_trace(start, SDF_SUN_DIRECTION, SDF_FAR, SDF_DARK_RAD, false, blocker, sun);
    sun = clamp(sun, 0.0, 1.0);
    sun *= sun * (3.0 - 2.0 * sun);
    float open = sdf_openness(position, normal);
    vec3 lit = sdf_shade(normal, -direction, color, metallic, roughness, sun, open);
    // The floor goes over into the horizon, without a seam at SDF_FAR.
    float haze = smoothstep(20.0, SDF_FAR, t);
    return clamp(mix(lit, sky, sqrt(haze)), vec3(0.0), vec3(64.0));
}

#endif
