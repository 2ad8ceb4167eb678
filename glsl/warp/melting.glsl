// Melting: the object is looked up above each point, by an amount that differs from column to column and grows
// towards the ground, so that it sags and drips.
// Source: PH 2.4 (dripping sphere: noise on y alone), MJ 6 and Fig. 7e; the form is a reconstruction. A drip is as long all
// over its middle, so that it ends in a drop and not in a point; a slower noise says how long.
// x: object space; jacobian: derivative of the displaced by the original point.
// @move +y drip_length * melt_time
// @param drip_length = 1.0 in [0, 2]: Longest drip, object units.
// @param drip_frequency = 5.0 in [0.2, 20]: Drips per object unit.
// @param melt_time = 1.0 in [0, 1]: How far the melting has gone.
// @groom length
#include <noise>
#include <groom>
const float DRIP_WHOLE = 0.5;           // noise from which on a drip is as long as it gets

void melting(inout vec3 x, inout mat3 jacobian) {
    float slower = 0.7 * drip_frequency;
    vec4 n = noise_gradient(vec3(drip_frequency * x.x, 5.5, drip_frequency * x.z));
    vec4 m = noise_gradient(vec3(slower * x.x, 15.5, slower * x.z));
    float part = clamp(n.w / DRIP_WHOLE, 0.0, 1.0);
    float raised = part * part * (3.0 - 2.0 * part);
    float drip = raised * (2.0 - raised), steep = 12.0 * (1.0 - raised) * part * (1.0 - part) / DRIP_WHOLE;
    float reach = 0.55 + 0.5 * m.w;                             // the noise reaches 0.866
    float ground = clamp(0.15 - 0.5 * x.y, 0.0, 1.0);           // 0 on what is high, 1 far below the object
    float inside = ground > 0.0 && ground < 1.0 ? 1.0 : 0.0;
    float amplitude = drip_length * melt_time;
    vec2 slope = steep * reach * drip_frequency * n.xz + 0.5 * slower * drip * m.xz;
    groomed(float melted = amplitude * ground * drip * reach; amplitude *= min(groom_length(x), 1.0);)
    mat3 step = mat3(1.0);
    step[0].y = amplitude * ground * slope.x;
    step[1].y = 1.0 - 0.5 * inside * amplitude * drip * reach;
    step[2].y = amplitude * ground * slope.y;
    groomed(vec3 more = melted * groom_slope(x); step[0].y += more.x; step[1].y += more.y; step[2].y += more.z;)
    x.y += amplitude * ground * drip * reach;
    jacobian = step * jacobian;
}
