// Double-single arithmetic: a number is the unevaluated sum of two floats, vec2(hi, lo) with
// |lo| <= ulp(hi)/2, which carries about 48 bits. Sources: Dekker (1971) for the product and the
// split, Knuth (TAOCP 2, 4.2.2) for the sum.
//
// Every result is `precise`: an optimiser that contracts or cancels terms would remove exactly the
// rounding errors that this file keeps. Products are split instead of using fma(), because Vulkan
// allows fma() to round twice. Nothing here uses the driver's log, exp, sin or atan, which may be
// off by thousands of ulps, and division is corrected, because it may be off by 2.5.
#ifndef MACULA_DF_GLSL
#define MACULA_DF_GLSL

const vec2 DF_LN2 = vec2(0.693147182, -1.90465421e-09);
const float DF_INV_LN2 = 1.44269502;
const vec2 DF_INV_TURN = vec2(0.159154937, 6.42063824e-09); // 1 / 2 pi
const vec2 DF_HALF_PI = vec2(1.57079637, -4.37113883e-08);
const vec2 DF_QUARTER_PI = vec2(0.785398185, -2.18556941e-08);
const float DF_SQRT2 = 1.41421354;

// 2^exponent for -126..127.
float df_pow2(int exponent) {
    return uintBitsToFloat(uint(clamp(exponent, -126, 127) + 127) << 23);
}

// Exponent of a positive normal number, such that the number is in [2^e, 2^(e+1)).
int df_exponent(float a) {
    return int(floatBitsToUint(a) >> 23) - 127;
}

// a + b exactly; |a| >= |b| or a = 0.
vec2 df_quick_two_sum(float a, float b) {
    precise float sum = a + b;
    precise float error = b - (sum - a);
    return vec2(sum, error);
}

// a + b exactly.
vec2 df_two_sum(float a, float b) {
    precise float sum = a + b;
    precise float from_b = sum - a;
    precise float from_a = sum - from_b;
    precise float error = (a - from_a) + (b - from_b);
    return vec2(sum, error);
}

// a as the sum of two numbers of 12 bits. |a| < 1e34.
vec2 df_split(float a) {
    precise float shifted = 4097.0 * a;
    precise float above = shifted - a;
    precise float hi = shifted - above;
    precise float lo = a - hi;
    return vec2(hi, lo);
}

// a * b exactly (barring underflow).
vec2 df_two_prod(float a, float b) {
    precise float product = a * b;
    vec2 x = df_split(a);
    vec2 y = df_split(b);
    precise float error = x.x * y.x - product;
    error += x.x * y.y;
    error += x.y * y.x;
    error += x.y * y.y;
    return vec2(product, error);
}

vec2 df_add(vec2 a, vec2 b) {
    vec2 hi = df_two_sum(a.x, b.x);
    vec2 lo = df_two_sum(a.y, b.y);
    precise float carry = hi.y + lo.x;
    vec2 sum = df_quick_two_sum(hi.x, carry);
    precise float rest = sum.y + lo.y;
    return df_quick_two_sum(sum.x, rest);
}

vec2 df_sub(vec2 a, vec2 b) {
    return df_add(a, -b);
}

vec2 df_mul(vec2 a, vec2 b) {
    vec2 product = df_two_prod(a.x, b.x);
    precise float cross_terms = a.x * b.y + a.y * b.x;
    precise float rest = product.y + cross_terms;
    return df_quick_two_sum(product.x, rest);
}

vec2 df_mul_f(vec2 a, float b) {
    vec2 product = df_two_prod(a.x, b);
    precise float rest = product.y + a.y * b;
    return df_quick_two_sum(product.x, rest);
}

// Long division: each quotient digit may be off by some ulps, the remainder shows by how much.
vec2 df_div(vec2 a, vec2 b) {
    precise float first = a.x / b.x;
    vec2 rest = df_sub(a, df_mul_f(b, first));
    precise float second = rest.x / b.x;
    rest = df_sub(rest, df_mul_f(b, second));
    precise float third = rest.x / b.x;
    vec2 quotient = df_quick_two_sum(first, second);
    return df_add(quotient, vec2(third, 0.0));
}

bool df_less(vec2 a, vec2 b) {
    return a.x < b.x || (a.x == b.x && a.y < b.y);
}

// Natural logarithm of a positive normal number. Keeps its relative precision around 1.
vec2 df_log(vec2 a) {
    int exponent = df_exponent(a.x);
    // Two steps, because 2^-exponent itself may be out of range.
    int half_exponent = exponent / 2;
    vec2 m = a * df_pow2(-half_exponent) * df_pow2(half_exponent - exponent);
    if (m.x > DF_SQRT2) {
        m *= 0.5;
        exponent += 1;
    }
    // log m = 2 artanh s, |s| < 0.172.
    vec2 s = df_div(df_add(m, vec2(-1.0, 0.0)), df_add(m, vec2(1.0, 0.0)));
    vec2 q = df_mul(s, s);
    precise float tail = 1.0 / 11.0 + q.x * (1.0 / 13.0 + q.x * (1.0 / 15.0 + q.x * (1.0 / 17.0
        + q.x * (1.0 / 19.0 + q.x * (1.0 / 21.0)))));
    vec2 series = df_add(vec2(0.111111112, -8.27842295e-10), df_mul_f(q, tail));
    series = df_add(vec2(0.142857149, -6.386212e-09), df_mul(q, series));
    series = df_add(vec2(0.200000003, -2.98023228e-09), df_mul(q, series));
    series = df_add(vec2(0.333333343, -9.93410776e-09), df_mul(q, series));
    vec2 twice = 2.0 * s;
    vec2 log_m = df_add(twice, df_mul(twice, df_mul(q, series)));
    return df_add(df_mul_f(DF_LN2, float(exponent)), log_m);
}

