// The list of shading samples of a foveated frame. Bit 31 set: a pixel of the native disc, as
// y * width + x of the display; else an LP texel, as v * w + u.
const uint NATIVE_SAMPLE = 0x80000000u;

// First column of the LP-buffer that a filter changes; where none runs, one past the last.
int first_filtered_column(FoveaParams p) {
    return int(p.ring.z * p.size_f.x);
}

struct SampleCounts {
    uint listed;            // entries of the list
    uint on_display;        // LP texels whose centre lies on the display
    uint shaded_texels;     // LP texels in the list
    uint native_pixels;     // display pixels in the list
    uint shaded_on_display; // of the LP texels in the list, those whose centre lies on the display
    uint reused;            // samples that the other eye had: not in the list
    uint pad0;
    uint pad1;
};
