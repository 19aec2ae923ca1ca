// The KFR mapping (thesis of 2018, Eq. 2.8) on the GPU, twin of `engine/src/fovea`.
//
// Three levels: `fovea_forward` carries about 48 bits throughout; `fovea_forward_texels` and
// `fovea_inverse_offset` run for every pixel or texel, and carry a second float only where single
// precision would show: in z = ln r / L and in the kernel. No function uses the driver's log, exp,
// sin or atan, for which Vulkan's bounds are too wide.
//
// There are no bindings in here: the block is passed in.
#ifndef MACULA_FOVEA_GLSL
#define MACULA_FOVEA_GLSL

#include "shared/df.glsl"

// The kernel's kind and integer exponent are the same for a whole pipeline. A shader that runs for
// every pixel may define both as specialisation constants before it includes this file, so that the
// other kernels are not even compiled: a driver that masks branches would run all of them.
#ifndef FOVEA_KERNEL_KIND
#define FOVEA_KERNEL_KIND p.kernel.x
#endif
#ifndef FOVEA_INTEGER_ALPHA
#define FOVEA_INTEGER_ALPHA p.kernel.y
#endif

const uint FOVEA_POWER = 0u;
const uint FOVEA_POLYNOMIAL = 1u;
const uint FOVEA_SINE = 2u;
const uint FOVEA_EXPONENTIAL = 3u;

// Same layout as the Rust `FoveaParams`, in std140 as in std430.
struct FoveaParams {
    vec4 gaze_px;   // x hi, y hi, x lo, y lo
    uvec4 size;     // display width, height (px); LP-buffer width, height (texels)
    vec4 size_f;    // LP-buffer width, height (texels); display width, height (px)
    vec4 log_reach; // L hi, lo; 1/L hi, lo
    vec4 octave;    // ln 2 / (2 L) head of 16 bits, tail; L / ln 2 hi, lo
    uvec4 kernel;   // kind, alpha where it is an integer or 0, number of coefficients, 0
    vec4 shape;     // alpha hi, lo, 1 / alpha, 0
    vec4 ring;      // native radius (px), blend band (px), u_norm of the LP filter's start (1: none), reach (px)
    vec4 beta_hi[2];
    vec4 beta_lo[2];
    // The other methods; mapping.glsl reads these.
    vec4 base_px;      // origin of offsets on the display: x hi, y hi, x lo, y lo
    vec4 ray_rows[3];  // ray in the gaze's frame from (offset, 1)
    vec4 px_rows[3];   // the inverse
    vec4 edges[4];     // unit normals, inwards, of the planes through the gaze's frame and the display's edges
    vec4 table;        // knots per unit, last knot, px per unit of the plane at distance 1, 1 / native band
    ivec4 native_box;  // first px, end px
    vec4 native_rect;  // x0, y0, x1, y1 in px
    vec4 layer_rect;   // of the finer layer
    vec4 axes;         // bands of the two rectangles (px), columns of the finer layer, start of the coarser one's table;
                       // radial: 1 for knots that are dense at the end
};

// A normalised LP position: hi and lo of u in 0..=1, hi and lo of v in [0, 1).
struct LpPoint {
    vec2 u;
    vec2 v;
};

const vec2 FOVEA_INV_E_LESS_1 = vec2(0.581976712, -4.88070429e-09); // 1 / (e - 1)
const float FOVEA_E_LESS_1 = 1.71828187;

// --- Elementary functions in single precision ----------------------------------------------------

// ln a = exponent ln 2 + log_m for a positive normal number; |log_m| <= 0.35, absolute error 6e-8.
void fovea_log_parts(float a, out float exponent, out float log_m) {
    int octave = df_exponent(a);
    float m = uintBitsToFloat((floatBitsToUint(a) & 0x007fffffu) | 0x3f800000u);
    if (m > DF_SQRT2) {
        m *= 0.5;
        octave += 1;
    }
    float s = (m - 1.0) / (m + 1.0);
    float q = s * s;
    float series = q * (1.0 / 3.0 + q * (0.2 + q * (1.0 / 7.0 + q * (1.0 / 9.0 + q * (1.0 / 11.0)))));
    exponent = float(octave);
    log_m = 2.0 * (s + s * series);
}

// Natural logarithm of a positive normal number, absolute error about 1e-7 times its exponent's size.
float fovea_log(float a) {
    float exponent, log_m;
    fovea_log_parts(a, exponent, log_m);
    precise float result = exponent * 0.693145752 + (exponent * 1.42860677e-06 + log_m);
    return result;
}

