// A breeze: gusts that travel over the object, a direction for each place and time, the same after each period.
// Source: ours. A sum of plane waves, each of which passes a whole number of times in a period, so that it has no seam.
// x: object space; result: how far a tip is bent, in lengths of its strand.
// @param wind_strength = 0.5 in [0, 2]: How far gusts bend tips, as a part of their length.
// @param wind_heading = 20 in [-180, 180]: Where the wind blows to, degrees about the vertical axis, from x towards -z.
// @param gust_size = 1.4 in [0.1, 8]: Distance between gusts, object units.
// @param wind_period = 4 in [0.25, 60]: Seconds after which the wind repeats.
#define windy(code) code
const float WIND_TURN = 6.2831853;

vec3 wind(vec3 x) {
    vec3 ahead = vec3(cos(radians(wind_heading)), 0.0, -sin(radians(wind_heading)));
    vec3 aside = vec3(-ahead.z, 0.0, ahead.x);
    float along = dot(x, ahead) / gust_size, across = (dot(x, aside) + 0.4 * x.y) / gust_size;
    float turns = fract(time / wind_period);
    vec3 waves = sin(WIND_TURN * vec3(along - turns, 1.7 * along + 0.9 * across - 2.0 * turns + 0.16,
                                      2.9 * along - 1.3 * across - 3.0 * turns + 0.32));
    float gust = 0.6 + dot(waves, vec3(0.2, 0.12, 0.08));
    float sway = dot(waves.yzx, vec3(0.2, 0.12, 0.08));
    return wind_strength * (gust * ahead + sway * aside);
}