// e^x - 1 for |x| <= 0.35, to full relative precision.
vec2 df_expm1_small(vec2 x) {
    // Eighths converge fast; e^2r - 1 = 2 (e^r - 1) + (e^r - 1)^2 leads back.
    vec2 r = 0.125 * x;
    precise float tail = 1.0 / 120.0 + r.x * (1.0 / 720.0 + r.x * (1.0 / 5040.0 + r.x * (1.0 / 40320.0)));
    vec2 series = df_add(vec2(0.0416666679, -1.24176347e-09), df_mul_f(r, tail));
    series = df_add(vec2(0.166666672, -4.96705388e-09), df_mul(r, series));
    series = df_add(vec2(0.5, 0.0), df_mul(r, series));
    vec2 result = df_add(r, df_mul(df_mul(r, r), series));
    for (int i = 0; i < 3; ++i) {
        result = df_add(2.0 * result, df_mul(result, result));
    }
    return result;
}

// e^x for -87 <= x <= 87; 0 below.
vec2 df_exp(vec2 x) {
    if (x.x < -87.0) {
        return vec2(0.0);
    }
    float octaves = round(x.x * DF_INV_LN2);
    vec2 rest = df_sub(x, df_mul_f(DF_LN2, octaves));
    return df_add(vec2(1.0, 0.0), df_expm1_small(rest)) * df_pow2(int(octaves));
}

// e^x - 1 for -87 <= x <= 87, to full relative precision around 0.
vec2 df_expm1(vec2 x) {
    if (abs(x.x) <= 0.35) {
        return df_expm1_small(x);
    }
    return df_add(df_exp(x), vec2(-1.0, 0.0));
}

// sin x for |x| <= 0.79, to full relative precision.
vec2 df_sin_small(vec2 x) {
    vec2 q = df_mul(x, x);
    precise float tail = 2.75573188e-06 + q.x * (-2.50521079e-08 + q.x * (1.60590444e-10 - q.x * 7.64716373e-13));
    vec2 series = df_add(vec2(-0.000198412701, 2.72559687e-12), df_mul_f(q, tail));
    series = df_add(vec2(0.00833333377, -4.34617203e-10), df_mul(q, series));
    series = df_add(vec2(-0.166666672, 4.96705388e-09), df_mul(q, series));
    return df_add(x, df_mul(df_mul(x, q), series));
}

// atan(k/8) / 2 pi
const vec2 DF_ATAN_EIGHTHS[9] = vec2[9](
    vec2(0.0, 0.0), vec2(0.019791713, -9.04159914e-10), vec2(0.0389895663, -1.07785203e-09),
    vec2(0.0571001247, 9.5279995e-10), vec2(0.0737918094, -5.54837842e-10),
    vec2(0.0889038444, -2.11186046e-09), vec2(0.102416381, 1.10967568e-09),
    vec2(0.114405349, -1.21445354e-09), vec2(0.125, 0.0));

// atan2(y, x) as a share of a turn, in [0, 1); 0 for lengths below 1e-30. Just below a full turn hi
// is 1 and lo is negative.
vec2 df_atan2_turns(vec2 y, vec2 x) {
    vec2 wide = x.x < 0.0 ? -x : x;
    vec2 high = y.x < 0.0 ? -y : y;
    bool steep = df_less(wide, high);
    vec2 most = steep ? high : wide;
    vec2 least = steep ? wide : high;
    if (most.x < 1e-30) {
        return vec2(0.0);
    }
    float scale = df_pow2(-df_exponent(most.x));
    most *= scale;
    least *= scale;
    // atan t = atan c + atan((t - c) / (1 + t c)), with c the nearest eighth.
    int eighths = clamp(int(round(8.0 * least.x / most.x)), 0, 8);
    float c = 0.125 * float(eighths);
    vec2 w = df_div(df_sub(least, df_mul_f(most, c)), df_add(most, df_mul_f(least, c)));
    vec2 q = df_mul(w, w);
    precise float tail = -1.0 / 7.0 + q.x * (1.0 / 9.0 + q.x * (-1.0 / 11.0 + q.x * (1.0 / 13.0)));
    vec2 series = df_add(vec2(0.200000003, -2.98023228e-09), df_mul_f(q, tail));
    series = df_add(vec2(-0.333333343, 9.93410776e-09), df_mul(q, series));
    vec2 angle = df_add(w, df_mul(w, df_mul(q, series)));
    vec2 turns = df_add(DF_ATAN_EIGHTHS[eighths], df_mul(angle, DF_INV_TURN));
    if (steep) {
        turns = df_sub(vec2(0.25, 0.0), turns);
    }
    if (x.x < 0.0) {
        turns = df_sub(vec2(0.5, 0.0), turns);
    }
    if (y.x < 0.0) {
        turns = df_sub(vec2(1.0, 0.0), turns);
    }
    // An angle below the smallest step of the pair rounds to the full turn.
    return df_less(turns, vec2(1.0, 0.0)) ? turns : vec2(0.0);
}

#endif