// e^x for |x| <= 0.35.
float fovea_exp_small(float x) {
    return 1.0 + x * (1.0 + x * (0.5 + x * (1.0 / 6.0 + x * (1.0 / 24.0 + x * (1.0 / 120.0
        + x * (1.0 / 720.0 + x * (1.0 / 5040.0)))))));
}

// e^x for -87 <= x <= 87; about 1e-38 below.
float fovea_exp(float x) {
    float octaves = round(max(x, -87.0) * DF_INV_LN2);
    precise float rest = (max(x, -87.0) - octaves * 0.693145752) - octaves * 1.42860677e-06;
    return fovea_exp_small(rest) * df_pow2(int(octaves));
}

// sin x for |x| <= pi/4.
float fovea_sin_small(float x) {
    float q = x * x;
    return x + x * q * (-1.0 / 6.0 + q * (1.0 / 120.0 + q * (-1.0 / 5040.0 + q * 2.75573188e-06)));
}

// cos x for |x| <= pi/4.
float fovea_cos_small(float x) {
    float q = x * x;
    return 1.0 + q * (-0.5 + q * (1.0 / 24.0 + q * (-1.0 / 720.0 + q * (2.48015876e-05 - q * 2.755732e-07))));
}

// Unit vector at a share of a turn, any finite number.
vec2 fovea_direction(float turns) {
    float quarters = round(4.0 * turns);
    precise float rest = turns - 0.25 * quarters;
    float angle = rest * 6.28318548 + rest * -1.74845553e-07;
    vec2 unit = vec2(fovea_cos_small(angle), fovea_sin_small(angle));
    int quarter = int(quarters) & 3;
    if ((quarter & 1) != 0) {
        unit = vec2(-unit.y, unit.x);
    }
    return (quarter & 2) != 0 ? -unit : unit;
}

// atan2(y, x) as a share of a turn in [0, 1), absolute error 1e-7; 0 for (0, 0).
float fovea_turns(vec2 offset) {
    vec2 size = abs(offset);
    float most = max(size.x, size.y);
    float least = min(size.x, size.y);
    // Beyond 22.5 degrees the angle to the diagonal is the smaller one.
    bool diagonal = least > 0.414213562 * most;
    float t = diagonal ? (least - most) / (least + most) : least / max(most, 1e-37);
    float q = t * t;
    float series = q * (-1.0 / 3.0 + q * (0.2 + q * (-1.0 / 7.0 + q * (1.0 / 9.0
        + q * (-1.0 / 11.0 + q * (1.0 / 13.0 - q * (1.0 / 15.0)))))));
    float turns = (t + t * series) * DF_INV_TURN.x;
    turns = diagonal ? 0.125 + turns : turns;
    turns = size.y > size.x ? 0.25 - turns : turns;
    turns = offset.x < 0.0 ? 0.5 - turns : turns;
    turns = offset.y < 0.0 ? 1.0 - turns : turns;
    return turns < 1.0 ? turns : 0.0;
}

// arcsin s for 0 <= s <= 0.71, relative error 1e-7 up to 0.5.
float fovea_asin_small(float s) {
    float q = s * s;
    return s + s * q * (0.166666667 + q * (0.075 + q * (0.0446428571 + q * (0.0303819444
        + q * (0.0223721591 + q * (0.0173527644 + q * (0.01396484375 + q * (0.0115518009
        + q * (0.00976160953 + q * 0.00839033537)))))))));
}

// --- Kernels -------------------------------------------------------------------------------------

vec2 fovea_pow_integer(vec2 z, uint alpha) {
    if (alpha == 1u) {
        return z;
    }
    vec2 square = df_mul(z, z);
    if (alpha == 2u) {
        return square;
    }
    if (alpha == 4u) {
        return df_mul(square, square);
    }
    vec2 cube = df_mul(square, z);
    if (alpha == 3u) {
        return cube;
    }
    return alpha == 5u ? df_mul(cube, square) : df_mul(cube, cube);
}

vec2 fovea_horner_step(vec2 sum, vec2 z, float beta_hi, float beta_lo) {
    return df_add(df_mul(sum, z), vec2(beta_hi, beta_lo));
}

