// Melting: the object is looked up above each point, by an amount that differs from column to column and grows
// towards the ground, so that it sags and drips.
// Source: PH 2.4 (dripping sphere: noise on y alone), MJ 6 and Fig. 7e; the form is a reconstruction.
// x: object space; jacobian: derivative of the displaced by the original point.
// @move +y drip_length * melt_time
// @param drip_length = 0.75 in [0, 2]: Longest drip, object units.
// @param drip_frequency = 4.0 in [0.2, 20]: Drips per object unit.
// @param melt_time = 1.0 in [0, 1]: How far the melting has gone.
#include <noise>
void melting(inout vec3 x, inout mat3 jacobian) {
    vec4 n = noise_gradient(vec3(drip_frequency * x.x, 5.5, drip_frequency * x.z));
    float drip = clamp(0.35 + 1.3 * n.w, 0.0, 1.0);
    float inside = drip > 0.0 && drip < 1.0 ? 1.3 : 0.0;
    float ground = clamp(0.5 - 0.5 * x.y, 0.0, 1.0);             // 0 at the top of the object, 1 at its bottom
    float inside_ground = ground > 0.0 && ground < 1.0 ? 1.0 : 0.0;
    float amplitude = drip_length * melt_time;
    float shaped = drip * drip;
    mat3 step = mat3(1.0);
    step[0].y = amplitude * ground * 2.0 * drip * inside * drip_frequency * n.x;
    step[1].y = 1.0 - 0.5 * inside_ground * amplitude * shaped;
    step[2].y = amplitude * ground * 2.0 * drip * inside * drip_frequency * n.z;
    x.y += amplitude * ground * shaped;
    jacobian = step * jacobian;
}
