// Each slice cut to the box around the soft region, in the vertex stage, from a static vertex buffer.
// Source: GG 39.6.1 (draw only the required fragments); the corner paths follow Rezk-Salama and Kolb 2005.
// corner: x = corner 0..5 of the polygon, y = depth of the slice, negative; material: tint of the slice, linear RGBA.
#include <planes>
layout(location = 0) in vec2 corner;
layout(location = 1) in vec4 material;

// Six corners: an even one walks one of three edge-disjoint paths from the nearest to the farthest box corner, an odd
// one takes the edge between two paths, or repeats its even neighbor where the slice does not cut that edge.
vec3 proxy_position() {
    vec3 low = box_min.xyz - box_margin, high = box_max.xyz + box_margin;
    vec3 size = high - low;
    vec3 nearest = low;
    vec3 edge[3];
    float rise[3];
    for (int axis = 0; axis < 3; ++axis) {
        vec3 along = object_matrix[axis].xyz * size[axis];
        if (plane_depth(along) < 0.0) {     // toward the first slice: start at the other end of this axis
            nearest[axis] = high[axis];
            along = -along;
        }
        edge[axis] = along;
        rise[axis] = max(plane_depth(along), 1e-20);
    }
    vec3 start = (object_matrix * vec4(nearest, 1.0)).xyz;
    float depth = -corner.y - plane_depth(start);         // from the nearest corner to the slice, >= 0 inside
    if (depth < 0.0 || depth > rise[0] + rise[1] + rise[2]) return start;   // all six coincide
    int index = int(corner.x);
    int a = index / 2, b = (a + 1) % 3, c = (a + 2) % 3;
    float past = depth - rise[a];
    if ((index & 1) == 1 && past >= 0.0 && past <= rise[b]) return start + edge[a] + edge[b] * (past / rise[b]);
    if (past <= 0.0) return start + edge[a] * (depth / rise[a]);
    if (past <= rise[c]) return start + edge[a] + edge[c] * (past / rise[c]);
    return start + edge[a] + edge[c] + edge[b] * min((past - rise[c]) / rise[b], 1.0);
}
vec3 proxy_tex_coord() { return proxy_position(); }
vec4 proxy_color() { return material; }
