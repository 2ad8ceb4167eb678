// A grid of cells around the soft region, of which some are proven to be empty: a ray goes on to where it leaves them, and
// lands on the same grid of samples, so that the picture does not change.
// Source: ours; GG 39.6.1 leaves out blocks by their extremes.
// x: object space; stride: of the ray, from one sample to the next, object space; k: number of the sample, which grows
// along a ray. Result: steps to the next sample that may hold matter; 0 where that is x.
// A texel is how many cells it is to one that may hold matter, 0 for such a one: all that are nearer are empty. The grid is
// asked again where a ray leaves a cell, not at each sample in it.
float open_until = -1.0;    // the last sample of this ray that is in the cell looked up last, where that may hold matter
float empty_until = -1.0;   // where the ray leaves the empty cells that it was in last, in steps
const float SLIVER = 1e-3;  // so little of a step between two cells is rounding

float empty_steps(vec3 x, vec3 stride, float k) {
    if (k <= open_until) return 0.0;
    vec3 count = vec3(textureSize(cell_grid, 0)), scale = count / (box_max.xyz - box_min.xyz);
    vec3 at = (x - box_min.xyz) * scale, cell = clamp(floor(at), vec3(0.0), count - 1.0);
    float cells = round(255.0 * texelFetch(cell_grid, ivec3(cell), 0).r);
    vec3 rate = stride * scale;                           // in cells
    rate = mix(rate, vec3(1e-12), lessThan(abs(rate), vec3(1e-12)));
    vec3 reach = sign(rate) * (max(cells, 1.0) - 0.5);
    vec3 ways = (cell + 0.5 + reach - at) / rate, came = (at - cell - 0.5 + reach) / rate;
    float leaves = min(min(ways.x, ways.y), ways.z), entered = min(min(came.x, came.y), came.z);
    float steps = max(floor(leaves), 0.0);
    // A sample that looks back to the one before is left out where all of that step is in cells that are empty.
    bool looks_in = sample_reach > 0.0 && entered < 1.0 && k - entered > empty_until;
#ifdef ONE_SAMPLE
    looks_in = false;
#endif
    if (cells > 0.0) {
        empty_until = k + leaves + SLIVER;
        if (!looks_in) return steps + 1.0;
        steps = 0.0;
    }
    open_until = k + steps;
    return 0.0;
}
