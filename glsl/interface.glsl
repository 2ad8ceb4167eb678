// Every set, binding, block and varying of the slice programs: the only file with layout(set = ...).
// Source: MJ 3.4, 3.5 and 6 name the constants; here they keep those names, in anonymous blocks.
// Spaces: `x` is object space, where the longest side of the object spans [-1, 1]; `_eye` is eye space, same unit.
layout(set = 0, binding = 0) uniform View {
    mat4 projection;        // eye to clip space: fixed while the trackball turns (MJ 3.4)
    mat4 texture_matrix;    // eye to object space: the trackball, inverted (MJ 3.3)
    mat4 object_matrix;     // object to eye space
    mat4 display_matrix;    // turns the finished slice stack, to look at it from the side (MJ Fig. 1)
    vec4 box_min;           // box around the soft region, object space
    vec4 box_max;
    vec4 clip_plane;        // keeps dot(clip_plane.xyz, x) <= clip_plane.w
    vec4 volume_scale;      // object space to texture coordinates: scale * x + offset
    vec4 volume_offset;
    vec4 volume_texel;      // one texel in texture coordinates
    vec4 distance_decode;   // stored texel s to signed distance: x + y * s, object units
    vec4 picture_scale;     // pixel coordinates to [0, 2] across the picture, in xy
    vec4 ray_scale;         // half width and height of the view: at depth 1 in perspective, at any depth in parallel
    float step_size;        // distance between slices, object units
    float first_depth;      // depth of the slice nearest to the eye
    float slice_count;      // slices from there on
    float leap_slack;       // how much nearer the matter may be than a sampled distance says, object units
    float full_opacity;     // a ray ends where its opacity reaches this
    float time;             // seconds
    float opacity_rate;     // c of PH 3.1, per object unit
    float noise_cells;      // lattice cells across the noise block
    float turbulence_cells; // lattice cells of the first octave across the turbulence block
};
layout(set = 0, binding = 1) uniform Constants {
    mat4 normal_matrix;     // inverse transpose of object_matrix: normals to eye space (MJ 3.3)
    vec4 material_color;    // linear RGB
    vec4 ambient_color;
    vec4 light_color;
    vec4 light_position;    // eye space: the light moves with the eye (MJ 3.2)
    float specular_power;
    float specular_strength;
    float iso_value;        // inner iso-value: the object starts here, signed distance in object units
    float outer_iso_value;  // outer iso-value: the soft region starts here (MJ 6)
};
#include <knobs>
layout(set = 0, binding = 3) uniform texture3D volume_image;        // MJ 3.1
layout(set = 0, binding = 4) uniform texture3D noise_image;         // MJ 4.1: gradient in RGB, noise in A
layout(set = 0, binding = 5) uniform texture3D turbulence_image;    // MJ 4.1: the same, all octaves summed
layout(set = 0, binding = 6) uniform texture1D transfer_image;      // MJ 2: colour and opacity by density
layout(set = 0, binding = 7) uniform texture2D segment_image;       // Engel 2001: the same for a segment, by both ends
layout(set = 0, binding = 8) uniform texture3D classified_image;    // MJ 2: pre-classified, opacity-weighted
layout(set = 0, binding = 9) uniform sampler clamp_sampler;
layout(set = 0, binding = 10) uniform sampler repeat_sampler;
#define volume sampler3D(volume_image, clamp_sampler)
#define noise_block sampler3D(noise_image, repeat_sampler)
#define turbulence_block sampler3D(turbulence_image, repeat_sampler)
#define transfer_map sampler1D(transfer_image, clamp_sampler)
#define segment_map sampler2D(segment_image, clamp_sampler)
#define classified_volume sampler3D(classified_image, clamp_sampler)
