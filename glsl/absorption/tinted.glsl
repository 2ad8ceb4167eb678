// A tint that deepens with the path: thick glass is bluer than thin.
// Source: Beer-Lambert law, for each channel.
// amount: integral of the density along the path, object units; result: what comes through, linear RGB in [0, 1].
// @color glass_color = #3f86e0: Color that white light has after the tint depth.
// @param tint_depth = 1.2 in [0.01, 100]: Path through the densest glass that gives it its color, object units.
vec3 transmitted(float amount) { return exp(log(max(glass_color.rgb, 1e-4)) * (amount / tint_depth)); }