// Unrolled, so that no array is indexed by a variable: that would go through memory.
vec2 fovea_polynomial(FoveaParams p, vec2 z) {
    vec2 sum = vec2(0.0);
    if (p.kernel.z > 4u) {
        sum = vec2(p.beta_hi[1].w, p.beta_lo[1].w);
        sum = fovea_horner_step(sum, z, p.beta_hi[1].z, p.beta_lo[1].z);
        sum = fovea_horner_step(sum, z, p.beta_hi[1].y, p.beta_lo[1].y);
        sum = fovea_horner_step(sum, z, p.beta_hi[1].x, p.beta_lo[1].x);
    }
    sum = fovea_horner_step(sum, z, p.beta_hi[0].w, p.beta_lo[0].w);
    sum = fovea_horner_step(sum, z, p.beta_hi[0].z, p.beta_lo[0].z);
    sum = fovea_horner_step(sum, z, p.beta_hi[0].y, p.beta_lo[0].y);
    return df_mul(sum, z);
}

vec2 fovea_clamp01(vec2 value) {
    if (!(value.x > 0.0)) {
        return vec2(0.0);
    }
    return df_less(value, vec2(1.0, 0.0)) ? value : vec2(1.0, 0.0);
}

// K(z), hi and lo, to about 48 bits; near 1 the sine's pair holds the distance to 1 to 24 bits.
vec2 fovea_kernel_df(FoveaParams p, vec2 z) {
    z = fovea_clamp01(z);
    if (z.x == 0.0 || z == vec2(1.0, 0.0)) {
        return z;
    }
    vec2 u;
    if (FOVEA_KERNEL_KIND == FOVEA_POWER) {
        u = FOVEA_INTEGER_ALPHA != 0u ? fovea_pow_integer(z, FOVEA_INTEGER_ALPHA) : df_exp(df_mul(df_log(z), p.shape.xy));
    } else if (FOVEA_KERNEL_KIND == FOVEA_POLYNOMIAL) {
        u = fovea_polynomial(p, z);
    } else if (FOVEA_KERNEL_KIND == FOVEA_SINE) {
        if (z.x > 0.5) {
            vec2 half_sine = df_sin_small(df_mul(DF_QUARTER_PI, df_sub(vec2(1.0, 0.0), z)));
            u = df_sub(vec2(1.0, 0.0), 2.0 * df_mul(half_sine, half_sine));
        } else {
            u = df_sin_small(df_mul(DF_HALF_PI, z));
        }
    } else {
        u = df_mul(df_expm1(z), FOVEA_INV_E_LESS_1);
    }
    return fovea_clamp01(u);
}

// dK/dz, never negative.
float fovea_kernel_slope(FoveaParams p, float z) {
    z = clamp(z, 0.0, 1.0);
    if (FOVEA_KERNEL_KIND == FOVEA_POWER) {
        if (FOVEA_INTEGER_ALPHA != 0u) {
            return FOVEA_INTEGER_ALPHA == 1u ? 1.0
                                    : p.shape.x * fovea_pow_integer(vec2(z, 0.0), FOVEA_INTEGER_ALPHA - 1u).x;
        }
        return p.shape.x * fovea_exp((p.shape.x - 1.0) * fovea_log(max(z, 1e-30)));
    }
    if (FOVEA_KERNEL_KIND == FOVEA_POLYNOMIAL) {
        vec4 low = p.beta_hi[0];
        vec4 high = p.beta_hi[1];
        return max(low.y + z * (2.0 * low.z + z * (3.0 * low.w + z * (4.0 * high.x + z * (5.0 * high.y
            + z * (6.0 * high.z + z * 7.0 * high.w))))), 0.0);
    }
    if (FOVEA_KERNEL_KIND == FOVEA_SINE) {
        float other = 1.0 - z;
        return DF_HALF_PI.x * (other > 0.5 ? fovea_cos_small(DF_HALF_PI.x * z)
                                           : fovea_sin_small(DF_HALF_PI.x * other));
    }
    return fovea_exp(z) * FOVEA_INV_E_LESS_1.x;
}

void fovea_compensated_step(inout float sum, inout float error, float z, float beta) {
    vec2 product = df_two_prod(sum, z);
    vec2 next = df_two_sum(product.x, beta);
    precise float carried = error * z + (product.y + next.y);
    sum = next.x;
    error = carried;
}

// Horner's scheme that carries its rounding errors along (Langlois and Louvet, 2007); the second
// part of z enters by the slope.
vec2 fovea_polynomial_fast(FoveaParams p, vec2 z) {
    float sum = 0.0;
    float error = 0.0;
    if (p.kernel.z > 4u) {
        sum = p.beta_hi[1].w;
        fovea_compensated_step(sum, error, z.x, p.beta_hi[1].z);
        fovea_compensated_step(sum, error, z.x, p.beta_hi[1].y);
        fovea_compensated_step(sum, error, z.x, p.beta_hi[1].x);
    }
    fovea_compensated_step(sum, error, z.x, p.beta_hi[0].w);
    fovea_compensated_step(sum, error, z.x, p.beta_hi[0].z);
    fovea_compensated_step(sum, error, z.x, p.beta_hi[0].y);
    fovea_compensated_step(sum, error, z.x, 0.0);
    return fovea_clamp01(df_two_sum(sum, error + fovea_kernel_slope(p, z.x) * z.y));
}

