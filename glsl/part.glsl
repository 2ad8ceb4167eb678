// Inputs of each object of a scene: constants, volume, transfer map.
// Source: MJ 3.5 and 6 name the constants.
// Spaces as in interface.glsl; bindings from 16 on. An additional object has the next eight bindings, and its constants in
// the block of parameters.
layout(set = 0, binding = 16) uniform Constants {
    mat4 normal_matrix;     // inverse transpose of object_matrix: normals to eye space (MJ 3.3)
    vec4 material_color;    // linear RGB
    vec4 ambient_color;
    vec4 light_color;
    vec4 light_position;    // eye space: the light moves with the eye (MJ 3.2)
    float specular_power;
    float specular_strength;
    float iso_value;        // inner iso-value: the object starts here, signed distance in object units
    float outer_iso_value;  // outer iso-value: the soft region starts here (MJ 6)
    vec4 volume_scale;      // object space to texture coordinates: scale * x + offset
    vec4 volume_offset;
    vec4 volume_texel;      // one texel in texture coordinates
    vec4 distance_decode;   // stored texel s to signed distance: x + y * s, object units
    mat4 place_matrix;      // object space of the scene to that of this object, where a scene has several
    vec4 own_min;           // box around the soft region, in the object's own space; heights of a kept base in w
    vec4 own_max;
    vec4 transfer_color;    // of a transfer map that has no other: linear RGB, density in A
    float opacity_rate;     // c of PH 3.1, per object unit
    float place_scale;      // object units of the scene in one of this object
    float skip_slack;       // how much nearer the matter may be than a sampled distance says, units of the object
    float own_radius;       // no matter is farther from the origin of the object's own space than this
    float hold_radius;      // beyond it a step along the radius stays as long as it is there, the object's own space
    float closest_range;    // stored texel s to the way to the closest point: (2 s - 1) times this, object units
};
layout(set = 0, binding = 17) uniform texture3D volume_image;       // MJ 3.1
layout(set = 0, binding = 18) uniform texture1D transfer_image;     // MJ 2: colour and opacity by density
layout(set = 0, binding = 19) uniform texture2D segment_image;      // Engel 2001: the same for a segment, by both ends
layout(set = 0, binding = 20) uniform texture3D classified_image;   // MJ 2: pre-classified, opacity-weighted
layout(set = 0, binding = 22) uniform texture1D index_image;        // PH 2.4: index of refraction by density
layout(set = 0, binding = 21) uniform texture3D closest_image;      // PH 4: the way to the closest point in RGB
layout(set = 0, binding = 23) uniform texture3D brick_image;        // which bricks of the volume are stored, and where
#define volume sampler3D(volume_image, clamp_sampler)
#define transfer_map sampler1D(transfer_image, table_sampler)
#define segment_map sampler2D(segment_image, table_sampler)
#define classified_volume sampler3D(classified_image, clamp_sampler)
#define index_map sampler1D(index_image, table_sampler)
#define closest_volume sampler3D(closest_image, clamp_sampler)
#define brick_index sampler3D(brick_image, clamp_sampler)
