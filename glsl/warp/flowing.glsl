// Flowing: a point is looked up where its matter came from, followed back through a current that drifts.
// Source: PH abstract (fluid flow), GG 39.5 (drifting vector noise). Ours: each step is three shears, one along each axis
// by a noise of the other two coordinates, so that matter is stretched and folded but its volume stays what it is.
// x: object space; jacobian: derivative of the displaced by the original point, of determinant 1.
// @move 1.1547006 * noise_bound * flow_length
// @drift flow_speed
// @param flow_length = 1 in [0, 4]: How far the current carries matter at most, object units.
// @param flow_frequency = 1.5 in [0.1, 10]: Eddies of the current: noise cells per object unit.
// @param flow_speed = 0.2 in [0, 8]: How fast the current changes, noise cells per second.
#include <noise>
#include <phases>
const int FLOW_STEPS = 4;
const float FASTEST = 1.5;              // length of three noises, each at most 0.866

// One shear: `along` grows by a noise of the other two coordinates; the rows of the jacobian follow.
void shear(inout float along, inout vec3 row, vec2 across, vec3 row_a, vec3 row_b, float place) {
    float far = flow_length / (FASTEST * float(FLOW_STEPS));
    vec3 p = vec3(flow_frequency * across.x, place + flow_speed * time, flow_frequency * across.y);
    vec4 n = far * noise_gradient(p);
    SECOND_PHASE(
        vec3 velocity = vec3(0.0, flow_speed, 0.0);
        n = passing(n, far * noise_gradient(earlier(p, velocity)), velocity, far * NOISE_RANGE);
    )
    along += n.w;
    row += flow_frequency * (n.x * row_a + n.z * row_b);
}

void flowing(inout vec3 x, inout mat3 jacobian) {
    mat3 rows = transpose(jacobian);
    for (int i = 0; i < FLOW_STEPS; ++i) {
        shear(x.x, rows[0], x.yz, rows[1], rows[2], 2.6);
        shear(x.y, rows[1], x.zx, rows[2], rows[0], 9.9);
        shear(x.z, rows[2], x.xy, rows[0], rows[1], 17.2);
    }
    jacobian = transpose(rows);
}