// K(z) for z as a pair, to about 2e-7: cheap where single precision is good enough, and pairs for
// powers and polynomials, which pile up the rounding of their steps.
vec2 fovea_kernel_fast(FoveaParams p, vec2 z) {
    if (FOVEA_KERNEL_KIND == FOVEA_SINE) {
        if (z.x > 0.5) {
            float half_sine = fovea_sin_small(DF_QUARTER_PI.x * ((1.0 - z.x) - z.y));
            return df_quick_two_sum(1.0, -2.0 * half_sine * half_sine);
        }
        return vec2(fovea_sin_small(DF_HALF_PI.x * (z.x + z.y)), 0.0);
    }
    if (FOVEA_KERNEL_KIND == FOVEA_EXPONENTIAL) {
        // Nested, so that each rounding is damped by the factor outside.
        float x = z.x;
        float expm1 = x * (1.0 + x * (1.0 / 2.0) * (1.0 + x * (1.0 / 3.0) * (1.0 + x * (1.0 / 4.0)
            * (1.0 + x * (1.0 / 5.0) * (1.0 + x * (1.0 / 6.0) * (1.0 + x * (1.0 / 7.0)
            * (1.0 + x * (1.0 / 8.0) * (1.0 + x * (1.0 / 9.0) * (1.0 + x * (1.0 / 10.0)
            * (1.0 + x * (1.0 / 11.0)))))))))));
        return vec2(min((expm1 + (1.0 + expm1) * z.y) * FOVEA_INV_E_LESS_1.x, 1.0), 0.0);
    }
    if (FOVEA_KERNEL_KIND == FOVEA_POLYNOMIAL) {
        return fovea_polynomial_fast(p, z);
    }
    if (FOVEA_INTEGER_ALPHA != 0u) {
        return fovea_pow_integer(z, FOVEA_INTEGER_ALPHA);
    }
    return vec2(min(fovea_exp(p.shape.x * (fovea_log(z.x) + z.y / z.x)), 1.0), 0.0);
}

// K(z); the error is below 1 ulp.
float fovea_kernel(FoveaParams p, float z) {
    return fovea_kernel_df(p, vec2(z, 0.0)).x;
}

// Root of the polynomial kernel to single precision: Newton's method inside a shrinking bracket.
float fovea_polynomial_root(FoveaParams p, float u) {
    float low = 0.0;
    float high = 1.0;
    float z = u;
    for (int i = 0; i < 32; ++i) {
        vec2 reached = fovea_polynomial_fast(p, vec2(z, 0.0));
        float miss = (reached.x - u) + reached.y;
        if (miss < 0.0) {
            low = z;
        } else {
            high = z;
        }
        float slope = fovea_kernel_slope(p, z);
        float next = z - miss / max(slope, 1e-30);
        next = next > low && next < high ? next : 0.5 * (low + high);
        bool done = abs(next - z) <= 1e-7 * z;
        z = next;
        if (done) {
            break;
        }
    }
    return z;
}

// K^-1(u) as a pair, to about 1e-9 wherever the slope of K is above 1e-3.
vec2 fovea_kernel_inverse_pair(FoveaParams p, vec2 u) {
    u = fovea_clamp01(u);
    // The smallest texel centre is far above the limit; below it the logarithms would fail.
    if (u.x < 1e-30 || u == vec2(1.0, 0.0)) {
        return u.x < 1e-30 ? vec2(0.0) : u;
    }
    if (FOVEA_KERNEL_KIND == FOVEA_SINE) {
        // The arc sine's slope is infinite at 1; the half-angle form's is not, and no step of
        // Newton's method is needed.
        if (u.x > 0.5) {
            float rest = (1.0 - u.x) - u.y;
            return df_quick_two_sum(1.0, -1.27323949 * fovea_asin_small(sqrt(0.5 * rest)));
        }
        return vec2(fovea_asin_small(u.x) / DF_HALF_PI.x, 0.0);
    }
    float z = u.x;
    if (FOVEA_KERNEL_KIND == FOVEA_POWER) {
        if (FOVEA_INTEGER_ALPHA == 1u) {
            return u;
        }
        z = fovea_exp(p.shape.z * fovea_log(u.x));
    } else if (FOVEA_KERNEL_KIND == FOVEA_POLYNOMIAL) {
        z = fovea_polynomial_root(p, u.x);
    } else {
        z = fovea_log(1.0 + FOVEA_E_LESS_1 * u.x);
    }
    // One step of Newton's method with the residual of the pair; limited, for a slope near 0.
    z = clamp(z, 0.0, 1.0);
    vec2 miss = df_sub(fovea_kernel_df(p, vec2(z, 0.0)), u);
    float slope = max(fovea_kernel_slope(p, z), 1e-30);
    float change = clamp(miss.x / slope, -1e-4, 1e-4);
    return fovea_clamp01(df_two_sum(z, -change));
}

