// Every set, binding and block that a scene has once; what each object of a scene has is in part.glsl.
// Source: MJ 3.4, 3.5 and 6 name the constants; here they keep those names, in anonymous blocks.
// Blocks: View, Constants, Parameters, and no fourth: lavapipe of Mesa 22.3 crashes while it compiles a program with four.
// Spaces: `x` is object space, where the longest side of the object spans [-1, 1]; `_eye` is eye space, same unit.
layout(set = 0, binding = 0) uniform View {
    mat4 projection;        // eye to clip space: fixed while the trackball turns (MJ 3.4)
    mat4 texture_matrix;    // eye to object space: the trackball, inverted (MJ 3.3)
    mat4 object_matrix;     // object to eye space
    mat4 display_matrix;    // turns the finished slice stack, to look at it from the side (MJ Fig. 1)
    vec4 box_min;           // box around the soft region, object space
    vec4 box_max;
    vec4 clip_plane;        // keeps dot(clip_plane.xyz, x) <= clip_plane.w
    vec4 picture_scale;     // pixel coordinates to [0, 2] across the picture, in xy; where in its pixel a ray is, in zw
    vec4 ray_scale;         // half width and height of the view: at depth 1 in perspective, at any depth in parallel
    float soft_radius;      // no matter is farther from the origin of object space than this
    float step_size;        // distance between slices, object units
    float first_depth;      // depth of the slice nearest to the eye
    float slice_count;      // slices from there on
    float full_opacity;     // a ray ends where its opacity reaches this
    float sample_reach;     // how far from its place a sample looks for matter along its ray, object units: 0 for a point
    float steepness;        // how much a distance changes at most, for the way: more than 1 where a warp moves what is looked up
    float box_margin;       // how much further than the box the slices go: samples reach and move along their rays
    float jitter_seed;      // below 2^24: which phases the pixels have
    float time;             // seconds
    float noise_cells;      // lattice cells across the noise block
    float turbulence_cells; // lattice cells of the first octave across the turbulence block
    float channel_cells;    // those across the block of four octaves
    float turbulence_octaves;   // octaves in the turbulence block
    float low_octaves;      // octaves in the block of the low ones
    float noise_period;     // cells after which the lattice of procedural noise repeats, a power of two
    float turbulence_period;    // those of the first octave of turbulence
    float turbulence_growth;    // 1: each octave repeats after twice as many cells as the one before; 0: after as many
    float turbulence_cycle; // octaves after which that begins anew, a power of two
    float random_mean;      // mean of |noise| of the block of random texels
    mat4 shadow_matrix;     // eye space to that of the light: the light at the origin, the scene along +z
    float shadow_rim;       // 4 sin(a / 4) of the greatest angle a from the axis of the light, see light_space.glsl
    float shadow_near;      // distances from the light between which the scene is
    float shadow_far;
    float shadow_side;      // texels along a side of the shadow volume
    float shadow_steps;     // samples along a ray of the light in each
    float shadow_bias;      // size of a texel in the middle of the scene, object units
    vec4 slice_axis;        // across the slices of half-angle slicing, toward the light; eye space, unit length
    vec4 transport_color;   // part of the optical depth that scattered light is spared, linear RGB
    float translucency;     // part of the light that is scattered
    float scatter;          // standard deviation of its blur after one object unit, object units
};
#include <parameters>
layout(set = 0, binding = 1) uniform sampler table_sampler;         // tables of one and two dimensions: clamps
layout(set = 0, binding = 57) uniform texture2D phase_image;        // PH 3.1: phases of the pixels, blue noise; 16 to 55 are those of objects
layout(set = 0, binding = 3) uniform texture3D noise_image;         // MJ 4.1: gradient in RGB, noise in A
layout(set = 0, binding = 4) uniform texture3D turbulence_image;    // MJ 4.1: the same, all octaves summed
layout(set = 0, binding = 5) uniform sampler clamp_sampler;
layout(set = 0, binding = 6) uniform sampler repeat_sampler;
layout(set = 0, binding = 7) uniform texture3D shadow_image;        // light that is left before each segment
layout(set = 0, binding = 8) uniform sampler block_sampler;         // MJ 4.1: repeats, or mirrors
layout(set = 0, binding = 9) uniform texture3D noise_value_image;   // noise alone
layout(set = 0, binding = 10) uniform texture3D turbulence_value_image;     // turbulence alone
layout(set = 0, binding = 11) uniform texture3D channel_image;      // MJ 4.1: four octaves of noise
layout(set = 0, binding = 12) uniform texture1D permutation_image;  // MJ 4.2: an entry and the next one
layout(set = 0, binding = 13) uniform texture1D gradient_image;     // MJ 4.2: gradients in the order of the permutation
layout(set = 0, binding = 14) uniform texture3D low_octaves_image;  // the first octaves of turbulence
layout(set = 0, binding = 15) uniform texture3D random_image;       // GG 39.5
layout(set = 0, binding = 58) uniform texture2D light_before_image; // GG 39.5.1: light that is left before a slice
layout(set = 0, binding = 56) uniform texture2D light_behind_image; // and behind it
layout(set = 0, binding = 59) uniform texture3D cell_image;         // cells that are proven to be empty: see cells/grid.glsl
layout(set = 0, binding = 60) uniform texture2D target_image;       // the picture, as far as it is drawn: see mark.frag
layout(set = 0, binding = 62) uniform texture3D groom_shape_image;  // painted: direction in RGB, length in A
layout(set = 0, binding = 63) uniform texture3D groom_look_image;   // painted: color in RGB, density in A
layout(set = 0, binding = 64) uniform texture3D groom_amount_image; // painted: how strong warps and DMFs are
#define noise_block sampler3D(noise_image, block_sampler)
#define noise_value_block sampler3D(noise_value_image, block_sampler)
#define turbulence_block sampler3D(turbulence_image, block_sampler)
#define turbulence_value_block sampler3D(turbulence_value_image, block_sampler)
#define channel_block sampler3D(channel_image, block_sampler)
#define low_octaves_block sampler3D(low_octaves_image, block_sampler)
#define random_block sampler3D(random_image, block_sampler)
#define phase_tile sampler2D(phase_image, clamp_sampler)
#define permutation_table sampler1D(permutation_image, repeat_sampler)
#define gradient_table sampler1D(gradient_image, repeat_sampler)
#define light_before sampler2D(light_before_image, table_sampler)
#define light_behind sampler2D(light_behind_image, table_sampler)
#define groom_shape_volume sampler3D(groom_shape_image, clamp_sampler)
#define groom_look_volume sampler3D(groom_look_image, clamp_sampler)
#define groom_amount_volume sampler3D(groom_amount_image, clamp_sampler)
#define cell_grid sampler3D(cell_image, clamp_sampler)
#define shadow_volume sampler3D(shadow_image, clamp_sampler)
#include "part.glsl"