// K^-1(u).
float fovea_kernel_inverse(FoveaParams p, float u) {
    vec2 z = fovea_kernel_inverse_pair(p, vec2(u, 0.0));
    return z.x + z.y;
}

// --- Mapping -------------------------------------------------------------------------------------

// Display position (px, hi and lo) to the LP-buffer, to about 1e-12: 1e-4 px or better on the
// display, up to 11520x6480. Where a kernel is flat at 1 (sine; some polynomials) that holds up to
// the last half pixel before the farthest corner; at the corner itself u = 1 has no more digits.
LpPoint fovea_forward(FoveaParams p, vec2 px_hi, vec2 px_lo) {
    vec2 x = df_add(df_two_sum(px_hi.x, -p.gaze_px.x), df_two_sum(px_lo.x, -p.gaze_px.z));
    vec2 y = df_add(df_two_sum(px_hi.y, -p.gaze_px.y), df_two_sum(px_lo.y, -p.gaze_px.w));
    vec2 r2 = df_add(df_mul(x, x), df_mul(y, y));
    LpPoint lp;
    lp.u = vec2(0.0);
    if (df_less(vec2(1.0, 0.0), r2)) {
        lp.u = fovea_kernel_df(p, df_mul(0.5 * df_log(r2), p.log_reach.zw));
    }
    lp.v = df_atan2_turns(y, x);
    return lp;
}

// Display position (px) to LP texels (u w, v h), to 2e-3 texels at 7680x4320.
vec2 fovea_forward_texels(FoveaParams p, vec2 px) {
    precise vec2 offset = (px - p.gaze_px.xy) - p.gaze_px.zw;
    float r2 = dot(offset, offset);
    vec2 u = vec2(0.0);
    if (r2 > 1.0) {
        float exponent, log_m;
        fovea_log_parts(r2, exponent, log_m);
        // z = ln r2 / 2 L. The product with the head is exact, and the sum keeps its rounding.
        precise float head = exponent * p.octave.x;
        precise float rest = 0.5 * log_m * p.log_reach.z;
        vec2 z = df_two_sum(head, rest);
        precise float low = z.y + exponent * p.octave.y;
        z = fovea_clamp01(df_quick_two_sum(z.x, low));
        u = z.x > 0.0 ? fovea_kernel_fast(p, z) : vec2(0.0);
    }
    vec2 texels = vec2(u.x * p.size_f.x + u.y * p.size_f.x, fovea_turns(offset) * p.size_f.y);
    // A row just below the full turn rounds to the first one.
    texels.y = texels.y < p.size_f.y ? texels.y : 0.0;
    return texels;
}

// LP position in texels (centres at .5) to the display position's offset from the gaze, px.
vec2 fovea_inverse_offset(FoveaParams p, vec2 uv_texels) {
    precise float share = uv_texels.x / p.size_f.x;
    vec2 back = df_two_prod(share, p.size_f.x);
    precise float miss = (uv_texels.x - back.x) - back.y;
    vec2 z = fovea_kernel_inverse_pair(p, df_quick_two_sum(share, miss / p.size_f.x));
    // r = 2^(z L / ln 2), with the fraction taken before it is rounded.
    vec2 octaves = df_mul(z, p.octave.zw);
    float whole = round(octaves.x);
    precise float fraction = (octaves.x - whole) + octaves.y;
    float radius_px = fovea_exp_small(fraction * DF_LN2.x) * df_pow2(int(whole));
    return radius_px * fovea_direction(uv_texels.y / p.size_f.y);
}

// LP texels per px^2 at a distance from the gaze (px); 0 inside the fovea hole (r < 1 px).
float fovea_density(FoveaParams p, float radius_px) {
    if (!(radius_px >= 1.0)) {
        return 0.0;
    }
    float z = min(fovea_log(radius_px) * p.log_reach.z, 1.0);
    float texels = p.size_f.x * p.size_f.y;
    return texels * fovea_kernel_slope(p, z) * p.log_reach.z * DF_INV_TURN.x / (radius_px * radius_px);
}

#endif
